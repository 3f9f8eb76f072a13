//! What a rover says, as lines for people.

use rover_shared::wire::message::{
    Event, EventKind, Fault, Hello, Mode, Outcome, Report, ResetReason, State, Task,
};

use super::values::as_compass;
use crate::link::{channel_health, channel_name, compass_health, fault_name};

/// A report worth a line; `None` for those that come all the time.
pub fn line(report: &Report) -> Option<String> {
    Some(match report {
        Report::Hello(hello) => self::hello(hello),
        Report::Event(Event { kind, .. }) => event(kind)?,
        // Learning is to run into things; the outcome of each action tells.
        Report::Fault(fault) if fault.fault == Fault::Blocked => return None,
        Report::Fault(fault) => format!(
            "fault: {} (number {} since the reset)",
            fault_name(fault.fault),
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
        EventKind::State(state) => self::state(*state),
        EventKind::MoveEnded(how) => format!("the move ended: {}", outcome(*how)),
        EventKind::Direction(direction) => {
            format!("follows {:.1} degrees", as_compass(*direction))
        }
        EventKind::KnowledgeStored { fingerprint } => {
            format!("knowledge {fingerprint:08x} is in the flash")
        }
        EventKind::Range { channel, health } => format!(
            "range sensor {} {}",
            channel_name(*channel),
            channel_health(*health)
        ),
        EventKind::Compass(health) => format!("compass {}", compass_health(*health)),
        EventKind::Session {
            mode,
            seed,
            knowledge,
        } => format!(
            "a session begins: {}, seed {seed}, from knowledge {knowledge:08x}",
            self::mode(*mode)
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
        "{}, firmware {}, started by {}, {knowledge}",
        hello.board,
        hello.firmware,
        reset(hello.reset)
    )
}

/// Why it started, after "started by".
pub fn reset(reason: ResetReason) -> &'static str {
    match reason {
        ResetReason::PowerOn => "power-on",
        ResetReason::RunPin => "the RUN pin",
        ResetReason::Watchdog => "the watchdog",
        ResetReason::Panic => "a panic",
        ResetReason::HardFault => "a hard fault",
        ResetReason::Requested => "request",
    }
}

/// What the supervisor allows.
pub fn state(state: State) -> String {
    match state {
        State::Disarmed => "disarmed".into(),
        State::Armed => "armed".into(),
        State::Driving(mode) => format!("driving: {}", self::mode(mode)),
        State::Faulted(fault) => format!("stopped by a fault: {}", fault_name(fault)),
    }
}

/// Who drives.
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Idle => "idle",
        Mode::Learn => "learn",
        Mode::Run => "run",
        Mode::Host => "host",
    }
}

/// What is to be done.
pub fn task(task: Task) -> &'static str {
    match task {
        Task::FollowDirection => "follow a direction",
        Task::FollowChangingDirection => "follow a direction that changes at random",
        Task::AimAtTarget => "aim at a target",
    }
}

/// How a move ended.
pub fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Obstacle => "stopped before an obstacle",
        Outcome::NoProgress => "no progress",
        Outcome::TurnTimeout => "the turn took too long",
        Outcome::CompassLost => "the compass was lost",
        Outcome::Late => "the control loop was late",
        Outcome::Stopped => "stopped from outside",
    }
}
