//! Logs replay to the same bits; damage is found, and any change that an output depends on.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/rewrite.rs"]
mod rewrite;

use std::io::Cursor;

use proptest::prelude::*;
use rewrite::rewrite;
use rover_log::{Log, LogWriter, Origin, ReadError, knowledge, replay};
use rover_shared::learning::Mode;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_simulator::arena::{ArenaSource, Layout};
use rover_simulator::experiment::{Known, SessionPlan, learn};

/// A short session's log.
fn record(seed: u64, trials: u32, follow_direction: bool) -> Vec<u8> {
    let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
    let arenas = ArenaSource::from(Layout::paper());
    let plan = SessionPlan {
        seed,
        trials,
        steps: 120,
        follow_direction,
        arenas,
    };
    let before = knowledge::to_bytes(
        &Known::new(&coefficients.learning),
        coefficients.parameters(),
    );
    let origin = Origin {
        seed,
        mode: Mode::Learn,
        writer: "test".into(),
    };
    let mut log = LogWriter::new(Cursor::new(Vec::new()), &origin, &before).unwrap();
    let learned = learn(&plan, &coefficients, &mut log, |_| {});
    let after = knowledge::to_bytes(&learned.knowledge, coefficients.parameters());
    log.finish(&after).unwrap().into_inner()
}

/// The log with `from` replaced by `to` at its `nth` occurrence.
fn forge(log: &[u8], from: &str, to: &str, nth: usize) -> Vec<u8> {
    let mut seen = 0;
    let log = rewrite(log, |_, text| {
        let here = text.matches(from).count();
        if (seen..seen + here).contains(&nth) {
            let (at, _) = text.match_indices(from).nth(nth - seen).unwrap();
            text.replace_range(at..at + from.len(), to);
        }
        seen += here;
        true
    });
    assert!(seen > nth, "{from} occurs {seen} times");
    log
}

fn first_difference(log: &[u8]) -> Option<String> {
    let log = Log::read(log).unwrap();
    replay::verify(&log)
        .unwrap()
        .difference
        .map(|difference| difference.to_string())
}

#[test]
fn a_log_replays_to_the_same_bits() {
    for follow_direction in [false, true] {
        let log = Log::read(&record(11, 8, follow_direction)).unwrap();
        let replayed = replay::verify(&log).unwrap();
        assert_eq!(replayed.difference, None);
        assert!(replayed.complete && replayed.steps > 100, "{replayed:?}");
        assert_eq!(replayed.trials, 8);
    }
}

#[test]
fn one_seed_writes_one_log() {
    assert!(record(12, 3, false) == record(12, 3, false));
    assert!(record(12, 3, false) != record(13, 3, false));
}

#[test]
fn a_changed_output_is_named() {
    let log = record(11, 2, false);
    let text = first_difference(&forge(
        &log,
        "\"module_um\":40000",
        "\"module_um\":40001",
        5,
    ));
    let text = text.unwrap();
    assert!(
        text.contains("message 6 (trial 1): record.action.module_um"),
        "{text}"
    );
    assert!(
        text.contains("recorded as 40001, the core gives 40000"),
        "{text}"
    );
}

#[test]
fn a_changed_input_is_named_by_what_follows_from_it() {
    let log = record(11, 2, false);
    let forged = forge(&log, "\"front_um\":400000", "\"front_um\":300000", 0);
    let text = first_difference(&forged).unwrap();
    assert!(text.contains("record.sensed.percept_ppm[0]"), "{text}");
    assert!(
        text.contains("recorded as 1000000, the core gives 500000"),
        "{text}"
    );
}

#[test]
fn a_message_that_was_taken_out_is_found() {
    let log = record(11, 2, false);
    let mut step = 0;
    let without = rewrite(&log, |topic, _| {
        step += u32::from(topic == "/step");
        topic != "/step" || step != 7
    });
    let text = first_difference(&without).unwrap();
    assert!(text.contains("message 7 (trial 1): record."), "{text}");
    let without_end = rewrite(&log, |topic, _| topic != "/end");
    assert!(first_difference(&without_end).is_some());
}

#[test]
fn a_value_that_no_output_depends_on_can_be_changed_on_purpose() {
    let log = record(11, 2, false);
    assert_eq!(
        first_difference(&forge(&log, "\"x_um\":1", "\"x_um\":2", 0)),
        None
    );
}

/// Messages of a chunk, at most: 768 KiB of no less than 500 bytes each.
const CHUNK: usize = 1_600;

/// A log of several chunks.
fn long_log() -> &'static [u8] {
    static LOG: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| record(15, 30, true));
    &LOG
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Whatever byte of a file is changed, the log is refused or the difference found, unless the
    /// byte belongs to what readers do not use (the index, names of the writing library).
    #[test]
    fn no_changed_message_byte_goes_unnoticed(at: prop::sample::Index, by in 1u8..=255) {
        let log = record(14, 2, false);
        let intact = Log::read(&log).unwrap();
        let mut changed = log.clone();
        let at = at.index(changed.len());
        changed[at] ^= by;
        match Log::read(&changed) {
            Err(_) => {}
            Ok(read) => {
                let same = read.entries == intact.entries
                    && read.before == intact.before
                    && read.after == intact.after
                    && read.origin == intact.origin;
                // Damage looks like a cut where it hits the length of a record.
                let unnoticed = replay::verify(&read)
                    .is_ok_and(|replayed| replayed.difference.is_none() && replayed.complete);
                prop_assert!(same || !unnoticed, "byte {at}");
            }
        }
    }

    /// A log that ends anywhere is readable up to there.
    #[test]
    fn a_cut_log_is_readable_up_to_the_cut(at: prop::sample::Index) {
        let log = long_log();
        let whole = Log::read(log).unwrap();
        let cut = at.index(log.len());
        match Log::read(&log[..cut]) {
            Ok(read) => {
                prop_assert!(read.cut_off);
                prop_assert!(whole.entries.starts_with(&read.entries));
                // All but the chunk that was being written can be read.
                let share = whole.entries.len() * cut / log.len();
                prop_assert!(read.entries.len() + CHUNK >= share, "cut at {cut}");
                prop_assert_eq!(replay::verify(&read).unwrap().difference, None);
            }
            // Only a log without its beginning says nothing at all.
            Err(error) => prop_assert!(cut < 4_000, "cut at {cut}: {error}"),
        }
    }
}

#[test]
fn other_files_are_refused_with_a_sentence() {
    let text = |file: &[u8]| Log::read(file).unwrap_err().to_string();
    assert!(text(b"").contains("not an MCAP file"), "{}", text(b""));
    assert!(text(b"t_s,front_cm\n").contains("not an MCAP file"));
    let mut foreign = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    foreign.finish().unwrap();
    let foreign = foreign.into_inner().into_inner();
    assert!(matches!(Log::read(&foreign), Err(ReadError::Foreign(_))));
}
