//! `rover` as a user types it, with a rover at the other end of a pseudo-terminal.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rover_boardless::BoardlessRover;
use rover_link::serial::SerialPort;
use rover_link::{Client, LinkError, PortError};
use rover_log::recorder::{RecordError, Recorder};
use rover_log::recording::{Recording, RecordingWriter, What};
use rover_log::replay;
use rover_log::replayable::Sessions;
use rover_shared::contract::{Mode, ResetReason, Task};
use rover_shared::time;
use rover_shared::wire::message::Command as Order;
use serde_json::Value;
use serialport::{SerialPort as _, TTYPort};

/// How long anything may take that is waited for.
const LIMIT: Duration = Duration::from_secs(60);

/// A rover behind a pseudo-terminal, in a thread of its own.
struct Cable {
    folder: tempfile::TempDir,
    orders: Option<Sender<Pull>>,
    answers: Receiver<()>,
    thread: Option<JoinHandle<()>>,
}

/// What is done to the cable or the rover.
enum Pull {
    Out,
    In,
    Reset,
}

impl Cable {
    /// Its time passes `speed` times as fast as ours.
    fn new(seed: u64, speed: u32) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("port");
        let (orders, taken) = channel();
        let (done, answers) = channel();
        let thread = std::thread::spawn(move || End::new(seed, path).run(speed, &taken, &done));
        let cable = Self {
            folder,
            orders: Some(orders),
            answers,
            thread: Some(thread),
        };
        cable.pull(Pull::In);
        cable
    }

    fn pull(&self, pull: Pull) {
        self.orders.as_ref().unwrap().send(pull).unwrap();
        self.answers.recv_timeout(LIMIT).unwrap();
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().into()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rover"));
        command.args(arguments).args(["--port", &self.path("port")]);
        command.current_dir(self.folder.path());
        command
    }

    fn rover(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.rover(&[arguments, &["--json"]].concat());
        assert!(
            output.status.success(),
            "{arguments:?}: {}",
            text(&output.stderr)
        );
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn fails(&self, arguments: &[&str], status: i32, words: &str) {
        let output = self.rover(arguments);
        let stderr = text(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{arguments:?}: {stderr}"
        );
        let last = stderr.lines().last().unwrap();
        assert!(
            last.contains(words),
            "{arguments:?}: no \"{words}\" in: {stderr}"
        );
    }

    fn state(&self) -> Value {
        self.json(&["status"])["status"]["state"].clone()
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        self.orders = None;
        let ended = self.thread.take().unwrap().join();
        if !std::thread::panicking() {
            ended.unwrap();
        }
    }
}

/// The rover's end.
struct End {
    path: PathBuf,
    rover: BoardlessRover,
    port: Option<TTYPort>,
    /// Whether somebody has the other end open.
    open: bool,
}

impl End {
    fn new(seed: u64, path: PathBuf) -> Self {
        Self {
            path,
            rover: BoardlessRover::in_empty_room(seed),
            port: None,
            open: false,
        }
    }

