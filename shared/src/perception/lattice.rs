//! The run of the lattice from its initial state to a Turing pattern, in 32-bit fixed point.
//!
//! # When to stop
//!
//! The paper's percept is complete when every |x1| > 1. The engine stops at the first time this
//! is so, and no code can change after that:
//!
//! Let sigma be the signs of x1, l = min(|x1|, 1), G = (epsilon - mu - D2 L)^-1 with the zero-flux
//! Laplacian L, and E the largest deviation of x2 from s G y1 in any cell. G and exp(-t G^-1) have
//! no negative elements, so as long as y1 stays between sigma l and sigma, x2 stays within
//! s G rho + E of s G ybar, where ybar = sigma (1 + l) / 2 and rho = (1 - l) / 2. Nor can any |x1|
//! exceed an upper bound u, which follows in the same way from the largest inflow. A cell at the
//! edge of this box, sigma x1 = l, is driven outwards if
//!
//! ```text
//! (mu + epsilon) l - s (sigma s G ybar + s G rho + E) + D1 (sum over like neighbours (l_n - l)
//!     - sum over opposite neighbours (u_n + l)) > 0
//! ```
//!
//! and if this holds for every cell, no state ever leaves the box: no sign changes again. It held
//! in every run when all cells were saturated for the first time, which the fidelity test repeats.
//! (It holds a fifth of the time earlier, but costs as much as some steps.)

use core::fmt;

use serde::{Deserialize, Serialize};

use super::fixed_point::{halved, product, rounded, scale};
use super::pattern::PatternCode;
use super::tables::{
    CELL_BITS, FEED_SHIFT, FOLLOW_SHIFT, Lattice, MODE_BITS, ModeStep, SUM_BITS, StepTable,
};
use super::transform::{Layer, forward, inverse, parities, parity};
use crate::random::Generator;

/// Time limit: 200 time units, twice the paper's 100. All starts from sensed corners settle
/// by 90; one in some thousands from all-zero corners takes longer than 100.
pub const MAX_TIME: SettleTime = SettleTime(200 * SettleTime::PER_UNIT);

/// The initial states of the four corner cells of layer 1, Q20 (raw / 2^20), in the order front
/// (upper left), left (upper right), right (lower left), target (lower right). Fig. 2b.
///
/// Values beyond +-[`Corners::MAX`] count as +-`MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Corners(pub [i32; 4]);

impl Corners {
    /// Fraction bits of a corner.
    pub const FRACTION_BITS: u32 = 20;
    /// The largest magnitude: 40. Unbounded staircases reach 5 to 40; beyond 43 the modes would
    /// leave their 32 bits.
    pub const MAX: i32 = 40 << Self::FRACTION_BITS;
    /// The cells that the corners set, in their order.
    pub const CELLS: [usize; 4] = [0, 3, 12, 15];
}

/// The initial states of layer 2, Q26 (raw / 2^26), row by row from the upper left.
///
/// Values beyond +-[`Noise::MAX`] count as +-`MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Noise(pub [i32; 16]);

impl Noise {
    /// Fraction bits of a state.
    pub const FRACTION_BITS: u32 = 26;
    /// The paper's range: uniform in +-0.005 (II-B).
    pub const AMPLITUDE: i32 = 335_544;
    /// The largest magnitude: 1/16, so that the sums of 16 have room for four more fraction bits.
    pub const MAX: i32 = 1 << (Self::FRACTION_BITS - 4);

    /// Draws a new initial state from the paper's range.
    pub fn draw(rng: &mut Generator) -> Self {
        Self(core::array::from_fn(|_| {
            rng.symmetric(Self::AMPLITUDE.unsigned_abs())
        }))
    }
}

/// Time in the lattice (the t of eq. 1, no physical time) in 1/64 of its unit.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct SettleTime(pub u32);

impl SettleTime {
    /// Raw units in one time unit of the lattice, which is 1,000 Euler steps of the paper's.
    pub const PER_UNIT: u32 = 64;

    /// Thousandths of the lattice's time unit: the number of Euler steps the paper would take.
    pub const fn thousandths(self) -> u64 {
        self.0 as u64 * 1000 / Self::PER_UNIT as u64
    }
}

impl fmt::Display for SettleTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let thousandths = self.thousandths();
        write!(f, "{}.{:03}", thousandths / 1000, thousandths % 1000)
    }
}

/// A percept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settled {
    /// The pattern the lattice settled into.
    pub code: PatternCode,
    /// When all cells of layer 1 had saturated.
    pub time: SettleTime,
}

