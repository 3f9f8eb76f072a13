//! Fig. 10b and 15: the patterns in use, how often they occurred and what they stand for.

use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::palette::{OTHERS, Palette, Used};
use super::shape::{
    Area, FAINT_INK, HEADER, Heading, INK, TEXT_SIZE, centred, group, line, number, pattern,
    rectangle, sheet, text,
};

/// Patterns shown; a trained robot is carried by some twenty.
const MOST: usize = 20;
const COLUMN: f64 = 46.0;
const LEFT: f64 = 74.0;
const DRAWING: f64 = 30.0;

/// Draws the patterns that chose the robot's actions, the most used first.
pub(super) fn draw(palette: &Palette, phase_limit_deg: f64, heading: &Heading) -> String {
    let ranked = palette.ranked();
    let shown = &ranked[..ranked.len().min(MOST)];
    // Wide enough for title and legend when few patterns are in use.
    let columns = shown.len().max(14) as f64;
    let width = COLUMN * columns;
    let counts = Area {
        left: LEFT,
        top: HEADER + 40.0,
        width,
        height: 210.0,
    };
    let drawings = counts.bottom() + 14.0;
    let turns = Area {
        left: LEFT,
        top: drawings + DRAWING + 58.0,
        width,
        height: 170.0,
    };
    let mut parts = vec![
        histogram(counts, shown, palette),
        actions(turns, shown, palette, phase_limit_deg),
    ];
    for (i, used) in shown.iter().enumerate() {
        let middle = LEFT + COLUMN * (i as f64 + 0.5);
        let at = [middle - DRAWING / 2.0, drawings];
        let code = centred(
            [middle, drawings + DRAWING + 15.0],
            11.0,
            used.code.to_string(),
        );
        let drawing = pattern(at, DRAWING, used.code, palette.colour(Some(used.code)));
        parts.push(group("column").add(drawing).add(code));
    }
    parts.push(legend(turns.bottom() + 32.0, palette));
    sheet([LEFT + width + 24.0, turns.bottom() + 70.0], heading, parts)
}

/// The patterns in use, in words: the most used ones.
pub(super) fn described(palette: &Palette) -> String {
    let patterns = palette.coloured().map(|(used, _)| {
        format!(
            "code {}, {} actions, {}",
            used.code,
            used.occurrences,
            used.turn()
        )
    });
    let most = patterns.collect::<Vec<_>>().join("; ");
    format!(
        "{} patterns; the most used: {most}.",
        palette.ranked().len()
    )
}

/// The middle of a column, and the bar's left edge and width.
fn column(i: usize) -> (f64, f64, f64) {
    let middle = LEFT + COLUMN * (i as f64 + 0.5);
    (middle, middle - 0.34 * COLUMN, 0.68 * COLUMN)
}

fn histogram(area: Area, shown: &[Used], palette: &Palette) -> Group {
    let most = shown.iter().map(|used| used.occurrences).max().unwrap_or(0) as f64;
    // Some room for the number above the highest bar.
    let high = axes::rounded_up((1.1 * most).max(1.0), 6);
    let y = Scale::linear([0.0, high], [area.bottom(), area.top]);
    let y_ticks = axes::ticks([0.0, high], 6);
    let mut drawing = group("panel");
    let heading = text([LEFT, area.top - 12.0], 13.0, "(a) Occurrences");
    drawing.append(heading.set("font-weight", "bold"));
    drawing.append(axes::frame(area, &y, &y_ticks));
    for (i, used) in shown.iter().enumerate() {
        let (middle, left, width) = column(i);
        let top = y.at(used.occurrences as f64);
        let bar = Area {
            left,
            top,
            width,
            height: area.bottom() - top,
        };
        drawing.append(rectangle(bar, palette.colour(Some(used.code))));
        drawing.append(centred(
            [middle, top - 4.0],
            10.0,
            used.occurrences.to_string(),
        ));
    }
    drawing.append(axes::border(area));
    drawing.append(axes::beside(area, &y, &y_ticks, "actions chosen (number)"));
    drawing
}

fn actions(area: Area, shown: &[Used], palette: &Palette, limit_deg: f64) -> Group {
    // Room for the number at a bar that ends at the limit.
    let high = 1.2 * limit_deg;
    let y = Scale::linear([-high, high], [area.bottom(), area.top]);
    let y_ticks: Vec<_> = axes::ticks([-limit_deg, limit_deg], 6);
    let mut drawing = group("panel");
    let heading = text([LEFT, area.top - 10.0], 13.0, "(b) Learned action");
    drawing.append(heading.set("font-weight", "bold"));
    drawing.append(axes::frame(area, &y, &y_ticks));
    for (i, used) in shown.iter().enumerate() {
        let (middle, left, width) = column(i);
        let Some(turn) = used.turn_deg else {
            drawing.append(centred([middle, y.at(0.0) - 4.0], 10.0, "none"));
            continue;
        };
        let (from, to) = (y.at(0.0), y.at(turn.clamp(-limit_deg, limit_deg)));
        let bar = Area {
            left,
            top: from.min(to),
            width,
            height: (from - to).abs(),
        };
        drawing.append(rectangle(bar, palette.colour(Some(used.code))));
        let label_y = if turn < 0.0 { to + 12.0 } else { to - 4.0 };
        drawing.append(centred([middle, label_y], 10.0, number(turn, 1)));
    }
    drawing.append(line(
        [area.left, y.at(0.0)],
        [area.right(), y.at(0.0)],
        INK,
        1.0,
    ));
    drawing.append(axes::border(area));
    drawing.append(axes::beside(area, &y, &y_ticks, "turn (degrees)"));
    for (label, y) in [("left", area.top + 14.0), ("right", area.bottom() - 7.0)] {
        let side = text([area.right() - 6.0, y], 11.0, label).set("text-anchor", "end");
        drawing.append(side.set("fill", FAINT_INK));
    }
    drawing
}

fn legend(y: f64, palette: &Palette) -> Group {
    let mut legend = group("legend");
    let mut x = LEFT;
    let swatch = |legend: &mut Group, x: f64, colour| {
        let (left, top) = (x, y - 10.0);
        legend.append(rectangle(
            Area {
                left,
                top,
                width: 11.0,
                height: 11.0,
            },
            colour,
        ));
    };
    for (_, colour) in palette.coloured() {
        swatch(&mut legend, x, colour);
        x += 14.0;
    }
    legend.append(text(
        [x + 6.0, y],
        TEXT_SIZE,
        "used most, coloured as in the trajectories",
    ));
    swatch(&mut legend, x + 290.0, OTHERS);
    legend.append(text([x + 310.0, y], TEXT_SIZE, "other patterns"));
    let ranked = palette.ranked();
    let sum = |of: &[Used]| of.iter().map(|used| used.occurrences).sum::<usize>();
    let mut count = format!("{} actions, {} patterns", sum(ranked), ranked.len());
    if let Some(rare) = ranked.get(MOST..).filter(|rare| !rare.is_empty()) {
        let (rare, actions) = (rare.len(), sum(rare));
        count += &format!("; the {rare} used least, for {actions} actions in all, are not shown");
    }
    if ranked.iter().take(MOST).any(|used| used.turn_deg.is_none()) {
        count += "; none: met in the test for the first time";
    }
    legend.append(text([LEFT, y + 21.0], TEXT_SIZE, count).set("fill", FAINT_INK));
    legend
}
