//! The flash: 2 MB of NOR, a Winbond W25Q16 in its times and commands.
//!
//! Programming only clears bits, erasing sets them. Both are done by the boot ROM, a page or sector
//! at a time, while the core stands still. A power cut leaves the operation under way half done, in
//! a way that a seed decides; [`Flash::cut_power_at`] orders one for a certain operation.

use std::collections::VecDeque;

use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg32;

use super::peripheral::{CYCLES_PER_MICROSECOND, Cycles};

/// 2 MB, as on a Raspberry Pi Pico.
pub const SIZE: usize = 2 << 20;
/// What is erased at once.
pub const SECTOR: u32 = 4096;
/// What is programmed at once.
pub const PAGE: u32 = 256;
/// Erasing a sector (data sheet, typical).
pub const ERASE_TIME: Cycles = 45_000 * CYCLES_PER_MICROSECOND;
/// Erasing a sector (data sheet, at most).
pub const LONGEST_ERASE_TIME: Cycles = 400_000 * CYCLES_PER_MICROSECOND;
/// Programming a page (typical).
pub const PROGRAM_TIME: Cycles = 400 * CYCLES_PER_MICROSECOND;
/// Programming a page (at most).
pub const LONGEST_PROGRAM_TIME: Cycles = 3_000 * CYCLES_PER_MICROSECOND;

/// What is done to a sector or page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Operation {
    /// All its bits become 1.
    Erase {
        /// Where the sector begins.
        offset: u32,
    },
    /// Bits that are 0 here become 0.
    Program {
        /// Where the bytes begin; they do not cross a page's border.
        offset: u32,
        /// The bytes.
        bytes: Vec<u8>,
    },
}

impl Operation {
    const fn time(&self, slow: bool) -> Cycles {
        match (self, slow) {
            (Self::Erase { .. }, false) => ERASE_TIME,
            (Self::Erase { .. }, true) => LONGEST_ERASE_TIME,
            (Self::Program { .. }, false) => PROGRAM_TIME,
            (Self::Program { .. }, true) => LONGEST_PROGRAM_TIME,
        }
    }
}

/// A power cut that is to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PowerCut {
    /// During the operation that has this number.
    operation: u64,
    /// Decides when, and what is left.
    seed: u64,
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Box<[u8; SIZE]>,
    /// Bytes that the processor sees at the flash's addresses: all or none.
    mapped: u32,
    queue: VecDeque<Operation>,
    /// When the operation at the queue's head began.
    began: Cycles,
    completed: u64,
    slow: bool,
    power_cuts: Vec<PowerCut>,
    power_lost: bool,
}

impl Flash {
    /// Erased, and not accessible before it is set up.
    pub fn new() -> Self {
        let bytes: Result<Box<[u8; SIZE]>, _> = vec![0xff; SIZE].into_boxed_slice().try_into();
        Self {
            bytes: bytes.expect("it has the length of the array"),
            mapped: 0,
            queue: VecDeque::new(),
            began: 0,
            completed: 0,
            slow: false,
            power_cuts: Vec::new(),
            power_lost: false,
        }
    }

