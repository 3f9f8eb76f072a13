//! The coefficients of the fixed-point steps, made from the parameters at compile time.
//!
//! Layer 2 never saturates: |x2| <= s / (epsilon - mu) <= 1 by the maximum principle. So the clamp
//! of layer 1 is the only nonlinearity of eq. 1, and per spatial mode (see [`transform`]) the
//! lattice is
//!
//! ```text
//! a' = -p a + (1 + mu + epsilon) Y - s b        p = 1 + D1 lambda
//! b' = -r b + s Y                               r = epsilon - mu + D2 lambda
//! ```
//!
//! with a and b the modes of x1 and x2, and Y those of y1. For a Y held over a step of length h
//! this has an exact solution, b <- R b + S Y and a <- E a + F Y - H b with
//!
//! ```text
//! R = e^-rh     S = s (1 - R) / r     H = s (e^-ph - R) / (r - p)     F = a* (1 - E) + b* H
//! b* = s / r    a* = (1 + mu + epsilon - s^2 / r) / p                 E = e^-ph
//! ```
//!
//! where a*, b* is the equilibrium per unit of Y. Y is taken at the middle of the step, where the
//! state is extrapolated from the increment of the step before: a + d / 2. Two simplifications:
//!
//! * Of layer 2 only the inhibition H b is ever needed, so that is what is stored.
//! * Where R is small, it is neglected: the inhibition is taken to be b* H times the Y of the step
//!   before, which keeps the equilibrium and, over all, the delay.
//!
//! That leaves two errors, and both are removed by a choice of E. First, the extrapolation makes
//! a growing mode grow a little too slowly. Second, the reference is not eq. 1 itself but its
//! Euler solution with a step of 0.001, in which a mode grows by ln(1 + 0.001 g) / 0.001 a unit of
//! time instead of g. E is fitted so that every unsaturated mode grows by exactly the reference's
//! factor G a step. (There b = S Y / (G - R) and Y = M a with M = 1 + (1 - 1/G) / 2, which leaves
//! an equation linear in E.) A pattern's code depends on which modes win, by fractions of a
//! thousandth, so this matters more than anything else here.
//!
//! [`transform`]: super::transform

use super::parameters::{LatticeError, LatticeParameters};
use super::spectrum::{REFERENCE_STEP, Rates, check, end, rates, squared_length};
use super::transform::mode_indices;
use crate::series::{exp, ln};

/// Fraction bits of cells and outputs: room for +-128.
pub(super) const CELL_BITS: u32 = 24;
/// Fraction bits of modes: room for +-64. A corner of 40 makes a mode of up to 29.2, and twice
/// that plus an increment must fit.
pub(super) const MODE_BITS: u32 = 25;
/// Fraction bits that `feed` has more than `decay`: it is divided by the squared length of the
/// eigenvector, 5.49 to 16.
const FEED_BITS: u32 = 4;
/// Fraction bits that `follow` has more than `decay`: it is H S, and each of them is small.
const FOLLOW_BITS: u32 = 8;
/// Fraction bits that an increment has more than `decay` before it is rounded to a mode's.
pub(super) const SUM_BITS: u32 = MODE_BITS - 16;
/// By how much a product of an output and `feed` is shifted to make an increment.
pub(super) const FEED_SHIFT: u32 = CELL_BITS + FEED_BITS - SUM_BITS;
/// By how much a product of an output and `follow` is shifted to make an inhibition.
pub(super) const FOLLOW_SHIFT: u32 = CELL_BITS + FOLLOW_BITS - SUM_BITS;
/// 17-bit coefficients stay this far below 2^17, so that rounding cannot overflow 32 bits.
const WIDE_LIMIT: f64 = 130_944.0;

/// An R below this is taken for zero: it saves a product, and cost none of 95,000 codes.
const NEGLIGIBLE: f64 = 0.03;

