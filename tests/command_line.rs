//! `rover` as a user would type it: good use, bad use, and what is left behind.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn rover(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rover"))
        .args(arguments)
        .output()
        .expect("rover starts")
}

fn stdout(output: &Output) -> String {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout.clone()).expect("stdout is text")
}

fn json(output: &Output) -> Value {
    serde_json::from_str(&stdout(output)).expect("stdout is JSON")
}

/// Asserts that a command fails with this status, prints nothing on stdout, and says one sentence
/// with all of these words on stderr.
fn assert_fails(arguments: &[&str], status: i32, words: &[&str]) {
    let output = rover(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(status),
        "{arguments:?}: {stderr}"
    );
    assert_eq!(output.stdout, b"", "{arguments:?}");
    for word in words {
        assert!(
            stderr.contains(word),
            "{arguments:?}: no \"{word}\" in: {stderr}"
        );
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
    if status == 1 {
        assert_eq!(stderr.lines().count(), 1, "one sentence, not: {stderr}");
    }
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder for the test"))
    }

    fn path(&self, name: &str) -> String {
        self.0
            .path()
            .join(name)
            .to_str()
            .expect("the path is text")
            .into()
    }

    fn file(&self, name: &str, contents: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), contents).expect("the file can be written");
        self.path(name)
    }

    /// A few trials' learning into `out`.
    fn learned(&self, arguments: &[&str]) -> String {
        let out = self.path("out");
        let few: &[&str] = if arguments.contains(&"--trials") {
            &[]
        } else {
            &["--trials", "6"]
        };
        let fixed = ["learn", "--test-arenas", "5", "--out", &out];
        stdout(&rover(&[&fixed, few, arguments].concat()));
        out
    }
}

fn names(folder: impl AsRef<Path>) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder exists");
    let mut names: Vec<_> = entries
        .map(|entry| {
            entry
                .expect("it can be read")
                .file_name()
                .into_string()
                .expect("text")
        })
        .collect();
    names.sort();
    names
}

/// Recorded drives of real robots lie beside the repository, not in it.
fn recorded(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/data")
        .join(name);
    let found = path.exists();
    if !found {
        eprintln!("skipped: the recorded drive {} is not here", path.display());
    }
    found.then_some(path)
}

#[test]
fn learning_writes_knowledge_and_a_log_that_verifies() {
    let folder = Folder::new();
    let out = folder.learned(&[]);
    let written = names(&out);
    assert!(written.contains(&"knowledge.rover".into()) && written.contains(&"learn.mcap".into()));
    let log = format!("{out}/learn.mcap");
    let text = stdout(&rover(&["replay", &log, "--verify"]));
    assert!(text.contains("equal, bit by bit"), "{text}");
}

#[test]
fn the_same_seed_learns_the_same() {
    let (a, b) = (Folder::new(), Folder::new());
    let read = |out: String| std::fs::read(format!("{out}/knowledge.rover")).expect("written");
    let first = read(a.learned(&["--seed", "7"]));
    assert!(first == read(b.learned(&["--seed", "7"])));
    assert!(first != read(b.learned(&["--seed", "8"])));
}

#[test]
fn several_sessions_are_numbered() {
    let folder = Folder::new();
    let out = folder.learned(&["--sessions", "3"]);
    for k in 1..=3 {
        assert!(
            names(&out).contains(&format!("knowledge-{k}.rover")),
            "{:?}",
            names(&out)
        );
    }
    // The k-th session is the one that its seed gives alone.
    let alone = Folder::new().learned_file(&["--seed", "3"]);
    assert!(std::fs::read(format!("{out}/knowledge-3.rover")).expect("written") == alone);
}

impl Folder {
    fn learned_file(&self, arguments: &[&str]) -> Vec<u8> {
        let out = self.learned(arguments);
        std::fs::read(format!("{out}/knowledge.rover")).expect("written")
    }
}

