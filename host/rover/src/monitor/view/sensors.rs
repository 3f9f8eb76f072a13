//! The range sensors, the compass and the angle to go.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rover_shared::contract::{ChannelHealth, CompassHealth};

use super::look::{Look, Panel};
use crate::monitor::model::Dashboard;
use rover_link::{names, text};

/// Column where health begins.
const HEALTH: u16 = 28;

/// Draws the sensors.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let mut panel = Panel::titled(area, buffer, look, "Sensors           cm counts health");
    let readings = dashboard.readings;
    for (channel, name) in names::CHANNELS.iter().enumerate() {
        let y = channel as u16;
        let distance = readings.and_then(|readings| readings.distances[channel]);
        let counts = readings.and_then(|readings| readings.counts);
        let counts = counts.map(|counts| counts[channel]);
        line(&mut panel, y, name, distance.map(text::centimetres), counts);
        if let Some(ranges) = &dashboard.ranges {
            let health = ranges[channel];
            let fit = matches!(health, ChannelHealth::Good);
            let unknown = matches!(health, ChannelHealth::Unknown | ChannelHealth::NotFitted);
            let style = style(look, fit, unknown);
            panel.text(HEALTH, y, names::channel_health(health), style);
        }
    }
    let front = readings.map(|readings| text::centimetres(readings.front));
    line(&mut panel, 4, "ahead, nearer", front, None);
    compass(&mut panel, dashboard);
}

fn line(panel: &mut Panel<'_>, y: u16, name: &str, cm: Option<String>, counts: Option<u16>) {
    let cm = cm.unwrap_or_default();
    let counts = counts.map(|c| c.to_string()).unwrap_or_default();
    let text = format!("{name:<14}{cm:>6}{counts:>7}");
    panel.text(0, y, &text, Style::new());
}

fn compass(panel: &mut Panel<'_>, dashboard: &Dashboard) {
    let look = panel.look;
    let heading = dashboard.readings.and_then(|readings| readings.heading);
    let heading = heading.map(text::compass);
    let text = format!("{:<14}{:>13}", "heading", heading.unwrap_or_default());
    panel.text(0, 5, &text, Style::new());
    if let Some(health) = dashboard.compass {
        let fit = health == CompassHealth::Good;
        let style = style(look, fit, health == CompassHealth::Unknown);
        panel.text(HEALTH, 5, names::compass_health(health), style);
    }
    let sensed = dashboard.action.map(|action| action.step.sensed);
    let heading = dashboard.readings.and_then(|readings| readings.heading);
    let angle = match (dashboard.direction, heading, sensed) {
        // Where a direction is followed, the angle is known at every moment.
        (Some(direction), Some(heading), _) => text::turn(direction.turn_from(heading)),
        (_, _, None) => String::new(),
        (_, _, Some(None)) => "not sensed".into(),
        (_, _, Some(Some(sensed))) => text::turn(sensed.target_angle),
    };
    panel.text(
        0,
        6,
        &format!("{:<12}{angle:>15}", "angle to go"),
        Style::new(),
    );
}

fn style(look: Look, fit: bool, unknown: bool) -> Style {
    match (fit, unknown) {
        (true, _) => look.good(),
        (false, true) => look.quiet(),
        (false, false) => look.trouble(),
    }
}
