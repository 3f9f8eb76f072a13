//! `rover learn`

use std::io::Write as _;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use rover_shared::parameters::Coefficients;
use serde::Serialize;

use super::input::read_parameters;
use super::output::{Failure, answer, shown};
use super::simulated::ArenaTask;
use rover_log::files::{Replacement, WriteError, writable_folder};
use rover_log::results;
use rover_log::{LogWriter, Origin};
use rover_simulator::experiment::{
    Estimate, ExamResult, LearnedSession, SessionPlan, Trial, learn, mean,
};
use rover_simulator::parameters::preset;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Seed of the first session; each further session adds 1
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many sessions, each from nothing, spread over all cores
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    sessions: u32,
    /// Trials in each session, each in a new arena [default: 200 to aim at a target, 20 to follow
    /// a direction]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    trials: Option<u32>,
    /// Actions allowed in each trial
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// The task to learn
    #[arg(long, value_enum, default_value_t = ArenaTask::Target)]
    task: ArenaTask,
    /// paper, harder, free, rover, rover-5m, or a file (.toml, or a ROS map's .yaml)
    #[arg(long, value_name = "FILE|NAME")]
    arena: Option<String>,
    /// Parameters to learn with (TOML); what it leaves out is as the arena's robot needs it
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Arenas never met before in which each session is tested afterwards
    #[arg(long, default_value_t = 100, value_name = "N")]
    test_arenas: u32,
    /// Folder for what was learned, the log and the figures
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// The arguments of a test in the arenas that were learned in.
    fn test(&self) -> String {
        let arena = self.arena.as_deref().unwrap_or(self.task.arena());
        match self.task {
            ArenaTask::Target => format!("--arena {arena}"),
            ArenaTask::Direction => format!("--arena {arena} --task direction"),
        }
    }
}

/// What the command prints for machines.
#[derive(Serialize)]
struct Outcome {
    sessions: Vec<SessionOutcome>,
    /// Means over the sessions.
    reached: Option<Estimate>,
    clean: Option<Estimate>,
    path_ratio: Option<Estimate>,
    first_trial_directedness: Option<Estimate>,
    free_angle_deg: Option<Estimate>,
    out: String,
}

/// One session.
#[derive(Serialize)]
struct SessionOutcome {
    seed: u64,
    knowledge: String,
    actions: u64,
    patterns: usize,
    first_trial_directedness: Option<f64>,
    test: ExamResult,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let name = arguments.arena.as_deref().unwrap_or(arguments.task.arena());
    let arenas = rover_log::arena_file::load(name)?;
    arguments.task.check(name, &arenas)?;
    let parameters = read_parameters(arguments.parameters.as_deref(), preset(arenas.robot()))?;
    let coefficients = Coefficients::new(&parameters)?;
    let plan = SessionPlan {
        seed: arguments.seed,
        trials: arguments.trials.unwrap_or(arguments.task.trials()),
        steps: arguments.steps,
        follow_direction: arguments.task == ArenaTask::Direction,
        arenas,
    };
    writable_folder(&arguments.out)?;
    let bar = progress_bar(u64::from(arguments.sessions) * u64::from(plan.trials));
    let sessions: Vec<(LearnedSession, ExamResult, PathBuf)> = (0..arguments.sessions)
        .into_par_iter()
        .map(|k| session(arguments, &plan, &coefficients, k, &bar))
        .collect::<Result<_, WriteError>>()?;
    bar.finish_and_clear();
    let learned: Vec<&LearnedSession> = sessions.iter().map(|(learned, ..)| learned).collect();
    let exam = plan.exam(arguments.test_arenas);
    rover_figure::of_sessions(&learned, &plan, &exam, &coefficients).write(&arguments.out)?;
    let outcome = outcome(arguments, &sessions);
    answer(
        arguments.json,
        &outcome,
        text(arguments, &outcome, &sessions),
    )
}

/// One session with its log, its knowledge file and its test.
fn session(
    arguments: &Arguments,
    plan: &SessionPlan,
    coefficients: &Coefficients,
    k: u32,
    bar: &ProgressBar,
) -> Result<(LearnedSession, ExamResult, PathBuf), WriteError> {
    let plan = plan.nth(u64::from(k));
    let after_trial = |_: &Trial| bar.inc(1);
    // One log shows how learning goes; hundreds would fill the disk.
    let learned = if k == 0 {
        let path = arguments.out.join("learn.mcap");
        learn_with_log(&path, &plan, coefficients, after_trial)?
    } else {
        learn(&plan, coefficients, (), after_trial)
    };
    let file = match arguments.sessions {
        1 => "knowledge.rover".into(),
        _ => format!("knowledge-{}.rover", k + 1),
    };
    let path = arguments.out.join(file);
    rover_log::knowledge::save(&path, &learned.knowledge, coefficients.parameters())?;
    let test = learned.test(&plan.exam(arguments.test_arenas), coefficients);
    Ok((learned, test, path))
}

