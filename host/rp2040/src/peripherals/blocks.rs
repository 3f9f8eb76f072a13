//! The blocks by address, in reset or not, their events and interrupt lines.

use crate::adc::{self, Adc};
use crate::clocks::Clocks;
use crate::dma::{self, Dma, treq};
use crate::gpio::{self, IoBank0};
use crate::i2c::{self, I2c};
use crate::latches::{self, Latches};
use crate::pads::Pads;
use crate::peripheral::{Alias, Cycles, Peripheral, Write};
use crate::pll::Pll;
use crate::psm::{Psm, stage};
use crate::pwm::{self, Pwm};
use crate::resets::{Resets, subsystem};
use crate::rosc::Rosc;
use crate::sio::Sio;
use crate::sysinfo::SysInfo;
use crate::timer::Timer;
use crate::usb::Usb;
use crate::vreg_and_chip_reset::{ChipReset, VregAndChipReset};
use crate::watchdog::{Tick, Watchdog};
use crate::xosc::Xosc;

/// Where the blocks are (RP2040 datasheet 2.2).
mod base {
    pub const SYSINFO: u32 = 0x4000_0000;
    pub const SYSCFG: u32 = 0x4000_4000;
    pub const CLOCKS: u32 = 0x4000_8000;
    pub const RESETS: u32 = 0x4000_c000;
    pub const PSM: u32 = 0x4001_0000;
    pub const IO_BANK0: u32 = 0x4001_4000;
    pub const IO_QSPI: u32 = 0x4001_8000;
    pub const PADS_BANK0: u32 = 0x4001_c000;
    pub const PADS_QSPI: u32 = 0x4002_0000;
    pub const XOSC: u32 = 0x4002_4000;
    pub const PLL_SYS: u32 = 0x4002_8000;
    pub const PLL_USB: u32 = 0x4002_c000;
    pub const BUSCTRL: u32 = 0x4003_0000;
    pub const UART0: u32 = 0x4003_4000;
    pub const UART1: u32 = 0x4003_8000;
    pub const SPI0: u32 = 0x4003_c000;
    pub const SPI1: u32 = 0x4004_0000;
    pub const I2C0: u32 = 0x4004_4000;
    pub const I2C1: u32 = 0x4004_8000;
    pub const ADC: u32 = 0x4004_c000;
    pub const PWM: u32 = 0x4005_0000;
    pub const TIMER: u32 = 0x4005_4000;
    pub const WATCHDOG: u32 = 0x4005_8000;
    pub const RTC: u32 = 0x4005_c000;
    pub const ROSC: u32 = 0x4006_0000;
    pub const VREG_AND_CHIP_RESET: u32 = 0x4006_4000;
    pub const TBMAN: u32 = 0x4006_c000;
    pub const DMA: u32 = 0x5000_0000;
    pub const USB: u32 = 0x5011_0000;
    pub const PIO0: u32 = 0x5020_0000;
    pub const PIO1: u32 = 0x5030_0000;
    pub const XIP_AUX: u32 = 0x5040_0000;
}

/// The aliases of a block and the offset within it are left out of its address.
const BLOCK_MASK: u32 = !0x3fff;
const OFFSET_MASK: u32 = 0xffc;

/// Lines of the NVIC (2.3.2) that the peripherals do not name themselves.
const USBCTRL_IRQ: u32 = 5;
const SIO_IRQ_PROC0: u32 = 15;

/// What answers at an address.
enum Block<'a> {
    /// A block of registers, and the subsystem that holds it in reset.
    Registers(&'a mut dyn Peripheral, u32),
    /// A peripheral of the chip that is not emulated.
    Unmodelled,
    /// Nothing.
    None,
}

/// An access to a peripheral that is not emulated. It read as 0, or was ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unmodelled {
    /// The first address accessed.
    pub address: u32,
    /// When.
    pub at: Cycles,
    /// How many accesses there were in all.
    pub count: u64,
}

