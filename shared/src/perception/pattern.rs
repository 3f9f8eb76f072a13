//! The code of a Turing pattern (eq. 3).

use core::fmt;

use serde::{Deserialize, Serialize};

/// A pattern as the paper codes it: the sum of y_c 2^c (eq. 3), where y_c is 1 for a cell c of
/// layer 1 that saturated at +1 and 0 for one at -1, and c counts row by row from the upper left.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct PatternCode(pub u16);

impl PatternCode {
    /// Rows of the lattice, and cells in a row.
    pub const SIDE: usize = 4;

    /// The code of the signs of 16 states: bit c is set where `states[c]` > 0.
    pub(super) fn of_signs(states: &[i32; 16]) -> Self {
        let mut code = 0;
        for (cell, &state) in states.iter().enumerate() {
            code |= u16::from(state > 0) << cell;
        }
        Self(code)
    }

    /// Whether cell `cell` (0 to 15, row by row from the upper left) is at +1. Cells beyond 15
    /// do not exist and are not.
    pub const fn cell(self, cell: usize) -> bool {
        cell < 16 && self.0 >> cell & 1 == 1
    }

    /// The four rows, upper one first, each from left to right.
    pub fn rows(self) -> impl Iterator<Item = [bool; Self::SIDE]> {
        (0..Self::SIDE)
            .map(move |row| core::array::from_fn(|column| self.cell(Self::SIDE * row + column)))
    }

    /// Draws the pattern in four lines of text, `#` for +1 and `.` for -1.
    pub const fn picture(self) -> Picture {
        Picture(self)
    }
}

impl fmt::Display for PatternCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Four lines of text that show a pattern; see [`PatternCode::picture`].
#[derive(Clone, Copy, Debug)]
pub struct Picture(PatternCode);

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, row) in self.0.rows().enumerate() {
            if number > 0 {
                f.write_str("\n")?;
            }
            for cell in row {
                f.write_str(if cell { "#" } else { "." })?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn the_papers_pattern_is_drawn_from_the_upper_left() {
        // 12703 = 0x319F: rows F, 9, 1, 3 with the lowest bit on the left.
        let picture = PatternCode(12_703).picture().to_string();
        assert_eq!(picture, "####\n#..#\n#...\n##..");
    }

    #[test]
    fn rows_and_cells_rebuild_the_code() {
        for code in [0, 1, 12_703, 37_156, 63_884, u16::MAX] {
            let pattern = PatternCode(code);
            let rebuilt: u32 = pattern
                .rows()
                .flatten()
                .zip(0..)
                .map(|(cell, c)| u32::from(cell) << c)
                .sum();
            assert_eq!(rebuilt, u32::from(code));
            assert!(!pattern.cell(16));
        }
    }

    #[test]
    fn the_papers_two_headings_are_rotations_of_each_other() {
        let rotated = PatternCode(12_703u16.reverse_bits());
        assert_eq!(rotated, PatternCode(63_884));
    }
}
