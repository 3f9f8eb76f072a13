//! An arena seen from above, and a drive through it.

use rover_shared::units::Microdegrees;
use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::drive::Drive;
use super::palette::{COLOURS, OTHERS, Palette, width};
use super::shape::{Area, INK, Outline, circle, group, line};
use rover_simulator::arena::{
    Motion, Obstacle, OccupancyGrid, Pose, Vector, World, degrees, radians, unit,
};
use rover_simulator::experiment::{Event, TaskKind};

const OBSTACLE: &str = "#d4d4d4";
const OBSTACLE_EDGE: &str = "#6e6e6e";
/// Fill of the target.
pub(super) const TARGET: &str = "#fff3b0";
/// Actions from one heading mark to the next.
pub(super) const MARK_EVERY: usize = 10;
/// Pixels between marks of one pattern, which may come and go at every action, and of two.
const SAME_APART: f64 = 40.0;
const OTHERS_APART: f64 = 9.0;
/// Cells of a map are drawn as blocks, of which at most this many lie side by side.
const MOST_BLOCKS: usize = 160;

/// An arena drawn to scale within an area.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// What the arena covers.
    pub area: Area,
    x: Scale,
    y: Scale,
    /// Its scale.
    pub px_per_cm: f64,
}

impl View {
    /// A view of `world` with its upper left corner where that of `within` is, as large as fits.
    pub fn new(world: &World, within: Area) -> Self {
        let (width, height) = (world.width_cm(), world.height_cm());
        let px_per_cm = (within.width / width).min(within.height / height);
        let area = Area {
            width: width * px_per_cm,
            height: height * px_per_cm,
            ..within
        };
        let x = Scale::linear([0.0, width], [area.left, area.right()]);
        let y = Scale::linear([0.0, height], [area.bottom(), area.top]);
        Self {
            area,
            x,
            y,
            px_per_cm,
        }
    }

    /// A view of `world` in the middle of the upper edge of `within`, as large as fits.
    pub fn centred(world: &World, within: Area) -> Self {
        let width = Self::new(world, within).area.width;
        let left = within.left + (within.width - width) / 2.0;
        Self::new(world, Area { left, ..within })
    }

    /// Where a point of the arena is drawn.
    pub fn at(&self, point: Vector) -> [f64; 2] {
        [self.x.at(point.x), self.y.at(point.y)]
    }

    /// Axes in centimetres; those without labels have only ticks.
    pub fn axes(&self, world: &World, label_x: bool, label_y: bool) -> [Group; 2] {
        let x_ticks = axes::ticks([0.0, world.width_cm()], 6);
        let y_ticks = axes::ticks([0.0, world.height_cm()], 5);
        let label = |shown: bool, name: &str| {
            if shown {
                name.to_owned()
            } else {
                String::new()
            }
        };
        [
            axes::below(self.area, &self.x, &x_ticks, &label(label_x, "x (cm)")),
            axes::beside(self.area, &self.y, &y_ticks, &label(label_y, "y (cm)")),
        ]
    }

    /// Obstacles, target and walls; where they are not known, what the sensors saw of them.
    pub fn arena(&self, drive: &Drive) -> Group {
        let mut drawing = group("arena");
        if !drive.arena_known {
            drawing.append(self.echoes(drive));
            drawing.append(axes::border(self.area).set("stroke", OBSTACLE_EDGE));
            return drawing;
        }
        for obstacle in drive.scenario.world.obstacles() {
            drawing.append(self.obstacle(obstacle));
        }
        if let Some(goal) = drive.scenario.goal {
            let centre = self.at(goal.position());
            // Maps may be so large that the target would be no more than a dot.
            drawing.append(target(centre, (goal.radius_cm * self.px_per_cm).max(4.0)));
        }
        drawing.append(axes::border(self.area).set("stroke-width", 1.5));
        drawing
    }

