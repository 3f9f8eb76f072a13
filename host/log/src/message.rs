//! The messages of a log.
//!
//! Each message carries a checksum of itself and of all messages before it (`chain`), so that a
//! value changed later is noticed even where no calculation depends on it.

use crc::{CRC_32_ISO_HDLC, Crc};
use rover_shared::controller::{Learned, StepRecord};
use rover_shared::sensing::Sample;
use rover_shared::units::Microdegrees;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use rover_simulator::arena::{Motion, Pose};
use rover_simulator::experiment::{Ending, TaskKind};

/// JSON Schema of [`Step`].
pub const STEP_SCHEMA: &str = include_str!("step.schema.json");
/// JSON Schema of [`End`].
pub const END_SCHEMA: &str = include_str!("end.schema.json");

/// One action: what was asked for and sensed, what the core made of it, what came of it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Counts trials, from 1.
    pub trial: u32,
    /// Whether the core was told to forget the action before: a new trial, or a new direction.
    pub interrupted: bool,
    /// What was to be done.
    pub task: TaskKind,
    /// What was sensed.
    pub sample: Sample,
    /// What the core made of it.
    pub record: StepRecord,
    /// What became of the action; `None` where nobody can tell.
    pub motion: Option<Motion>,
    /// Where the robot was when it sensed; `None` outside simulations.
    pub pose: Option<LoggedPose>,
}

/// A place in the arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct End {
    /// Counts trials, from 1.
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

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// The checksum that links each message to all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chain(u32);

impl Chain {
    /// The beginning of the chain of a log with this origin, so that the origin is covered too.
    pub fn new(origin: &impl Serialize) -> Result<Self, serde_json::Error> {
        let mut chain = Self(0);
        chain.add(&serde_json::to_vec(origin)?);
        Ok(chain)
    }

    /// The checksum so far.
    pub fn value(&self) -> u32 {
        self.0
    }

    /// The message as JSON, with the checksum up to it as its last field.
    pub fn seal<T: Serialize>(&mut self, message: &T) -> Result<Vec<u8>, serde_json::Error> {
        let mut bytes = serde_json::to_vec(message)?;
        self.add(&bytes);
        debug_assert_eq!(bytes.last(), Some(&b'}'), "messages are JSON objects");
        bytes.pop();
        bytes.extend_from_slice(format!(",\"chain\":{}}}", self.0).as_bytes());
        Ok(bytes)
    }

    /// The message in `bytes`, and whether its checksum is the one that was to come.
    pub fn open<T: Serialize + DeserializeOwned>(
        &mut self,
        bytes: &[u8],
    ) -> Result<(T, bool), serde_json::Error> {
        let mut value: serde_json::Value = serde_json::from_slice(bytes)?;
        let chain = value
            .as_object_mut()
            .and_then(|object| object.remove("chain"));
        let message: T = serde_json::from_value(value)?;
        self.add(&serde_json::to_vec(&message)?);
        let intact = chain.and_then(|chain| chain.as_u64()) == Some(u64::from(self.0));
        Ok((message, intact))
    }

    fn add(&mut self, bytes: &[u8]) {
        let mut digest = CRC.digest();
        digest.update(&self.0.to_le_bytes());
        digest.update(bytes);
        self.0 = digest.finalize();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Origin;
    use rover_shared::learning::Mode;

    fn chain() -> Chain {
        let origin = Origin {
            seed: 1,
            mode: Mode::Learn,
            writer: "test".into(),
        };
        Chain::new(&origin).unwrap()
    }

    fn end(trial: u32) -> End {
        End {
            trial,
            task: TaskKind::AimAtTarget,
            sample: Sample {
                front: Default::default(),
                left: Default::default(),
                right: Default::default(),
                heading: Default::default(),
                target_bearing: None,
            },
            learned: None,
            ending: Ending::Reached,
        }
    }

    #[test]
    fn what_was_sealed_opens_in_order_only() {
        let mut sealing = chain();
        let sealed: Vec<_> = (1..4).map(|i| sealing.seal(&end(i)).unwrap()).collect();
        let mut opening = chain();
        for (i, bytes) in (1..).zip(&sealed) {
            assert_eq!(opening.open(bytes).unwrap(), (end(i), true));
        }
        let mut skipping = chain();
        assert_eq!(skipping.open(&sealed[1]).unwrap(), (end(2), false));
    }

    #[test]
    fn a_value_nothing_depends_on_is_missed_too() {
        let sealed = chain().seal(&end(1)).unwrap();
        let changed = String::from_utf8(sealed)
            .unwrap()
            .replace("\"trial\":1", "\"trial\":2");
        let (_, intact) = chain().open::<End>(changed.as_bytes()).unwrap();
        assert!(!intact);
    }
}
