//! The bus fabric and memory map (RP2040 datasheet 2.1 and 2.2).
//!
//! RAM, flash and ROM come first, for that is where programs spend their time. Bytes and halfwords
//! read from registers are parts of the word; written, they are repeated over its width (2.1.4).
//! Registers are behind four aliases that write, toggle, set and clear (2.1.2), but for SIO, and
//! those of the flash's interface.
//!
//! A load or store takes two cycles, on SIO one. Wait states (the bridge to the APB, misses of the
//! flash cache, two masters at one bank) are not modelled.

use super::boot_rom::Service;
use super::cpu::{self, BusFault, Registers};
use super::flash::Flash;
use super::memory::{self, Memory};
use super::peripheral::{Cycles, Peripheral as _, Write};
use super::peripherals::Peripherals;
use super::sio::Sio;
use super::ssi::Ssi;
use super::xip::XipControl;

/// Where the flash is seen, by way of the cache.
pub const FLASH: u32 = 0x1000_0000;
/// The flash is seen in four windows of 16 MB, with and without cache and allocation in it.
const FLASH_WINDOW_MASK: u32 = 0x00ff_ffff;
const XIP_CONTROL: u32 = 0x1400_0000;
const SSI: u32 = 0x1800_0000;
const SIO: u32 = 0xd000_0000;
/// Memory of the USB controller, which takes bytes as they are.
const USB_MEMORY: u32 = 0x5010_0000;
const USB_MEMORY_MASK: u32 = 0xffff_0000;
/// Blocks of registers are this large at least.
const PAGE_MASK: u32 = !0xfff;
const OFFSET_MASK: u32 = 0xffc;

/// All that the core is connected to.
#[derive(Clone, Debug)]
pub struct SystemBus {
    pub(super) now: Cycles,
    /// Until when the core may go on without the machine looking after anything. A write to a
    /// register sets it to 0.
    pub(super) horizon: Cycles,
    /// Until when the core stands still, for the boot ROM is at work in its place.
    pub(super) stalled_until: Cycles,
    /// Until when the DMA controller is busy with transfers that were made.
    pub(super) dma_busy_until: Cycles,
    pub(super) memory: Memory,
    pub(super) flash: Flash,
    pub(super) ssi: Ssi,
    pub(super) peripherals: Peripherals,
    /// What the boot ROM came to, at the last reset.
    pub(super) boot: Boot,
    xip: XipControl,
}

/// What the boot ROM came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boot {
    /// It has not run yet.
    Pending,
    /// It has started the second stage.
    Started,
    /// There is no valid second stage in the flash: the real one would show itself as a USB drive.
    NoProgram,
    /// The program asked for the boot ROM's USB drive.
    UsbDrive,
}

impl SystemBus {
    /// After power-up, with an erased flash.
    pub fn new(seed: u64) -> Self {
        Self {
            now: 0,
            horizon: 0,
            stalled_until: 0,
            dma_busy_until: 0,
            memory: Memory::new(seed),
            flash: Flash::new(),
            ssi: Ssi::new(seed),
            peripherals: Peripherals::new(seed),
            boot: Boot::Pending,
            xip: XipControl::new(),
        }
    }

    /// The machine is to look before the next instruction.
    pub(super) fn look(&mut self) {
        self.horizon = 0;
    }

    /// The interface to the flash after a reset.
    pub(super) fn reset_flash_interface(&mut self) {
        self.xip = XipControl::new();
        self.ssi.reset();
        self.flash.set_mapped(false);
    }

    /// Bytes that are not at the addresses of RAM and flash used most.
    #[inline(never)]
    fn read_elsewhere<const N: usize>(&mut self, address: u32) -> Result<[u8; N], BusFault> {
        let window = address >> 24;
        match window {
            0x00 => self.memory.read_rom(address).ok_or(BusFault),
            0x10..=0x13 => {
                // Above its size the flash is seen again.
                let offset = address & FLASH_WINDOW_MASK & (super::flash::SIZE as u32 - 1);
                self.flash.mapped_bytes(offset).ok_or(BusFault)
            }
            0x21 => {
                let address = memory::striped(address).ok_or(BusFault)?;
                self.memory.read_ram(address).ok_or(BusFault)
            }
            0x50 if address & USB_MEMORY_MASK == USB_MEMORY => {
                self.look();
                Ok(self.peripherals.usb.read_memory(address, self.now))
            }
            _ => {
                let word = self.read_register(address & !3)?;
                let lane = (address & 3) as usize;
                let bytes = word.to_le_bytes();
                bytes[lane..].first_chunk().copied().ok_or(BusFault)
            }
        }
    }

