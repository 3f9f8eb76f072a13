//! How patterns grow: layer 1 of the network from its initial state to the steady state.

use rover_shared::perception::{Corners, Lattice, Noise, PatternCode, SettleTime};
use rover_shared::sensing::Percept;
use rover_shared::sensing::neuron::STEPS;
use svg::Node as _;
use svg::node::element::{Group, Text};

use super::axes::{self, Scale};
use super::drive::Drive;
use super::palette::{Palette, Used};
use super::shape::{
    Area, FAINT_INK, GRID, HEADER, Heading, INK, Outline, TEXT_SIZE, centred, group, line, number,
    pattern, rectangle, sheet, text,
};
use rover_simulator::experiment::Event;

/// Percepts shown.
const MOST: usize = 4;
/// Snapshots between the initial state and the pattern, as shares of the settling time.
const SHARES: [f64; 4] = [0.08, 0.2, 0.4, 0.7];

/// Points of a time course.
const MOST_POINTS: usize = 90;

/// States of layer 1 over the network's own time.
type States = Vec<(f64, [f64; 16])>;

/// A percept that is grown once more, observed.
pub(super) struct Growth {
    used: Used,
    percept: Percept,
    corners: [f64; 4],
    states: States,
    settle_time: f64,
}

/// The percepts of the patterns used most, of each the first from which it grows without noise.
pub(super) fn chosen(drives: &[Drive], palette: &Palette, lattice: &Lattice) -> Vec<Growth> {
    let events = || drives.iter().flat_map(|drive| &drive.events);
    let growth = |used: &Used| {
        let here =
            events().filter(|event| event.record.perceived.is_some_and(|p| p.code == used.code));
        // More would only be more of the same.
        here.take(50)
            .find_map(|event| Growth::of(event, used, lattice))
    };
    palette
        .ranked()
        .iter()
        .filter_map(growth)
        .take(MOST)
        .collect()
}

/// The growths in words.
pub(super) fn described<'a>(growths: impl IntoIterator<Item = &'a Growth>) -> String {
    let each = growths.into_iter().map(|growth| {
        let corners = growth.corners.map(|corner| number(corner, 2)).join(", ");
        format!(
            "From the corners {corners} (F, L, R, T) grows code {} in {} time units",
            growth.used.code,
            number(growth.settle_time, 1)
        )
    });
    each.collect::<Vec<_>>().join("; ") + "."
}

/// Layer 1 from these corners, without noise in layer 2: the pattern and its states, or `None` if
/// it does not settle.
pub(super) fn grown(corners: &Corners, lattice: &Lattice) -> Option<(PatternCode, States, f64)> {
    let unit = f64::from(1 << Corners::FRACTION_BITS);
    let time = |time: SettleTime| f64::from(time.0) / f64::from(SettleTime::PER_UNIT);
    let mut states: States = vec![(0.0, initial(corners))];
    let settled = lattice
        .settle_observed(corners, &Noise::default(), &mut |at, cells| {
            states.push((time(at), cells.map(|cell| f64::from(cell) / unit)));
        })
        .ok()?;
    Some((settled.code, states, time(settled.time)))
}

/// The initial state: the corners, and nothing else (Fig. 2b).
fn initial(corners: &Corners) -> [f64; 16] {
    let unit = f64::from(1 << Corners::FRACTION_BITS);
    let mut cells = [0.0; 16];
    for (cell, corner) in Corners::CELLS.into_iter().zip(corners.0) {
        cells[cell] = f64::from(corner) / unit;
    }
    cells
}

impl Growth {
    fn of(event: &Event, used: &Used, lattice: &Lattice) -> Option<Self> {
        let corners = event.record.perceived?.corners;
        let percept = event.record.sensed?.percept;
        let (code, states, settle_time) = grown(&corners, lattice)?;
        (code == used.code).then(|| Self {
            used: *used,
            percept,
            corners: corners
                .0
                .map(|c| f64::from(c) / f64::from(1 << Corners::FRACTION_BITS)),
            states,
            settle_time,
        })
    }

    /// Whether there was something in the range of the front sensor.
    pub fn sees_ahead(&self) -> bool {
        let [front, ..] = self.percept.steps();
        front.index() < STEPS - 1
    }

    /// The state nearest to a time.
    fn at(&self, time: f64) -> &(f64, [f64; 16]) {
        let far = |state: &(f64, [f64; 16])| (state.0 - time).abs();
        let nearest = self.states.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.unwrap_or(&self.states[0])
    }
}

