//! Runs of the reference side by side, for the processor's vector units: the same operations in
//! the same order as in [`Reference::run`](super::Reference::run), so the same bits.

use rover_shared::perception::LatticeParameters;

use super::state::{CHECK_INTERVAL, LatticeState, NEIGHBOURS, STEP, STEPS, output};

/// The states of several runs, lane by lane.
pub(super) struct Lanes {
    x1: [[f64; LANES]; 16],
    x2: [[f64; LANES]; 16],
}

/// Runs in parallel: enough to keep two-lane vector units busy in spite of their latency.
const LANES: usize = 4;

impl Lanes {
    /// Runs from all `starts`: whenever a run ends, the next one takes over its lane.
    pub(super) fn run(
        parameters: &LatticeParameters,
        starts: &[LatticeState],
        stop: impl Fn(&LatticeState) -> bool,
    ) -> Vec<LatticeState> {
        let mut ends = starts.to_vec();
        let mut waiting = 0..starts.len();
        let mut lanes = Self {
            x1: [[0.0; LANES]; 16],
            x2: [[0.0; LANES]; 16],
        };
        let mut runs: [Option<(usize, u32)>; LANES] = [None; LANES];
        loop {
            for (lane, run) in runs.iter_mut().enumerate() {
                if run.is_none() {
                    *run = waiting.next().map(|index| (index, 0));
                    if let Some((index, _)) = *run {
                        lanes.set(lane, &starts[index]);
                    }
                }
            }
            if runs.iter().all(Option::is_none) {
                return ends;
            }
            for _ in 0..CHECK_INTERVAL {
                lanes.advance(parameters);
            }
            for (lane, run) in runs.iter_mut().enumerate() {
                if let Some((index, steps)) = run {
                    *steps += CHECK_INTERVAL;
                    let state = lanes.get(lane);
                    if *steps >= STEPS || stop(&state) {
                        ends[*index] = state;
                        *run = None;
                    }
                }
            }
        }
    }

    fn set(&mut self, lane: usize, state: &LatticeState) {
        for cell in 0..16 {
            self.x1[cell][lane] = state.x1[cell];
            self.x2[cell][lane] = state.x2[cell];
        }
    }

    fn get(&self, lane: usize) -> LatticeState {
        LatticeState {
            x1: self.x1.map(|cell| cell[lane]),
            x2: self.x2.map(|cell| cell[lane]),
        }
    }

    fn advance(&mut self, parameters: &LatticeParameters) {
        let LatticeParameters {
            mu,
            epsilon,
            s,
            d1,
            d2,
        } = *parameters;
        let (x1, x2) = (&self.x1, &self.x2);
        let mut change1 = [[0.0; LANES]; 16];
        let mut change2 = [[0.0; LANES]; 16];
        for cell in 0..16 {
            let [above, below, left, right] = NEIGHBOURS[cell];
            for lane in 0..LANES {
                let laplacian = |x: &[[f64; LANES]; 16]| {
                    x[above][lane] + x[below][lane] + x[left][lane] + x[right][lane]
                        - 4.0 * x[cell][lane]
                };
                let (y1, y2) = (output(x1[cell][lane]), output(x2[cell][lane]));
                change1[cell][lane] =
                    -x1[cell][lane] + (1.0 + mu + epsilon) * y1 - s * y2 + d1 * laplacian(x1);
                change2[cell][lane] =
                    -x2[cell][lane] + s * y1 + (1.0 + mu - epsilon) * y2 + d2 * laplacian(x2);
            }
        }
        for cell in 0..16 {
            for lane in 0..LANES {
                self.x1[cell][lane] += STEP * change1[cell][lane];
                self.x2[cell][lane] += STEP * change2[cell][lane];
            }
        }
    }
}
