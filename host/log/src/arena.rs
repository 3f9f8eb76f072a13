//! The message of channel `/arena`: where a trial takes place. Simulators know it; a rover on a
//! floor does not, and its logs have no such messages.

use std::sync::Arc;

use rover_simulator::arena::{Goal, Place, Pose, Scenario};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::message::LoggedPose;

/// Where a trial takes place, written before its first step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Arena {
    /// Counts trials, from 1.
    pub trial: u32,
    /// What stands where, and the robot; `None` if nothing has changed since the trial before: a
    /// map may have thousands of shapes.
    pub place: Option<Place>,
    /// Where the robot starts.
    pub start: LoggedPose,
    /// What it has to reach, if anything.
    pub goal: Option<Goal>,
}

/// The message of a trial, and of the one before, make no arena.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NoArena {
    /// The place is that of the trial before, of which there is none.
    #[error("trial {0} refers to the arena of a trial before it, which the log does not have")]
    Nowhere(u32),
    /// The place cannot be.
    #[error("the arena of trial {0} has no extent, or an obstacle that is not a shape")]
    Impossible(u32),
}

impl Arena {
    /// The message for a scenario; `same_place` if walls, obstacles and robot are those of the
    /// message before.
    pub fn new(trial: u32, scenario: &Scenario, same_place: bool) -> Self {
        Self {
            trial,
            place: (!same_place).then(|| Place::new(&scenario.world, &scenario.robot)),
            start: scenario.start.into(),
            goal: scenario.goal,
        }
    }

    /// The scenario that was logged, after that of the trial before.
    ///
    /// # Errors
    /// [`NoArena`], if a log was made by hand or changed.
    pub fn scenario(&self, before: Option<&Scenario>) -> Result<Scenario, NoArena> {
        let (world, robot) = match &self.place {
            Some(place) => {
                let world = place.world().ok_or(NoArena::Impossible(self.trial))?;
                (Arc::new(world), place.robot.clone())
            }
            None => {
                let before = before.ok_or(NoArena::Nowhere(self.trial))?;
                (before.world.clone(), before.robot.clone())
            }
        };
        Ok(Scenario {
            world,
            robot,
            start: self.start.into(),
            goal: self.goal,
        })
    }
}

impl From<LoggedPose> for Pose {
    fn from(pose: LoggedPose) -> Self {
        Self {
            x_cm: pose.x_um as f64 / 1e4,
            y_cm: pose.y_um as f64 / 1e4,
            heading: pose.heading_udeg,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg32;
    use rover_simulator::arena::{Circle, Layout, Obstacle, Outline, Polygon, Rect, World};

    use super::*;

    fn scenario() -> Scenario {
        Layout::paper().draw(&mut Pcg32::new(1, 1))
    }

    fn json(arena: &Arena) -> String {
        serde_json::to_string(arena).unwrap()
    }

    #[test]
    fn what_is_written_is_read_again_to_a_micrometre() {
        for layout in [Layout::paper(), Layout::rover(500.0, 3, 10.0)] {
            let scenario = layout.draw(&mut Pcg32::new(7, 1));
            let first = json(&Arena::new(1, &scenario, false));
            let read: Arena = serde_json::from_str(&first).unwrap();
            assert_eq!(json(&read), first);
            let restored = read.scenario(None).unwrap();
            assert_eq!(json(&Arena::new(1, &restored, false)), first);
            assert_eq!(restored.robot.sensors.len(), layout.robot.sensors.len());
            assert_eq!(restored.world.obstacles().len(), layout.rectangles);
            let second = Arena::new(2, &scenario, true)
                .scenario(Some(&restored))
                .unwrap();
            assert!(Arc::ptr_eq(&second.world, &restored.world));
        }
    }

    /// The bytes of format 1, which logs are read by and their checksums are made of.
    #[test]
    fn the_format_stays_as_it_is() {
        let rect = Rect {
            x_cm: 1.5,
            y_cm: 2.00004,
            w_cm: 3.0,
            h_cm: 4.0,
        };
        let circle = Circle {
            x_cm: 50.0,
            y_cm: 60.0,
            r_cm: 7.0,
        };
        let triangle = Polygon::new(vec![[80.0, 10.0], [90.0, 10.0], [85.0, 20.0]]).unwrap();
        let obstacles = vec![
            Obstacle::Rect(rect),
            Obstacle::Circle(circle),
            Obstacle::Polygon(triangle),
        ];
        let mut scenario = scenario();
        scenario.world = Arc::new(World::new(100.0, 80.0, obstacles));
        scenario.robot.sensors.truncate(1);
        scenario.robot.sensors[0].mount_cm = [1.0, -0.5];
        scenario.start = Pose {
            x_cm: 12.0,
            y_cm: 13.5,
            heading: rover_simulator::arena::degrees(-90.0),
        };
        scenario.goal = Some(Goal {
            x_cm: 70.0,
            y_cm: 40.0,
            radius_cm: 12.0,
        });
        let expected = concat!(
            r#"{"trial":1,"place":{"width_um":1000000,"height_um":800000,"obstacles":["#,
            r#"{"kind":"rect","x_um":15000,"y_um":20000,"w_um":30000,"h_um":40000},"#,
            r#"{"kind":"circle","x_um":500000,"y_um":600000,"radius_um":70000},"#,
            r#"{"kind":"polygon","points_um":[[800000,100000],[900000,100000],[850000,200000]]}],"#,
            r#""step_um":40000,"max_turn_udeg":45000000,"contact_radius_um":20000,"#,
            r#""sensors":[{"side":"front","mount_um":[10000,-5000],"axis_udeg":0,"#,
            r#""half_field_udeg":45000000,"rays":19,"min_um":0,"max_um":400000}]},"#,
            r#""start":{"x_um":120000,"y_um":135000,"heading_udeg":-90000000},"#,
            r#""goal":{"x_um":700000,"y_um":400000,"radius_um":120000}}"#,
        );
        assert_eq!(json(&Arena::new(1, &scenario, false)), expected);
        for (from, to) in [
            (r#""w_um""#, r#""w_cm""#),
            (r#""step_um""#, r#""name":1,"step_um""#),
            (r#""radius_um":12"#, r#""r_um":1,"radius_um":12"#),
            (r#""rays":19"#, r#""rays":19,"age":1"#),
            (r#""circle""#, r#""disc""#),
            ("120000,", "1.2,"),
        ] {
            let changed = expected.replace(from, to);
            serde_json::from_str::<Arena>(&changed).expect_err(to);
        }
    }

    #[test]
    fn impossible_arenas_are_refused() {
        let message = Arena::new(3, &scenario(), false);
        let mut with_flat = message.clone();
        let points_cm = vec![[0.0, 0.0], [1.0, 0.0]];
        let place = with_flat.place.as_mut().unwrap();
        place.obstacles.push(Outline::Polygon { points_cm });
        let refused = with_flat.scenario(None).err();
        assert_eq!(refused, Some(NoArena::Impossible(3)));
        let nowhere = Arena {
            place: None,
            ..message
        };
        assert_eq!(nowhere.scenario(None).err(), Some(NoArena::Nowhere(3)));
    }
}
