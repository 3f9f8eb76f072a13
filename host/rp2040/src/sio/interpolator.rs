//! The interpolators (RP2040 datasheet 2.3.1.6).

/// Bits of CTRL_LANEx.
mod ctrl {
    pub const SIGNED: u32 = 1 << 15;
    pub const CROSS_INPUT: u32 = 1 << 16;
    pub const CROSS_RESULT: u32 = 1 << 17;
    pub const ADD_RAW: u32 = 1 << 18;
    pub const FORCE_MSB_SHIFT: u32 = 19;
    /// Lane 0 of interpolator 0.
    pub const BLEND: u32 = 1 << 21;
    /// Lane 0 of interpolator 1.
    pub const CLAMP: u32 = 1 << 22;
    pub const OVERF0: u32 = 1 << 23;
    pub const OVERF1: u32 = 1 << 24;
    pub const OVERF: u32 = 1 << 25;
    /// What both lanes have.
    pub const COMMON: u32 = (1 << 21) - 1;
}

/// Bits of ACCUMx_ADD.
const ADD_MASK: u32 = 0x00ff_ffff;

/// Which of the two it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// INTERP0, which can blend.
    Blending,
    /// INTERP1, which can clamp.
    Clamping,
}

/// An interpolator.
#[derive(Clone, Debug)]
pub(super) struct Interpolator {
    kind: Kind,
    accumulators: [u32; 2],
    bases: [u32; 3],
    ctrl: [u32; 2],
}

/// Results of both lanes.
struct Results {
    lanes: [u32; 2],
    full: u32,
}

impl Interpolator {
    pub const fn new(kind: Kind) -> Self {
        Self {
            kind,
            accumulators: [0; 2],
            bases: [0; 3],
            ctrl: [0; 2],
        }
    }

    fn input(&self, lane: usize) -> u32 {
        let crossed = self.ctrl[lane] & ctrl::CROSS_INPUT != 0;
        self.accumulators[if crossed { 1 - lane } else { lane }]
    }

    /// The accumulator after right shift, mask and sign extension, and whether bits above the mask
    /// were lost.
    fn shifted_and_masked(&self, lane: usize) -> (u32, bool) {
        let ctrl = self.ctrl[lane];
        let (low, high) = (ctrl >> 5 & 31, ctrl >> 10 & 31);
        let shifted = self.input(lane) >> (ctrl & 31);
        let up_to_high = u32::MAX >> (31 - high);
        let masked = shifted & up_to_high & u32::MAX << low;
        let negative = ctrl & ctrl::SIGNED != 0 && masked >> high & 1 != 0;
        let extended = if negative {
            masked | !up_to_high
        } else {
            masked
        };
        (extended, shifted & !up_to_high != 0)
    }

    fn is_set(&self, lane: usize, bit: u32) -> bool {
        self.ctrl[lane] & bit != 0
    }

    fn results(&self) -> Results {
        let values = [0, 1].map(|lane| self.shifted_and_masked(lane).0);
        let added = [0, 1].map(|lane| {
            if self.is_set(lane, ctrl::ADD_RAW) {
                self.input(lane)
            } else {
                values[lane]
            }
        });
        let mut lanes = [0, 1].map(|lane| self.bases[lane].wrapping_add(added[lane]));
        let mut full = self.bases[2]
            .wrapping_add(values[0])
            .wrapping_add(values[1]);
        match self.kind {
            Kind::Blending if self.is_set(0, ctrl::BLEND) => {
                let alpha = values[1] & 0xff;
                lanes = [alpha, self.blend(alpha)];
                full = self.bases[2].wrapping_add(values[0]);
            }
            Kind::Clamping if self.is_set(0, ctrl::CLAMP) => lanes[0] = self.clamp(values[0]),
            _ => {}
        }
        Results { lanes, full }
    }

    /// From BASE0 to BASE1, by 256ths.
    fn blend(&self, alpha: u32) -> u32 {
        let signed = self.is_set(1, ctrl::SIGNED);
        let widen = |base: u32| {
            if signed {
                i64::from(base as i32)
            } else {
                i64::from(base)
            }
        };
        let (from, to) = (widen(self.bases[0]), widen(self.bases[1]));
        (from + ((i64::from(alpha) * (to - from)) >> 8)) as u32
    }

