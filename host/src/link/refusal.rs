//! Why a rover refused, as a sentence with the next step.

use rover_shared::wire::message::{ChannelHealth, CompassHealth, Fault, Refusal};

/// What a refusal means, and what to do about it.
pub fn explain(refusal: Refusal) -> String {
    let text = match refusal {
        Refusal::NoHello => "it has not been introduced: try again",
        Refusal::SchemaMismatch => {
            "it was built from another revision: build firmware and host program from the same one"
        }
        Refusal::NotArmed => "it is not armed: `rover arm` arms it",
        Refusal::Armed => "it is armed: `rover disarm` first",
        Refusal::Fault(fault) => {
            return format!(
                "a fault stands ({}): `rover disarm` acknowledges it",
                fault_name(fault)
            );
        }
        Refusal::KnowledgeInvalid => {
            "it has no valid knowledge: `rover knowledge new` begins with none, `rover knowledge \
             push FILE` gives it some"
        }
        Refusal::RangeSensor { channel, health } => return range(channel, health),
        Refusal::Compass(health) => return compass(health),
        Refusal::ControlSilent => "its control loop does not run: reset the board",
        Refusal::FlashBusy => "its flash is being written: try again in a second",
        Refusal::NoHeartbeat => "it hears no heartbeats from this host: try again",
        Refusal::NotHostDriven => "the host does not drive it: `rover drive` does",
        Refusal::MoveUnderWay => "a move is under way: wait until it has ended",
        Refusal::OutOfRange => "a value is out of range: see the command's --help",
        Refusal::BadCalibration => {
            "the points are no falling curve: give 2 to 12 of them, counts rising and distances \
             falling"
        }
        Refusal::ChunkOutOfOrder => "a part of the transfer was lost: try again",
        Refusal::TooLong => "the knowledge is longer than it has room for",
        Refusal::BadChecksum => "the knowledge was damaged on the way: try again",
        Refusal::BadKnowledge => {
            "the knowledge is of another version, or was learned with other parameters: learn it \
             with `rover learn --task direction`"
        }
        Refusal::Unsupported => "this rover cannot do that: it senses no target",
    };
    text.into()
}

/// The name of a range sensor's channel.
pub fn channel_name(channel: u8) -> &'static str {
    match channel {
        0 => "front left",
        1 => "front right",
        2 => "left",
        3 => "right",
        _ => "unknown",
    }
}

/// What the health of a range sensor means.
pub fn channel_health(health: ChannelHealth) -> &'static str {
    match health {
        ChannelHealth::Unknown => "has not been sampled yet",
        ChannelHealth::Good => "is well",
        ChannelHealth::Open => "is open",
        ChannelHealth::Shorted => "is shorted",
        ChannelHealth::Frozen => "is frozen",
        ChannelHealth::Silent => "is silent",
        ChannelHealth::NotFitted => "is not fitted",
    }
}

/// What the health of the compass means.
pub fn compass_health(health: CompassHealth) -> &'static str {
    match health {
        CompassHealth::Unknown => "has not been read yet",
        CompassHealth::Good => "is well",
        CompassHealth::Silent => "does not answer",
        CompassHealth::Implausible => "gives headings that cannot be true",
    }
}

/// A fault's name as words.
pub fn fault_name(fault: Fault) -> String {
    let mut words = String::new();
    for character in format!("{fault:?}").chars() {
        if character.is_ascii_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.push(character.to_ascii_lowercase());
    }
    words
}

fn range(channel: u8, health: ChannelHealth) -> String {
    let next = match health {
        ChannelHealth::Unknown => "try again in a second",
        ChannelHealth::Open | ChannelHealth::NotFitted => "check its cable",
        ChannelHealth::Shorted => "check its wiring for a short to the supply",
        ChannelHealth::Frozen => "check its supply and that nothing covers it",
        ChannelHealth::Good | ChannelHealth::Silent => "reset the board",
    };
    let (name, health) = (channel_name(channel), channel_health(health));
    format!("the {name} range sensor {health}: {next}")
}

fn compass(health: CompassHealth) -> String {
    let next = match health {
        CompassHealth::Unknown | CompassHealth::Good => "try again in a second",
        CompassHealth::Silent => "check its cable, level shifter and address (0x60)",
        CompassHealth::Implausible => "check that no magnet, motor or iron is near it",
    };
    format!("the compass {}: {next}", compass_health(health))
}

#[cfg(test)]
mod tests {
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
}