    /// The places at which sensors saw something, each in the middle of the sensor's field.
    fn echoes(&self, drive: &Drive) -> svg::node::element::Path {
        let mut places = Vec::new();
        for event in &drive.events {
            for reading in drive.readings(event).filter(|reading| reading.seen) {
                let place = reading.from + unit(reading.axis) * reading.distance_cm;
                let [x, y] = self.at(place);
                if x > self.area.left
                    && x < self.area.right()
                    && y > self.area.top
                    && y < self.area.bottom()
                {
                    places.push([x, y]);
                }
            }
        }
        Outline::dots(places).dotted(OBSTACLE_EDGE, 3.0)
    }

    /// What the sensors saw before an action: of each its field, up to where it is free.
    pub fn fields(&self, drive: &Drive, event: &Event) -> Group {
        let mut fields = group("fields");
        for reading in drive.readings(event) {
            let edge = |distance_cm: f64| {
                let half = reading.half_field_deg;
                (0..=16).map(move |i| {
                    let by = degrees(half * (f64::from(i) / 8.0 - 1.0));
                    let along = unit(reading.axis.turned(by));
                    self.at(reading.from + along * distance_cm)
                })
            };
            let corner = self.at(reading.from);
            let mut range = Outline::through([corner].into_iter().chain(edge(reading.range_cm)));
            range.close();
            let outline = range.stroked(OBSTACLE_EDGE, 0.8);
            fields.append(outline.set("stroke-dasharray", "3 2"));
            let mut free = Outline::through([corner].into_iter().chain(edge(reading.distance_cm)));
            free.close();
            fields.append(free.filled(INK).set("fill-opacity", 0.16));
        }
        fields
    }

