//! The analogue-to-digital converter (RP2040 datasheet 4.9).
//!
//! A conversion takes 96 cycles of the converter's own 48 MHz clock, 2 us. What is converted are
//! counts that [`Adc::set_input`] puts on the five channels; the input counts at the end of the
//! conversion. Where the datasheet is silent: the converter is ready as soon as it is enabled, the
//! first conversion of START_MANY begins at once (the divider is reset then, as it is by a write to
//! DIV), and START_ONCE is ignored while a conversion runs.

use std::collections::VecDeque;

use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral, Write, flag};

#[cfg(test)]
mod tests;

/// Channels: GPIO 26 to 29 and the temperature sensor.
pub const CHANNELS: usize = 5;
/// The channel of the temperature sensor.
pub const TEMPERATURE: usize = 4;
/// The largest count.
pub const FULL_SCALE: u16 = 0xfff;
/// Its interrupt line, ADC_IRQ_FIFO.
pub const IRQ: u32 = 22;

/// 27 degrees: 0.706 V of 3.3 V (4.9.5).
const ROOM_TEMPERATURE: u16 = 876;
/// Results that the FIFO holds.
const FIFO_DEPTH: usize = 4;
/// Cycles of the converter's clock in a microsecond.
const CLOCKS_PER_MICROSECOND: u64 = 48;
/// Cycles of the converter's clock that a conversion takes.
const CONVERSION_CLOCKS: u64 = 96;
/// The same in cycles of the system clock.
const CONVERSION: Cycles = CONVERSION_CLOCKS * CYCLES_PER_MICROSECOND / CLOCKS_PER_MICROSECOND;

/// Codes that are far too wide (erratum RP2040-E11).
const WIDE_CODES: [u16; 4] = [512, 1536, 2560, 3584];
/// How far a wide code reaches to either side. They were measured to be 9.9 counts wide
/// (pico-adc.markomo.me: a differential nonlinearity of 8.9); how that shifts the codes between
/// them is not modelled.
const WIDE_CODE_REACH: u16 = 4;

const CS: u32 = 0x00;
const RESULT: u32 = 0x04;
const FCS: u32 = 0x08;
const FIFO: u32 = 0x0c;
const DIV: u32 = 0x10;
const INTR: u32 = 0x14;
const INTE: u32 = 0x18;
const INTF: u32 = 0x1c;
const INTS: u32 = 0x20;

/// Bits of CS.
mod cs {
    pub const EN: u32 = 1 << 0;
    pub const TS_EN: u32 = 1 << 1;
    pub const START_ONCE: u32 = 1 << 2;
    pub const START_MANY: u32 = 1 << 3;
    pub const READY: u32 = 1 << 8;
    pub const ERR: u32 = 1 << 9;
    pub const ERR_STICKY: u32 = 1 << 10;
    pub const AINSEL_SHIFT: u32 = 12;
    pub const AINSEL: u32 = 7 << AINSEL_SHIFT;
    pub const RROBIN_SHIFT: u32 = 16;
    pub const RROBIN: u32 = 0x1f << RROBIN_SHIFT;
    /// What stays as it is written.
    pub const STORED: u32 = EN | TS_EN | START_MANY | AINSEL | RROBIN;
}

/// Bits of FCS.
mod fcs {
    pub const EN: u32 = 1 << 0;
    pub const SHIFT: u32 = 1 << 1;
    pub const ERR: u32 = 1 << 2;
    pub const DREQ_EN: u32 = 1 << 3;
    pub const EMPTY: u32 = 1 << 8;
    pub const FULL: u32 = 1 << 9;
    pub const UNDER: u32 = 1 << 10;
    pub const OVER: u32 = 1 << 11;
    pub const LEVEL_SHIFT: u32 = 16;
    pub const THRESH_SHIFT: u32 = 24;
    /// What stays as it is written.
    pub const STORED: u32 = EN | SHIFT | ERR | DREQ_EN | 0xf << THRESH_SHIFT;
}

/// Bit of a result in the FIFO whose conversion failed.
const FIFO_ERR: u16 = 1 << 15;

