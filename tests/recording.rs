//! What a rover said, recorded over its port, replays to the same bits; what was lost is named, and
//! damage and changes that an output depends on are found.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/rewrite.rs"]
mod rewrite;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;

use proptest::prelude::*;
use rewrite::rewrite;
use rover_boardless::{BoardlessPort, BoardlessRover};
use rover_emulator::vehicle;
use rover_link::{Client, LinkError};
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{Recorded, Recording, RecordingWriter, What};
use rover_log::replay::{self, Replayed};
use rover_log::replayable::{Knowledge, Sessions};
use rover_log::{Entry, Log, ReadError};
use rover_shared::contract::{Fault, Mode, ResetReason, Task};
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{Command, Report};

/// A rover that is recorded.
struct Bench {
    recorder: Recorder,
    rover: Rc<RefCell<BoardlessRover>>,
    cable: Rc<RefCell<bool>>,
    folder: tempfile::TempDir,
}

const MINUTE: Duration = Duration::from_millis(60_000);

fn seconds(seconds: u32) -> Duration {
    Duration::from_millis(seconds * 1_000)
}

impl Bench {
    fn new(seed: u64, rotate: Option<u64>) -> Self {
        let rover = Rc::new(RefCell::new(BoardlessRover::in_empty_room(seed)));
        Self::of(rover, rotate)
    }

    fn of(rover: Rc<RefCell<BoardlessRover>>, rotate: Option<u64>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let port = BoardlessPort::new(rover.clone());
        let cable = port.cable();
        let client = Client::open(Box::new(port)).unwrap();
        let log = RecordingWriter::create(&folder.path().join("drive.mcap"), rotate, "test", None);
        Self {
            recorder: Recorder::begin(client, None, log.unwrap()).unwrap(),
            rover,
            cable,
            folder,
        }
    }

    fn order(&mut self, command: Command) {
        self.recorder.client().ask(&command).unwrap();
    }

    fn run(&mut self, span: Duration) {
        let until = self.recorder.client().now().after(span);
        while self.recorder.client().now() < until {
            let left = until.since(self.recorder.client().now());
            self.recorder.next(left).unwrap();
        }
    }

    /// Learns to follow directions that change, until disarmed.
    fn learn(&mut self) {
        self.order(Command::SetTask(Task::FollowChangingDirection));
        self.order(Command::Arm);
        self.order(Command::SetMode(Mode::Learn));
    }

    fn stop(&mut self) {
        self.order(Command::Disarm);
        self.run(seconds(1));
    }

    /// The contents of the files.
    fn finish(self) -> (Vec<Vec<u8>>, tempfile::TempDir) {
        let written = self.recorder.finish(|_| {}).unwrap();
        let read = |path: &PathBuf| std::fs::read(path).unwrap();
        (written.files.iter().map(read).collect(), self.folder)
    }
}

fn verify(files: &[Vec<u8>]) -> Replayed {
    replay::verify_sessions(&Sessions::read(files).unwrap()).unwrap()
}

fn actions(files: &[Vec<u8>]) -> usize {
    let recording = Recording::read(files).unwrap();
    let action = |what: &What| match what {
        What::Report(report) => matches!(**report, Report::Action(_)),
        _ => false,
    };
    let messages = recording.messages.iter();
    messages.filter(|message| action(&message.what)).count()
}

#[test]
fn a_learning_rover_replays_to_the_same_bits() {
    let mut bench = Bench::new(11, None);
    bench.learn();
    for i in 0..30u32 {
        bench.run(seconds(10));
        // Odd things happen: a compass that fails, another order, another session.
        match i % 10 {
            2 => {
                let silent = [vehicle::Fault::CompassSilent];
                bench.rover.borrow_mut().set_faults(&silent);
                bench.run(Duration::from_millis(300));
                bench.rover.borrow_mut().set_faults(&[]);
            }
            5 => bench.order(Command::SetDirection(Microdegrees::from_degrees(i as i32))),
            7 => {
                bench.order(Command::SetMode(Mode::Idle));
                bench.run(Duration::from_millis(100));
                bench.order(Command::SetMode(Mode::Run));
            }
            9 => {
                bench.stop();
                bench.learn();
            }
            _ => {}
        }
    }
    bench.stop();
    let stored = bench.rover.borrow().stored().to_vec();
    let (files, _folder) = bench.finish();
    let replayed = verify(&files);
    assert_eq!(replayed.difference, None);
    assert_eq!(replayed.unverified, []);
    assert!(replayed.complete);
    assert!(replayed.sessions >= 6, "{replayed:?}");
    assert!(
        replayed.steps > 150 && replayed.steps == actions(&files),
        "{replayed:?}"
    );
    let sessions = Sessions::read(&files).unwrap();
    let last = sessions.sessions.last().unwrap();
    assert_eq!(last.after, Some(Knowledge::Bytes(stored.into())));
    // What figures and the monitor look at.
    let log = Log::read(&files[0]).unwrap();
    assert_eq!(log.entries.len(), replayed.steps);
    assert!(log.after.is_some() && !log.cut_off);
}

