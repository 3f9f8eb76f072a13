//! Logs are read by the MCAP project's Python library, and each message is what its schema says.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/formats.rs"]
mod formats;

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::LazyLock;

use rover_link::{Counters, Received, Sent};
use rover_log::arena::Arena;
use rover_log::knowledge;
use rover_log::recording::{Recording, RecordingWriter, Topic, What};
use rover_log::{LogWriter, Origin};
use rover_shared::contract::{
    Calibration, ChannelHealth, CompassHealth, Counters as Faults, CurvePoint, Fault, FaultReport,
    Mode, Outcome, Refusal, ResetReason, State, Task,
};
use rover_shared::controller::StepRecord;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::sensing::Sample;
use rover_shared::time::Instant;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{
    Ack, ActionRecord, Chunk, Command, Event, EventKind, Hello, Report, Status,
};
use rover_simulator::arena::{ArenaSource, Layout};
use rover_simulator::experiment::{Known, SessionPlan, Stream, generator, learn};
use serde_json::Value;

/// A Python with the packages; `None`, and a sentence, where there is none.
static PYTHON: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
    let python = python();
    if let Err(missing) = &python {
        eprintln!("not checked with Python's mcap: {missing}");
    }
    python.ok()
});

fn python() -> Result<PathBuf, String> {
    let has_packages = |python: &Path| {
        let check = process::Command::new(python)
            .args(["-c", "import mcap.reader, jsonschema"])
            .output();
        check.is_ok_and(|output| output.status.success())
    };
    let plain = PathBuf::from("python3");
    if has_packages(&plain) {
        return Ok(plain);
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let python = folder.join("bin").join("python");
    if has_packages(&python) {
        return Ok(python);
    }
    let run = |command: &mut process::Command, what: &str| match command.output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(_) => Err(format!("{what} failed")),
        Err(error) => Err(format!("{what}: {error}")),
    };
    let mut venv = process::Command::new("python3");
    venv.args(["-m", "venv", "--clear"]).arg(&folder);
    run(&mut venv, "`python3 -m venv` (install Python 3 with venv)")?;
    let mut pip = process::Command::new(&python);
    let quick = ["--timeout", "10", "--retries", "1"];
    pip.args(["-m", "pip", "install", "--quiet", "mcap", "jsonschema"]);
    pip.args(quick);
    run(
        &mut pip,
        "`pip install mcap jsonschema` (connect to the Internet, or install them)",
    )?;
    if has_packages(&python) {
        Ok(python)
    } else {
        Err("the packages mcap and jsonschema cannot be imported".into())
    }
}

/// What Python found in a log; `None` without Python.
fn read(log: &Path) -> Option<Value> {
    let python = PYTHON.as_ref()?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_log.py");
    let output = process::Command::new(python)
        .arg(script)
        .arg(log)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

#[test]
fn a_simulations_log_is_read_by_others() {
    let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for follow_direction in [false, true] {
        let plan = SessionPlan {
            seed: 3,
            trials: 4,
            steps: 100,
            follow_direction,
            arenas: ArenaSource::from(Layout::paper()),
        };
        let known = Known::new(&coefficients.learning);
        let before = knowledge::to_bytes(&known, coefficients.parameters());
        let origin = Origin {
            seed: 3,
            mode: rover_shared::learning::Mode::Learn,
            writer: "test".into(),
        };
        let mut log = LogWriter::new(Cursor::new(Vec::new()), &origin, &before).unwrap();
        let learned = learn(&plan, &coefficients, &mut log, |_| {});
        let after = knowledge::to_bytes(&learned.knowledge, coefficients.parameters());
        let bytes = log.finish(&after).unwrap().into_inner();
        let path = folder.path().join("learn.mcap");
        std::fs::write(&path, &bytes).unwrap();
        let Some(found) = read(&path) else {
            return;
        };
        let steps: u32 = learned.trials.iter().map(|trial| trial.steps).sum();
        assert_eq!(found["topics"]["/step"]["messages"], steps);
        assert_eq!(found["topics"]["/step"]["schema"], "Step");
        assert_eq!(found["topics"]["/end"]["messages"], 4);
        assert_eq!(found["counted"]["/step"], steps);
        let attachments: Vec<_> = found["attachments"].as_array().unwrap().iter().collect();
        assert_eq!(attachments.len(), 2);
        assert_eq!(found["metadata"]["turing-rover"]["seed"], "3");
    }
}

#[test]
fn logs_of_old_formats_are_read_by_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("old.mcap");
    for file in formats::logs().concat() {
        std::fs::write(&path, file).unwrap();
        let Some(found) = read(&path) else {
            return;
        };
        assert_eq!(found["metadata"]["turing-rover"]["format"], "1");
    }
}

