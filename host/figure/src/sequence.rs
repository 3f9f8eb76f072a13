//! Fig. 10: a trajectory and the sequence of patterns that drove it.

use rover_shared::perception::PatternCode;
use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::drive::Drive;
use super::palette::{COLOURS, OTHERS, Palette, Used};
use super::shape::{
    Area, FAINT_INK, GRID, HEADER, Heading, INK, Outline, TEXT_SIZE, centred, circle, group, line,
    pattern, rectangle, sheet, text,
};
use super::situations::{Scene, outcome};
use super::trajectories::mark_legend;
use super::view::{View, pattern_mark};
use rover_simulator::arena::{Side, Vector, radians};
use rover_simulator::experiment::Event;

const SHEET_WIDTH: f64 = 1000.0;
/// Where action 0 is drawn; left of it, pattern, code and turn.
const LEFT: f64 = 226.0;
const WIDTH: f64 = SHEET_WIDTH - LEFT - 30.0;
const ROW: f64 = 24.0;
const STRIP: f64 = 16.0;
/// Patterns with a row of their own.
const MOST_ROWS: usize = 16;
const SEEN: &str = "#6e6e6e";

/// Draws a drive and which pattern chose each of its actions.
pub(super) fn draw(scene: &Scene, palette: &Palette, heading: &Heading) -> String {
    let drive = &scene.drive;
    let within = Area {
        left: 90.0,
        top: HEADER + 34.0,
        width: 860.0,
        height: 330.0,
    };
    let view = View::centred(&drive.scenario.world, within);
    let mut parts = vec![course(scene, &view, palette)];
    let actions = drive.events.len().max(1) as f64;
    let x = Scale::linear([0.0, actions], [LEFT, LEFT + WIDTH]);

    let top = view.area.bottom() + 70.0;
    parts.push(text_group([20.0, top], "Something in the sensor's range"));
    let strips = Area {
        left: LEFT,
        top: top + 10.0,
        width: WIDTH,
        height: 3.0 * STRIP,
    };
    parts.push(encounters(drive, strips, &x));

    let top = strips.bottom() + 34.0;
    let (rows, others) = rows(drive, palette);
    parts.push(text_group(
        [20.0, top],
        "Pattern, code, how often, and turn, in the order of first occurrence",
    ));
    let shown = rows.len() + usize::from(others > 0);
    let area = Area {
        left: LEFT,
        top: top + 12.0,
        width: WIDTH,
        height: ROW * shown.max(1) as f64,
    };
    parts.push(sequence(drive, area, &x, &rows, others, palette));
    let ticks = axes::ticks([0.0, actions], 10);
    parts.push(axes::below(area, &x, &ticks, "action (number)"));
    parts.push(legend(
        area.bottom() + 62.0,
        palette,
        changes(drive).next().is_some(),
    ));
    parts.push(mark_legend([20.0, area.bottom() + 84.0], &[drive]));
    sheet([SHEET_WIDTH, area.bottom() + 106.0], heading, parts)
}

/// The drive in words: its patterns by use.
pub(super) fn described(drive: &Drive, palette: &Palette) -> String {
    let mut counts: Vec<(PatternCode, usize)> = occurrences(drive);
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let most = counts.iter().take(6).map(|(code, count)| {
        let used = palette.ranked().iter().find(|used| used.code == *code);
        let turn = used.map(Used::turn).unwrap_or_default();
        format!("code {code}, {count} actions, {turn}")
    });
    let most = most.collect::<Vec<_>>().join("; ");
    format!(
        "{}; {} patterns, most often {most}.",
        outcome(drive),
        counts.len()
    )
}

/// How often each pattern chose an action, in the order of their first occurrence.
fn occurrences(drive: &Drive) -> Vec<(PatternCode, usize)> {
    let mut counted: Vec<(PatternCode, usize)> = Vec::new();
    for code in drive.codes().flatten() {
        match counted.iter_mut().find(|(known, _)| *known == code) {
            Some((_, count)) => *count += 1,
            None => counted.push((code, 1)),
        }
    }
    counted
}

fn text_group(at: [f64; 2], heading: &str) -> Group {
    group("heading").add(text(at, 13.0, heading).set("font-weight", "bold"))
}