fn learn_with_log(
    path: &Path,
    plan: &SessionPlan,
    coefficients: &Coefficients,
    after_trial: impl FnMut(&Trial),
) -> Result<LearnedSession, WriteError> {
    let at = |error| WriteError::new(path, error);
    let mut file = Replacement::new(path)?;
    let origin = Origin {
        seed: plan.seed,
        mode: rover_shared::learning::Mode::Learn,
        writer: format!("rover {}", env!("CARGO_PKG_VERSION")),
    };
    let parameters = coefficients.parameters();
    let nothing = rover_simulator::experiment::Known::new(&coefficients.learning);
    let before = rover_log::knowledge::to_bytes(&nothing, parameters);
    let mut log = LogWriter::new(file.file(), &origin, &before).map_err(at)?;
    let learned = learn(plan, coefficients, &mut log, after_trial);
    let after = rover_log::knowledge::to_bytes(&learned.knowledge, parameters);
    log.finish(&after)
        .and_then(|file| file.flush())
        .map_err(at)?;
    file.commit()?;
    Ok(learned)
}

fn progress_bar(trials: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("learning {wide_bar} {pos}/{len} trials, {eta} left");
    ProgressBar::new(trials).with_style(style.expect("the template is a constant and valid"))
}

fn outcome(arguments: &Arguments, sessions: &[(LearnedSession, ExamResult, PathBuf)]) -> Outcome {
    let sessions: Vec<SessionOutcome> = sessions
        .iter()
        .map(|(learned, test, path)| SessionOutcome {
            seed: learned.seed,
            knowledge: path.display().to_string(),
            actions: learned
                .trials
                .iter()
                .map(|trial| u64::from(trial.steps))
                .sum(),
            patterns: learned.knowledge.patterns.elements().len(),
            first_trial_directedness: learned.trials.first().and_then(|t| t.directedness),
            test: test.clone(),
        })
        .collect();
    let over = |of: fn(&SessionOutcome) -> Option<f64>| {
        mean(&sessions.iter().filter_map(of).collect::<Vec<_>>())
    };
    Outcome {
        reached: over(|s| Some(s.test.reached?.value)),
        clean: over(|s| Some(s.test.clean?.value)),
        path_ratio: over(|s| Some(s.test.path_ratio?.value)),
        first_trial_directedness: over(|s| s.first_trial_directedness),
        free_angle_deg: over(|s| Some(s.test.free_angle_deg?.value)),
        out: arguments.out.display().to_string(),
        sessions,
    }
}

fn text(
    arguments: &Arguments,
    outcome: &Outcome,
    sessions: &[(LearnedSession, ExamResult, PathBuf)],
) -> String {
    match (outcome.sessions.as_slice(), sessions) {
        ([only], [(learned, _, path)]) => {
            let mut text =
                results::learning_curve(&learned.trials, arguments.task == ArenaTask::Direction);
            text += &format!(
                "\nLearned {} patterns in {} actions. The ones used most:\n\n",
                only.patterns, only.actions
            );
            text += &results::patterns(&learned.knowledge, 5);
            text += &format!("\nTest in {} arenas never met before:\n", only.test.arenas);
            text += &results::exam(&only.test);
            text += &next_steps(&arguments.out, path, &arguments.test());
            text
        }
        (all, _) => {
            let mut text = String::from("session  seed  patterns  reached  clean  path\n");
            for (k, s) in (1..).zip(all) {
                let value =
                    |e: Option<Estimate>| e.map_or("-".into(), |e| format!("{:.3}", e.value));
                text += &format!(
                    "{k:>7}  {:>4}  {:>8}  {:>7}  {:>5}  {:>4}\n",
                    s.seed,
                    s.patterns,
                    value(s.test.reached),
                    value(s.test.clean),
                    value(s.test.path_ratio)
                );
            }
            text += &format!(
                "\nMean over {} sessions [95 % interval]\n  reached     {}\n  clean       {}\n  path ratio  {}\n  directedness of the first trial {}\n",
                all.len(),
                shown(outcome.reached, 3),
                shown(outcome.clean, 3),
                shown(outcome.path_ratio, 3),
                shown(outcome.first_trial_directedness, 3),
            );
            if outcome.free_angle_deg.is_some() {
                text += &format!(
                    "  angle to the direction with nothing in sight {} deg\n",
                    shown(outcome.free_angle_deg, 1)
                );
            }
            text
        }
    }
}

/// What to do with the files in `out`: `arguments` name the task and the arena that was learned in.
fn next_steps(out: &Path, knowledge: &Path, arguments: &str) -> String {
    let (out, knowledge) = (out.display(), knowledge.display());
    // The program as it was called, so that the lines can be copied.
    let rover = std::env::args().next().unwrap_or_else(|| "rover".into());
    format!(
        "\n{out}/ now holds what was learned, the log of every action, and figures\n\
         (*.svg; report.html has them all).\n\
         Next:  {rover} test --knowledge {knowledge} {arguments}\n       \
         {rover} replay {out}/learn.mcap --verify\n"
    )
}
