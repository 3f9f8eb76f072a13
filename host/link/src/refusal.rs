//! Why a rover refused, as a sentence with the next step.

use rover_shared::contract::{ChannelHealth, CompassHealth, Refusal};
use std::borrow::Cow;

use crate::names;

/// What a refusal means, and what to do about it at the command line.
pub fn explain(refusal: Refusal) -> String {
    let (reason, command, _) = explanation(refusal);
    joined(reason, ": ", command)
}

/// The same for the dashboard's keys: short enough for a line of 80 columns behind the name of what
/// a key asks for.
pub fn explain_by_keys(refusal: Refusal) -> String {
    let (reason, _, keys) = explanation(refusal);
    joined(reason, "; ", keys)
}

fn joined(reason: Cow<'static, str>, by: &str, next: &str) -> String {
    match next {
        "" => reason.into(),
        _ => reason.into_owned() + by + next,
    }
}

/// The reason, and the next step, if there is one: at the command line, and by keys, in few words
/// and without the names of commands.
fn explanation(refusal: Refusal) -> (Cow<'static, str>, &'static str, &'static str) {
    let same = |reason, next| (reason, next, next);
    let (reason, command, keys) = match refusal {
        Refusal::NoHello => ("no hello was exchanged", "try again", "connect again"),
        Refusal::SchemaMismatch => (
            "rover and program differ",
            "build firmware and host program from the same revision",
            "build both anew",
        ),
        Refusal::NotArmed => (
            "the rover is disarmed",
            "give --arm, or `rover arm` first",
            "arm it first",
        ),
        Refusal::Armed => (
            "the rover is armed or drives",
            "`rover disarm` first",
            "disarm it first",
        ),
        Refusal::Fault(fault) => {
            let reason = format!("a fault stands ({})", names::fault(fault));
            return (
                reason.into(),
                "`rover disarm` acknowledges it",
                "disarm first",
            );
        }
        Refusal::KnowledgeInvalid => (
            "no valid knowledge",
            "`rover knowledge new` begins with none, `rover knowledge push FILE` gives it some",
            "send some or begin anew",
        ),
        Refusal::RangeSensor { channel, health } => {
            let (command, keys) = range(health);
            let (name, health) = (names::channel(channel), names::channel_health(health));
            let reason = format!("the {name} range sensor is {health}");
            return (reason.into(), command, keys);
        }
        Refusal::Compass(health) => {
            let (command, keys) = compass(health);
            let reason = format!("the compass is {}", names::compass_health(health));
            return (reason.into(), command, keys);
        }
        Refusal::ControlSilent => same("its control loop does not run", "reset the board"),
        Refusal::FlashBusy => (
            "the flash is being written",
            "try again in a second",
            "try again",
        ),
        Refusal::NoHeartbeat => same("it hears no heartbeats from this host", "try again"),
        Refusal::NotHostDriven => same("the host does not drive it", "`rover drive` does"),
        Refusal::MoveUnderWay => same("a move is under way", "wait until it has ended"),
        Refusal::OutOfRange => ("a value is out of range", "see the command's --help", ""),
        Refusal::BadCalibration => same(
            "the points are no falling curve",
            "give 2 to 12 of them, counts rising and distances falling",
        ),
        Refusal::ChunkOutOfOrder => same("a part of the transfer was lost", "try again"),
        Refusal::TooLong => same("the knowledge is too long for the board", ""),
        Refusal::BadChecksum => same("the knowledge was damaged on the way", "try again"),
        Refusal::BadKnowledge => same(
            "the knowledge is of another version, or was learned with other parameters",
            "learn it with `rover learn --task direction`",
        ),
        Refusal::Unsupported => same("this rover cannot do that", "it senses no target"),
    };
    (reason.into(), command, keys)
}

/// The next step, at the command line and by keys.
fn range(health: ChannelHealth) -> (&'static str, &'static str) {
    match health {
        ChannelHealth::Unknown => ("try again in a second", "try again"),
        ChannelHealth::Open | ChannelHealth::NotFitted => ("check its cable", "check its cable"),
        ChannelHealth::Shorted => (
            "check its wiring for a short to the supply",
            "check its wiring",
        ),
        ChannelHealth::Frozen => (
            "check its supply and that nothing covers it",
            "check its supply",
        ),
        ChannelHealth::Good | ChannelHealth::Silent => ("reset the board", "reset the board"),
    }
}

/// The same for the compass.
fn compass(health: CompassHealth) -> (&'static str, &'static str) {
    match health {
        CompassHealth::Unknown | CompassHealth::Good => ("try again in a second", "try again"),
        CompassHealth::Silent => (
            "check its cable, level shifter and address (0x60)",
            "check its cable",
        ),
        CompassHealth::Implausible => (
            "check that no magnet, motor or iron is near it",
            "check for magnets and iron nearby",
        ),
    }
}

#[cfg(test)]
mod tests {
    use rover_shared::contract::{Fault, Mode, Task};
    use rover_shared::units::Microdegrees;
    use rover_shared::wire::message::Command;

    use super::*;

    #[test]
    fn every_refusal_names_a_next_step() {
        let health = ChannelHealth::Open;
        let open = Refusal::RangeSensor { channel: 1, health };
        for refusal in [
            Refusal::NoHello,
            Refusal::SchemaMismatch,
            Refusal::NotArmed,
            Refusal::Armed,
            Refusal::Fault(Fault::HostLost),
            Refusal::KnowledgeInvalid,
            open,
            Refusal::Compass(CompassHealth::Silent),
            Refusal::ControlSilent,
            Refusal::FlashBusy,
            Refusal::NoHeartbeat,
            Refusal::NotHostDriven,
            Refusal::MoveUnderWay,
            Refusal::OutOfRange,
            Refusal::BadCalibration,
            Refusal::ChunkOutOfOrder,
            Refusal::BadChecksum,
            Refusal::BadKnowledge,
        ] {
            let text = explain(refusal);
            assert!(text.contains(": ") && !text.ends_with('.'), "{text}");
        }
        assert!(explain(Refusal::Fault(Fault::HostLost)).contains("host lost"));
        assert_eq!(
            explain(open),
            "the front right range sensor is open: check its cable"
        );
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
        ];
        let fits = |asked: &Command, why| {
            let (name, text) = (names::command(asked), explain_by_keys(why));
            let text = format!("refused: {name}: {text}");
            assert!(text.len() <= 80 && text.is_ascii(), "{text}");
        };
        for why in refusals {
            commands.iter().for_each(|asked| fits(asked, why));
        }
        // No rover knows how to aim, and only arming looks at the sensors.
        fits(&Command::SetTask(Task::AimAtTarget), Refusal::Unsupported);
        for why in [
            of_channel((1, ChannelHealth::Unknown)),
            of_channel((1, ChannelHealth::Shorted)),
            of_channel((1, ChannelHealth::Frozen)),
            of_channel((1, ChannelHealth::Silent)),
            of_channel((9, ChannelHealth::Unknown)),
            Refusal::Compass(CompassHealth::Unknown),
            Refusal::Compass(CompassHealth::Implausible),
        ] {
            fits(&Command::Arm, why);
        }
    }
}