#[test]
fn a_changed_value_is_named() {
    let mut bench = Bench::new(3, None);
    bench.learn();
    bench.run(MINUTE);
    bench.stop();
    let (files, _folder) = bench.finish();
    let forged = forge(
        &files[0],
        "/action",
        "\"module_um\":70000",
        "\"module_um\":70001",
    );
    let text = verify(&[forged]).difference.unwrap().to_string();
    assert!(
        text.contains("record.action.module_um was recorded as 70001"),
        "{text}"
    );
}

#[test]
fn an_action_that_was_taken_out_is_found() {
    let mut bench = Bench::new(3, None);
    bench.learn();
    bench.run(MINUTE);
    bench.stop();
    let (files, _folder) = bench.finish();
    let mut action = 0;
    let without = rewrite(&files[0], |topic, _| {
        action += u32::from(topic == "/action");
        topic != "/action" || action != 7
    });
    let difference = verify(&[without]).difference.unwrap();
    assert!(difference.field.starts_with("record."), "{difference}");
}

#[test]
fn knowledge_at_the_end_is_compared() {
    let mut bench = Bench::new(3, None);
    bench.learn();
    bench.run(MINUTE);
    bench.stop();
    let (files, _folder) = bench.finish();
    let mut sessions = Sessions::read(&files).unwrap();
    let after = &mut sessions.sessions[0].after;
    let Some(Knowledge::Bytes(bytes)) = after else {
        panic!("it was pulled at the end");
    };
    let print = rover_shared::checksum::fingerprint(bytes);
    let mut other = bytes.to_vec();
    *other.last_mut().unwrap() ^= 1;
    *after = Some(Knowledge::Bytes(other.into()));
    let text = |s: &Sessions| {
        replay::verify_sessions(s)
            .unwrap()
            .difference
            .unwrap()
            .to_string()
    };
    assert!(text(&sessions).contains("of the knowledge at the end"));
    sessions.sessions[0].after = Some(Knowledge::Named(!print));
    assert!(text(&sessions).contains(&format!("the core gives \"{print:08x}\"")));
    sessions.sessions[0].after = Some(Knowledge::Named(print));
    let replayed = replay::verify_sessions(&sessions).unwrap();
    assert!(replayed.complete && replayed.difference.is_none());
}

#[test]
fn a_lost_frame_ends_what_can_be_verified_until_the_next_session() {
    let mut bench = Bench::new(5, None);
    bench.learn();
    bench.run(MINUTE);
    bench.rover.borrow_mut().lose = 1;
    bench.run(MINUTE);
    bench.stop();
    bench.learn();
    bench.run(MINUTE);
    bench.stop();
    let (files, _folder) = bench.finish();
    let replayed = verify(&files);
    assert_eq!(replayed.difference, None);
    assert!(!replayed.complete);
    // The session that was cut short, and what is left of it.
    let [cut, rest] = &replayed.unverified[..] else {
        panic!("{replayed:?}");
    };
    assert!(cut.reason.contains("a frame was lost"), "{cut:?}");
    assert!(rest.steps > 10, "{rest:?}");
    assert_eq!(replayed.steps + rest.steps, actions(&files));
    assert!(
        replayed.steps > 2 * rest.steps - 10,
        "the sessions before and after: {replayed:?}"
    );
}

