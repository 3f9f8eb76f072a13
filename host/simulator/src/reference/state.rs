//! The states of the lattice, and what every integration of eq. 1 needs.

use rover_shared::perception::{Corners, Noise, PatternCode};

/// The paper's integration constant.
pub const STEP: f64 = 0.001;
/// The paper's number of integration steps.
pub const STEPS: u32 = 100_000;

/// How often, in steps, a run is asked whether it may stop: a quarter of a time unit.
pub const CHECK_INTERVAL: u32 = 250;

/// The states of one layer, row by row from the upper left corner.
pub type Layer = [f64; 16];

/// The neighbours of each cell: above, below, left, right; the cell itself where there is none.
pub(super) const NEIGHBOURS: [[usize; 4]; 16] = {
    let mut table = [[0; 4]; 16];
    let mut cell = 0;
    while cell < 16 {
        let (row, column) = (cell / 4, cell % 4);
        table[cell] = [
            if row > 0 { cell - 4 } else { cell },
            if row < 3 { cell + 4 } else { cell },
            if column > 0 { cell - 1 } else { cell },
            if column < 3 { cell + 1 } else { cell },
        ];
        cell += 1;
    }
    table
};

/// The states of both layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeState {
    /// Layer 1.
    pub x1: Layer,
    /// Layer 2.
    pub x2: Layer,
}

impl LatticeState {
    /// The initial state (Fig. 2b): `corners` are front, left, right and target.
    pub fn initial(corners: [f64; 4], noise: Layer) -> Self {
        let mut x1 = [0.0; 16];
        for (cell, corner) in Corners::CELLS.into_iter().zip(corners) {
            x1[cell] = corner;
        }
        Self { x1, x2: noise }
    }

    /// The initial state that the fixed-point engine starts from: the conversion is exact.
    pub fn from_fixed(corners: &Corners, noise: &Noise) -> Self {
        let corner_unit = f64::from(1 << Corners::FRACTION_BITS);
        let noise_unit = f64::from(1 << Noise::FRACTION_BITS);
        Self::initial(
            corners.0.map(|corner| f64::from(corner) / corner_unit),
            noise.0.map(|state| f64::from(state) / noise_unit),
        )
    }

    /// The signs of layer 1 as a pattern code (eq. 3).
    pub fn code(&self) -> PatternCode {
        let mut code = 0;
        for (cell, &state) in self.x1.iter().enumerate() {
            code |= u16::from(state > 0.0) << cell;
        }
        PatternCode(code)
    }

    /// Whether every cell of layer 1 is saturated: the paper's condition for a pattern.
    pub fn is_saturated(&self) -> bool {
        self.x1.iter().all(|state| state.abs() > 1.0)
    }
}

/// The output function of a cell.
#[inline(always)]
pub(super) fn output(x: f64) -> f64 {
    0.5 * ((x + 1.0).abs() - (x - 1.0).abs())
}
