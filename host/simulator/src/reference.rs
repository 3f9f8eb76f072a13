//! The paper's lattice taken literally: eq. 1 in f64, integrated by Euler's method.
//!
//! This is the oracle by which the fixed-point engine is judged; nothing in the robot uses it.
//! With L the five-point Laplacian whose missing neighbours mirror the cell itself (zero flux),
//!
//! ```text
//! x1' = -x1 + (1 + mu + epsilon) y1 - s y2 + D1 L x1
//! x2' = -x2 + s y1 + (1 + mu - epsilon) y2 + D2 L x2        y = (|x + 1| - |x - 1|) / 2
//! ```
//!
//! both layers are advanced N = 100,000 times by dt = 0.001 (II-B).
//!
//! [`Reference::run`] does just that. [`Reference::codes`] gives the same codes for many starts in
//! a tenth of the time: several runs side by side, each of them stopped when it is proved that no
//! sign of layer 1 can change any more.

mod lanes;
mod state;

pub use state::{CHECK_INTERVAL, LatticeState, Layer, STEP, STEPS};

use rover_shared::perception::{LatticeParameters, PatternCode};

use lanes::Lanes;
use state::{NEIGHBOURS, output};

/// What the reference ends in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePattern {
    /// The signs of layer 1 at the end.
    pub code: PatternCode,
    /// The lattice time at which every cell of layer 1 was saturated for the first time.
    pub settle_time: Option<f64>,
    /// Whether every cell of layer 1 is saturated at the end.
    pub saturated: bool,
    /// Both layers at the end.
    pub state: LatticeState,
}

/// The lattice of eq. 1 in f64.
#[derive(Clone, Debug)]
pub struct Reference {
    parameters: LatticeParameters,
    /// (epsilon - mu - D2 L)^-1: the layer 2 that a constant output of layer 1 leads to is s
    /// times this. `None` if the parameters are outside what the proof of a final code needs.
    response: Option<Box<[Layer; 16]>>,
}

impl Reference {
    /// The lattice with these parameters, which are not checked: a reference may show what bad
    /// ones do.
    pub fn new(parameters: LatticeParameters) -> Self {
        let response = parameters.validate().is_ok().then(|| response(&parameters));
        Self {
            parameters,
            response,
        }
    }

    /// Runs all [`STEPS`] steps from the initial states of corners and layer 2.
    pub fn settle(&self, corners: [f64; 4], noise: Layer) -> ReferencePattern {
        self.run(LatticeState::initial(corners, noise))
    }

    /// Runs all [`STEPS`] steps from `state`.
    pub fn run(&self, mut state: LatticeState) -> ReferencePattern {
        let mut settle_time = None;
        for step in 1..=STEPS {
            self.advance(&mut state);
            if settle_time.is_none() && state.is_saturated() {
                settle_time = Some(f64::from(step) * STEP);
            }
        }
        ReferencePattern {
            code: state.code(),
            settle_time,
            saturated: state.is_saturated(),
            state,
        }
    }

    /// One step of Euler's method.
    fn advance(&self, state: &mut LatticeState) {
        let LatticeParameters {
            mu,
            epsilon,
            s,
            d1,
            d2,
        } = self.parameters;
        let LatticeState { x1, x2 } = *state;
        for cell in 0..16 {
            let [above, below, left, right] = NEIGHBOURS[cell];
            let laplacian = |x: &Layer| x[above] + x[below] + x[left] + x[right] - 4.0 * x[cell];
            let (y1, y2) = (output(x1[cell]), output(x2[cell]));
            let dx1 = -x1[cell] + (1.0 + mu + epsilon) * y1 - s * y2 + d1 * laplacian(&x1);
            let dx2 = -x2[cell] + s * y1 + (1.0 + mu - epsilon) * y2 + d2 * laplacian(&x2);
            state.x1[cell] += STEP * dx1;
            state.x2[cell] += STEP * dx2;
        }
    }

    /// The codes that [`run`](Self::run) ends in, for many starts.
    pub fn codes(&self, starts: &[LatticeState]) -> Vec<PatternCode> {
        self.run_until(starts, |state| self.is_decided(state))
            .iter()
            .map(LatticeState::code)
            .collect()
    }

    /// Runs from many starts, each until `stop` holds or all [`STEPS`] steps are done. `stop` is
    /// asked every [`CHECK_INTERVAL`] steps.
    pub fn run_until(
        &self,
        starts: &[LatticeState],
        stop: impl Fn(&LatticeState) -> bool + Sync,
    ) -> Vec<LatticeState> {
        Lanes::run(&self.parameters, starts, &stop)
    }