    /// Between BASE0 and BASE1.
    fn clamp(&self, value: u32) -> u32 {
        let [low, high, _] = self.bases;
        if self.is_set(0, ctrl::SIGNED) {
            (value as i32).max(low as i32).min(high as i32) as u32
        } else {
            value.max(low).min(high)
        }
    }

    /// What the processor reads of a lane's result.
    fn presented(&self, lane: usize, result: u32) -> u32 {
        result | (self.ctrl[lane] >> ctrl::FORCE_MSB_SHIFT & 3) << 28
    }

    /// Writes the results back to the accumulators.
    fn pop(&mut self, results: &Results) {
        for lane in 0..2 {
            let crossed = self.is_set(lane, ctrl::CROSS_RESULT);
            self.accumulators[lane] = results.lanes[if crossed { 1 - lane } else { lane }];
        }
    }

    /// Reads the register at this offset from ACCUM0.
    pub fn read(&mut self, offset: u32) -> u32 {
        let results = self.results();
        match offset {
            0x00 | 0x04 => self.accumulators[offset as usize / 4],
            0x08 | 0x0c | 0x10 => self.bases[offset as usize / 4 - 2],
            0x14 | 0x18 => {
                self.pop(&results);
                let lane = offset as usize / 4 - 5;
                self.presented(lane, results.lanes[lane])
            }
            0x1c => {
                self.pop(&results);
                results.full
            }
            0x20 | 0x24 => {
                let lane = offset as usize / 4 - 8;
                self.presented(lane, results.lanes[lane])
            }
            0x28 => results.full,
            0x2c => {
                let [overflow0, overflow1] = [0, 1].map(|lane| self.shifted_and_masked(lane).1);
                let flag = |set: bool, bit| if set { bit } else { 0 };
                self.ctrl[0]
                    | flag(overflow0, ctrl::OVERF0)
                    | flag(overflow1, ctrl::OVERF1)
                    | flag(overflow0 || overflow1, ctrl::OVERF)
            }
            0x30 => self.ctrl[1],
            0x34 | 0x38 => self.shifted_and_masked(offset as usize / 4 - 13).0,
            _ => 0,
        }
    }

