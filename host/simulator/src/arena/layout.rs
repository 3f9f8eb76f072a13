//! Random arenas: rectangles, a start and a goal, drawn until all gaps are wide enough.

use std::sync::Arc;

use parry2d_f64::math::Vector;
use rand_pcg::Pcg32;

use super::model::RobotModel;
use super::obstacle::{Obstacle, Rect};
use super::pose::{Pose, degrees};
use super::scenario::{Goal, Scenario};
use super::world::World;
use crate::chance::{direction, uniform};

/// A recipe for random arenas.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Inner width.
    pub width_cm: f64,
    /// Inner height.
    pub height_cm: f64,
    /// How many rectangles.
    pub rectangles: usize,
    /// Shortest and longest side of a rectangle; sides are uniform between them.
    pub side_cm: [f64; 2],
    /// Least distance between two rectangles, and between a rectangle and a wall: there is always
    /// a way past on both sides.
    pub gap_cm: f64,
    /// Room around start and goal.
    pub margins: Margins,
    /// Radius of the goal; `None` where the task is to follow a direction.
    pub goal_radius_cm: Option<f64>,
    /// How far to either side the goal may lie from where the robot points at the start.
    pub goal_within_deg: f64,
    /// The robot.
    pub robot: RobotModel,
}

/// How much room a random start and goal have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margins {
    /// Least clearance of the start.
    pub start_cm: f64,
    /// Least clearance of the goal.
    pub goal_cm: f64,
    /// Least distance from start to goal.
    pub apart_cm: f64,
}

/// A goal is reached within this distance, in the built-in arenas and where a file does not say.
pub(super) const GOAL_RADIUS_CM: f64 = 12.0;

/// Draws of one rectangle or place before everything is drawn afresh. In 10,000 arenas, neither of
/// the target tasks ever needed a second attempt, and the rover's room of 3 m 507 times.
const DRAWS: usize = 200;

impl Margins {
    /// For the paper's arena and for whatever is not much unlike it.
    pub const PAPER: Self = Self {
        start_cm: 20.0,
        goal_cm: 25.0,
        apart_cm: 60.0,
    };
}

impl Layout {
    /// The arena of III-A: 489 by 185, "sparse obstacles randomly distributed": here four
    /// rectangles, 10 to 30 a side, with gaps of at least 36. A goal is reached within 12.
    pub fn paper() -> Self {
        Self {
            width_cm: 489.0,
            height_cm: 185.0,
            rectangles: 4,
            side_cm: [10.0, 30.0],
            gap_cm: 36.0,
            margins: Margins::PAPER,
            goal_radius_cm: Some(GOAL_RADIUS_CM),
            goal_within_deg: 180.0,
            robot: RobotModel::paper(),
        }
    }

    /// The paper's arena with six rectangles, and a robot twice as wide that moves in longer steps.
    pub fn harder() -> Self {
        Self {
            rectangles: 6,
            robot: RobotModel::harder(),
            ..Self::paper()
        }
    }

    /// No obstacles, and walls that are out of sight of the straight way from start to goal: for
    /// the directedness of (8) in free space. As in the paper's first test (Fig. 5), the goal lies
    /// ahead, up to 90 degrees aside: to turn round first (Fig. 6) takes moves of its own.
    pub fn free() -> Self {
        Self {
            width_cm: 1000.0,
            height_cm: 1000.0,
            rectangles: 0,
            margins: Margins {
                start_cm: 300.0,
                goal_cm: 100.0,
                apart_cm: 150.0,
            },
            goal_within_deg: 90.0,
            ..Self::paper()
        }
    }

    /// A square room for the rover, to follow a direction in (IV-C: 3 m with three obstacles).
    /// Obstacles are 20 to 40 cm a side and 60 cm apart: the rover is 35 cm wide and cannot see
    /// what is nearer than 14 cm.
    pub fn rover(side_cm: f64, obstacles: usize, beam_deg: f64) -> Self {
        Self {
            width_cm: side_cm,
            height_cm: side_cm,
            rectangles: obstacles,
            side_cm: [20.0, 40.0],
            gap_cm: 60.0,
            margins: Margins {
                start_cm: 25.0,
                goal_cm: 0.0,
                apart_cm: 0.0,
            },
            goal_radius_cm: None,
            goal_within_deg: 180.0,
            robot: RobotModel::rover(beam_deg),
        }
    }

