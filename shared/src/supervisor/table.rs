//! The table of time limits: which signal must keep coming, how long it may be missing, and the
//! response.

use crate::contract::{Fault, Mode, State};
use crate::time::Duration;

/// How often the guard's alarm interrupt polls the supervisor. Every rule acts this much before its
/// time limit, so that the limit holds wherever the poll falls.
pub const GUARD_PERIOD: Duration = Duration::from_millis(10);
/// Period of the hardware watchdog. Together with [`LOOP_SILENCE`] and the guard's period: a silent
/// loop resets the board within a second.
pub const HARDWARE_WATCHDOG: Duration = Duration::from_millis(500);
/// How long a loop may be silent before the watchdog is no longer fed: longer than the 400 ms
/// for which erasing a sector of the flash may stop everything.
pub const LOOP_SILENCE: Duration = Duration::from_millis(480);
/// Consecutive moves without progress that disarm; moves that prove nothing are not counted.
pub const STUCK_AFTER: u8 = 3;

/// The firmware's loops; each reports every turn.
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
    /// Writes the knowledge to the flash.
    Store,
}

/// A signal that must keep coming.
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

/// The states in which a rule applies.
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

/// A rule's response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Counts.
    Warn,
    /// Counts, and keeps the motors off until the signal is back. Also acts at once when the signal
    /// reports that it is bad.
    Stop,
    /// Counts, and disarms with this fault.
    Fault,
    /// Counts, and lets the watchdog reset the board.
    Reset,
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The signal watched.
    pub signal: Signal,
    /// The states in which it is watched.
    pub when: When,
    /// Time limit: the response happens no later than this after the signal last came.
    pub within: Duration,
    /// The response.
    pub response: Response,
    /// The fault counted.
    pub fault: Fault,
}

impl Rule {
    /// How long the signal may be missing before the response is due: a guard period less than the
    /// time limit.
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

/// The table of time limits.
///
/// A sensor's stop ends when the sensor is back; after 2 s without it the rover disarms, so that it
/// cannot start to move unexpectedly.
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
