//! The smallest machine: the core, flash and RAM where the RP2040 has them, and semihosting.
//!
//! No access has wait states, so what runs here takes the cycles that it takes from SRAM.

mod memory;

pub use memory::{FLASH_SIZE, FLASH_START, Memory, RAM_SIZE, RAM_START};

use crate::cpu::{Activity, Core, FaultReport};
use crate::elf::Image;

/// A program that does not fit into the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{size} bytes at {address:#010x} lie outside flash and RAM")]
pub struct OutsideMemory {
    /// Where it should go.
    pub address: u32,
    /// How long it is.
    pub size: usize,
}

/// How a program ended by itself (SYS_EXIT).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exit {
    /// The reason it gave.
    pub reason: u32,
}

impl Exit {
    /// ADP_Stopped_ApplicationExit: all went well.
    pub const SUCCESS: Self = Self { reason: 0x20026 };
}

/// How a program was ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RunError {
    /// It went on and on.
    #[error("the program did not end within {limit} cycles; it was at {pc:#010x}")]
    CycleLimit {
        /// The cycles it was given.
        limit: u64,
        /// Where it was.
        pc: u32,
    },
    /// It sleeps, and nothing on this machine would wake it.
    #[error("the program sleeps at {pc:#010x}, and nothing will wake it")]
    Asleep {
        /// Where it would go on.
        pc: u32,
    },
    /// A fault within the HardFault handler, or without any.
    #[error("the core locked up: {fault}")]
    Lockup {
        /// The last fault.
        fault: FaultReport,
    },
    /// It asked for a reset, which would only begin it again.
    #[error("the program asked for a reset")]
    Reset,
}

/// The machine.
#[derive(Clone, Debug, Default)]
pub struct Bare {
    /// The processor.
    pub core: Core,
    memory: Memory,
    cycles: u64,
}

impl Bare {
    /// Erased flash, zeroed RAM, a core that was not reset.
    pub fn new() -> Self {
        Self::default()
    }

    /// Puts a program into memory.
    ///
    /// # Errors
    /// A segment outside flash and RAM; those before it are loaded.
    pub fn load(&mut self, image: &Image) -> Result<(), OutsideMemory> {
        image
            .segments
            .iter()
            .try_for_each(|segment| self.write(segment.address, &segment.bytes))
    }

