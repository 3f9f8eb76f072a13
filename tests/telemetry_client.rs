//! docs/telemetry.py, a host in another language and from docs/wire.md alone, with the firmware on
//! the emulated board.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rover_shared::wire::SCHEMA_HASH;
use serde_json::Value;

#[path = "support/thumb.rs"]
mod thumb;

/// How long the client may take: some dozen actions of 1.4 s, in real time.
const LIMIT: Duration = Duration::from_secs(120);

/// A program that does not outlive the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Running {
    fn start(command: &mut Command) -> Self {
        Self(command.stdout(Stdio::piped()).spawn().unwrap())
    }

    /// Waits for its end; gives its exit status.
    fn end(&mut self) -> Option<i32> {
        let began = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status.code();
            }
            assert!(began.elapsed() < LIMIT, "the client does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// An emulated rover at a pseudo-terminal.
struct Rover {
    path: String,
    _served: Running,
}

impl Rover {
    fn new() -> Self {
        let firmware = thumb::build("rover-firmware", "firmware", "");
        let mut served = Running::start(
            Command::new(env!("CARGO_BIN_EXE_rover"))
                .args(["emulate", "--pty", "--seed", "3", "--elf"])
                .arg(firmware)
                .stderr(Stdio::null()),
        );
        let mut path = String::new();
        let printed = served.0.stdout.take().unwrap();
        BufReader::new(printed).read_line(&mut path).unwrap();
        Self {
            path: path.trim().into(),
            _served: served,
        }
    }

    /// The client at this rover's port.
    fn client(&self, arguments: &[&str]) -> Running {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
        let root = { root }.find(|folder| folder.join("docs/telemetry.py").exists());
        let root = root.expect("the tests stand in the repository");
        Running::start(
            Command::new("python3")
                .arg(root.join("docs/telemetry.py"))
                .arg(&self.path)
                .args(arguments),
        )
    }

    /// All that the client prints until it ends, and its exit status.
    fn listen(&self, arguments: &[&str]) -> (Vec<Value>, Option<i32>) {
        let mut client = self.client(arguments);
        let mut printed = client.0.stdout.take().unwrap();
        let lines = std::thread::spawn(move || {
            let mut text = String::new();
            printed.read_to_string(&mut text).unwrap();
            text
        });
        let status = client.end();
        let lines = lines.join().unwrap();
        let json = |line: &str| serde_json::from_str(line).unwrap_or_else(|_| panic!("{line}"));
        (lines.lines().map(json).collect(), status)
    }

    /// What our own host hears from it.
    fn rover(&self, arguments: &[&str]) -> Value {
        let mut rover = Command::new(env!("CARGO_BIN_EXE_rover"));
        let output = rover.args(arguments).args(["--port", &self.path, "--json"]);
        let output = output.output().unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {errors}");
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

/// Whether there is Python. Somebody's machine may lack it; the one that decides must not.
fn python() -> bool {
    let there = Command::new("python3").arg("--version").output();
    let there = there.is_ok_and(|output| output.status.success());
    if !there {
        assert!(std::env::var_os("CI").is_none(), "python3 is not installed");
        eprintln!("skipped: python3 is not installed, in which docs/telemetry.py is written");
    }
    there
}

fn of_kind<'a>(lines: &'a [Value], kind: &str) -> Vec<&'a Value> {
    lines.iter().filter(|line| line["report"] == kind).collect()
}

fn numbers(values: &[&Value], pointer: &str) -> Vec<u64> {
    let number = |value: &&Value| value.pointer(pointer).and_then(Value::as_u64);
    values.iter().map(|value| number(value).unwrap()).collect()
}

fn ascend(numbers: &[u64], by: u64) -> bool {
    numbers.windows(2).all(|pair| pair[1] == pair[0] + by)
}

#[test]
fn a_host_in_python_has_a_rover_learn_and_understands_what_it_says() {
    if !python() {
        return;
    }
    let rover = Rover::new();
    let (lines, status) = rover.listen(&["--learn", "--actions", "8"]);
    assert_eq!(status, Some(0), "{lines:?}");

    let hello = of_kind(&lines, "Hello")[0];
    assert_eq!(hello["schema"], SCHEMA_HASH);
    assert_eq!(hello["board"], "rp2040-four-adc");
    assert_eq!(hello["reset"], "PowerOn");
    assert!(
        lines.iter().all(|line| line["lost_frames"] == 0),
        "{lines:?}"
    );
    let frames: Vec<_> = lines.iter().collect();
    assert!(ascend(&numbers(&frames, "/frame"), 1), "{lines:?}");

    let actions = of_kind(&lines, "Action");
    assert!(actions.len() >= 8, "{}", actions.len());
    assert!(ascend(&numbers(&actions, "/step/step"), 1), "{actions:?}");
    assert!(numbers(&actions, "/time_us").is_sorted());
    for action in &actions {
        let within = |pointer: &str, low: i64, high: i64| {
            let value = action.pointer(pointer).and_then(Value::as_i64);
            let value = value.unwrap_or_else(|| panic!("{pointer}: {action}"));
            assert!((low..=high).contains(&value), "{pointer}: {action}");
        };
        for side in ["front", "left", "right"] {
            within(&format!("/sample/{side}_um"), 140_000, 640_000);
        }
        for channel in 0..4 {
            within(&format!("/counts_adc/{channel}"), 1, 4_095);
            within(
                &format!("/step/sensed/percept_ppm/{channel}"),
                -1_000_000,
                1_000_000,
            );
            assert_eq!(action["ranges"][channel], "Good");
        }
        within("/sample/heading_udeg", -179_999_999, 180_000_000);
        within("/step/action/module_um", 70_000, 70_000);
        assert!(
            action["step"]["perceived"]["familiarity"].is_string(),
            "{action}"
        );
    }
    let session = |line: &&Value| line["kind"]["Session"]["mode"] == "Learn";
    assert_eq!(
        of_kind(&lines, "Event").into_iter().filter(session).count(),
        1
    );

    let last = *of_kind(&lines, "Status").last().unwrap();
    assert!(of_kind(&lines, "Status").len() > 5, "one a second");
    assert_eq!(last["state"], "Disarmed");
    // What it understood is what the rover says to our own host.
    let ours = &rover.rover(&["status"])["status"];
    assert_eq!(ours["state"], last["state"]);
    assert_eq!(ours["task"], last["task"]);
    assert_eq!(ours["steps"], last["steps"]);
    assert_eq!(ours["direction"], last["direction_udeg"]);
    assert_eq!(ours["counters"], last["counters"]);
}

#[test]
fn it_disarms_on_ctrl_c_and_leaves_a_rover_alone_that_it_only_listens_to() {
    if !python() {
        return;
    }
    let rover = Rover::new();
    let mut client = rover.client(&["--learn"]);
    let mut lines = BufReader::new(client.0.stdout.take().unwrap()).lines();
    let begun = lines.any(|line| line.unwrap().contains("\"report\": \"Action\""));
    assert!(begun, "no action came");
    let pid = client.0.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    assert!(sent.success());
    let rest: Vec<_> = lines.map(Result::unwrap).collect();
    assert_eq!(client.end(), Some(130), "{rest:?}");
    let state = || rover.rover(&["status"])["status"]["state"].clone();
    assert_eq!(state(), "Disarmed");

    rover.rover(&["arm"]);
    let (lines, status) = rover.listen(&["--seconds", "1.5"]);
    assert_eq!(status, Some(0), "{lines:?}");
    assert_eq!(of_kind(&lines, "Status")[0]["state"], "Armed");
    assert_eq!(state(), "Armed");
}
