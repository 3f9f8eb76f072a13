//! What happened, in lines, the latest last.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

use super::look::{Look, Panel};
use crate::monitor::model::Dashboard;
use rover_link::text;

/// Draws the latest notes.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let mut panel = Panel::titled(area, buffer, look, "What happened");
    let room = usize::from(panel.height());
    let skipped = dashboard.notes.len().saturating_sub(room);
    for (y, note) in (0..).zip(dashboard.notes.iter().skip(skipped)) {
        let time = note.time.map(text::clock).unwrap_or_default();
        let x = panel.text(0, y, &format!("{time:>9}"), look.quiet());
        panel.text(x + 2, y, &note.line.text, look.line(note.line.kind));
    }
}
