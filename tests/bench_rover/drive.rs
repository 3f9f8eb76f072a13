//! Long drives: turns end, advances are as long as they should be, obstacles stop them, and the
//! supervisor finds nothing.

use std::collections::VecDeque;

use rover_boardless::BoardlessRover;
use rover_shared::contract::{Fault, Mode, Outcome, State, Task};
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::message::{ActionRecord, Report};
use rover_simulator::arena::{ArenaSource, Pose};

use super::fixture::{bench, room, scenario};

/// One action as it went, from rest to rest.
struct Action {
    record: ActionRecord,
    turned_deg: f64,
    advanced_cm: f64,
}

/// A drive and what it was like.
#[derive(Default)]
struct Drive {
    actions: Vec<Action>,
    faults: Vec<Fault>,
    touching_s: f64,
    /// The longest driven time within one move in which the rover moved neither 1 cm nor 2 degrees,
    /// with something in view ahead throughout.
    longest_stall_s: f64,
}

impl Drive {
    fn run(bench: &mut BoardlessRover, span: Duration) -> Self {
        let mut drive = Self::default();
        // Poses at the observations of the last ten seconds.
        let mut poses: VecDeque<(Instant, Pose)> = VecDeque::new();
        let mut before: Option<(ActionRecord, Pose)> = None;
        let mut stall = Stall::default();
        let end = bench.now().after(span);
        while bench.now() < end {
            let reports = bench.period();
            let pose = bench.vehicle().pose();
            poses.push_back((bench.latest().time, pose));
            if poses.len() > 500 {
                poses.pop_front();
            }
            drive.touching_s += 0.02 * f64::from(u8::from(bench.vehicle().touching()));
            drive.longest_stall_s = drive.longest_stall_s.max(stall.note(bench, pose));
            for report in reports {
                match report {
                    Report::Fault(report) => drive.faults.push(report.fault),
                    Report::Action(record) => {
                        stall = Stall::default();
                        let at = |(time, _): &&(Instant, Pose)| *time == record.time;
                        let pose = poses.iter().rev().find(at).expect("a move takes seconds").1;
                        if let Some((record, from)) = before.replace((record, pose)) {
                            drive.actions.push(Action::new(record, from, pose));
                        }
                    }
                    _ => {}
                }
            }
            assert_eq!(
                bench.state(),
                State::Driving(Mode::Learn),
                "after {:?} and {:?}",
                bench.now(),
                drive.faults
            );
        }
        drive
    }

    fn count(&self, outcome: Outcome) -> usize {
        let ended = |action: &&Action| action.record.outcome == outcome;
        self.actions.iter().filter(ended).count()
    }

    fn completed(&self) -> impl Iterator<Item = &Action> {
        let completed = |action: &&Action| action.record.outcome == Outcome::Completed;
        self.actions.iter().filter(completed)
    }
}

impl Action {
    fn new(record: ActionRecord, from: Pose, to: Pose) -> Self {
        Self {
            record,
            turned_deg: f64::from(to.heading.turn_from(from.heading).0) / 1e6,
            advanced_cm: to.position().distance(from.position()),
        }
    }

    /// By how much more the rover turned than it wanted.
    fn turn_error_deg(&self) -> f64 {
        self.turned_deg - f64::from(self.record.step.action.phase.0) / 1e6
    }
}

/// Driven time without true motion.
#[derive(Default)]
struct Stall {
    from: Option<Pose>,
    driven_s: f64,
}

impl Stall {
    fn note(&mut self, bench: &BoardlessRover, pose: Pose) -> f64 {
        let still = self.from.is_some_and(|from| {
            pose.position().distance(from.position()) < 1.0
                && pose.heading.turn_from(from.heading).0.abs() < 2_000_000
        });
        let in_view = bench.latest().ir.clearance().front.0 < 550_000;
        if !still || !in_view {
            *self = Self {
                from: Some(pose),
                driven_s: 0.0,
            };
        } else if bench.driven() {
            self.driven_s += 0.02;
        }
        self.driven_s
    }
}

/// The value below which this share of all lies.
fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

fn drive(source: &ArenaSource, seed: u64, hours: u32) -> Drive {
    let scenario = scenario(source, seed);
    let mut bench = bench(&scenario, seed);
    bench
        .drive(Mode::Learn, Task::FollowChangingDirection)
        .expect("all is well");
    Drive::run(&mut bench, Duration::from_millis(hours * 3_600_000))
}

/// What has to hold for a drive of some hours.
fn check(drive: &Drive, hours: u32) {
    let completed = || drive.completed();
    let [slow, typical, fast] =
        [0.05, 0.5, 0.95].map(|share| quantile(completed().map(|a| a.advanced_cm), share));
    let [right, left] =
        [0.01, 0.99].map(|share| quantile(completed().map(Action::turn_error_deg), share));
    println!(
        "{} actions, {} completed, {} stopped by obstacles, {} without progress; advances \
         {slow:.2} {typical:.2} {fast:.2} cm; turn errors {right:.1} to {left:.1} degrees; touching \
         for {:.0} s; longest stall {:.2} s",
        drive.actions.len(),
        completed().count(),
        drive.count(Outcome::Obstacle),
        drive.count(Outcome::NoProgress),
        drive.touching_s,
        drive.longest_stall_s,
    );
    let hours = hours as usize;
    assert!(drive.actions.len() > 2_000 * hours, "the rover goes on");
    // Nothing but obstacles, and rarely something that the sensors cannot see.
    let counted = |fault: &&Fault| !matches!(fault, Fault::Blocked | Fault::NoProgress);
    assert_eq!(drive.faults.iter().find(counted), None);
    assert!(drive.count(Outcome::NoProgress) <= hours);
    assert_eq!(
        drive.actions.len(),
        completed().count() + drive.count(Outcome::Obstacle) + drive.count(Outcome::NoProgress),
        "every turn ends, no move is lost"
    );
    // 7 cm by a speed that is some per cent off.
    assert!(slow > 6.0 && fast < 7.8 && (6.5..7.5).contains(&typical));
    // Within the tolerance of 2 degrees, the compass's errors and the hold's.
    assert!(right > -5.0 && left < 5.0);
    assert!(drive.touching_s < 0.05 * 3_600.0 * hours as f64);
    // Promised within a second.
    assert!(drive.longest_stall_s <= 1.0, "{}", drive.longest_stall_s);
}

#[test]
fn an_hour_in_the_paper_s_room_is_uneventful() {
    let drive = drive(&room(300.0, 10.0), 2, 1);
    check(&drive, 1);
    assert!(drive.count(Outcome::Obstacle) > 20, "its walls are near");
}

#[test]
fn an_hour_in_the_large_room_is_uneventful() {
    let furnished = concat!(env!("CARGO_MANIFEST_DIR"), "/host/arenas/rover-5m.toml");
    let furnished = rover_log::arena_file::load(furnished).expect("an arena");
    check(&drive(&furnished, 1, 1), 1);
}

/// `cargo test --release --test bench_rover -- --ignored --nocapture a_day_is_uneventful`
#[test]
#[ignore = "a day for each of eight rovers: some minutes"]
fn a_day_is_uneventful() {
    for side_cm in [300.0, 500.0] {
        for beam_deg in [10.0, 30.0] {
            for seed in [2, 3] {
                println!("{side_cm} cm, fields of {beam_deg} degrees, seed {seed}:");
                check(&drive(&room(side_cm, beam_deg), seed, 24), 24);
            }
        }
    }
}
