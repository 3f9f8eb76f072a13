//! IO_BANK0: which peripheral drives a pin, overrides, and the pins' interrupts (RP2040 datasheet
//! 2.19.2 to 2.19.6.1).

use super::peripheral::{Cycles, Peripheral, Write};

/// Pins of bank 0.
pub const PINS: usize = 30;
/// Its interrupt line of core 0, IO_IRQ_BANK0.
pub const IRQ: u32 = 13;

const GPIO0_STATUS: u32 = 0x000;
const LAST_CTRL: u32 = 0x0ec;
const INTR0: u32 = 0x0f0;
const PROC0_INTE0: u32 = 0x100;
const PROC0_INTF0: u32 = 0x110;
const PROC0_INTS0: u32 = 0x120;
const PROC1_INTE0: u32 = 0x130;

/// FUNCSEL.
mod function {
    pub const I2C: u32 = 3;
    pub const PWM: u32 = 4;
    pub const SIO: u32 = 5;
    pub const NULL: u32 = 0x1f;
}

const FUNCSEL: u32 = 0x1f;
const OUTOVER_SHIFT: u32 = 8;
const OEOVER_SHIFT: u32 = 12;
const INOVER_SHIFT: u32 = 16;
const IRQOVER_SHIFT: u32 = 28;
const CTRL_WRITABLE: u32 =
    FUNCSEL | 3 << OUTOVER_SHIFT | 3 << OEOVER_SHIFT | 3 << INOVER_SHIFT | 3 << IRQOVER_SHIFT;

/// Bits of GPIOx_STATUS that are modelled: what goes to and comes from the pad.
const INFROMPAD: u32 = 1 << 17;
const INTOPERI: u32 = 1 << 19;
const IRQTOPROC: u32 = 1 << 26;

/// Bits of a pin's interrupts.
mod event {
    pub const LEVEL_LOW: u32 = 1;
    pub const LEVEL_HIGH: u32 = 1 << 1;
    pub const EDGE_LOW: u32 = 1 << 2;
    pub const EDGE_HIGH: u32 = 1 << 3;
    /// The edges of eight pins, which are remembered until written 1.
    pub const EDGES: u32 = 0xcccc_cccc;
}

/// What a pin's signal comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// I2C, SDA on even and SCL on odd pins.
    I2c,
    /// The PWM slices.
    Pwm,
    /// The processor.
    Sio,
    /// Nothing, or a peripheral that is not emulated.
    Other,
}

/// What a signal is changed to on its way to the pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Override {
    /// It is left as it is.
    None,
    /// Inverted.
    Invert,
    /// Fixed: low, or disabled.
    Low,
    /// Fixed: high, or enabled.
    High,
}

impl Override {
    const fn of(ctrl: u32, shift: u32) -> Self {
        match ctrl >> shift & 3 {
            0 => Self::None,
            1 => Self::Invert,
            2 => Self::Low,
            _ => Self::High,
        }
    }

    /// What it makes of a level.
    pub const fn apply(self, level: bool) -> bool {
        match self {
            Self::None => level,
            Self::Invert => !level,
            Self::Low => false,
            Self::High => true,
        }
    }
}

/// The registers.
#[derive(Clone, Debug)]
pub struct IoBank0 {
    ctrl: [u32; PINS],
    /// The levels at the pads, as of the last change.
    levels: u32,
    edges: [u32; 4],
    enabled: [u32; 4],
    forced: [u32; 4],
    /// Core 1's and dormant wake's masks: storage only.
    unused: [u32; 24],
}

impl IoBank0 {
    /// After a reset: no pin has a function.
    pub const fn new() -> Self {
        Self {
            ctrl: [function::NULL; PINS],
            levels: 0,
            edges: [0; 4],
            enabled: [0; 4],
            forced: [0; 4],
            unused: [0; 24],
        }
    }