#[test]
fn a_recording_survives_unplugging_and_resets() {
    let mut bench = Bench::new(6, None);
    for round in 0..12u64 {
        bench.learn();
        bench.run(seconds(20));
        *bench.cable.borrow_mut() = false;
        let Err(RecordError::Link(error @ LinkError::Port(_))) = bench.recorder.next(seconds(1))
        else {
            panic!("a pulled cable is noticed");
        };
        bench.rover.borrow_mut().run(seconds(3));
        if round % 3 == 1 {
            bench.rover.borrow_mut().reset(ResetReason::PowerOn, round);
        }
        *bench.cable.borrow_mut() = true;
        bench.recorder.reconnect(&error, MINUTE, &|| false).unwrap();
        bench.run(seconds(5));
        bench.stop();
    }
    let (files, _folder) = bench.finish();
    let recording = Recording::read(&files).unwrap();
    let gaps = recording
        .messages
        .iter()
        .filter(|m| matches!(m.what, What::Gap(_)));
    assert_eq!(gaps.count(), 12);
    let replayed = verify(&files);
    assert_eq!(replayed.difference, None);
    let unverified: usize = replayed.unverified.iter().map(|u| u.steps).sum();
    assert_eq!(replayed.steps + unverified, actions(&files));
    assert!(replayed.steps > 100 && unverified > 0, "{replayed:?}");
    let told = replayed
        .unverified
        .iter()
        .any(|u| u.reason.contains("unplugged"));
    assert!(told, "{replayed:?}");
}

#[test]
fn a_rover_that_starts_anew_behind_an_open_port_is_a_gap() {
    let mut bench = Bench::new(12, None);
    bench.learn();
    bench.run(seconds(30));
    {
        let mut rover = bench.rover.borrow_mut();
        rover.reset(ResetReason::Watchdog, 5);
        rover.open();
    }
    // The client notices by the hello, and introduces itself again.
    bench.run(seconds(1));
    bench.learn();
    bench.run(seconds(30));
    bench.stop();
    let (files, _folder) = bench.finish();
    let replayed = verify(&files);
    assert_eq!((replayed.difference, replayed.sessions), (None, 2));
    assert_eq!(replayed.steps, actions(&files));
    let [cut] = &replayed.unverified[..] else {
        panic!("{:?}", replayed.unverified);
    };
    assert!(cut.reason.contains("began anew"), "{cut}");
}

#[test]
fn reports_that_the_rover_dropped_are_a_gap_without_a_gap_in_numbers() {
    let mut bench = Bench::new(13, None);
    bench.learn();
    bench.run(MINUTE);
    bench.stop();
    let (files, _folder) = bench.finish();
    let mut recording = Recording::read(&files).unwrap();
    // As if there had been no room for one action in the rover's queue.
    let action = |message: &Recorded| match &message.what {
        What::Report(report) => matches!(**report, Report::Action(_)),
        _ => false,
    };
    let all = recording
        .messages
        .iter()
        .filter(|message| action(message))
        .count();
    let dropped = recording.messages.iter().position(action).unwrap() + 20;
    let dropped = dropped
        + recording.messages[dropped..]
            .iter()
            .position(action)
            .unwrap();
    recording.messages.remove(dropped);
    for message in &mut recording.messages[dropped..] {
        if let What::Report(report) = &mut message.what {
            match &mut **report {
                Report::Action(action) => action.counters.0[Fault::QueueFull as usize] += 1,
                Report::Status(status) => status.counters.0[Fault::QueueFull as usize] += 1,
                _ => {}
            }
        }
    }
    let replayed = replay::verify_sessions(&Sessions::from(recording)).unwrap();
    assert_eq!(replayed.difference, None);
    let unverified: usize = replayed.unverified.iter().map(|u| u.steps).sum();
    assert_eq!(replayed.steps + unverified, all - 1);
    assert!(replayed.steps > 5 && unverified > 5, "{replayed:?}");
    assert!(
        replayed.unverified[0]
            .reason
            .contains("the rover dropped 1 report")
    );
}

#[test]
fn a_recording_that_begins_in_the_middle_says_so() {
    let rover = {
        let mut bench = Bench::new(7, None);
        bench.learn();
        bench.run(seconds(20));
        bench.rover.clone()
    };
    let mut bench = Bench::of(rover, None);
    bench.run(seconds(30));
    let (files, _folder) = bench.finish();
    let replayed = verify(&files);
    assert_eq!((replayed.steps, replayed.difference), (0, None));
    assert!(
        replayed.unverified[0]
            .reason
            .contains("beginning is not in the log")
    );
    assert!(matches!(Log::read(&files[0]), Err(ReadError::NoStart)));
}

