//! What must keep coming, how long it may be missing, and what happens then.

use crate::contract::{Fault, Mode, State};
use crate::time::Duration;

/// How often the guard's alarm interrupt polls the supervisor. Every rule acts this much before
/// the time it promises, so that the promise holds whenever the poll falls.
pub const GUARD_PERIOD: Duration = Duration::from_millis(10);
/// Period of the hardware watchdog. With [`LOOP_SILENCE`] and the guard's period it makes the
/// second within which a silent loop resets the board.
pub const HARDWARE_WATCHDOG: Duration = Duration::from_millis(500);
/// How long a loop may be silent before the watchdog is no longer fed: longer than the 400 ms
/// for which erasing a sector of the flash may stop everything.
pub const LOOP_SILENCE: Duration = Duration::from_millis(480);
/// Moves without progress in a row that disarm; moves that prove nothing do not break the row.
pub const STUCK_AFTER: u8 = 3;

/// The firmware's loops; each says at every turn that it lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loop {
    /// Samples the sensors.
    Sense,
    /// Runs action cycles and moves.
    Control,
    /// Applies wheel commands.
    Drive,
    /// Talks to the host.
    Link,
    /// Keeps the knowledge in the flash.
    Store,
}

/// What must keep coming.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// A loop's sign of life.
    Alive(Loop),
    /// Range sensors that are all fit for use.
    Ranges,
    /// A compass that is fit for use.
    Compass,
    /// The host's heartbeat.
    Heartbeat,
}

impl Signal {
    /// Number of signals.
    pub(super) const COUNT: usize = 8;

    pub(super) const fn index(self) -> usize {
        match self {
            Self::Alive(of) => of as usize,
            Self::Ranges => 5,
            Self::Compass => 6,
            Self::Heartbeat => 7,
        }
    }
}

/// In which states a rule holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// In all.
    Always,
    /// Armed, driving or not.
    Armed,
    /// Driven by the host.
    HostDriven,
}

impl When {
    pub(super) const fn holds(self, state: State) -> bool {
        match self {
            Self::Always => true,
            Self::Armed => matches!(state, State::Armed | State::Driving(_)),
            Self::HostDriven => matches!(state, State::Driving(Mode::Host)),
        }
    }
}

/// What a rule does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Counts.
    Warn,
    /// Counts, and keeps the motors off until the signal is back. Also acts at once when the
    /// signal itself says that it is bad.
    Stop,
    /// Counts, and disarms with this fault.
    Fault,
    /// Counts, and lets the watchdog reset the board.
    Reset,
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// What must keep coming.
    pub signal: Signal,
    /// In which states.
    pub when: When,
    /// How long after the last time it came the response has happened at the latest.
    pub within: Duration,
    /// What happens.
    pub response: Response,
    /// What is counted.
    pub fault: Fault,
}

impl Rule {
    /// How long the signal may be missing before the response is due: a guard's period before the
    /// time that is promised.
    pub const fn limit(&self) -> Duration {
        self.within.minus(GUARD_PERIOD)
    }
}

const fn row(signal: Signal, when: When, within: u32, response: Response, fault: Fault) -> Rule {
    Rule {
        signal,
        when,
        within: Duration::from_millis(within),
        response,
        fault,
    }
}

/// The table of what is watched by time.
///
/// The stops for sensors are lifted when the sensor is back; if it is away for 2 s, the rover
/// disarms, so that it does not start to move by itself long after anybody expects it to.
#[rustfmt::skip]
pub const RULES: [Rule; 12] = {
    use Loop::{Control, Drive, Link, Sense, Store};
    use Signal::{Alive, Compass, Heartbeat, Ranges};
    use When::{Always, Armed, HostDriven};
    let silence = LOOP_SILENCE.0 as u32 / 1_000;
    [
        //  signal         when        within (ms)  response         fault
        row(Alive(Control), Armed,      200,     Response::Fault, Fault::ControlSilent),
        row(Ranges,         Armed,      200,     Response::Stop,  Fault::RangeSensor),
        row(Ranges,         Armed,      2_000,   Response::Fault, Fault::RangeSensor),
        row(Compass,        Armed,      100,     Response::Stop,  Fault::Compass),
        row(Compass,        Armed,      2_000,   Response::Fault, Fault::Compass),
        row(Heartbeat,      HostDriven, 500,     Response::Warn,  Fault::HostLate),
        row(Heartbeat,      HostDriven, 2_000,   Response::Fault, Fault::HostLost),
        row(Alive(Sense),   Always,     silence, Response::Reset, Fault::TaskSilent),
        row(Alive(Control), Always,     silence, Response::Reset, Fault::TaskSilent),
        row(Alive(Drive),   Always,     silence, Response::Reset, Fault::TaskSilent),
        row(Alive(Link),    Always,     silence, Response::Reset, Fault::TaskSilent),
        row(Alive(Store),   Always,     silence, Response::Reset, Fault::TaskSilent),
    ]
};