#[test]
fn a_test_has_all_its_measures_with_intervals() {
    let folder = Folder::new();
    let knowledge = format!("{}/knowledge.rover", folder.learned(&[]));
    let result = json(&rover(&[
        "test",
        "--knowledge",
        &knowledge,
        "--arenas",
        "20",
        "--json",
    ]));
    assert_eq!(result["arenas"], 20);
    for name in ["reached", "clean", "directedness", "steps"] {
        let [low, value, high] =
            ["low", "value", "high"].map(|part| result[name][part].as_f64().expect(name));
        assert!(low <= value && value <= high, "{name}: {result}");
    }
}

#[test]
fn the_hand_written_rule_drives_better_than_chance() {
    let reached = |controller: &str| {
        let output = rover(&[
            "test",
            "--controller",
            controller,
            "--arenas",
            "60",
            "--json",
        ]);
        json(&output)["reached"]["value"]
            .as_f64()
            .expect("a number")
    };
    assert!(reached("reactive") > 0.95);
    assert!(reached("vfh") > 0.95);
    assert!(reached("random") < 0.35);
    assert!(reached("q-learning") > 0.85);
}

#[test]
fn one_pattern_is_drawn_and_coded() {
    let text = stdout(&rover(&["perceive", "--corners", "1,1,1,-1"]));
    assert!(text.contains("code 12703"), "{text}");
    let reference = json(&rover(&[
        "perceive",
        "--corners",
        "-1,1,1,1",
        "--engine",
        "reference",
        "--json",
    ]));
    assert_eq!(reference["code"], 63884);
}

#[test]
fn a_table_of_starts_becomes_a_table_of_codes() {
    let folder = Folder::new();
    let header = "f,l,r,t,".to_owned()
        + &(0..16)
            .map(|i| format!("n{i}"))
            .collect::<Vec<_>>()
            .join(",");
    let noise = ["0.001"; 16].join(",");
    let table = folder.file(
        "starts.csv",
        format!("{header}\n1,1,1,-1,{noise}\n-2,1.5,1,1,{noise}\n"),
    );
    let text = stdout(&rover(&["perceive", "--from", &table]));
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], format!("{header},code,settle_time"));
    let codes: Vec<_> = lines[1..]
        .iter()
        .map(|l| l.split(',').nth(20).expect("code"))
        .collect();
    assert_eq!(codes, ["12703", "63884"]);
}