#[test]
fn a_recording_with_every_kind_of_message_is_read_by_others() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let mut log = RecordingWriter::create(&path, None, "test", None).unwrap();
    let mut expected = std::collections::BTreeMap::new();
    for (sequence, report) in (0..).zip(reports()) {
        let topic = topic(&report);
        *expected.entry(topic.name()).or_insert(0) += 1;
        log.hear(&Received {
            at: Instant(u64::from(sequence) * 1_000),
            sequence,
            lost: u32::from(sequence % 3),
            report,
        })
        .unwrap();
    }
    log.gap(Instant(900_000), "unplugged").unwrap();
    let coefficients = Coefficients::new(&Parameters::ROVER).unwrap();
    let known = Known::new(&coefficients.learning);
    let bytes = knowledge::to_bytes(&known, &Parameters::ROVER);
    log.knowledge(Instant(900_000), &bytes).unwrap();
    for (sequence, command) in (0..).zip(commands()) {
        let at = Instant(1_000_000);
        log.command(&Sent {
            at,
            sequence,
            command,
        })
        .unwrap();
    }
    let scenario = ArenaSource::named("rover-5m")
        .unwrap()
        .scenario(&mut generator(1, Stream::Learning));
    let time = Instant(2_000_000);
    log.arena(time, Arena::new(1, &scenario, false)).unwrap();
    log.truth(time, time, scenario.start).unwrap();
    expected.extend([("/gap", 1), ("/knowledge", 1), ("/arena", 1), ("/truth", 1)]);
    expected.insert("/command", commands().len() as u64);
    let written = log.finish(Counters::default()).unwrap();
    // Ours first: what was written is what is read.
    let recording = Recording::read(&[std::fs::read(&path).unwrap()]).unwrap();
    // The arena is none of the messages.
    assert_eq!(recording.messages.len() as u64 + 1, written.messages);
    let arena = recording.arena.as_ref().unwrap();
    let message = |arena| serde_json::to_value(arena).unwrap();
    assert_eq!(message(arena), message(&Arena::new(1, &scenario, false)));
    let told = recording.messages.iter().filter_map(|m| match &m.what {
        What::Command(asked) => Some(asked.command.clone()),
        _ => None,
    });
    assert_eq!(told.collect::<Vec<_>>(), commands());
    let heard: Vec<_> = recording
        .messages
        .iter()
        .filter_map(|message| match &message.what {
            What::Report(report) => Some((**report).clone()),
            _ => None,
        })
        .collect();
    assert_eq!(heard, reports());
    let kept: Vec<_> = recording
        .knowledge
        .values()
        .map(|kept| kept.to_vec())
        .collect();
    assert_eq!(kept, std::slice::from_ref(&bytes));

    let Some(found) = read(&path) else {
        return;
    };
    for topic in Topic::ALL {
        let name = topic.name();
        assert_eq!(found["topics"][name]["messages"], expected[name], "{name}");
        assert_eq!(found["counted"][name], expected[name], "{name}");
        assert_eq!(found["topics"][name]["schema"], format!("{topic:?}"));
    }
    let end = &found["metadata"]["turing-rover-end"];
    assert_eq!(end["messages"], written.messages.to_string());
    assert_eq!(end["lost_frames"], written.lost_frames.to_string());
    assert_eq!(found["attachments"][0]["bytes"], bytes.len());
}

fn topic(report: &Report) -> Topic {
    match report {
        Report::Hello(_) => Topic::Hello,
        Report::Ack(_) => Topic::Ack,
        Report::Status(_) => Topic::Status,
        Report::Action(_) => Topic::Action,
        Report::Event(_) => Topic::Event,
        Report::Fault(_) => Topic::Fault,
        Report::LastWords(_) => Topic::LastWords,
        Report::Knowledge(_) => unreachable!("chunks are not recorded"),
    }
}

