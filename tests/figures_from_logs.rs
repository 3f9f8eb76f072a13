//! Figures and report drawn from logs: they hold the numbers of the log and nothing else.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::process::Command;

use rover_figure::{Figures, LoggedSession, Moment, first_trial, of_recordings};
use rover_log::knowledge;
use rover_log::{Entry, Log, LogWriter, Origin};
use rover_shared::learning::Mode;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::{Noise, PatternCode};
use rover_shared::sensing::neuron::Activation;
use rover_simulator::arena::{ArenaSource, Layout, Motion};
use rover_simulator::experiment::{Known, LearnedSession, SessionPlan, learn};
use roxmltree::{Document, Node, ParsingOptions};

/// A session, and the file of its log.
struct Logged {
    plan: SessionPlan,
    coefficients: Coefficients,
    session: LearnedSession,
    file: Vec<u8>,
}

impl Logged {
    fn new(plan: SessionPlan, parameters: &Parameters) -> Self {
        let coefficients = Coefficients::new(parameters).unwrap();
        let nothing = Known::new(&coefficients.learning);
        let before = knowledge::to_bytes(&nothing, parameters);
        let origin = Origin {
            seed: plan.seed,
            mode: Mode::Learn,
            writer: "test".into(),
        };
        let mut log = LogWriter::new(Cursor::new(Vec::new()), &origin, &before).unwrap();
        let session = learn(&plan, &coefficients, &mut log, |_| {});
        let after = knowledge::to_bytes(&session.knowledge, parameters);
        let file = log.finish(&after).unwrap().into_inner();
        Self {
            plan,
            coefficients,
            session,
            file,
        }
    }

    fn aiming(seed: u64) -> Self {
        let plan = SessionPlan {
            seed,
            trials: 60,
            steps: 300,
            follow_direction: false,
            arenas: ArenaSource::from(Layout::paper()),
        };
        Self::new(plan, &Parameters::PAPER)
    }

    fn following(seed: u64) -> Self {
        let plan = SessionPlan {
            seed,
            trials: 6,
            steps: 250,
            follow_direction: true,
            arenas: ArenaSource::from(Layout::rover(500.0, 3, 10.0)),
        };
        Self::new(plan, &Parameters::ROVER)
    }

    fn log(&self) -> Log {
        Log::read(&self.file).unwrap()
    }

    fn recording(&self) -> LoggedSession {
        LoggedSession::new(&self.log()).unwrap()
    }
}

fn drawn(recordings: Vec<LoggedSession>, moment: Moment) -> Figures {
    let names = (1..).map(|i| format!("log-{i}.mcap"));
    let named: Vec<_> = names.zip(recordings).collect();
    of_recordings(&named, moment).unwrap()
}

fn svg<'a>(figures: &'a Figures, name: &str) -> &'a str {
    let found = figures.figures.iter().find(|figure| figure.name == name);
    &found.expect(name).svg
}

fn of_class<'a, 'i>(document: &'a Document<'i>, class: &str) -> Vec<Node<'a, 'i>> {
    let all = document.descendants();
    all.filter(|node| node.attribute("class") == Some(class))
        .collect()
}

fn texts<'a>(node: Node<'a, '_>) -> Vec<&'a str> {
    let texts = node.descendants().filter(|node| node.has_tag_name("text"));
    texts
        .filter_map(|text| text.text())
        .map(str::trim)
        .collect()
}

/// A number as figures write it.
fn written(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").replace('-', "\u{2212}")
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-3, "{a} is not {b}");
}

