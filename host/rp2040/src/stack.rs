//! How deep the stack has been: it is painted at power-up, and what is no longer paint was used.

use super::elf::Image;
use super::memory::{Memory, RAM};

/// Unlikely to be pushed.
const PAINT: [u8; 4] = 0x5a17_c0de_u32.to_le_bytes();

/// Where the stack lies, by the symbols `_stack_start` (its top, where it begins) and `_stack_end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stack {
    top: u32,
    end: u32,
}

impl Stack {
    /// The stack of a program; `None` if it does not say where both ends are.
    pub fn of(image: &Image) -> Option<Self> {
        let top = image.symbol("_stack_start")?.address;
        let end = image.symbol("_stack_end")?.address;
        (RAM <= end && end < top).then_some(Self { top, end })
    }

    /// Its bytes.
    pub const fn size(self) -> u32 {
        self.top - self.end
    }

    fn range(self) -> std::ops::Range<usize> {
        (self.end - RAM) as usize..(self.top - RAM) as usize
    }

    /// Paints it.
    pub fn paint(self, memory: &mut Memory) {
        let cells = memory.ram_mut().get_mut(self.range()).unwrap_or_default();
        for word in cells.chunks_exact_mut(PAINT.len()) {
            word.copy_from_slice(&PAINT);
        }
    }

    /// The most bytes that were on it.
    pub fn high_water(self, memory: &Memory) -> u32 {
        let cells = memory.ram().get(self.range()).unwrap_or_default();
        let untouched = cells
            .chunks_exact(PAINT.len())
            .take_while(|word| *word == PAINT)
            .count();
        self.size() - (untouched * PAINT.len()) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::Symbol;

    #[test]
    fn the_deepest_word_written_counts() {
        let mut image = Image::default();
        assert_eq!(Stack::of(&image), None);
        for (name, address) in [("_stack_start", RAM + 0x800), ("_stack_end", RAM)] {
            image
                .symbols
                .insert(name.into(), Symbol { address, size: 0 });
        }
        let stack = Stack::of(&image).expect("both symbols are there");
        let mut memory = Memory::new(0);
        stack.paint(&mut memory);
        assert_eq!((stack.size(), stack.high_water(&memory)), (0x800, 0));
        memory.write_ram(RAM + 0x7fc, [0; 4]);
        memory.write_ram(RAM + 0x700, [0; 4]);
        assert_eq!(stack.high_water(&memory), 0x100);
    }
}