/// A file of the repository's own.
fn example(name: &str) -> String {
    format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The drives in `tests/data` were driven in the simulator, with the columns of real logs.
#[test]
fn drives_run_through_the_core() {
    let folder = Folder::new();
    let knowledge = format!(
        "{}/knowledge.rover",
        folder.learned(&["--task", "direction", "--steps", "200"])
    );
    let drive = example("drive.csv");
    let rows = std::fs::read_to_string(&drive)
        .expect("it is there")
        .lines()
        .count()
        - 1;
    let report = json(&rover(&[
        "replay",
        &drive,
        "--knowledge",
        &knowledge,
        "--json",
    ]));
    assert_eq!(report["sample_count"], rows);
    let counts = report["codes"].as_array().expect("a list").iter();
    let counted: u64 = counts
        .map(|code| code["count"].as_u64().expect("a number"))
        .sum();
    assert_eq!(
        counted + report["unsettled"].as_u64().expect("a number"),
        rows as u64
    );
    assert!(report["codes"].as_array().expect("a list").len() > 1);
    for name in [
        "flicker",
        "flicker_within_steps",
        "unseen_codes",
        "unseen_samples",
    ] {
        assert!(report[name].is_number(), "{name}: {report}");
    }
    let again = rover(&["replay", &drive, "--knowledge", &knowledge, "--json"]);
    assert_eq!(report, json(&again), "the same seed gives the same report");

    let other = example("other-columns.csv");
    let table = folder.path("samples.csv");
    let columns = "front=front_m,left=left_m,right=right_m";
    let text = stdout(&rover(&[
        "replay",
        &other,
        "--columns",
        columns,
        "--knowledge",
        &knowledge,
        "--out",
        &table,
    ]));
    assert!(text.contains("no headings"), "{text}");
    let lines = |path: &str| {
        std::fs::read_to_string(path)
            .expect("it is there")
            .lines()
            .count()
    };
    assert_eq!(lines(&table), lines(&other));
    assert_fails(
        &["replay", &other, "--knowledge", &knowledge],
        1,
        &["line 1", "front_left_cm", "is missing", "--columns"],
    );
    let nowhere = folder.path("no/such/folder/samples.csv");
    assert_fails(
        &[
            "replay",
            &drive,
            "--knowledge",
            &knowledge,
            "--out",
            &nowhere,
        ],
        1,
        &["samples.csv", "cannot be written"],
    );
}

#[test]
fn recorded_drives_run_through_the_core() {
    let folder = Folder::new();
    let knowledge = format!(
        "{}/knowledge.rover",
        folder.learned(&["--task", "direction", "--steps", "200"])
    );
    if let Some(drive) = recorded("intel-lab-drive.csv") {
        let drive = drive.to_str().expect("text");
        let report = json(&rover(&[
            "replay",
            drive,
            "--knowledge",
            &knowledge,
            "--json",
        ]));
        assert_eq!(report["sample_count"], 910);
        let counted: u64 = report["codes"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|code| code["count"].as_u64().expect("a number"))
            .sum();
        assert_eq!(
            counted + report["unsettled"].as_u64().expect("a number"),
            910
        );
    }
    if let Some(drive) = recorded("scitos-wall-following.csv") {
        let drive = drive.to_str().expect("text");
        let table = folder.path("samples.csv");
        let columns = "front=front_m,left=left_m,right=right_m";
        let text = stdout(&rover(&[
            "replay",
            drive,
            "--columns",
            columns,
            "--knowledge",
            &knowledge,
            "--out",
            &table,
        ]));
        assert!(
            text.contains("5456 samples") && text.contains("no headings"),
            "{text}"
        );
        assert_eq!(
            std::fs::read_to_string(table)
                .expect("written")
                .lines()
                .count(),
            5457
        );
        assert_fails(
            &["replay", drive, "--knowledge", &knowledge],
            1,
            &["front_left_cm", "is missing", "--columns"],
        );
    }
}

#[test]
fn damaged_knowledge_is_refused() {
    let folder = Folder::new();
    let good = folder.learned_file(&[]);
    let refuse = |name: &str, bytes: &[u8], words: &[&str]| {
        let file = folder.file(name, bytes);
        let words: Vec<&str> = [words, &[name]].concat();
        assert_fails(&["test", "--knowledge", &file], 1, &words);
    };
    refuse("magic", b"no knowledge at all", &["TRVK"]);
    refuse("empty", b"", &["TRVK"]);
    refuse("short", &good[..good.len() - 9], &["cut short"]);
    let changed = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 0x11;
        bytes
    };
    refuse("version", &changed(4), &["version"]);
    refuse("crc", &changed(300), &["checksum"]);
    assert_fails(
        &["test", "--knowledge", "/no/such/file"],
        1,
        &["/no/such/file", "cannot be read"],
    );
}

#[test]
fn damaged_logs_are_refused_with_the_place() {
    let folder = Folder::new();
    let out = folder.learned(&[]);
    let good = std::fs::read(format!("{out}/learn.mcap")).expect("written");
    let mut changed = good.clone();
    let middle = changed.len() / 3;
    changed[middle] ^= 1;
    let changed = folder.file("changed.mcap", changed);
    assert_fails(&["replay", &changed, "--verify"], 1, &["changed.mcap"]);
    let longer = folder.learned(&["--trials", "40"]);
    let good = std::fs::read(format!("{longer}/learn.mcap")).expect("written");
    let cut = folder.file("cut.mcap", &good[..good.len() * 9 / 10]);
    let output = rover(&["replay", &cut, "--verify", "--json"]);
    let replayed = json(&output);
    assert_eq!(
        (&replayed["complete"], &replayed["difference"]),
        (&false.into(), &Value::Null)
    );
    assert!(replayed["steps"].as_u64().expect("a number") > 0);
    assert!(String::from_utf8_lossy(&output.stderr).contains("cut off"));
}

