//! Where the vehicle was, by the board's clock.

use std::collections::VecDeque;

use rover_shared::time::Instant;
use rover_simulator::arena::Pose;

/// Places that are kept: longer than any action takes, at one a millisecond.
const KEPT: usize = 20_000;

/// The poses of the last 20 seconds.
#[derive(Clone, Debug, Default)]
pub struct Track(VecDeque<(Instant, Pose)>);

impl Track {
    /// The vehicle is here now.
    pub fn note(&mut self, board_time: Instant, pose: Pose) {
        if self.0.back().is_some_and(|(last, _)| *last > board_time) {
            // The board was reset, and its clock with it.
            self.0.clear();
        }
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back((board_time, pose));
    }

    /// Where it was at a moment, to the millisecond.
    pub fn pose_at(&self, board_time: Instant) -> Option<Pose> {
        let after = self.0.partition_point(|(time, _)| *time < board_time);
        let near = after.checked_sub(1).unwrap_or(after);
        let known = self.0.front()?.0 <= board_time && self.0.len() > after;
        known
            .then(|| self.0.get(near))
            .flatten()
            .map(|(_, pose)| *pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover_shared::units::Microdegrees;

    fn pose(x_cm: f64) -> Pose {
        Pose {
            x_cm,
            y_cm: 0.0,
            heading: Microdegrees(0),
        }
    }

    #[test]
    fn places_are_found_by_their_time_until_they_are_too_old() {
        let mut track = Track::default();
        for ms in 0..KEPT as u64 + 10 {
            track.note(Instant(ms * 1_000), pose(ms as f64));
        }
        assert_eq!(track.pose_at(Instant(15_000_400)), Some(pose(15_000.0)));
        assert_eq!(track.pose_at(Instant(1_000)), None, "too long ago");
        assert_eq!(track.pose_at(Instant(99_000_000)), None, "still to come");
        track.note(Instant(0), pose(-1.0));
        assert_eq!(track.pose_at(Instant(15_000_000)), None, "before a reset");
    }
}