    #[inline(never)]
    fn write_elsewhere<const N: usize>(
        &mut self,
        address: u32,
        bytes: [u8; N],
    ) -> Result<(), BusFault> {
        match address >> 24 {
            // Writes to ROM and flash go nowhere, as errors.
            0x00 | 0x10..=0x13 => Err(BusFault),
            0x21 => {
                let address = memory::striped(address).ok_or(BusFault)?;
                self.memory.write_ram(address, bytes).ok_or(BusFault)
            }
            0x50 if address & USB_MEMORY_MASK == USB_MEMORY => {
                self.look();
                self.peripherals.usb.write_memory(address, bytes, self.now);
                Ok(())
            }
            _ => {
                let mut word = [0; 4];
                for (lane, byte) in word.iter_mut().zip(bytes.iter().cycle()) {
                    *lane = *byte;
                }
                self.write_register(address & !3, u32::from_le_bytes(word))
            }
        }
    }

    fn read_register(&mut self, address: u32) -> Result<u32, BusFault> {
        let offset = address & OFFSET_MASK;
        match address & PAGE_MASK {
            SIO if Sio::reads_pins(offset) => Ok(self.peripherals.io_bank0.inputs()),
            SIO => Ok(self.peripherals.sio.read(offset, self.now)),
            XIP_CONTROL => Ok(self.xip.read(offset, self.now)),
            SSI => Ok(self.ssi.read(offset, self.now)),
            _ => {
                let value = self.peripherals.read(address, self.now).ok_or(BusFault)?;
                if let Some(until) = self.peripherals.wait_at(address, self.now) {
                    self.stalled_until = until;
                    self.look();
                }
                // Reading may change what the peripheral asks for.
                if Peripherals::reading_changes(address) {
                    self.look();
                }
                Ok(value)
            }
        }
    }

    fn write_register(&mut self, address: u32, value: u32) -> Result<(), BusFault> {
        let offset = address & OFFSET_MASK;
        match address & PAGE_MASK {
            SIO => {
                self.peripherals.sio.write(offset, value, self.now);
                if Sio::is_seen_outside(offset) {
                    self.peripherals.pins_changed(self.now);
                    self.look();
                }
            }
            XIP_CONTROL => self.xip.write(offset, Write::plain(value), self.now),
            SSI => {
                self.ssi.write(offset, Write::plain(value), self.now);
                self.flash.set_mapped(self.ssi.serves_reads());
            }
            _ => {
                let written = self.peripherals.write(address, value, self.now);
                self.look();
                return written.ok_or(BusFault);
            }
        }
        Ok(())
    }
}

impl cpu::Bus for SystemBus {
    #[inline(always)]
    fn read<const N: usize>(&mut self, address: u32) -> Result<[u8; N], BusFault> {
        if let Some(bytes) = self.memory.read_ram(address) {
            return Ok(bytes);
        }
        match self.flash.mapped_bytes(address.wrapping_sub(FLASH)) {
            Some(bytes) => Ok(bytes),
            None => self.read_elsewhere(address),
        }
    }

    #[inline(always)]
    fn write<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> Result<(), BusFault> {
        match self.memory.write_ram(address, bytes) {
            Some(()) => Ok(()),
            None => self.write_elsewhere(address, bytes),
        }
    }

    #[inline(always)]
    fn fetch(&mut self, address: u32) -> Result<u16, BusFault> {
        match self.flash.mapped_bytes(address.wrapping_sub(FLASH)) {
            Some(bytes) => Ok(u16::from_le_bytes(bytes)),
            None => self.read(address).map(u16::from_le_bytes),
        }
    }