    /// Draws an arena. Each rectangle and place is drawn up to 200 times; if none fits, everything
    /// is drawn afresh, with one rectangle less after every 100 failures. A layout that cannot hold
    /// its rectangles therefore ends with fewer of them; the layouts above never do.
    ///
    /// # Panics
    /// If the margins leave no place even in the empty arena.
    pub fn draw(&self, rng: &mut Pcg32) -> Scenario {
        for attempt in 0..100 * (self.rectangles + 1) {
            let rectangles = self.rectangles - attempt / 100;
            if let Some(scenario) = self.attempt(rectangles, rng) {
                return scenario;
            }
        }
        panic!("the margins of a layout fit into the empty arena")
    }

    fn attempt(&self, rectangles: usize, rng: &mut Pcg32) -> Option<Scenario> {
        let mut placed: Vec<Rect> = Vec::with_capacity(rectangles);
        for _ in 0..rectangles {
            let mut draws = (0..DRAWS).map(|_| self.rectangle(rng));
            let fits = |rect: &Rect| placed.iter().all(|other| gap(rect, other) >= self.gap_cm);
            let next = draws.find(fits)?;
            placed.push(next);
        }
        let obstacles = placed.into_iter().map(Obstacle::Rect).collect();
        let world = World::new(self.width_cm, self.height_cm, obstacles);
        let (mut start, goal) = self.margins.draw(&world, self.goal_radius_cm, rng)?;
        if let Some(goal) = goal.filter(|_| self.goal_within_deg < 180.0) {
            let to = goal.position() - start.position();
            let aside = uniform(rng, -self.goal_within_deg, self.goal_within_deg);
            start.heading = degrees(libm::atan2(to.y, to.x).to_degrees() + aside);
        }
        Some(Scenario {
            world: Arc::new(world),
            robot: self.robot.clone(),
            start,
            goal,
        })
    }

    /// A rectangle that keeps its distance from the walls.
    fn rectangle(&self, rng: &mut Pcg32) -> Rect {
        let [shortest, longest] = self.side_cm;
        let w_cm = uniform(rng, shortest, longest);
        let h_cm = uniform(rng, shortest, longest);
        let x_cm = uniform(rng, self.gap_cm, self.width_cm - self.gap_cm - w_cm);
        let y_cm = uniform(rng, self.gap_cm, self.height_cm - self.gap_cm - h_cm);
        Rect {
            x_cm,
            y_cm,
            w_cm,
            h_cm,
        }
    }
}

/// The distance between two rectangles, 0 if they overlap.
fn gap(a: &Rect, b: &Rect) -> f64 {
    let between = |a: f64, a_size: f64, b: f64, b_size: f64| {
        (b - (a + a_size)).max(a - (b + b_size)).max(0.0)
    };
    let across = between(a.x_cm, a.w_cm, b.x_cm, b.w_cm);
    let along = between(a.y_cm, a.h_cm, b.y_cm, b.h_cm);
    Vector::new(across, along).length()
}

impl Margins {
    /// A start with any heading and, if there is a `radius_cm`, a goal; `None` if the draws of one
    /// of them found no room.
    fn draw(
        &self,
        world: &World,
        radius_cm: Option<f64>,
        rng: &mut Pcg32,
    ) -> Option<(Pose, Option<Goal>)> {
        let start = self.start(world, None, |_| true, rng)?;
        let goal = match radius_cm {
            None => None,
            Some(radius) => Some(self.goal(world, start.position(), radius, |_| true, rng)?),
        };
        Some((start, goal))
    }

    /// A start in an acceptable place, far enough from `goal`.
    pub(super) fn start(
        &self,
        world: &World,
        goal: Option<Vector>,
        accept: impl Fn(Vector) -> bool,
        rng: &mut Pcg32,
    ) -> Option<Pose> {
        let Vector { x, y } = self.place(world, self.start_cm, goal, accept, rng)?;
        Some(Pose {
            x_cm: x,
            y_cm: y,
            heading: direction(rng),
        })
    }

    /// A goal in an acceptable place, far enough from `start`.
    pub(super) fn goal(
        &self,
        world: &World,
        start: Vector,
        radius_cm: f64,
        accept: impl Fn(Vector) -> bool,
        rng: &mut Pcg32,
    ) -> Option<Goal> {
        let Vector { x, y } = self.place(world, self.goal_cm, Some(start), accept, rng)?;
        Some(Goal {
            x_cm: x,
            y_cm: y,
            radius_cm,
        })
    }

