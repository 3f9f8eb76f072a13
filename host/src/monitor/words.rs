//! The contract's values as words, in ASCII: short ones for panels, sentences for refusals.

use rover_shared::sensing::Stimulus;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{
    ChannelHealth, Command, CompassHealth, Fault, Mode, Outcome, Refusal, ResetReason, State, Task,
};

/// The range sensors' channels, in the wire's order.
pub const CHANNELS: [&str; 4] = ["front left", "front right", "left", "right"];

/// What the supervisor allows, in one or two words; the first is in capitals.
pub fn state(state: State) -> String {
    match state {
        State::Disarmed => "DISARMED".into(),
        State::Armed => "ARMED".into(),
        State::Driving(by) => format!("DRIVING ({})", mode(by)),
        State::Faulted(of) => format!("FAULTED ({})", fault(of)),
    }
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

/// How a move ended.
pub fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Obstacle => "obstacle",
        Outcome::NoProgress => "no progress",
        Outcome::TurnTimeout => "turn timeout",
        Outcome::CompassLost => "compass lost",
        Outcome::Late => "late",
        Outcome::Stopped => "stopped",
    }
}

/// Why the rover started.
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
        Command::SetDirection(to) => format!("direction {}", compass(*to)),
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

/// Why a command was refused, and what to do about it.
pub fn refusal(refusal: Refusal) -> String {
    match refusal {
        Refusal::NoHello => "no hello was exchanged; connect again".into(),
        Refusal::SchemaMismatch => "rover and program differ; build both anew".into(),
        Refusal::NotArmed => "the rover is disarmed; arm it first".into(),
        Refusal::Armed => "the rover is armed or drives; disarm it first".into(),
        Refusal::Fault(of) => format!("a fault stands ({}); disarm first", fault(of)),
        Refusal::KnowledgeInvalid => "no valid knowledge; send some or begin anew".into(),
        Refusal::RangeSensor { channel, health } => {
            let name = CHANNELS.get(usize::from(channel)).unwrap_or(&"unknown");
            format!(
                "the {name} range sensor is {}; check its cable",
                channel_health(health)
            )
        }
        Refusal::Compass(health) => {
            format!("the compass is {}; check its cable", compass_health(health))
        }
        Refusal::ControlSilent => "its control loop does not run; reset the board".into(),
        Refusal::FlashBusy => "the flash is being written; try again".into(),
        Refusal::NoHeartbeat => "host-driven mode needs heartbeats".into(),
        Refusal::NotHostDriven => "this needs host-driven mode".into(),
        Refusal::MoveUnderWay => "a move is under way; wait for its end".into(),
        Refusal::OutOfRange => "a value lies outside its range".into(),
        Refusal::BadCalibration => "the calibration is not a falling curve".into(),
        Refusal::ChunkOutOfOrder => "the transfer has a gap; start it again".into(),
        Refusal::TooLong => "the knowledge is too long for the board".into(),
        Refusal::BadChecksum => "the knowledge was damaged on the way; send it again".into(),
        Refusal::BadKnowledge => "the knowledge is of another version or make".into(),
        Refusal::Unsupported => "this rover cannot do that".into(),
    }
}

/// Text that a terminal takes for text, whatever was in it: control characters are shown as `?`.
pub fn printable(text: &str, ascii: bool) -> String {
    let strange = |c: char| c.is_control() || (ascii && !c.is_ascii());
    text.chars()
        .map(|c| if strange(c) { '?' } else { c })
        .collect()
}

/// A turn, with its side.
pub fn turn(turn: Microdegrees) -> String {
    // Whole tenths, so that no turn of 0.0 has a side.
    let tenths = (f64::from(turn.0) / 1e5).round();
    let side = match tenths {
        ..0.0 => " right",
        0.0 => "",
        _ => " left",
    };
    format!("{:.1} deg{side}", (tenths / 10.0).abs())
}

/// A direction as a compass shows it: clockwise, 0 to 359.9 degrees.
pub fn compass(direction: Microdegrees) -> String {
    // Whole tenths, so that nothing is rounded up to 360.0.
    let tenths = (-i64::from(direction.0) + 50_000).div_euclid(100_000);
    let tenths = tenths.rem_euclid(3_600);
    format!("{}.{} deg", tenths / 10, tenths % 10)
}