#[test]
fn a_log_gives_back_the_drives_of_its_session() {
    for logged in [Logged::aiming(31), Logged::following(32)] {
        let recording = logged.recording();
        assert_eq!(recording.drives.len(), logged.session.trials.len());
        assert_eq!(recording.follows_direction(), logged.plan.follow_direction);
        assert!(!recording.cut_off && recording.learning);
        for (drive, trial) in recording.drives.iter().zip(&logged.session.trials) {
            assert!(drive.arena_known);
            assert_eq!(drive.trial.ending, trial.ending);
            assert_eq!(drive.trial.steps, trial.steps);
            assert_eq!(drive.events.len() as u32, trial.steps);
            assert_eq!(drive.trial.collisions, trial.collisions);
            close(drive.end.x, trial.end_cm[0]);
            close(drive.end.y, trial.end_cm[1]);
            for (drawn, measured) in [
                (drive.trial.directedness, trial.directedness),
                (drive.trial.path_ratio, trial.path_ratio),
                (drive.trial.free_angle_deg, trial.free_angle_deg),
            ] {
                assert_eq!(drawn.is_some(), measured.is_some());
                close(drawn.unwrap_or(0.0), measured.unwrap_or(0.0));
            }
        }
        let first = first_trial(&logged.plan, &logged.coefficients).unwrap();
        let read = &recording.drives[0];
        assert_eq!(read.scenario.start.heading, first.scenario.start.heading);
        assert_eq!(read.scenario.goal.is_some(), first.scenario.goal.is_some());
        let (robot, driven) = (&read.scenario.robot, &first.scenario.robot);
        assert_eq!(robot.step_cm, driven.step_cm);
        assert_eq!(robot.sensors.len(), driven.sensors.len());
        for (a, b) in robot.sensors.iter().zip(&driven.sensors) {
            assert_eq!(
                (a.side, a.axis_deg, a.max_cm),
                (b.side, b.axis_deg, b.max_cm)
            );
            close(a.mount_cm[0], b.mount_cm[0]);
            close(a.mount_cm[1], b.mount_cm[1]);
        }
        let outlines = |drive: &rover_figure::Drive| {
            let obstacles = drive.scenario.world.obstacles().iter();
            obstacles.map(|o| o.bounds_cm()).collect::<Vec<_>>()
        };
        for (a, b) in outlines(read).iter().zip(&outlines(&first)) {
            for (a, b) in a.iter().zip(b) {
                close(a.x, b.x);
                close(a.y, b.y);
            }
        }
        for (a, b) in read.events.iter().zip(&first.events) {
            assert_eq!((a.sample, a.record), (b.sample, b.record));
        }
    }
}

/// The staircases told from the logged changes are those that the core had at every action.
#[test]
fn the_history_of_staircases_explains_every_percept() {
    for logged in [Logged::aiming(41), Logged::following(42)] {
        let recording = logged.recording();
        let mut checked = 0;
        for drive in &recording.drives {
            for (i, event) in drive.events.iter().enumerate().step_by(7) {
                let (sensed, perceived) = (event.record.sensed, event.record.perceived);
                let (sensed, perceived) = (sensed.unwrap(), perceived.unwrap());
                let neurons = recording.history.at(drive.first_action + i as u64);
                let steps = sensed.percept.steps();
                for ((neuron, step), corner) in neurons.iter().zip(steps).zip(perceived.corners.0) {
                    assert_eq!(neuron.output(step), Activation(corner), "action {i}");
                }
                checked += 1;
            }
        }
        assert!(checked > 100, "{checked} percepts");
        assert_eq!(
            recording.history.at(u64::MAX),
            logged.session.knowledge.sensing.neurons
        );
        assert_eq!(
            logged.session.history.changes(),
            recording.history.changes()
        );
    }
}

#[test]
fn one_place_is_drawn_with_the_numbers_of_the_log() {
    let logged = Logged::aiming(51);
    let log = logged.log();
    let (trial, at) = (40, 6);
    let steps: Vec<_> = log
        .entries
        .iter()
        .filter_map(|entry| match entry {
            Entry::Step(step) if step.trial == trial => Some(step),
            _ => None,
        })
        .collect();
    let moment = Moment {
        trial: Some(trial),
        at: Some(at),
    };
    let figures = drawn(vec![logged.recording()], moment);
    let document = Document::parse(svg(&figures, "position.svg")).unwrap();

    let step = steps[at];
    let perceived = step.record.perceived.unwrap();
    let percept = step.record.sensed.unwrap().percept;
    let panels = of_class(&document, "staircase");
    assert_eq!(panels.len(), 4);
    for ((panel, corner), step) in panels.iter().zip(perceived.corners.0).zip(percept.steps()) {
        let amplitude = written(f64::from(corner) / f64::from(Activation::ONE), 2);
        let says = format!(": step {}, {amplitude}", step.index() + 1);
        let texts = texts(*panel);
        assert!(
            texts.iter().any(|text| text.ends_with(&says)),
            "{says} of {texts:?}"
        );
        // The bold step stands over its place: each is a tenth of the panel's width.
        let mut inside = panel.descendants();
        let bold = inside.find(|node| node.attribute("class") == Some("active"));
        let x = |name| {
            bold.unwrap()
                .attribute(name)
                .unwrap()
                .parse::<f64>()
                .unwrap()
        };
        let width = x("x2") - x("x1");
        assert!((width - 17.6).abs() < 0.2, "{width}");
        let left = x("x1") - 17.6 * step.index() as f64;
        assert!(
            [60.0, 300.0, 540.0, 780.0]
                .iter()
                .any(|l| (left - l).abs() < 0.2),
            "{left}"
        );
    }
    let turn = f64::from(step.record.action.phase.0) / 1e6;
    let side = if turn < 0.0 { "right" } else { "left" };
    let says = format!(
        "pattern {}, turn of {:.1}° to the {side}",
        perceived.code,
        turn.abs()
    );
    let all = texts(document.root_element());
    assert!(all.contains(&says.as_str()), "{says} of {all:?}");
    let subtitle = format!("trial {trial}, after {at} actions");
    assert!(all.iter().any(|text| text.contains(&subtitle)));
}

