//! The Turing pattern that was perceived last, and what was done about it.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rover_shared::controller::{Familiarity, StepRecord};

use super::look::{Look, Panel};
use crate::monitor::model::Dashboard;
use rover_link::{names, text};

/// Draws the pattern, its familiarity and the action.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let action = dashboard.action.as_ref();
    let perceived = action.and_then(|action| action.step.perceived);
    let title = match perceived {
        Some(perceived) => format!("Pattern {}", perceived.code),
        None => "Pattern".into(),
    };
    let mut panel = Panel::titled(area, buffer, look, &title);
    let Some(action) = action else {
        panel.wrapped(
            0,
            "none yet: the rover perceives while it drives",
            look.quiet(),
        );
        return;
    };
    match perceived {
        Some(perceived) => {
            let rows = text::pattern(perceived.code, look.lattice_cells());
            for (y, row) in (0..).zip(&rows) {
                panel.text(0, y, row, Style::new());
            }
            let familiarity = match perceived.familiarity {
                Familiarity::Known => match dashboard.mirror() {
                    Some(mirror) => mirror
                        .pattern(perceived.code)
                        .map_or("known".into(), |p| format!("met {} times", p.occurrences)),
                    None => "known".into(),
                },
                Familiarity::New => "met first now".into(),
                Familiarity::Replaced(old) => format!("new for {old}"),
            };
            panel.text(0, 4, &familiarity, Style::new());
        }
        None => {
            let why = if action.step.unsettled() {
                "none: the lattice did not settle"
            } else {
                "none: the target is not sensed"
            };
            panel.wrapped(0, why, look.trouble());
        }
    }
    panel.text(0, 5, &text::turn(action.step.action.phase), look.title());
    let advance = text::centimetres(action.step.action.module);
    panel.text(0, 6, &format!("ahead {advance} cm"), Style::new());
    if let Some(outcome) = action.outcome {
        panel.text(0, 7, names::outcome(outcome), Style::new());
    }
    panel.text(0, 8, &gain(&action.step), Style::new());
}

/// What the action before was worth: DRF.
fn gain(step: &StepRecord) -> String {
    step.learned.map_or(String::new(), |learned| {
        format!("gain {:+.2}", f64::from(learned.reward_difference) / 1e6)
    })
}
