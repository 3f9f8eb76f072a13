//! The figures: well-formed, complete, the same for the same seed, and about the right data.

use std::collections::BTreeMap;

use rover_figure::{Drive, Figure, Figures, first_trial, of_sessions, test_drives};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_simulator::arena::Layout;
use rover_simulator::experiment::{
    Exam, Known, LearnedSession, SessionPlan, Trial, examine_knowledge, learn,
};
use roxmltree::{Document, Node};

const NAMES: [&str; 9] = [
    "lattice.svg",
    "learning.svg",
    "neuron.svg",
    "overview.svg",
    "patterns.svg",
    "position.svg",
    "sequence.svg",
    "staircases.svg",
    "trajectories.svg",
];

/// What the figures of a series of sessions are made from.
struct Series {
    sessions: Vec<LearnedSession>,
    plan: SessionPlan,
    exam: Exam,
    coefficients: Coefficients,
}

impl Series {
    fn learned(count: u64, plan: SessionPlan, parameters: &Parameters) -> Self {
        let coefficients = Coefficients::new(parameters).expect("presets are valid");
        let sessions = (0..count)
            .map(|k| learn(&plan.nth(k), &coefficients, (), |_| ()))
            .collect();
        let exam = Exam {
            seed: 1_000 + plan.seed,
            arenas: 3,
            steps: plan.steps,
            follow_direction: plan.follow_direction,
            source: plan.arenas.clone(),
        };
        Self {
            sessions,
            plan,
            exam,
            coefficients,
        }
    }

    fn aiming(count: u64, seed: u64, trials: u32, steps: u32) -> Self {
        let arenas = Layout::paper().into();
        let plan = SessionPlan {
            seed,
            trials,
            steps,
            follow_direction: false,
            arenas,
        };
        Self::learned(count, plan, &Parameters::PAPER)
    }

    fn following(trials: u32) -> Self {
        let arenas = Layout::rover(500.0, 3, 10.0).into();
        let plan = SessionPlan {
            seed: 3,
            trials,
            steps: 200,
            follow_direction: true,
            arenas,
        };
        Self::learned(1, plan, &Parameters::ROVER)
    }

    fn drawn(&self) -> Figures {
        let sessions: Vec<_> = self.sessions.iter().collect();
        of_sessions(&sessions, &self.plan, &self.exam, &self.coefficients)
    }

    fn figures(&self) -> Vec<Figure> {
        self.drawn().figures
    }

    fn known(&self) -> &Known {
        &self.sessions[0].knowledge
    }

    fn drives(&self, arenas: u32) -> Vec<Drive> {
        let exam = Exam {
            arenas,
            ..self.exam.clone()
        };
        test_drives(&exam, &self.coefficients, self.known())
    }
}

fn named<'a>(figures: &'a [Figure], name: &str) -> &'a str {
    &figures
        .iter()
        .find(|figure| figure.name == name)
        .expect(name)
        .svg
}

fn number(node: Node, attribute: &str) -> Option<f64> {
    node.attribute(attribute)?.parse().ok()
}

fn of_class<'a, 'i>(document: &'a Document<'i>, class: &str) -> Vec<Node<'a, 'i>> {
    document
        .descendants()
        .filter(|node| node.attribute("class") == Some(class))
        .collect()
}

/// A text as viewers show it: white space around it does not count.
fn shown<'a>(text: Node<'a, '_>) -> Option<&'a str> {
    text.text().map(str::trim)
}

fn texts<'a>(node: Node<'a, '_>) -> Vec<&'a str> {
    let texts = node.descendants().filter(|node| node.has_tag_name("text"));
    texts.filter_map(shown).collect()
}

/// About where a text lies: left, top, right, bottom; `None` for text that runs upwards.
fn extent(text: Node) -> Option<[f64; 4]> {
    if text.has_attribute("transform") {
        return None;
    }
    let [x, y, size] = ["x", "y", "font-size"].map(|name| number(text, name).expect(name));
    // Half the size is the mean width of a letter in the usual sans-serif fonts.
    let width = 0.5 * size * shown(text)?.chars().count() as f64;
    let left = match text.attribute("text-anchor") {
        None => x,
        Some("middle") => x - width / 2.0,
        Some("end") => x - width,
        Some(other) => panic!("unexpected anchor {other}"),
    };
    Some([left, y - 0.7 * size, left + width, y])
}

