//! What learning must achieve, over many sessions. None of the seeds was used to choose a rule or
//! a parameter.
//!
//! `cargo test --test learning -- --nocapture` prints the figures.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;
use std::sync::LazyLock;

use rayon::prelude::*;
use rover_shared::controller::Controller;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::learning::{Memory, Mode};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::PatternCode;
use rover_shared::random::Generator;
use rover_simulator::arena::{ArenaSource, Layout};
use rover_simulator::experiment::{
    Event, Exam, ExamResult, Known, SessionPlan, Stream, Trial, Turing, Witness, examine,
    examine_knowledge, learn, mean, run_trial,
};

/// First of the sessions' seeds.
const SEEDS: u64 = 8_810_000;
/// First of the tests' seeds.
const TEST_SEEDS: u64 = 7_700_000;
const SESSIONS: u64 = 60;

fn plan(arenas: Layout, session: u64) -> SessionPlan {
    SessionPlan {
        seed: SEEDS + session,
        trials: 200,
        steps: 500,
        follow_direction: false,
        arenas: ArenaSource::from(arenas),
    }
}

/// Drives without obstacles in each session's test.
const FREE_RUNS: u32 = 20;

fn exam(layout: Layout, arenas: u32, session: u64) -> Exam {
    Exam {
        seed: TEST_SEEDS + 1_000 * session,
        arenas,
        steps: 500,
        follow_direction: false,
        source: ArenaSource::from(layout),
    }
}

struct Session {
    first_trial: Trial,
    result: ExamResult,
    free: ExamResult,
    zigzag: Vec<bool>,
    /// The same from any heading, as in Fig. 6.
    free_from_any: ExamResult,
}

fn session(coefficients: &Coefficients, k: u64) -> Session {
    let learned = learn(&plan(Layout::paper(), k), coefficients, (), |_| {});
    let known = &learned.knowledge;
    let result = examine_knowledge(&exam(Layout::paper(), 100, k), coefficients, known);
    let (free, zigzag) = free_space(coefficients, known, k);
    let any_heading = Layout {
        goal_within_deg: 180.0,
        ..Layout::free()
    };
    let from_any = examine_knowledge(&exam(any_heading, FREE_RUNS, k), coefficients, known);
    Session {
        first_trial: learned.trials[0].clone(),
        result: ExamResult::new(&result, true),
        free: ExamResult::new(&free, true),
        zigzag,
        free_from_any: ExamResult::new(&from_any, true),
    }
}

/// Drives without obstacles, and whether each used two patterns of opposite sign most.
fn free_space(coefficients: &Coefficients, known: &Known, k: u64) -> (Vec<Trial>, Vec<bool>) {
    let mut zigzag = Vec::new();
    let exam = exam(Layout::free(), FREE_RUNS, k);
    let trials = examine(&exam, |i, scenario, conduct| {
        let mut known = Box::new(known.clone());
        let mut codes = Codes::default();
        let rng = Generator::with_stream(exam.seed + i, Stream::Examined as u64);
        let controller = Controller::new(coefficients, PaperRule, &mut known, rng, Mode::Run);
        let trial = run_trial(scenario, conduct, &mut Turing::new(controller, &mut codes));
        zigzag.push(codes.opposite_signs(&known));
        trial
    });
    (trials, zigzag)
}

/// Counts the patterns of a drive.
#[derive(Default)]
struct Codes(BTreeMap<PatternCode, usize>);

impl Witness for Codes {
    fn step(&mut self, event: &Event) {
        if let Some(perceived) = event.record.perceived {
            *self.0.entry(perceived.code).or_default() += 1;
        }
    }
}

impl Codes {
    fn opposite_signs(&self, known: &Known) -> bool {
        let mut codes: Vec<_> = self.0.iter().collect();
        codes.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
        let phase = |i: usize| {
            let (code, _) = codes.get(i)?;
            Some(known.patterns.get(**code)?.memory.phase().0.signum())
        };
        phase(0).zip(phase(1)).is_some_and(|(a, b)| a * b < 0)
    }
}

fn average(values: impl Iterator<Item = f64>) -> f64 {
    mean(&values.collect::<Vec<_>>())
        .expect("there are values")
        .value
}

/// The tests of the first sessions, each in 100 arenas of the kind it learned in.
fn learned_and_tested(
    coefficients: &Coefficients,
    layout: fn() -> Layout,
    sessions: u64,
) -> Vec<ExamResult> {
    (0..sessions)
        .into_par_iter()
        .map(|k| {
            let learned = learn(&plan(layout(), k), coefficients, (), |_| {});
            let exam = exam(layout(), 100, k);
            ExamResult::new(
                &examine_knowledge(&exam, coefficients, &learned.knowledge),
                true,
            )
        })
        .collect()
}