#[test]
fn bad_tables_are_refused_with_file_line_and_expectation() {
    let folder = Folder::new();
    let knowledge = format!("{}/knowledge.rover", folder.learned(&[]));
    let header = "t_s,front_left_cm,front_right_cm,left_cm,right_cm,heading_deg";
    for (row, words) in [
        ("0,NaN,1,1,1,0", ["line 3", "NaN"]),
        ("0,-5,1,1,1,0", ["line 3", "a distance from 0"]),
        ("0,1,1,1e12,1,0", ["line 3", "left_cm"]),
        ("0,1,1,1,1,400", ["line 3", "0 to 360"]),
    ] {
        let file = folder.file("drive.csv", format!("{header}\n0,1,1,1,1,0\n{row}\n"));
        assert_fails(&["replay", &file, "--knowledge", &knowledge], 1, &words);
    }
    let file = folder.file("starts.csv", "f,l,r\n1,1,1\n");
    assert_fails(
        &["perceive", "--from", &file],
        1,
        &["starts.csv", "line 1", "t, n0"],
    );
}

#[test]
fn bad_arenas_are_refused() {
    let folder = Folder::new();
    let out = folder.path("out");
    let arena = |text: &str| folder.file("arena.toml", text);
    let learn = |file: &str, words: &[&str]| {
        assert_fails(&["learn", "--arena", file, "--out", &out], 1, words);
        assert!(!Path::new(&out).exists(), "something was left behind");
    };
    learn(&arena("width_cm = 100\n"), &["arena.toml", "height_cm"]);
    learn(
        &arena("width_cm = 200\nheight_cm = 200\ncolour = 'red'\n"),
        &["arena.toml", "line 3", "colour"],
    );
    learn(
        &arena(
            "width_cm = 200\nheight_cm = 200\nstart = { x_cm = 30, y_cm = 30, heading_deg = 0 }\n\
             goal = { x_cm = 150, y_cm = 150, radius_cm = 10 }\n\
             [[rect]]\nx_cm = 140\ny_cm = 140\nw_cm = 20\nh_cm = 20\n",
        ),
        &["arena.toml", "goal"],
    );
    learn("nowhere.toml", &["nowhere.toml"]);
    learn("mars", &["mars"]);
}

#[test]
fn parameters_without_turing_patterns_are_refused() {
    let folder = Folder::new();
    let out = folder.path("out");
    let learn = |text: &str, words: &[&str]| {
        let file = folder.file("parameters.toml", text);
        let words: Vec<&str> = [words, &["parameters.toml"]].concat();
        assert_fails(&["learn", "--parameters", &file, "--out", &out], 1, &words);
        assert!(!Path::new(&out).exists(), "something was left behind");
    };
    learn("[lattice]\nmu = 0.1\n", &["line 1", "mu"]);
    learn("[lattice]\nd2 = 0.05\n", &["eq. 2"]);
    learn(
        "[learning]\nrate = 2\n",
        &["line 2", "learning.rate", "0 to 1"],
    );
    learn("[learning]\nspeed = 2\n", &["line 2", "speed"]);
}

#[test]
fn places_that_cannot_be_written_are_refused_before_learning() {
    let folder = Folder::new();
    let file = folder.file("a-file", "");
    let inside = format!("{file}/out");
    assert_fails(
        &["learn", "--out", &inside],
        1,
        &["a-file", "cannot be written", "choose another place"],
    );
    assert_eq!(names(folder.0.path()), ["a-file"]);
}

#[test]
fn figures_do_not_mix_tasks() {
    let (aiming, following) = (Folder::new(), Folder::new());
    let aimed = format!("{}/learn.mcap", aiming.learned(&[]));
    let followed = format!("{}/learn.mcap", following.learned(&["--task", "direction"]));
    let out = aiming.path("figures");
    let figures = ["figures", &aimed, &followed, "--out", &out];
    assert_fails(&figures, 1, &[&followed, "draw them apart"]);
    assert!(!Path::new(&out).exists());
}

#[test]
fn knowledge_of_another_robot_is_refused() {
    let folder = Folder::new();
    let knowledge = format!("{}/knowledge.rover", folder.learned(&[]));
    assert_fails(
        &[
            "test",
            "--knowledge",
            &knowledge,
            "--arena",
            "rover",
            "--task",
            "direction",
        ],
        1,
        &["0 to 40 cm", "14 to 64 cm", "learn with --arena rover"],
    );
}

