//! The DMA controller (RP2040 datasheet 2.5).
//!
//! The controller decides what is to be moved, and the bus moves it: [`Dma::next_transfer`] gives
//! the next transfer that may be made, the bus makes it, and [`Dma::completed`] takes the outcome.
//! Between the two the bus may access the controller's own registers, as channels that reprogram
//! other channels do.
//!
//! ```
//! # use crate::dma::{Dma, Outcome, Size};
//! # fn read(_: u32, _: Size) -> Option<u32> { Some(0) }
//! # fn write(_: u32, _: Size, _: u32) -> Option<()> { Some(()) }
//! # let (mut dma, requests, now) = (Dma::new(), 0, 0);
//! if !dma.is_idle() {
//!     while let Some(transfer) = dma.next_transfer(requests, now) {
//!         let outcome = match read(transfer.from, transfer.size) {
//!             None => Outcome::ReadError,
//!             Some(data) => match write(transfer.to, transfer.size, transfer.swapped(data)) {
//!                 None => Outcome::WriteError,
//!                 Some(()) => Outcome::Moved(data),
//!             },
//!         };
//!         dma.completed(transfer, outcome);
//!     }
//! }
//! ```
//!
//! The hardware makes one transfer in a cycle at best, so that the bus should not ask more often
//! than once a cycle. Here a transfer is over when it has begun: there is nothing in flight, aborts
//! are immediate and raise no interrupt (they can in hardware, erratum RP2040-E13), and the FIFOs
//! between the controller's stages are always empty.
//!
//! Peripherals with FIFOs ask for transfers for as long as there is something to be moved: their
//! requests are levels, a bit each in what [`Dma::next_transfer`] is given. The wraps of PWM
//! counters are moments, and each is good for one transfer: [`Dma::request_once`]. The pacing
//! timers are the controller's own.

use super::peripheral::{Cycles, Peripheral, Write};

mod channel;
mod sniffer;
#[cfg(test)]
mod tests;
mod timer;

use channel::{Channel, Completion};
use sniffer::Sniffer;
use timer::Timer;

/// Channels.
pub const CHANNELS: usize = 12;
/// Its interrupt lines, DMA_IRQ_0 and DMA_IRQ_1.
pub const IRQS: [u32; 2] = [11, 12];

/// What paces a channel: the numbers of TREQ_SEL (2.5.3.1), which are also the places of their bits
/// in sets of requests.
pub mod treq {
    /// The first PWM slice's counter wrapped; the other slices follow.
    pub const PWM_WRAP0: u32 = 24;
    /// The transmit FIFO of I2C0.
    pub const I2C0_TX: u32 = 32;
    /// The receive FIFO of I2C0.
    pub const I2C0_RX: u32 = 33;
    /// The transmit FIFO of I2C1.
    pub const I2C1_TX: u32 = 34;
    /// The receive FIFO of I2C1.
    pub const I2C1_RX: u32 = 35;
    /// The FIFO of the analogue-to-digital converter.
    pub const ADC: u32 = 36;
    /// The first pacing timer; the others follow.
    pub const TIMER0: u32 = 59;
    /// Always.
    pub const PERMANENT: u32 = 63;
}

/// Requests that nobody outside has to make.
const OWN_REQUESTS: u64 = !0 << treq::TIMER0;
const TIMERS: usize = 4;

const CHANNEL_STRIDE: u32 = 0x40;
const CHANNELS_END: u32 = CHANNELS as u32 * CHANNEL_STRIDE;
const INTR: u32 = 0x400;
const INTE0: u32 = 0x404;
const INTF0: u32 = 0x408;
const INTS0: u32 = 0x40c;
const INTE1: u32 = 0x414;
const INTF1: u32 = 0x418;
const INTS1: u32 = 0x41c;
const TIMER0: u32 = 0x420;
const TIMER3: u32 = 0x42c;
const MULTI_CHAN_TRIGGER: u32 = 0x430;
const SNIFF_CTRL: u32 = 0x434;
const SNIFF_DATA: u32 = 0x438;
const CHAN_ABORT: u32 = 0x444;
const N_CHANNELS: u32 = 0x448;
const DEBUG: u32 = 0x800;
const DEBUG_END: u32 = DEBUG + CHANNELS_END;