    #[inline(always)]
    fn access_cycles(&self, address: u32) -> u32 {
        if address >> 28 == SIO >> 28 { 1 } else { 2 }
    }

    /// Breakpoints of the boot ROM are its functions.
    fn breakpoint(&mut self, comment: u8, registers: &mut Registers) -> bool {
        let address = registers.get(cpu::PC).wrapping_sub(2);
        let Some(service) = Service::at(address, comment) else {
            return false;
        };
        self.look();
        self.serve(service, registers).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cpu::Bus as _;

    fn bus() -> SystemBus {
        SystemBus::new(0)
    }

    #[test]
    fn memory_is_where_the_data_sheet_says() {
        let mut bus = bus();
        bus.write32(0x2000_0000, 0x0302_0100).expect("RAM");
        assert_eq!(bus.read16(0x2000_0002), Ok(0x0302));
        assert_eq!(bus.read8(0x2100_0001), Ok(0x01));
        bus.write8(0x2101_0000, 9).expect("bank 1");
        assert_eq!(bus.read8(0x2000_0004), Ok(9));
        assert_eq!(bus.read32(0x2004_2000), Err(BusFault));
        assert_eq!(bus.read32(0x1fff_fffc), Err(BusFault));
        assert_eq!(bus.read16(0x10), Ok(u16::from_le_bytes(*b"Mu")));
        assert_eq!(bus.write8(0x10, 0), Err(BusFault));
        assert_eq!(bus.read32(0x3000_0000), Err(BusFault));
        assert_eq!(bus.read32(0xe000_0000), Err(BusFault));
    }

    #[test]
    fn the_flash_is_seen_in_four_windows_when_it_is_set_up() {
        let mut bus = bus();
        bus.flash.bytes_mut()[..4].copy_from_slice(&[1, 2, 3, 4]);
        assert_eq!(bus.read32(FLASH), Err(BusFault));
        assert_eq!(bus.fetch(FLASH), Err(BusFault));
        bus.flash.set_mapped(true);
        for window in [0x1000_0000, 0x1100_0000, 0x1200_0000, 0x1320_0000] {
            assert_eq!(bus.read32(window), Ok(0x0403_0201));
            assert_eq!(bus.write32(window, 0), Err(BusFault));
        }
        assert_eq!(bus.fetch(FLASH + 2), Ok(0x0403));
    }

    #[test]
    fn narrow_writes_to_registers_are_repeated() {
        let mut bus = bus();
        let scratch = 0x4005_800c;
        bus.write8(scratch + 2, 0xa5).expect("a register");
        assert_eq!(bus.read32(scratch), Ok(0xa5a5_a5a5));
        bus.write16(scratch, 0x1234).expect("a register");
        assert_eq!(bus.read32(scratch), Ok(0x1234_1234));
        bus.write8(scratch + 0x3000, 0x04)
            .expect("the alias that clears");
        assert_eq!(bus.read32(scratch), Ok(0x1230_1230));
        assert_eq!(bus.read8(scratch + 1), Ok(0x12));
    }

    #[test]
    fn registers_call_the_machine_when_written() {
        let mut bus = bus();
        bus.horizon = 1_000;
        bus.read32(0x4005_8008).expect("a register");
        bus.write32(0x2000_0000, 0).expect("RAM");
        bus.read32(0xd000_017c).expect("a spinlock");
        bus.write32(0xd000_017c, 0).expect("a spinlock");
        assert_eq!(bus.horizon, 1_000);
        bus.write32(0xd000_0014, 1).expect("pins");
        assert_eq!(bus.horizon, 0);
        bus.horizon = 1_000;
        bus.write32(0x4005_800c, 0).expect("a register");
        assert_eq!(bus.horizon, 0);
    }

    #[test]
    fn accesses_take_their_cycles() {
        let bus = bus();
        assert_eq!(bus.access_cycles(0xd000_0000), 1);
        assert_eq!(bus.access_cycles(0x2000_0000), 2);
    }
}
