//! Where arenas come from: a random layout, or a file.

use std::io;
use std::path::Path;

use rand_pcg::Pcg32;

use super::error::ArenaError;
use super::files::Files;
use super::fixed::{Fixed, Task};
use super::layout::{GOAL_RADIUS_CM, Layout};
use super::model::RobotModel;
use super::obstacle::Obstacle;
use super::scenario::Scenario;
use super::world::World;
use super::{file, map_server};

/// An arena for every trial.
#[derive(Clone, Debug)]
pub struct ArenaSource(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Layout(Layout),
    Fixed(Fixed),
}

impl From<Layout> for ArenaSource {
    fn from(layout: Layout) -> Self {
        Self(Kind::Layout(layout))
    }
}

impl ArenaSource {
    /// Bytes of the largest file that an arena can have, a map's image.
    pub const LARGEST_FILE: u64 = map_server::LARGEST_FILE;

    /// A built-in arena by its name.
    ///
    /// | name | is |
    /// |---|---|
    /// | `paper` | [`Layout::paper`] |
    /// | `harder` | [`Layout::harder`] |
    /// | `free` | [`Layout::free`] |
    /// | `rover` | [`Layout::rover`]: 3 m, three obstacles, fields of 10 degrees |
    /// | `rover-5m` | [`Layout::rover`]: 5 m, three obstacles, fields of 10 degrees |
    pub fn named(name: &str) -> Option<Self> {
        let layout = match name {
            "paper" => Layout::paper(),
            "harder" => Layout::harder(),
            "free" => Layout::free(),
            "rover" => Layout::rover(300.0, 3, 10.0),
            "rover-5m" => Layout::rover(500.0, 3, 10.0),
            _ => return None,
        };
        Some(layout.into())
    }

    /// An arena file (TOML) or a `map_server` map (YAML), by its ending. `read` returns the bytes
    /// of this file and of those it names, whose paths are relative to the same folder; no file
    /// needs to be read beyond [`LARGEST_FILE`](Self::LARGEST_FILE).
    ///
    /// # Errors
    /// If a file cannot be read or is not valid, or the ending is another.
    pub fn read(
        path: &Path,
        read: &mut dyn FnMut(&Path) -> io::Result<Vec<u8>>,
    ) -> Result<Self, ArenaError> {
        let files = &mut Files(read);
        let extension = path.extension().unwrap_or_default();
        let fixed = match extension.to_ascii_lowercase().to_str() {
            Some("toml") => file::load(path, files)?,
            Some("yaml" | "yml") => map_arena(path, files)?,
            _ => return Err(ArenaError::Unknown(path.display().to_string())),
        };
        Ok(Self(Kind::Fixed(fixed)))
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
fn map_arena(path: &Path, files: &mut Files) -> Result<Fixed, ArenaError> {
    let map = Obstacle::Grid(map_server::load(path, files)?);
    let [_, size] = map.bounds_cm();
    let world = World::new(size.x, size.y, vec![map]);
    let task = Task::ReachAnywhere {
        radius_cm: GOAL_RADIUS_CM,
    };
    Fixed::new(world, RobotModel::paper(), None, task)
        .map_err(|problem| ArenaError::file(path, problem))
}
