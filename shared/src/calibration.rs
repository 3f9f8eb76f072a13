//! Calibrations of one rover: the curves of its range sensors, its compass's mounting, its speed.
//! Set by commands, stored in the flash.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::contract::{CURVE_POINTS, Calibration, CurvePoint, Refusal};
use crate::motion::Parameters;
use crate::sensing::ir::CHANNELS;
use crate::sensing::ir::curve::RangeCurve;
use crate::units::{Microdegrees, Micrometres};

/// Most encoded bytes: four curves of twelve points of 8 bytes, and some 30 bytes more.
pub const MOST_BYTES: usize = 512;

/// Version of the encoding.
const VERSION: u8 = 1;

/// All calibrations of one rover.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Calibrations {
    /// Of the range sensors: front left, front right, left, right.
    pub curves: [RangeCurve; CHANNELS],
    /// Added to the compass's counter-clockwise heading.
    pub compass_offset: Microdegrees,
    /// Of its moves.
    pub motion: Parameters,
}

/// The encoding: version, then this in postcard format.
#[derive(Serialize, Deserialize)]
struct Stored {
    curves: [Vec<CurvePoint, CURVE_POINTS>; CHANNELS],
    compass_offset: Microdegrees,
    cruise: u16,
    cruise_speed: Micrometres,
    dead_band: u16,
}

impl Calibrations {
    /// An uncalibrated rover with these defaults.
    pub const fn new(curve: RangeCurve, motion: Parameters) -> Self {
        Self {
            curves: [curve; CHANNELS],
            compass_offset: Microdegrees(0),
            motion,
        }
    }

    /// Applies one calibration.
    ///
    /// # Errors
    /// [`Refusal::BadCalibration`] for points that are no curve, [`Refusal::OutOfRange`] for
    /// numbers that do not fit; nothing is changed.
    pub fn apply(&mut self, calibration: &Calibration) -> Result<(), Refusal> {
        match calibration {
            Calibration::Range { channel, points } => {
                let curve = RangeCurve::new(points).map_err(|_| Refusal::BadCalibration)?;
                let place = self.curves.get_mut(usize::from(*channel));
                *place.ok_or(Refusal::OutOfRange)? = curve;
            }
            Calibration::Compass { offset } => {
                if offset.0.unsigned_abs() > Microdegrees::HALF_TURN.0.unsigned_abs() {
                    return Err(Refusal::OutOfRange);
                }
                self.compass_offset = *offset;
            }
            Calibration::Speed {
                duty,
                speed,
                dead_band,
            } => {
                let motion = Parameters {
                    cruise: *duty,
                    cruise_speed: *speed,
                    dead_band: *dead_band,
                    ..self.motion
                };
                motion.check().map_err(|_| Refusal::OutOfRange)?;
                self.motion = motion;
            }
        }
        Ok(())
    }

    /// Encodes the calibrations, in at most [`MOST_BYTES`] bytes.
    pub fn encode<'b>(&self, buffer: &'b mut [u8; MOST_BYTES]) -> &'b [u8] {
        let curve = |curve: &RangeCurve| curve.points().iter().copied().collect();
        let stored = Stored {
            curves: self.curves.each_ref().map(curve),
            compass_offset: self.compass_offset,
            cruise: self.motion.cruise,
            cruise_speed: self.motion.cruise_speed,
            dead_band: self.motion.dead_band,
        };
        // Does not fail: a test encodes the longest there can be.
        postcard::to_slice(&(VERSION, stored), buffer).unwrap_or_default()
    }

    /// Restores the output of [`encode`](Self::encode); false, and nothing changed, if the bytes
    /// are something else.
    pub fn restore(&mut self, bytes: &[u8]) -> bool {
        self.decode(bytes)
            .map(|restored| *self = restored)
            .is_some()
    }

    fn decode(&self, bytes: &[u8]) -> Option<Self> {
        let (version, stored): (u8, Stored) = postcard::from_bytes(bytes).ok()?;
        let mut restored = self.clone();
        for (channel, points) in (0..).zip(stored.curves) {
            restored
                .apply(&Calibration::Range { channel, points })
                .ok()?;
        }
        restored
            .apply(&Calibration::Compass {
                offset: stored.compass_offset,
            })
            .ok()?;
        let speed = Calibration::Speed {
            duty: stored.cruise,
            speed: stored.cruise_speed,
            dead_band: stored.dead_band,
        };
        restored.apply(&speed).ok()?;
        (version == VERSION).then_some(restored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FRESH: Calibrations = Calibrations::new(RangeCurve::GP2D12, Parameters::LYNXMOTION_4WD2);

    fn points(n: u16) -> Vec<CurvePoint, CURVE_POINTS> {
        (0..n)
            .map(|i| CurvePoint {
                counts: 4_095 - n + i,
                distance: Micrometres(Micrometres::from_cm(600).0 - u32::from(i)),
            })
            .collect()
    }

    #[test]
    fn what_is_set_survives_the_bytes() {
        let mut set = FRESH;
        for channel in 0..4 {
            let longest = Calibration::Range {
                channel,
                points: points(CURVE_POINTS as u16),
            };
            assert_eq!(set.apply(&longest), Ok(()));
        }
        let offset = Microdegrees(-179_999_999);
        assert_eq!(set.apply(&Calibration::Compass { offset }), Ok(()));
        let speed = Calibration::Speed {
            duty: 900,
            speed: Micrometres::from_cm(99),
            dead_band: 899,
        };
        assert_eq!(set.apply(&speed), Ok(()));
        let mut buffer = [0; MOST_BYTES];
        let bytes = set.encode(&mut buffer);
        assert!(bytes.len() > 300, "{}", bytes.len());
        let mut restored = FRESH;
        assert!(restored.restore(bytes));
        assert_eq!(restored, set);
    }

    #[test]
    fn what_does_not_fit_is_refused_and_changes_nothing() {
        let mut set = FRESH;
        let refused = |c: &Calibration| {
            let mut set = FRESH;
            let error = set.apply(c).expect_err("does not fit");
            assert_eq!(set, FRESH);
            error
        };
        let range = |channel, n| Calibration::Range {
            channel,
            points: points(n),
        };
        assert_eq!(refused(&range(4, 5)), Refusal::OutOfRange);
        assert_eq!(refused(&range(0, 1)), Refusal::BadCalibration);
        let offset = Microdegrees(i32::MIN);
        assert_eq!(
            refused(&Calibration::Compass { offset }),
            Refusal::OutOfRange
        );
        let speed = Calibration::Speed {
            duty: 100,
            speed: Micrometres(0),
            dead_band: 200,
        };
        assert_eq!(refused(&speed), Refusal::OutOfRange);
        assert!(!set.restore(&[]));
        assert!(!set.restore(&[VERSION + 1; 200]));
    }

    proptest! {
        /// Whatever is accepted could have been set, and is written as the same again.
        #[test]
        fn no_bytes_make_it_panic(noise in prop::collection::vec(any::<u8>(), 0..MOST_BYTES)) {
            let mut bytes = std::vec![VERSION];
            bytes.extend(noise);
            let mut restored = FRESH;
            if restored.restore(&bytes) {
                let mut again = FRESH;
                let mut buffer = [0; MOST_BYTES];
                prop_assert!(again.restore(restored.encode(&mut buffer)));
                prop_assert_eq!(again, restored);
            } else {
                prop_assert_eq!(restored, FRESH);
            }
        }
    }
}