/// Every kind of report, and every value that its enums take.
fn reports() -> Vec<Report> {
    let mut reports = vec![Report::LastWords(
        "panicked at board.rs:3".try_into().unwrap(),
    )];
    reports.extend(hellos());
    reports.extend(actions());
    reports.extend(events());
    reports.extend(acks());
    for (fault, time) in Fault::ALL.into_iter().zip(0..) {
        reports.push(Report::Fault(FaultReport {
            time: Instant(time),
            fault,
            count: 3,
        }));
    }
    for (state, heading) in states()
        .into_iter()
        .zip([None, Some(Microdegrees(-7))].into_iter().cycle())
    {
        reports.push(Report::Status(Status {
            time: Instant(5),
            state,
            motors_enabled: heading.is_some(),
            task: Task::FollowChangingDirection,
            direction: Microdegrees(-170_000_000),
            steps: 7,
            counts: [0, 4_095, 1, 2],
            distances: [Micrometres(u32::MAX); 4],
            heading,
            ranges: [ChannelHealth::Good; 4],
            compass: CompassHealth::Good,
            counters: Faults::default(),
        }));
    }
    reports
}

/// Every kind of command.
fn commands() -> Vec<Command> {
    use Calibration::{Compass, Range, Speed};
    let mut commands = vec![
        Command::Hello { schema: u32::MAX },
        Command::Ping,
        Command::Heartbeat,
        Command::Arm,
        Command::Disarm,
        Command::SetDirection(Microdegrees(-179_999_999)),
        Command::Drive {
            turn: Microdegrees(-1),
            advance: Micrometres(u32::MAX),
        },
        Command::SetSeed(u64::MAX),
        Command::ReadStatus,
        Command::PullKnowledge { offset: 7 },
        Command::PushKnowledge(Chunk {
            total: 3,
            fingerprint: u32::MAX,
            offset: 0,
            data: [0, 127, 255].into_iter().collect(),
        }),
        Command::StoreKnowledge,
        Command::NewKnowledge,
    ];
    let modes = [Mode::Idle, Mode::Learn, Mode::Run, Mode::Host];
    commands.extend(modes.map(Command::SetMode));
    use Task::{AimAtTarget, FollowChangingDirection, FollowDirection};
    let tasks = [FollowDirection, FollowChangingDirection, AimAtTarget];
    commands.extend(tasks.map(Command::SetTask));
    let point = CurvePoint {
        counts: 496,
        distance: Micrometres(800_000),
    };
    let calibrations = [
        Range {
            channel: 3,
            points: [point, point].into_iter().collect(),
        },
        Compass {
            offset: Microdegrees(5),
        },
        Speed {
            duty: 450,
            speed: Micrometres(150_000),
            dead_band: 180,
        },
    ];
    commands.extend(calibrations.map(Command::Calibrate));
    commands
}

fn hellos() -> Vec<Report> {
    use ResetReason::{HardFault, Panic, PowerOn, Requested, RunPin, Watchdog};
    [PowerOn, RunPin, Watchdog, Panic, HardFault, Requested]
        .into_iter()
        .zip([None, Some(u32::MAX)].into_iter().cycle())
        .map(|(reset, knowledge)| {
            Report::Hello(Hello {
                schema: 1,
                board: "boardless".try_into().unwrap(),
                firmware: "0.1.0".try_into().unwrap(),
                reset,
                seed: u64::MAX,
                knowledge,
            })
        })
        .collect()
}

