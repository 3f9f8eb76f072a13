//! What the board is doing, in words, to explain why nothing happens.

use emulated_rp2040::cpu::{Activity, FaultReport};
use emulated_rp2040::incident::{Incident, Kind};
use emulated_rp2040::machine::Machine;
use emulated_rp2040::peripheral::CYCLES_PER_MICROSECOND;

use crate::vehicle::Fault;

/// Where the core is, what went wrong last, and which faults hold.
pub fn whereabouts(machine: &Machine, faults: &[Fault]) -> String {
    let mut text = if machine.powered() {
        of_core(machine)
    } else {
        "it is without power".into()
    };
    if !faults.is_empty() {
        let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
        text += &format!("; faults at work: {}", faults.join(", "));
    }
    text
}

fn of_core(machine: &Machine) -> String {
    let core = machine.core();
    let last = machine.incidents().first().last();
    let before = last.map_or(
        "nothing went wrong before".into(),
        |Incident { at, kind }| {
            let seconds = (at / CYCLES_PER_MICROSECOND) as f64 / 1e6;
            format!("before, at {seconds:.3} s: {}", incident(*kind))
        },
    );
    format!(
        "its core is at {:#010x}, {}; {before}",
        core.pc(),
        activity(core.activity())
    )
}

fn activity(activity: Activity) -> &'static str {
    match activity {
        Activity::Running => "running",
        Activity::WaitingForEvent => "asleep until an event",
        Activity::WaitingForInterrupt => "asleep until an interrupt",
        Activity::Lockup => "locked up",
    }
}

fn incident(kind: Kind) -> String {
    match kind {
        Kind::HardFault(report) => format!("hard fault ({})", fault(report)),
        Kind::Lockup(report) => format!("lockup ({})", fault(report)),
        Kind::Watchdog { fault: None } => "reset by the watchdog".into(),
        Kind::Watchdog {
            fault: Some(report),
        } => format!("reset by the watchdog, after a fault ({})", fault(report)),
        Kind::Requested => "reset that the program asked for".into(),
        Kind::RunPin => "reset by the RUN pin".into(),
        Kind::BrownOut => "reset by the brown-out detector".into(),
        Kind::PowerLost => "loss of power".into(),
    }
}

fn fault(report: FaultReport) -> String {
    let FaultReport {
        cause,
        instruction,
        address,
    } = report;
    let access = address.map_or(String::new(), |address| {
        format!(", access to {address:#010x}")
    });
    format!("{cause} at {instruction:#010x}{access}")
}

#[cfg(test)]
mod tests {
    use emulated_rp2040::cpu::FaultCause;

    use super::*;

    #[test]
    fn incidents_are_told_in_words() {
        let report = FaultReport {
            cause: FaultCause::Unaligned,
            instruction: 0x1000_0200,
            address: Some(3),
        };
        let told = incident(Kind::Watchdog {
            fault: Some(report),
        });
        assert_eq!(
            told,
            "reset by the watchdog, after a fault (unaligned access at 0x10000200, access to \
             0x00000003)"
        );
    }
}
