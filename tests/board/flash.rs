//! A power cut at every operation of a save leaves the old or the new knowledge, whole.

use rover_shared::wire::message::{Command, Event, EventKind, Mode, Report};

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

/// The knowledge that the board has after it was switched on again.
fn after_power_cut(mut bench: Bench) -> Option<u32> {
    bench.machine.power_on();
    bench.connect();
    bench.hello().knowledge
}

#[test]
fn a_power_cut_during_a_save_leaves_old_or_new_knowledge() {
    let mut bench = Bench::connected(1);
    bench.run(500);
    assert_eq!(bench.command(&Command::StoreKnowledge), Ok(()));
    let old = saved(&mut bench).expect("a first save");
    // What it learns on the bench is of no use, but it is something else.
    for command in [Command::Arm, Command::SetMode(Mode::Learn)] {
        assert_eq!(bench.command(&command), Ok(()));
    }
    bench.run(1_500);
    let first = bench.machine.flash_operations();
    let mut undisturbed = bench.clone();
    // Once disarmed it saves by itself.
    assert_eq!(undisturbed.command(&Command::Disarm), Ok(()));
    let new = saved(&mut undisturbed).expect("a second save");
    assert_ne!(old, new);
    let operations = undisturbed.machine.flash_operations() - first;
    assert!(operations >= 3, "{operations} operations");
    undisturbed.machine.power_off();
    assert_eq!(after_power_cut(undisturbed), Some(new));
    let mut outcomes = Vec::new();
    for operation in 0..operations {
        let mut cut = bench.clone();
        cut.machine.cut_power_at(first + operation, operation);
        cut.send(&Command::Disarm);
        cut.run(3_000);
        assert!(!cut.machine.powered(), "operation {operation}");
        let kept = after_power_cut(cut);
        assert!(
            kept == Some(old) || kept == Some(new),
            "{operation}: {kept:?}"
        );
        outcomes.push(kept);
    }
    println!("{operations} operations, old {old:08x}, new {new:08x}: {outcomes:x?}");
    assert_eq!(outcomes.first(), Some(&Some(old)));
}
