//! Checks an arena file value by value: every error names its line.

use std::ops::Range;
use std::path::Path;

use parry2d_f64::math::Vector;
use toml::Spanned;

use super::entry::{
    ArenaEntry, CircleEntry, GoalEntry, ModelEntry, Number, PolygonEntry, RectEntry, RobotEntry,
    StartEntry,
};
use super::error::ArenaError;
use super::files::Files;
use super::map_server;
use super::model::{RobotModel, Side};
use super::obstacle::{Circle, Obstacle, Polygon, Rect};
use super::pose::{Pose, degrees};
use super::scenario::Goal;
use super::world::World;

/// No arena is larger: 1 km, a quarter of what a distance sample can hold.
const LARGEST_CM: f64 = 100_000.0;

/// The text of an arena file, for errors that name the line.
pub(super) struct Text<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Text<'_> {
    pub(super) fn at(&self, span: &Range<usize>, problem: impl Into<String>) -> ArenaError {
        let line = 1 + self
            .text
            .bytes()
            .take(span.start)
            .filter(|b| *b == b'\n')
            .count();
        ArenaError::line(self.path, line, problem)
    }

    fn number(&self, name: &str, n: &Number, range: Range<f64>) -> Result<f64, ArenaError> {
        let (value, Range { start, end }) = (*n.get_ref(), range);
        if value.is_finite() && (start..=end).contains(&value) {
            return Ok(value);
        }
        let expected = format!("`{name}` is {value}, but must be between {start} and {end}");
        Err(self.at(&n.span(), expected))
    }

    fn positive(&self, name: &str, n: &Number, most: f64) -> Result<f64, ArenaError> {
        if *n.get_ref() > 0.0 {
            return self.number(name, n, 0.0..most);
        }
        let expected = format!("`{name}` is {}, but must be greater than 0", n.get_ref());
        Err(self.at(&n.span(), expected))
    }

    pub(super) fn world(&self, entry: &ArenaEntry, files: &mut Files) -> Result<World, ArenaError> {
        let (size, mut obstacles) = self.size(entry, files)?;
        for rect in &entry.rect {
            let shape = Obstacle::Rect(self.rect(rect.get_ref())?);
            obstacles.push(self.inside("rectangle", &rect.span(), shape, size)?);
        }
        for circle in &entry.circle {
            let shape = Obstacle::Circle(self.circle(circle.get_ref())?);
            obstacles.push(self.inside("circle", &circle.span(), shape, size)?);
        }
        for polygon in &entry.polygon {
            let shape = Obstacle::Polygon(self.polygon(polygon.get_ref())?);
            obstacles.push(self.inside("polygon", &polygon.span(), shape, size)?);
        }
        let [width, height] = size;
        Ok(World::new(width, height, obstacles))
    }

    /// The arena's width and height, and the map that they are from.
    fn size(
        &self,
        entry: &ArenaEntry,
        files: &mut Files,
    ) -> Result<([f64; 2], Vec<Obstacle>), ArenaError> {
        let missing = |key: &str| {
            ArenaError::file(self.path, format!("`{key}` is missing: expected a number"))
        };
        match (&entry.width_cm, &entry.height_cm, &entry.map) {
            (Some(width), Some(height), None) => {
                let width = self.positive("width_cm", width, LARGEST_CM)?;
                let height = self.positive("height_cm", height, LARGEST_CM)?;
                Ok(([width, height], Vec::new()))
            }
            (None, None, Some(map)) => {
                let beside = self.path.parent().unwrap_or(Path::new(""));
                let map = map_server::load(&beside.join(map.get_ref()), files)?;
                let map = Obstacle::Grid(map);
                let [_, size] = map.bounds_cm();
                Ok((size.to_array(), vec![map]))
            }
            (None, _, None) => Err(missing("width_cm")),
            (_, None, None) => Err(missing("height_cm")),
            (_, _, Some(map)) => {
                let problem = "`map` gives the size: expected no `width_cm` and `height_cm`";
                Err(self.at(&map.span(), problem))
            }
        }
    }

    fn inside(
        &self,
        what: &str,
        span: &Range<usize>,
        shape: Obstacle,
        [width, height]: [f64; 2],
    ) -> Result<Obstacle, ArenaError> {
        let [low, high] = shape.bounds_cm();
        if low.x >= 0.0 && low.y >= 0.0 && high.x <= width && high.y <= height {
            return Ok(shape);
        }
        let problem = format!(
            "the {what} reaches from ({}, {}) to ({}, {}): expected it inside the walls, from \
             (0, 0) to ({width}, {height})",
            low.x, low.y, high.x, high.y
        );
        Err(self.at(span, problem))
    }

    fn rect(&self, entry: &RectEntry) -> Result<Rect, ArenaError> {
        Ok(Rect {
            x_cm: self.number("x_cm", &entry.x_cm, 0.0..LARGEST_CM)?,
            y_cm: self.number("y_cm", &entry.y_cm, 0.0..LARGEST_CM)?,
            w_cm: self.positive("w_cm", &entry.w_cm, LARGEST_CM)?,
            h_cm: self.positive("h_cm", &entry.h_cm, LARGEST_CM)?,
        })
    }

    fn circle(&self, entry: &CircleEntry) -> Result<Circle, ArenaError> {
        Ok(Circle {
            x_cm: self.number("x_cm", &entry.x_cm, 0.0..LARGEST_CM)?,
            y_cm: self.number("y_cm", &entry.y_cm, 0.0..LARGEST_CM)?,
            r_cm: self.positive("r_cm", &entry.r_cm, LARGEST_CM)?,
        })
    }

    fn polygon(&self, entry: &PolygonEntry) -> Result<Polygon, ArenaError> {
        let wrong = |problem| self.at(&entry.points_cm.span(), problem);
        let point = |(i, numbers): (usize, &Vec<f64>)| match numbers[..] {
            [x, y] => Ok([x, y]),
            _ => Err(wrong(format!(
                "point {} of `points_cm` has {} numbers: expected x and y",
                i + 1,
                numbers.len()
            ))),
        };
        let points = entry.points_cm.get_ref().iter().enumerate().map(point);
        Polygon::new(points.collect::<Result<_, _>>()?)
            .map_err(|e| wrong(format!("`points_cm` is no polygon: {e}")))
    }

    pub(super) fn start(
        &self,
        entry: &Spanned<StartEntry>,
        world: &World,
        robot: &RobotModel,
    ) -> Result<Pose, ArenaError> {
        let start = entry.get_ref();
        let pose = Pose {
            x_cm: self.number("x_cm", &start.x_cm, 0.0..world.width_cm())?,
            y_cm: self.number("y_cm", &start.y_cm, 0.0..world.height_cm())?,
            heading: degrees(self.number("heading_deg", &start.heading_deg, -360.0..360.0)?),
        };
        self.free("start", &entry.span(), pose.position(), world, robot)?;
        Ok(pose)
    }

    pub(super) fn goal(
        &self,
        entry: &Spanned<GoalEntry>,
        world: &World,
        robot: &RobotModel,
    ) -> Result<Goal, ArenaError> {
        let goal = entry.get_ref();
        let goal = Goal {
            x_cm: self.number("x_cm", &goal.x_cm, 0.0..world.width_cm())?,
            y_cm: self.number("y_cm", &goal.y_cm, 0.0..world.height_cm())?,
            radius_cm: self.positive("radius_cm", &goal.radius_cm, LARGEST_CM)?,
        };
        self.free("goal", &entry.span(), goal.position(), world, robot)?;
        Ok(goal)
    }

    /// Checks that the robot can stand at a place.
    fn free(
        &self,
        what: &str,
        span: &Range<usize>,
        place: Vector,
        world: &World,
        robot: &RobotModel,
    ) -> Result<(), ArenaError> {
        let (clearance, needs) = (world.clearance(place), robot.contact_radius_cm);
        if clearance >= needs {
            return Ok(());
        }
        let Vector { x, y } = place;
        let problem = if clearance == 0.0 {
            format!("lies in an obstacle or wall: expected {needs} cm free around it")
        } else {
            format!(
                "cannot stand free: {clearance:.1} cm from an obstacle or wall, where the robot \
                 needs {needs} cm"
            )
        };
        Err(self.at(span, format!("the {what} at ({x}, {y}) {problem}")))
    }

    pub(super) fn robot(&self, entry: &RobotEntry) -> Result<RobotModel, ArenaError> {
        let mut robot = match (entry.model, &entry.beam_deg) {
            (ModelEntry::Rover, None) => RobotModel::rover(10.0),
            (ModelEntry::Rover, Some(beam)) => {
                RobotModel::rover(self.number("beam_deg", beam, 1.0..90.0)?)
            }
            (_, Some(beam)) => {
                return Err(self.at(&beam.span(), "`beam_deg` needs `model = \"rover\"`"));
            }
            (ModelEntry::Paper, None) => RobotModel::paper(),
            (ModelEntry::Harder, None) => RobotModel::harder(),
        };
        if let Some(step) = &entry.step_cm {
            robot.step_cm = self.positive("step_cm", step, LARGEST_CM)?;
        }
        if let Some(radius) = &entry.contact_radius_cm {
            robot.contact_radius_cm = self.positive("contact_radius_cm", radius, LARGEST_CM)?;
        }
        for sensor in &mut robot.sensors {
            let (name, range) = match sensor.side {
                Side::Front => ("front_range_cm", &entry.front_range_cm),
                Side::Left | Side::Right => ("side_range_cm", &entry.side_range_cm),
            };
            if let Some(range) = range {
                // At least a centimetre between the readings that -1 and 1 stand for.
                sensor.max_cm = self.number(name, range, sensor.min_cm + 1.0..LARGEST_CM)?;
            }
        }
        Ok(robot)
    }
}
