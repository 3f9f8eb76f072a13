//! A power cut at every operation of a save leaves the old or the new knowledge, whole.

use rover_shared::contract::{Mode, State};
use rover_shared::wire::message::{Command, Event, EventKind, Report};

use crate::rig::Bench;

/// Waits until knowledge was saved; gives its fingerprint.
fn saved(bench: &mut Bench) -> Option<u32> {
    let stored = bench.wait(5_000, |report| {
        matches!(report, Report::Event(event)
            if matches!(event.kind, EventKind::KnowledgeStored { .. }))
    });
    match stored {
        Some(Report::Event(Event {
            kind: EventKind::KnowledgeStored { fingerprint },
            ..
        })) => Some(fingerprint),
        _ => None,
    }
}

/// The knowledge that the board has after it was switched on again, disarmed.
fn after_power_cut(mut bench: Bench) -> Option<u32> {
    bench.machine.power_on();
    bench.connect();
    bench.send(&Command::ReadStatus);
    let is_status = |report: &Report| matches!(report, Report::Status(_));
    let Some(Report::Status(status)) = bench.wait(500, is_status) else {
        panic!("no status");
    };
    assert_eq!(status.state, State::Disarmed);
    assert!(bench.motors_off());
    bench.hello().knowledge
}

/// Learns something: what that is on the bench is of no use, but it is something else than before.
fn learn(bench: &mut Bench) {
    for command in [Command::Arm, Command::SetMode(Mode::Learn)] {
        assert_eq!(bench.command(&command), Ok(()));
    }
    bench.run(1_500);
}

#[test]
fn a_power_cut_at_any_operation_of_ten_saves_leaves_old_or_new_knowledge() {
    let mut bench = Bench::connected(1);
    bench.run(500);
    assert_eq!(bench.command(&Command::StoreKnowledge), Ok(()));
    let mut old = saved(&mut bench).expect("a first save");
    let mut cuts = 0;
    for save in 0..10u64 {
        learn(&mut bench);
        let first = bench.machine.flash_operations();
        let mut undisturbed = bench.clone();
        // Once disarmed it saves by itself.
        assert_eq!(undisturbed.command(&Command::Disarm), Ok(()));
        let new = saved(&mut undisturbed).expect("another save");
        assert_ne!(old, new);
        let operations = undisturbed.machine.flash_operations() - first;
        assert!(operations >= 3, "{operations} operations");
        let mut outcomes = Vec::new();
        for operation in 0..operations {
            let mut cut = bench.clone();
            cut.machine
                .cut_power_at(first + operation, save << 8 | operation);
            cut.send(&Command::Disarm);
            cut.run(3_000);
            assert!(!cut.machine.powered(), "operation {operation}");
            let kept = after_power_cut(cut);
            assert!(
                kept == Some(old) || kept == Some(new),
                "save {save}, operation {operation}: {kept:?}"
            );
            outcomes.push(kept == Some(new));
        }
        cuts += operations;
        assert_eq!(outcomes.first(), Some(&false), "nothing new is there yet");
        let mut ended = undisturbed.clone();
        ended.machine.power_off();
        assert_eq!(after_power_cut(ended), Some(new));
        println!("save {save}: {old:08x} to {new:08x}, new after a cut: {outcomes:?}");
        (bench, old) = (undisturbed, new);
    }
    println!("{cuts} power cuts in 10 saves");
}
