//! What a rover says, as lines for people: worded once for the commands and the dashboard.

use rover_shared::contract::{
    ChannelHealth, CompassHealth, Counters, Fault, FaultReport, Refusal, State, Task,
};
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{Command, EventKind, Hello, Report};

use rover_link::{explain_by_keys, names, text};

/// A line for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// What it is about.
    pub kind: Kind,
    /// A sentence without a full stop.
    pub text: String,
}

/// What a line is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something went as it should.
    Fact,
    /// Something is wrong or was refused.
    Trouble,
}

impl Line {
    fn new(good: bool, text: String) -> Option<Self> {
        let kind = if good { Kind::Fact } else { Kind::Trouble };
        Some(Self { kind, text })
    }
}

/// The line for a report; `None` for those that come all the time.
pub fn line(report: &Report) -> Option<Line> {
    match report {
        Report::Hello(hello) => Line::new(true, self::hello(hello)),
        Report::Event(event) => of_event(event.kind),
        Report::Fault(fault) => Line::new(
            false,
            format!("{} {} so far", fault_begin(fault), fault.count),
        ),
        Report::LastWords(text) => Line::new(false, format!("before its last reset: {text}")),
        Report::Ack(_) | Report::Status(_) | Report::Action(_) | Report::Knowledge(_) => None,
    }
}

/// How the line of a fault begins, however often it was counted.
pub fn fault_begin(fault: &FaultReport) -> String {
    format!("fault: {},", names::fault(fault.fault))
}

fn of_event(kind: EventKind) -> Option<Line> {
    match kind {
        EventKind::State(state) => {
            let good = !matches!(state, State::Faulted(_));
            Line::new(good, names::loud_state(state))
        }
        EventKind::MoveEnded(outcome) => {
            let how = names::outcome(outcome);
            Line::new(true, format!("the host's move ended: {how}"))
        }
        EventKind::Direction(to) => Line::new(true, format!("direction {}", text::compass(to))),
        EventKind::KnowledgeStored { fingerprint } => Line::new(
            true,
            format!("{} is in the flash", knowledge(Some(fingerprint))),
        ),
        EventKind::Range { channel, health } => {
            let good = matches!(health, ChannelHealth::Good | ChannelHealth::NotFitted);
            let (name, health) = (names::channel(channel), names::channel_health(health));
            Line::new(good, format!("{name} range sensor: {health}"))
        }
        EventKind::Compass(health) => {
            let good = health == CompassHealth::Good;
            Line::new(good, format!("compass: {}", names::compass_health(health)))
        }
        EventKind::Session {
            mode,
            seed,
            knowledge,
        } => {
            let (mode, knowledge) = (names::mode(mode), self::knowledge(Some(knowledge)));
            let text = format!("a session begins: {mode}, seed {seed}, from {knowledge}");
            Line::new(true, text)
        }
    }
}

/// Who a rover is, and why it started.
pub fn hello(hello: &Hello) -> String {
    let (reset, knowledge) = (names::reset(hello.reset), knowledge(hello.knowledge));
    format!(
        "{}, firmware {}, {reset}, {knowledge}",
        hello.board, hello.firmware
    )
}

/// Which knowledge, by its fingerprint.
pub fn knowledge(fingerprint: Option<u32>) -> String {
    match fingerprint {
        Some(fingerprint) => format!("knowledge {fingerprint:08x}"),
        None => "no valid knowledge".into(),
    }
}

/// Whether wheel commands reach the motors.
pub fn motors(enabled: bool) -> &'static str {
    if enabled { "motors on" } else { "motors off" }
}

/// The faults that were counted, and how often.
pub fn counted(counters: &Counters) -> impl Iterator<Item = (Fault, u32)> {
    let counts = Fault::ALL.map(|fault| (fault, counters.of(fault)));
    counts.into_iter().filter(|(_, count)| *count > 0)
}

/// What is being done, and in which direction if there is one.
pub fn task(task: Task, direction: Option<Microdegrees>) -> String {
    let direction = direction.map(text::compass);
    names::task(task).to_owned() + &direction.map_or(String::new(), |d| format!(", {d}"))
}

/// Why a command was refused, with the key to press next.
pub fn refused(command: &Command, refusal: Refusal) -> String {
    let (command, why) = (names::command(command), explain_by_keys(refusal));
    format!("refused: {command}: {why}")
}
