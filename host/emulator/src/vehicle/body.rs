//! The vehicle's body in its arena: where its wheels take it, and where it is stopped.

use std::sync::Arc;

use rover_simulator::arena::{Pose, Vector, World, degrees, radians};

/// A disc that stands in an arena.
///
/// The rover is a square of 35 cm, taken to be the disc that fits into it, as the simulator has it
/// (`RobotModel::rover`): so board and simulator meet obstacles at the same places, and a
/// turn on the spot is always possible, which is how the rule of motion has it. A real rover's
/// corners reach 7 cm farther.
#[derive(Clone, Debug)]
pub(super) struct Body {
    world: Arc<World>,
    radius_cm: f64,
    /// Distance between the lines on which the two sides roll, as turns on the spot see it.
    track_cm: f64,
    place: Vector,
    /// Counter-clockwise from the x axis; goes on growing over whole turns.
    heading_rad: f64,
    /// The body can move so far in any direction before it can meet anything.
    slack_cm: f64,
    touching: bool,
}

/// What is nearer than this touches.
const TOUCH_CM: f64 = 0.02;
/// Coefficient of friction of the bumper: it sticks where the way into the wall is steeper than
/// 59 degrees and slides along where it is not.
const FRICTION: f64 = 0.6;

impl Body {
    pub(super) fn new(world: Arc<World>, start: Pose, radius_cm: f64, track_cm: f64) -> Self {
        let mut body = Self {
            world,
            radius_cm,
            track_cm,
            place: start.position(),
            heading_rad: 0.0,
            slack_cm: 0.0,
            touching: false,
        };
        body.put(start);
        body
    }

    /// Puts the body somewhere, whether there is room or not.
    pub(super) fn put(&mut self, pose: Pose) {
        self.place = pose.position();
        self.heading_rad = radians(pose.heading);
        self.slack_cm = self.world.clearance(self.place) - self.radius_cm;
        self.touching = self.slack_cm < TOUCH_CM;
    }

    pub(super) fn pose(&self) -> Pose {
        Pose {
            x_cm: self.place.x,
            y_cm: self.place.y,
            heading: degrees(self.heading_rad.to_degrees()),
        }
    }

    pub(super) fn heading_rad(&self) -> f64 {
        self.heading_rad
    }

    pub(super) fn touching(&self) -> bool {
        self.touching
    }

    /// Rolls for `seconds` at these speeds over ground, in cm/s, as far as nothing is in the way.
    pub(super) fn roll(&mut self, [left, right]: [f64; 2], seconds: f64) {
        let turn = (right - left) / self.track_cm * seconds;
        let (sin, cos) = libm::sincos(self.heading_rad + turn / 2.0);
        self.heading_rad += turn;
        let way = Vector::new(cos, sin) * ((left + right) / 2.0 * seconds);
        let length = way.length();
        if length == 0.0 {
            return;
        }
        if length + TOUCH_CM < self.slack_cm {
            self.slack_cm -= length;
            self.touching = false;
            self.place += way;
        } else if !self.try_to_go(way) {
            let along = self.along(way);
            if along.length() == 0.0 || !self.try_to_go(along) {
                self.touching = true;
            }
        }
    }

    /// Goes where there is room, or where there is more of it than here.
    fn try_to_go(&mut self, way: Vector) -> bool {
        let slack = self.world.clearance(self.place + way) - self.radius_cm;
        let free = slack >= 0.0 || slack > self.world.clearance(self.place) - self.radius_cm;
        if free {
            self.place += way;
            self.slack_cm = slack;
            self.touching = slack < TOUCH_CM;
        }
        free
    }

