//! The dashboard as a picture: one panel a file.
//!
//! ```text
//! header      connection, supervisor, session, message
//! sensors   | staircases
//! pattern   | pattern vector | history | lost and faults
//! notes       on taller terminals
//! keys
//! ```
//!
//! 80 columns and 24 rows hold all of it; more room goes to the staircases, the pattern vector and
//! the histories.

mod faults;
mod header;
mod help;
mod history;
mod look;
mod notes;
mod pattern;
mod sensors;
mod staircases;
mod vector;

pub use header::connection;
pub use look::Look;

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};

use self::look::Panel;
use super::app::App;

/// The least room that shows everything.
pub const COLUMNS: u16 = 80;
/// The same in rows.
pub const ROWS: u16 = 24;

/// From this many rows on there are notes.
const ROWS_WITH_NOTES: u16 = 30;
const UPPER: u16 = 8;
const LOWER: u16 = 11;
const SENSORS: u16 = 36;
const PATTERN: u16 = 17;
const HISTORY: u16 = 20;
const FAULTS: u16 = 18;

/// Draws everything that fits.
pub fn draw(area: Rect, buffer: &mut Buffer, app: &App, log: bool, look: Look) {
    if area.width < COLUMNS || area.height < ROWS {
        return draw_small(area, buffer, app, log, look);
    }
    let dashboard = &app.dashboard;
    let spare = area.height - ROWS;
    let notes = if area.height >= ROWS_WITH_NOTES {
        spare / 2
    } else {
        0
    };
    let upper = UPPER + (spare - notes) / 2;
    let rows = Layout::vertical([
        Constraint::Length(header::ROWS),
        Constraint::Length(upper),
        Constraint::Min(LOWER),
        Constraint::Length(notes),
        Constraint::Length(1),
    ]);
    let [head, upper, lower, notes, keys] = rows.areas(area);
    header::draw(head, buffer, dashboard, look);
    help::row(keys, buffer, app.prompt.as_ref(), log, look);
    if app.help {
        let all = Rect {
            height: area.height - header::ROWS - 1,
            ..upper
        };
        return help::draw(all, buffer, log, look);
    }
    let columns = Layout::horizontal([Constraint::Length(SENSORS), Constraint::Fill(1)]).spacing(1);
    let [left, right] = columns.areas(upper);
    sensors::draw(left, buffer, dashboard, look);
    staircases::draw(right, buffer, dashboard, look);
    // More columns of patterns for most of the room to spare, more history for the rest.
    let spare = area.width - COLUMNS;
    let pitch = vector::WIDTH + 1;
    let patterns = spare * 2 / 3 / pitch * pitch;
    let columns = Layout::horizontal([
        Constraint::Length(PATTERN),
        Constraint::Length(vector::WIDTH + patterns),
        Constraint::Length(HISTORY + spare - patterns),
        Constraint::Length(FAULTS),
    ])
    .spacing(1);
    let [left, vector, history, right] = columns.areas(lower);
    pattern::draw(left, buffer, dashboard, look);
    vector::draw(vector, buffer, dashboard, look);
    history::draw(history, buffer, dashboard, look);
    faults::draw(right, buffer, dashboard, look);
    if notes.height > 1 {
        notes::draw(notes, buffer, dashboard, look);
    }
}

/// What matters most, where there is no room for more.
fn draw_small(area: Rect, buffer: &mut Buffer, app: &App, log: bool, look: Look) {
    let mut panel = Panel::new(area, buffer, look);
    let (state, style) = header::state(&app.dashboard, look);
    panel.text(0, 0, &state, style.add_modifier(Modifier::REVERSED));
    let connection = header::connection(&app.dashboard);
    let y = panel.wrapped(1, &connection, Style::new());
    let wanted = format!(
        "This terminal has {} columns and {} rows; the dashboard wants {COLUMNS} and {ROWS}.",
        area.width, area.height
    );
    let y = panel.wrapped(y, &wanted, Style::new());
    let keys = if log {
        "space plays and pauses, q quits"
    } else {
        "space disarms, q quits"
    };
    panel.wrapped(y, keys, look.title());
}
