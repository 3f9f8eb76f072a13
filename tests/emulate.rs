//! `rover emulate`, as a user types it: the release firmware on the emulated board.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;

use rover_log::recording::{Recording, What};
use rover_log::{Entry, Log};
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{self, Report};
use rover_simulator::arena::{Motion, Pose};
use serde_json::Value;

#[path = "support/thumb.rs"]
mod thumb;

static FIRMWARE: LazyLock<PathBuf> =
    LazyLock::new(|| thumb::build("rover-firmware", "firmware", ""));

fn rover(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rover"));
    command.args(arguments);
    command
}

fn emulate(arguments: &[&str]) -> Output {
    rover(&["emulate", "--elf"])
        .arg(&*FIRMWARE)
        .args(arguments)
        .output()
        .unwrap()
}

fn json(output: &Output) -> Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn failed(output: &Output, code: i32) -> String {
    assert!(output.stdout.is_empty());
    ended_badly(output, code)
}

/// The error of a run that had begun.
fn ended_badly(output: &Output, code: i32) -> String {
    assert_eq!(output.status.code(), Some(code));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// What the board learned by itself, with sensors, motors and radio silence between, is what the core
/// makes of the same samples here.
#[test]
fn what_the_board_recorded_replays_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("drive.mcap");
    let knowledge = folder.path().join("learned.rover");
    let (log, knowledge) = (log.to_str().unwrap(), knowledge.to_str().unwrap());
    let answer = json(&emulate(&[
        "--steps", "120", "--seed", "3", "--log", log, "--save", knowledge, "--json",
    ]));
    assert_eq!(answer["drive"]["actions"], 120);
    assert_eq!(answer["drive"]["lost_frames"], 0);
    assert_eq!(answer["incidents"], 0);
    let replayed = json(
        &rover(&["replay", log, "--verify", "--json"])
            .output()
            .unwrap(),
    );
    assert_eq!(replayed["steps"], 120, "{replayed}");
    assert_eq!(replayed["difference"], Value::Null);
    assert_eq!(replayed["complete"], true);
    let shown = json(
        &rover(&["knowledge", "show", knowledge, "--json"])
            .output()
            .unwrap(),
    );
    assert!(shown["patterns"].as_array().unwrap().len() > 1, "{shown}");
    // What it learned can be given to another.
    let answer = json(&emulate(&[
        "--steps",
        "5",
        "--knowledge",
        knowledge,
        "--mode",
        "run",
        "--json",
    ]));
    assert_eq!(answer["drive"]["actions"], 5);
}

#[test]
fn a_recording_knows_where_the_emulated_rover_was_and_what_it_was_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    emulate(&[
        "--steps",
        "260",
        "--seed",
        "4",
        "--log",
        path.to_str().unwrap(),
    ]);
    let file = std::fs::read(path).unwrap();
    let recorded = Recording::read(&[&file]).unwrap();
    // Every acknowledgement is one of a command that is there.
    let mut asked = BTreeMap::new();
    let mut answered = 0;
    for message in &recorded.messages {
        match &message.what {
            What::Command(sent) => {
                asked.insert(sent.sequence, sent.command.clone());
            }
            What::Report(report) => {
                if let Report::Ack(ack) = **report {
                    answered += 1;
                    assert!(asked.contains_key(&ack.sequence), "{ack:?}");
                }
            }
            _ => {}
        }
    }
    assert!(answered >= asked.len() && answered > 5, "{answered}");
    assert!(
        asked
            .values()
            .any(|command| *command == message::Command::Arm)
    );

    let log = Log::read(&file).unwrap();
    let [arena] = log.arenas.as_slice() else {
        panic!("{} arenas", log.arenas.len());
    };
    let scenario = arena.scenario(None).unwrap();
    assert_eq!(scenario.world.width_cm(), 500.0);
    // By the places, a whole move is as long as the rover says it is, and its compass points ahead.
    let steps = log.entries.iter().map(|entry| match entry {
        Entry::Step(step) => step,
        Entry::End(_) => panic!("a rover has no trials"),
    });
    let steps: Vec<_> = steps.collect();
    assert_eq!(steps.len(), 260);
    let mut whole = 0;
    for pair in steps.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|step| Pose::from(step.pose.unwrap()));
        let way = (to.position() - from.position()).length();
        if pair[0].motion == Some(Motion::Moved) && !pair[1].interrupted {
            whole += 1;
            assert!((4.0..10.0).contains(&way), "{way} cm");
        }
        let back = Microdegrees(-from.heading.0);
        let off = pair[0].sample.heading.turned(back);
        assert!(off.0.abs() < 10_000_000, "{off:?}");
    }
    assert!(whole > 100, "{whole}");

    // Figures take it in parts: 100 actions, and the last one with the rest that is no half.
    let parts = rover_figure::LoggedSession::new(&log).unwrap().drives;
    let lengths: Vec<_> = parts.iter().map(|part| part.events.len()).collect();
    assert_eq!(lengths, [100, 100, 60]);
    assert!(parts.iter().all(|part| part.arena_known));
    let begins: Vec<_> = parts.iter().map(|part| part.first_action).collect();
    assert_eq!(begins, [0, 100, 200]);
    assert_eq!(parts[0].end, parts[1].scenario.start.position());
}

#[test]
fn the_same_seed_gives_the_same_drive() {
    let run = |seed| {
        let mut answer = json(&emulate(&["--steps", "15", "--seed", seed, "--json"]));
        for varying in ["wall_seconds", "times_real_time"] {
            answer[varying].take();
        }
        answer
    };
    assert_eq!(run("5"), run("5"));
    assert_ne!(run("5"), run("6"));
}