/// The blocks on APB and AHB-Lite, and SIO.
#[derive(Clone, Debug)]
pub struct Peripherals {
    pub(crate) sio: Sio,
    pub(crate) io_bank0: IoBank0,
    pub(crate) pads: Pads,
    pub(crate) adc: Adc,
    pub(crate) dma: Dma,
    pub(crate) i2c: [I2c; 2],
    /// The pins that devices of each bus are wired to: data and clock.
    pub(crate) i2c_pins: [Option<[usize; 2]>; 2],
    pub(crate) usb: Usb,
    pub(super) pwm: Pwm,
    pub(crate) timer: Timer,
    pub(crate) watchdog: Watchdog,
    pub(crate) psm: Psm,
    pub(crate) resets: Resets,
    pub(super) clocks: Clocks,
    pub(super) xosc: Xosc,
    pub(super) rosc: Rosc,
    pub(super) pll_sys: Pll,
    pub(super) pll_usb: Pll,
    pub(super) vreg_and_chip_reset: VregAndChipReset,
    pub(super) sysinfo: SysInfo,
    pub(super) syscfg: Latches,
    pub(super) io_qspi: Latches,
    pub(super) pads_qspi: Latches,
    pub(super) busctrl: Latches,
    pub(super) tbman: Latches,
    /// What the pins are held at from outside.
    pub(crate) outside: [Option<bool>; gpio::PINS],
    unmodelled: Option<Unmodelled>,
}

impl Peripherals {
    /// After power-up.
    pub fn new(seed: u64) -> Self {
        Self {
            sio: Sio::new(),
            io_bank0: IoBank0::new(),
            pads: Pads::new(),
            adc: Adc::new(),
            dma: Dma::new(),
            i2c: [I2c::new(), I2c::new()],
            i2c_pins: [None; 2],
            usb: Usb::new(),
            pwm: Pwm::new(),
            timer: Timer::new(Tick::STOPPED, 0),
            watchdog: Watchdog::new(),
            psm: Psm::new(),
            resets: Resets::new(),
            clocks: Clocks::new(),
            xosc: Xosc::new(),
            rosc: Rosc::new(seed),
            pll_sys: Pll::new(),
            pll_usb: Pll::new(),
            vreg_and_chip_reset: VregAndChipReset::new(ChipReset::Power),
            sysinfo: SysInfo,
            syscfg: Latches::new(latches::SYSCFG),
            io_qspi: Latches::new(latches::IO_QSPI),
            pads_qspi: Latches::new(latches::PADS_QSPI),
            busctrl: Latches::new(latches::BUSCTRL),
            tbman: Latches::new(latches::TBMAN),
            outside: [None; gpio::PINS],
            unmodelled: None,
        }
    }

    /// The first access to a peripheral that is not emulated; `None` if there was none.
    pub const fn unmodelled(&self) -> Option<Unmodelled> {
        self.unmodelled
    }