/// The trajectory, with the numbers of some actions.
fn course(scene: &Scene, view: &View, palette: &Palette) -> Group {
    let (drive, area) = (&scene.drive, view.area);
    let mut course = group("panel");
    let heading = format!(
        "Trajectory, with the numbers of some actions: {}",
        outcome(drive)
    );
    course.append(text([20.0, area.top - 12.0], 13.0, heading).set("font-weight", "bold"));
    course.append(view.arena(drive));
    course.append(view.path(drive, palette));
    course.append(view.marks(drive));
    for (i, [x, y]) in numbered(drive, view) {
        // A white rim keeps it readable over path and obstacles.
        course.append(
            centred([x, y + 4.0], 11.0, i.to_string())
                .set("stroke", "#ffffff")
                .set("stroke-width", 3)
                .set("paint-order", "stroke")
                .set("stroke-linejoin", "round"),
        );
    }
    for axis in view.axes(&drive.scenario.world, true, true) {
        course.append(axis);
    }
    course
}

/// Actions whose numbers are written beside the path, and where: on its left or right, inside the
/// arena, clear of each other and if possible of obstacles. Without room, the number is left out.
fn numbered(drive: &Drive, view: &View) -> Vec<(usize, [f64; 2])> {
    let every = if drive.events.len() > 100 { 20 } else { 10 };
    let mut placed: Vec<(usize, [f64; 2])> = Vec::new();
    for (i, event) in drive.events.iter().enumerate().step_by(every).skip(1) {
        let (sin, cos) = libm::sincos(radians(event.pose.heading));
        let sides = [1.0, -1.0].map(|side| {
            let beside = Vector::new(-17.0 * sin, 14.0 * cos) * (side / view.px_per_cm);
            event.pose.position() + beside
        });
        let fits = |place: &Vector| {
            let ([x, y], area) = (view.at(*place), view.area);
            let inside = (area.left + 12.0..area.right() - 12.0).contains(&x)
                && (area.top + 9.0..area.bottom() - 9.0).contains(&y);
            let clear = |[u, v]: [f64; 2]| (x - u).abs() > 24.0 || (y - v).abs() > 13.0;
            inside && placed.iter().all(|(_, other)| clear(*other))
        };
        let world = &drive.scenario.world;
        let free = |place: &&Vector| world.clearance(**place) * view.px_per_cm > 9.0;
        let places: Vec<Vector> = sides.into_iter().filter(fits).collect();
        if let Some(place) = places.iter().find(free).or(places.first()) {
            placed.push((i, view.at(*place)));
        }
    }
    placed
}

/// Three strips that show when each sensor saw something.
fn encounters(drive: &Drive, area: Area, x: &Scale) -> Group {
    let mut strips = group("encounters");
    let sides = [
        (Side::Front, "front"),
        (Side::Left, "left"),
        (Side::Right, "right"),
    ];
    for (i, (side, name)) in sides.into_iter().enumerate() {
        let top = area.top + STRIP * i as f64;
        let label = text([LEFT - 10.0, top + 12.0], TEXT_SIZE, name).set("text-anchor", "end");
        strips.append(label);
        for [from, to] in runs(drive.events.iter().map(|event| drive.saw(event, side))) {
            let [left, right] = [from, to].map(|action| x.at(action as f64));
            let seen = Area {
                left,
                top: top + 2.0,
                width: right - left,
                height: STRIP - 4.0,
            };
            strips.append(rectangle(seen, SEEN));
        }
        if i > 0 {
            strips.append(line([area.left, top], [area.right(), top], GRID, 1.0));
        }
    }
    strips.append(axes::border(area));
    strips
}

/// First and one past last of each stretch of `true`.
fn runs(flags: impl Iterator<Item = bool>) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for (i, _) in flags.enumerate().filter(|(_, flag)| *flag) {
        match runs.last_mut() {
            Some([_, end]) if *end == i => *end += 1,
            _ => runs.push([i, i + 1]),
        }
    }
    runs
}

/// The patterns that get a row, in the order of their first occurrence, and how many do not.
fn rows(drive: &Drive, palette: &Palette) -> (Vec<(PatternCode, usize)>, usize) {
    let counted = occurrences(drive);
    let mut counts: Vec<usize> = counted.iter().map(|(_, count)| *count).collect();
    counts.sort_unstable_by_key(|count| std::cmp::Reverse(*count));
    // Among equally rare ones, the first to occur get the rows left.
    let least = counts.get(MOST_ROWS - 1).copied().unwrap_or(0);
    let mut ties = MOST_ROWS
        - counts
            .iter()
            .take(MOST_ROWS)
            .filter(|c| **c > least)
            .count();
    let coloured = |code| palette.colour(Some(code)) != OTHERS;
    let mut rows = Vec::new();
    for (code, count) in &counted {
        let tied = *count == least && ties > 0;
        if *count > least || tied || coloured(*code) {
            ties -= usize::from(tied);
            rows.push((*code, *count));
        }
    }
    let others = counted.len() - rows.len();
    (rows, others)
}