    /// Writes to flash or RAM as a programmer does.
    ///
    /// # Errors
    /// Bytes that do not lie in one of them.
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), OutsideMemory> {
        let outside = OutsideMemory {
            address,
            size: bytes.len(),
        };
        let target = self.memory.slice_mut(address, bytes.len()).ok_or(outside)?;
        target.copy_from_slice(bytes);
        Ok(())
    }

    /// What is in memory at `address`; `None` outside flash and RAM.
    pub fn read(&self, address: u32, size: usize) -> Option<&[u8]> {
        self.memory.slice(address, size)
    }

    /// Resets the core, with the vector table at this address.
    pub fn reset(&mut self, vector_table: u32) {
        self.core.reset(&mut self.memory, vector_table);
    }

    /// Executes one instruction, or takes one exception; returns its cycles.
    #[inline]
    pub fn step(&mut self) -> u32 {
        let cycles = self.core.step(&mut self.memory);
        self.cycles += u64::from(cycles);
        cycles
    }

    /// Runs the program to its end, for at most `limit` cycles from now.
    ///
    /// # Errors
    /// [`RunError`]: it did not come to its end.
    pub fn run(&mut self, limit: u64) -> Result<Exit, RunError> {
        let end = self.cycles.saturating_add(limit);
        while self.cycles < end {
            self.step();
            if let Some(reason) = self.memory.take_exit() {
                return Ok(Exit { reason });
            }
            if self.core.activity() != Activity::Running {
                self.pass_the_time(end)?;
            }
            if self.core.take_reset_request() {
                return Err(RunError::Reset);
            }
        }
        Err(RunError::CycleLimit {
            limit,
            pc: self.core.pc(),
        })
    }

    /// Only SysTick can wake the core.
    fn pass_the_time(&mut self, end: u64) -> Result<(), RunError> {
        if self.core.activity() == Activity::Lockup
            && let Some(fault) = self.core.fault()
        {
            return Err(RunError::Lockup { fault });
        }
        if !self.core.sleeping() {
            return Ok(());
        }
        let asleep = RunError::Asleep { pc: self.core.pc() };
        let wake = self.core.cycles_to_systick().ok_or(asleep)?;
        let nap = wake.min(end - self.cycles);
        self.core.idle(nap);
        self.cycles += nap;
        Ok(())
    }

    /// Cycles since the machine was made, sleep included.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// All that the program has printed by semihosting.
    pub fn output(&self) -> &[u8] {
        self.memory.output()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::FaultCause;
    use crate::elf::Segment;

    /// A machine about to execute this at the start of the RAM.
    fn machine(code: &[u16]) -> Bare {
        let mut machine = Bare::new();
        let table: Vec<u8> = [RAM_START + 0x8000, RAM_START + 0x101]
            .iter()
            .flat_map(|w| w.to_le_bytes())
            .collect();
        machine.write(RAM_START, &table).expect("in RAM");
        let code: Vec<u8> = code.iter().flat_map(|op| op.to_le_bytes()).collect();
        machine.write(RAM_START + 0x100, &code).expect("in RAM");
        machine.reset(RAM_START);
        machine
    }

    /// A machine that makes one semihosting call with R1 at 0x20000400, and what it left in R0.
    fn semihosting(operation: u16, argument: &[u8]) -> (Bare, u32) {
        // MOVS R0, #operation; MOVS R1, #4; LSLS R1, #8; MOVS R2, #1; LSLS R2, #29; ADDS R1, R2;
        // BKPT #0xAB; B .
        let operation = 0x2000 | operation;
        let code = [
            operation, 0x2104, 0x0209, 0x2201, 0x0752, 0x1889, 0xbeab, 0xe7fe,
        ];
        let mut machine = machine(&code);
        machine.write(RAM_START + 0x400, argument).expect("in RAM");
        for _ in 0..7 {
            machine.step();
        }
        let result = machine.core.registers().get(0);
        (machine, result)
    }

    #[test]
    fn programs_print_by_semihosting() {
        assert_eq!(semihosting(0x03, b"x").0.output(), b"x");
        assert_eq!(semihosting(0x04, b"hello\0there").0.output(), b"hello");
        let block = [
            [1, 0, 0, 0],
            (RAM_START + 0x410).to_le_bytes(),
            [3, 0, 0, 0],
            *b"----",
        ];
        let mut argument = block.concat();
        argument.extend(b"abcdef");
        let (machine, unwritten) = semihosting(0x05, &argument);
        assert_eq!((machine.output(), unwritten), (&b"abc"[..], 0));
    }

    #[test]
    fn other_semihosting_calls_fail_and_the_program_goes_on() {
        let (mut machine, result) = semihosting(0x06, b"");
        assert_eq!(result, u32::MAX);
        let pc = machine.core.pc();
        assert_eq!(
            machine.run(100),
            Err(RunError::CycleLimit { limit: 100, pc })
        );
    }

    #[test]
    fn semihosting_does_not_read_beyond_memory() {
        let mut machine = machine(&[0xbeab, 0xe7fe]);
        for (operation, address) in [
            (3, 0),
            (4, u32::MAX),
            (5, u32::MAX - 5),
            (0x20, 0x3000_0000),
        ] {
            machine.reset(RAM_START);
            machine.core.registers_mut().set(0, operation);
            machine.core.registers_mut().set(1, address);
            machine.step();
            assert_eq!(machine.core.registers().get(0), u32::MAX, "{operation:x}");
        }
        assert_eq!(machine.output(), b"");
    }

    #[test]
    fn a_program_ends_with_its_reason() {
        // MOVS R0, #0x18; MOVS R1, #7; BKPT #0xAB
        assert_eq!(
            machine(&[0x2018, 0x2107, 0xbeab]).run(100),
            Ok(Exit { reason: 7 })
        );
    }

    #[test]
    fn programs_that_do_not_end_are_ended() {
        let pc = RAM_START + 0x102;
        // WFI, with nothing to wake for
        assert_eq!(machine(&[0xbf30]).run(100), Err(RunError::Asleep { pc }));
        // UDF, and no HardFault handler
        let error = machine(&[0xde00]).run(100).expect_err("a lockup");
        let RunError::Lockup { fault } = error else {
            panic!("{error}")
        };
        assert_eq!(fault.cause, FaultCause::NotThumb, "the vector is zero");
        assert!(
            error.to_string().contains("without the Thumb bit"),
            "{error}"
        );
    }

    fn image(address: u32, size: usize) -> Image {
        let mut image = Image::default();
        image.segments.push(Segment {
            address,
            bytes: vec![7; size],
        });
        image
    }

    #[test]
    fn programs_have_to_fit() {
        for (address, size) in [
            (0, 4),
            (FLASH_START - 1, 2),
            (RAM_START + RAM_SIZE as u32 - 3, 4),
        ] {
            assert_eq!(
                Bare::new().load(&image(address, size)),
                Err(OutsideMemory { address, size })
            );
        }
        assert_eq!(Bare::new().load(&image(FLASH_START, FLASH_SIZE)), Ok(()));
    }
}