    /// All its bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.as_slice()
    }

    /// All its bytes, for a programmer to change.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        self.bytes.as_mut_slice()
    }

    /// Bytes at an offset, if the processor sees the flash.
    #[inline(always)]
    pub fn mapped_bytes<const N: usize>(&self, offset: u32) -> Option<[u8; N]> {
        if offset >= self.mapped {
            return None;
        }
        // Aligned as it is, this cannot reach beyond the end, and the compiler sees that.
        let start = offset as usize & (SIZE - N);
        self.bytes[start..start + N].first_chunk().copied()
    }

    /// Whether the processor sees the flash at its addresses.
    pub const fn is_mapped(&self) -> bool {
        self.mapped != 0
    }

    /// Shows the flash to the processor, or hides it.
    pub fn set_mapped(&mut self, mapped: bool) {
        self.mapped = if mapped { SIZE as u32 } else { 0 };
    }

    /// Operations that were carried out since the machine was made.
    pub const fn operations(&self) -> u64 {
        self.completed
    }

    /// Cuts the power during the operation with this number, counted as
    /// [`operations`](Self::operations) does: the next one has the number that is given there now.
    pub fn cut_power_at(&mut self, operation: u64, seed: u64) {
        self.power_cuts.push(PowerCut { operation, seed });
    }

    /// Whether operations take as long as the data sheet allows, as those of a worn chip in the cold,
    /// rather than what is typical.
    pub fn set_slow(&mut self, slow: bool) {
        self.slow = slow;
    }

    /// Whether the power was cut since this was last asked.
    pub fn take_power_lost(&mut self) -> bool {
        std::mem::take(&mut self.power_lost)
    }

    /// Takes an operation to be done after those that wait.
    pub fn enqueue(&mut self, operation: Operation, now: Cycles) {
        if self.queue.is_empty() {
            self.began = now;
        }
        self.queue.push_back(operation);
    }

    /// Whether an operation is under way.
    pub fn busy(&self) -> bool {
        !self.queue.is_empty()
    }

    /// When the operation under way ends, or the power during it.
    pub fn next_event(&self) -> Option<Cycles> {
        let operation = self.queue.front()?;
        let time = match self.due_cut() {
            Some(cut) => cut_time(cut.seed, operation.time(self.slow)),
            None => operation.time(self.slow),
        };
        Some(self.began + time)
    }

    fn due_cut(&self) -> Option<PowerCut> {
        let mut cuts = self.power_cuts.iter().copied();
        cuts.find(|cut| cut.operation == self.completed)
    }

    /// Completes the operations that are over by now.
    pub fn advance(&mut self, now: Cycles) {
        while let Some(at) = self.next_event().filter(|&at| at <= now) {
            if let Some(cut) = self.due_cut() {
                self.power_cuts
                    .retain(|other| other.operation != cut.operation);
                self.lose_power(at, cut.seed);
                self.power_lost = true;
                return;
            }
            if let Some(operation) = self.queue.pop_front() {
                self.apply(&operation);
            }
            self.completed += 1;
            self.began = at;
        }
    }

    fn range(&mut self, offset: u32, length: usize) -> &mut [u8] {
        let start = offset as usize % SIZE;
        let end = (start + length).min(SIZE);
        &mut self.bytes[start..end]
    }

    fn apply(&mut self, operation: &Operation) {
        match operation {
            Operation::Erase { offset } => self.range(*offset, SECTOR as usize).fill(0xff),
            Operation::Program { offset, bytes } => {
                for (cell, byte) in self.range(*offset, bytes.len()).iter_mut().zip(bytes) {
                    *cell &= byte;
                }
            }
        }
    }

    /// The supply fails: what is under way stays half done, what waits is not done.
    pub fn lose_power(&mut self, now: Cycles, seed: u64) {
        if let Some(operation) = self.queue.pop_front() {
            let share = (now - self.began) as f64 / operation.time(self.slow) as f64;
            self.half_apply(&operation, share.clamp(0.0, 1.0), seed);
            self.completed += 1;
        }
        self.queue.clear();
        self.set_mapped(false);
    }

    /// Does a share of an operation: of the bits that would change, as many have. An erasure begins
    /// by clearing all bits, so that cells age evenly.
    fn half_apply(&mut self, operation: &Operation, share: f64, seed: u64) {
        /// The share of an erasure that clears.
        const CLEARING: f64 = 0.3;
        let mut chance = Pcg32::seed_from_u64(seed);
        match operation {
            Operation::Erase { offset } => {
                let cells = self.range(*offset, SECTOR as usize);
                if share < CLEARING {
                    for cell in cells {
                        *cell &= !bits(&mut chance, share / CLEARING);
                    }
                } else {
                    for cell in cells {
                        *cell = bits(&mut chance, (share - CLEARING) / (1.0 - CLEARING));
                    }
                }
            }
            Operation::Program { offset, bytes } => {
                for (cell, byte) in self.range(*offset, bytes.len()).iter_mut().zip(bytes) {
                    *cell &= byte | !bits(&mut chance, share);
                }
            }
        }
    }
}

/// A byte of bits each of which is 1 with this probability.
fn bits(chance: &mut Pcg32, probability: f64) -> u8 {
    let threshold = (probability * f64::from(u32::MAX)) as u32;
    (0..8)
        .filter(|_| chance.next_u32() < threshold)
        .map(|bit| 1 << bit)
        .sum()
}