    /// What is left of a way into something: along its face, less the friction.
    fn along(&self, way: Vector) -> Vector {
        const SMALL: f64 = 1e-4;
        let clearance = |x, y| self.world.clearance(self.place + Vector::new(x, y));
        let away = Vector::new(
            clearance(SMALL, 0.0) - clearance(-SMALL, 0.0),
            clearance(0.0, SMALL) - clearance(0.0, -SMALL),
        );
        let Some(away) = away.try_normalize() else {
            return Vector::ZERO;
        };
        let into = -way.dot(away);
        let along = way + away * into;
        let left = along.length() - FRICTION * into.max(0.0);
        // A little outwards, so that rounding does not lead into a face that is not straight.
        along.try_normalize().map_or(Vector::ZERO, |direction| {
            (direction + away * 1e-3) * left.max(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use rover_simulator::arena::{Circle, Obstacle, Rect};

    fn world() -> Arc<World> {
        let rect = Rect {
            x_cm: 120.0,
            y_cm: 40.0,
            w_cm: 30.0,
            h_cm: 30.0,
        };
        let circle = Circle {
            x_cm: 60.0,
            y_cm: 140.0,
            r_cm: 15.0,
        };
        let obstacles = vec![Obstacle::Rect(rect), Obstacle::Circle(circle)];
        Arc::new(World::new(200.0, 200.0, obstacles))
    }

    fn body(x_cm: f64, y_cm: f64, heading_deg: f64) -> Body {
        let heading = degrees(heading_deg);
        Body::new(
            world(),
            Pose {
                x_cm,
                y_cm,
                heading,
            },
            17.5,
            33.0,
        )
    }

    fn roll(body: &mut Body, speeds: [f64; 2], milliseconds: u32) {
        (0..milliseconds).for_each(|_| body.roll(speeds, 0.001));
    }

    #[test]
    fn it_rolls_straight_turns_on_the_spot_and_bends() {
        let mut straight = body(100.0, 100.0, 90.0);
        roll(&mut straight, [10.0, 10.0], 2_000);
        let pose = straight.pose();
        assert!((pose.x_cm - 100.0).abs() < 1e-6 && (pose.y_cm - 120.0).abs() < 1e-6);
        let mut spot = body(100.0, 100.0, 0.0);
        roll(&mut spot, [-16.5, 16.5], 1_571);
        assert!(
            (spot.heading_rad() - 1.571).abs() < 1e-9,
            "{}",
            spot.heading_rad()
        );
        assert_eq!(spot.pose().position(), Vector::new(100.0, 100.0));
        // A quarter of a circle of radius 33 to the left.
        let mut bend = body(100.0, 100.0, 0.0);
        let quarter = std::f64::consts::FRAC_PI_2;
        roll(&mut bend, [16.5 * quarter, 49.5 * quarter], 1_000);
        let pose = bend.pose();
        assert!((pose.x_cm - 133.0).abs() < 1e-3 && (pose.y_cm - 133.0).abs() < 1e-3);
    }

    #[test]
    fn a_wall_stops_it_and_it_comes_free_backwards() {
        let mut body = body(30.0, 100.0, 180.0);
        roll(&mut body, [20.0, 20.0], 2_000);
        assert!(body.touching());
        assert!(
            (17.5..17.53).contains(&body.pose().x_cm),
            "{}",
            body.pose().x_cm
        );
        let steps = (0..1_000).map(|_| {
            let before = body.place;
            roll(&mut body, [20.0, 20.0], 1);
            body.place.distance(before)
        });
        assert!(steps.sum::<f64>() < 1e-3, "the wheels slip");
        roll(&mut body, [-20.0, -20.0], 500);
        assert!(!body.touching() && (body.pose().x_cm - 27.5).abs() < 0.1);
    }

    #[test]
    fn it_slides_along_what_it_meets_at_a_slant_and_sticks_at_what_it_meets_squarely() {
        let mut slant = body(30.0, 100.0, 225.0);
        roll(&mut slant, [20.0, 20.0], 3_000);
        let pose = slant.pose();
        assert!(slant.touching() && (17.5..18.0).contains(&pose.x_cm));
        // Of each centimetre (0.71 - 0.6 * 0.71) of one are left.
        assert!((70.0..80.0).contains(&pose.y_cm), "{}", pose.y_cm);
        let mut square = body(30.0, 100.0, 205.0);
        roll(&mut square, [20.0, 20.0], 3_000);
        let fallen = 100.0 - square.pose().y_cm;
        assert!(
            (5.0..6.5).contains(&fallen),
            "sticks where it first touches: {fallen}"
        );
    }

    #[test]
    fn it_turns_on_the_spot_even_where_it_touches() {
        let mut body = body(17.5, 17.5, 225.0);
        assert!(body.touching());
        roll(&mut body, [-16.5, 16.5], 500);
        assert!((body.heading_rad().to_degrees() + 135.0 - 28.65).abs() < 0.1);
    }

    proptest! {
        #[test]
        fn it_is_never_inside_anything(
            moves in prop::collection::vec((-60.0..60.0f64, -60.0..60.0f64, 1u32..400), 1..60),
            heading in -180.0..180.0f64,
        ) {
            let mut body = body(40.0, 60.0, heading);
            for (left, right, milliseconds) in moves {
                for _ in 0..milliseconds {
                    let before = body.pose().position();
                    body.roll([left, right], 0.001);
                    let clearance = body.world.clearance(body.pose().position());
                    prop_assert!(clearance >= 17.5, "{clearance}");
                    let step = body.pose().position().distance(before);
                    prop_assert!(step <= 0.061);
                    prop_assert!(body.slack_cm <= clearance - 17.5 + 1e-9);
                }
            }
        }
    }
}
