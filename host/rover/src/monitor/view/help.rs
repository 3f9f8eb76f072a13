//! The keys: the most used ones in one row, all of them on demand.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::look::{Look, Panel};
use crate::monitor::keys::{LIVE, LOG, Prompt};

const LIVE_ROW: &str =
    "space disarm  a arm  l learn  r run  i idle  <- -> g direction  ? keys  q quit";
const LOG_ROW: &str = "space play or pause  <- -> step  + - speed  0 $ start, end  ? keys  q quit";

/// Draws the last row: keys, or the direction being typed.
pub fn row(area: Rect, buffer: &mut Buffer, prompt: Option<&Prompt>, log: bool, look: Look) {
    let mut panel = Panel::new(area, buffer, look);
    let Some(prompt) = prompt else {
        panel.text(0, 0, if log { LOG_ROW } else { LIVE_ROW }, look.quiet());
        return;
    };
    let label = "direction, degrees clockwise from north: ";
    let x = panel.text(0, 0, label, look.title());
    let x = panel.text(x, 0, &format!("{}_", prompt.text), Style::new());
    if prompt.error.is_some() {
        panel.text(x + 1, 0, "-360 to 360!", look.trouble());
    } else {
        panel.text(x + 1, 0, "Enter sets it, Esc leaves it", look.quiet());
    }
}

/// Draws all keys.
pub fn draw(area: Rect, buffer: &mut Buffer, log: bool, look: Look) {
    let mut panel = Panel::titled(area, buffer, look, "Keys");
    let keys: &[_] = if log { &LOG } else { &LIVE };
    for (y, (key, does)) in (0..).zip(keys) {
        panel.text(0, y, key, look.title());
        panel.text(15, y, does, Style::new());
    }
}
