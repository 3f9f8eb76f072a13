//! Reward and phase over the latest actions, one column an action.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::look::{Look, Panel};
use crate::monitor::model::{Dashboard, Moment};

/// Draws the history; the latest action is on the right.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let title = format!("Last {} actions", area.width);
    let mut panel = Panel::titled(area, buffer, look, &title);
    let width = usize::from(panel.width());
    let skipped = dashboard.history.len().saturating_sub(width);
    let shown: Vec<_> = dashboard.history.iter().skip(skipped).copied().collect();
    let left = (width - shown.len().min(width)) as u16;
    // Two labels; the rest for bars, one row more for turns, which go both ways.
    let rows = panel.height().saturating_sub(2);
    let (reward_rows, turn_rows) = (rows / 2, rows - rows / 2);
    reward(&mut panel, left, reward_rows, &shown);
    turn(&mut panel, left, reward_rows + 1, turn_rows, &shown);
}

/// Bars from the worst reward shown up to 0, the best that there can be.
fn reward(panel: &mut Panel<'_>, left: u16, rows: u16, shown: &[Option<Moment>]) {
    let of = |moment: &Option<Moment>| moment.and_then(|m| m.reward);
    let latest = shown.last().and_then(of);
    let worst = shown.iter().filter_map(of).min().unwrap_or(0).min(-1);
    let label = match latest {
        Some(reward) => format!("reward {:.2}", f64::from(reward) / 1e6),
        None => "reward".into(),
    };
    let x = panel.text(0, 0, &label, Style::new());
    let scale = format!("  {:.0} to 0", f64::from(worst) / 1e6);
    if latest.is_some() && usize::from(panel.width() - x) >= scale.len() {
        panel.right(0, &scale, panel.look.quiet());
    }
    for (x, reward) in (left..).zip(shown.iter().map(of)) {
        let Some(reward) = reward else { continue };
        let share = 1.0 - f64::from(reward) / f64::from(worst);
        let eighths = (share * f64::from(rows) * 8.0).round().max(1.0) as usize;
        for row in 0..rows {
            let filled = eighths.saturating_sub(8 * usize::from(row)).min(8);
            let cell = panel.look.eighths(filled);
            panel.text(x, rows - row, cell, Style::new());
        }
    }
}

/// Bars up for turns to the left, down for turns to the right.
fn turn(panel: &mut Panel<'_>, left: u16, top: u16, rows: u16, shown: &[Option<Moment>]) {
    let moments = || shown.iter().map(|m| m.map(|m| f64::from(m.phase.0) / 1e6));
    let largest = moments().flatten().map(f64::abs).fold(1.0, f64::max);
    let label = format!("turn to {largest:.0} deg L/R");
    panel.text(0, top, &label, Style::new());
    for (x, turn) in (left..).zip(moments()) {
        let Some(turn) = turn else { continue };
        let halves = (turn / largest * f64::from(rows)).round() as i32;
        for row in 0..rows {
            // Half cells, counted upwards from the middle.
            let lower = 2 * i32::from(rows - 1 - row) - i32::from(rows);
            let filled = |half: i32| {
                if halves >= 0 {
                    (0..halves).contains(&half)
                } else {
                    (halves..0).contains(&half)
                }
            };
            let cell = match panel.look.halves(filled(lower + 1), filled(lower)) {
                " " if halves == 0 && (lower..lower + 2).contains(&0) => "-",
                cell => cell,
            };
            panel.text(x, top + 1 + row, cell, Style::new());
        }
    }
}