/// The sessions in the paper's arena, which two tests look at.
fn paper_sessions() -> &'static [Session] {
    static SESSIONS_OF_PAPER: LazyLock<Vec<Session>> = LazyLock::new(|| {
        let coefficients = Coefficients::new(&Parameters::PAPER).unwrap();
        let sessions = (0..SESSIONS).into_par_iter();
        sessions.map(|k| session(&coefficients, k)).collect()
    });
    &SESSIONS_OF_PAPER
}

/// Section III: nearly all sessions learn to reach the target, avoid obstacles, and go straight
/// where nothing hinders, by two patterns that turn to opposite sides.
#[test]
fn sixty_sessions_learn_what_the_paper_says() {
    let sessions = paper_sessions();
    let over = |of: fn(&Session) -> Option<f64>| average(sessions.iter().filter_map(of));

    let reached = over(|s| Some(s.result.reached?.value));
    let clean = over(|s| Some(s.result.clean?.value));
    let path = over(|s| Some(s.result.path_ratio?.value));
    let free = over(|s| Some(s.free.directedness?.value));
    let first = over(|s| s.first_trial.directedness);
    let runs: Vec<bool> = sessions.iter().flat_map(|s| s.zigzag.clone()).collect();
    let zigzag = runs.iter().filter(|both| **both).count() as f64 / runs.len() as f64;
    let any = over(|s| Some(s.free_from_any.directedness?.value));
    println!(
        "{SESSIONS} sessions: reached {reached:.4}, clean {clean:.4}, path {path:.3}, directedness \
         in free space {free:.4} (from any heading {any:.4}), of the first trial {first:.3}, two \
         patterns of opposite sign in {:.1} % of {} free runs",
        100.0 * zigzag,
        runs.len()
    );
    assert!(reached >= 0.985, "reached {reached}");
    assert!(clean >= 0.915, "clean {clean}");
    assert!(free >= 0.96, "directedness in free space {free}");
    assert!(
        (0.2..=0.45).contains(&first),
        "directedness of the first trial {first}"
    );
    assert!(zigzag >= 0.95, "two patterns of opposite sign {zigzag}");
}

/// Staircases are bounded at 10, which nearly all sessions reach; that must cost nothing. The bound
/// of 40 is as good as none.
#[test]
fn the_bound_on_staircases_costs_nothing() {
    let bounded = paper_sessions().iter().map(|session| &session.result);
    let mut parameters = Parameters::PAPER;
    parameters.learning.amplitude_limit = 40.0;
    let coefficients = Coefficients::new(&parameters).unwrap();
    let unbounded = learned_and_tested(&coefficients, Layout::paper, 20);
    let clean = |result: &ExamResult| result.clean.expect("there are trials").value;
    let differences: Vec<f64> = bounded
        .zip(&unbounded)
        .map(|(a, b)| clean(a) - clean(b))
        .collect();
    let difference = mean(&differences).expect("there are values");
    println!("clean, bound 10 less bound 40, 20 pairs of sessions: {difference:.3?}");
    // Certainly worse, at 95 %, would be a cost.
    assert!(
        difference.high >= 0.0 && difference.value > -0.03,
        "{difference:?}"
    );
}

/// The control: patterns keep the phases they were given at random, and only the staircases learn.
/// Ten sessions, because lost robots use up all their actions; for sixty, run
/// `rover learn --sessions 60 --parameters host/parameters/fixed-phases.toml`.
#[test]
fn without_a_motor_map_hardly_anything_is_learned() {
    let mut parameters = Parameters::PAPER;
    parameters.learning.rate = 0.0;
    parameters.learning.initial_search_deg = 0.0;
    parameters.learning.final_search_deg = 0.0;
    let coefficients = Coefficients::new(&parameters).unwrap();
    let results = learned_and_tested(&coefficients, Layout::paper, 10);
    let reached = average(results.iter().filter_map(|r| Some(r.reached?.value)));
    println!("random fixed phases: reached {reached:.3}");
    assert!(reached <= 0.35, "reached {reached}");
}

/// The harder arena, with the robot that has sharper turns and longer steps.
#[test]
fn the_harder_arena_is_learned_too() {
    let coefficients = Coefficients::new(&Parameters::HARDER).unwrap();
    let results = learned_and_tested(&coefficients, Layout::harder, 20);
    let reached = average(results.iter().filter_map(|r| Some(r.reached?.value)));
    let clean = average(results.iter().filter_map(|r| Some(r.clean?.value)));
    println!("harder arena, 20 sessions: reached {reached:.3}, clean {clean:.3}");
    // Three standard errors of 20 sessions below 0.98 and 0.87, which more sessions gave.
    assert!(reached >= 0.95, "reached {reached}");
    assert!(clean >= 0.80, "clean {clean}");
}
