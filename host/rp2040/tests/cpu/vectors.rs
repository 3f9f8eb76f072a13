//! Single instructions against an independent emulator: `make_vectors.py` says how the vectors
//! are made and what their format is.

use std::collections::BTreeMap;

use emulated_rp2040::cpu::{Bus, BusFault, Core, Flags, PC, SP};

const DATA: u32 = 0x2001_0000;
const CODE: u32 = 0x2010_0000;
const CODE_SIZE: u32 = 14 << 20;

/// A hash of 32 bits (the finaliser of MurmurHash3).
fn mix(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x85eb_ca6b);
    let x = (x ^ x >> 13).wrapping_mul(0xc2b2_ae35);
    x ^ x >> 16
}

/// Memory that holds hashes, and what was written to it.
#[derive(Default)]
struct Memory {
    written: BTreeMap<u32, u8>,
    instruction: (u32, Vec<u8>),
}

impl Memory {
    fn before(address: u32) -> u32 {
        mix((address >> 2 & 0x3fff)
            .wrapping_mul(0x9e37_79b9)
            .wrapping_add(1))
    }

    fn byte(&self, address: u32) -> u8 {
        let (start, code) = &self.instruction;
        let coded = code.get(address.wrapping_sub(*start) as usize);
        let shift = 8 * (address & 3);
        let before = (Self::before(address) >> shift) as u8;
        self.written
            .get(&address)
            .or(coded)
            .copied()
            .unwrap_or(before)
    }

    fn bytes<const N: usize>(&self, address: u32) -> [u8; N] {
        std::array::from_fn(|i| self.byte(address + i as u32))
    }

    /// Words that differ from what they were.
    fn changed(&self) -> BTreeMap<u32, u32> {
        let word = |address| (address, u32::from_le_bytes(self.bytes(address)));
        let words = self.written.keys().map(|address| word(address & !3));
        words
            .filter(|&(address, value)| value != Self::before(address))
            .collect()
    }
}

impl Bus for Memory {
    fn read<const N: usize>(&mut self, address: u32) -> Result<[u8; N], BusFault> {
        Ok(self.bytes(address))
    }
    fn write<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> Result<(), BusFault> {
        self.written.extend((address..).zip(bytes));
        Ok(())
    }
}

/// What a vector compares.
#[derive(Clone, Debug, PartialEq)]
struct State {
    /// R0 to R14.
    registers: [u32; 15],
    psp: u32,
    flags: Flags,
    primask: bool,
    pc: u32,
    memory: BTreeMap<u32, u32>,
}

impl State {
    /// What vector `i` starts from, before some registers are changed.
    fn draw(seed: u32, i: u32) -> Self {
        let base = mix(seed).wrapping_add(i.wrapping_mul(32));
        let word = |k: u32| mix(base.wrapping_add(k));
        let on_stack = |word: u32| DATA + (word & 0x3fffc);
        let mut registers = std::array::from_fn(|k| register_value(word(k as u32)));
        registers[SP] = on_stack(word(SP as u32));
        Self {
            registers,
            psp: on_stack(word(15)),
            flags: Flags::from_psr(word(16) << 28),
            primask: word(17) & 1 != 0,
            pc: CODE + (6 * i) % CODE_SIZE,
            memory: BTreeMap::new(),
        }
    }

    /// The state in which `core` stops after one instruction.
    fn after_step(&self, code: &[u8], core: &mut Core) -> Self {
        let mut memory = Memory {
            instruction: (self.pc, code.to_vec()),
            ..Memory::default()
        };
        let registers = core.registers_mut();
        for (n, value) in self.registers.iter().enumerate() {
            registers.set(n, *value);
        }
        registers.set(PC, self.pc);
        registers.set_psp(self.psp);
        registers.set_flags(self.flags);
        registers.set_primask(self.primask);
        core.step(&mut memory);
        let registers = core.registers();
        Self {
            registers: std::array::from_fn(|n| registers.get(n)),
            psp: registers.psp(),
            flags: registers.flags(),
            primask: registers.primask(),
            pc: core.pc(),
            memory: memory.changed(),
        }
    }
}

/// Of random words, makes some small, some negative, some extreme.
fn register_value(word: u32) -> u32 {
    match mix(word.wrapping_add(1)) & 7 {
        0 => word & 0xff,
        1 => 0x7fff_ffff + (word & 3),
        2 => 0xffff_ff00 | word & 0xff,
        3 => word & 0x3f,
        _ => word,
    }
}

/// Takes numbers off the front of a file.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk().expect("the file is whole");
        self.0 = rest;
        *head
    }

    fn u8(&mut self) -> u8 {
        let [byte] = self.take();
        byte
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn code(&mut self) -> Vec<u8> {
        let first: [u8; 2] = self.take();
        let mut code = first.to_vec();
        if u16::from_le_bytes(first) >> 11 >= 0b11101 {
            code.extend(self.take::<2>());
        }
        code
    }

    /// Replaces the values that a mask names.
    fn replace<'v>(&mut self, values: impl Iterator<Item = &'v mut u32>) {
        let mask = self.u16();
        for (n, value) in values.enumerate() {
            if mask >> n & 1 != 0 {
                *value = self.u32();
            }
        }
    }

    fn expected(&mut self, before: &State, size: u32) -> State {
        let mut state = before.clone();
        let bits = self.u8();
        state.flags = Flags::from_psr(u32::from(bits) << 24);
        state.primask = bits & 1 != 0;
        self.replace(state.registers.iter_mut().chain([&mut state.psp]));
        state.pc = if bits & 2 != 0 {
            self.u32()
        } else {
            before.pc + size
        };
        state.memory = (0..self.u8()).map(|_| (self.u32(), self.u32())).collect();
        state
    }
}

/// Runs all vectors of a file; returns how many there were.
///
/// # Panics
/// At the first that comes out differently.
pub fn check(file: &[u8]) -> u32 {
    let mut reader = Reader(file);
    assert_eq!(&reader.take(), b"TRV1", "not a file of vectors");
    let (count, seed) = (reader.u32(), reader.u32());
    for i in 0..count {
        let code = reader.code();
        let mut before = State::draw(seed, i);
        reader.replace(before.registers.iter_mut());
        let expected = reader.expected(&before, code.len() as u32);
        let mut core = Core::new();
        let after = before.after_step(&code, &mut core);
        assert_eq!(
            after, expected,
            "vector {i}, instruction {code:02x?}, from {before:x?}"
        );
        assert_eq!(core.fault(), None, "vector {i}, instruction {code:02x?}");
    }
    assert!(reader.0.is_empty(), "bytes after the last vector");
    count
}
