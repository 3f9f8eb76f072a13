//! Walls and obstacles, and the two questions a robot asks of them.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::query::{Ray, RayCast};

use super::obstacle::Obstacle;

/// A rectangular arena from (0, 0) to (width, height), walled in, with obstacles.
#[derive(Clone, Debug)]
pub struct World {
    walls: Aabb,
    obstacles: Vec<Obstacle>,
}

impl World {
    /// An arena of `width_cm` by `height_cm`, both finite and positive. Obstacles may touch or
    /// cross the walls and each other.
    pub fn new(width_cm: f64, height_cm: f64, obstacles: Vec<Obstacle>) -> Self {
        let walls = Aabb::new(Vector::ZERO, Vector::new(width_cm, height_cm));
        Self { walls, obstacles }
    }

    /// Inner width, x from 0 to here.
    pub fn width_cm(&self) -> f64 {
        self.walls.maxs.x
    }

    /// Inner height, y from 0 to here.
    pub fn height_cm(&self) -> f64 {
        self.walls.maxs.y
    }

    /// The obstacles, in the order they were given.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The distance from `origin` to the first wall or obstacle in a direction (radians,
    /// counter-clockwise, 0 = right); `max_cm` where nothing is nearer. Zero from inside an
    /// obstacle or outside the walls.
    pub fn ray(&self, origin: Vector, direction_rad: f64, max_cm: f64) -> f64 {
        let (sin, cos) = libm::sincos(direction_rad);
        self.ray_along(origin, Vector::new(cos, sin), max_cm)
    }

    /// [`World::ray`] along a vector of length 1.
    pub fn ray_along(&self, origin: Vector, direction: Vector, max_cm: f64) -> f64 {
        if !self.walls.contains_local_point(origin) {
            return 0.0;
        }
        let ray = Ray::new(origin, direction);
        // Not solid: from inside the box, the hit is where the ray leaves it.
        let to_wall = self.walls.cast_local_ray(&ray, max_cm, false);
        let first = to_wall.unwrap_or(0.0).min(max_cm);
        self.obstacles
            .iter()
            .fold(first, |nearest, obstacle| obstacle.ray(&ray, nearest))
    }

    /// The distance from `point` to the nearest wall or obstacle: zero inside an obstacle and
    /// outside the walls.
    pub fn clearance(&self, point: Vector) -> f64 {
        let Vector { x, y } = point;
        let to_wall = x
            .min(y)
            .min(self.width_cm() - x)
            .min(self.height_cm() - y)
            .max(0.0);
        self.obstacles.iter().fold(to_wall, |nearest, obstacle| {
            if nearest > 0.0 {
                nearest.min(obstacle.distance(point))
            } else {
                0.0
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::super::obstacle::{Circle, Polygon, Rect};
    use super::*;

    fn world() -> World {
        let triangle = vec![[70.0, 10.0], [90.0, 10.0], [80.0, 30.0]];
        World::new(
            100.0,
            60.0,
            vec![
                Obstacle::Rect(Rect {
                    x_cm: 40.0,
                    y_cm: 20.0,
                    w_cm: 10.0,
                    h_cm: 20.0,
                }),
                Obstacle::Circle(Circle {
                    x_cm: 75.0,
                    y_cm: 45.0,
                    r_cm: 5.0,
                }),
                Obstacle::Polygon(Polygon::new(triangle).expect("a triangle is simple")),
            ],
        )
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    }

    #[test]
    fn rays_reach_walls_and_obstacles_where_geometry_says() {
        let w = world();
        let from = Vector::new(20.0, 30.0);
        close(w.ray(from, 0.0, 1e3), 20.0); // left face of the rectangle
        close(w.ray(from, PI, 1e3), 20.0); // left wall
        close(w.ray(from, FRAC_PI_2, 1e3), 30.0); // upper wall
        close(w.ray(from, -FRAC_PI_4, 1e3), 30.0 * 2f64.sqrt()); // floor, beside the rectangle
        close(w.ray(Vector::new(75.0, 35.0), FRAC_PI_2, 1e3), 5.0); // circle from below
        close(w.ray(Vector::new(60.0, 20.0), 0.0, 1e3), 15.0); // triangle's slope at half height
        // The circle again, met off its middle: a chord 3 cm beside the centre of radius 5.
        close(w.ray(Vector::new(60.0, 48.0), 0.0, 1e3), 11.0);
    }

    #[test]
    fn rays_saturate_and_start_at_zero_where_there_is_no_room() {
        let w = world();
        close(w.ray(Vector::new(20.0, 30.0), 0.0, 7.5), 7.5);
        close(w.ray(Vector::new(45.0, 30.0), 1.0, 50.0), 0.0); // in the rectangle
        close(w.ray(Vector::new(80.0, 15.0), 1.0, 50.0), 0.0); // in the triangle
        close(w.ray(Vector::new(75.0, 46.0), 1.0, 50.0), 0.0); // in the circle
        close(w.ray(Vector::new(-1.0, 30.0), 0.0, 50.0), 0.0); // outside the walls
    }

    #[test]
    fn clearance_is_the_nearest_of_all() {
        let w = world();
        close(w.clearance(Vector::new(5.0, 30.0)), 5.0); // wall
        close(w.clearance(Vector::new(37.0, 16.0)), 5.0); // corner of the rectangle: 3, 4, 5
        close(w.clearance(Vector::new(75.0, 38.0)), 2.0); // circle
        close(w.clearance(Vector::new(80.0, 32.0)), 2.0); // tip of the triangle
        for inside in [
            [45.0, 30.0],
            [80.0, 15.0],
            [75.0, 45.0],
            [101.0, 5.0],
            [5.0, -1.0],
        ] {
            close(w.clearance(Vector::from_array(inside)), 0.0);
        }
    }
}
