//! Does the rover learn to follow a direction, with sensors, compass and motors as they are?
//! `cargo test --test bench_rover -- --ignored --nocapture learning_study`

use rayon::prelude::*;
use rover_boardless::{BoardlessRover, COEFFICIENTS};
use rover_shared::contract::{Mode, Outcome, State, Task};
use rover_shared::sensing::ir::FARTHEST;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{ActionRecord, Command, EventKind, Report};
use rover_simulator::arena::ArenaSource;
use rover_simulator::experiment::{
    Exam, ExamResult, SessionPlan, examine_knowledge, learn, numbered,
};

use super::fixture::{bench, room, scenario};

/// Actions with nothing in sight after which the angle to the direction counts: untrained phases
/// of 20 degrees turn round in nine. (The experiments in the simulator wait for twenty, which in a
/// room leaves few actions to count.)
const UNDISTURBED: u32 = 10;

/// Angle to the direction to follow, where nothing was in sight for as long as a turn takes.
#[derive(Default)]
struct FreeHeading {
    direction: Microdegrees,
    undisturbed: u32,
    sum_deg: f64,
    count: u32,
    /// The same of all actions with nothing in sight, whatever was before.
    clear_sum_deg: f64,
    clear_count: u32,
}

impl FreeHeading {
    fn redirect(&mut self, direction: Microdegrees) {
        self.direction = direction;
        self.undisturbed = 0;
    }

    fn note(&mut self, record: &ActionRecord) {
        let sample = &record.sample;
        let free = [sample.front, sample.left, sample.right]
            .iter()
            .all(|range| *range >= FARTHEST);
        self.undisturbed = if free { self.undisturbed + 1 } else { 0 };
        let angle = self.direction.turn_from(sample.heading).0;
        let angle_deg = f64::from(angle.unsigned_abs()) / 1e6;
        if free {
            self.clear_sum_deg += angle_deg;
            self.clear_count += 1;
        }
        if self.undisturbed > UNDISTURBED {
            self.sum_deg += angle_deg;
            self.count += 1;
        }
    }

    /// Means since the last call, of free actions and of those with nothing in sight, and how many
    /// free actions it is.
    fn take(&mut self) -> (f64, f64, u32) {
        let fresh = Self {
            direction: self.direction,
            undisturbed: self.undisturbed,
            ..Self::default()
        };
        let done = std::mem::replace(self, fresh);
        (
            done.sum_deg / f64::from(done.count),
            done.clear_sum_deg / f64::from(done.clear_count),
            done.count,
        )
    }
}

/// What a block of actions was like.
#[derive(Clone, Copy, Debug)]
struct Block {
    free_deg: f64,
    clear_deg: f64,
    free_actions: u32,
    obstacles: u32,
    touching_s: f64,
}

/// Lets the rover act so often; one [`Block`] for each part of the way.
fn act(bench: &mut BoardlessRover, actions: u32, blocks: u32) -> Vec<Block> {
    let mut free = FreeHeading::default();
    let mut done = Vec::new();
    let (mut acted, mut obstacles, mut touching) = (0, 0, 0u32);
    while acted < actions {
        let reports = bench.period();
        touching += u32::from(bench.vehicle().touching());
        for report in reports {
            match report {
                Report::Event(event) => {
                    if let EventKind::Direction(direction) = event.kind {
                        free.redirect(direction);
                    }
                }
                Report::Action(record) => {
                    free.note(&record);
                    obstacles += u32::from(record.outcome == Outcome::Obstacle);
                    acted += 1;
                    if acted % (actions / blocks) == 0 {
                        let (free_deg, clear_deg, free_actions) = free.take();
                        done.push(Block {
                            free_deg,
                            clear_deg,
                            free_actions,
                            obstacles: std::mem::take(&mut obstacles),
                            touching_s: f64::from(std::mem::take(&mut touching)) * 0.02,
                        });
                    }
                }
                _ => {}
            }
        }
        assert!(
            matches!(bench.state(), State::Driving(_)),
            "stopped at {:?}: {:?}",
            bench.now(),
            bench.state()
        );
    }
    done
}

/// What came of one rover.
struct Session {
    /// Two thousand actions without learning, as drawn.
    untrained: Block,
    /// Ten thousand actions that it learned in, by two thousands.
    learning: Vec<Block>,
    /// Six thousand more, without learning.
    frozen: Block,
    /// For how long it learned.
    hours: f64,
}