/// What one step does to one mode. `q` is [`StepTable::bits`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ModeStep {
    /// 1 - E, Q(q), 16 bits: how much of a decays.
    pub decay: u32,
    /// F over the squared length of the eigenvector, Q(q + 4), 17 bits: what Y adds to a.
    pub feed: u32,
    /// H S over the squared length of the eigenvector, Q(q + 8), 17 bits: what Y adds to the
    /// inhibition.
    pub follow: u32,
    /// R, Q16, 16 bits: how much of the inhibition stays.
    pub keep: u32,
}

/// The coefficients of one step length.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepTable {
    /// Length of a step in 1/64 of the lattice's time unit; even, so that its middle is one too.
    pub length: u32,
    /// Lattice time, in 1/64, at which the next table takes over.
    pub until: u32,
    /// Fraction bits of `decay`, 17 to 22: as many as the largest coefficient allows. Increments
    /// and inhibitions have [`SUM_BITS`] more.
    pub bits: u32,
    /// The coefficients of each mode.
    pub modes: [ModeStep; 16],
    /// By what inhibitions are multiplied when this table takes over, Q30: H and its format depend
    /// on the length of the step. For the first table, what makes b, in Q30, an inhibition.
    pub inherit: [i64; 16],
}

impl StepTable {
    const ZERO: Self = Self {
        length: 0,
        until: 0,
        bits: 0,
        modes: [ModeStep {
            decay: 0,
            feed: 0,
            follow: 0,
            keep: 0,
        }; 16],
        inherit: [0; 16],
    };
}

/// How the initial state becomes that of a mode. All Q30.
#[derive(Clone, Copy, Debug)]
pub(super) struct ModeStart {
    /// What a corner adds to this mode, up to its sign.
    pub corner: i64,
    /// One over the squared length of the eigenvector.
    pub reciprocal: i64,
    /// The layer-2 state per layer-1 output which a fast mode follows; 0 if it is not fast.
    pub slaved: i64,
}

/// Step lengths, in 1/64 of a time unit, and until when each is used. Each is a multiple of the
/// one before.
///
/// Corners that start far outside [-1, 1] pull their neighbours through the linear range within
/// half a time unit: that needs short steps. Later, states are of order 1 and only the last
/// undecided cells move, over many time units. Over 95,000 starts of seven kinds this schedule
/// disagreed with the reference no more often than steps of 1/32 throughout, at a quarter of their
/// number. Beginning with 1/16 or 1/8 instead costs 0.15 % or 1 % of the codes where one corner is
/// large and the others are not.
const SCHEDULE: [(u32, u32); 4] = [(2, 64), (4, 3 * 64), (8, 12 * 64), (16, u32::MAX)];

/// The lattice of eq. 1, ready to run: nothing but integer tables.
///
/// Made at compile time, so that no floating point is calculated on the board:
///
/// ```
/// use rover_shared::perception::{Corners, Lattice, LatticeParameters, Noise};
/// static LATTICE: Lattice = match Lattice::new(&LatticeParameters::PAPER) {
///     Ok(lattice) => lattice,
///     Err(_) => panic!("the paper's parameters are admissible"),
/// };
///
/// // From four corners, here without noise, to a pattern; and from mirrored corners to its mirror.
/// let one = 1 << Corners::FRACTION_BITS;
/// let code = |corners| LATTICE.settle(&Corners(corners), &Noise::default()).map(|s| s.code);
/// let pattern = code([one, -one, one / 2, 2 * one])?;
/// let mirrored = code([-one, one, 2 * one, one / 2])?;
/// assert_eq!(pattern.picture().to_string(), "##..\n#...\n#..#\n####");
/// assert_eq!(mirrored.picture().to_string(), "..##\n...#\n#..#\n####");
/// # Ok::<(), rover_shared::perception::DidNotSettle>(())
/// ```
#[derive(Clone, Debug)]
pub struct Lattice {
    pub(super) steps: [StepTable; SCHEDULE.len()],
    pub(super) start: [ModeStart; 16],
}

