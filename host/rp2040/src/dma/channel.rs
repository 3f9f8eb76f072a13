//! One channel: its registers in all four orders, its sequence of transfers
//! (RP2040 datasheet 2.5.1, 2.5.2 and 2.5.7).

use super::transfer::{Outcome, Size, Transfer};
use crate::peripheral::Write;

/// Bits of CTRL.
pub mod ctrl {
    pub const EN: u32 = 1 << 0;
    pub const HIGH_PRIORITY: u32 = 1 << 1;
    pub const DATA_SIZE_SHIFT: u32 = 2;
    pub const INCR_READ: u32 = 1 << 4;
    pub const INCR_WRITE: u32 = 1 << 5;
    pub const RING_SIZE_SHIFT: u32 = 6;
    pub const RING_SEL: u32 = 1 << 10;
    pub const CHAIN_TO_SHIFT: u32 = 11;
    pub const TREQ_SEL_SHIFT: u32 = 15;
    pub const IRQ_QUIET: u32 = 1 << 21;
    pub const BSWAP: u32 = 1 << 22;
    pub const SNIFF_EN: u32 = 1 << 23;
    pub const BUSY: u32 = 1 << 24;
    pub const WRITE_ERROR: u32 = 1 << 29;
    pub const READ_ERROR: u32 = 1 << 30;
    pub const AHB_ERROR: u32 = 1 << 31;
    /// What stays as it is written.
    pub const STORED: u32 = 0x00ff_ffff;
    pub const ERRORS: u32 = WRITE_ERROR | READ_ERROR;
}

/// The counter of requests has 6 bits.
const MOST_CREDITS: u64 = 63;

const DBG_CTDREQ: u32 = 0x00;
const DBG_TCR: u32 = 0x04;

/// The registers in the order of the first four addresses. The other twelve are the same in other
/// orders, each with another one last, where a write triggers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Register {
    ReadAddr,
    WriteAddr,
    TransCount,
    Ctrl,
}

const ORDER: [Register; 16] = {
    use Register::{Ctrl, ReadAddr, TransCount, WriteAddr};
    [
        ReadAddr, WriteAddr, TransCount, Ctrl, // as they are
        Ctrl, ReadAddr, WriteAddr, TransCount, // alias 1
        Ctrl, TransCount, ReadAddr, WriteAddr, // alias 2
        Ctrl, WriteAddr, TransCount, ReadAddr, // alias 3
    ]
};

/// Whether a sequence of transfers is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completion {
    NotYet,
    Completed,
    /// By a bus error.
    Halted,
}

/// A channel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Channel {
    read_addr: u32,
    write_addr: u32,
    /// Transfers left.
    count: u32,
    /// Transfers of the next sequence.
    reload: u32,
    /// CTRL, as far as it is stored.
    ctrl: u32,
    errors: u32,
    busy: bool,
    /// Requests counted and not yet served.
    pub credits: u8,
}

impl Channel {
    pub fn read(&self, register: u32) -> u32 {
        match ORDER[(register / 4) as usize] {
            Register::ReadAddr => self.read_addr,
            Register::WriteAddr => self.write_addr,
            Register::TransCount => self.count,
            Register::Ctrl => self.read_ctrl(),
        }
    }

    fn read_ctrl(&self) -> u32 {
        let busy = if self.busy { ctrl::BUSY } else { 0 };
        let any_error = if self.errors == 0 { 0 } else { ctrl::AHB_ERROR };
        self.ctrl | busy | self.errors | any_error
    }

    /// Returns what the register was set to.
    pub fn write(&mut self, register: u32, write: Write) -> u32 {
        let value = write.onto(self.read(register));
        match ORDER[(register / 4) as usize] {
            Register::ReadAddr => self.read_addr = value,
            Register::WriteAddr => self.write_addr = value,
            Register::TransCount => self.reload = value,
            Register::Ctrl => {
                self.ctrl = value & ctrl::STORED;
                // Written 1 to clear, through whichever alias.
                self.errors &= !(write.value & ctrl::ERRORS);
            }
        }
        value
    }