    fn run(mut self, speed: u32, orders: &Receiver<Pull>, done: &Sender<()>) {
        let mut last = Instant::now();
        loop {
            match orders.recv_timeout(Duration::from_millis(1)) {
                Ok(pull) => {
                    self.pull(&pull);
                    done.send(()).unwrap();
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            self.hear();
            let passed = last.elapsed() * speed;
            last = Instant::now();
            self.rover.run(time::Duration(passed.as_micros() as u64));
            self.say();
        }
    }

    fn pull(&mut self, pull: &Pull) {
        match pull {
            Pull::Out => {
                self.port = None;
                self.close();
                std::fs::remove_file(&self.path).unwrap();
            }
            Pull::In => {
                let (mut master, slave) = TTYPort::pair().unwrap();
                master.set_timeout(Duration::from_millis(1)).unwrap();
                symlink(slave.name().unwrap(), &self.path).unwrap();
                self.port = Some(master);
            }
            Pull::Reset => {
                self.rover.reset(ResetReason::Watchdog, 77);
                if self.open {
                    self.rover.open();
                }
            }
        }
    }

    fn close(&mut self) {
        if std::mem::take(&mut self.open) {
            self.rover.close();
        }
    }

    fn hear(&mut self) {
        let Some(port) = &mut self.port else {
            return;
        };
        let mut buffer = [0; 512];
        let heard = port.read(&mut buffer);
        match heard {
            Ok(length) => {
                self.open();
                self.rover.receive(&buffer[..length]);
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => self.open(),
            // The other end is closed.
            Err(_) => self.close(),
        }
    }

    fn open(&mut self) {
        if !std::mem::replace(&mut self.open, true) {
            self.rover.open();
        }
    }

    fn say(&mut self) {
        let mut buffer = [0; 1_024];
        while self.open
            && let Some(port) = &mut self.port
        {
            let length = self.rover.take_sent(&mut buffer);
            // What a host that went away does not take is lost, as on a cable.
            if length == 0 || port.write_all(&buffer[..length]).is_err() {
                break;
            }
        }
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Waits until something is so.
fn until(what: &str, so: impl Fn() -> bool) {
    let began = Instant::now();
    while !so() {
        assert!(began.elapsed() < LIMIT, "not within a minute: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn interrupt(child: &Child) {
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    assert!(sent.success());
}

fn length(path: &str) -> u64 {
    std::fs::metadata(path).map_or(0, |file| file.len())
}

#[test]
fn commands_do_what_they_say() {
    let cable = Cable::new(1, 1);
    let status = cable.json(&["status"]);
    assert_eq!(status["hello"]["board"], "boardless");
    assert_eq!(status["status"]["state"], "Disarmed");
    assert_eq!(status["status"]["heading"], 0);
    let shown = text(&cable.rover(&["status"]).stdout);
    assert!(
        shown.contains("front left") && shown.contains("disarmed, motors off"),
        "{shown}"
    );

    cable.fails(
        &["task", "follow", "90", "--mode", "run"],
        1,
        "`rover arm` first",
    );
    assert_eq!(cable.json(&["arm"])["state"], "Armed");
    assert_eq!(cable.json(&["disarm"])["state"], "Disarmed");
    assert_eq!(cable.state(), "Disarmed");
    let set = cable.json(&["task", "follow", "90"]);
    assert_eq!(set["direction"], -90_000_000, "east is to the right");

    cable.json(&["arm"]);
    let moved = cable.json(&["drive", "--left", "20", "--advance", "7"]);
    assert_eq!(moved["outcome"], "Completed");
    let heading = cable.json(&["status"])["status"]["heading"]
        .as_i64()
        .unwrap();
    assert!((heading - 20_000_000).abs() < 3_000_000, "{heading}");
    assert_eq!(cable.state(), "Disarmed");
    cable.fails(&["drive", "--right", "20"], 1, "`rover arm` first");
    let moved = cable.json(&["drive", "--arm", "--right", "20"]);
    assert_eq!(moved["outcome"], "Completed");
    assert_eq!(cable.state(), "Disarmed");
}

#[test]
fn wrong_use_is_told() {
    let cable = Cable::new(1, 1);
    cable.fails(&["task", "follow"], 2, "--help");
    cable.fails(&["task", "follow", "400"], 2, "--help");
    cable.fails(&["drive"], 2, "--help");
    cable.fails(&["drive", "--advance", "101"], 2, "--help");
    cable.fails(&["record", "--rotate", "5"], 2, "--help");
    let refused = ["record", "--mode", "learn", "--out", "refused.mcap"];
    cable.fails(&refused, 1, "give --arm");
    assert!(!std::path::Path::new(&cable.path("refused.mcap")).exists());
    cable.fails(
        &["calibrate", "range", "left", "500:40"],
        2,
        "expected 2 to 12",
    );
    cable.fails(
        &["calibrate", "range", "left", "500:40", "600:60"],
        1,
        "counts have to rise where distances fall",
    );
    cable.pull(Pull::Out);
    cable.fails(&["status"], 1, "no such port");
}

#[test]
fn knowledge_goes_there_and_back() {
    let cable = Cable::new(2, 40);
    cable.json(&["task", "wander", "--mode", "learn", "--arm", "--for", "1s"]);
    let pulled = cable.json(&["knowledge", "pull", "learned.rover"]);
    let shown = cable.json(&["knowledge", "show"]);
    assert_eq!(pulled["fingerprint"], shown["fingerprint"]);
    assert_eq!(cable.json(&["knowledge", "show", "learned.rover"]), shown);
    assert!(shown["patterns"].as_array().unwrap().len() > 1);
    assert_eq!(
        cable.json(&["knowledge", "diff", "learned.rover"])["equal"],
        true
    );

    cable.json(&["knowledge", "new"]);
    let difference = cable.json(&["knowledge", "diff", "learned.rover"]);
    assert_eq!(
        (&difference["equal"], &difference["same_parameters"]),
        (&false.into(), &true.into())
    );
    assert!(!difference["only_first"].as_array().unwrap().is_empty());
    cable.json(&["arm"]);
    cable.fails(
        &["knowledge", "push", "learned.rover"],
        1,
        "`rover disarm` first",
    );
    cable.json(&["disarm"]);
    assert_eq!(
        cable.json(&["knowledge", "push", "learned.rover"])["verified"],
        true
    );
    assert_eq!(
        cable.json(&["knowledge", "diff", "learned.rover"])["equal"],
        true
    );
    // It is in the flash, too.
    cable.pull(Pull::Reset);
    assert_eq!(
        cable.json(&["knowledge", "diff", "learned.rover"])["equal"],
        true
    );

    std::fs::write(cable.path("no.rover"), "nothing").unwrap();
    cable.fails(
        &["knowledge", "push", "no.rover"],
        1,
        "not a knowledge file",
    );
}

#[test]
fn calibrations_hold() {
    let cable = Cable::new(1, 1);
    let calibrated = cable.json(&["calibrate", "compass", "270"]);
    assert_eq!(calibrated["calibration"]["Compass"]["offset"], 90_000_000);
    assert_eq!(cable.json(&["status"])["status"]["heading"], 90_000_000);
    // Again, from another start: the offset is not added to the one before.
    cable.json(&["calibrate", "compass", "-10"]);
    assert_eq!(cable.json(&["status"])["status"]["heading"], 10_000_000);

    cable.json(&[
        "calibrate",
        "speed",
        "14.5",
        "--duty",
        "440",
        "--dead-band",
        "170",
    ]);
    cable.fails(
        &["calibrate", "speed", "14", "--dead-band", "2000"],
        1,
        "out of range",
    );

    // Nothing is in view: the distance is the last one of the curve.
    assert_eq!(cable.json(&["status"])["status"]["distances"][2], 800_000);
    let points = ["500:70", "900:40", "2900:12"];
    cable.json(&[&["calibrate", "range", "left"][..], &points].concat());
    assert_eq!(cable.json(&["status"])["status"]["distances"][2], 700_000);
}

#[test]
fn ctrl_c_disarms() {
    let cable = Cable::new(3, 1);
    for arguments in [
        &["task", "follow", "0", "--mode", "run", "--arm"][..],
        &["record", "--mode", "learn", "--arm", "--out", "drive.mcap"][..],
    ] {
        let mut child = cable
            .command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // It says so when a session begins.
        let mut stderr = child.stderr.take().unwrap();
        let mut heard = Vec::new();
        while !text(&heard).contains("a session begins") {
            let mut byte = [0];
            assert_eq!(stderr.read(&mut byte).unwrap(), 1, "{}", text(&heard));
            heard.push(byte[0]);
        }
        interrupt(&child);
        stderr.read_to_end(&mut heard).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", text(&heard));
        assert!(
            text(&output.stdout).contains("no frame lost"),
            "{}",
            text(&output.stdout)
        );
        assert_eq!(cable.state(), "Disarmed");
    }
    let files = [std::fs::read(cable.path("drive.mcap")).unwrap()];
    let log = Sessions::read(&files).unwrap();
    assert!(!log.cut_off && log.sessions.len() == 1);
    assert!(log.sessions[0].over);
}

#[test]
fn a_dashboard_that_loses_its_terminal_disarms_and_ends() {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let cable = Cable::new(3, 1);
    // Closed in the dashboard's process, or the terminal would last as long as that.
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let terminal = openpt(flags).unwrap();
    grantpt(&terminal).unwrap();
    unlockpt(&terminal).unwrap();
    let other = ptsname(&terminal, Vec::new()).unwrap();
    let mut terminal = std::fs::File::from(terminal);
    let end = || {
        let mut options = std::fs::File::options();
        let end = options.read(true).write(true).open(other.to_str().unwrap());
        Stdio::from(end.unwrap())
    };
    let size = ["rows", "40", "cols", "120"];
    let sized = Command::new("stty").args(size).stdin(end()).status();
    assert!(sized.unwrap().success());
    let mut child = cable
        .command(&["monitor"])
        .env("TERM", "xterm")
        .stdin(end())
        .stdout(end())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut screen = Vec::new();
    let mut shows = |words: &str, key: &str| {
        let began = Instant::now();
        let mut pressed = 0;
        while !text(&screen).contains(words) {
            assert!(began.elapsed() < LIMIT, "it does not show {words}");
            // Again, for arming is refused until the sensors are believed.
            if began.elapsed().as_secs() >= pressed {
                pressed += 1;
                terminal.write_all(key.as_bytes()).unwrap();
            }
            let mut bytes = [0; 4_096];
            // It draws all the time.
            let length = terminal.read(&mut bytes).unwrap();
            screen.extend(&bytes[..length]);
        }
    };
    shows("DISARMED", "");
    shows("done:", "a");
    shows("DRIVING", "l");
    drop(terminal);
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < LIMIT, "it goes on without a terminal");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(cable.state(), "Disarmed");
}

#[test]
fn a_recorded_drive_replays() {
    let cable = Cable::new(4, 40);
    let arguments = [
        "record", "--task", "wander", "--mode", "learn", "--arm", "--for", "3s",
    ];
    let recorded = cable.json(&arguments);
    assert_eq!(recorded["lost_frames"], 0);
    assert_eq!(recorded["files"][0], "rover-1.mcap");
    let actions = recorded["drive"]["actions"].as_u64().unwrap();
    assert!(actions > 40, "{recorded}");
    let log = cable.path("rover-1.mcap");
    let replayed = Command::new(env!("CARGO_BIN_EXE_rover"))
        .args(["replay", &log, "--verify", "--json"])
        .output()
        .unwrap();
    assert!(replayed.status.success(), "{}", text(&replayed.stderr));
    let replayed: Value = serde_json::from_slice(&replayed.stdout).unwrap();
    assert_eq!(replayed["complete"], true, "{replayed}");
    // The last action may have ended after the time was over.
    assert!(replayed["steps"].as_u64().unwrap() - actions <= 2);
    // Again, under the next name.
    assert_eq!(
        cable.json(&["record", "--for", "100ms"])["files"][0],
        "rover-2.mcap"
    );
}

#[test]
fn a_killed_recorder_leaves_what_it_wrote() {
    let cable = Cable::new(5, 40);
    let path = cable.path("drive.mcap");
    let mut child = cable
        .command(&[
            "record",
            "--task",
            "wander",
            "--mode",
            "learn",
            "--arm",
            "--out",
            "drive.mcap",
        ])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    until("three chunks are written", || length(&path) > 250_000);
    // SIGKILL: nothing is tidied up.
    child.kill().unwrap();
    child.wait().unwrap();
    let files = [std::fs::read(&path).unwrap()];
    let recording = Recording::read(&files).unwrap();
    assert!(recording.cut_off && recording.messages.len() > 100);
    let replayed = replay::verify_sessions(&Sessions::read(&files).unwrap()).unwrap();
    assert!(replayed.steps > 50, "{replayed:?}");
    assert_eq!(replayed.difference, None);
    // The rover drives on by itself, and can be stopped.
    assert_eq!(cable.state()["Driving"], "Learn");
    cable.json(&["disarm"]);
    assert_eq!(cable.state(), "Disarmed");
}

#[test]
fn a_busy_port_is_told() {
    let cable = Cable::new(1, 1);
    let port = SerialPort::named(&cable.path("port")).unwrap();
    let client = Client::open(Box::new(port)).unwrap();
    cable.fails(&["status"], 1, "another program uses it");
    drop(client);
    // A program that another test starts has this one's files, and with them the lock, for the moment
    // between its fork and its exec.
    let free = |_| cable.rover(&["status"]).status.success();
    assert!((0..100).any(free), "it is not free again");
}

/// Unplugs and plugs in, again and again, while a recording goes on; sometimes the rover loses its
/// power too.
fn unplug(cycles: u64) {
    let cable = Cable::new(6, 20);
    let port = SerialPort::named(&cable.path("port")).unwrap();
    let client = Client::open(Box::new(port)).unwrap();
    let path = PathBuf::from(cable.path("drive.mcap"));
    let log = RecordingWriter::create(&path, None, "test", client.epoch()).unwrap();
    let mut recorder = Recorder::begin(client, None, log).unwrap();
    let patience = time::Duration(LIMIT.as_micros() as u64);
    let began = Instant::now();
    for cycle in 0..cycles {
        let order = match cycle % 10 {
            0 => Order::SetTask(Task::FollowChangingDirection),
            1 => Order::Arm,
            2 => Order::SetMode(Mode::Learn),
            9 => Order::Disarm,
            _ => Order::Ping,
        };
        // A rover that was reset is not armed; what counts here is that it answers.
        match recorder.client().ask(&order) {
            Ok(()) | Err(LinkError::Refused { .. }) => {}
            Err(error) => panic!("cycle {cycle}: {error}"),
        }
        cable.pull(Pull::Out);
        let lost = loop {
            match recorder.next(time::Duration::from_millis(100)) {
                Ok(_) => assert!(began.elapsed() < LIMIT * 10, "the loss is never noticed"),
                Err(RecordError::Link(error)) => break error,
                Err(error) => panic!("cycle {cycle}: {error}"),
            }
        };
        assert!(
            matches!(lost, LinkError::Port(PortError::Lost(..))),
            "{lost}"
        );
        if cycle % 7 == 0 {
            cable.pull(Pull::Reset);
        }
        cable.pull(Pull::In);
        recorder.reconnect(&lost, patience, &|| false).unwrap();
    }
    let client = recorder.client();
    assert_eq!(client.counters().reconnected, cycles);
    assert_eq!(
        client.counters().lost,
        0,
        "within connections no frame is lost"
    );
    recorder.finish(|_| {}).unwrap();
    let files = [std::fs::read(&path).unwrap()];
    let recording = Recording::read(&files).unwrap();
    let gaps = recording
        .messages
        .iter()
        .filter(|m| matches!(m.what, What::Gap(_)));
    assert_eq!((gaps.count() as u64, recording.cut_off), (cycles, false));
    let replayed = replay::verify_sessions(&Sessions::read(&files).unwrap()).unwrap();
    assert_eq!(replayed.difference, None);
    eprintln!(
        "{cycles} times unplugged in {:.1} s: {} messages recorded",
        began.elapsed().as_secs_f64(),
        recording.messages.len()
    );
}

#[test]
fn unplugging_a_thousand_times_loses_no_recording() {
    unplug(1_000);
}

#[test]
fn ports_are_listed() {
    let listed = Command::new(env!("CARGO_BIN_EXE_rover"))
        .args(["ports", "--all", "--json"])
        .output()
        .unwrap();
    assert!(listed.status.success(), "{}", text(&listed.stderr));
    let listed: Value = serde_json::from_slice(&listed.stdout).unwrap();
    let ports = listed.as_array().unwrap();
    assert!(
        ports
            .iter()
            .all(|port| port["path"].is_string() && port["rover"].is_boolean())
    );
}

#[test]
fn no_port_is_left_behind() {
    let path = {
        let cable = Cable::new(1, 1);
        cable.path("port")
    };
    assert!(!Path::new(&path).exists());
}

#[test]
fn the_monitor_is_steered_by_typed_lines() {
    let cable = Cable::new(7, 20);
    let mut child = cable
        .command(&["monitor", "--plain", "--every", "0"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (heard, lines) = channel();
    let stdout = child.stdout.take().unwrap();
    let reader = std::thread::spawn(move || {
        for line in std::io::BufRead::lines(std::io::BufReader::new(stdout)) {
            if heard.send(line.unwrap()).is_err() {
                break;
            }
        }
    });
    let mut stdin = child.stdin.take().unwrap();
    for (typed, answer) in [
        ("", "connected to "),
        ("arm", "done: arm"),
        ("learn", "DRIVING (learn)"),
        ("status", " frames lost, "),
        ("", "DISARMED"),
    ] {
        if answer != "connected to " {
            writeln!(stdin, "{typed}").unwrap();
        }
        let mut few = (0..1_000).map(|_| lines.recv_timeout(LIMIT).unwrap());
        assert!(few.any(|line| line.contains(answer)), "no {answer}");
    }
    writeln!(stdin, "quit").unwrap();
    assert!(child.wait().unwrap().success());
    drop(lines);
    reader.join().unwrap();
    assert_eq!(cable.state(), "Disarmed");
}
