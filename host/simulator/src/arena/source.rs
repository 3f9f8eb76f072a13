//! Where arenas come from: a random layout, or a file.

use std::path::Path;
use std::sync::Arc;

use parry2d_f64::math::Vector;
use rand_pcg::Pcg32;

use super::error::ArenaError;
use super::fixed::{Fixed, Task};
use super::grid::OccupancyGrid;
use super::layout::{GOAL_RADIUS_CM, Layout};
use super::model::RobotModel;
use super::obstacle::Obstacle;
use super::robot::Pose;
use super::world::World;
use super::{file, map_server};

/// What a robot has to reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// From the left wall.
    pub x_cm: f64,
    /// From the lower wall.
    pub y_cm: f64,
    /// Reached when the robot's centre is no farther away than this.
    pub radius_cm: f64,
}

/// Everything that a trial starts from.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Walls and obstacles.
    pub world: Arc<World>,
    /// The robot's body and sensors.
    pub robot: RobotModel,
    /// Where the robot starts.
    pub start: Pose,
    /// What it has to reach; `None` where the task is to follow a direction.
    pub goal: Option<Goal>,
}

/// Something that yields an arena for every trial.
#[derive(Clone, Debug)]
pub struct ArenaSource(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Layout(Layout),
    Fixed(Fixed),
}

impl Goal {
    /// The goal's centre.
    pub fn position(&self) -> Vector {
        Vector::new(self.x_cm, self.y_cm)
    }
}

impl Scenario {
    /// The distance from start to the centre of the goal, which paths are compared with; `None`
    /// without a goal.
    pub fn straight_cm(&self) -> Option<f64> {
        self.goal
            .map(|goal| goal.position().distance(self.start.position()))
    }
}

impl From<Layout> for ArenaSource {
    fn from(layout: Layout) -> Self {
        Self(Kind::Layout(layout))
    }
}

impl ArenaSource {
    /// A built-in arena by its name, or an arena file.
    ///
    /// | name | is |
    /// |---|---|
    /// | `paper` | [`Layout::paper`] |
    /// | `harder` | [`Layout::harder`] |
    /// | `free` | [`Layout::free`] |
    /// | `rover` | [`Layout::rover`]: 3 m, three obstacles, fields of 10 degrees |
    /// | `rover-5m` | [`Layout::rover`]: 5 m, three obstacles, fields of 10 degrees |
    ///
    /// # Errors
    /// If there is no such arena, or the file is not a valid one.
    pub fn load(spec: &str) -> Result<Self, ArenaError> {
        let layout = match spec {
            "paper" => Layout::paper(),
            "harder" => Layout::harder(),
            "free" => Layout::free(),
            "rover" => Layout::rover(300.0, 3, 10.0),
            "rover-5m" => Layout::rover(500.0, 3, 10.0),
            _ => return Self::load_file(Path::new(spec)),
        };
        Ok(layout.into())
    }

    /// An arena file: TOML, or a `map_server` map.
    ///
    /// # Errors
    /// If the file is not a valid one.
    pub fn load_file(path: &Path) -> Result<Self, ArenaError> {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        let fixed = match extension.to_ascii_lowercase().as_str() {
            "toml" => file::load(path)?,
            "yaml" | "yml" => map_arena(path, map_server::load(path)?)?,
            _ => return Err(ArenaError::Unknown(path.display().to_string())),
        };
        Ok(Self(Kind::Fixed(fixed)))
    }

    /// An arena by the text of its file; `path` is for errors, and for the place of a map that the
    /// text names.
    ///
    /// # Errors
    /// If the text is not that of a valid arena file.
    pub fn from_toml(path: &Path, text: &str) -> Result<Self, ArenaError> {
        Ok(Self(Kind::Fixed(file::parse(path, text)?)))
    }

    /// A `map_server` map by the contents of its YAML file and of its image; `path` is for errors.
    ///
    /// # Errors
    /// If they are not those of a valid map.
    pub fn from_map(path: &Path, yaml: &str, image: &[u8]) -> Result<Self, ArenaError> {
        let map = map_server::from_contents(path, yaml, image)?;
        Ok(Self(Kind::Fixed(map_arena(path, map)?)))
    }

    /// The arena of the next trial: all that is left to chance is drawn from `rng`.
    pub fn scenario(&self, rng: &mut Pcg32) -> Scenario {
        match &self.0 {
            Kind::Layout(layout) => layout.draw(rng),
            Kind::Fixed(fixed) => fixed.scenario(rng),
        }
    }

    /// The robot that is in all its arenas.
    pub fn robot(&self) -> &RobotModel {
        match &self.0 {
            Kind::Layout(layout) => &layout.robot,
            Kind::Fixed(fixed) => fixed.robot(),
        }
    }
}

/// A map alone: the paper's robot, and start and goal in random places.
fn map_arena(path: &Path, map: OccupancyGrid) -> Result<Fixed, ArenaError> {
    let map = Obstacle::Grid(map);
    let [_, size] = map.bounds_cm();
    let world = World::new(size.x, size.y, vec![map]);
    let task = Task::ReachAnywhere {
        radius_cm: GOAL_RADIUS_CM,
    };
    Fixed::new(world, RobotModel::paper(), None, task).map_err(|problem| ArenaError::File {
        path: path.to_path_buf(),
        problem,
    })
}
