//! ROM and RAM (RP2040 datasheet 2.6).
//!
//! 264 KB of RAM in six banks: words of the first four alternate at 0x20000000, and the same lie one
//! bank after the other at 0x21000000; two of 4 KB follow at 0x20040000.

use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg32;

use super::boot_rom;

/// Where the RAM begins, banks striped.
pub const RAM: u32 = 0x2000_0000;
/// Bytes of the RAM.
pub const RAM_SIZE: usize = 264 << 10;
/// Where the four large banks begin one after the other.
const BANKS: u32 = 0x2100_0000;
/// Bytes of all four.
const BANKS_SIZE: u32 = 256 << 10;
/// Bytes of one of them.
const BANK_SIZE_SHIFT: u32 = 16;

/// ROM and RAM.
#[derive(Clone, Debug)]
pub struct Memory {
    /// The boot ROM, at 0.
    pub rom: Box<[u8; boot_rom::SIZE]>,
    ram: Box<[u8; RAM_SIZE]>,
}

impl Memory {
    /// With a RAM full of what a seed decides, as after power-up.
    pub fn new(seed: u64) -> Self {
        let ram: Result<Box<[u8; RAM_SIZE]>, _> = vec![0; RAM_SIZE].into_boxed_slice().try_into();
        let mut memory = Self {
            rom: boot_rom::contents(),
            ram: ram.expect("it has the length of the array"),
        };
        memory.scramble(seed);
        memory
    }

    /// Fills the RAM with what a seed decides: without power it forgets.
    pub fn scramble(&mut self, seed: u64) {
        Pcg32::seed_from_u64(seed).fill_bytes(self.ram.as_mut_slice());
    }

    /// The RAM, banks striped.
    pub fn ram(&self) -> &[u8] {
        self.ram.as_slice()
    }

    /// The RAM, for a debugger to change.
    pub fn ram_mut(&mut self) -> &mut [u8] {
        self.ram.as_mut_slice()
    }

    /// Reads the RAM at its striped addresses.
    #[inline(always)]
    pub fn read_ram<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let start = address.wrapping_sub(RAM) as usize;
        self.ram.get(start..start + N)?.first_chunk().copied()
    }

    /// Writes the RAM at its striped addresses.
    #[inline(always)]
    pub fn write_ram<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> Option<()> {
        let start = address.wrapping_sub(RAM) as usize;
        self.ram.get_mut(start..start + N)?.copy_from_slice(&bytes);
        Some(())
    }

    /// Reads the ROM.
    pub fn read_rom<const N: usize>(&self, address: u32) -> Option<[u8; N]> {
        let start = address as usize;
        self.rom.get(start..start + N)?.first_chunk().copied()
    }
}

/// The striped address of an address at which the banks lie one after the other.
pub const fn striped(address: u32) -> Option<u32> {
    let offset = address.wrapping_sub(BANKS);
    if offset >= BANKS_SIZE {
        return None;
    }
    let bank = offset >> BANK_SIZE_SHIFT;
    let within = offset & ((1 << BANK_SIZE_SHIFT) - 1);
    Some(RAM + ((within >> 2) << 4 | bank << 2 | within & 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn banks_are_striped_by_words() {
        assert_eq!(striped(0x2100_0000), Some(0x2000_0000));
        assert_eq!(striped(0x2100_0006), Some(0x2000_0012));
        assert_eq!(striped(0x2101_0000), Some(0x2000_0004));
        assert_eq!(striped(0x2103_ffff), Some(0x2003_ffff));
        assert_eq!(striped(0x2104_0000), None);
        assert_eq!(striped(0x2000_0000), None);
        let mut all: Vec<u32> = (0x2100_0000..0x2104_0000).filter_map(striped).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 256 << 10);
    }

    #[test]
    fn ram_ends_where_it_ends() {
        let mut memory = Memory::new(1);
        let last = RAM + RAM_SIZE as u32 - 4;
        assert_eq!(memory.write_ram(last, [1, 2, 3, 4]), Some(()));
        assert_eq!(memory.read_ram(last), Some([1, 2, 3, 4]));
        assert_eq!(memory.read_ram::<4>(last + 2), None);
        assert_eq!(memory.write_ram(RAM - 4, [0; 4]), None);
        assert_eq!(memory.read_rom(0x10), Some(*b"Mu"));
        assert_eq!(memory.read_rom::<4>(boot_rom::SIZE as u32), None);
    }

    #[test]
    fn ram_forgets_by_seed() {
        let (mut first, second) = (Memory::new(1), Memory::new(2));
        assert_ne!(first.ram(), second.ram());
        first.scramble(2);
        assert_eq!(first.ram(), second.ram());
    }
}