    fn obstacle(&self, obstacle: &Obstacle) -> svg::node::element::Path {
        let corners = |corners: &[Vector]| {
            let mut outline = Outline::through(corners.iter().map(|corner| self.at(*corner)));
            outline.close();
            outline
                .filled(OBSTACLE)
                .set("stroke", OBSTACLE_EDGE)
                .set("stroke-width", 1)
        };
        match obstacle {
            Obstacle::Grid(grid) => self.map(grid),
            Obstacle::Polygon(polygon) => corners(polygon.points()),
            Obstacle::Circle(disc) => {
                let around = (0..48).map(|i| {
                    let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 48.0);
                    Vector::new(disc.x_cm + disc.r_cm * cos, disc.y_cm + disc.r_cm * sin)
                });
                corners(&around.collect::<Vec<_>>())
            }
            Obstacle::Rect(_) => {
                let [low, high] = obstacle.bounds_cm();
                corners(&[
                    low,
                    Vector::new(high.x, low.y),
                    high,
                    Vector::new(low.x, high.y),
                ])
            }
        }
    }

    /// The occupied cells of a map, in blocks if there are many.
    fn map(&self, grid: &OccupancyGrid) -> svg::node::element::Path {
        let cells = grid.columns().max(grid.rows()).div_ceil(MOST_BLOCKS);
        let (columns, rows) = (grid.columns().div_ceil(cells), grid.rows().div_ceil(cells));
        let occupied = |column: usize, row: usize| {
            let cells_of = |block: usize| block * cells..(block + 1) * cells;
            cells_of(column).any(|c| cells_of(row).any(|r| grid.is_occupied(c, r)))
        };
        let corner = |column: usize, row: usize| {
            let cell_cm = grid.cell_cm();
            let to = |block: usize, all: usize| (block * cells).min(all) as f64 * cell_cm;
            self.at(Vector::new(
                to(column, grid.columns()),
                to(row, grid.rows()),
            ))
        };
        let mut outline = Outline::default();
        for row in 0..rows {
            let mut column = 0;
            while column < columns {
                let from = column;
                while column < columns && occupied(column, row) {
                    column += 1;
                }
                if column > from {
                    outline.move_to(corner(from, row));
                    outline.line_to(corner(column, row));
                    outline.line_to(corner(column, row + 1));
                    outline.line_to(corner(from, row + 1));
                    outline.close();
                }
                column += 1;
            }
        }
        // Without smoothing, so that no seams show between the rows.
        outline
            .filled(OBSTACLE)
            .set("shape-rendering", "crispEdges")
    }

    /// The way driven: each move in the colour of the pattern that chose it, with marks.
    pub fn path(&self, drive: &Drive, palette: &Palette) -> Group {
        let mut drawing = group("path");
        let positions: Vec<[f64; 2]> = drive.positions().iter().map(|p| self.at(*p)).collect();
        // Grey below, so that the coloured patterns are never hidden by it.
        for rank in std::iter::once(None).chain((0..COLOURS.len()).rev().map(Some)) {
            let mut outline = Outline::default();
            let mut at_end = false;
            for (code, ends) in drive.codes().zip(positions.windows(2)) {
                let drawn = palette.rank(code) == rank && ends[0] != ends[1];
                if drawn {
                    if !at_end {
                        outline.move_to(ends[0]);
                    }
                    outline.line_to(ends[1]);
                }
                at_end = drawn;
            }
            if !outline.is_empty() {
                let colour = rank.map_or(OTHERS, |rank| COLOURS[rank]);
                let moves = outline.stroked(colour, width(rank));
                drawing.append(moves.set("stroke-linejoin", "round"));
            }
        }
        for mark in self.pattern_marks(drive, palette, &positions) {
            drawing.append(mark);
        }
        drawing
    }

    /// The signs of the patterns that are not the two used most, where one of them takes over.
    fn pattern_marks(
        &self,
        drive: &Drive,
        palette: &Palette,
        positions: &[[f64; 2]],
    ) -> Vec<svg::node::element::Path> {
        let mut marks = Vec::new();
        let mut placed: Vec<(Option<usize>, [f64; 2])> = Vec::new();
        let mut before = None;
        for (code, at) in drive.codes().zip(positions) {
            let rank = palette.rank(code);
            let clear = placed.iter().all(|(other, [x, y])| {
                let apart = (at[0] - x).abs().max((at[1] - y).abs());
                apart
                    > if *other == rank {
                        SAME_APART
                    } else {
                        OTHERS_APART
                    }
            });
            if rank != before
                && clear
                && let Some(mark) = rank.and_then(|r| pattern_mark(*at, r))
            {
                placed.push((rank, *at));
                marks.push(mark);
            }
            before = rank;
        }
        marks
    }

    /// Where an arrow begins so that its tip stays inside the arena.
    fn inside(&self, from: [f64; 2], direction: Microdegrees) -> [f64; 2] {
        let tip = away(from, direction, ARROW);
        let Area { left, top, .. } = self.area;
        let shift_x = tip[0].clamp(left + 3.0, self.area.right() - 3.0) - tip[0];
        let shift_y = tip[1].clamp(top + 3.0, self.area.bottom() - 3.0) - tip[1];
        [from[0] + shift_x, from[1] + shift_y]
    }

    /// Headings along the way, blocked moves, changes of the direction to follow, and the start.
    pub fn marks(&self, drive: &Drive) -> Group {
        let mut marks = group("marks");
        let mut direction = None;
        for event in &drive.events {
            if let TaskKind::FollowDirection { direction_udeg } = event.task
                && direction.replace(direction_udeg) != Some(direction_udeg)
            {
                let from = self.at(event.pose.position());
                marks.append(direction_mark(
                    self.inside(from, direction_udeg),
                    direction_udeg,
                ));
            }
        }
        for event in drive.events.iter().skip(MARK_EVERY).step_by(MARK_EVERY) {
            // An event's pose is the one before its turn.
            marks.append(heading_mark(
                self.at(event.pose.position()),
                event.pose.heading,
            ));
        }
        let blocked = drive
            .events
            .iter()
            .filter(|event| event.motion == Motion::Blocked);
        let mut last = None;
        for event in blocked {
            let at = self.at(event.pose.position());
            if last.replace(at) != Some(at) {
                marks.append(blocked_mark(at));
            }
        }
        let Pose { heading, .. } = drive.scenario.start;
        marks.append(start_mark(
            self.at(drive.scenario.start.position()),
            heading,
        ));
        marks
    }
}

