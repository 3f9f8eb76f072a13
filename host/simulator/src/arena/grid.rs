//! An occupancy grid: obstacles as the cells of a map.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::{IVector, Vector};
use parry2d_f64::query::{PointQuery, Ray, RayCast};
use parry2d_f64::shape::Voxels;

/// Square cells, each free or occupied, from the arena's lower left corner.
#[derive(Clone)]
pub struct OccupancyGrid {
    columns: usize,
    rows: usize,
    cell_cm: f64,
    /// Row by row from below, each from the left.
    occupied: Vec<bool>,
    /// The occupied cells that have a free neighbour; the others can be neither hit nor nearest.
    surface: Voxels,
}

impl OccupancyGrid {
    /// A grid of `columns` by `occupied.len() / columns` cells of `cell_cm` a side, given row by
    /// row **from below**, each row from the left.
    ///
    /// # Panics
    /// If the cells do not fill whole rows: callers have the image's own width.
    pub fn new(columns: usize, cell_cm: f64, occupied: Vec<bool>) -> Self {
        assert!(
            columns > 0 && occupied.len().is_multiple_of(columns),
            "cells fill whole rows"
        );
        let rows = occupied.len() / columns;
        let at = |column: usize, row: usize| occupied[row * columns + column];
        let free_beside = |column: usize, row: usize| {
            (row.saturating_sub(1)..=(row + 1).min(rows - 1)).any(|r| {
                (column.saturating_sub(1)..=(column + 1).min(columns - 1)).any(|c| !at(c, r))
            })
        };
        let surface: Vec<IVector> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (column, row)))
            .filter(|&(column, row)| at(column, row) && free_beside(column, row))
            .map(|(column, row)| IVector::new(column as i64, row as i64))
            .collect();
        let surface = Voxels::new(Vector::splat(cell_cm), &surface);
        Self {
            columns,
            rows,
            cell_cm,
            occupied,
            surface,
        }
    }

    /// Cells from left to right.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Cells from below upwards.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Side of a cell.
    pub fn cell_cm(&self) -> f64 {
        self.cell_cm
    }

    /// Whether a cell is occupied; cells beyond the grid are not.
    pub fn is_occupied(&self, column: usize, row: usize) -> bool {
        column < self.columns && row < self.rows && self.occupied[row * self.columns + column]
    }

    fn contains(&self, point: Vector) -> bool {
        let cell = (point / self.cell_cm).floor();
        cell.x >= 0.0 && cell.y >= 0.0 && self.is_occupied(cell.x as usize, cell.y as usize)
    }

    pub(super) fn bounds(&self) -> Aabb {
        let cells = Vector::new(self.columns as f64, self.rows as f64);
        Aabb::new(Vector::ZERO, cells * self.cell_cm)
    }

    pub(super) fn ray(&self, ray: &Ray, max_cm: f64) -> Option<f64> {
        if self.contains(ray.origin) {
            return Some(0.0);
        }
        self.surface.cast_local_ray(ray, max_cm, true)
    }

    pub(super) fn distance(&self, point: Vector) -> f64 {
        if self.contains(point) {
            return 0.0;
        }
        self.surface.distance_to_local_point(point, true)
    }
}

impl std::fmt::Debug for OccupancyGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OccupancyGrid")
            .field("columns", &self.columns)
            .field("rows", &self.rows)
            .field("cell_cm", &self.cell_cm)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use super::*;

    /// 40 by 30 cells of 5 cm: a frame one cell wide, and a block from (10, 10) to (19, 14).
    fn grid() -> OccupancyGrid {
        let occupied = |column: usize, row: usize| {
            let frame = column == 0 || column == 39 || row == 0 || row == 29;
            frame || (10..20).contains(&column) && (10..15).contains(&row)
        };
        let cells = (0..30).flat_map(|row| (0..40).map(move |column| occupied(column, row)));
        OccupancyGrid::new(40, 5.0, cells.collect())
    }

    fn cast(from: [f64; 2], towards: [f64; 2]) -> f64 {
        let ray = Ray::new(Vector::from_array(from), Vector::from_array(towards));
        grid().ray(&ray, 500.0).unwrap_or(500.0)
    }

    #[test]
    fn rays_stop_at_the_faces_of_occupied_cells() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}");
        close(cast([22.0, 62.0], [1.0, 0.0]), 28.0); // the block's left face at 50
        close(cast([22.0, 62.0], [-1.0, 0.0]), 17.0); // the frame's inner face at 5
        close(cast([150.0, 62.0], [-1.0, 0.0]), 50.0); // the block's right face at 100
        close(cast([70.0, 100.0], [0.0, -1.0]), 25.0); // the block's top at 75
        close(
            cast([30.0, 55.0], [FRAC_1_SQRT_2, FRAC_1_SQRT_2]),
            20.0 * 2f64.sqrt() * 1.0,
        );
        close(cast([70.0, 60.0], [1.0, 0.0]), 0.0); // inside, away from the surface
    }

    #[test]
    fn distances_are_those_to_the_nearest_occupied_cell() {
        let grid = grid();
        let distance = |x: f64, y: f64| grid.distance(Vector::new(x, y));
        assert_eq!(distance(40.0, 60.0), 10.0);
        assert_eq!(distance(47.0, 46.0), 5.0); // the block's corner at (50, 50): 3, 4, 5
        assert_eq!(distance(70.0, 60.0), 0.0);
        assert_eq!(distance(2.0, 2.0), 0.0);
    }

    #[test]
    fn an_empty_grid_is_nothing() {
        let grid = OccupancyGrid::new(3, 5.0, vec![false; 9]);
        let ray = Ray::new(Vector::new(7.0, 7.0), Vector::new(1.0, 0.0));
        assert_eq!(grid.ray(&ray, 50.0).unwrap_or(50.0), 50.0);
        assert!(grid.distance(Vector::new(7.0, 7.0)) > 1e6);
    }
}