/// The converter.
#[derive(Clone, Debug)]
pub struct Adc {
    /// CS, as far as it is stored.
    cs: u32,
    err: bool,
    err_sticky: bool,
    result: u16,
    /// FCS, as far as it is stored.
    fcs: u32,
    overflowed: bool,
    underflowed: bool,
    fifo: VecDeque<u16>,
    div: u32,
    inte: bool,
    intf: bool,
    /// When the running conversion ends.
    conversion: Option<Cycles>,
    pace: Pace,
    inputs: [u16; CHANNELS],
    failing: bool,
    wide_codes: bool,
}

/// The moments at which START_MANY starts conversions.
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// When the divider was reset.
    origin: Cycles,
    /// Conversions started since.
    count: u64,
}

impl Pace {
    /// When the next conversion starts. The period is whole cycles of the converter's clock, some
    /// shorter, some longer: they make up the fraction on average.
    fn next(self, div: u32) -> Cycles {
        // 1 + INT + FRAC / 256, in 256ths; shorter than a conversion means back to back.
        let period = u64::from(div + 0x100).max(CONVERSION_CLOCKS << 8);
        let clocks = (self.count * period) >> 8;
        self.origin + (clocks * CYCLES_PER_MICROSECOND).div_ceil(CLOCKS_PER_MICROSECOND)
    }
}

impl Default for Adc {
    fn default() -> Self {
        Self::new()
    }
}

impl Adc {
    /// A converter after power-up: inputs at 0 V, the temperature sensor at 27 degrees.
    pub fn new() -> Self {
        let mut inputs = [0; CHANNELS];
        inputs[TEMPERATURE] = ROOM_TEMPERATURE;
        Self {
            cs: 0,
            err: false,
            err_sticky: false,
            result: 0,
            fcs: 0,
            overflowed: false,
            underflowed: false,
            fifo: VecDeque::with_capacity(FIFO_DEPTH),
            div: 0,
            inte: false,
            intf: false,
            conversion: None,
            pace: Pace::default(),
            inputs,
            failing: false,
            wide_codes: false,
        }
    }

    /// Resets the registers; what is connected outside stays as it is.
    pub fn reset(&mut self) {
        *self = Self {
            inputs: self.inputs,
            failing: self.failing,
            wide_codes: self.wide_codes,
            ..Self::new()
        };
    }

    /// Puts a voltage on a channel, in counts of 0 to [`FULL_SCALE`]; more is full scale.
    ///
    /// # Panics
    /// There is no such channel.
    pub fn set_input(&mut self, channel: usize, counts: u16) {
        self.inputs[channel] = counts.min(FULL_SCALE);
    }

    /// Lets conversions fail from now on (CS.ERR), or succeed again.
    pub fn set_failing(&mut self, failing: bool) {
        self.failing = failing;
    }

    /// Models the spikes in the differential nonlinearity (erratum RP2040-E11), or an ideal
    /// converter, which is the default.
    pub fn set_wide_codes(&mut self, wide: bool) {
        self.wide_codes = wide;
    }

    /// The level of its interrupt line.
    pub fn line(&self) -> bool {
        self.intf || self.inte && self.reached_threshold()
    }

    /// Whether the DMA controller is asked for a transfer.
    pub fn dma_request(&self) -> bool {
        self.fcs & fcs::DREQ_EN != 0 && self.reached_threshold()
    }

    fn reached_threshold(&self) -> bool {
        self.fifo.len() as u32 >= self.fcs >> fcs::THRESH_SHIFT
    }

    fn enabled(&self, bit: u32) -> bool {
        self.cs & bit != 0
    }

    fn channel(&self) -> usize {
        ((self.cs & cs::AINSEL) >> cs::AINSEL_SHIFT) as usize
    }

    /// Resets the divider.
    fn restart(&mut self, now: Cycles) {
        self.pace = Pace {
            origin: self.conversion.map_or(now, |end| end.max(now)),
            count: 0,
        };
    }

    fn finish(&mut self) {
        self.conversion = None;
        let channel = self.channel();
        let counts = match self.inputs.get(channel) {
            Some(_) if channel == TEMPERATURE && !self.enabled(cs::TS_EN) => 0,
            Some(&counts) if self.wide_codes => through_wide_codes(counts),
            Some(&counts) => counts,
            None => 0,
        };
        self.result = counts;
        self.err = self.failing;
        self.err_sticky |= self.failing;
        if self.fcs & fcs::EN != 0 {
            self.push(counts);
        }
        self.select_next_channel(channel);
    }

