//! The upper rows: connection, supervisor, session, and the latest of what happened.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use rover_shared::contract::State;

use super::look::{Look, Panel};
use crate::lines;
use crate::monitor::feed::{Connection, Playback};
use crate::monitor::model::{Dashboard, Knowledge};
use rover_link::{names, text};

/// Rows of the header.
pub const ROWS: u16 = 4;

/// Draws the header.
pub fn draw(area: Rect, buffer: &mut Buffer, dashboard: &Dashboard, look: Look) {
    let mut panel = Panel::new(area, buffer, look);
    let x = panel.text(0, 0, "Turing Rover", look.title());
    panel.text(
        x + 2,
        0,
        &connection(dashboard),
        connection_style(dashboard, look),
    );
    if let Some(playback) = &dashboard.playback {
        panel.right(0, &format!("  {}", playback_text(playback)), look.title());
    } else if let Some(rover) = &dashboard.rover {
        panel.right(
            0,
            &format!("  {} {}", rover.board, rover.firmware),
            Style::new(),
        );
    }
    supervisor(&mut panel, dashboard);
    session(&mut panel, dashboard);
    message(&mut panel, dashboard);
}

/// The way to the rover as a sentence.
pub fn connection(dashboard: &Dashboard) -> String {
    match &dashboard.connection {
        Connection::None => "not connected".into(),
        Connection::Searching(port) => format!("looking for {port}"),
        Connection::Open(port) => match dashboard.silence() {
            Some(silence) => format!("{port} silent for {:.1} s", silence.as_secs_f64()),
            None => format!("connected to {port}"),
        },
        Connection::Lost(_) => "connection lost, trying again".into(),
        Connection::Log(file) => format!("log {file}"),
    }
}

fn connection_style(dashboard: &Dashboard, look: Look) -> Style {
    match dashboard.connection {
        Connection::Open(_) if dashboard.silence().is_none() => look.good(),
        Connection::Open(_) | Connection::Lost(_) => look.trouble(),
        _ => Style::new(),
    }
}

fn supervisor(panel: &mut Panel<'_>, dashboard: &Dashboard) {
    let look = panel.look;
    let (text, style) = state(dashboard, look);
    let x = panel.text(0, 1, &text, style.add_modifier(Modifier::REVERSED));
    let motors = dashboard.motors_enabled.map_or("", lines::motors);
    // A silent rover may have stopped since.
    let live = matches!(dashboard.connection, Connection::Open(_));
    let silence = dashboard.silence().filter(|_| live);
    let x = match silence {
        Some(_) => panel.text(x + 2, 1, "as last heard", look.trouble()),
        None => panel.text(x + 2, 1, motors, Style::new()),
    };
    let task = dashboard
        .task
        .map(|task| lines::task(task, dashboard.direction));
    let task = task.unwrap_or_default();
    panel.text(x + 2, 1, &task, Style::new());
    if let Some(time) = dashboard.time {
        panel.right(1, &format!("  {}", text::clock(time)), Style::new());
    } else if let Some(trial) = dashboard.trial {
        panel.right(1, &format!("  trial {trial}"), Style::new());
    }
}

/// The supervisor's state, and its style.
pub fn state(dashboard: &Dashboard, look: Look) -> (String, Style) {
    match dashboard.state {
        None if dashboard.trial.is_some() => (" SIMULATION ".into(), Style::new()),
        None => (" STATE UNKNOWN ".into(), Style::new()),
        Some(state) => {
            let style = match state {
                State::Disarmed => Style::new(),
                State::Armed | State::Driving(_) => look.live(),
                State::Faulted(_) => look.trouble(),
            };
            (format!(" {} ", names::loud_state(state)), style)
        }
    }
}

fn playback_text(playback: &Playback) -> String {
    let Playback {
        playing,
        speed,
        at,
        of,
        cut_off,
    } = playback;
    let how = if *playing { "PLAYING" } else { "PAUSED" };
    let cut = if *cut_off { ", cut off" } else { "" };
    format!("{how} x{speed} {at}/{of}{cut}")
}

fn session(panel: &mut Panel<'_>, dashboard: &Dashboard) {
    let quiet = panel.look.quiet();
    let text = match (&dashboard.session, &dashboard.rover) {
        (Some(session), _) => {
            let mode = session
                .mode
                .map_or(String::new(), |m| format!("{}  ", names::mode(m)));
            let (seed, knowledge) = (session.seed, lines::knowledge(Some(session.knowledge)));
            format!("session  {mode}seed {seed}  from {knowledge}")
        }
        (None, Some(rover)) => {
            format!("seed {}  {}", rover.seed, lines::knowledge(rover.knowledge))
        }
        (None, None) => String::new(),
    };
    panel.text(0, 2, &text, quiet);
    if let Some(action) = &dashboard.action {
        panel.right(2, &format!("  action {}", action.step.step), quiet);
    }
}

fn message(panel: &mut Panel<'_>, dashboard: &Dashboard) {
    let look = panel.look;
    if let Some((command, refusal)) = &dashboard.refused {
        panel.text(0, 3, &lines::refused(command, *refusal), look.trouble());
    } else if let Some(note) = dashboard.notes.back() {
        panel.text(0, 3, &note.line.text, look.line(note.line.kind));
    } else if let Knowledge::Unknown(why) = &dashboard.knowledge
        && dashboard.rover.is_some()
    {
        panel.text(0, 3, &format!("knowledge: {why}"), look.quiet());
    }
}