/// Drives untrained, learns for 10,000 actions (IV-B: 160 minutes at one a second), and drives with
/// what it learned.
fn session(source: &ArenaSource, seed: u64) -> Session {
    let scenario = scenario(source, seed);
    let mut bench = bench(&scenario, seed);
    bench
        .drive(Mode::Run, Task::FollowChangingDirection)
        .expect("all is well");
    let untrained = act(&mut bench, 2_000, 1)[0];
    for command in [
        Command::Disarm,
        Command::NewKnowledge,
        Command::Arm,
        Command::SetMode(Mode::Learn),
    ] {
        bench.command(&command).expect("all is well");
    }
    let began = bench.now();
    let learning = act(&mut bench, 10_000, 5);
    let hours = bench.now().since(began).0 as f64 / 3.6e9;
    for mode in [Mode::Idle, Mode::Run] {
        bench.command(&Command::SetMode(mode)).expect("armed");
    }
    Session {
        untrained,
        learning,
        frozen: act(&mut bench, 6_000, 1)[0],
        hours,
    }
}

#[test]
fn ten_thousand_actions_teach_the_rover_to_follow_a_direction() {
    let session = session(&room(500.0, 10.0), 1);
    let [untrained, frozen] = [session.untrained, session.frozen];
    println!("{untrained:?}\n{:?}\n{frozen:?}", session.learning);
    assert!(untrained.free_actions > 100 && frozen.free_actions > 500);
    assert!(frozen.free_deg < 20.0 && untrained.free_deg > 3.0 * frozen.free_deg);
    assert!(session.learning[4].obstacles < session.learning[0].obstacles);
}

/// The free heading that the simulator's robot has after as many actions, in degrees.
fn simulated(source: &ArenaSource, seed: u64) -> f64 {
    let plan = SessionPlan {
        seed,
        trials: 20,
        steps: 500,
        follow_direction: true,
        arenas: source.clone(),
    };
    let learned = learn(&plan, &COEFFICIENTS, (), |_| {});
    let exam = Exam {
        seed: numbered(seed, 2),
        arenas: 12,
        steps: 500,
        follow_direction: true,
        source: source.clone(),
    };
    let trials = examine_knowledge(&exam, &COEFFICIENTS, &learned.knowledge);
    let result = ExamResult::new(&trials, false);
    result.free_angle_deg.map_or(f64::NAN, |angle| angle.value)
}

#[test]
#[ignore = "a study: 60 rovers that learn for four hours, some minutes"]
fn learning_study() {
    println!(
        "| room | fields | free heading untrained | learning, first 2,000 | last 2,000 | frozen | \
         simulated | obstacles in the first 2,000 | last 2,000 | touching s | hours |"
    );
    let furnished = concat!(env!("CARGO_MANIFEST_DIR"), "/host/arenas/rover-5m.toml");
    let furnished = rover_log::arena_file::load(furnished).expect("an arena");
    let mut rooms = vec![("rover-5m.toml", 10.0, furnished)];
    for (name, side_cm) in [("3 m", 300.0), ("5 m", 500.0)] {
        for beam_deg in [5.0, 10.0, 20.0, 30.0] {
            rooms.push((name, beam_deg, room(side_cm, beam_deg)));
        }
    }
    for (name, beam_deg, source) in &rooms {
        let sessions: Vec<_> = (1..=6u64)
            .into_par_iter()
            .map(|seed| (session(source, seed), simulated(source, seed)))
            .collect();
        let each = |of: &dyn Fn(&Session) -> f64| spread(sessions.iter().map(|(s, _)| of(s)));
        println!(
            "| {name} | {beam_deg} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            each(&|s| s.untrained.free_deg),
            each(&|s| s.learning[0].free_deg),
            each(&|s| s.learning[4].free_deg),
            each(&|s| s.frozen.free_deg),
            spread(sessions.iter().map(|(_, simulated)| *simulated)),
            each(&|s| f64::from(s.learning[0].obstacles)),
            each(&|s| f64::from(s.learning[4].obstacles)),
            each(&|s| s.learning[4].touching_s),
            each(&|s| s.hours),
        );
        let free = [
            each(&|s| f64::from(s.untrained.free_actions)),
            each(&|s| f64::from(s.learning[4].free_actions)),
            each(&|s| f64::from(s.frozen.free_actions)),
        ];
        let clear = [
            each(&|s| s.untrained.clear_deg),
            each(&|s| s.learning[4].clear_deg),
            each(&|s| s.frozen.clear_deg),
        ];
        println!("  with nothing in sight: untrained, last 2,000, frozen {clear:?}");
        println!("  free actions of 2,000 untrained, the last 2,000, and 6,000 frozen: {free:?}");
    }
}

/// Mean, least and most of the rovers that have a value: in a small room not all have free actions.
fn spread(values: impl Iterator<Item = f64>) -> String {
    let values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let [low, high] =
        [f64::min, f64::max].map(|f| values.iter().copied().reduce(f).unwrap_or(f64::NAN));
    format!("{mean:.1} ({low:.1} to {high:.1})")
}