    fn push(&mut self, counts: u16) {
        if self.fifo.len() == FIFO_DEPTH {
            self.overflowed = true;
            return;
        }
        let shift = if self.fcs & fcs::SHIFT != 0 { 4 } else { 0 };
        let failed = self.err && self.fcs & fcs::ERR != 0;
        let error = if failed { FIFO_ERR } else { 0 };
        self.fifo.push_back(counts >> shift | error);
    }

    /// The next higher channel of RROBIN, or its lowest.
    fn select_next_channel(&mut self, channel: usize) {
        let mask = (self.cs & cs::RROBIN) >> cs::RROBIN_SHIFT;
        if mask == 0 {
            return;
        }
        let higher = mask & (!1 << channel);
        let next = if higher == 0 { mask } else { higher }.trailing_zeros();
        self.cs = self.cs & !cs::AINSEL | next << cs::AINSEL_SHIFT;
    }

    fn write_cs(&mut self, write: Write, now: Cycles) {
        let new = write.onto(self.cs);
        let before = self.cs;
        self.cs = new & cs::STORED;
        if write.value & cs::ERR_STICKY != 0 {
            self.err_sticky = false;
        }
        if !self.enabled(cs::EN) {
            self.conversion = None;
            return;
        }
        if self.cs & !before & (cs::START_MANY | cs::EN) != 0 {
            self.restart(now);
        }
        let once = new & cs::START_ONCE != 0 && !self.enabled(cs::START_MANY);
        if once && self.conversion.is_none() {
            self.conversion = Some(now + CONVERSION);
        }
    }

    fn write_fcs(&mut self, write: Write) {
        self.fcs = write.onto(self.fcs) & fcs::STORED;
        self.underflowed &= write.value & fcs::UNDER == 0;
        self.overflowed &= write.value & fcs::OVER == 0;
    }

    fn read_cs(&self) -> u32 {
        let ready = self.enabled(cs::EN) && self.conversion.is_none();
        self.cs
            | flag(ready, cs::READY)
            | flag(self.err, cs::ERR)
            | flag(self.err_sticky, cs::ERR_STICKY)
    }

    fn read_fcs(&self) -> u32 {
        self.fcs
            | flag(self.fifo.is_empty(), fcs::EMPTY)
            | flag(self.fifo.len() == FIFO_DEPTH, fcs::FULL)
            | flag(self.underflowed, fcs::UNDER)
            | flag(self.overflowed, fcs::OVER)
            | (self.fifo.len() as u32) << fcs::LEVEL_SHIFT
    }

    fn pop(&mut self) -> u32 {
        let result = self.fifo.pop_front();
        self.underflowed |= result.is_none();
        result.unwrap_or(0).into()
    }
}

fn through_wide_codes(counts: u16) -> u16 {
    let wide = WIDE_CODES.iter().copied();
    wide.into_iter()
        .find(|code| code.abs_diff(counts) <= WIDE_CODE_REACH)
        .unwrap_or(counts)
}

impl Peripheral for Adc {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        self.advance(now);
        match offset {
            CS => self.read_cs(),
            RESULT => self.result.into(),
            FCS => self.read_fcs(),
            FIFO => self.pop(),
            DIV => self.div,
            INTR => self.reached_threshold().into(),
            INTE => self.inte.into(),
            INTF => self.intf.into(),
            INTS => self.line().into(),
            _ => 0,
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        self.advance(now);
        match offset {
            CS => self.write_cs(write, now),
            FCS => self.write_fcs(write),
            DIV => {
                self.div = write.onto(self.div) & 0xff_ffff;
                self.restart(now);
            }
            INTE => self.inte = write.onto(self.inte.into()) & 1 != 0,
            INTF => self.intf = write.onto(self.intf.into()) & 1 != 0,
            _ => {}
        }
    }

    fn next_event(&self) -> Option<Cycles> {
        let many = self.enabled(cs::EN) && self.enabled(cs::START_MANY);
        let start = many.then(|| self.pace.next(self.div));
        self.conversion.or(start)
    }

    fn advance(&mut self, now: Cycles) {
        while let Some(due) = self.next_event().filter(|&due| due <= now) {
            if self.conversion.is_some() {
                self.finish();
            } else {
                self.pace.count += 1;
                self.conversion = Some(due + CONVERSION);
            }
        }
    }
}