/// Numbers of all attributes that hold coordinates.
fn coordinates<'a>(document: &'a Document) -> impl Iterator<Item = &'a str> {
    let names = [
        "x", "y", "x1", "x2", "y1", "y2", "cx", "cy", "r", "width", "height", "d",
    ];
    let all = document.descendants().flat_map(|node| node.attributes());
    let chosen = all.filter(move |attribute| names.contains(&attribute.name()));
    chosen
        .flat_map(|a| a.value().split(|c: char| c == ' ' || "MLZh".contains(c)))
        .filter(|number| !number.is_empty())
}

/// What every figure has to be.
fn check(figure: &Figure) {
    let Figure { name, svg, .. } = figure;
    assert!(svg.len() < 300_000, "{name} has {} bytes", svg.len());
    let document = Document::parse(svg).unwrap_or_else(|error| panic!("{name}: {error}"));
    let root = document.root_element();
    assert_eq!(
        root.tag_name().namespace(),
        Some("http://www.w3.org/2000/svg")
    );

    for outside in ["href", "url(", "@import", "<image", "<script", "<style"] {
        assert!(!svg.contains(outside), "{name} has {outside}");
    }
    for value in coordinates(&document) {
        let value: f64 = value.parse().unwrap_or_else(|_| panic!("{name}: {value}"));
        assert!(
            value.is_finite() && value.abs() < 3_000.0,
            "{name}: {value}"
        );
        assert!(
            (value * 10.0 - (value * 10.0).round()).abs() < 1e-6,
            "{name}: {value}"
        );
    }
    assert!(
        !svg.contains("NaN") && !svg.contains("inf,") && !svg.contains(">inf"),
        "{name}"
    );

    let title = root
        .children()
        .find(|node| node.has_tag_name("title"))
        .expect("a figure has a title");
    let title = title.text().expect("a title says something");
    assert!(
        texts(root).contains(&title),
        "{name}: the title is not shown"
    );
    let axes = of_class(&document, "axis");
    let labels: Vec<&str> = axes.iter().flat_map(|axis| texts(*axis)).collect();
    let units = ["(cm)", "(degrees", "(number", "(dimensionless)"];
    assert!(
        labels.iter().any(|l| units.iter().any(|u| l.contains(u))),
        "{name}: {labels:?}"
    );
    let legends = of_class(&document, "legend");
    assert!(
        legends.iter().any(|legend| !texts(*legend).is_empty()),
        "{name}: no legend"
    );

    let (width, height) = (
        number(root, "width").expect("width"),
        number(root, "height").expect("height"),
    );
    let written = document
        .descendants()
        .filter(|node| node.has_tag_name("text"));
    let extents: Vec<_> = written
        .filter_map(|t| Some((shown(t)?, extent(t)?)))
        .collect();
    for (i, (text, [left, top, right, bottom])) in extents.iter().enumerate() {
        let inside = *left >= 0.0 && *top >= 0.0 && *right <= width && *bottom <= height;
        assert!(inside, "{name}: \"{text}\" leaves the sheet");
        for (other, [l, t, r, b]) in &extents[..i] {
            let overlap = left < r && l < right && top < b && t < bottom;
            assert!(!overlap, "{name}: \"{text}\" lies over \"{other}\"");
        }
    }
}

fn check_all(figures: &[Figure], names: &[&str]) {
    let mut found: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
    found.sort_unstable();
    assert_eq!(found, names);
    figures.iter().for_each(check);
}

#[test]
fn every_figure_of_a_session_is_complete() {
    for seed in 1..=4 {
        check_all(&Series::aiming(1, seed, 60, 500).figures(), &NAMES);
    }
    check_all(&Series::following(4).figures(), &NAMES);
}