/// The lattice had not settled into a pattern by [`MAX_TIME`]: only near exact separatrices, such
/// as all-zero corners with zero noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DidNotSettle {
    /// The signs of layer 1 at that time, which are no percept.
    pub code: PatternCode,
    /// The number of steps taken.
    pub steps: u32,
}

impl fmt::Display for DidNotSettle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the lattice did not settle in {} steps", self.steps)
    }
}

impl core::error::Error for DidNotSettle {}

impl Lattice {
    /// Runs the lattice from `corners` and `noise` until every cell of layer 1 has saturated.
    ///
    /// # Errors
    ///
    /// [`DidNotSettle`] if that is not so by [`MAX_TIME`].
    pub fn settle(&self, corners: &Corners, noise: &Noise) -> Result<Settled, DidNotSettle> {
        self.run(corners, noise, |_, _| {})
    }

    /// As [`settle`](Self::settle), and shows `observer` the states of layer 1 once a step: the
    /// time, and x1 of the 16 cells in Q20, row by row.
    ///
    /// # Errors
    ///
    /// [`DidNotSettle`] if not every cell has saturated by [`MAX_TIME`].
    pub fn settle_observed(
        &self,
        corners: &Corners,
        noise: &Noise,
        observer: &mut impl FnMut(SettleTime, &[i32; 16]),
    ) -> Result<Settled, DidNotSettle> {
        self.run(corners, noise, |time, state| {
            observer(time, &state.observable())
        })
    }

    #[inline(always)]
    fn run(
        &self,
        corners: &Corners,
        noise: &Noise,
        mut observer: impl FnMut(SettleTime, &State),
    ) -> Result<Settled, DidNotSettle> {
        let mut state = State::new(self, corners, noise);
        let (mut time, mut steps) = (0, 0);
        let mut length = self.steps[0].length;
        for table in &self.steps {
            if table.length > length {
                state.lengthen_steps(table, table.length / length);
                length = table.length;
            }
            while time < table.until {
                state.sum_modes();
                let now = SettleTime(time + length / 2);
                observer(now, &state);
                if state.clamp() {
                    let code = PatternCode::of_signs(&state.middle);
                    return Ok(Settled { code, time: now });
                }
                if time >= MAX_TIME.0 {
                    let code = PatternCode::of_signs(&state.middle);
                    return Err(DidNotSettle { code, steps });
                }
                forward(&mut state.middle);
                state.advance(table.bits);
                time += length;
                steps += 1;
            }
        }
        // Not reached: the last table has no end.
        Err(DidNotSettle {
            code: PatternCode::default(),
            steps,
        })
    }
}

/// Fraction bits gained while all |x1| < 1/16: from all-zero corners the modes start at some
/// 10^-4, and the first increments would drown in rounding.
const GAIN_BITS: u32 = 4;

/// One in the format of cells.
const ONE: i32 = 1 << CELL_BITS;

/// The state between two steps. While the gain is on, all of it is scaled by 2^[`GAIN_BITS`].
struct State {
    /// Both layers, mode by mode.
    modes: [Mode; 16],
    /// The middle of the next step, Q24: in turn modes of x1, its cells, the outputs, and modes
    /// of the outputs.
    middle: Layer,
    /// Where outputs saturate, Q24: `ONE`, or that much more while the gain is on.
    limit: i32,
}

/// The state of one mode, and what a step does to it: side by side, so that the board needs few
/// addresses.
#[derive(Clone, Copy)]
struct Mode {
    /// The mode of x1, Q25.
    a: i32,
    /// What the mode of x2 will take from it in the next step, in the table's format.
    inhibition: i32,
    step: ModeStep,
}