/// A distance in centimetres.
pub fn centimetres(distance: Micrometres) -> String {
    format!("{:.1}", f64::from(distance.0) / 1e4)
}

/// A time since the board's reset: minutes and seconds, or hours before them.
pub fn clock(microseconds: u64) -> String {
    let tenths = microseconds / 100_000;
    let (minutes, tenths) = (tenths / 600, tenths % 600);
    let seconds = format!("{:02}.{}", tenths / 10, tenths % 10);
    match minutes / 60 {
        0 => format!("{minutes}:{seconds}"),
        hours => format!("{hours}:{:02}:{seconds}", minutes % 60),
    }
}

/// A count in at most `width` characters: thousands and millions are shortened, never cut.
pub fn count(count: u32, width: usize) -> String {
    let shortened = [
        (1u32, ""),
        (1_000, "k"),
        (1_000_000, "M"),
        (1_000_000_000, "G"),
    ];
    let texts = shortened.map(|(unit, letter)| format!("{}{letter}", count / unit));
    let fitting = texts.iter().find(|text| text.len() <= width);
    fitting.unwrap_or(&texts[3]).clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_a_compasss() {
        let of = |degrees: f64| compass(Microdegrees((degrees * 1e6) as i32));
        assert_eq!(
            [
                of(0.0),
                of(15.0),
                of(-15.0),
                of(180.0),
                of(0.01),
                of(-359.96)
            ],
            [
                "0.0 deg",
                "345.0 deg",
                "15.0 deg",
                "180.0 deg",
                "0.0 deg",
                "0.0 deg"
            ]
        );
        compass(Microdegrees(i32::MIN));
    }

    #[test]
    fn turns_name_their_side() {
        assert_eq!(turn(Microdegrees(9_230_000)), "9.2 deg left");
        assert_eq!(turn(Microdegrees(-8_100_000)), "8.1 deg right");
        assert_eq!(turn(Microdegrees(-49_999)), "0.0 deg");
        turn(Microdegrees(i32::MIN));
    }

    #[test]
    fn counts_are_shortened_and_never_cut() {
        assert_eq!(count(999, 3), "999");
        assert_eq!(count(12_345, 4), "12k");
        assert_eq!(count(u32::MAX, 3), "4G");
        assert_eq!(count(u32::MAX, 10), "4294967295");
    }

    #[test]
    fn words_fit_their_columns() {
        for of in Fault::ALL {
            assert!(fault(of).len() <= 14, "{}", fault(of));
        }
    }

    #[test]
    fn refusals_of_keys_fit_a_line() {
        let commands = [
            Command::Arm,
            Command::SetMode(Mode::Learn),
            Command::SetTask(Task::FollowChangingDirection),
            Command::SetDirection(Microdegrees(0)),
            Command::StoreKnowledge,
        ];
        let of_channel = |(channel, health)| Refusal::RangeSensor { channel, health };
        let refusals = [
            Refusal::NoHello,
            Refusal::SchemaMismatch,
            Refusal::NotArmed,
            Refusal::Armed,
            Refusal::Fault(Fault::ControlSilent),
            Refusal::KnowledgeInvalid,
            Refusal::ControlSilent,
            Refusal::FlashBusy,
            Refusal::OutOfRange,
            Refusal::Unsupported,
        ];
        let fits = |asked: &Command, why| {
            let text = format!("refused: {}: {}", command(asked), refusal(why));
            assert!(text.len() <= 80 && text.is_ascii(), "{text}");
        };
        for why in refusals {
            commands.iter().for_each(|asked| fits(asked, why));
        }
        // Only arming looks at the sensors.
        for why in [
            of_channel((1, ChannelHealth::Shorted)),
            of_channel((9, ChannelHealth::Unknown)),
            Refusal::Compass(CompassHealth::Implausible),
        ] {
            fits(&Command::Arm, why);
        }
    }

    #[test]
    fn nothing_that_was_said_steers_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}\n", false), "a?[2Jb??");
        assert_eq!(printable("caf\u{e9}", true), "caf?");
    }

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(clock(754_500_000), "12:34.5");
        assert_eq!(clock(3_600_000_000), "1:00:00.0");
        clock(u64::MAX);
    }
}