const SHEET_WIDTH: f64 = 1040.0;
const LEFT: f64 = 24.0;
const SIDE: f64 = 72.0;
const PITCH: f64 = 84.0;
pub(super) const ROW: f64 = 148.0;
/// Left edge of the time courses.
const COURSE: f64 = 690.0;

/// Draws the growth of some percepts, one a row.
pub(super) fn draw(growths: &[Growth], palette: &Palette, heading: &Heading) -> String {
    let top = HEADER + 26.0;
    let mut parts = vec![titles(top - 8.0)];
    for (i, growth) in growths.iter().enumerate() {
        parts.push(row(growth, top + ROW * i as f64, palette));
    }
    if growths.is_empty() {
        let none = text([LEFT, top + 20.0], TEXT_SIZE, "Nothing was perceived.");
        parts.push(group("panel").add(none));
        let x = Scale::linear([0.0, 1.0], [LEFT, LEFT + 100.0]);
        let area = Area {
            left: LEFT,
            top: top + 40.0,
            width: 100.0,
            height: 1.0,
        };
        parts.push(axes::below(area, &x, &[], "t (dimensionless)"));
    }
    let bottom = top + ROW * growths.len().max(1) as f64 + 8.0;
    parts.push(legend(bottom + 14.0));
    sheet([SHEET_WIDTH, bottom + 46.0], heading, parts)
}

/// What stands above the time courses.
pub(super) fn course_title(y: f64) -> Text {
    let title = "State x of all 16 cells of layer 1 (cut off at \u{b1}2)";
    text([COURSE + 24.0, y], 13.0, title).set("font-weight", "bold")
}

fn titles(y: f64) -> Group {
    let mut titles = group("titles");
    let bold = |x: f64, name: &str| text([x, y], 13.0, name).set("font-weight", "bold");
    titles.append(bold(LEFT, "Layer 1 at time t"));
    titles.append(bold(LEFT + 5.0 * PITCH + 26.0, "Pattern and turn"));
    titles.append(course_title(y));
    titles
}

/// One growth: its states, the pattern, and the time courses.
pub(super) fn row(growth: &Growth, top: f64, palette: &Palette) -> Group {
    let mut row = group("panel");
    let times = std::iter::once(0.0).chain(SHARES.map(|share| share * growth.settle_time));
    for (i, time) in times.enumerate() {
        let (time, cells) = growth.at(time);
        let left = LEFT + PITCH * i as f64;
        row.append(cells_drawn([left, top + 8.0], SIDE, cells, i == 0));
        let label = format!("t = {}", number(*time, if *time == 0.0 { 0 } else { 2 }));
        row.append(centred([left + SIDE / 2.0, top + SIDE + 24.0], 11.0, label));
    }
    let left = LEFT + PITCH * 5.0 + 26.0;
    let arrow = Outline::through([[left - 24.0, top + 44.0], [left - 8.0, top + 44.0]]);
    row.append(arrow.stroked(INK, 1.4));
    let head = Outline::through([
        [left - 12.0, top + 40.0],
        [left - 7.0, top + 44.0],
        [left - 12.0, top + 48.0],
    ]);
    row.append(head.stroked(INK, 1.4));
    let colour = palette.colour(Some(growth.used.code));
    row.append(pattern([left, top + 8.0], SIDE, growth.used.code, colour));
    let label = format!("t = {}", number(growth.settle_time, 2));
    row.append(centred([left + SIDE / 2.0, top + SIDE + 24.0], 11.0, label));
    let x = left + SIDE + 12.0;
    let code = format!("code {}", growth.used.code);
    row.append(text([x, top + 34.0], 13.0, code).set("font-weight", "bold"));
    row.append(text([x, top + 52.0], TEXT_SIZE, growth.used.turn()));
    let steps = growth
        .percept
        .steps()
        .map(|step| (step.index() + 1).to_string());
    let steps = format!(
        "Steps in use: F {}, L {}, R {}, T {}",
        steps[0], steps[1], steps[2], steps[3]
    );
    row.append(text([LEFT, top + SIDE + 46.0], 11.0, steps).set("fill", FAINT_INK));
    row.append(course(growth, top + 8.0));
    row
}

