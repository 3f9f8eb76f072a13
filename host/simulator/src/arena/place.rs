//! An arena and its robot as logs have them: shapes whose numbers are whole micrometres.

use serde::{Deserialize, Serialize};

use super::grid::OccupancyGrid;
use super::model::RobotModel;
use super::obstacle::{Circle, Obstacle, Polygon, Rect};
use super::whole::um;
use super::world::World;

/// Walls, obstacles and the robot among them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Inner width.
    #[serde(rename = "width_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub width_cm: f64,
    /// Inner height.
    #[serde(rename = "height_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub height_cm: f64,
    /// The obstacles.
    pub obstacles: Vec<Outline>,
    /// The robot.
    #[serde(flatten)]
    pub robot: RobotModel,
}

/// The outline of an obstacle, which may come from anywhere: not yet known to be a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Outline {
    /// A rectangle. Maps are written as one for each run of occupied cells.
    Rect(Rect),
    /// A disc.
    Circle(Circle),
    /// A polygon.
    Polygon {
        /// Its corners, x and y.
        #[serde(rename = "points_um", with = "um")]
        #[cfg_attr(feature = "schema", schemars(with = "Vec<[i64; 2]>"))]
        points_cm: Vec<[f64; 2]>,
    },
}

/// Arenas wider than 10 km, and obstacles farther away, are refused.
const FARTHEST_CM: f64 = 1e6;
/// The least extent of an arena: one micrometre.
const LEAST_CM: f64 = 1e-4;

impl Place {
    /// A world and the robot in it. Maps are written as rectangles.
    pub fn new(world: &World, robot: &RobotModel) -> Self {
        Self {
            width_cm: world.width_cm(),
            height_cm: world.height_cm(),
            obstacles: world.obstacles().iter().flat_map(outlines).collect(),
            robot: robot.clone(),
        }
    }

    /// The world; `None` if it has no extent, more than 10 km, or an obstacle that is not a shape.
    pub fn world(&self) -> Option<World> {
        let (width, height) = (self.width_cm, self.height_cm);
        let extents = LEAST_CM..=FARTHEST_CM;
        if !(extents.contains(&width) && extents.contains(&height)) {
            return None;
        }
        let obstacles = self.obstacles.iter().map(Outline::obstacle);
        Some(World::new(width, height, obstacles.collect::<Option<_>>()?))
    }
}

impl Outline {
    fn obstacle(&self) -> Option<Obstacle> {
        let obstacle = match self {
            Self::Rect(rect) => Obstacle::Rect(*rect),
            Self::Circle(circle) => Obstacle::Circle(*circle),
            Self::Polygon { points_cm } => Obstacle::Polygon(Polygon::new(points_cm.clone()).ok()?),
        };
        let [low, high] = obstacle.bounds_cm();
        let inside = [low.x, low.y, high.x, high.y]
            .iter()
            .all(|number| number.abs() <= FARTHEST_CM);
        (inside && low.x <= high.x && low.y <= high.y).then_some(obstacle)
    }
}

fn outlines(obstacle: &Obstacle) -> Vec<Outline> {
    match obstacle {
        Obstacle::Rect(rect) => vec![Outline::Rect(*rect)],
        Obstacle::Circle(circle) => vec![Outline::Circle(*circle)],
        Obstacle::Polygon(polygon) => {
            let points = polygon.points().iter();
            vec![Outline::Polygon {
                points_cm: points.map(|point| point.to_array()).collect(),
            }]
        }
        Obstacle::Grid(grid) => runs(grid).map(Outline::Rect).collect(),
    }
}

/// A map's occupied cells, row by row, neighbours in one rectangle.
fn runs(grid: &OccupancyGrid) -> impl Iterator<Item = Rect> {
    let side = grid.cell_cm();
    let row_runs = move |row: usize| {
        let mut column = 0;
        std::iter::from_fn(move || {
            let from = (column..grid.columns()).find(|&c| grid.is_occupied(c, row))?;
            column = (from..grid.columns())
                .find(|&c| !grid.is_occupied(c, row))
                .unwrap_or(grid.columns());
            Some(Rect {
                x_cm: from as f64 * side,
                y_cm: row as f64 * side,
                w_cm: (column - from) as f64 * side,
                h_cm: side,
            })
        })
    };
    (0..grid.rows()).flat_map(row_runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_becomes_one_rectangle_for_each_run_of_cells() {
        let occupied = [true, true, false, true, false, false, false, false];
        let grid = OccupancyGrid::new(4, 5.0, occupied.to_vec());
        let rect = |x_cm, w_cm| Rect {
            x_cm,
            y_cm: 0.0,
            w_cm,
            h_cm: 5.0,
        };
        assert_eq!(
            runs(&grid).collect::<Vec<_>>(),
            [rect(0.0, 10.0), rect(15.0, 5.0)]
        );
    }

    #[test]
    fn impossible_worlds_are_refused() {
        let place = Place::new(&World::new(100.0, 50.0, Vec::new()), &RobotModel::paper());
        assert!(place.world().is_some());
        let circle = |x_cm, r_cm| {
            Outline::Circle(Circle {
                x_cm,
                y_cm: 9.0,
                r_cm,
            })
        };
        let rect = |w_cm, h_cm| {
            Outline::Rect(Rect {
                x_cm: 1.0,
                y_cm: 1.0,
                w_cm,
                h_cm,
            })
        };
        let points_cm = vec![[0.0, 0.0], [1.0, 0.0]];
        let with = |outline| {
            let mut place = place.clone();
            place.obstacles.push(outline);
            place.world().is_some()
        };
        assert!(with(circle(9.0, 0.0)) && with(rect(0.0, 5.0)));
        assert!(!with(Outline::Polygon { points_cm }));
        assert!(!with(circle(9.0, -1.0)) && !with(circle(1e7, 1.0)));
        assert!(!with(rect(-1.0, 5.0)) && !with(rect(5.0, -1.0)) && !with(rect(1e7, 5.0)));
        for width_cm in [0.0, -5.0, 1e7] {
            let place = Place {
                width_cm,
                ..place.clone()
            };
            assert!(place.world().is_none(), "{width_cm}");
        }
    }
}
