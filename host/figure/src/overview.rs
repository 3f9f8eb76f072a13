//! All of it in one picture: a robot before and after learning, and what it perceives by.

use svg::Node as _;

use super::lattice::{self, Growth, ROW};
use super::palette::Palette;
use super::shape::{Area, FAINT_INK, HEADER, Heading, TEXT_SIZE, group, sheet, text};
use super::situations::Scene;
use super::trajectories::{mark_legend, panel, pattern_legend};
use super::view::View;

const SHEET_WIDTH: f64 = 1060.0;
const MOST_HEIGHT: f64 = 300.0;

/// The growths shown: that of the pattern used most, and that of the first with an obstacle ahead.
pub(super) fn chosen(growths: &[Growth]) -> Vec<&Growth> {
    let first = growths.first();
    let mut others = growths.iter().skip(1);
    let ahead = others.clone().find(|growth| growth.sees_ahead());
    let ahead = ahead.or_else(|| others.next());
    first.into_iter().chain(ahead).collect()
}

/// Draws one or two scenes and the growths below them.
pub(super) fn draw(
    scenes: &[&Scene],
    growths: &[&Growth],
    palette: &Palette,
    heading: &Heading,
) -> String {
    let mut parts = Vec::new();
    let mut bottom = HEADER;
    for (i, scene) in scenes.iter().enumerate() {
        let within = Area {
            left: 58.0 + 520.0 * i as f64,
            top: HEADER + 46.0,
            width: 456.0,
            height: MOST_HEIGHT,
        };
        let view = View::new(&scene.drive.scenario.world, within);
        bottom = view.area.bottom().max(bottom);
        parts.push(panel(scene, i, &view, palette, [true, i == 0]));
    }
    let drives: Vec<_> = scenes.iter().map(|scene| &scene.drive).collect();
    let legend = bottom + 66.0;
    parts.push(pattern_legend(58.0, legend, palette));
    parts.push(mark_legend([58.0, legend + 74.0], &drives));
    let top = legend + 116.0;
    let letter = char::from(b'a' + scenes.len() as u8);
    let title = format!("({letter}) How a percept grows from what is sensed");
    let mut caption = group("heading");
    caption.append(text([24.0, top], 13.0, title).set("font-weight", "bold"));
    let how = "Corners: front, left, right and target as sensed. Grey: states from \u{2212}1 (white) to 1";
    caption.append(text([24.0, top + 17.0], TEXT_SIZE, how).set("fill", FAINT_INK));
    caption.append(lattice::course_title(top + 17.0));
    parts.push(caption);
    for (i, growth) in growths.iter().enumerate() {
        parts.push(lattice::row(growth, top + 24.0 + ROW * i as f64, palette));
    }
    let height = top + 24.0 + ROW * growths.len() as f64;
    sheet([SHEET_WIDTH, height], heading, parts)
}