impl Lattice {
    /// Calculates the tables for any parameters that form Turing patterns.
    ///
    /// # Errors
    ///
    /// See [`LatticeError`]: a condition of eq. 2 fails, or the engine could not follow.
    pub const fn new(parameters: &LatticeParameters) -> Result<Self, LatticeError> {
        if let Err(error) = check(parameters) {
            return Err(error);
        }
        let mut steps = [StepTable::ZERO; SCHEDULE.len()];
        let mut table = 0;
        while table < steps.len() {
            let (length, until) = SCHEDULE[table];
            let Some(mut made) = step_table(parameters, length, until) else {
                return Err(LatticeError::CoefficientOutOfRange);
            };
            let mut place = 0;
            while place < 16 {
                let before = if table == 0 {
                    (1u64 << (30 - SUM_BITS)) as f64 // b itself, in Q30
                } else {
                    scaled_inhibition(parameters, place, &steps[table - 1])
                };
                let ratio = scaled_inhibition(parameters, place, &made) / before;
                made.inherit[place] = (ratio * Q30 + 0.5) as i64;
                place += 1;
            }
            steps[table] = made;
            table += 1;
        }
        let mut start = [ModeStart {
            corner: 0,
            reciprocal: 0,
            slaved: 0,
        }; 16];
        let mut place = 0;
        while place < 16 {
            start[place] = mode_start(parameters, place);
            place += 1;
        }
        Ok(Self { steps, start })
    }
}