    pub fn read_debug(&self, register: u32) -> u32 {
        match register {
            DBG_CTDREQ => self.credits.into(),
            DBG_TCR => self.reload,
            _ => 0,
        }
    }

    pub fn write_debug(&mut self, register: u32) {
        if register == DBG_CTDREQ {
            self.credits = 0;
        }
    }

    fn has(&self, bit: u32) -> bool {
        self.ctrl & bit != 0
    }

    pub fn has_high_priority(&self) -> bool {
        self.has(ctrl::HIGH_PRIORITY)
    }

    pub fn is_quiet(&self) -> bool {
        self.has(ctrl::IRQ_QUIET)
    }

    pub fn is_sniffed(&self) -> bool {
        self.has(ctrl::SNIFF_EN)
    }

    pub fn treq(&self) -> u32 {
        self.ctrl >> ctrl::TREQ_SEL_SHIFT & 0x3f
    }

    pub fn chain_to(&self) -> usize {
        (self.ctrl >> ctrl::CHAIN_TO_SHIFT & 0xf) as usize
    }

    /// Whether it has something to do: in a sequence, and not paused.
    pub fn is_active(&self) -> bool {
        self.busy && self.has(ctrl::EN)
    }

    /// Begins a sequence, unless it is in one or not enabled.
    pub fn trigger(&mut self) {
        if !self.busy && self.has(ctrl::EN) {
            self.busy = true;
            self.count = self.reload;
            self.credits = 0;
        }
    }

    pub fn abort(&mut self) {
        self.busy = false;
        self.credits = 0;
    }

    pub fn credit(&mut self, count: u64) {
        self.credits = u64::from(self.credits)
            .saturating_add(count)
            .min(MOST_CREDITS) as u8;
    }

    fn size(&self) -> Size {
        match self.ctrl >> ctrl::DATA_SIZE_SHIFT & 3 {
            0 => Size::Byte,
            1 => Size::Halfword,
            // 3 is reserved.
            _ => Size::Word,
        }
    }

    /// The next transfer of the sequence; the addresses move on.
    pub fn issue(&mut self, channel: usize) -> Transfer {
        let transfer = Transfer {
            channel,
            from: self.read_addr,
            to: self.write_addr,
            size: self.size(),
            byte_swap: self.has(ctrl::BSWAP),
        };
        let step = transfer.size.bytes();
        let ring = 1_u32 << (self.ctrl >> ctrl::RING_SIZE_SHIFT & 0xf);
        // A ring of one byte is none.
        let wrapped = if ring == 1 { u32::MAX } else { ring - 1 };
        let (read_mask, write_mask) = if self.has(ctrl::RING_SEL) {
            (u32::MAX, wrapped)
        } else {
            (wrapped, u32::MAX)
        };
        if self.has(ctrl::INCR_READ) {
            self.read_addr = moved(self.read_addr, step, read_mask);
        }
        if self.has(ctrl::INCR_WRITE) {
            self.write_addr = moved(self.write_addr, step, write_mask);
        }
        transfer
    }

    /// Takes the outcome of a transfer; of an aborted sequence it no longer matters.
    pub fn completed(&mut self, outcome: Outcome) -> Completion {
        if !self.busy {
            return Completion::NotYet;
        }
        match outcome {
            Outcome::Moved(_) => {
                self.count = self.count.saturating_sub(1);
                return self.complete_if_empty();
            }
            Outcome::ReadError => self.errors |= ctrl::READ_ERROR,
            Outcome::WriteError => self.errors |= ctrl::WRITE_ERROR,
        }
        self.busy = false;
        Completion::Halted
    }

    /// Whether no transfers are left.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub fn complete_if_empty(&mut self) -> Completion {
        if !self.is_empty() {
            return Completion::NotYet;
        }
        self.busy = false;
        Completion::Completed
    }
}

/// An address after a transfer; bits outside the mask do not change.
fn moved(address: u32, step: u32, mask: u32) -> u32 {
    address & !mask | address.wrapping_add(step) & mask
}