impl State {
    fn new(lattice: &Lattice, corners: &Corners, noise: &Noise) -> Self {
        let corners = corners
            .0
            .map(|corner| corner.clamp(-Corners::MAX, Corners::MAX));
        let mut noise = noise
            .0
            .map(|state| state.clamp(-Noise::MAX, Noise::MAX) << (30 - Noise::FRACTION_BITS));
        let small = corners
            .iter()
            .all(|corner| corner.abs() < 1 << (Corners::FRACTION_BITS - GAIN_BITS));
        let gain = if small { GAIN_BITS } else { 0 };

        let one = 1 << Corners::FRACTION_BITS;
        let inputs = parities(corners);
        let outputs = parities(corners.map(|corner| corner.clamp(-one, one)));
        forward(&mut noise);
        let first = &lattice.steps[0];
        let mut modes = first.modes.map(|step| Mode {
            a: 0,
            inhibition: 0,
            step,
        });
        for (place, start) in lattice.start.iter().enumerate() {
            // All Q30.
            let of_corner = |sum: i32| product(sum.into(), start.corner, Corners::FRACTION_BITS);
            let x1 = of_corner(inputs[parity(place)]);
            let y1 = of_corner(outputs[parity(place)]);
            let x2 = product(noise[place].into(), start.reciprocal, 30);
            // What a fast mode of layer 2 still takes from layer 1 before it follows the output.
            let (x1, x2) = if start.slaved == 0 {
                (x1, x2)
            } else {
                let followed = product(y1, start.slaved, 30);
                (x1 - product(x2 - followed, start.slaved, 30), followed)
            };
            modes[place].a = rounded(x1, 30 - MODE_BITS - gain) as i32;
            modes[place].inhibition = product(x2, first.inherit[place], 30 - gain) as i32;
        }
        let mut state = Self {
            modes,
            middle: modes.map(|mode| halved(mode.a, MODE_BITS - CELL_BITS)),
            limit: ONE << gain,
        };
        // There is no step before the first: a trial step finds the first one's middle.
        state.sum_modes();
        state.clamp();
        forward(&mut state.middle);
        state.advance(first.bits);
        let trial = core::mem::replace(&mut state.modes, modes);
        for (middle, (trial, mode)) in state.middle.iter_mut().zip(trial.iter().zip(&modes)) {
            *middle = halved(trial.a + mode.a, MODE_BITS - CELL_BITS + 1);
        }
        state
    }

    /// Turns the middle's modes into cells. Ends the gain when it is not needed any more.
    #[inline(always)]
    fn sum_modes(&mut self) {
        inverse(&mut self.middle);
        if self.limit != ONE && self.middle.iter().any(|cell| cell.abs() >= ONE) {
            for (mode, middle) in self.modes.iter_mut().zip(&mut self.middle) {
                mode.a = halved(mode.a, GAIN_BITS);
                mode.inhibition = halved(mode.inhibition, GAIN_BITS);
                *middle = halved(*middle, GAIN_BITS);
            }
            self.limit = ONE;
        }
    }

    /// Turns the middle's cells into outputs; true if all of them are saturated.
    #[inline(always)]
    fn clamp(&mut self) -> bool {
        let limit = self.limit;
        let mut saturated = true;
        for cell in &mut self.middle {
            if *cell > limit {
                *cell = limit;
            } else if *cell < -limit {
                *cell = -limit;
            } else {
                saturated = false;
            }
        }
        saturated
    }

    /// Executes the step whose middle has these modes of outputs, and extrapolates to the middle of
    /// the next. `bits` are those of the table.
    #[inline(never)]
    fn advance(&mut self, bits: u32) {
        let shift = bits + SUM_BITS - MODE_BITS;
        for (mode, middle) in self.modes.iter_mut().zip(&mut self.middle) {
            let (y, step) = (*middle, mode.step);
            let sum = scale::<15, FEED_SHIFT>(y, step.feed)
                - scale::<16, 16>(mode.a, step.decay)
                - mode.inhibition;
            let mut inhibition = scale::<15, FOLLOW_SHIFT>(y, step.follow);
            if step.keep != 0 {
                inhibition += scale::<16, 16>(mode.inhibition, step.keep);
            }
            mode.inhibition = inhibition;
            let increment = halved(sum, shift);
            mode.a += increment;
            *middle = halved(2 * mode.a + increment, MODE_BITS - CELL_BITS + 1);
        }
    }

    /// Switches to a table whose steps are longer by `factor`: their middle is further away and
    /// their inhibition differs.
    fn lengthen_steps(&mut self, table: &StepTable, factor: u32) {
        let coefficients = table.modes.iter().zip(&table.inherit);
        let modes = self.modes.iter_mut().zip(&mut self.middle);
        for ((mode, middle), (&step, &inherit)) in modes.zip(coefficients) {
            let a = halved(mode.a, MODE_BITS - CELL_BITS);
            *middle = a + (*middle - a) * factor as i32;
            mode.inhibition = product(mode.inhibition.into(), inherit, 30) as i32;
            mode.step = step;
        }
    }

    /// The middle's cells in the format shown to observers.
    fn observable(&self) -> [i32; 16] {
        let gain = if self.limit == ONE { 0 } else { GAIN_BITS };
        self.middle
            .map(|cell| cell >> (CELL_BITS - Corners::FRACTION_BITS + gain))
    }
}
