//! Which pattern has which colour: the same in all figures of a session.

use std::collections::BTreeMap;

use rover_log::knowledge::followed::Followed;
use rover_shared::perception::PatternCode;

use super::drive::Drive;

/// Colours that people of all kinds of colour vision can tell apart (Okabe and Ito, 2008), without
/// its black and yellow, which serve marks and would vanish on white. The two patterns of the
/// zig-zag come first: a dark and a light colour, which differ in grey too.
pub(super) const COLOURS: [&str; 6] = [
    "#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9",
];
/// Widths of the moves that the coloured patterns chose: a second sign for who sees no colours.
const WIDTHS: [f64; 6] = [1.8, 3.4, 2.6, 2.6, 2.6, 2.6];

/// All other patterns.
pub(super) const OTHERS: &str = "#999999";

/// A pattern that drove the robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Used {
    pub code: PatternCode,
    /// Actions that it chose.
    pub occurrences: usize,
    /// The turn it stands for, in degrees, positive to the left; `None` if it was never learned.
    pub turn_deg: Option<f64>,
}

impl Used {
    /// The turn as text.
    pub fn turn(&self) -> String {
        turn_text(self.turn_deg)
    }
}

fn turn_text(turn_deg: Option<f64>) -> String {
    match turn_deg {
        None => "not learned".into(),
        Some(turn) if turn < 0.0 => format!("{:.1}° right", -turn),
        Some(turn) => format!("{turn:.1}° left"),
    }
}

/// The width of the moves that a pattern of this rank chose.
pub(super) fn width(rank: Option<usize>) -> f64 {
    rank.map_or(2.2, |rank| WIDTHS[rank])
}

/// The patterns of some drives, the most used first.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    ranked: Vec<Used>,
}

impl Palette {
    /// Ranks the patterns by the actions that they chose in `drives`.
    pub fn new(drives: &[Drive], lessons: &Followed) -> Self {
        let mut counts = BTreeMap::<PatternCode, usize>::new();
        for code in drives.iter().flat_map(Drive::codes).flatten() {
            *counts.entry(code).or_default() += 1;
        }
        let mut ranked: Vec<Used> = counts
            .into_iter()
            .map(|(code, occurrences)| Used {
                code,
                occurrences,
                turn_deg: lessons.turn_deg(code),
            })
            .collect();
        // Stable: equals stay in the order of their codes.
        ranked.sort_by_key(|used| std::cmp::Reverse(used.occurrences));
        Self { ranked }
    }

    /// All patterns used.
    pub fn ranked(&self) -> &[Used] {
        &self.ranked
    }

    /// The patterns that have a colour of their own, with it.
    pub fn coloured(&self) -> impl Iterator<Item = (&Used, &'static str)> {
        self.ranked.iter().zip(COLOURS)
    }

    /// The rank of a pattern that has a colour of its own, from 0.
    pub fn rank(&self, code: Option<PatternCode>) -> Option<usize> {
        self.coloured()
            .position(|(used, _)| Some(used.code) == code)
    }

    /// The colour of a pattern.
    pub fn colour(&self, code: Option<PatternCode>) -> &'static str {
        self.rank(code).map_or(OTHERS, |rank| COLOURS[rank])
    }
}
