//! The clock generators (RP2040 datasheet 2.15).
//!
//! They hold what is set, and switch at once. What they are set to changes nothing: the emulated
//! system clock is at 125 MHz from the start. The frequency counter shows the frequencies that the
//! SDKs set up with a crystal of 12 MHz.

use super::peripheral::{Cycles, Peripheral, Write};

const CLK_GPOUT0_SELECTED: u32 = 0x08;
const CLK_GPOUT1_SELECTED: u32 = 0x14;
const CLK_GPOUT2_SELECTED: u32 = 0x20;
const CLK_GPOUT3_SELECTED: u32 = 0x2c;
const CLK_REF_CTRL: u32 = 0x30;
const CLK_REF_SELECTED: u32 = 0x38;
const CLK_SYS_CTRL: u32 = 0x3c;
const CLK_SYS_SELECTED: u32 = 0x44;
const CLK_PERI_SELECTED: u32 = 0x50;
const CLK_USB_SELECTED: u32 = 0x5c;
const CLK_ADC_SELECTED: u32 = 0x68;
const CLK_RTC_SELECTED: u32 = 0x74;
const CLK_SYS_RESUS_CTRL: u32 = 0x78;
const CLK_SYS_RESUS_STATUS: u32 = 0x7c;
const FC0_SRC: u32 = 0x94;
const FC0_STATUS: u32 = 0x98;
const FC0_RESULT: u32 = 0x9c;
const WAKE_EN0: u32 = 0xa0;
const SLEEP_EN1: u32 = 0xac;
const ENABLED0: u32 = 0xb0;
const ENABLED1: u32 = 0xb4;
const INTR: u32 = 0xb8;
const INTS: u32 = 0xc4;
/// Behind the last register.
const END: u32 = 0xc8;

/// FC0_STATUS: DONE and PASS.
const DONE_AND_PASS: u32 = 1 << 4 | 1;
/// FC0_RESULT: kHz stand above 5 bits of fraction.
const KHZ_SHIFT: u32 = 5;
/// Divisors after a reset: 1, with 8 bits of fraction.
const DIVISOR_ONE: u32 = 1 << 8;

/// Frequencies that the frequency counter measures, in kHz, by FC0_SRC.
const FREQUENCIES_KHZ: [u32; 14] = [
    0,       // nothing
    125_000, // PLL_SYS
    48_000,  // PLL_USB
    6_500,   // ROSC
    6_500,   // ROSC, phase shifted
    12_000,  // XOSC
    0, 0,       // GPIN0, GPIN1
    12_000,  // clk_ref
    125_000, // clk_sys
    125_000, // clk_peri
    48_000,  // clk_usb
    48_000,  // clk_adc
    46,      // clk_rtc
];

/// The registers.
#[derive(Clone, Debug)]
pub struct Clocks {
    registers: [u32; END as usize / 4],
}

impl Clocks {
    /// After a reset.
    pub fn new() -> Self {
        let mut registers = [0; END as usize / 4];
        for divisor in [0x04, 0x10, 0x1c, 0x28, 0x34, 0x40, 0x58, 0x64, 0x70] {
            registers[divisor / 4] = DIVISOR_ONE;
        }
        registers[CLK_SYS_RESUS_CTRL as usize / 4] = 0xff;
        for enable in (WAKE_EN0..=SLEEP_EN1).step_by(4) {
            registers[enable as usize / 4] = !0;
        }
        Self { registers }
    }

    fn register(&self, offset: u32) -> u32 {
        self.registers
            .get(offset as usize / 4)
            .copied()
            .unwrap_or(0)
    }
}

impl Peripheral for Clocks {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            // Only these two switch without glitches and say which source is in use.
            CLK_REF_SELECTED => 1 << (self.register(CLK_REF_CTRL) & 3),
            CLK_SYS_SELECTED => 1 << (self.register(CLK_SYS_CTRL) & 1),
            CLK_GPOUT0_SELECTED | CLK_GPOUT1_SELECTED | CLK_GPOUT2_SELECTED
            | CLK_GPOUT3_SELECTED | CLK_PERI_SELECTED | CLK_USB_SELECTED | CLK_ADC_SELECTED
            | CLK_RTC_SELECTED => 1,
            FC0_STATUS => DONE_AND_PASS,
            FC0_RESULT => {
                let source = self.register(FC0_SRC) as usize;
                FREQUENCIES_KHZ
                    .get(source)
                    .map_or(0, |khz| khz << KHZ_SHIFT)
            }
            ENABLED0 => !0,
            ENABLED1 => 0x7fff,
            // The system clock never stops, so nothing resuscitates it.
            CLK_SYS_RESUS_STATUS | INTR..=INTS => 0,
            _ => self.register(offset),
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        if let Some(register) = self.registers.get_mut(offset as usize / 4) {
            *register = write.onto(*register);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glitchless_clocks_say_which_source_they_have() {
        let mut clocks = Clocks::new();
        assert_eq!(clocks.read(CLK_REF_SELECTED, 0), 1);
        clocks.write(CLK_REF_CTRL, Write::plain(2), 0);
        assert_eq!(clocks.read(CLK_REF_SELECTED, 0), 4);
        clocks.write(CLK_SYS_CTRL, Write::plain(1), 0);
        assert_eq!(clocks.read(CLK_SYS_SELECTED, 0), 2);
    }

    #[test]
    fn the_frequency_counter_measures_the_usual_frequencies() {
        let mut clocks = Clocks::new();
        for (source, khz) in [(1, 125_000), (2, 48_000), (5, 12_000), (99, 0)] {
            clocks.write(FC0_SRC, Write::plain(source), 0);
            assert_eq!(clocks.read(FC0_STATUS, 0), 0x11);
            assert_eq!(clocks.read(FC0_RESULT, 0) >> 5, khz);
        }
    }

    #[test]
    fn other_registers_hold_what_is_written() {
        let mut clocks = Clocks::new();
        assert_eq!(clocks.read(0x40, 0), 0x100);
        clocks.write(0x40, Write::plain(0x200), 0);
        assert_eq!(clocks.read(0x40, 0), 0x200);
        clocks.write(0xffc, Write::plain(1), 0);
        assert_eq!(clocks.read(0xffc, 0), 0);
    }
}
