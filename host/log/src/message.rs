//! The messages of a simulation's log, but for that of the arena.

use rover_shared::controller::{Learned, StepRecord};
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use rover_simulator::arena::{Motion, Pose};
use rover_simulator::experiment::{Ending, TaskKind};

/// One action: what was asked for and sensed, what the core made of it, what came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Counts trials, from 1.
    #[schemars(range(min = 1))]
    pub trial: u32,
    /// Whether the core was told to forget the action before: a new trial, or a new direction.
    pub interrupted: bool,
    /// What was to be done.
    pub task: TaskKind,
    /// What was sensed.
    pub sample: Sample,
    /// What the core made of it.
    pub record: StepRecord,
    /// What became of the action; null where that is unknown.
    pub motion: Option<Motion>,
    /// Where the robot was when it sensed; null outside simulations.
    pub pose: Option<LoggedPose>,
}

/// A place in the arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoggedPose {
    /// From the left wall.
    pub x_um: i64,
    /// From the lower wall.
    pub y_um: i64,
    /// Counter-clockwise, 0 = right.
    pub heading_udeg: Microdegrees,
}

impl From<Pose> for LoggedPose {
    fn from(pose: Pose) -> Self {
        let micrometres = |cm: f64| (cm * 1e4).round() as i64;
        Self {
            x_um: micrometres(pose.x_cm),
            y_um: micrometres(pose.y_cm),
            heading_udeg: pose.heading,
        }
    }
}

/// The end of a trial.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// Counts trials, from 1.
    #[schemars(range(min = 1))]
    pub trial: u32,
    /// What was to be done.
    pub task: TaskKind,
    /// What was sensed after the last action.
    pub sample: Sample,
    /// What was learned from the last action.
    pub learned: Option<Learned>,
    /// How the trial ended.
    pub ending: Ending,
}

/// Reads a message of any format; of format 1 also its `chain`, a checksum of it and all before.
pub(crate) fn read<T: DeserializeOwned>(
    json: &[u8],
) -> Result<(T, Option<u64>), serde_json::Error> {
    let mut value: serde_json::Value = serde_json::from_slice(json)?;
    let chain = value
        .as_object_mut()
        .and_then(|fields| fields.remove("chain"));
    let message = serde_json::from_value(value)?;
    Ok((message, chain.and_then(|chain| chain.as_u64())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_format_1_have_a_checksum_more_and_nothing_else() {
        let pose = |more: &str| {
            read::<LoggedPose>(
                format!("{{\"x_um\":1,\"y_um\":2,\"heading_udeg\":3{more}}}").as_bytes(),
            )
        };
        let expected = LoggedPose {
            x_um: 1,
            y_um: 2,
            heading_udeg: Microdegrees(3),
        };
        assert_eq!(pose("").unwrap(), (expected, None));
        assert_eq!(pose(",\"chain\":7").unwrap(), (expected, Some(7)));
        assert!(pose(",\"chains\":7").is_err());
    }
}