    /// Where the pin's signal comes from.
    pub fn function(&self, pin: usize) -> Function {
        match self.ctrl[pin] & FUNCSEL {
            function::I2C => Function::I2c,
            function::PWM => Function::Pwm,
            function::SIO => Function::Sio,
            _ => Function::Other,
        }
    }

    /// What its output is changed to.
    pub fn output_override(&self, pin: usize) -> Override {
        Override::of(self.ctrl[pin], OUTOVER_SHIFT)
    }

    /// What its output enable is changed to.
    pub fn enable_override(&self, pin: usize) -> Override {
        Override::of(self.ctrl[pin], OEOVER_SHIFT)
    }

    /// What peripherals see of the pads at the levels last set.
    pub fn inputs(&self) -> u32 {
        (0..PINS)
            .filter(|&pin| {
                Override::of(self.ctrl[pin], INOVER_SHIFT).apply(self.levels >> pin & 1 != 0)
            })
            .map(|pin| 1 << pin)
            .sum()
    }

    /// The pads are at these levels now.
    pub fn set_levels(&mut self, levels: u32) {
        let changed = levels ^ self.levels;
        self.levels = levels;
        for pin in (0..PINS).filter(|pin| changed >> pin & 1 != 0) {
            let edge = if levels >> pin & 1 != 0 {
                event::EDGE_HIGH
            } else {
                event::EDGE_LOW
            };
            self.edges[pin / 8] |= edge << (4 * (pin % 8));
        }
    }

    /// The raw interrupts of eight pins, four bits a pin.
    fn raw(&self, group: usize) -> u32 {
        let levels: u32 = (0..8)
            .filter(|i| 8 * group + i < PINS)
            .map(|i| {
                let high = self.levels >> (8 * group + i) & 1 != 0;
                let level = if high {
                    event::LEVEL_HIGH
                } else {
                    event::LEVEL_LOW
                };
                level << (4 * i)
            })
            .sum();
        self.edges[group] | levels
    }

    fn status(&self, group: usize) -> u32 {
        self.raw(group) & self.enabled[group] | self.forced[group]
    }

    /// The interrupt line of core 0.
    pub fn line(&self) -> bool {
        (0..4).any(|group| {
            let wanted = self.enabled[group] | self.forced[group];
            wanted != 0 && self.status(group) != 0
        })
    }

    fn pin_status(&self, pin: usize) -> u32 {
        let level = self.levels >> pin & 1 != 0;
        let seen = Override::of(self.ctrl[pin], INOVER_SHIFT).apply(level);
        let event = self.status(pin / 8) >> (4 * (pin % 8)) & 0xf != 0;
        let irq = Override::of(self.ctrl[pin], IRQOVER_SHIFT).apply(event);
        [(level, INFROMPAD), (seen, INTOPERI), (irq, IRQTOPROC)]
            .into_iter()
            .filter(|(set, _)| *set)
            .map(|(_, bit)| bit)
            .sum()
    }
}

/// Which of four registers from `first`.
const fn group(offset: u32, first: u32) -> usize {
    (offset - first) as usize / 4
}

