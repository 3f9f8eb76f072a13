//! Which places of an arena are connected: maps have free pockets that no robot can get to.

use parry2d_f64::math::Vector;

use super::world::World;

/// The largest connected part of the free space, or that around a given place, on a lattice.
#[derive(Clone)]
pub(super) struct Reach {
    columns: usize,
    spacing_cm: f64,
    connected: Vec<bool>,
}

/// Lattice points along the longer side, at most: a quarter of a million clearances in all.
const FINEST: f64 = 512.0;

impl Reach {
    /// Fills the space where a robot of this radius is free from `origin`, or from wherever the
    /// most can be reached. The lattice is as fine as the radius, or coarser in arenas of more than
    /// 512 radii, where gaps of less than two lattice spacings may count as closed: enough to draw
    /// places from, not to call a place unreachable.
    pub(super) fn new(world: &World, radius_cm: f64, origin: Option<Vector>) -> Self {
        let (width, height) = (world.width_cm(), world.height_cm());
        let spacing_cm = radius_cm.max(width.max(height) / FINEST);
        let columns = (width / spacing_cm).ceil() as usize;
        let rows = (height / spacing_cm).ceil() as usize;
        let centre = |i: usize| {
            Vector::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5) * spacing_cm
        };
        let free: Vec<bool> = (0..columns * rows)
            .map(|i| world.clearance(centre(i)) >= radius_cm)
            .collect();
        let mut part = vec![0usize; free.len()];
        let mut sizes = vec![0usize];
        for seed in 0..free.len() {
            if free[seed] && part[seed] == 0 {
                let size = fill(&free, columns, seed, sizes.len(), &mut part);
                sizes.push(size);
            }
        }
        let largest = (1..sizes.len()).max_by_key(|&p| sizes[p]).unwrap_or(0);
        let of = |i: usize| part.get(i).copied().filter(|&p| p != 0);
        let lattice = Self {
            columns,
            spacing_cm,
            connected: Vec::new(),
        };
        let wanted = origin
            .and_then(|origin| of(lattice.cell(origin)))
            .unwrap_or(largest);
        let connected = part.iter().map(|&p| p != 0 && p == wanted).collect();
        Self {
            connected,
            ..lattice
        }
    }

    fn cell(&self, place: Vector) -> usize {
        let cell = place / self.spacing_cm;
        cell.y as usize * self.columns + cell.x as usize
    }

    /// Whether a place is connected to all the others of which this is true.
    pub(super) fn contains(&self, place: Vector) -> bool {
        self.connected
            .get(self.cell(place))
            .copied()
            .unwrap_or(false)
    }
}

impl std::fmt::Debug for Reach {
    /// Without the lattice, which fills pages.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let size = self
            .connected
            .iter()
            .filter(|connected| **connected)
            .count();
        f.debug_struct("Reach")
            .field("spacing_cm", &self.spacing_cm)
            .field("connected", &size)
            .finish_non_exhaustive()
    }
}

/// Marks all free lattice points that are connected to `seed` as belonging to a part, and counts
/// them.
fn fill(free: &[bool], columns: usize, seed: usize, name: usize, part: &mut [usize]) -> usize {
    let mut open = vec![seed];
    part[seed] = name;
    let mut size = 0;
    while let Some(i) = open.pop() {
        size += 1;
        let beside = [
            (i % columns > 0).then(|| i - 1),
            (i % columns + 1 < columns).then(|| i + 1),
            i.checked_sub(columns),
            Some(i + columns),
        ];
        for next in beside.into_iter().flatten() {
            if free.get(next) == Some(&true) && part[next] == 0 {
                part[next] = name;
                open.push(next);
            }
        }
    }
    size
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::{Obstacle, Rect};
    use super::*;

    /// 100 by 40, cut in two at x = 60 by a wall with a gap of `gap` at the top.
    fn cut(gap: f64) -> World {
        let wall = Rect {
            x_cm: 60.0,
            y_cm: 0.0,
            w_cm: 5.0,
            h_cm: 40.0 - gap,
        };
        World::new(100.0, 40.0, vec![Obstacle::Rect(wall)])
    }

    #[test]
    fn the_larger_part_counts_unless_a_place_is_given() {
        let (left, right) = (Vector::new(30.0, 10.0), Vector::new(80.0, 10.0));
        let any = Reach::new(&cut(0.0), 2.0, None);
        assert!(any.contains(left) && !any.contains(right));
        let given = Reach::new(&cut(0.0), 2.0, Some(right));
        assert!(!given.contains(left) && given.contains(right));
        assert!(!any.contains(Vector::new(62.0, 10.0)), "the wall itself");
    }

    #[test]
    fn a_gap_connects_robots_that_fit_through_it() {
        let ends = [Vector::new(30.0, 10.0), Vector::new(80.0, 10.0)];
        let both = |gap, radius| {
            let reach = Reach::new(&cut(gap), radius, None);
            ends.iter().all(|end| reach.contains(*end))
        };
        assert!(both(12.0, 2.0));
        assert!(!both(12.0, 7.0));
    }
}