    fn block(&mut self, address: u32) -> Block<'_> {
        let (block, subsystem): (&mut dyn Peripheral, u32) = match address & BLOCK_MASK {
            base::SYSINFO => (&mut self.sysinfo, subsystem::SYSINFO),
            base::SYSCFG => (&mut self.syscfg, subsystem::SYSCFG),
            base::CLOCKS => (&mut self.clocks, 0),
            base::RESETS => (&mut self.resets, 0),
            base::PSM => (&mut self.psm, 0),
            base::IO_BANK0 => (&mut self.io_bank0, subsystem::IO_BANK0),
            base::IO_QSPI => (&mut self.io_qspi, subsystem::IO_QSPI),
            base::PADS_BANK0 => (&mut self.pads, subsystem::PADS_BANK0),
            base::PADS_QSPI => (&mut self.pads_qspi, subsystem::PADS_QSPI),
            base::XOSC => (&mut self.xosc, 0),
            base::PLL_SYS => (&mut self.pll_sys, subsystem::PLL_SYS),
            base::PLL_USB => (&mut self.pll_usb, subsystem::PLL_USB),
            base::BUSCTRL => (&mut self.busctrl, subsystem::BUSCTRL),
            base::I2C0 => (&mut self.i2c[0], subsystem::I2C0),
            base::I2C1 => (&mut self.i2c[1], subsystem::I2C1),
            base::ADC => (&mut self.adc, subsystem::ADC),
            base::DMA => (&mut self.dma, subsystem::DMA),
            base::USB => (&mut self.usb, subsystem::USBCTRL),
            base::PWM => (&mut self.pwm, subsystem::PWM),
            base::TIMER => (&mut self.timer, subsystem::TIMER),
            base::WATCHDOG => (&mut self.watchdog, 0),
            base::ROSC => (&mut self.rosc, 0),
            base::VREG_AND_CHIP_RESET => (&mut self.vreg_and_chip_reset, 0),
            base::TBMAN => (&mut self.tbman, subsystem::TBMAN),
            base::UART0
            | base::UART1
            | base::SPI0
            | base::SPI1
            | base::RTC
            | base::PIO0
            | base::PIO1
            | base::XIP_AUX => return Block::Unmodelled,
            _ => return Block::None,
        };
        Block::Registers(block, subsystem)
    }

    /// Reads a register; `None` if nothing is at the address. What is held in reset reads as 0.
    pub fn read(&mut self, address: u32, now: Cycles) -> Option<u32> {
        let held = self.resets.held();
        match self.block(address) {
            Block::Registers(block, subsystem) if held & subsystem == 0 => {
                Some(block.read(address & OFFSET_MASK, now))
            }
            Block::Registers(..) => Some(0),
            Block::Unmodelled => {
                self.note_unmodelled(address, now);
                Some(0)
            }
            Block::None => None,
        }
    }

    /// Writes a register; `None` if nothing is at the address. What is held in reset ignores it.
    pub fn write(&mut self, address: u32, value: u32, now: Cycles) -> Option<()> {
        let held = self.resets.held();
        let alias = Alias::of(address);
        match self.block(address) {
            Block::Registers(block, subsystem) if held & subsystem == 0 => {
                block.write(address & OFFSET_MASK, Write { value, alias }, now);
            }
            Block::Registers(..) => {}
            Block::Unmodelled => self.note_unmodelled(address, now),
            Block::None => return None,
        }
        match address & BLOCK_MASK {
            base::RESETS => {
                let switched = self.resets.take_switched();
                self.reset_subsystems(switched, now);
            }
            base::PSM if self.psm.take_fallen() & stage::SIO != 0 => self.sio = Sio::new(),
            base::WATCHDOG => self.timer.set_tick(self.watchdog.tick(), now),
            base::IO_BANK0 | base::PADS_BANK0 => self.pins_changed(now),
            _ => {}
        }
        Some(())
    }

    #[cold]
    fn note_unmodelled(&mut self, address: u32, at: Cycles) {
        let first = Unmodelled {
            address,
            at,
            count: 0,
        };
        self.unmodelled.get_or_insert(first).count += 1;
    }

    /// Whether reading a register at this address can change an interrupt line or an event.
    pub const fn reading_changes(address: u32) -> bool {
        matches!(
            address & BLOCK_MASK,
            base::ADC | base::I2C0 | base::I2C1 | base::USB
        )
    }

    /// Until when the core has to wait where it reads this register.
    pub(crate) fn wait_at(&self, address: u32, now: Cycles) -> Option<Cycles> {
        if address & BLOCK_MASK != base::XOSC {
            return None;
        }
        self.xosc.wait_at_status(address & OFFSET_MASK, now)
    }

    /// What peripherals ask of the DMA controller, a bit for each number of [`treq`].
    pub(crate) fn dma_requests(&self) -> u64 {
        [
            (self.i2c[0].transmit_request(), treq::I2C0_TX),
            (self.i2c[0].receive_request(), treq::I2C0_RX),
            (self.i2c[1].transmit_request(), treq::I2C1_TX),
            (self.i2c[1].receive_request(), treq::I2C1_RX),
            (self.adc.dma_request(), treq::ADC),
        ]
        .into_iter()
        .map(|(asks, request)| u64::from(asks) << request)
        .sum()
    }

    /// Hands the wraps of PWM counters that DMA channels wait for to the DMA controller.
    pub(crate) fn pass_on_wraps(&mut self) {
        let awaited = self.dma.awaited() >> treq::PWM_WRAP0;
        self.pwm.await_wraps(awaited as u32);
        let wraps = self.pwm.take_wraps();
        if wraps == 0 {
            return;
        }
        for slice in (0..pwm::SLICES as u32).filter(|slice| wraps >> slice & 1 != 0) {
            self.dma.request_once(treq::PWM_WRAP0 + slice);
        }
    }

    /// The levels of the interrupt lines to the NVIC.
    pub fn interrupt_lines(&self) -> u32 {
        let line = |high: bool, number: u32| u32::from(high) << number;
        let [dma0, dma1] = self.dma.lines();
        self.timer.lines()
            | line(self.pwm.interrupt(), pwm::IRQ)
            | line(self.usb.interrupt(), USBCTRL_IRQ)
            | line(dma0, dma::IRQS[0])
            | line(dma1, dma::IRQS[1])
            | line(self.adc.line(), adc::IRQ)
            | line(self.i2c[0].line(), i2c::IRQS[0])
            | line(self.i2c[1].line(), i2c::IRQS[1])
            | line(self.io_bank0.line(), gpio::IRQ)
            | line(self.sio.line(), SIO_IRQ_PROC0)
    }

    /// When the next of them does something by itself.
    pub fn next_event(&self) -> Option<Cycles> {
        let events = [
            self.timer.next_event(),
            self.pwm.next_event(),
            self.watchdog.next_event(),
            self.adc.next_event(),
            self.dma.next_event(),
            self.i2c[0].next_event(),
            self.i2c[1].next_event(),
            self.usb.next_event(),
        ];
        events.into_iter().flatten().min()
    }

    /// Does what is due by now.
    pub fn advance(&mut self, now: Cycles) {
        self.timer.advance(now);
        self.pwm.advance(now);
        self.watchdog.advance(now);
        self.adc.advance(now);
        self.dma.advance(now);
        self.i2c[0].advance(now);
        self.i2c[1].advance(now);
        self.usb.advance(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIMERAWL: u32 = base::TIMER + 0x28;

    fn running() -> Peripherals {
        let mut peripherals = Peripherals::new(0);
        // A tick each microsecond; everything out of reset.
        peripherals.write(base::WATCHDOG + 0x2c, 0x200 | 12, 0);
        peripherals.write(base::RESETS, 0, 0);
        peripherals
    }

    #[test]
    fn what_is_held_in_reset_does_nothing() {
        let mut peripherals = Peripherals::new(0);
        peripherals.write(base::WATCHDOG + 0x2c, 0x200 | 12, 0);
        assert_eq!(peripherals.read(TIMERAWL, 125_000), Some(0));
        peripherals.write(base::RESETS + 0x3000, subsystem::TIMER, 125_000);
        assert_eq!(peripherals.read(TIMERAWL, 250_000), Some(1_000));
        peripherals.write(base::RESETS + 0x2000, subsystem::TIMER, 250_000);
        peripherals.write(base::RESETS + 0x3000, subsystem::TIMER, 375_000);
        assert_eq!(peripherals.read(TIMERAWL, 375_000), Some(0));
    }

    #[test]
    fn aliases_change_single_bits() {
        let mut peripherals = running();
        let inte = base::TIMER + 0x38;
        peripherals.write(inte + 0x2000, 0b0110, 0);
        peripherals.write(inte + 0x3000, 0b0010, 0);
        peripherals.write(inte + 0x1000, 0b0101, 0);
        assert_eq!(peripherals.read(inte, 0), Some(0b0001));
        assert_eq!(peripherals.read(inte + 0x2000, 0), Some(0b0001));
    }

    #[test]
    fn nothing_answers_where_nothing_is() {
        let mut peripherals = running();
        for address in [0x4006_8000, 0x4007_0000, 0x5050_0000, 0x6000_0000] {
            assert_eq!(peripherals.read(address, 0), None);
            assert_eq!(peripherals.write(address, 0, 0), None);
        }
    }

    #[test]
    fn what_is_not_emulated_is_told() {
        let mut peripherals = running();
        assert_eq!(peripherals.unmodelled(), None);
        peripherals.read(base::UART0 + 0x18, 7);
        peripherals.write(base::SPI1, 1, 8);
        let told = Unmodelled {
            address: base::UART0 + 0x18,
            at: 7,
            count: 2,
        };
        assert_eq!(peripherals.unmodelled(), Some(told));
    }

    #[test]
    fn the_watchdog_resets_what_it_is_set_to() {
        let mut peripherals = running();
        peripherals.write(base::TIMER + 0x38, 1, 0);
        peripherals.write(base::WATCHDOG + 0x0c, 42, 0);
        assert_eq!(peripherals.reset_by_watchdog(0), 0);
        assert_eq!(peripherals.read(base::TIMER + 0x38, 0), Some(1));
        peripherals.write(base::PSM + 8, 0x1_fffc, 0);
        assert_eq!(peripherals.reset_by_watchdog(0), 0x1_fffc);
        assert_eq!(peripherals.read(base::TIMER + 0x38, 0), Some(0));
        assert_eq!(peripherals.read(base::RESETS, 0), Some(0x01ff_fdbf));
        assert_eq!(peripherals.read(base::WATCHDOG + 0x0c, 0), Some(42));
        peripherals.reset_chip(ChipReset::RunPin, 0);
        assert_eq!(peripherals.read(base::WATCHDOG + 0x0c, 0), Some(0));
    }
}
