//! Pulse width modulation (RP2040 datasheet 4.5): eight slices of two outputs each.
//!
//! The counters are not stepped: their state is worked out from the time when they are read. A
//! slice makes an event of a wrap only if an interrupt or the DMA controller wants it, or if new
//! values of TOP or CC wait to take over there.
//!
//! Not modelled: counting pulses at the B pins (DIVMODE 1 to 3, in which the counter stands).

use crate::peripheral::{Cycles, Peripheral, Write};
use crate::pins::Pulses;

#[cfg(test)]
mod tests;

/// Slices.
pub const SLICES: usize = 8;
/// The interrupt line, PWM_IRQ_WRAP.
pub const IRQ: u32 = 4;

/// Bytes of a slice's registers.
const STRIDE: u32 = 0x14;
const CSR: u32 = 0x00;
const DIV: u32 = 0x04;
const CTR: u32 = 0x08;
const CC: u32 = 0x0c;
const TOP: u32 = 0x10;
const EN: u32 = 0xa0;
const INTR: u32 = 0xa4;
const INTE: u32 = 0xa8;
const INTF: u32 = 0xac;
const INTS: u32 = 0xb0;
/// A bit for each slice.
const ALL: u32 = (1 << SLICES) - 1;

/// Bits of CSR.
mod csr {
    pub const EN: u32 = 1 << 0;
    pub const PH_CORRECT: u32 = 1 << 1;
    pub const A_INV: u32 = 1 << 2;
    pub const B_INV: u32 = 1 << 3;
    pub const DIVMODE: u32 = 3 << 4;
    pub const PH_RET: u32 = 1 << 6;
    pub const PH_ADV: u32 = 1 << 7;
    /// Those that stay as they are written.
    pub const KEPT: u32 = EN | PH_CORRECT | A_INV | B_INV | DIVMODE;
}

/// Cycles are divided in sixteenths (DIV: 8 bits of integer, 4 of fraction).
const FRACTION: u64 = 16;

/// TOP and CC, which take over together when the counter wraps (4.5.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    top: u16,
    compare: [u16; 2],
}

/// One slice.
#[derive(Clone, Copy, Debug)]
struct Slice {
    csr: u32,
    div: u32,
    /// In force.
    shape: Shape,
    /// Written; in force from the next wrap on.
    next: Shape,
    /// Sixteenths of cycles, of which the counter makes counts, at `since`.
    phase: u64,
    since: Cycles,
}

impl Slice {
    const RESET: Self = {
        let shape = Shape {
            top: u16::MAX,
            compare: [0; 2],
        };
        Self {
            csr: 0,
            div: 1 << 4,
            shape,
            next: shape,
            phase: 0,
            since: 0,
        }
    };

    const fn counts(&self) -> bool {
        self.csr & csr::EN != 0 && self.csr & csr::DIVMODE == 0
    }

    /// Sixteenths of cycles that a count takes. An integer part of 0 stands for 256 (4.5.2.4).
    const fn count_length(&self) -> u64 {
        match self.div as u64 {
            fraction @ ..FRACTION => 256 * FRACTION + fraction,
            div => div,
        }
    }

    /// Counts from wrap to wrap.
    const fn period(&self) -> u64 {
        let counts = self.shape.top as u64 + 1;
        if self.csr & csr::PH_CORRECT != 0 {
            2 * counts
        } else {
            counts
        }
    }

    /// Brings the slice to this time; whether it wrapped.
    fn settle(&mut self, now: Cycles) -> bool {
        let span = now.saturating_sub(self.since);
        self.since = now;
        if !self.counts() {
            self.shape = self.next;
            return false;
        }
        self.phase += span * FRACTION;
        let wrap = self.period() * self.count_length();
        if self.phase < wrap {
            return false;
        }
        // Whole periods pass with the old shape once, then with the new one.
        self.phase -= wrap;
        self.shape = self.next;
        self.phase %= self.period() * self.count_length();
        true
    }

    /// When it wraps next.
    fn wraps_at(&self) -> Option<Cycles> {
        let wrap = self.period() * self.count_length();
        self.counts()
            .then(|| self.since + (wrap - self.phase).div_ceil(FRACTION))
    }

    /// The counter.
    fn counter(&self) -> u16 {
        let counts = self.phase / self.count_length();
        let top = u64::from(self.shape.top);
        let counter = if counts > top {
            (2 * top + 1).saturating_sub(counts)
        } else {
            counts
        };
        counter as u16
    }

    fn set_counter(&mut self, counter: u16) {
        self.phase = u64::from(counter.min(self.shape.top)) * self.count_length();
    }
}

/// All slices.
#[derive(Clone, Debug)]
pub struct Pwm {
    slices: [Slice; SLICES],
    wrapped: u32,
    enabled: u32,
    forced: u32,
    /// Slices whose wraps a DMA channel waits for.
    awaited: u32,
    /// Those of them that have wrapped.
    requests: u32,
}