/// When the power fails within an operation of this length.
fn cut_time(seed: u64, length: Cycles) -> Cycles {
    1 + Pcg32::seed_from_u64(!seed).next_u64() % (length - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(offset: u32, bytes: &[u8]) -> Operation {
        Operation::Program {
            offset,
            bytes: bytes.to_vec(),
        }
    }

    #[test]
    fn programming_clears_bits_and_erasing_sets_them() {
        let mut flash = Flash::new();
        flash.enqueue(program(0x1000, &[0xf0, 0x0f]), 1_000);
        assert!(flash.busy());
        assert_eq!(flash.next_event(), Some(1_000 + PROGRAM_TIME));
        flash.advance(1_000 + PROGRAM_TIME - 1);
        assert_eq!(flash.bytes()[0x1000], 0xff);
        flash.advance(1_000 + PROGRAM_TIME);
        assert_eq!(flash.bytes()[0x1000..0x1003], [0xf0, 0x0f, 0xff]);
        assert!(!flash.busy());
        flash.enqueue(program(0x1000, &[0x3c]), 0);
        flash.enqueue(Operation::Erase { offset: 0x2000 }, 0);
        flash.advance(PROGRAM_TIME);
        assert_eq!(flash.bytes()[0x1000], 0x30);
        assert_eq!(flash.next_event(), Some(PROGRAM_TIME + ERASE_TIME));
        flash.enqueue(Operation::Erase { offset: 0x1000 }, PROGRAM_TIME);
        flash.advance(PROGRAM_TIME + 2 * ERASE_TIME);
        assert!(flash.bytes().iter().all(|byte| *byte == 0xff));
        assert_eq!(flash.operations(), 4);
    }

    #[test]
    fn a_power_cut_leaves_an_operation_half_done() {
        let results: Vec<Vec<u8>> = (0..20)
            .map(|seed| {
                let mut flash = Flash::new();
                flash.cut_power_at(1, seed);
                flash.enqueue(program(0, &[0; 256]), 0);
                flash.enqueue(program(256, &[0; 256]), 0);
                flash.enqueue(program(512, &[0; 256]), 0);
                flash.advance(PROGRAM_TIME);
                assert!(!flash.take_power_lost());
                flash.advance(3 * PROGRAM_TIME);
                assert!(flash.take_power_lost());
                assert!(flash.bytes()[..256].iter().all(|byte| *byte == 0));
                assert!(flash.bytes()[512..].iter().all(|byte| *byte == 0xff));
                flash.bytes()[256..512].to_vec()
            })
            .collect();
        let half = |page: &&Vec<u8>| page.iter().any(|byte| !matches!(*byte, 0 | 0xff));
        assert!(results.iter().filter(half).count() > 15);
        assert_ne!(results[0], results[1]);
    }

    #[test]
    fn an_interrupted_erasure_may_clear_bits_or_set_some() {
        let erase = |at: Cycles| {
            let mut flash = Flash::new();
            flash.bytes_mut()[..4096].fill(0xa5);
            flash.enqueue(Operation::Erase { offset: 0 }, 0);
            flash.lose_power(at, 1);
            let ones = flash.bytes()[..4096].iter().map(|byte| byte.count_ones());
            assert_eq!(flash.bytes()[4096], 0xff);
            ones.sum::<u32>()
        };
        let (all, half) = (4096 * 8, 4096 * 4);
        assert_eq!(erase(0), half);
        assert!(erase(ERASE_TIME / 4) < half / 2);
        assert!(erase(ERASE_TIME * 9 / 10) > half);
        assert!(erase(ERASE_TIME) > all - 10);
    }

    #[test]
    fn it_is_seen_only_when_mapped() {
        let mut flash = Flash::new();
        assert_eq!(flash.mapped_bytes::<4>(0), None);
        flash.set_mapped(true);
        assert_eq!(flash.mapped_bytes(SIZE as u32 - 4), Some([0xff; 4]));
        assert_eq!(flash.mapped_bytes::<4>(SIZE as u32), None);
    }
}