#[test]
fn figures_of_many_sessions_show_their_spread() {
    let series = Series::aiming(5, 10, 12, 200);
    let figures = series.figures();
    check_all(&figures, &NAMES);
    let document = Document::parse(named(&figures, "learning.svg")).unwrap();
    let legend = texts(of_class(&document, "legend")[0]).join(" ");
    assert!(
        legend.contains("median of 5 sessions") && legend.contains("10 to 90 %"),
        "{legend}"
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let first = Series::aiming(2, 5, 20, 300).figures();
    assert!(first == Series::aiming(2, 5, 20, 300).figures());
    for (a, b) in first.iter().zip(Series::aiming(2, 6, 20, 300).figures()) {
        assert_eq!(a.name, b.name);
        assert_ne!(a.svg, b.svg, "{}", a.name);
    }
}

#[test]
fn little_to_show_is_no_reason_to_fail() {
    // One trial; trials without actions; no trials at all; no sessions.
    check_all(&Series::aiming(1, 1, 1, 500).figures(), &NAMES);
    check_all(&Series::aiming(1, 1, 1, 0).figures(), &NAMES);
    check_all(&Series::aiming(3, 1, 0, 1).figures(), &NAMES);
    check_all(&Series::following(0).figures(), &NAMES);
    check_all(&Series::aiming(0, 1, 1, 1).figures(), &[]);
}

#[test]
fn trials_of_very_many_actions_do_not_swell_the_figures() {
    let arenas = Layout::rover(500.0, 3, 10.0).into();
    let plan = SessionPlan {
        seed: 1,
        trials: 1,
        steps: 30_000,
        follow_direction: true,
        arenas,
    };
    check_all(
        &Series::learned(1, plan, &Parameters::ROVER).figures(),
        &NAMES,
    );
}

#[test]
fn arena_files_of_every_kind_can_be_drawn() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("host/arenas");
    let choices = [
        ("lab.toml", false),
        ("lab.yaml", false),
        ("rover-5m.toml", true),
        ("lab.toml", true),
    ];
    for (file, follow_direction) in choices {
        let arenas = rover_log::arena_file::load_file(&folder.join(file)).unwrap();
        let plan = SessionPlan {
            seed: 2,
            trials: 3,
            steps: 150,
            follow_direction,
            arenas,
        };
        let parameters = if follow_direction {
            Parameters::ROVER
        } else {
            Parameters::PAPER
        };
        let figures = Series::learned(1, plan, &parameters).figures();
        check_all(&figures, &NAMES);
        let document = Document::parse(named(&figures, "trajectories.svg")).unwrap();
        let obstacles = of_class(&document, "arena")[0];
        assert!(
            obstacles.children().any(|node| node.has_tag_name("path")),
            "{file}"
        );
        // An arena's target is nothing to who follows a direction.
        let targets = of_class(&document, "target").len();
        assert_eq!(targets == 0, follow_direction, "{file}");
    }
}

#[test]
fn drives_are_those_of_the_session_and_of_its_test() {
    let series = Series::aiming(1, 4, 15, 300);
    let first = first_trial(&series.plan, &series.coefficients).unwrap();
    let same = |drive: &Drive, trial: &Trial| {
        assert_eq!(format!("{:?}", drive.trial), format!("{trial:?}"));
        assert_eq!(drive.events.len() as u32, trial.steps);
        assert_eq!(drive.end.to_array(), trial.end_cm);
    };
    same(&first, &series.sessions[0].trials[0]);

    let exam = Exam {
        arenas: 4,
        ..series.exam.clone()
    };
    let tested = examine_knowledge(&exam, &series.coefficients, series.known());
    let drives = series.drives(4);
    assert_eq!(drives.len(), tested.len());
    for (drive, trial) in drives.iter().zip(&tested) {
        same(drive, trial);
    }
}

#[test]
fn the_histogram_counts_what_the_test_drives_used() {
    let series = Series::aiming(1, 8, 60, 500);
    let mut counts = BTreeMap::new();
    for code in series.drives(40).iter().flat_map(Drive::codes).flatten() {
        *counts.entry(code).or_insert(0u32) += 1;
    }
    let (code, count) = counts.iter().max_by_key(|(_, count)| **count).unwrap();
    let figures = series.figures();
    let document = Document::parse(named(&figures, "patterns.svg")).unwrap();
    // The most used pattern is in the first column, under its bar's number.
    assert_eq!(texts(of_class(&document, "column")[0]), [code.to_string()]);
    let shown = texts(of_class(&document, "panel")[0]);
    assert!(
        shown.contains(&count.to_string().as_str()),
        "{count} of {shown:?}"
    );
    let drawn = of_class(&document, "column").len();
    assert_eq!(drawn, counts.len().min(20));
}

#[test]
fn the_files_are_written_whole_or_the_place_is_named() {
    let series = Series::aiming(1, 1, 2, 100);
    let drawn = series.drawn();
    let folder = tempfile::tempdir().unwrap();
    let write = |to: &std::path::Path| drawn.write(to);
    write(folder.path()).unwrap();
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(report == drawn.report);
    for figure in &drawn.figures {
        let written = std::fs::read_to_string(folder.path().join(figure.name)).unwrap();
        assert!(written == figure.svg, "{}", figure.name);
    }
    let missing = folder.path().join("missing");
    let error = write(&missing).unwrap_err().to_string();
    assert!(
        error.contains("missing") && error.contains("cannot be written"),
        "{error}"
    );
}