impl LatticeParameters {
    /// Checks that the lattice forms Turing patterns (eq. 2) and that the fixed-point engine can
    /// follow it.
    ///
    /// # Errors
    ///
    /// The first condition that fails, in the order of [`LatticeError`]'s variants.
    pub const fn validate(&self) -> Result<(), LatticeError> {
        match Lattice::new(self) {
            Ok(_) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// One in the format of the tables that only the set-up uses.
const Q30: f64 = (1u64 << 30) as f64;

/// The rate in continuous time that equals `rate` in the reference's Euler steps.
const fn as_in_reference(rate: f64) -> f64 {
    ln(1.0 + REFERENCE_STEP * rate) / REFERENCE_STEP
}

/// Rounds a coefficient, if it is in [0, `limit`], to `bits` fraction bits.
const fn quantised(value: f64, bits: u32, limit: f64) -> Option<u32> {
    let scaled = value * (1u64 << bits) as f64 + 0.5;
    if scaled >= 0.0 && scaled < limit {
        Some(scaled as u32)
    } else {
        None
    }
}

/// The table of one step length with as many bits as its largest coefficient allows.
const fn step_table(parameters: &LatticeParameters, length: u32, until: u32) -> Option<StepTable> {
    let mut bits = 22;
    // With 16 bits the format of increments is that of modes: fewer would have to shift up.
    while bits > 16 {
        let mut table = StepTable {
            length,
            until,
            bits,
            ..StepTable::ZERO
        };
        if fill(parameters, &mut table) {
            return Some(table);
        }
        bits -= 1;
    }
    None
}

/// Calculates the coefficients of a table; false if one does not fit.
const fn fill(parameters: &LatticeParameters, table: &mut StepTable) -> bool {
    let mut place = 0;
    while place < 16 {
        match mode_step(parameters, place, table) {
            Some(made) => table.modes[place] = made,
            None => return false,
        }
        place += 1;
    }
    true
}

/// H: what b takes from a in a step of `length`.
const fn inhibition(parameters: &LatticeParameters, place: usize, length: u32) -> f64 {
    let Rates { p, r, .. } = rates(parameters, place);
    let (p, r, h) = (-as_in_reference(-p), -as_in_reference(-r), duration(length));
    let difference = r - p;
    if difference.abs() < 1e-6 {
        parameters.s * h * exp(-p * h)
    } else {
        parameters.s * (exp(-p * h) - exp(-r * h)) / difference
    }
}

/// A step length in the lattice's time unit.
const fn duration(length: u32) -> f64 {
    length as f64 / 64.0
}

/// H in the format of a table's inhibitions, but for [`SUM_BITS`].
const fn scaled_inhibition(parameters: &LatticeParameters, place: usize, table: &StepTable) -> f64 {
    inhibition(parameters, place, table.length) * (1u64 << table.bits) as f64
}

/// The coefficients of one mode; `None` if one does not fit.
///
/// The equilibrium decides the last undecided cells, so F follows from the coefficients as
/// rounded, not from those meant.
const fn mode_step(
    parameters: &LatticeParameters,
    place: usize,
    table: &StepTable,
) -> Option<ModeStep> {
    let Rates { p, r, growth } = rates(parameters, place);
    let LatticeParameters { mu, epsilon, s, .. } = *parameters;
    let (h, squared) = (duration(table.length), squared_length(place));
    let follow_bits = table.bits + FOLLOW_BITS;
    let stays = exp(as_in_reference(-r) * h);
    let stays = if stays < NEGLIGIBLE { 0.0 } else { stays };
    let Some(rounded_keep) = quantised(stays, 16, 65_536.0) else {
        return None;
    };
    let keep = rounded_keep as f64 / 65_536.0;
    let follow = inhibition(parameters, place, table.length) * s / r * (1.0 - keep);
    let Some(follow) = quantised(follow / squared, follow_bits, WIDE_LIMIT) else {
        return None;
    };
    // What layer 2 takes at equilibrium, per unit of Y and eigenvector.
    let taken = follow as f64 / (1u64 << follow_bits) as f64 / (1.0 - keep);

    let a_star = (1.0 + mu + epsilon - s * s / r) / p;
    let mut e = exp(as_in_reference(-p) * h);
    // Modes without a real growth rate oscillate and decay.
    if let Some(growth) = growth {
        let factor = exp(as_in_reference(growth) * h);
        // A growing mode is always behind: it takes less.
        let missing = taken * squared * (1.0 - (1.0 - keep) / (factor - keep));
        e = fitted_decay(e, a_star, missing, factor);
    }
    let Some(decay) = quantised(1.0 - e, table.bits, 65_536.0) else {
        return None;
    };
    let feed = a_star * decay as f64 / (1u64 << table.bits) as f64 / squared + taken;
    let Some(feed) = quantised(feed, table.bits + FEED_BITS, WIDE_LIMIT) else {
        return None;
    };
    Some(ModeStep {
        decay,
        feed,
        follow,
        keep: rounded_keep,
    })
}

/// E such that an unsaturated mode grows by `factor` a step; `e` where there is no such E.
const fn fitted_decay(e: f64, a_star: f64, missing: f64, factor: f64) -> f64 {
    // A mode that neither grows nor decays leaves E undetermined.
    if (factor - 1.0).abs() < 1e-5 {
        return e;
    }
    let middle = 1.0 + 0.5 * (1.0 - 1.0 / factor);
    let fitted = (middle * (a_star + missing) - factor) / (middle * a_star - 1.0);
    // A correction of third order in h: a larger one means that the formula is close to 0 / 0.
    if (fitted - e).abs() < 0.02 * (1.0 - e) {
        fitted
    } else {
        e
    }
}

const fn mode_start(parameters: &LatticeParameters, place: usize) -> ModeStart {
    let Rates { r, growth, .. } = rates(parameters, place);
    let (i, j) = mode_indices(place);
    let squared = squared_length(place);
    let corner = end(i) * end(j) / squared;
    // All modes but the uniform one decay within a tenth of a time unit in layer 2: the
    // transient is not followed but integrated out.
    let slaved = match growth {
        Some(growth) if place != 0 => parameters.s / (r + growth),
        _ => 0.0,
    };
    ModeStart {
        corner: (corner * Q30 + 0.5) as i64,
        reciprocal: (Q30 / squared + 0.5) as i64,
        slaved: (slaved * Q30 + 0.5) as i64,
    }
}
