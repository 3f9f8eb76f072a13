//! `rover test`

use std::path::PathBuf;

use rover_shared::parameters::Coefficients;
use serde::Serialize;

use super::output::{Failure, answer};
use super::simulated::ArenaTask;
use rover_log::knowledge::{self, Loaded};
use rover_log::results;
use rover_simulator::arena::ArenaSource;
use rover_simulator::baseline;
use rover_simulator::experiment::{
    BaselinePilot, Exam, ExamResult, Trial, examine, examine_knowledge, run_trial, teach,
};
use rover_simulator::parameters::preset;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// What was learned; needed for the controller turing
    #[arg(long, value_name = "FILE")]
    knowledge: Option<PathBuf>,
    /// How many arenas; with arena files, how often each is driven
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    arenas: u32,
    /// paper, harder, free, rover, rover-5m, or a file; may be repeated
    #[arg(long, value_name = "FILE|NAME")]
    arena: Vec<String>,
    /// Decides the arenas: the same for every controller
    #[arg(long, default_value_t = 1_000_000)]
    seed: u64,
    /// Actions allowed in each arena
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// The rover's task
    #[arg(long, value_enum, default_value_t = ArenaTask::Target)]
    task: ArenaTask,
    /// Who drives
    #[arg(long, value_enum, default_value_t = ControllerChoice::Turing)]
    controller: ControllerChoice,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
enum ControllerChoice {
    /// Turing patterns, with what was learned
    Turing,
    /// A table of action values, learned over 200 trials first
    QLearning,
    /// A hand-written rule for the same sensors
    Reactive,
    /// A vector field histogram that sees far more
    Vfh,
    /// Chance
    Random,
}

/// What the command prints for machines.
#[derive(Serialize)]
struct Outcome {
    controller: ControllerChoice,
    seed: u64,
    #[serde(flatten)]
    result: ExamResult,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let loaded = load(arguments)?;
    let names = match arguments.arena.as_slice() {
        [] => vec![arguments.task.arena().to_owned()],
        names => names.to_vec(),
    };
    let mut trials = Vec::new();
    for name in &names {
        let source = rover_log::arena_file::load(name)?;
        arguments.task.check(name, &source)?;
        if let Some(loaded) = &loaded {
            check_robot(loaded, name, &source)?;
        }
        let exam = Exam {
            seed: arguments.seed,
            arenas: arguments.arenas,
            steps: arguments.steps,
            follow_direction: arguments.task == ArenaTask::Direction,
            source,
        };
        trials.extend(drive(arguments.controller, &exam, loaded.as_ref())?);
    }
    let result = ExamResult::new(&trials, arguments.task == ArenaTask::Target);
    let text = format!(
        "{} arenas ({})\n{}",
        result.arenas,
        names.join(", "),
        results::exam(&result)
    );
    let outcome = Outcome {
        controller: arguments.controller,
        seed: arguments.seed,
        result,
    };
    answer(arguments.json, &outcome, text)
}

/// Refuses knowledge of another robot's sensors, and says where the robot moves differently.
fn check_robot(loaded: &Loaded, name: &str, source: &ArenaSource) -> Result<(), Failure> {
    let (learned, here) = (loaded.coefficients.parameters(), preset(source.robot()));
    if learned.sensing != here.sensing {
        return Err(Failure::Failed(format!(
            "this was learned with sensors from {} to {} cm in front, the robot of arena {name} \
             has {} to {} cm; learn with --arena {name} first",
            learned.sensing.front_near_cm,
            learned.sensing.front_far_cm,
            here.sensing.front_near_cm,
            here.sensing.front_far_cm
        )));
    }
    let (learned, here) = (learned.learning, here.learning);
    if (learned.module_cm, learned.phase_limit_deg) != (here.module_cm, here.phase_limit_deg) {
        eprintln!(
            "rover: the robot of arena {name} learns with steps of {} cm and turns up to {} \
             degrees; this one has learned with {} cm and {} degrees, and keeps them",
            here.module_cm, here.phase_limit_deg, learned.module_cm, learned.phase_limit_deg
        );
    }
    Ok(())
}

fn load(arguments: &Arguments) -> Result<Option<Loaded>, Failure> {
    match (&arguments.knowledge, arguments.controller) {
        (Some(path), ControllerChoice::Turing) => Ok(Some(knowledge::load(path)?)),
        (None, ControllerChoice::Turing) => Err(Failure::Usage(
            "the controller turing needs --knowledge FILE; `rover learn` writes one".into(),
        )),
        (Some(_), _) => Err(Failure::Usage(
            "--knowledge is only for the controller turing; leave it out".into(),
        )),
        (None, _) => Ok(None),
    }
}

fn drive(
    controller: ControllerChoice,
    exam: &Exam,
    loaded: Option<&Loaded>,
) -> Result<Vec<Trial>, Failure> {
    if let Some(Loaded {
        known,
        coefficients,
    }) = loaded
    {
        return Ok(examine_knowledge(exam, coefficients, known));
    }
    let model = exam.source.robot();
    let coefficients = Coefficients::new(&preset(model))?;
    let mut learner: Option<baseline::QLearning> = None;
    if controller == ControllerChoice::QLearning {
        let mut driver = baseline::QLearning::new(model, exam.seed);
        teach(&mut driver, exam, &coefficients);
        learner = Some(driver);
    }
    Ok(examine(exam, |i, scenario, conduct| {
        let mut driver: Box<dyn baseline::Driver> = match (&learner, controller) {
            (Some(learner), _) => Box::new(learner.clone()),
            (None, ControllerChoice::Reactive) => Box::new(baseline::Reactive::new(model)),
            (None, ControllerChoice::Vfh) => Box::new(baseline::Vfh::new(model)),
            (None, _) => Box::new(baseline::Random::new(exam.seed.wrapping_add(i))),
        };
        run_trial(
            scenario,
            conduct,
            &mut BaselinePilot::new(driver.as_mut(), &coefficients),
        )
    }))
}