    /// Whether no sign of layer 1 can ever change again; `false` may also mean "not known".
    ///
    /// While every x1 keeps its sign sigma and stays beyond l = min(|x1|, 1), its output is within
    /// rho = (1 - l) / 2 of sigma (1 + l) / 2. Layer 2 is linear, since |x2| <= 1, and its response
    /// G = (epsilon - mu - D2 L)^-1 has no negative element, so it stays within
    /// `spread` = s G rho + E of `centre` = s G sigma (1 + l) / 2, if E is its largest deviation
    /// from `centre` now. From that follow, for each cell, an upper bound of |x1| and the smallest
    /// drive at |x1| = l. If every drive points outwards, no cell is the first to come back to l.
    /// (Euler's steps preserve these inequalities: both update matrices are non-negative, as
    /// 0.001 (epsilon - mu + 8 D2) < 1.)
    pub fn is_decided(&self, state: &LatticeState) -> bool {
        let Some(response) = &self.response else {
            return false;
        };
        let LatticeParameters {
            mu, epsilon, s, d1, ..
        } = self.parameters;
        let magnitude = state.x1.map(f64::abs);
        let sign = state.x1.map(f64::signum);
        let least = magnitude.map(|m| m.min(1.0));
        let respond = |input: &dyn Fn(usize) -> f64| -> Layer {
            std::array::from_fn(|cell| {
                s * (0..16).map(|n| response[cell][n] * input(n)).sum::<f64>()
            })
        };
        let centre = respond(&|n| sign[n] * (1.0 + least[n]) / 2.0);
        let deviation = (0..16).map(|cell| (state.x2[cell] - centre[cell]).abs());
        let deviation = deviation.fold(0.0, f64::max);
        let spread = respond(&|n| (1.0 - least[n]) / 2.0).map(|spread| spread + deviation);
        // Inflow from neighbours whose magnitudes, of own and other sign, are bounded like this.
        let inflow = |cell: usize, same: &Layer, opposite: &Layer| -> (f64, f64) {
            let neighbours = NEIGHBOURS[cell].into_iter().filter(|&n| n != cell);
            neighbours.fold((0.0, 0.0), |(sum, count), n| {
                let flow = if sign[n] == sign[cell] {
                    same[n]
                } else {
                    -opposite[n]
                };
                (sum + d1 * flow, count + d1)
            })
        };
        let inhibition = |cell: usize| s * sign[cell] * centre[cell];

        // At the largest cell nothing flows in, so this bounds all; then each by its neighbours.
        let excitation = 1.0 + mu + epsilon;
        let bound_of_x2 = state
            .x2
            .iter()
            .fold(s / (epsilon - mu), |m, x| m.max(x.abs()));
        let largest = magnitude
            .iter()
            .copied()
            .fold(excitation + s * bound_of_x2, f64::max);
        let mut most = [largest; 16];
        for _ in 0..4 {
            most = std::array::from_fn(|cell| {
                let (flow, outflow) = inflow(cell, &most, &least);
                let drive = excitation - inhibition(cell) + s * spread[cell] + flow;
                magnitude[cell].max(drive / (1.0 + outflow))
            });
        }
        (0..16).all(|cell| {
            let (flow, outflow) = inflow(cell, &least, &most);
            let drive =
                (mu + epsilon - outflow) * least[cell] - inhibition(cell) - s * spread[cell] + flow;
            drive > ROUNDING_MARGIN
        })
    }
}

/// By how much drives must point outwards: far above the rounding of f64.
const ROUNDING_MARGIN: f64 = 1e-9;

/// (epsilon - mu - D2 L)^-1 by Gauss-Jordan elimination, which needs no pivoting: the matrix is
/// diagonally dominant.
fn response(parameters: &LatticeParameters) -> Box<[Layer; 16]> {
    let mut left = [[0.0; 16]; 16];
    let mut right = Box::new([[0.0; 16]; 16]);
    for cell in 0..16 {
        left[cell][cell] = parameters.epsilon - parameters.mu;
        right[cell][cell] = 1.0;
        for n in NEIGHBOURS[cell] {
            left[cell][cell] += parameters.d2;
            left[cell][n] -= parameters.d2;
        }
    }
    for pivot in 0..16 {
        let scale = 1.0 / left[pivot][pivot];
        left[pivot] = left[pivot].map(|element| element * scale);
        right[pivot] = right[pivot].map(|element| element * scale);
        let (pivot_left, pivot_right) = (left[pivot], right[pivot]);
        for row in (0..16).filter(|&row| row != pivot) {
            let factor = left[row][pivot];
            for column in 0..16 {
                left[row][column] -= factor * pivot_left[column];
                right[row][column] -= factor * pivot_right[column];
            }
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use rover_shared::perception::{Corners, Noise};
    use rover_shared::random::Generator;

    use super::*;

    fn starts(count: usize) -> Vec<LatticeState> {
        let mut rng = Generator::new(31);
        (0..count)
            .map(|_| {
                let corners = Corners(std::array::from_fn(|_| rng.symmetric(2 << 20)));
                LatticeState::from_fixed(&corners, &Noise::draw(&mut rng))
            })
            .collect()
    }

    #[test]
    fn lanes_give_the_bits_of_the_literal_run() {
        let reference = Reference::new(LatticeParameters::PAPER);
        let starts = starts(7);
        let ends = reference.run_until(&starts, |_| false);
        for (start, end) in starts.iter().zip(ends) {
            let literal = reference.run(*start).state;
            assert_eq!(literal.x1.map(f64::to_bits), end.x1.map(f64::to_bits));
            assert_eq!(literal.x2.map(f64::to_bits), end.x2.map(f64::to_bits));
        }
    }

    #[test]
    fn stopping_early_changes_no_code() {
        let reference = Reference::new(LatticeParameters::PAPER);
        let starts = starts(100);
        let whole = reference.run_until(&starts, |_| false);
        let codes: Vec<_> = whole.iter().map(LatticeState::code).collect();
        assert_eq!(reference.codes(&starts), codes);
        let decided = reference.run_until(&starts, |state| reference.is_decided(state));
        assert!(decided.iter().all(|state| reference.is_decided(state)));
    }

    #[test]
    fn no_start_is_decided() {
        let reference = Reference::new(LatticeParameters::PAPER);
        assert!(starts(50).iter().all(|start| !reference.is_decided(start)));
    }
}
