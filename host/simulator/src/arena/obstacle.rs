//! The shapes an obstacle can have.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::{PointQuery, Ray, RayCast};
use parry2d_f64::shape::{Ball, Polyline};
use parry2d_f64::utils::{SegmentsIntersection, point_in_poly2d, segments_intersection2d};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::grid::OccupancyGrid;
use super::whole::um;

/// Something that a robot cannot enter.
#[derive(Clone, Debug)]
pub enum Obstacle {
    /// A rectangle parallel to the walls.
    Rect(Rect),
    /// A disc.
    Circle(Circle),
    /// A simple polygon.
    Polygon(Polygon),
    /// The occupied cells of a map.
    Grid(OccupancyGrid),
}

/// A rectangle parallel to the walls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rect {
    /// Left edge.
    #[serde(rename = "x_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub x_cm: f64,
    /// Lower edge.
    #[serde(rename = "y_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub y_cm: f64,
    /// Width, positive.
    #[serde(rename = "w_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub w_cm: f64,
    /// Height, positive.
    #[serde(rename = "h_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub h_cm: f64,
}

/// A disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Circle {
    /// Centre, from the left.
    #[serde(rename = "x_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub x_cm: f64,
    /// Centre, from below.
    #[serde(rename = "y_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub y_cm: f64,
    /// Radius, positive.
    #[serde(rename = "radius_um", with = "um")]
    #[cfg_attr(feature = "schema", schemars(with = "i64"))]
    pub r_cm: f64,
}

/// A simple polygon, convex or not, its corners in either sense of rotation.
#[derive(Clone, Debug)]
pub struct Polygon(Polyline);

/// Why corners do not make a [`Polygon`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum PolygonError {
    /// Fewer than three corners.
    #[error("a polygon needs at least three points")]
    TooFewPoints,
    /// More corners than every pair of sides can be checked of.
    #[error("a polygon of {0} points, expected at most {MOST_POINTS}")]
    TooManyPoints(usize),
    /// Corner number `.0` (from 1) is not finite.
    #[error("point {0} is not finite")]
    NotFinite(usize),
    /// Corner number `.0` (from 1) equals the next one.
    #[error("point {0} is the same as the point after it")]
    RepeatedPoint(usize),
    /// The sides that start at these corners (from 1) meet away from a common corner.
    #[error(
        "the side after point {0} meets the side after point {1}: a polygon may not cross itself"
    )]
    Crossing(usize, usize),
}

/// Each side is compared with each other side.
const MOST_POINTS: usize = 1_000;

impl Rect {
    pub(super) fn bounds(&self) -> Aabb {
        let lower_left = Vector::new(self.x_cm, self.y_cm);
        Aabb::new(lower_left, lower_left + Vector::new(self.w_cm, self.h_cm))
    }
}

impl Circle {
    fn centre(&self) -> Pose {
        Pose::translation(self.x_cm, self.y_cm)
    }
}

impl Polygon {
    /// A polygon with these corners, in order; the last is joined to the first.
    ///
    /// # Errors
    /// If there are fewer than three, or the outline touches or crosses itself.
    pub fn new(points_cm: Vec<[f64; 2]>) -> Result<Self, PolygonError> {
        let points: Vec<Vector> = points_cm.into_iter().map(Vector::from_array).collect();
        let n = points.len();
        if n < 3 {
            return Err(PolygonError::TooFewPoints);
        }
        if n > MOST_POINTS {
            return Err(PolygonError::TooManyPoints(n));
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(PolygonError::NotFinite(i + 1));
        }
        if let Some(i) = (0..n).find(|&i| points[i] == points[(i + 1) % n]) {
            return Err(PolygonError::RepeatedPoint(i + 1));
        }
        if let Some((i, j)) = first_crossing(&points) {
            return Err(PolygonError::Crossing(i + 1, j + 1));
        }
        let sides = (0..n as u32).map(|i| [i, (i + 1) % n as u32]).collect();
        Ok(Self(Polyline::new(points, Some(sides))))
    }

    /// The corners in centimetres, as given.
    pub fn points(&self) -> &[Vector] {
        self.0.vertices()
    }

    fn contains(&self, point: Vector) -> bool {
        point_in_poly2d(point, self.0.vertices())
    }
}

