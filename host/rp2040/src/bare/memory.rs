//! Flash, RAM, and the debugger that semihosting talks to.

use crate::cpu::{Bus, BusFault, Registers};

/// Where the flash begins; code only reads it.
pub const FLASH_START: u32 = 0x1000_0000;
/// 2 MB, as on a Raspberry Pi Pico.
pub const FLASH_SIZE: usize = 2 << 20;
/// Where the RAM begins.
pub const RAM_START: u32 = 0x2000_0000;
/// 264 KB, as in the RP2040.
pub const RAM_SIZE: usize = 264 << 10;

/// The comment of the BKPT that is a semihosting call.
const SEMIHOSTING: u8 = 0xab;

/// Semihosting operations, in R0; the argument is in R1.
mod operation {
    /// Opens a file: only the console, so its name is not looked at.
    pub const OPEN: u32 = 0x01;
    /// Prints the character that R1 points to.
    pub const WRITE_CHARACTER: u32 = 0x03;
    /// Prints the string that R1 points to, up to a zero byte.
    pub const WRITE_STRING: u32 = 0x04;
    /// Prints (handle, pointer, length), which R1 points to; returns how many bytes it did not.
    pub const WRITE: u32 = 0x05;
    /// Ends the program; R1 is the reason.
    pub const EXIT: u32 = 0x18;
    /// Ends the program; R1 points to the reason and a subcode.
    pub const EXIT_EXTENDED: u32 = 0x20;
}
/// The handle of the console.
const CONSOLE: u32 = 1;
/// Result of an operation that failed or does not exist.
const FAILED: u32 = u32::MAX;

/// What the core of the bare machine is connected to.
#[derive(Clone, Debug)]
pub struct Memory {
    flash: Vec<u8>,
    ram: Vec<u8>,
    output: Vec<u8>,
    exit: Option<u32>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            flash: vec![0xff; FLASH_SIZE],
            ram: vec![0; RAM_SIZE],
            output: vec![],
            exit: None,
        }
    }
}

impl Memory {
    /// `size` bytes at `address`, if they lie in flash or RAM.
    #[inline(always)]
    pub fn slice(&self, address: u32, size: usize) -> Option<&[u8]> {
        let (memory, start) = if address >= RAM_START {
            (&self.ram, RAM_START)
        } else {
            (&self.flash, FLASH_START)
        };
        let offset = address.wrapping_sub(start) as usize;
        memory.get(offset..offset.checked_add(size)?)
    }

    /// As [`slice`](Self::slice), to be written.
    pub fn slice_mut(&mut self, address: u32, size: usize) -> Option<&mut [u8]> {
        let (memory, start) = if address >= RAM_START {
            (&mut self.ram, RAM_START)
        } else {
            (&mut self.flash, FLASH_START)
        };
        let offset = address.wrapping_sub(start) as usize;
        memory.get_mut(offset..offset.checked_add(size)?)
    }

    pub(super) fn take_exit(&mut self) -> Option<u32> {
        self.exit.take()
    }

    pub(super) fn output(&self) -> &[u8] {
        &self.output
    }

    /// Does what a semihosting call asks; returns R0's new value.
    fn semihost(&mut self, operation: u32, argument: u32) -> Option<u32> {
        match operation {
            operation::OPEN => Some(CONSOLE),
            operation::WRITE_CHARACTER => {
                let [character] = self.read(argument).ok()?;
                self.output.push(character);
                Some(operation)
            }
            operation::WRITE_STRING => {
                let mut address = argument;
                loop {
                    let [character] = self.read(address).ok()?;
                    if character == 0 {
                        return Some(operation);
                    }
                    self.output.push(character);
                    address = address.wrapping_add(1);
                }
            }
            operation::WRITE => {
                let pointer = self
                    .read(argument.wrapping_add(4))
                    .map(u32::from_le_bytes)
                    .ok()?;
                let length = self
                    .read(argument.wrapping_add(8))
                    .map(u32::from_le_bytes)
                    .ok()?;
                let bytes = self.slice(pointer, length as usize)?.to_vec();
                self.output.extend(bytes);
                Some(0)
            }
            operation::EXIT => {
                self.exit = Some(argument);
                Some(operation)
            }
            operation::EXIT_EXTENDED => {
                self.exit = Some(self.read(argument).map(u32::from_le_bytes).ok()?);
                Some(operation)
            }
            _ => None,
        }
    }
}

impl Bus for Memory {
    #[inline(always)]
    fn read<const N: usize>(&mut self, address: u32) -> Result<[u8; N], BusFault> {
        let bytes = self.slice(address, N).and_then(|bytes| bytes.first_chunk());
        bytes.copied().ok_or(BusFault)
    }

    #[inline(always)]
    fn write<const N: usize>(&mut self, address: u32, value: [u8; N]) -> Result<(), BusFault> {
        let offset = address.wrapping_sub(RAM_START) as usize;
        let end = offset.checked_add(N).ok_or(BusFault)?;
        self.ram
            .get_mut(offset..end)
            .ok_or(BusFault)?
            .copy_from_slice(&value);
        Ok(())
    }

    fn breakpoint(&mut self, comment: u8, registers: &mut Registers) -> bool {
        if comment == SEMIHOSTING {
            let result = self.semihost(registers.get(0), registers.get(1));
            registers.set(0, result.unwrap_or(FAILED));
        }
        comment == SEMIHOSTING
    }
}