/// A bit for each channel.
const ALL_CHANNELS: u32 = (1 << CHANNELS) - 1;

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
    const fn reversed(self, data: u32) -> u32 {
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

/// The controller.
#[derive(Clone, Debug, Default)]
pub struct Dma {
    channels: [Channel; CHANNELS],
    /// Channels with something to do: busy and not paused.
    active: u32,
    /// The channel that had the last turn.
    last: usize,
    timers: [Timer; TIMERS],
    raised: u32,
    enabled: [u32; 2],
    forced: [u32; 2],
    sniffer: Sniffer,
}

impl Dma {
    /// A controller after power-up.
    pub fn new() -> Self {
        Self::default()
    }

    /// Resets it.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Whether no channel has anything to do.
    pub const fn is_idle(&self) -> bool {
        self.active == 0
    }

    /// The requests that channels wait for, a bit for each number of [`treq`].
    pub fn awaited(&self) -> u64 {
        bits(self.active).fold(0, |set, n| set | 1 << self.channels[n].treq())
    }

    /// The next transfer that may be made now, given the requests that peripherals make, a bit for
    /// each number of [`treq`]. It has to be made, and [`Dma::completed`] called.
    ///
    /// Channels take turns; those of high priority go first.
    pub fn next_transfer(&mut self, requests: u64, now: Cycles) -> Option<Transfer> {
        if self.is_idle() {
            return None;
        }
        self.advance(now);
        self.complete_empty_channels();
        let ready = subset(self.active, |n| self.is_ready(n, requests));
        let preferred = subset(ready, |n| self.channels[n].has_high_priority());
        let candidates = if preferred == 0 { ready } else { preferred };
        let after_last = candidates & (!1 << self.last);
        let turn = if after_last == 0 {
            candidates
        } else {
            after_last
        };
        let channel = bits(turn).next()?;
        self.last = channel;
        let Channel { credits, .. } = &mut self.channels[channel];
        *credits = credits.saturating_sub(1);
        Some(self.channels[channel].issue(channel))
    }

    /// Takes the outcome of a transfer.
    pub fn completed(&mut self, transfer: Transfer, outcome: Outcome) {
        if let Outcome::Moved(data) = outcome {
            let sniffed = self.channels[transfer.channel].is_sniffed();
            self.sniffer.observe(&transfer, sniffed, data);
        }
        let completion = self.channels[transfer.channel].completed(outcome);
        self.close(transfer.channel, completion);
    }

    /// A moment at which a peripheral asks for one transfer (the wrap of a PWM counter): each
    /// channel that waits for it counts it.
    pub fn request_once(&mut self, treq: u32) {
        self.credit(treq, 1);
    }

    /// The levels of the interrupt lines, in the order of [`IRQS`].
    pub fn lines(&self) -> [bool; 2] {
        [0, 1].map(|line| self.status(line) != 0)
    }

    fn status(&self, line: usize) -> u32 {
        self.raised & self.enabled[line] | self.forced[line]
    }

    fn is_ready(&self, n: usize, requests: u64) -> bool {
        let channel = &self.channels[n];
        let requests = requests & !OWN_REQUESTS | 1 << treq::PERMANENT;
        !channel.is_empty() && (channel.credits > 0 || requests >> channel.treq() & 1 != 0)
    }

    fn credit(&mut self, treq: u32, count: u64) {
        for n in bits(self.active) {
            let channel = &mut self.channels[n];
            if channel.treq() == treq {
                channel.credit(count);
            }
        }
    }

    /// Sequences of no transfers complete when it would be their turn.
    fn complete_empty_channels(&mut self) {
        for n in bits(self.active) {
            let completion = self.channels[n].complete_if_empty();
            self.close(n, completion);
        }
    }

    fn close(&mut self, n: usize, completion: Completion) {
        if completion == Completion::NotYet {
            return;
        }
        let channel = &self.channels[n];
        let halted = completion == Completion::Halted;
        if halted || !channel.is_quiet() {
            self.raised |= 1 << n;
        }
        let next = channel.chain_to();
        self.note(n);
        if !halted && next != n && next < CHANNELS {
            self.trigger(next);
        }
    }

    fn trigger(&mut self, n: usize) {
        self.channels[n].trigger();
        self.note(n);
    }

    /// Notes whether a channel is active, after anything may have changed that.
    fn note(&mut self, n: usize) {
        let active = u32::from(self.channels[n].is_active());
        self.active = self.active & !(1 << n) | active << n;
    }

    fn write_channel(&mut self, offset: u32, write: Write) {
        let n = (offset / CHANNEL_STRIDE) as usize;
        let register = offset % CHANNEL_STRIDE;
        let written = self.channels[n].write(register, write);
        // The last register of each of the four orders triggers.
        if register % 0x10 == 0xc {
            if written != 0 {
                self.channels[n].trigger();
            } else if self.channels[n].is_quiet() {
                self.raised |= 1 << n;
            }
        }
        self.note(n);
    }

    fn abort(&mut self, channels: u32) {
        for n in bits(channels & ALL_CHANNELS) {
            self.channels[n].abort();
            self.note(n);
        }
    }
}

/// The members of a set for which something holds.
fn subset(set: u32, holds: impl Fn(usize) -> bool) -> u32 {
    let members = bits(set).filter(|&n| holds(n));
    members.fold(0, |subset, n| subset | 1 << n)
}

/// The members of a set, lowest first.
fn bits(set: u32) -> impl Iterator<Item = usize> {
    let more = |set: &u32| Some(set & set.wrapping_sub(1)).filter(|&rest| rest != 0);
    let first = Some(set).filter(|&set| set != 0);
    std::iter::successors(first, more).map(|set| set.trailing_zeros() as usize)
}

impl Peripheral for Dma {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        self.advance(now);
        match offset {
            ..CHANNELS_END => {
                let channel = &self.channels[(offset / CHANNEL_STRIDE) as usize];
                channel.read(offset % CHANNEL_STRIDE)
            }
            INTR => self.raised,
            INTE0 => self.enabled[0],
            INTE1 => self.enabled[1],
            INTF0 => self.forced[0],
            INTF1 => self.forced[1],
            INTS0 => self.status(0),
            INTS1 => self.status(1),
            TIMER0..=TIMER3 => self.timers[((offset - TIMER0) / 4) as usize].fraction(),
            SNIFF_CTRL => self.sniffer.control(),
            SNIFF_DATA => self.sniffer.result(),
            N_CHANNELS => CHANNELS as u32,
            DEBUG..DEBUG_END => {
                let channel = &self.channels[((offset - DEBUG) / CHANNEL_STRIDE) as usize];
                channel.read_debug(offset % CHANNEL_STRIDE)
            }
            // FIFO_LEVELS too: they are always empty.
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        self.advance(now);
        let onto = |register: u32| write.onto(register) & ALL_CHANNELS;
        match offset {
            ..CHANNELS_END => self.write_channel(offset, write),
            // Written 1 to clear, through whichever alias.
            INTR | INTS0 | INTS1 => self.raised &= !write.value,
            INTE0 => self.enabled[0] = onto(self.enabled[0]),
            INTE1 => self.enabled[1] = onto(self.enabled[1]),
            INTF0 => self.forced[0] = onto(self.forced[0]),
            INTF1 => self.forced[1] = onto(self.forced[1]),
            TIMER0..=TIMER3 => {
                let timer = &mut self.timers[((offset - TIMER0) / 4) as usize];
                timer.set(write.onto(timer.fraction()), now);
            }
            MULTI_CHAN_TRIGGER => bits(onto(0)).for_each(|n| self.trigger(n)),
            SNIFF_CTRL => self.sniffer.set_control(write.onto(self.sniffer.control())),
            SNIFF_DATA => self.sniffer.seed(write.onto(self.sniffer.result())),
            CHAN_ABORT => self.abort(onto(0)),
            DEBUG..DEBUG_END => {
                let channel = &mut self.channels[((offset - DEBUG) / CHANNEL_STRIDE) as usize];
                channel.write_debug(offset % CHANNEL_STRIDE);
            }
            _ => {}
        }
    }

    /// When a pacing timer next asks for a transfer that a channel waits for.
    fn next_event(&self) -> Option<Cycles> {
        if self.is_idle() {
            return None;
        }
        let awaited = self.awaited();
        let timers = self.timers.iter().enumerate();
        timers
            .filter(|(n, _)| awaited >> (treq::TIMER0 + *n as u32) & 1 != 0)
            .filter_map(|(_, timer)| timer.next_request())
            .min()
    }

    fn advance(&mut self, now: Cycles) {
        for n in 0..TIMERS {
            let requests = self.timers[n].advance(now);
            if requests > 0 {
                self.credit(treq::TIMER0 + n as u32, requests);
            }
        }
    }
}
