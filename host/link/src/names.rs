//! The contract's values as words, for the command line and the dashboard alike: in ASCII, and
//! short enough for the dashboard's panels. Sentences are put together from them where they are
//! said.

use rover_shared::contract::{
    ChannelHealth, CompassHealth, Fault, Mode, Outcome, ResetReason, State, Task,
};
use rover_shared::sensing::Stimulus;
use rover_shared::wire::message::Command;

use crate::text;

/// The range sensors' channels, in the wire's order.
pub const CHANNELS: [&str; 4] = ["front left", "front right", "left", "right"];

/// What the supervisor allows.
pub fn state(state: State) -> String {
    match state {
        State::Disarmed => "disarmed".into(),
        State::Armed => "armed".into(),
        State::Driving(by) => format!("driving ({})", mode(by)),
        State::Faulted(of) => format!("faulted ({})", fault(of)),
    }
}

/// The same with its first word in capitals, to be seen from afar.
pub fn loud_state(of: State) -> String {
    let text = state(of);
    let (first, rest) = text.split_at(text.find(' ').unwrap_or(text.len()));
    first.to_ascii_uppercase() + rest
}

/// Who moves the rover.
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
        Task::FollowDirection => "follow a fixed direction",
        Task::FollowChangingDirection => "wander",
        Task::AimAtTarget => "aim at a target",
    }
}

/// A fault, in at most 14 characters.
pub fn fault(fault: Fault) -> &'static str {
    match fault {
        Fault::ControlSilent => "control silent",
        Fault::TaskSilent => "task silent",
        Fault::Blocked => "blocked",
        Fault::RangeSensor => "range sensor",
        Fault::Compass => "compass",
        Fault::NoProgress => "no progress",
        Fault::Stuck => "stuck",
        Fault::HostLate => "host late",
        Fault::HostLost => "host lost",
        Fault::ArmRefused => "arm refused",
        Fault::FlashWhileArmed => "flash refused",
        Fault::BadFrame => "bad frame",
        Fault::Unsettled => "unsettled",
        Fault::QueueFull => "queue full",
        Fault::TurnTimeout => "turn timeout",
        Fault::LateStep => "late step",
        Fault::BusRecovered => "bus freed",
        Fault::AdcError => "ADC error",
        Fault::ClockStepped => "clock stepped",
        Fault::FlashFailed => "flash failed",
    }
}

/// The name of a range sensor's channel.
pub fn channel(channel: u8) -> &'static str {
    CHANNELS.get(usize::from(channel)).unwrap_or(&"unknown")
}

/// A range sensor's health, in at most 7 characters.
pub fn channel_health(health: ChannelHealth) -> &'static str {
    match health {
        ChannelHealth::Unknown => "unknown",
        ChannelHealth::Good => "good",
        ChannelHealth::Open => "open",
        ChannelHealth::Shorted => "shorted",
        ChannelHealth::Frozen => "frozen",
        ChannelHealth::Silent => "silent",
        ChannelHealth::NotFitted => "absent",
    }
}

/// The compass's health, in at most 7 characters.
pub fn compass_health(health: CompassHealth) -> &'static str {
    match health {
        CompassHealth::Unknown => "unknown",
        CompassHealth::Good => "good",
        CompassHealth::Silent => "silent",
        CompassHealth::Implausible => "absurd",
    }
}

/// How a move ended, in at most 14 characters.
pub fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Obstacle => "obstacle",
        Outcome::NoProgress => "no progress",
        Outcome::TurnTimeout => "turn timeout",
        Outcome::CompassLost => "compass lost",
        Outcome::Late => "control late",
        Outcome::Stopped => "stopped",
    }
}

/// Why the rover started, as a clause.
pub fn reset(reason: ResetReason) -> &'static str {
    match reason {
        ResetReason::PowerOn => "power came on",
        ResetReason::RunPin => "its reset button was pressed",
        ResetReason::Watchdog => "the watchdog reset it",
        ResetReason::Panic => "its program panicked",
        ResetReason::HardFault => "its processor took a hard fault",
        ResetReason::Requested => "a restart was asked for",
    }
}

/// A stimulus.
pub fn stimulus(stimulus: Stimulus) -> &'static str {
    match stimulus {
        Stimulus::Front => "front",
        Stimulus::Left => "left",
        Stimulus::Right => "right",
        Stimulus::Target => "target",
    }
}

/// What a command asks for.
pub fn command(command: &Command) -> String {
    match command {
        Command::Hello { .. } => "hello".into(),
        Command::Ping => "ping".into(),
        Command::Heartbeat => "heartbeat".into(),
        Command::Arm => "arm".into(),
        Command::Disarm => "disarm".into(),
        Command::SetMode(to) => format!("mode {}", mode(*to)),
        Command::SetTask(Task::FollowDirection) => "task fixed".into(),
        Command::SetTask(Task::FollowChangingDirection) => "task wander".into(),
        Command::SetTask(Task::AimAtTarget) => "task target".into(),
        Command::SetDirection(to) => format!("direction {}", text::compass(*to)),
        Command::Drive { .. } => "drive".into(),
        Command::SetSeed(seed) => format!("seed {seed}"),
        Command::Calibrate(_) => "calibration".into(),
        Command::ReadStatus => "status".into(),
        Command::PullKnowledge { .. } => "reading the knowledge".into(),
        Command::PushKnowledge(_) => "sending knowledge".into(),
        Command::StoreKnowledge => "storing the knowledge".into(),
        Command::NewKnowledge => "new knowledge".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_fit_their_columns() {
        for of in Fault::ALL {
            assert!(fault(of).len() <= 14, "{}", fault(of));
        }
        assert_eq!([3, 4].map(channel), ["right", "unknown"]);
    }

    #[test]
    fn states_can_be_loud() {
        let lost = State::Faulted(Fault::HostLost);
        assert_eq!(loud_state(State::Armed), "ARMED");
        assert_eq!(state(lost), "faulted (host lost)");
        assert_eq!(loud_state(lost), "FAULTED (host lost)");
    }
}