#[test]
fn patterns_are_counted_in_the_last_trials_of_the_log() {
    let logged = Logged::aiming(61);
    let mut counts = BTreeMap::<PatternCode, usize>::new();
    let mut actions = 0;
    for entry in &logged.log().entries {
        if let Entry::Step(step) = entry
            && step.trial > 30
        {
            *counts
                .entry(step.record.perceived.unwrap().code)
                .or_default() += 1;
            actions += 1;
        }
    }
    let figures = drawn(vec![logged.recording()], Moment::default());
    let document = Document::parse(svg(&figures, "patterns.svg")).unwrap();
    let all = texts(document.root_element());
    let total = format!("{actions} actions, {} patterns", counts.len());
    assert!(
        all.iter().any(|text| text.starts_with(&total)),
        "{total} of {all:?}"
    );
    let bars = texts(of_class(&document, "panel")[0]);
    let turns = texts(of_class(&document, "panel")[1]);
    let columns = of_class(&document, "column");
    assert!(columns.len() >= 15, "{} columns", columns.len());
    for column in columns {
        let code = PatternCode(texts(column)[0].parse().unwrap());
        assert!(bars.contains(&counts[&code].to_string().as_str()), "{code}");
        let element = logged.session.knowledge.patterns.get(code).unwrap();
        let turn = written(f64::from(element.memory.phase.0) / 1e6, 1);
        assert!(
            turns.contains(&turn.as_str()),
            "{code}: {turn} of {turns:?}"
        );
    }
}

#[test]
fn patterns_grow_as_the_core_lets_them() {
    let logged = Logged::aiming(71);
    let recording = logged.recording();
    let figures = drawn(vec![recording.clone()], Moment::default());
    let document = Document::parse(svg(&figures, "lattice.svg")).unwrap();
    let rows = of_class(&document, "panel");
    assert_eq!(rows.len(), 4);
    for row in rows {
        let all = texts(row);
        let code = all
            .iter()
            .find_map(|text| text.strip_prefix("code "))
            .unwrap();
        let code = PatternCode(code.parse().unwrap());
        // Some percept of the last trials grows into it, in the time that is shown.
        let events = recording.drives[30..]
            .iter()
            .flat_map(|drive| &drive.events);
        let grown = events
            .filter_map(|event| event.record.perceived)
            .filter(|perceived| perceived.code == code)
            .find_map(|perceived| {
                let lattice = &recording.coefficients.lattice;
                let settled = lattice.settle(&perceived.corners, &Noise::default()).ok()?;
                (settled.code == code).then_some(settled)
            })
            .unwrap();
        let time = format!("t = {}", written(grown.time.thousandths() as f64 / 1e3, 2));
        assert!(all.contains(&time.as_str()), "{time} of {all:?}");
        // Five states with 16 cells and a frame each; the drawing of the pattern is apart.
        let cells: Vec<_> = row
            .descendants()
            .filter(|node| node.attribute("class") == Some("cells"))
            .collect();
        assert_eq!(cells.len(), 5);
        for state in cells {
            let shades = state.children().filter(|node| node.has_tag_name("rect"));
            assert_eq!(shades.count(), 17);
        }
    }
}

