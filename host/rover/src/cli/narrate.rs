//! What a rover says, as lines for people.

use rover_shared::contract::Fault;
use rover_shared::wire::message::{Event, EventKind, Hello, Report};

use rover_link::{names, text};

/// A report worth a line; `None` for those that come all the time.
pub fn line(report: &Report) -> Option<String> {
    Some(match report {
        Report::Hello(hello) => self::hello(hello),
        Report::Event(Event { kind, .. }) => event(kind)?,
        // Learning is to run into things; the outcome of each action tells.
        Report::Fault(fault) if fault.fault == Fault::Blocked => return None,
        Report::Fault(fault) => format!(
            "fault: {} (number {} since the reset)",
            names::fault(fault.fault),
            fault.count
        ),
        Report::LastWords(text) => format!("before the last reset: {text}"),
        Report::Ack(_) | Report::Status(_) | Report::Action(_) | Report::Knowledge(_) => {
            return None;
        }
    })
}

fn event(kind: &EventKind) -> Option<String> {
    Some(match kind {
        EventKind::State(state) => names::state(*state),
        EventKind::MoveEnded(how) => format!("the move ended: {}", names::outcome(*how)),
        EventKind::Direction(direction) => {
            format!("direction {}", text::compass(*direction))
        }
        EventKind::KnowledgeStored { fingerprint } => {
            format!("knowledge {fingerprint:08x} is in the flash")
        }
        EventKind::Range { channel, health } => format!(
            "{} range sensor: {}",
            names::channel(*channel),
            names::channel_health(*health)
        ),
        EventKind::Compass(health) => format!("compass: {}", names::compass_health(*health)),
        EventKind::Session {
            mode,
            seed,
            knowledge,
        } => format!(
            "a session begins: {}, seed {seed}, from knowledge {knowledge:08x}",
            names::mode(*mode)
        ),
    })
}

/// Who a rover is.
pub fn hello(hello: &Hello) -> String {
    let knowledge = match hello.knowledge {
        Some(print) => format!("knowledge {print:08x}"),
        None => "no valid knowledge".into(),
    };
    format!(
        "{}, firmware {}, {}, {knowledge}",
        hello.board,
        hello.firmware,
        names::reset(hello.reset)
    )
}
