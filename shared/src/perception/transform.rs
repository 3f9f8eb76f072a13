//! The lattice's spatial modes: a 4x4 cosine transform in which zero-flux diffusion is diagonal.
//!
//! The eigenvectors of the zero-flux Laplacian are products of two of the four one-dimensional
//! cosines (DCT-II)
//!
//! ```text
//! w0 = [1,  1,  1,  1]     w1 = [1,  t, -t, -1]      t = tan(pi/8) = sqrt(2) - 1
//! w2 = [1, -1, -1,  1]     w3 = [t, -1,  1, -t]      |w|^2 = 4 (even), 2 (1 + t^2) (odd)
//! ```
//!
//! with eigenvalues -(2 - 2 cos(pi i / 4)). Scaled like this, t is the only factor. Both
//! directions of the transform are made of the same two symmetric halves:
//!
//! * [`fold`] replaces four cells that are mirror images of each other by their sums and
//!   differences, which splits the lattice into four blocks by parity over rows and columns. It
//!   is the transpose of itself, and so its own inverse but for a factor;
//! * [`mix`] turns the four elements of a block into modes, with [[1, 1], [1, -1]] along an even
//!   direction and [[1, t], [t, -1]] along an odd one. It is its own transpose, too.
//!
//! Since t^2 = 1 - 2t, every mode is P + tQ with P and Q plain sums of cells: each is rounded
//! once, by a product whose rounding is odd. That makes the transform commute exactly, in fixed
//! point, with all mirror images and rotations of the lattice and with negation.

use super::fixed_point::scale;

/// A layer in place: its cells, row by row from the upper left corner; or its modes, in the
/// order of [`mode_indices`].
pub(super) type Layer = [i32; 16];

/// The cells that are mirror images of one another.
const MIRRORED: [[usize; 4]; 4] = [[0, 3, 12, 15], [1, 2, 13, 14], [4, 7, 8, 11], [5, 6, 9, 10]];

/// The indices (i, j) of the cosines over rows and columns of the mode stored at `place`.
pub(super) const fn mode_indices(place: usize) -> (usize, usize) {
    const ORDER: [usize; 4] = [0, 2, 3, 1];
    (ORDER[place / 4], ORDER[place % 4])
}

/// The index in [`parities`] of the sum that the mode stored at `place` depends on.
pub(super) const fn parity(place: usize) -> usize {
    2 * (place / 8) + place % 4 / 2
}

/// Replaces cells by their scalar products with all eigenvectors: up to 16 times the largest.
pub(super) fn forward(layer: &mut Layer) {
    fold(layer);
    mix(layer);
}

/// Replaces the weights of the eigenvectors by the cells they sum up to.
pub(super) fn inverse(layer: &mut Layer) {
    mix(layer);
    fold(layer);
}

/// The sums of four mirror images: even-even, even-odd, odd-even and odd-odd over rows, columns.
#[inline(always)]
pub(super) fn parities([p, q, r, s]: [i32; 4]) -> [i32; 4] {
    let (upper, upper_odd, lower, lower_odd) = (p + q, p - q, r + s, r - s);
    [
        upper + lower,
        upper_odd + lower_odd,
        upper - lower,
        upper_odd - lower_odd,
    ]
}

/// tan(pi/8) v.
#[inline(always)]
fn by_tangent(v: i32) -> i32 {
    const TANGENT_Q16: u32 = 27_146; // 0.4142136 * 2^16; the error of 1.5e-6 costs no code
    scale::<16, 16>(v, TANGENT_Q16)
}

/// Applies `function` to the elements at four places.
#[inline(always)]
fn replace(layer: &mut Layer, places: [usize; 4], function: impl Fn([i32; 4]) -> [i32; 4]) {
    let results = function(places.map(|place| layer[place]));
    for (place, result) in places.into_iter().zip(results) {
        layer[place] = result;
    }
}

#[inline(always)]
fn fold(layer: &mut Layer) {
    for places in MIRRORED {
        replace(layer, places, parities);
    }
}

#[inline(always)]
fn mix(layer: &mut Layer) {
    let odd = |p, q| [p + by_tangent(q), by_tangent(p) - q];
    // Even over rows and columns; even over rows, odd over columns; and the other way round.
    replace(layer, [0, 1, 4, 5], parities);
    replace(layer, [3, 2, 7, 6], |[p, q, r, s]| {
        let ([a, b], [c, d]) = (odd(p + r, q + s), odd(p - r, q - s));
        [a, b, c, d]
    });
    replace(layer, [12, 13, 8, 9], |[p, q, r, s]| {
        let ([a, c], [b, d]) = (odd(p + q, r + s), odd(p - q, r - s));
        [a, b, c, d]
    });
    // Odd over both, with t^2 = 1 - 2t.
    replace(layer, [15, 14, 11, 10], |[p, q, r, s]| {
        [
            p + s + by_tangent(q + r - 2 * s),
            r - q + by_tangent(p - s - 2 * r),
            q - r + by_tangent(p - s - 2 * q),
            p + s - by_tangent(2 * p + q + r),
        ]
    });
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The one-dimensional cosines of the module's header.
    fn cosine(i: usize, k: usize) -> f64 {
        let t = core::f64::consts::FRAC_PI_8.tan();
        [
            [1.0, 1.0, 1.0, 1.0],
            [1.0, t, -t, -1.0],
            [1.0, -1.0, -1.0, 1.0],
            [t, -1.0, 1.0, -t],
        ][i][k]
    }

    /// The element of the transform's matrix for a mode and a cell.
    fn element(place: usize, cell: usize) -> f64 {
        let (i, j) = mode_indices(place);
        cosine(i, cell / 4) * cosine(j, cell % 4)
    }

    fn layer(limit: i32) -> impl Strategy<Value = Layer> {
        prop::array::uniform16(-limit..=limit)
    }

    proptest! {
        #[test]
        fn modes_are_the_products_with_the_cosines(cells in layer(1 << 24)) {
            let mut modes = cells;
            forward(&mut modes);
            for (place, &mode) in modes.iter().enumerate() {
                let exact: f64 = (0..16).map(|cell| element(place, cell) * f64::from(cells[cell])).sum();
                // One rounding, and an error of t of 1.5e-6 on at most 16 cells.
                prop_assert!((f64::from(mode) - exact).abs() < 0.5 + 16.0 * 1.5e-6 * 2f64.powi(24));
            }
        }

        #[test]
        fn cells_are_the_sums_of_the_cosines(modes in layer(1 << 22)) {
            let mut cells = modes;
            inverse(&mut cells);
            for (cell, &state) in cells.iter().enumerate() {
                let exact: f64 = (0..16).map(|place| element(place, cell) * f64::from(modes[place])).sum();
                prop_assert!((f64::from(state) - exact).abs() < 6.0 + 16.0 * 1.5e-6 * 2f64.powi(22));
            }
        }

        #[test]
        fn a_transposed_layer_has_transposed_modes(cells in layer(1 << 24)) {
            let transpose = |layer: Layer| -> Layer { core::array::from_fn(|k| layer[k % 4 * 4 + k / 4]) };
            let (mut modes, mut transposed) = (cells, transpose(cells));
            forward(&mut modes);
            forward(&mut transposed);
            prop_assert_eq!(transpose(modes), transposed);
            inverse(&mut modes);
            inverse(&mut transposed);
            prop_assert_eq!(transpose(modes), transposed);
        }
    }
}