#[test]
fn several_logs_share_the_learning_curves() {
    let logs: Vec<Logged> = (81..84).map(Logged::aiming).collect();
    let recordings: Vec<LoggedSession> = logs.iter().map(Logged::recording).collect();
    let mut cut = recordings.clone();
    cut[1].drives.truncate(2);
    let figures = drawn(cut, Moment::default());
    assert!(svg(&figures, "learning.svg").contains("fewer from trial 3 on"));
    let figures = drawn(recordings, Moment::default());
    let document = Document::parse(svg(&figures, "learning.svg")).unwrap();
    let legend = texts(of_class(&document, "legend")[0]).join(" ");
    assert!(legend.contains("median of 3 sessions"), "{legend}");
    assert!(!legend.contains("fewer"), "{legend}");
    // Directedness of the three first trials: the description begins with their median.
    let mut first: Vec<f64> = logs
        .iter()
        .map(|log| log.session.trials[0].directedness.unwrap())
        .collect();
    first.sort_by(f64::total_cmp);
    let says = format!("Directedness (8): {} at first", written(first[1], 2));
    let description = document
        .descendants()
        .find(|node| node.has_tag_name("desc"))
        .and_then(|node| node.text())
        .unwrap();
    assert!(description.contains(&says), "{says} of {description}");
}

/// A rover on a floor logs neither poses nor arenas: compass and moves have to do.
#[test]
fn without_poses_the_way_is_reckoned_from_compass_and_moves() {
    for logged in [Logged::aiming(91), Logged::following(92)] {
        let mut log = logged.log();
        log.arenas.clear();
        for entry in &mut log.entries {
            if let Entry::Step(step) = entry {
                step.pose = None;
            }
        }
        let (known, reckoned) = (logged.recording(), LoggedSession::new(&log).unwrap());
        for (known, reckoned) in known.drives.iter().zip(&reckoned.drives) {
            assert!(!reckoned.arena_known);
            let from = reckoned.scenario.start.position() - known.scenario.start.position();
            for (a, b) in known.positions().iter().zip(reckoned.positions()) {
                close(a.x + from.x, b.x);
                close(a.y + from.y, b.y);
            }
        }
        let figures = drawn(vec![reckoned], Moment::default());
        let trajectories = figures
            .figures
            .iter()
            .find(|f| f.name == "trajectories.svg")
            .unwrap();
        assert!(trajectories.caption.contains("dead reckoning"));
        for figure in &figures.figures {
            Document::parse(&figure.svg).unwrap_or_else(|e| panic!("{}: {e}", figure.name));
        }
    }
}

#[test]
fn a_log_that_was_cut_off_is_drawn_up_to_the_cut() {
    let logged = Logged::aiming(101);
    let log = Log::read(&logged.file[..logged.file.len() * 2 / 3]).unwrap();
    assert!(log.cut_off);
    let recording = LoggedSession::new(&log).unwrap();
    assert!(recording.cut_off);
    assert_eq!(*recording.lessons.neurons(), recording.history.at(u64::MAX));
    let figures = drawn(vec![recording], Moment::default());
    assert_eq!(figures.figures.len(), 9);
    assert!(figures.report.contains("cut off"));
}

#[test]
fn a_log_without_actions_is_refused() {
    let mut log = Logged::aiming(111).log();
    log.entries.clear();
    let error = LoggedSession::new(&log).unwrap_err().to_string();
    assert!(error.contains("no actions"), "{error}");
}

#[test]
fn moments_that_never_were_are_refused() {
    let logged = Logged::aiming(121);
    let named = [("learn.mcap".to_owned(), logged.recording())];
    let refused = |trial, at| {
        let moment = Moment { trial, at };
        of_recordings(&named, moment).unwrap_err().to_string()
    };
    let error = refused(Some(61), None);
    assert!(
        error.contains("no trial 61") && error.contains("1 to 60"),
        "{error}"
    );
    let steps = logged.session.trials[1].steps;
    let error = refused(Some(2), Some(steps as usize));
    let expected = format!("expected 0 to {}", steps - 1);
    assert!(error.contains(&expected), "{error}");
}