#[test]
fn times_load_and_sizes_are_measured() {
    let answer = json(&emulate(&["--steps", "10", "--report", "--json"]));
    let report = &answer["report"];
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(report["perception"]["times"], 10, "{report}");
    assert!(number(&report["perception"]["mean_cycles"]) > 10_000.0);
    assert!(
        number(&report["action_cycle"]["mean_cycles"])
            > number(&report["perception"]["mean_cycles"])
    );
    assert!((0.0..1.0).contains(&number(&report["cpu_load"])));
    assert!(number(&report["sizes"]["flash_bytes"]) <= 160.0 * 1024.0);
    assert!(number(&report["sizes"]["static_ram_bytes"]) <= 160.0 * 1024.0);
    assert!(
        number(&report["stack_high_water_bytes"]) < number(&report["stack_bytes"]) / 2.0,
        "{report}"
    );
}

#[test]
fn a_fault_that_ends_the_drive_is_told() {
    let answer = json(&emulate(&[
        "--steps",
        "50",
        "--fault",
        "10:compass-silent",
        "--json",
    ]));
    assert_eq!(
        answer["drive"]["ended"]["by_rover"]["Faulted"], "Compass",
        "{answer}"
    );
    let answer = json(&emulate(&[
        "--steps",
        "50",
        "--fault",
        "8+1:task control hang",
        "--json",
    ]));
    assert_eq!(answer["drive"]["ended"]["by_rover"], "Disarmed", "{answer}");
    assert_ne!(answer["incidents"], 0);
}

#[test]
fn a_run_that_a_fault_ends_for_good_says_so_and_what_there_was() {
    let output = emulate(&["--steps", "50", "--fault", "10:usb unplugged"]);
    let error = ended_badly(&output, 1);
    assert!(error.contains("did not come back within 60 s"), "{error}");
    assert!(error.contains("faults at work: usb unplugged"), "{error}");
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(summary.contains("s emulated in"), "{summary}");
}

#[test]
fn faults_that_never_came_about_are_told() {
    let faults = ["action 30:ir left open", "flash 90:power cut"];
    let mut arguments = vec!["--steps", "3"];
    arguments.extend(faults.iter().flat_map(|fault| ["--fault", *fault]));
    let output = emulate(&arguments);
    let told = String::from_utf8(output.stderr).unwrap();
    for fault in faults {
        assert!(told.contains(&format!("came about: {fault}")), "{told}");
    }
}

#[test]
fn what_cannot_be_saved_is_refused_before_the_drive() {
    for option in ["--save", "--log"] {
        let path = "no-such-folder/place.mcap";
        let output = emulate(&["--steps", "4000000000", "--limit", "60", option, path]);
        let error = failed(&output, 1);
        assert!(error.contains("choose another place"), "{error}");
    }
}

#[test]
fn a_run_that_takes_too_long_is_given_up() {
    let output = emulate(&["--steps", "4000000000", "--limit", "1"]);
    let error = ended_badly(&output, 1);
    assert!(error.contains("given up after 1 s"), "{error}");
    assert!(error.contains("its core is at 0x"), "{error}");
    assert!(error.contains("--limit"), "{error}");
}

#[test]
fn a_program_that_is_not_the_firmware_is_told() {
    let vectors = thumb::build("rover-thumb-vectors", "release", "");
    let output = rover(&["emulate", "--limit", "20", "--elf"])
        .arg(vectors)
        .output()
        .unwrap();
    let error = failed(&output, 1);
    assert!(
        error.contains("does not say which board it is for"),
        "{error}"
    );
}

#[test]
fn bad_use_says_what_was_expected() {
    let error = failed(&emulate(&["--fault", "5:the wheel falls off"]), 2);
    assert!(error.contains("compass silent|stuck"), "{error}");
    let error = failed(&emulate(&["--fault", "compass silent"]), 2);
    assert!(error.contains("AT[+FOR]:WHAT"), "{error}");
    let missing = rover(&["emulate", "--elf", "no/such/firmware"])
        .output()
        .unwrap();
    let error = failed(&missing, 1);
    assert!(error.contains("cargo fw"), "{error}");
    let text = rover(&["emulate", "--elf", file!()])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let error = failed(&text, 1);
    assert!(error.contains("emulate.rs"), "{error}");
    let error = failed(&emulate(&["--direction", "90"]), 2);
    assert!(error.contains("--task follow"), "{error}");
    let error = failed(&emulate(&["--log", "drive.txt"]), 2);
    assert!(error.contains(".mcap"), "{error}");
    let error = failed(&emulate(&["--arena", "nowhere"]), 1);
    assert!(error.contains("nowhere"), "{error}");
}

/// Every command works on an emulated board at the end of a pseudo-terminal.
#[cfg(unix)]
#[test]
fn an_emulated_board_can_be_had_at_a_pseudo_terminal() {
    let mut served = rover(&["emulate", "--pty", "--elf"])
        .arg(&*FIRMWARE)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut path = String::new();
    let mut printed = BufReader::new(served.stdout.take().unwrap());
    printed.read_line(&mut path).unwrap();
    let path = path.trim();
    let ask = |arguments: &[&str]| {
        let output = rover(arguments).args(["--port", path]).output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments:?}: {errors}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let state = || {
        let answer: Value = serde_json::from_str(&ask(&["status", "--json"])).unwrap();
        answer["status"]["state"].clone()
    };
    assert_eq!(state(), "Disarmed");
    ask(&["arm"]);
    assert_eq!(state(), "Armed");
    ask(&["task", "follow", "90", "--mode", "run", "--for", "3s"]);
    assert_eq!(state(), "Disarmed", "the time was over");
    assert!(ask(&["knowledge", "show"]).contains("pattern"));
    served.kill().unwrap();
    served.wait().unwrap();
}
