//! The simulated world (III-A): an arena with walls and obstacles, a robot that senses it and
//! moves in it, and the arenas it is put into.
//!
//! Lengths are centimetres; one pixel of the paper's arena is one centimetre. The origin is the
//! lower left corner, x runs right and y up, angles are counter-clockwise, 90 degrees is up.
//! Positions are `f64`, and every function on them is exactly rounded or comes from `libm`, so that
//! a seed gives the same run on every machine. Ray casts and distances are `parry2d`'s.
//!
//! | file | holds |
//! |---|---|
//! | `world` | walls and obstacles: [`World::ray`], [`World::clearance`] |
//! | `obstacle`, `grid` | the shapes an obstacle can have |
//! | `model` | what a robot's body and sensors are: [`RobotModel`] |
//! | `pose` | poses and units |
//! | `scenario` | what a trial starts from: [`Scenario`] |
//! | `robot` | a robot in a world: [`Robot::sense`], [`Robot::act`] |
//! | `layout` | random arenas: [`Layout::paper`] and others |
//! | `source`, `files` | where arenas come from: [`ArenaSource::named`], [`ArenaSource::read`] |
//! | `file`, `entry`, `check` | arena files |
//! | `map_server` | maps of the Robot Operating System |
//! | `fixed`, `reach` | the arena that a file describes, and where its robot can get to |
//! | `place`, `whole` | arenas as logs have them: [`Place`] |

mod check;
mod entry;
mod error;
mod file;
mod files;
mod fixed;
mod grid;
mod layout;
mod map_server;
mod model;
mod obstacle;
mod place;
mod pose;
mod reach;
mod robot;
mod scenario;
mod source;
mod whole;
mod world;

pub use error::ArenaError;
pub use grid::OccupancyGrid;
pub use layout::{Layout, Margins};
pub use model::{RangeSensor, RobotModel, Side};
pub use obstacle::{Circle, Obstacle, Polygon, PolygonError, Rect};
pub use parry2d_f64::math::Vector;
pub use place::{Outline, Place};
pub use pose::{Pose, centimetres, degrees, micrometres, radians, to_degrees, unit};
pub use robot::{Motion, Robot};
pub use scenario::{Goal, Scenario};
pub use source::ArenaSource;
pub use world::World;