    /// Writes the register at this offset from ACCUM0.
    pub fn write(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 | 0x04 => self.accumulators[offset as usize / 4] = value,
            0x08 | 0x0c | 0x10 => self.bases[offset as usize / 4 - 2] = value,
            0x2c => {
                let own = match self.kind {
                    Kind::Blending => ctrl::BLEND,
                    Kind::Clamping => ctrl::CLAMP,
                };
                self.ctrl[0] = value & (ctrl::COMMON | own);
            }
            0x30 => self.ctrl[1] = value & ctrl::COMMON,
            0x34 | 0x38 => {
                let accumulator = &mut self.accumulators[offset as usize / 4 - 13];
                *accumulator = accumulator.wrapping_add(value & ADD_MASK);
            }
            // BASE_1AND0: a half each.
            0x3c => {
                for (lane, half) in [value as u16, (value >> 16) as u16].into_iter().enumerate() {
                    self.bases[lane] = if self.is_set(lane, ctrl::SIGNED) {
                        half as i16 as u32
                    } else {
                        u32::from(half)
                    };
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ACCUM0: u32 = 0x00;
    const ACCUM1: u32 = 0x04;
    const BASE0: u32 = 0x08;
    const BASE1: u32 = 0x0c;
    const BASE2: u32 = 0x10;
    const POP_LANE0: u32 = 0x14;
    const PEEK_LANE0: u32 = 0x20;
    const PEEK_LANE1: u32 = 0x24;
    const PEEK_FULL: u32 = 0x28;
    const CTRL0: u32 = 0x2c;
    const CTRL1: u32 = 0x30;
    /// The whole word, unshifted.
    const WHOLE: u32 = 31 << 10;

    fn with(kind: Kind, writes: &[(u32, u32)]) -> Interpolator {
        let mut interpolator = Interpolator::new(kind);
        for &(offset, value) in writes {
            interpolator.write(offset, value);
        }
        interpolator
    }

    #[test]
    fn a_lane_makes_multiplication_tables() {
        // The data sheet's example: add 5 to accumulator 0 with each pop.
        let mut lane = with(Kind::Blending, &[(BASE0, 5), (CTRL0, WHOLE)]);
        let table: Vec<u32> = (0..4).map(|_| lane.read(POP_LANE0)).collect();
        assert_eq!(table, [5, 10, 15, 20]);
    }

    #[test]
    fn lanes_shift_mask_and_extend_the_sign() {
        let mut lane = with(
            Kind::Blending,
            &[(ACCUM0, 0x1234_abcd), (CTRL0, 8 | 4 << 5 | 7 << 10)],
        );
        assert_eq!(lane.read(PEEK_LANE0), 0xa0);
        lane.write(CTRL0, 8 | 4 << 5 | 7 << 10 | ctrl::SIGNED);
        assert_eq!(lane.read(PEEK_LANE0), 0xffff_ffa0);
        assert_eq!(lane.read(0x34), 0xffff_ffa0, "without the base");
        assert_eq!(lane.read(CTRL0) >> 23, 0b101, "bits above the mask");
    }

    #[test]
    fn inputs_and_results_cross() {
        let mut crossed = with(
            Kind::Blending,
            &[
                (ACCUM0, 1),
                (ACCUM1, 10),
                (BASE0, 100),
                (BASE1, 1_000),
                (BASE2, 7),
                (CTRL0, WHOLE | ctrl::CROSS_INPUT | ctrl::CROSS_RESULT),
                (CTRL1, WHOLE | ctrl::CROSS_RESULT),
            ],
        );
        assert_eq!(crossed.read(PEEK_FULL), 27);
        assert_eq!(crossed.read(POP_LANE0), 110);
        assert_eq!((crossed.read(ACCUM0), crossed.read(ACCUM1)), (1_010, 110));
    }

    #[test]
    fn interpolator_0_blends() {
        let mut blend = with(
            Kind::Blending,
            &[
                (BASE0, 500),
                (BASE1, 1_000),
                (ACCUM1, 0x1_0080),
                (CTRL0, ctrl::BLEND),
                (CTRL1, WHOLE),
            ],
        );
        assert_eq!(blend.read(PEEK_LANE1), 750);
        assert_eq!(blend.read(PEEK_LANE0), 0x80);
        blend.write(CTRL1, WHOLE | ctrl::SIGNED);
        blend.write(0x3c, 1_000 << 16 | 0xfc18);
        // Lane 0 is not signed: its base is not extended.
        assert_eq!(blend.read(BASE0), 0xfc18);
        blend.write(BASE0, -1_000i32 as u32);
        assert_eq!(blend.read(PEEK_LANE1), 0);
    }

    #[test]
    fn interpolator_1_clamps() {
        let mut clamp = with(
            Kind::Clamping,
            &[
                (CTRL0, WHOLE | ctrl::SIGNED | ctrl::CLAMP),
                (BASE0, -10i32 as u32),
                (BASE1, 20),
            ],
        );
        for (value, clamped) in [(-1_000, -10), (-10, -10), (3, 3), (1_000, 20)] {
            clamp.write(ACCUM0, value as u32);
            assert_eq!(clamp.read(PEEK_LANE0) as i32, clamped);
        }
        assert_eq!(clamp.read(CTRL0) & ctrl::BLEND, 0, "it cannot blend");
    }

    #[test]
    fn accumulators_take_sums_and_forced_bits_are_only_shown() {
        let mut lane = with(
            Kind::Clamping,
            &[(CTRL0, WHOLE | 2 << ctrl::FORCE_MSB_SHIFT)],
        );
        lane.write(0x34, 0xff00_0005);
        lane.write(0x34, 6);
        assert_eq!(lane.read(ACCUM0), 11);
        assert_eq!(lane.read(PEEK_LANE0), 0x2000_000b);
        lane.read(POP_LANE0);
        assert_eq!(lane.read(ACCUM0), 11);
    }
}
