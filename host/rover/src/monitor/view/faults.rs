//! Counters of losses and of faults.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rover_shared::contract::State;

use super::look::{Look, Panel};
use crate::lines;
use crate::monitor::model::Dashboard;
use rover_link::{names, text};

/// Draws the counters: the host's always, the board's where they are not 0.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let mut panel = Panel::titled(area, buffer, look, "Lost, and faults");
    let frames = &dashboard.frames;
    let lost = [
        ("frames lost", frames.lost),
        ("frames bad", frames.damaged),
        ("reports unread", frames.unread),
        ("actions missed", dashboard.missed.into()),
        ("reconnected", frames.reconnected),
    ];
    let mut y = 0;
    for (name, count) in lost {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        line(&mut panel, y, name, count, style(look, count));
        y += 1;
    }
    let faults: Vec<_> = lines::counted(&dashboard.counters).collect();
    if faults.is_empty() {
        panel.text(0, y, "no faults counted", look.quiet());
        return;
    }
    let room = usize::from(panel.height().saturating_sub(y));
    let shown = if faults.len() > room {
        room.saturating_sub(1)
    } else {
        faults.len()
    };
    for (fault, count) in &faults[..shown] {
        let present = dashboard.state == Some(State::Faulted(*fault));
        let style = if present {
            look.trouble()
        } else {
            Style::new()
        };
        line(&mut panel, y, names::fault(*fault), *count, style);
        y += 1;
    }
    let more = faults.len() - shown;
    if more > 0 {
        panel.text(0, y, &format!("and {more} more"), look.quiet());
    }
}

fn line(panel: &mut Panel<'_>, y: u16, name: &str, count: u32, style: Style) {
    let room = usize::from(panel.width()).saturating_sub(name.len() + 1);
    panel.text(0, y, name, style);
    panel.right(y, &text::count(count, room), style);
}

fn style(look: Look, count: u32) -> Style {
    if count == 0 {
        look.quiet()
    } else {
        look.trouble()
    }
}