/// The cells of layer 1 in shades of grey, from white at -1 to black at 1.
pub(super) fn cells_drawn(
    [left, top]: [f64; 2],
    side: f64,
    cells: &[f64; 16],
    with_corners: bool,
) -> Group {
    let mut drawing = group("cells");
    let cell = side / 4.0;
    for (i, value) in cells.iter().enumerate() {
        let area = Area {
            left: left + cell * (i % 4) as f64,
            top: top + cell * (i / 4) as f64,
            width: cell,
            height: cell,
        };
        drawing.append(rectangle(area, &shade(*value)));
        if with_corners && Corners::CELLS.contains(&i) {
            let ink = if *value > 0.1 { "#ffffff" } else { INK };
            let at = [area.left + cell / 2.0, area.top + cell / 2.0 + 3.0];
            let decimals = usize::from(value.abs() < 9.95);
            let label = centred(at, 0.44 * cell, number(*value, decimals));
            drawing.append(label.set("fill", ink));
        }
    }
    let outline = Area {
        left,
        top,
        width: side,
        height: side,
    };
    let edge = rectangle(outline, "none").set("stroke", INK);
    drawing.append(edge.set("stroke-width", 0.8));
    drawing
}

/// The grey of a state: beyond -1 and 1 it does not change, as the output does not.
fn shade(value: f64) -> String {
    let level = (255.0 - (value.clamp(-1.0, 1.0) + 1.0) / 2.0 * 225.0).round() as u8;
    format!("#{level:02x}{level:02x}{level:02x}")
}

/// All 16 cells over time.
fn course(growth: &Growth, top: f64) -> Group {
    let area = Area {
        left: COURSE + 24.0,
        top,
        width: SHEET_WIDTH - COURSE - 48.0,
        height: 84.0,
    };
    let x = Scale::linear([0.0, growth.settle_time], [area.left, area.right()]);
    let y = Scale::linear([-2.0, 2.0], [area.bottom(), area.top]);
    let y_ticks: Vec<_> = axes::ticks([-2.0, 2.0], 4);
    let mut drawing = group("course");
    drawing.append(axes::frame(area, &y, &y_ticks));
    for level in [-1.0, 1.0] {
        let y = y.at(level);
        drawing.append(line([area.left, y], [area.right(), y], FAINT_INK, 0.8));
    }
    let last = growth.states.last().map(|(_, cells)| *cells);
    // More points than pixels would only swell the file.
    let every = growth.states.len().div_ceil(MOST_POINTS).max(1);
    for cell in 0..16 {
        let thinned = growth.states.iter().step_by(every);
        let points = thinned
            .chain(growth.states.last())
            .map(|(time, cells)| [x.at(*time), y.at(cells[cell].clamp(-2.0, 2.0))]);
        let up = last.is_some_and(|cells| cells[cell] > 0.0);
        let curve = Outline::through(points).stroked(if up { INK } else { FAINT_INK }, 1.1);
        let dashed = if up { "none" } else { "3 2" };
        drawing.append(curve.set("stroke-dasharray", dashed));
    }
    drawing.append(axes::border(area));
    drawing.append(axes::beside(area, &y, &y_ticks, ""));
    let ticks = axes::ticks([0.0, growth.settle_time], 5);
    drawing.append(axes::below(area, &x, &ticks, "t (dimensionless)"));
    drawing
}

fn legend(y: f64) -> Group {
    let mut legend = group("legend");
    legend.append(text([LEFT, y + 4.0], TEXT_SIZE, "State of a cell:"));
    for i in 0..9 {
        let value = -1.0 + 0.25 * f64::from(i);
        let area = Area {
            left: LEFT + 136.0 + 14.0 * f64::from(i),
            top: y - 7.0,
            width: 14.0,
            height: 14.0,
        };
        legend.append(rectangle(area, &shade(value)).set("stroke", GRID));
    }
    let low = text([LEFT + 130.0, y + 4.0], TEXT_SIZE, "\u{2264} \u{2212}1");
    legend.append(low.set("text-anchor", "end"));
    legend.append(text([LEFT + 270.0, y + 4.0], TEXT_SIZE, "\u{2265} 1"));
    let curves = [
        (COURSE - 40.0, INK, "none", "cell that ends above 1"),
        (
            COURSE + 160.0,
            FAINT_INK,
            "3 2",
            "cell that ends below \u{2212}1",
        ),
    ];
    for (x, ink, dashes, name) in curves {
        let sample = line([x, y], [x + 26.0, y], ink, 1.4);
        legend.append(sample.set("stroke-dasharray", dashes));
        legend.append(text([x + 34.0, y + 4.0], TEXT_SIZE, name));
    }
    legend
}