    /// The first of [`DRAWS`] random places that is acceptable, clear, and far enough from
    /// `other`.
    fn place(
        &self,
        world: &World,
        clearance_cm: f64,
        other: Option<Vector>,
        accept: impl Fn(Vector) -> bool,
        rng: &mut Pcg32,
    ) -> Option<Vector> {
        let mut draws = (0..DRAWS).map(|_| {
            Vector::new(
                uniform(rng, 0.0, world.width_cm()),
                uniform(rng, 0.0, world.height_cm()),
            )
        });
        draws.find(|place| {
            other.is_none_or(|other| place.distance(other) >= self.apart_cm)
                && world.clearance(*place) >= clearance_cm
                && accept(*place)
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn rectangles(scenario: &Scenario) -> Vec<Rect> {
        let rect = |obstacle: &Obstacle| match obstacle {
            Obstacle::Rect(rect) => *rect,
            other => panic!("layouts hold rectangles only, not {other:?}"),
        };
        scenario.world.obstacles().iter().map(rect).collect()
    }

    /// All that a layout promises of each of its arenas.
    fn check(layout: &Layout, scenario: &Scenario) {
        let (rects, world) = (rectangles(scenario), &scenario.world);
        assert_eq!(rects.len(), layout.rectangles);
        assert_eq!(
            (world.width_cm(), world.height_cm()),
            (layout.width_cm, layout.height_cm)
        );
        let [shortest, longest] = layout.side_cm;
        for (i, r) in rects.iter().enumerate() {
            assert!(
                [r.w_cm, r.h_cm]
                    .iter()
                    .all(|side| (shortest..longest).contains(side))
            );
            let to_right = layout.width_cm - (r.x_cm + r.w_cm);
            let to_top = layout.height_cm - (r.y_cm + r.h_cm);
            let to_walls = r.x_cm.min(r.y_cm).min(to_right).min(to_top);
            assert!(to_walls >= layout.gap_cm - 1e-9, "{to_walls} to a wall");
            assert!(
                rects[..i]
                    .iter()
                    .all(|other| gap(r, other) >= layout.gap_cm)
            );
        }
        assert!(world.clearance(scenario.start.position()) >= layout.margins.start_cm);
        assert_eq!(scenario.goal.is_some(), layout.goal_radius_cm.is_some());
        if let (Some(goal), Some(straight)) = (scenario.goal, scenario.straight_cm()) {
            assert!(world.clearance(goal.position()) >= layout.margins.goal_cm);
            assert!(straight >= layout.margins.apart_cm);
        }
        assert_eq!(scenario.robot, layout.robot);
    }

    proptest! {
        #[test]
        fn every_arena_keeps_what_its_layout_promises(seed: u64) {
            let layouts = [
                Layout::paper(),
                Layout::harder(),
                Layout::free(),
                Layout::rover(300.0, 3, 10.0),
                Layout::rover(500.0, 3, 30.0),
            ];
            for layout in layouts {
                check(&layout, &layout.draw(&mut Pcg32::new(seed, 9)));
            }
        }

        #[test]
        fn the_gap_is_what_the_distances_of_corners_say(
            (x, y, w, h) in (0.0..50.0, 0.0..50.0, 1.0..20.0, 1.0..20.0),
            (u, v) in (0.0..50.0f64, 0.0..50.0f64),
        ) {
            let a = Rect { x_cm: x, y_cm: y, w_cm: w, h_cm: h };
            // A rectangle without extent is a point, to which the distance is parry's.
            let point = Rect { x_cm: u, y_cm: v, w_cm: 0.0, h_cm: 0.0 };
            let distance = Obstacle::Rect(a).distance(Vector::new(u, v));
            prop_assert!((gap(&a, &point) - distance).abs() < 1e-9);
            prop_assert!((gap(&point, &a) - distance).abs() < 1e-9);
        }
    }

    #[test]
    fn an_overfull_layout_ends_with_fewer_rectangles() {
        let layout = Layout {
            rectangles: 40,
            ..Layout::paper()
        };
        let scenario = layout.draw(&mut Pcg32::new(1, 1));
        let found = rectangles(&scenario).len();
        assert!((5..40).contains(&found), "{found}");
    }
}
