//! The controller: channels, their turns, and its registers.

use super::channel::{Channel, Completion};
use super::registers::*;
use super::sniffer::Sniffer;
use super::timer::Timer;
use super::transfer::{Outcome, Transfer};
use crate::peripheral::{Cycles, Peripheral, Write};

/// Requests that are the controller's own.
const OWN_REQUESTS: u64 = !0 << treq::TIMER0;
const TIMERS: usize = 4;

/// A bit for each channel.
const ALL_CHANNELS: u32 = (1 << CHANNELS) - 1;

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