/// Every link, label and reference of the page is inside it, and every figure can be heard.
#[test]
fn the_report_stands_alone() {
    let logged = Logged::aiming(131);
    let figures = drawn(vec![logged.recording()], Moment::default());
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    let page = Document::parse_with_options(&figures.report, options).unwrap();
    let attributes = || page.descendants().flat_map(|node| node.attributes());
    let mut ids = BTreeSet::new();
    for id in attributes().filter(|a| a.name() == "id") {
        assert!(ids.insert(id.value()), "{} twice", id.value());
    }
    for attribute in attributes() {
        let value = attribute.value();
        match attribute.name() {
            "href" => assert!(ids.contains(value.strip_prefix('#').unwrap()), "{value}"),
            "src" | "srcset" | "onload" => panic!("{value}"),
            "aria-labelledby" => {
                for id in value.split(' ') {
                    let named = page.descendants().find(|n| n.attribute("id") == Some(id));
                    let text = named.and_then(|node| node.text()).unwrap_or_default();
                    assert!(text.trim().len() > 10, "{id}: \"{text}\"");
                }
            }
            _ => {}
        }
    }
    let drawings: Vec<_> = page
        .descendants()
        .filter(|node| node.has_tag_name("svg"))
        .collect();
    assert_eq!(drawings.len(), figures.figures.len());
    for drawing in drawings {
        assert_eq!(drawing.attribute("role"), Some("img"));
        assert!(drawing.has_attribute("aria-labelledby"));
    }
    assert!(!figures.report.contains("<script") && !figures.report.contains("url("));
    // The numbers of the log stand in the table.
    let cells = page.descendants().filter(|node| node.has_tag_name("td"));
    let cells: Vec<&str> = cells.filter_map(|cell| cell.text()).collect();
    let actions: u32 = logged.session.trials.iter().map(|trial| trial.steps).sum();
    let patterns = logged.session.knowledge.patterns.elements().len();
    let first = logged.session.trials[0].directedness.unwrap();
    for value in [actions.to_string(), patterns.to_string(), written(first, 2)] {
        assert!(cells.contains(&value.as_str()), "{value} of {cells:?}");
    }
}

/// Blocked moves are crosses, once at each place.
#[test]
fn the_first_trial_is_drawn_as_it_was() {
    let logged = (141..160)
        .map(Logged::aiming)
        .find(|logged| (1..30).contains(&logged.session.trials[0].collisions))
        .unwrap();
    let recording = logged.recording();
    let blocked: BTreeSet<String> = recording.drives[0]
        .events
        .iter()
        .filter(|event| event.motion == Motion::Blocked)
        .map(|event| format!("{:?}", event.pose.position()))
        .collect();
    let collisions = recording.drives[0].trial.collisions;
    let figures = drawn(vec![recording], Moment::default());
    let document = Document::parse(svg(&figures, "trajectories.svg")).unwrap();
    let panel = of_class(&document, "panel")[0];
    let says = format!(", {collisions} blocked");
    assert!(
        texts(panel).iter().any(|text| text.contains(&says)),
        "{says}"
    );
    let marks = panel
        .descendants()
        .find(|node| node.attribute("class") == Some("marks"));
    let crosses = marks.unwrap().children().filter(|node| {
        let is_path = node.has_tag_name("path");
        is_path && node.attribute("fill") == Some("none")
    });
    assert!(crosses.count() >= blocked.len());
}

#[test]
fn the_command_draws_and_says_what() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("learn.mcap"), Logged::aiming(171).file).unwrap();
    std::fs::write(path("bad.mcap"), b"no log").unwrap();
    let rover = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rover"));
        command.arg("figures").args(arguments).output().unwrap()
    };
    let (log, out) = (path("learn.mcap"), path("out"));
    let output = rover(&[&log, "--out", &out, "--trial", "9", "--at", "3", "--json"]);
    assert!(output.status.success(), "{output:?}");
    let drawn: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let figures = drawn["figures"].as_array().unwrap();
    assert_eq!(figures.len(), 9);
    for figure in figures {
        let file = std::fs::read_to_string(figure["file"].as_str().unwrap()).unwrap();
        Document::parse(&file).unwrap();
    }
    let report = std::fs::read_to_string(drawn["report"].as_str().unwrap()).unwrap();
    assert!(report.contains("trial 9, after 3 actions"));

    for (arguments, status, words) in [
        (&[path("bad.mcap")][..], 1, "not an MCAP file"),
        (&[path("missing.mcap")], 1, "cannot be read"),
        (
            &[log.clone(), "--trial".into(), "99".into()],
            1,
            "there is no trial 99",
        ),
        (&[log.clone(), "--at".into(), "x".into()], 2, "--at"),
        (&[], 2, "LOG"),
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = rover(&arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(status),
            "{arguments:?}: {stderr}"
        );
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
        assert!(output.stdout.is_empty());
    }
}
