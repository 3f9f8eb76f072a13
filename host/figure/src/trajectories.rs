//! Fig. 5 to 9: trajectories before and after learning.

use rover_shared::units::Microdegrees;
use svg::Node as _;
use svg::node::element::Group;

use super::drive::Drive;
use super::palette::{OTHERS, Palette, width};
use super::shape::{
    Area, FAINT_INK, HEADER, Heading, Outline, TEXT_SIZE, group, pattern, sheet, text,
};
use super::situations::Scene;
use super::view::{
    MARK_EVERY, View, blocked_mark, direction_mark, heading_mark, pattern_mark, start_mark, target,
};
use rover_simulator::arena::Motion;

const SHEET_WIDTH: f64 = 1060.0;
/// Left of a panel, for its axis.
const LEFT: f64 = 58.0;
/// Above a panel, for two lines of text.
const ABOVE: f64 = 42.0;
/// Below a panel, for its axis.
const BELOW: f64 = 40.0;
const MOST_HEIGHT: f64 = 340.0;
const LEGEND_HEIGHT: f64 = 100.0;

/// Whether an arena takes the width of two columns.
fn is_wide(drive: &Drive) -> bool {
    drive.scenario.world.width_cm() > 1.6 * drive.scenario.world.height_cm()
}

/// Draws scenes side by side, with a legend below.
pub(super) fn draw(scenes: &[&Scene], palette: &Palette, heading: &Heading) -> String {
    let mut parts = Vec::new();
    // Drives without a target have less to say above their panels.
    let narrow = scenes
        .iter()
        .all(|s| s.drive.scenario.goal.is_none() && !is_wide(&s.drive));
    let columns = if narrow && scenes.len() > 2 { 3 } else { 2 };
    let width = (SHEET_WIDTH - 20.0) / columns as f64 - LEFT - 6.0;
    let mut top = HEADER;
    for (row, in_row) in scenes.chunks(columns).enumerate() {
        let mut height = 0.0f64;
        for (column, scene) in in_row.iter().enumerate() {
            let left = LEFT + (SHEET_WIDTH - 20.0) / columns as f64 * column as f64;
            let number = row * columns + column;
            let within = Area {
                left,
                top: top + ABOVE,
                width,
                height: MOST_HEIGHT,
            };
            let last_of_column = number + columns >= scenes.len();
            let labels = [last_of_column, column == 0];
            let view = View::new(&scene.drive.scenario.world, within);
            height = height.max(view.area.height);
            parts.push(panel(scene, number, &view, palette, labels));
        }
        top += ABOVE
            + height
            + if (row + 1) * columns >= scenes.len() {
                BELOW
            } else {
                22.0
            };
    }
    parts.push(legend(top + 12.0, palette, scenes));
    sheet([SHEET_WIDTH, top + LEGEND_HEIGHT + 12.0], heading, parts)
}

/// What the scenes show, in words.
pub(super) fn described(scenes: &[&Scene]) -> String {
    let lettered = scenes.iter().enumerate().map(|(i, scene)| {
        let letter = char::from(b'a' + i.min(25) as u8);
        format!("({letter}) {}: {}", scene.title, scene.outcome())
    });
    lettered.collect::<Vec<_>>().join("; ") + "."
}

/// One scene with its axes.
pub(super) fn panel(
    scene: &Scene,
    number: usize,
    view: &View,
    palette: &Palette,
    labels: [bool; 2],
) -> Group {
    let letter = char::from(b'a' + number.min(25) as u8);
    let Area { left, top, .. } = view.area;
    let mut panel = group("panel");
    let heading = format!("({letter}) {}", scene.title);
    panel.append(text([left, top - 22.0], 13.0, heading).set("font-weight", "bold"));
    let below = text([left, top - 7.0], TEXT_SIZE, scene.outcome());
    panel.append(below.set("fill", FAINT_INK));
    panel.append(view.arena(&scene.drive));
    panel.append(view.path(&scene.drive, palette));
    panel.append(view.marks(&scene.drive));
    for axis in view.axes(&scene.drive.scenario.world, labels[0], labels[1]) {
        panel.append(axis);
    }
    panel
}

/// What colours and marks mean.
fn legend(top: f64, palette: &Palette, scenes: &[&Scene]) -> Group {
    let drives: Vec<&Drive> = scenes.iter().map(|scene| &scene.drive).collect();
    let mut legend = pattern_legend(LEFT, top, palette);
    legend.append(mark_legend([LEFT, top + 74.0], &drives));
    legend
}

/// The marks that occur in drives.
pub(super) fn mark_legend([left, y]: [f64; 2], drives: &[&Drive]) -> Group {
    let mut legend = group("legend");
    let mut x = left;
    let mut entry = |mark: &dyn Fn([f64; 2]) -> Group, width: f64, name: &str| {
        legend.append(mark([x + 8.0, y]));
        legend.append(text([x + 24.0, y + 4.0], TEXT_SIZE, name));
        x += width;
    };
    let shows = |found: fn(&Drive) -> bool| drives.iter().any(|drive| found(drive));
    let ahead = Microdegrees(0);
    entry(&|at| start_mark(at, ahead), 100.0, "start");
    let name = format!("heading, every {MARK_EVERY} actions");
    entry(
        &|at| group("mark").add(heading_mark(at, ahead)),
        230.0,
        &name,
    );
    if shows(|drive| drive.scenario.goal.is_some()) {
        entry(&|at| target(at, 8.0), 110.0, "target");
    }
    if shows(|drive| {
        drive
            .events
            .iter()
            .any(|event| event.motion == Motion::Blocked)
    }) {
        entry(
            &|at| group("mark").add(blocked_mark(at)),
            150.0,
            "move blocked",
        );
    }
    if shows(|drive| drive.scenario.goal.is_none()) {
        entry(
            &|[x, y]| direction_mark([x - 9.0, y], ahead),
            200.0,
            "new direction to follow",
        );
    }
    legend
}

/// The coloured patterns, each with its drawing, code and turn.
pub(super) fn pattern_legend(left: f64, top: f64, palette: &Palette) -> Group {
    let mut legend = group("legend");
    let heading =
        "Colour, width and mark of a move: the pattern that chose it, its code and its turn";
    legend.append(text([left, top], TEXT_SIZE, heading));
    let mut x = left;
    for (rank, (used, colour)) in palette.coloured().enumerate() {
        legend.append(pattern([x, top + 12.0], 28.0, used.code, colour));
        // As on the way: a stretch of line, with the mark if there is one.
        let y = top + 47.0;
        let stretch = Outline::through([[x, y], [x + 28.0, y]]);
        legend.append(stretch.stroked(colour, width(Some(rank))));
        if let Some(mark) = pattern_mark([x + 14.0, y], rank) {
            legend.append(mark);
        }
        legend.append(
            text([x + 36.0, top + 23.0], TEXT_SIZE, used.code.to_string())
                .set("font-weight", "bold"),
        );
        legend.append(text([x + 36.0, top + 38.0], TEXT_SIZE, used.turn()));
        x += 140.0;
    }
    let others = palette
        .ranked()
        .len()
        .saturating_sub(palette.coloured().count());
    if others > 0 {
        let y = top + 26.0;
        legend.append(Outline::through([[x, y], [x + 24.0, y]]).stroked(OTHERS, 3.0));
        legend.append(text([x + 32.0, y + 4.0], TEXT_SIZE, "all others"));
    }
    legend
}
