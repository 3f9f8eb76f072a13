//! A transfer: what is moved, and what came of it.

/// How much is moved at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// A byte.
    Byte,
    /// Two.
    Halfword,
    /// Four.
    Word,
}

impl Size {
    /// In bytes.
    pub const fn bytes(self) -> u32 {
        match self {
            Self::Byte => 1,
            Self::Halfword => 2,
            Self::Word => 4,
        }
    }

    /// The bytes of a value in reverse order; bits above the size are 0.
    pub(super) const fn reversed(self, data: u32) -> u32 {
        match self {
            Self::Byte => data & 0xff,
            Self::Halfword => (data as u16).swap_bytes() as u32,
            Self::Word => data.swap_bytes(),
        }
    }
}

/// One read and one write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// Whose it is.
    pub channel: usize,
    /// The address to read; unaligned if the program made it so.
    pub from: u32,
    /// The address to write; unaligned if the program made it so.
    pub to: u32,
    /// How much.
    pub size: Size,
    /// BSWAP: what is written is what was read in reverse order.
    pub byte_swap: bool,
}

impl Transfer {
    /// What to write after this was read.
    pub const fn swapped(&self, data: u32) -> u32 {
        if self.byte_swap {
            self.size.reversed(data)
        } else {
            data
        }
    }
}

/// What came of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It was made; this is what was read.
    Moved(u32),
    /// The read met a bus error.
    ReadError,
    /// The write met one.
    WriteError,
}