#[test]
fn a_long_recording_is_rotated_and_read_as_one() {
    let mut bench = Bench::new(8, Some(300_000));
    bench.learn();
    bench.run(Duration::from_millis(15 * 60_000));
    bench.stop();
    let (files, _folder) = bench.finish();
    assert!(files.len() > 2, "{} files", files.len());
    let lengths: Vec<_> = files.iter().map(Vec::len).collect();
    assert!(
        lengths.iter().all(|length| *length < 450_000),
        "{lengths:?}"
    );
    let replayed = verify(&files);
    assert!(
        replayed.complete && replayed.difference.is_none(),
        "{replayed:?}"
    );
    assert_eq!(replayed.steps, actions(&files));
    // One that is missing is a gap, and one alone is read.
    let replayed = verify(&[files[0].clone(), files[2].clone()]);
    assert!(replayed.difference.is_none() && !replayed.complete);
    let gap = &replayed.unverified[0];
    assert!(
        gap.reason.contains("does not follow the one before"),
        "{gap}"
    );
    assert!(verify(&files[1..2]).difference.is_none());
    // Figures take it whole, too.
    let log = Log::read_parts(&files).unwrap();
    let steps = log.entries.iter();
    let steps = steps.filter(|entry| matches!(entry, Entry::Step(_)));
    assert_eq!(steps.count() as u64, actions(&files) as u64);
}

#[test]
fn a_file_that_will_be_in_the_way_is_found_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(folder.path().join("drive-2.mcap"), "").unwrap();
    let refused = RecordingWriter::create(&path, Some(300_000), "test", None);
    let error = refused.err().unwrap().to_string();
    assert!(error.contains("drive-2.mcap"), "{error}");
    assert!(!path.exists());
    RecordingWriter::create(&path, None, "test", None).unwrap();
}

#[test]
fn a_recording_never_overwrites_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    std::fs::write(&path, "something dear").unwrap();
    let error = RecordingWriter::create(&path, None, "test", None)
        .err()
        .unwrap();
    assert!(error.to_string().contains("choose another name"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"something dear");
}

#[test]
fn one_drive_writes_one_recording() {
    let record = || {
        let mut bench = Bench::new(9, None);
        bench.learn();
        bench.run(seconds(20));
        bench.stop();
        bench.finish().0
    };
    assert!(
        record() == record(),
        "a port with a time of its own makes it repeatable"
    );
}

/// Some minutes of learning, with a gap.
fn some() -> &'static [u8] {
    static FILE: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| {
        let mut bench = Bench::new(14, None);
        bench.learn();
        bench.run(MINUTE);
        bench.rover.borrow_mut().lose = 1;
        bench.run(seconds(20));
        bench.stop();
        bench.finish().0.swap_remove(0)
    });
    &FILE
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A recording that ends anywhere is readable up to there, but for the chunk being written.
    #[test]
    fn a_cut_recording_is_readable_up_to_the_cut(at: prop::sample::Index) {
        let file = some();
        let whole = Recording::read(&[file]).unwrap();
        let cut = at.index(file.len());
        match Recording::read(&[&file[..cut]]) {
            Ok(read) => {
                prop_assert!(read.cut_off);
                prop_assert!(whole.messages.starts_with(&read.messages));
                let replayed = replay::verify_sessions(&Sessions::from(read)).unwrap();
                prop_assert_eq!(replayed.difference, None);
            }
            // Before its metadata is whole it says nothing at all.
            Err(error) => prop_assert!(cut < 1_000, "cut at {}: {}", cut, error),
        }
    }

    /// Whatever byte is changed, the recording is refused, or read as it was, or the change found.
    #[test]
    fn no_changed_byte_goes_unnoticed(at: prop::sample::Index, by in 1u8..=255) {
        let mut changed = some().to_vec();
        let whole = Recording::read(&[&changed]).unwrap();
        let at = at.index(changed.len());
        changed[at] ^= by;
        if let Ok(read) = Recording::read(&[&changed]) {
            let same = read.messages == whole.messages && read.knowledge == whole.knowledge;
            let cut = read.cut_off;
            let replayed = replay::verify_sessions(&Sessions::from(read));
            let found = replayed.is_ok_and(|replayed| replayed.difference.is_some());
            prop_assert!(same || cut || found, "byte {}", at);
        }
    }

    /// Nothing that somebody calls a recording makes a reader panic.
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..2_000)) {
        let mut file = mcap::MAGIC.to_vec();
        file.extend(&bytes);
        let _ = Recording::read(&[&bytes, &file]);
        let _ = Sessions::read(&[&file]);
    }
}

/// The recording with `from` in a channel's first message that has it replaced by `to`.
fn forge(log: &[u8], topic: &str, from: &str, to: &str) -> Vec<u8> {
    let mut forged = false;
    let log = rewrite(log, |of, text| {
        if !forged && of == topic && text.contains(from) {
            *text = text.replacen(from, to, 1);
            forged = true;
        }
        true
    });
    assert!(forged, "{from} occurs in {topic}");
    log
}
