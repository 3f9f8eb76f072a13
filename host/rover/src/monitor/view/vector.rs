//! The pattern vector (II-B): the patterns used most, each with its drawing and its turn.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use rover_shared::perception::PatternCode;

use super::look::{Look, Panel};
use crate::monitor::model::{Dashboard, Knowledge};
use rover_link::text;
use rover_log::knowledge::followed::Pattern;

/// Columns that one pattern takes.
pub const WIDTH: u16 = 22;
/// The same in rows.
const ROWS: u16 = 2;

/// Draws as many patterns as there is room for.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let title = match dashboard.mirror() {
        Some(mirror) => format!("{} patterns by use", mirror.patterns().len()),
        None => "Patterns by use".into(),
    };
    let mut panel = Panel::titled(area, buffer, look, &title);
    let mirror = match &dashboard.knowledge {
        Knowledge::Known(mirror) => mirror,
        Knowledge::Unknown(why) => {
            let y = panel.wrapped(0, &format!("not known: {why}"), look.quiet());
            if dashboard.controller_drives() {
                let how = "it can be read when the rover does not drive (key i)";
                panel.wrapped(y, how, look.quiet());
            }
            return;
        }
    };
    let current = dashboard
        .action
        .and_then(|action| action.step.perceived)
        .map(|perceived| perceived.code);
    let columns = ((panel.width() + 1) / (WIDTH + 1)).max(1);
    let rows = panel.height() / ROWS;
    let room = usize::from(columns * rows);
    for (i, pattern) in mirror.by_use().iter().take(room).enumerate() {
        let (column, row) = (i as u16 / rows, i as u16 % rows);
        let at = (column * (WIDTH + 1), row * ROWS);
        entry(&mut panel, at, pattern, current == Some(pattern.code));
    }
}

fn entry(panel: &mut Panel<'_>, (x, y): (u16, u16), pattern: &Pattern, current: bool) {
    let style = if current {
        Style::new().add_modifier(Modifier::BOLD)
    } else {
        Style::new()
    };
    let [upper, lower] = thumbnail(panel.look, pattern.code);
    panel.text(x, y, &upper, style);
    panel.text(x, y + 1, &lower, style);
    let mark = if current { ">" } else { " " };
    let used = text::count(pattern.occurrences, 7);
    let text = format!("{mark}{:<6}{used:>7} x", pattern.code.0);
    panel.text(x + 5, y, &text, style);
    let turn = pattern.phase.map_or("turn unknown".into(), text::turn);
    panel.text(x + 6, y + 1, &turn, style);
}

/// The pattern in two rows of four characters.
fn thumbnail(look: Look, code: PatternCode) -> [String; 2] {
    let rows: Vec<_> = code.rows().collect();
    [0, 2].map(|upper| {
        let pair = rows[upper].iter().zip(&rows[upper + 1]);
        pair.map(|(up, down)| look.halves(*up, *down)).collect()
    })
}