/// Actions as the core makes them, and one with nothing in it.
fn actions() -> Vec<Report> {
    use Outcome::{CompassLost, Completed, Late, NoProgress, Obstacle, Stopped, TurnTimeout};
    let coefficients = Coefficients::new(&Parameters::ROVER).unwrap();
    let mut known = Known::new(&coefficients.learning);
    let rng = rover_shared::random::Generator::new(1);
    let mode = rover_shared::learning::Mode::Learn;
    let rule = rover_shared::learning::paper_rule::PaperRule;
    let mut controller =
        rover_shared::controller::Controller::new(&coefficients, rule, &mut known, rng, mode);
    let task = rover_shared::reward::FollowDirection(Microdegrees(0));
    let outcomes = [
        Completed,
        Obstacle,
        NoProgress,
        TurnTimeout,
        CompassLost,
        Late,
        Stopped,
    ];
    let sample = |i: u32| Sample {
        front: Micrometres::from_cm(14 + i * 7 % 50),
        left: Micrometres::from_cm(14 + i * 11 % 50),
        right: Micrometres::from_cm(64),
        heading: Microdegrees::from_degrees(i as i32 * 5 - 90),
        target_bearing: None,
    };
    let record = |i: u32, step: StepRecord| {
        Report::Action(ActionRecord {
            time: Instant(u64::from(i) * 1_000_000),
            counts: [1, 2, 3, 4],
            ranges: [ChannelHealth::Good; 4],
            compass: CompassHealth::Good,
            sample: sample(i),
            step,
            outcome: outcomes[i as usize % outcomes.len()],
            counters: Faults::default(),
        })
    };
    let mut actions: Vec<_> = (0..60u32)
        .map(|i| record(i, controller.step(&sample(i), &task)))
        .collect();
    let nothing = StepRecord {
        step: 0,
        sensed: None,
        learned: None,
        perceived: None,
        action: rover_shared::action::Action::STAY,
    };
    actions.push(record(60, nothing));
    actions
}

fn states() -> Vec<State> {
    let modes = [Mode::Idle, Mode::Learn, Mode::Run, Mode::Host].map(State::Driving);
    let faults = Fault::ALL.map(State::Faulted);
    let plain = [State::Disarmed, State::Armed];
    plain.into_iter().chain(modes).chain(faults).collect()
}

fn healths() -> [ChannelHealth; 7] {
    use ChannelHealth::{Frozen, Good, NotFitted, Open, Shorted, Silent, Unknown};
    [Unknown, Good, Open, Shorted, Frozen, Silent, NotFitted]
}

fn compasses() -> [CompassHealth; 4] {
    use CompassHealth::{Good, Implausible, Silent, Unknown};
    [Unknown, Good, Silent, Implausible]
}

fn events() -> Vec<Report> {
    let mut kinds: Vec<EventKind> = states().into_iter().map(EventKind::State).collect();
    kinds.extend(healths().map(|health| EventKind::Range { channel: 3, health }));
    kinds.extend(compasses().map(EventKind::Compass));
    kinds.push(EventKind::MoveEnded(Outcome::Late));
    kinds.push(EventKind::Direction(Microdegrees::HALF_TURN));
    kinds.push(EventKind::KnowledgeStored { fingerprint: 9 });
    kinds.push(EventKind::Session {
        mode: Mode::Learn,
        seed: u64::MAX,
        knowledge: u32::MAX,
    });
    let event = |kind| {
        Report::Event(Event {
            time: Instant(u64::MAX),
            kind,
        })
    };
    kinds.into_iter().map(event).collect()
}

fn acks() -> Vec<Report> {
    use Refusal::{
        Armed, BadCalibration, BadChecksum, BadKnowledge, ChunkOutOfOrder, ControlSilent,
        FlashBusy, KnowledgeInvalid, MoveUnderWay, NoHeartbeat, NoHello, NotArmed, NotHostDriven,
        OutOfRange, SchemaMismatch, TooLong, Unsupported,
    };
    let mut refusals = vec![
        NoHello,
        SchemaMismatch,
        NotArmed,
        Armed,
        KnowledgeInvalid,
        ControlSilent,
        FlashBusy,
        NoHeartbeat,
        NotHostDriven,
        MoveUnderWay,
        OutOfRange,
        BadCalibration,
        ChunkOutOfOrder,
        TooLong,
        BadChecksum,
        BadKnowledge,
        Unsupported,
    ];
    refusals.extend(Fault::ALL.map(Refusal::Fault));
    refusals.extend(compasses().map(Refusal::Compass));
    refusals.extend(healths().map(|health| Refusal::RangeSensor { channel: 0, health }));
    let results = std::iter::once(Ok(())).chain(refusals.into_iter().map(Err));
    let ack = |result| {
        Report::Ack(Ack {
            sequence: 7,
            result,
        })
    };
    results.map(ack).collect()
}
