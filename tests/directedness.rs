//! What a directedness (8) can be at all, before learning is judged by it. A robot that has to turn
//! round first makes moves that lead away from its target, however well it drives.
//!
//! `cargo test --test directedness -- --nocapture` prints the figures.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use rover_shared::action::Action;
use rover_shared::reward::Task as _;
use rover_shared::sensing::Sample;
use rover_simulator::arena::{ArenaSource, Layout, Robot, Scenario, degrees};
use rover_simulator::experiment::{Exam, Pilot, TaskKind, examine, mean, run_trial};

/// Steers by two turns of opposite sign, as the paper's robot does where nothing hinders: always to
/// the side on which the target lies.
struct ZigZag {
    turn_deg: f64,
}

impl Pilot for ZigZag {
    fn begin_trial(&mut self, _: &Scenario) {}

    fn task_changed(&mut self) {}

    fn act(&mut self, robot: &Robot, sample: &Sample, task: TaskKind) -> Action {
        let on_the_left = task.target_angle(sample).unwrap().0 >= 0;
        let turn_deg = if on_the_left {
            self.turn_deg
        } else {
            -self.turn_deg
        };
        Action {
            module: robot.model().step(),
            phase: degrees(turn_deg),
        }
    }
}

/// Mean directedness of 400 drives without obstacles, the target up to `within_deg` aside at first.
fn directedness(turn_deg: f64, within_deg: f64) -> f64 {
    let layout = Layout {
        goal_within_deg: within_deg,
        ..Layout::free()
    };
    let exam = Exam {
        seed: 5_150_000,
        arenas: 400,
        steps: 500,
        follow_direction: false,
        source: ArenaSource::from(layout),
    };
    let trials = examine(&exam, |_, scenario, conduct| {
        run_trial(scenario, conduct, &mut ZigZag { turn_deg })
    });
    assert!(trials.iter().all(|trial| trial.reached()), "{turn_deg}");
    let values: Vec<f64> = trials.iter().filter_map(|t| t.directedness).collect();
    mean(&values).unwrap().value
}

/// With the target up to 90 degrees aside, the paper's turns of 8 to 9 degrees give 0.98, and 0.96
/// can be asked for. From any heading no pair of turns gives 0.96, and the paper's give 0.93.
#[test]
fn two_turns_cannot_be_directed_from_any_heading() {
    let turns = [5.0, 8.3, 10.0, 12.0, 15.0, 17.5, 20.0, 25.0, 30.0, 45.0];
    let ahead = turns.map(|turn| directedness(turn, 90.0));
    let any = turns.map(|turn| directedness(turn, 180.0));
    for ((turn, ahead), any) in turns.iter().zip(&ahead).zip(&any) {
        println!("turns of {turn:>4} degrees: target ahead {ahead:.3}, anywhere {any:.3}");
    }
    let best = any.iter().copied().fold(0.0, f64::max);
    assert!(best < 0.96, "{best}");
    assert!((0.91..0.94).contains(&any[1]), "{}", any[1]);
    assert!(ahead[1] > 0.975, "{}", ahead[1]);
}
