//! The range sensors, the compass and the angle to go.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rover_shared::wire::message::{ChannelHealth, CompassHealth};

use super::look::{Look, Panel};
use crate::monitor::model::{Action, Dashboard};
use crate::monitor::words;

/// Columns where counts end and health begins.
const CENTIMETRES_END: usize = 19;
const COUNTS_END: usize = 26;
const HEALTH: u16 = 28;

/// Draws the sensors; the front sensors' distance is the shorter one of both.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let mut panel = Panel::titled(area, buffer, look, "Sensors      cm counts health");
    let action = dashboard.action.as_ref();
    let sample = action.map(|action| &action.sample);
    let front = sample.map(|s| s.front);
    line(&mut panel, 0, "front", front.map(words::centimetres), None);
    let distances = [None, None, sample.map(|s| s.left), sample.map(|s| s.right)];
    for (channel, distance) in distances.into_iter().enumerate() {
        let y = channel as u16 + 1;
        let name = ["  its left", "  its right", "left", "right"][channel];
        let counts = action.and_then(|a| a.counts).map(|counts| counts[channel]);
        line(&mut panel, y, name, distance.map(words::centimetres), counts);
        if let Some(ranges) = &dashboard.ranges {
            let health = ranges[channel];
            let fit = matches!(health, ChannelHealth::Good);
            let unknown = matches!(health, ChannelHealth::Unknown | ChannelHealth::NotFitted);
            let style = style(look, fit, unknown);
            panel.text(HEALTH, y, words::channel_health(health), style);
        }
    }
    compass(&mut panel, dashboard, action);
}

fn line(panel: &mut Panel<'_>, y: u16, name: &str, cm: Option<String>, counts: Option<u16>) {
    let cm = cm.unwrap_or_default();
    let counts = counts.map(|c| c.to_string()).unwrap_or_default();
    let width = CENTIMETRES_END - 12;
    let after = COUNTS_END - CENTIMETRES_END;
    let text = format!("{name:<12}{cm:>width$}{counts:>after$}");
    panel.text(0, y, &text, Style::new());
}

fn compass(panel: &mut Panel<'_>, dashboard: &Dashboard, action: Option<&Action>) {
    let look = panel.look;
    let heading = action.map(|a| words::compass(a.sample.heading));
    let text = format!("{:<12}{:>13}", "heading", heading.unwrap_or_default());
    panel.text(0, 5, &text, Style::new());
    if let Some(health) = dashboard.compass {
        let fit = health == CompassHealth::Good;
        let style = style(look, fit, health == CompassHealth::Unknown);
        panel.text(HEALTH, 5, words::compass_health(health), style);
    }
    let sensed = action.and_then(|a| a.step.sensed);
    let angle = match (action, sensed) {
        (None, _) => String::new(),
        (Some(_), None) => "not sensed".into(),
        (Some(_), Some(sensed)) => words::turn(sensed.target_angle),
    };
    panel.text(0, 6, &format!("{:<12}{angle:>15}", "to go"), Style::new());
}

fn style(look: Look, fit: bool, unknown: bool) -> Style {
    match (fit, unknown) {
        (true, _) => look.good(),
        (false, true) => look.quiet(),
        (false, false) => look.trouble(),
    }
}