impl Peripheral for IoBank0 {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            GPIO0_STATUS..=LAST_CTRL if offset & 4 == 0 => self.pin_status(offset as usize / 8),
            GPIO0_STATUS..=LAST_CTRL => self.ctrl[offset as usize / 8],
            INTR0..PROC0_INTE0 => self.raw(group(offset, INTR0)),
            PROC0_INTE0..PROC0_INTF0 => self.enabled[group(offset, PROC0_INTE0)],
            PROC0_INTF0..PROC0_INTS0 => self.forced[group(offset, PROC0_INTF0)],
            PROC0_INTS0..PROC1_INTE0 => self.status(group(offset, PROC0_INTS0)),
            _ => {
                let unused = self.unused.get(group(offset, PROC1_INTE0));
                unused.copied().unwrap_or(0)
            }
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        let register = match offset {
            GPIO0_STATUS..=LAST_CTRL if offset & 4 == 0 => return,
            GPIO0_STATUS..=LAST_CTRL => {
                let ctrl = &mut self.ctrl[offset as usize / 8];
                *ctrl = write.onto(*ctrl) & CTRL_WRITABLE;
                return;
            }
            INTR0..PROC0_INTE0 => {
                // Written 1 to clear.
                self.edges[group(offset, INTR0)] &= !(write.value & event::EDGES);
                return;
            }
            PROC0_INTE0..PROC0_INTF0 => &mut self.enabled[group(offset, PROC0_INTE0)],
            PROC0_INTF0..PROC0_INTS0 => &mut self.forced[group(offset, PROC0_INTF0)],
            PROC0_INTS0..PROC1_INTE0 => return,
            _ => match self.unused.get_mut(group(offset, PROC1_INTE0)) {
                Some(unused) => unused,
                None => return,
            },
        };
        *register = write.onto(*register);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ctrl(pin: u32) -> u32 {
        8 * pin + 4
    }

    #[test]
    fn pins_have_functions_and_overrides() {
        let mut bank = IoBank0::new();
        assert_eq!(bank.function(0), Function::Other);
        assert_eq!(bank.read(ctrl(29), 0), 0x1f);
        for (funcsel, function) in [
            (3, Function::I2c),
            (4, Function::Pwm),
            (5, Function::Sio),
            (2, Function::Other),
        ] {
            bank.write(ctrl(1), Write::plain(funcsel | 2 << 8 | 3 << 12), 0);
            assert_eq!(bank.function(1), function);
        }
        assert_eq!(bank.output_override(1), Override::Low);
        assert_eq!(bank.enable_override(1), Override::High);
        assert_eq!(bank.output_override(0), Override::None);
    }

    #[test]
    fn overrides_do_what_they_say() {
        let results = |over: Override| [false, true].map(|level| over.apply(level));
        assert_eq!(results(Override::None), [false, true]);
        assert_eq!(results(Override::Invert), [true, false]);
        assert_eq!(results(Override::Low), [false, false]);
        assert_eq!(results(Override::High), [true, true]);
    }

    #[test]
    fn edges_are_remembered_and_levels_are_not() {
        let mut bank = IoBank0::new();
        let pin_9 = |bits: u32| bits << 4;
        bank.write(PROC0_INTE0 + 4, Write::plain(pin_9(event::EDGE_HIGH)), 0);
        bank.set_levels(1 << 9);
        assert!(bank.line());
        let raw = pin_9(event::EDGE_HIGH | event::LEVEL_HIGH);
        assert_eq!(bank.read(INTR0 + 4, 0) & pin_9(0xf), raw);
        bank.write(INTR0 + 4, Write::plain(pin_9(0xf)), 0);
        assert!(!bank.line());
        assert_eq!(
            bank.read(INTR0 + 4, 0) & pin_9(0xf),
            pin_9(event::LEVEL_HIGH)
        );
        bank.write(PROC0_INTE0 + 4, Write::plain(pin_9(event::LEVEL_LOW)), 0);
        bank.set_levels(0);
        assert!(bank.line());
        assert_eq!(bank.read(PROC0_INTS0 + 4, 0), pin_9(event::LEVEL_LOW));
        bank.set_levels(1 << 9);
        assert!(!bank.line());
        bank.write(PROC0_INTF0, Write::plain(1), 0);
        assert!(bank.line());
    }

    #[test]
    fn a_pins_status_shows_what_comes_in() {
        let mut bank = IoBank0::new();
        bank.set_levels(1 << 3);
        assert_eq!(bank.read(8 * 3, 0), INFROMPAD | INTOPERI);
        bank.write(ctrl(3), Write::plain(5 | 1 << INOVER_SHIFT), 0);
        assert_eq!(bank.read(8 * 3, 0), INFROMPAD);
        assert_eq!(bank.inputs() & 1 << 3, 0);
    }
}