#[test]
fn wrong_usage_has_status_2() {
    assert_fails(&["test"], 2, &["--knowledge", "rover learn"]);
    assert_fails(&["learn", "--sessions", "0"], 2, &["sessions"]);
    assert_fails(&["learn", "--task", "sing"], 2, &["target", "direction"]);
    assert_fails(
        &["perceive", "--corners", "1,2,3"],
        2,
        &["3 values", "expected 4"],
    );
    assert_fails(
        &["perceive", "--corners", "1,2,3,400"],
        2,
        &["400", "-40 to 40"],
    );
    assert_fails(&["perceive", "--corners", "1,2,3,NaN"], 2, &["NaN"]);
    assert_fails(&["replay", "drive.txt"], 2, &[".mcap or .csv"]);
    assert_fails(&["replay", "drive.csv"], 2, &["--knowledge"]);
    assert_fails(
        &["learn", "--arena", "rover"],
        2,
        &["rover", "no target", "--task direction"],
    );
    assert_fails(&["dance"], 2, &["dance"]);
}

#[test]
fn every_command_has_help() {
    for command in ["learn", "test", "perceive", "replay"] {
        let text = stdout(&rover(&[command, "--help"]));
        assert!(text.contains("Usage: rover"), "{text}");
    }
}

/// The commands that `rover --help` names.
fn commands() -> Vec<String> {
    let help = stdout(&rover(&["--help"]));
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    listed
        .take_while(|line| !line.is_empty())
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .map(String::from)
        .collect()
}

#[test]
fn shells_complete_every_command() {
    let commands = commands();
    assert!(commands.len() > 10, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = stdout(&rover(&["completions", shell]));
        for command in &commands {
            assert!(script.contains(command), "{shell}: no {command}");
        }
    }
    assert_fails(&["completions", "tcsh"], 2, &["possible values", "bash"]);
}

#[test]
fn bash_takes_the_script_and_completes_by_it() {
    let Ok(bash) = Command::new("bash").arg("--version").output() else {
        return eprintln!("there is no bash here");
    };
    assert!(bash.status.success());
    let folder = Folder::new();
    let script = folder.file("rover.bash", rover(&["completions", "bash"]).stdout);
    let typed =
        "COMP_WORDS=(rover mon); COMP_CWORD=1; _rover rover mon rover; echo ${COMPREPLY[@]}";
    let completed = Command::new("bash")
        .args(["-c", &format!("source {script}; {typed}")])
        .output()
        .expect("bash starts");
    assert_eq!(stdout(&completed).trim(), "monitor");
}

#[test]
fn there_is_a_manual_page_for_every_command() {
    let first = stdout(&rover(&["man"]));
    assert!(first.contains(".TH rover 1"), "{first}");
    let folder = Folder::new();
    let out = folder.path("man/man1");
    stdout(&rover(&["man", "--out", &out]));
    for command in commands() {
        let page = std::fs::read_to_string(format!("{out}/rover-{command}.1"));
        let page = page.unwrap_or_else(|error| panic!("rover-{command}.1: {error}"));
        assert!(page.contains("SYNOPSIS"), "{page}");
    }
    let nested = std::fs::read_to_string(format!("{out}/rover-knowledge-pull.1"));
    assert!(nested.is_ok(), "commands of commands have pages too");
    let file = folder.file("file", "");
    assert_fails(&["man", "--out", &file], 1, &["cannot be written"]);
}

#[test]
fn a_monitor_without_a_terminal_tells_a_log_in_lines() {
    let folder = Folder::new();
    let out = folder.learned(&[]);
    let log = format!("{out}/learn.mcap");
    let plain = stdout(&rover(&["monitor", &log]));
    assert!(plain.contains("trial 6 ended"), "{plain}");
    assert!(!plain.contains('\u{1b}'));
    for line in stdout(&rover(&["monitor", "--json", &log])).lines() {
        let _: Value = serde_json::from_str(line).expect("each line is JSON");
    }
    let nothing = folder.path("nothing.mcap");
    assert_fails(&["monitor", &nothing], 1, &["cannot be read"]);
    let text = folder.file("text.mcap", "text");
    assert_fails(&["monitor", &text], 1, &["not an MCAP file"]);
    assert_fails(&["monitor", "--every=-1"], 2, &["expected seconds"]);
}