impl Default for Pwm {
    fn default() -> Self {
        Self::new()
    }
}

impl Pwm {
    /// After power-up.
    pub const fn new() -> Self {
        Self {
            slices: [Slice::RESET; SLICES],
            wrapped: 0,
            enabled: 0,
            forced: 0,
            awaited: 0,
            requests: 0,
        }
    }

    /// Resets all slices.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Whether PWM_IRQ_WRAP is up.
    pub fn interrupt(&self) -> bool {
        (self.wrapped & self.enabled) | self.forced != 0
    }

    /// Tells for the wraps of which slices DMA channels wait, a bit each. Others ask for nothing.
    pub fn await_wraps(&mut self, slices: u32) {
        self.awaited = slices & ALL;
        self.requests &= self.awaited;
    }

    /// The slices that have wrapped since, of those that DMA channels wait for.
    pub fn take_wraps(&mut self) -> u32 {
        std::mem::take(&mut self.requests)
    }

    /// The pulses of a pin that is a PWM output: slice and channel by the table of 4.5.2.
    pub fn output(&self, pin: usize) -> Pulses {
        let slice = &self.slices[(pin / 2) % SLICES];
        let channel = pin % 2;
        let period = u32::from(slice.shape.top) + 1;
        let high = if slice.counts() {
            u32::from(slice.shape.compare[channel]).min(period)
        } else {
            // A counter that stands leaves the level as it is.
            let high = slice.counter() < slice.shape.compare[channel];
            u32::from(high) * period
        };
        let inverted = slice.csr & [csr::A_INV, csr::B_INV][channel] != 0;
        Pulses {
            high: if inverted { period - high } else { high },
            period,
        }
    }

    fn enables(&self) -> u32 {
        let bit = |(i, slice): (usize, &Slice)| (slice.csr & csr::EN) << i;
        self.slices.iter().enumerate().map(bit).sum()
    }
}

impl Peripheral for Pwm {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        self.advance(now);
        match offset {
            EN => return self.enables(),
            INTR => return self.wrapped,
            INTE => return self.enabled,
            INTF => return self.forced,
            INTS => return (self.wrapped & self.enabled) | self.forced,
            _ => {}
        }
        let Some(slice) = self.slices.get((offset / STRIDE) as usize) else {
            return 0;
        };
        match offset % STRIDE {
            CSR => slice.csr,
            DIV => slice.div,
            CTR => slice.counter().into(),
            CC => u32::from(slice.next.compare[1]) << 16 | u32::from(slice.next.compare[0]),
            TOP => slice.next.top.into(),
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        let old = self.read(offset, now);
        let value = write.onto(old);
        match offset {
            EN => {
                for (i, slice) in self.slices.iter_mut().enumerate() {
                    slice.csr = slice.csr & !csr::EN | (value >> i & 1);
                }
                return;
            }
            INTR => {
                self.wrapped &= !write.value;
                return;
            }
            INTE => {
                self.enabled = value & ALL;
                return;
            }
            INTF => {
                self.forced = value & ALL;
                return;
            }
            _ => {}
        }
        let Some(slice) = self.slices.get_mut((offset / STRIDE) as usize) else {
            return;
        };
        match offset % STRIDE {
            CSR => {
                slice.csr = value & csr::KEPT;
                // One count on or back; the bits clear themselves.
                if value & csr::PH_ADV != 0 {
                    slice.phase += slice.count_length();
                }
                if value & csr::PH_RET != 0 {
                    slice.phase = slice.phase.saturating_sub(slice.count_length());
                }
            }
            DIV => {
                let counter = slice.counter();
                slice.div = value & 0xfff;
                slice.set_counter(counter);
            }
            CTR => slice.set_counter(value as u16),
            CC => slice.next.compare = [value as u16, (value >> 16) as u16],
            TOP => slice.next.top = value as u16,
            _ => {}
        }
        // A slice that stands has no wrap to wait for.
        slice.settle(now);
    }

    fn next_event(&self) -> Option<Cycles> {
        let wanted = |i: usize, slice: &Slice| {
            let asked_for = self.awaited | self.enabled & !self.wrapped;
            slice.shape != slice.next || asked_for >> i & 1 != 0
        };
        self.slices
            .iter()
            .enumerate()
            .filter(|(i, slice)| wanted(*i, slice))
            .filter_map(|(_, slice)| slice.wraps_at())
            .min()
    }

    fn advance(&mut self, now: Cycles) {
        for (i, slice) in self.slices.iter_mut().enumerate() {
            if slice.settle(now) {
                self.wrapped |= 1 << i;
                self.requests |= self.awaited & 1 << i;
            }
        }
    }
}