/// Which pattern chose which action.
fn sequence(
    drive: &Drive,
    area: Area,
    x: &Scale,
    rows: &[(PatternCode, usize)],
    others: usize,
    palette: &Palette,
) -> Group {
    let mut drawing = group("sequence");
    let middle = |row: usize| area.top + ROW * (row as f64 + 0.5);
    for (row, (code, count)) in rows.iter().enumerate() {
        drawing.append(line(
            [area.left, middle(row)],
            [area.right(), middle(row)],
            GRID,
            1.0,
        ));
        let colour = palette.colour(Some(*code));
        drawing.append(pattern([24.0, middle(row) - 9.0], 18.0, *code, colour));
        drawing.append(text([50.0, middle(row) + 4.0], TEXT_SIZE, code.to_string()));
        let rank = palette.rank(Some(*code));
        if let Some(mark) = rank.and_then(|rank| pattern_mark([100.0, middle(row)], rank)) {
            drawing.append(mark);
        }
        let times = text(
            [140.0, middle(row) + 4.0],
            TEXT_SIZE,
            format!("{count}\u{d7}"),
        );
        drawing.append(times.set("text-anchor", "end"));
        let used = palette.ranked().iter().find(|used| used.code == *code);
        let turn = used.map(Used::turn).unwrap_or_default();
        let turn = text([LEFT - 10.0, middle(row) + 4.0], TEXT_SIZE, turn);
        drawing.append(turn.set("text-anchor", "end").set("fill", FAINT_INK));
    }
    if others > 0 {
        let y = middle(rows.len());
        let name = format!("{others} more, rarely used");
        drawing.append(text([LEFT - 10.0, y + 4.0], TEXT_SIZE, name).set("text-anchor", "end"));
    }
    let row_of = |code| {
        rows.iter()
            .position(|(row, _)| *row == code)
            .unwrap_or(rows.len())
    };
    let places: Vec<Option<(PatternCode, [f64; 2])>> = (0u32..)
        .zip(drive.codes())
        .map(|(i, code)| code.map(|code| (code, [x.at(f64::from(i) + 0.5), middle(row_of(code))])))
        .collect();
    for (i, _) in changes(drive) {
        let x = x.at(i as f64);
        let change = line([x, area.top], [x, area.bottom()], INK, 0.9);
        drawing.append(change.set("stroke-dasharray", CHANGE));
    }
    let joined = Outline::through(places.iter().flatten().map(|(_, place)| *place));
    if !joined.is_empty() {
        drawing.append(joined.stroked("#bdbdbd", 0.7));
    }
    let radius = (0.45 * area.width / places.len().max(1) as f64).clamp(1.2, 4.0);
    for colour in std::iter::once(OTHERS).chain(COLOURS) {
        let here = places
            .iter()
            .flatten()
            .filter(|(code, _)| palette.colour(Some(*code)) == colour);
        let dots = Outline::dots(here.map(|(_, place)| *place));
        if !dots.is_empty() {
            drawing.append(dots.dotted(colour, 2.0 * radius));
        }
    }
    drawing.append(axes::border(area));
    drawing
}

/// Dashes of the line at which the direction changes.
const CHANGE: &str = "4 3";

/// The actions before which the direction to follow changed.
fn changes(drive: &Drive) -> impl Iterator<Item = (usize, &Event)> {
    let events = drive.events.iter().enumerate();
    events.filter(|(i, event)| *i > 0 && event.interrupted)
}

fn legend(y: f64, palette: &Palette, with_changes: bool) -> Group {
    let mut legend = group("legend");
    let mut x = 20.0;
    for (_, colour) in palette.coloured() {
        legend.append(circle([x, y - 4.0], 4.0, colour));
        x += 11.0;
    }
    legend.append(text(
        [x + 4.0, y],
        TEXT_SIZE,
        "an action chosen by one of the patterns used most",
    ));
    legend.append(circle([x + 390.0, y - 4.0], 4.0, OTHERS));
    legend.append(text([x + 400.0, y], TEXT_SIZE, "by another"));
    legend.append(rectangle(
        Area {
            left: x + 490.0,
            top: y - 10.0,
            width: 22.0,
            height: 11.0,
        },
        SEEN,
    ));
    legend.append(text([x + 518.0, y], TEXT_SIZE, "something in range").set("fill", INK));
    if with_changes {
        let change = line([x + 660.0, y - 12.0], [x + 660.0, y + 3.0], INK, 0.9);
        legend.append(change.set("stroke-dasharray", CHANGE));
        legend.append(text([x + 670.0, y], TEXT_SIZE, "new direction to follow"));
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_the_stretches_of_true() {
        let flags = [true, true, false, false, true, false, true];
        assert_eq!(runs(flags.into_iter()), [[0, 2], [4, 5], [6, 7]]);
        assert!(runs([false, false].into_iter()).is_empty());
    }
}