/// The first two sides that meet anywhere but at the corner they share.
fn first_crossing(points: &[Vector]) -> Option<(usize, usize)> {
    let n = points.len();
    let side = |i: usize| (points[i], points[(i + 1) % n]);
    let meet = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (side(i), side(j));
        let hit = segments_intersection2d(a, b, c, d, f64::EPSILON);
        let neighbours = (i + 1) % n == j || (j + 1) % n == i;
        match hit {
            None => false,
            // Neighbours meet at their corner; lying on each other, they fold back.
            Some(SegmentsIntersection::Point { .. }) => !neighbours,
            Some(SegmentsIntersection::Segment { .. }) => true,
        }
    };
    (0..n)
        .flat_map(|i| (i + 1..n).map(move |j| (i, j)))
        .find(|&(i, j)| meet(i, j))
}

impl Obstacle {
    /// The smaller of `max_cm` and the distance along the ray (direction of length 1) to this
    /// obstacle.
    pub(super) fn ray(&self, ray: &Ray, max_cm: f64) -> f64 {
        let hit = match self {
            Self::Rect(rect) => rect.bounds().cast_local_ray(ray, max_cm, true),
            Self::Circle(circle) => {
                Ball::new(circle.r_cm).cast_ray(&circle.centre(), ray, max_cm, true)
            }
            Self::Polygon(polygon) if polygon.contains(ray.origin) => Some(0.0),
            Self::Polygon(polygon) => polygon.0.cast_local_ray(ray, max_cm, true),
            Self::Grid(grid) => grid.ray(ray, max_cm),
        };
        hit.map_or(max_cm, |distance| distance.min(max_cm))
    }

    /// The distance from a point to this obstacle, zero inside.
    pub(super) fn distance(&self, point: Vector) -> f64 {
        match self {
            Self::Rect(rect) => rect.bounds().distance_to_local_point(point, true),
            Self::Circle(circle) => {
                Ball::new(circle.r_cm).distance_to_point(&circle.centre(), point, true)
            }
            Self::Polygon(polygon) if polygon.contains(point) => 0.0,
            Self::Polygon(polygon) => polygon.0.distance_to_local_point(point, true),
            Self::Grid(grid) => grid.distance(point),
        }
    }

    /// The smallest box around this obstacle: lower left and upper right corner.
    pub fn bounds_cm(&self) -> [Vector; 2] {
        let bounds = match self {
            Self::Rect(rect) => rect.bounds(),
            Self::Circle(circle) => {
                let centre = Vector::new(circle.x_cm, circle.y_cm);
                Aabb::from_half_extents(centre, Vector::splat(circle.r_cm))
            }
            Self::Polygon(polygon) => polygon.0.local_aabb(),
            Self::Grid(grid) => grid.bounds(),
        };
        [bounds.mins, bounds.maxs]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_that_are_no_polygon_are_refused() {
        let refused = |points: &[[f64; 2]]| Polygon::new(points.to_vec()).err();
        assert_eq!(
            refused(&[[0.0, 0.0], [1.0, 0.0]]),
            Some(PolygonError::TooFewPoints)
        );
        assert_eq!(
            refused(&[[0.0, 0.0], [f64::NAN, 0.0], [1.0, 1.0]]),
            Some(PolygonError::NotFinite(2))
        );
        assert_eq!(
            refused(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
            Some(PolygonError::RepeatedPoint(2))
        );
        // A bow tie, a spike that folds back on itself, and a corner that touches a side.
        assert_eq!(
            refused(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]),
            Some(PolygonError::Crossing(1, 3))
        );
        assert_eq!(
            refused(&[[0.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 3.0]]),
            Some(PolygonError::Crossing(1, 2))
        );
        assert!(refused(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]]).is_some());
        // A concave outline, either way round, is fine.
        let mut l = vec![
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        assert_eq!(refused(&l), None);
        l.reverse();
        assert_eq!(refused(&l), None);
    }

    #[test]
    fn the_notch_of_a_concave_polygon_is_free() {
        let l = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 1.0],
            [1.0, 1.0],
            [1.0, 4.0],
            [0.0, 4.0],
        ];
        for corners in [l.to_vec(), l.iter().rev().copied().collect()] {
            let shape = Obstacle::Polygon(Polygon::new(corners).expect("simple"));
            let notch = Vector::new(3.0, 3.0);
            assert_eq!(shape.distance(notch), 2.0);
            assert_eq!(shape.distance(Vector::new(0.5, 3.0)), 0.0);
            assert_eq!(
                shape.ray(&Ray::new(notch, Vector::new(-1.0, 0.0)), 9.0),
                2.0
            );
            assert_eq!(shape.ray(&Ray::new(notch, Vector::new(1.0, 0.0)), 9.0), 9.0);
        }
    }
}