/// The point at a distance in pixels from another.
fn away([x, y]: [f64; 2], direction: Microdegrees, distance: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(radians(direction));
    [x + distance * cos, y - distance * sin]
}

/// The target: within its circle the robot has arrived.
pub(super) fn target(centre: [f64; 2], radius: f64) -> Group {
    let mut drawing = group("target");
    let edge = circle(centre, radius, TARGET)
        .set("stroke", INK)
        .set("stroke-width", 1);
    drawing.append(edge.set("stroke-dasharray", "3 2"));
    drawing.append(circle(centre, 1.8, INK));
    drawing
}

/// Where a drive starts: a robot that points where it is headed.
pub(super) fn start_mark(centre: [f64; 2], heading: Microdegrees) -> Group {
    let mut mark = group("start");
    mark.append(line(centre, away(centre, heading, 11.0), INK, 1.6));
    mark.append(
        circle(centre, 4.5, "#ffffff")
            .set("stroke", INK)
            .set("stroke-width", 1.6),
    );
    mark
}

/// A small triangle that points where the robot is headed.
pub(super) fn heading_mark(centre: [f64; 2], heading: Microdegrees) -> svg::node::element::Path {
    let corner = |by: i32, distance| {
        away(
            centre,
            heading.turned(Microdegrees::from_degrees(by)),
            distance,
        )
    };
    let mut outline = Outline::through([corner(0, 5.5), corner(140, 4.2), corner(-140, 4.2)]);
    outline.close();
    outline
        .filled(INK)
        .set("stroke", "#ffffff")
        .set("stroke-width", 0.6)
}

/// The sign of a pattern besides its colour; none for the two used most, which differ in width.
pub(super) fn pattern_mark([x, y]: [f64; 2], rank: usize) -> Option<svg::node::element::Path> {
    const R: f64 = 3.4;
    let corners: &[[f64; 2]] = match rank {
        2 => &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
        3 => &[[0.0, -1.4], [1.4, 0.0], [0.0, 1.4], [-1.4, 0.0]],
        4 => &[[-1.2, -1.0], [1.2, -1.0], [0.0, 1.3]],
        5 => &[[-1.4, -0.6], [1.4, -0.6], [1.4, 0.6], [-1.4, 0.6]],
        _ => return None,
    };
    let mut outline = Outline::through(corners.iter().map(|[u, v]| [x + R * u, y + R * v]));
    outline.close();
    let mark = outline.filled(COLOURS[rank]);
    Some(mark.set("stroke", INK).set("stroke-width", 0.9))
}

/// A cross where something stood in the way.
pub(super) fn blocked_mark([x, y]: [f64; 2]) -> svg::node::element::Path {
    let mut outline = Outline::default();
    outline.move_to([x - 3.5, y - 3.5]);
    outline.line_to([x + 3.5, y + 3.5]);
    outline.move_to([x - 3.5, y + 3.5]);
    outline.line_to([x + 3.5, y - 3.5]);
    outline.stroked(INK, 1.4)
}

/// Length of the arrow to a direction.
const ARROW: f64 = 18.0;

/// An arrow from where the direction to follow changed.
pub(super) fn direction_mark(from: [f64; 2], direction: Microdegrees) -> Group {
    let tip = away(from, direction, ARROW);
    let barb = |by: i32| away(tip, direction.turned(Microdegrees::from_degrees(by)), 5.0);
    let mut mark = group("direction");
    mark.append(line(from, tip, INK, 1.2));
    mark.append(Outline::through([barb(150), tip, barb(-150)]).stroked(INK, 1.2));
    mark
}
