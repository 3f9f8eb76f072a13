//! The staircases of the four sensing neurons (II-D), and the step that is active.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use rover_shared::sensing::Stimulus;
use rover_shared::sensing::neuron::{Activation, STEPS};

use super::look::{Look, Panel};
use crate::monitor::model::{Dashboard, Knowledge};
use rover_link::names;

/// Rows besides those of the steps: name, mark, value.
const OTHER_ROWS: u16 = 3;
/// The scale of staircases that have not learned anything yet.
const LEAST: f64 = 0.01;

/// Draws the staircases, all to one scale, zero at half height.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let largest = dashboard.mirror().map(largest);
    let title = match largest {
        Some(LEAST) => "Staircases, all 0".into(),
        Some(largest) => format!("Staircases, -{largest:.2} to {largest:.2}"),
        None => "Staircases".into(),
    };
    let mut panel = Panel::titled(area, buffer, look, &title);
    // As wide as there is room: one column or more a step, one between the neurons.
    let step_width = (panel.width().saturating_sub(3) / (4 * STEPS as u16)).max(1);
    let pitch = step_width * STEPS as u16 + 1;
    let bar_rows = panel.height().saturating_sub(OTHER_ROWS);
    for (i, stimulus) in Stimulus::ALL.into_iter().enumerate() {
        let x = pitch * i as u16;
        panel.text(x, 0, names::stimulus(stimulus), Style::new());
        let active = active(dashboard, i);
        if let (Some(mirror), Some(largest)) = (dashboard.mirror(), largest) {
            for (s, amplitude) in mirror.neurons()[i].amplitudes().iter().enumerate() {
                let share = real(amplitude.0) / largest / 2.0 + 0.5;
                let is_active = active.is_some_and(|(step, _)| step == s);
                let style = if is_active { look.live() } else { Style::new() };
                let at = x + step_width * s as u16;
                bar(&mut panel, at, step_width, bar_rows, share, style);
            }
        }
        mark(&mut panel, x, step_width, bar_rows + 1, active);
    }
    if let Knowledge::Unknown(why) = &dashboard.knowledge {
        panel.text(0, 1, "not known:", look.quiet());
        panel.wrapped(2, &why.to_string(), look.quiet());
    }
}

/// The active step of a neuron and its output, Q20, at the latest action.
fn active(dashboard: &Dashboard, neuron: usize) -> Option<(usize, Option<i32>)> {
    let step = &dashboard.action.as_ref()?.step;
    let active = step.sensed?.percept.steps()[neuron];
    let output = step.perceived.map(|perceived| perceived.corners.0[neuron]);
    Some((active.index(), output))
}

/// A bar from below; something of it is always seen.
fn bar(panel: &mut Panel<'_>, x: u16, width: u16, rows: u16, share: f64, style: Style) {
    let eighths = (share * f64::from(rows) * 8.0).round().max(1.0) as usize;
    for row in 0..rows {
        let filled = eighths.saturating_sub(8 * usize::from(row)).min(8);
        let cell = panel.look.eighths(filled).repeat(usize::from(width));
        panel.text(x, rows - row, &cell, style);
    }
}

/// The mark under the active step, and below it step and output.
fn mark(panel: &mut Panel<'_>, x: u16, width: u16, y: u16, active: Option<(usize, Option<i32>)>) {
    let Some((step, output)) = active else {
        return;
    };
    let style = Style::new().add_modifier(Modifier::BOLD);
    panel.text(
        x + width * step as u16,
        y,
        &"^".repeat(usize::from(width)),
        style,
    );
    let output = output.map_or(String::new(), |output| format!(" {:+.2}", real(output)));
    panel.text(x, y + 1, &format!("{step}:{output}"), style);
}

/// The largest amplitude of all, or [`LEAST`].
fn largest(mirror: &rover_log::knowledge::followed::Followed) -> f64 {
    let amplitudes = mirror.neurons().iter().flat_map(|n| n.amplitudes());
    amplitudes.map(|a| real(a.0).abs()).fold(LEAST, f64::max)
}

/// A Q20 number.
fn real(q20: i32) -> f64 {
    f64::from(q20) / f64::from(Activation::ONE)
}
