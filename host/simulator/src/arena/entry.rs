//! What an arena file can say, with the place of each value for errors that name its line.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

pub(super) type Number = Spanned<f64>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ArenaEntry {
    pub(super) width_cm: Option<Number>,
    pub(super) height_cm: Option<Number>,
    pub(super) map: Option<Spanned<PathBuf>>,
    pub(super) start: Option<Spanned<StartEntry>>,
    pub(super) goal: Option<Spanned<GoalEntry>>,
    #[serde(default)]
    pub(super) rect: Vec<Spanned<RectEntry>>,
    #[serde(default)]
    pub(super) circle: Vec<Spanned<CircleEntry>>,
    #[serde(default)]
    pub(super) polygon: Vec<Spanned<PolygonEntry>>,
    #[serde(default)]
    pub(super) robot: RobotEntry,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StartEntry {
    pub(super) x_cm: Number,
    pub(super) y_cm: Number,
    pub(super) heading_deg: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GoalEntry {
    pub(super) x_cm: Number,
    pub(super) y_cm: Number,
    pub(super) radius_cm: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RectEntry {
    pub(super) x_cm: Number,
    pub(super) y_cm: Number,
    pub(super) w_cm: Number,
    pub(super) h_cm: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CircleEntry {
    pub(super) x_cm: Number,
    pub(super) y_cm: Number,
    pub(super) r_cm: Number,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PolygonEntry {
    // Not `[f64; 2]`, which would drop a third number without a word.
    pub(super) points_cm: Spanned<Vec<Vec<f64>>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotEntry {
    #[serde(default)]
    pub(super) model: ModelEntry,
    pub(super) beam_deg: Option<Number>,
    pub(super) step_cm: Option<Number>,
    pub(super) contact_radius_cm: Option<Number>,
    pub(super) front_range_cm: Option<Number>,
    pub(super) side_range_cm: Option<Number>,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ModelEntry {
    #[default]
    Paper,
    Harder,
    Rover,
}
