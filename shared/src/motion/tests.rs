use super::*;
use proptest::prelude::*;
use std::vec::Vec;

/// A rover in front of a wall: differential drive with a dead band, motors with inertia, a
/// compass that is late. Distances in cm, angles in degrees.
struct Plant {
    motion: Motion,
    now: Instant,
    period: Duration,
    heading: f64,
    wheels: (f64, f64),
    /// The last headings; the compass shows the oldest.
    seen: [f64; 3],
    wall: f64,
    way: f64,
    blind: bool,
    stuck: bool,
}

impl Plant {
    const TRACK: f64 = 30.0;

    fn new() -> Self {
        Self {
            motion: Motion::new(Parameters::LYNXMOTION_4WD2).expect("the defaults fit together"),
            now: Instant(1_000),
            period: Duration::from_millis(20),
            heading: 170.0,
            wheels: (0.0, 0.0),
            seen: [170.0; 3],
            wall: 500.0,
            way: 0.0,
            blind: false,
            stuck: false,
        }
    }

    fn speed(duty: i16) -> f64 {
        let p = Parameters::LYNXMOTION_4WD2;
        let above = f64::from(duty.abs()) - f64::from(p.dead_band);
        let whole = f64::from(p.cruise - p.dead_band);
        15.0 * (above.max(0.0) / whole) * f64::from(duty.signum())
    }

    fn step(&mut self) -> (WheelCommand, Option<MotionEvent>) {
        let degrees = |d: f64| Microdegrees::wrapped((d * 1e6) as i64);
        let cm = |d: f64| Micrometres((d.clamp(0.0, 80.0) * 1e4) as u32);
        let senses = Senses {
            heading: (!self.blind).then(|| degrees(self.seen[2])),
            clearance: Ranges {
                front: cm(self.wall - self.way),
                left: cm(80.0),
                right: cm(80.0),
            },
        };
        let (command, event) = self.motion.step(self.now, senses);
        self.now = self.now.after(self.period);
        let seconds = self.period.0 as f64 / 1e6;
        let lag = seconds / (seconds + 0.04);
        self.wheels.0 += lag * (Self::speed(command.left()) - self.wheels.0);
        self.wheels.1 += lag * (Self::speed(command.right()) - self.wheels.1);
        if !self.stuck {
            self.way += seconds * (self.wheels.0 + self.wheels.1) / 2.0;
            let turn = seconds * (self.wheels.1 - self.wheels.0) / Self::TRACK;
            self.heading += turn.to_degrees();
        }
        self.seen.rotate_right(1);
        self.seen[0] = self.heading;
        (command, event)
    }

    fn start(&mut self, degrees: i32, cm: u32) {
        self.motion
            .start(
                Microdegrees::from_degrees(degrees),
                Micrometres::from_cm(cm),
            )
            .expect("idle and in range");
    }

    /// Runs to the end of the move; its report and the seconds it took.
    fn run(&mut self) -> (Move, f64) {
        let began = self.now;
        for _ in 0..1_000 {
            let (command, event) = self.step();
            if let Some(MotionEvent::Ended(report)) = event {
                assert_eq!(command, WheelCommand::STOP, "stopped at the end of a move");
                assert_eq!(self.step(), (WheelCommand::STOP, None), "and after it");
                return (report, self.now.since(began).0 as f64 / 1e6);
            }
        }
        panic!("the move never ends");
    }
}

#[test]
fn a_move_turns_and_advances_as_asked() {
    for turn in [-180, -90, -45, -9, 9, 20, 45, 90, 179] {
        let mut plant = Plant::new();
        plant.start(turn, 7);
        let (report, seconds) = plant.run();
        assert_eq!(report.outcome, Outcome::Completed, "{turn} degrees");
        let error = (plant.heading - 170.0 - f64::from(turn) + 540.0).rem_euclid(360.0) - 180.0;
        assert!(error.abs() < 3.0, "{turn} degrees: off by {error}");
        assert!(
            (6.0..8.0).contains(&plant.way),
            "{turn} degrees: went {} cm",
            plant.way
        );
        assert!(report.advanced >= Micrometres(69_999));
        assert!(seconds < 4.5, "{turn} degrees took {seconds} s");
    }
}

#[test]
fn the_control_period_does_not_change_the_way() {
    for period in [5, 10, 20, 33, 50] {
        let mut plant = Plant::new();
        plant.period = Duration::from_millis(period);
        plant.start(0, 7);
        plant.run();
        assert!(
            (6.3..8.2).contains(&plant.way),
            "{period} ms: went {} cm",
            plant.way
        );
    }
}

#[test]
fn an_advance_speeds_up_and_slows_down_by_the_ramp() {
    let mut plant = Plant::new();
    plant.start(0, 7);
    let mut duties = Vec::new();
    while plant.motion.under_way() || duties.is_empty() {
        duties.push(plant.step().0.left());
    }
    let p = Parameters::LYNXMOTION_4WD2;
    assert_eq!(duties.iter().max(), Some(&(p.cruise as i16)));
    let last = duties[duties.len() - 2];
    assert!(last < 300, "still at {last} at the end");
    let most = (u32::from(p.ramp) / 50 + 1) as i16; // 20 ms
    let smooth = duties[..duties.len() - 1]
        .windows(2)
        .all(|d| (d[1] - d[0]).abs() <= most);
    assert!(smooth, "{duties:?}");
}

#[test]
fn small_turns_are_left_to_the_heading_hold() {
    let mut plant = Plant::new();
    plant.start(1, 30);
    let (command, event) = plant.step();
    assert!(event.is_none() && command.left() > 0 && command.right() > command.left());
    plant.run();
    assert!((170.4..171.6).contains(&plant.heading), "{}", plant.heading);
}

#[test]
fn an_obstacle_stops_the_advance_within_one_period_and_keeps_the_turn() {
    let mut plant = Plant::new();
    plant.wall = 16.0;
    plant.start(30, 7);
    let (report, _) = plant.run();
    assert_eq!(report.outcome, Outcome::Obstacle);
    let left = plant.wall - plant.way;
    assert!(
        (11.0..=12.0).contains(&left),
        "stopped {left} cm before the wall"
    );
    assert!((plant.heading - 200.0).abs() < 3.0);
    assert!(report.advanced < Micrometres::from_cm(6));
}

#[test]
fn an_obstacle_at_the_side_stops_the_advance_too() {
    let far = Micrometres::from_cm(80);
    for clearance in [
        Ranges {
            front: far,
            left: Micrometres(0),
            right: far,
        },
        Ranges {
            front: far,
            left: far,
            right: Micrometres::from_cm(11),
        },
    ] {
        let mut motion = Motion::new(Parameters::LYNXMOTION_4WD2).unwrap();
        motion
            .start(Microdegrees(0), Micrometres::from_cm(7))
            .unwrap();
        let senses = Senses {
            heading: Some(Microdegrees(0)),
            clearance,
        };
        let (command, event) = motion.step(Instant(0), senses);
        assert_eq!(command, WheelCommand::STOP);
        let Some(MotionEvent::Ended(report)) = event else {
            panic!("{event:?}")
        };
        assert_eq!(report.outcome, Outcome::Obstacle);
    }
}

#[test]
fn a_turn_goes_on_before_an_obstacle() {
    let mut plant = Plant::new();
    plant.wall = 5.0;
    plant.start(40, 7);
    plant.run();
    assert!((plant.heading - 210.0).abs() < 3.0);
}

#[test]
fn no_turn_is_finished_blindly() {
    let mut plant = Plant::new();
    plant.start(90, 7);
    (0..20).for_each(|_| assert!(plant.step().1.is_none()));
    plant.blind = true;
    let (command, event) = plant.step();
    assert_eq!(command, WheelCommand::STOP);
    assert!(matches!(
        event,
        Some(MotionEvent::Ended(Move {
            outcome: Outcome::CompassLost,
            ..
        }))
    ));
}

#[test]
fn wheels_that_do_not_move_the_rover_are_stopped_within_a_second() {
    let mut plant = Plant::new();
    plant.stuck = true;
    plant.start(90, 7);
    let (report, seconds) = plant.run();
    assert_eq!(report.outcome, Outcome::NoProgress);
    assert!((0.9..=1.05).contains(&seconds), "{seconds} s");
}

#[test]
fn short_advances_that_lead_nowhere_add_up() {
    let mut plant = Plant::new();
    plant.stuck = true;
    plant.wall = 30.0;
    let outcomes: Vec<_> = (0..4)
        .map(|_| {
            plant.start(0, 7);
            let (ended, _) = plant.run();
            assert!(!ended.proven);
            ended.outcome
        })
        .collect();
    assert!(outcomes.contains(&Outcome::NoProgress), "{outcomes:?}");
    assert_eq!(
        outcomes[0],
        Outcome::Completed,
        "one alone is too short to tell"
    );
}

#[test]
fn small_turns_to_and_fro_do_not_add_up() {
    let mut plant = Plant::new();
    for i in 0..60 {
        plant.start(if i % 2 == 0 { 3 } else { -3 }, 0);
        assert_eq!(plant.run().0.outcome, Outcome::Completed, "turn {i}");
    }
}

#[test]
fn in_the_open_nothing_can_be_told_of_an_advance() {
    let mut plant = Plant::new();
    for _ in 0..10 {
        plant.start(0, 7);
        let (ended, _) = plant.run();
        assert_eq!((ended.outcome, ended.proven), (Outcome::Completed, false));
    }
}

#[test]
fn turns_and_advances_towards_a_wall_are_proven() {
    for (degrees, cm, wall) in [(30, 0, 500.0), (-90, 7, 500.0), (0, 7, 40.0)] {
        let mut plant = Plant::new();
        plant.wall = wall;
        plant.start(degrees, cm);
        let (ended, _) = plant.run();
        assert_eq!(
            (ended.outcome, ended.proven),
            (Outcome::Completed, true),
            "{degrees} degrees, {cm} cm, wall at {wall} cm"
        );
    }
}

#[test]
fn a_turn_that_never_settles_times_out() {
    let mut motion = Motion::new(Parameters::LYNXMOTION_4WD2).unwrap();
    motion
        .start(Microdegrees::from_degrees(90), Micrometres(0))
        .unwrap();
    let far = Micrometres::from_cm(80);
    let clearance = Ranges {
        front: far,
        left: far,
        right: far,
    };
    let mut outcome = None;
    for i in 0..300 {
        // Swings to and fro round the target.
        let heading = Some(Microdegrees::from_degrees(if i % 2 == 0 { 0 } else { 100 }));
        let now = Instant(20_000 * i);
        if let (_, Some(MotionEvent::Ended(report))) =
            motion.step(now, Senses { heading, clearance })
        {
            outcome = Some((report.outcome, now.0));
            break;
        }
    }
    assert_eq!(outcome, Some((Outcome::TurnTimeout, 4_000_000)));
}

#[test]
fn a_late_step_stops_the_move() {
    let mut plant = Plant::new();
    plant.start(0, 50);
    (0..10).for_each(|_| assert!(plant.step().1.is_none()));
    plant.now = plant.now.after(Duration::from_millis(140));
    let (command, event) = plant.step();
    assert_eq!(command, WheelCommand::STOP);
    assert!(matches!(
        event,
        Some(MotionEvent::Ended(Move {
            outcome: Outcome::Late,
            ..
        }))
    ));
}

#[test]
fn stop_ends_a_move_once() {
    let mut plant = Plant::new();
    assert!(plant.motion.stop().is_none());
    plant.start(0, 50);
    (0..10).for_each(|_| assert!(plant.step().1.is_none()));
    assert_eq!(
        plant.motion.stop().map(|m| m.outcome),
        Some(Outcome::Stopped)
    );
    assert!(plant.motion.stop().is_none());
    assert_eq!(plant.step(), (WheelCommand::STOP, None));
}

#[test]
fn what_cannot_be_done_is_not_started() {
    let mut motion = Motion::new(Parameters::LYNXMOTION_4WD2).unwrap();
    let (turn, far) = (Microdegrees(180_000_001), Micrometres(1_000_001));
    assert_eq!(
        motion.start(turn, Micrometres(0)),
        Err(StartError::OutOfRange)
    );
    assert_eq!(
        motion.start(Microdegrees(0), far),
        Err(StartError::OutOfRange)
    );
    assert_eq!(
        motion.start(Microdegrees(i32::MIN), far),
        Err(StartError::OutOfRange)
    );
    assert_eq!(motion.start(Microdegrees(0), Micrometres(1)), Ok(()));
    assert_eq!(
        motion.start(Microdegrees(0), Micrometres(1)),
        Err(StartError::UnderWay)
    );
}

#[test]
fn parameters_that_do_not_fit_are_refused() {
    let base = Parameters::LYNXMOTION_4WD2;
    assert_eq!(base.check(), Ok(()));
    let cases = [
        (
            Parameters {
                turn_maximum: 279,
                ..base
            },
            ParameterError::TurnDuty,
        ),
        (
            Parameters {
                turn_maximum: 1_001,
                ..base
            },
            ParameterError::TurnDuty,
        ),
        (
            Parameters {
                tolerance: Microdegrees(0),
                ..base
            },
            ParameterError::Tolerance,
        ),
        (
            Parameters {
                dead_band: 450,
                ..base
            },
            ParameterError::AdvanceDuty,
        ),
        (
            Parameters {
                cruise_speed: Micrometres(0),
                ..base
            },
            ParameterError::Speed,
        ),
        (Parameters { ramp: 99, ..base }, ParameterError::Gain),
        (
            Parameters {
                ramp: 10_001,
                ..base
            },
            ParameterError::Gain,
        ),
        (
            Parameters {
                front_stop: Micrometres(99_999),
                ..base
            },
            ParameterError::StopDistance,
        ),
        (
            Parameters {
                in_view: base.front_stop,
                ..base
            },
            ParameterError::Progress,
        ),
        (
            Parameters {
                late: Duration(200_001),
                ..base
            },
            ParameterError::Time,
        ),
    ];
    for (parameters, error) in cases {
        assert_eq!(parameters.check(), Err(error));
        assert!(Motion::new(parameters).is_err());
    }
    let mut motion = Motion::new(base).unwrap();
    assert!(
        motion
            .calibrate_speed(500, Micrometres::from_cm(20), 600)
            .is_err()
    );
    assert_eq!(motion.parameters(), &base);
    assert!(
        motion
            .calibrate_speed(500, Micrometres::from_cm(20), 150)
            .is_ok()
    );
    assert_eq!(motion.parameters().cruise, 500);
}

proptest! {
    /// Whatever is sensed, whenever: nothing panics, every move ends, and nothing but a move
    /// drives the wheels; never forwards against an obstacle, never at all without a heading.
    #[test]
    fn wheels_are_driven_by_moves_only(
        steps in prop::collection::vec(
            (0u64..60_000, prop::option::weighted(0.95, -180_000_000i32..=180_000_000),
             prop::array::uniform3(0u32..800_000), any::<bool>(), -200_000_000i32..200_000_000, 0u32..1_200_000),
            1..400),
    ) {
        let mut motion = Motion::new(Parameters::LYNXMOTION_4WD2).unwrap();
        let mut now = Instant(0);
        for (later, heading, [front, left, right], start, turn, advance) in steps {
            now = now.after(Duration(later));
            if start {
                let _ = motion.start(Microdegrees(turn), Micrometres(advance));
            }
            let clearance = Ranges {
                front: Micrometres(front), left: Micrometres(left), right: Micrometres(right),
            };
            let heading = heading.map(Microdegrees);
            let (command, _) = motion.step(now, Senses { heading, clearance });
            if command.drives() {
                prop_assert!(motion.under_way() && heading.is_some());
            }
            if i32::from(command.left()) + i32::from(command.right()) > 0 {
                prop_assert!(front > 120_000 && left > 110_000 && right > 110_000);
            }
        }
        for i in 1..400 {
            now = now.after(Duration::from_millis(20));
            let far = Micrometres(700_000);
            let clearance = Ranges { front: far, left: far, right: far };
            motion.step(now, Senses { heading: Some(Microdegrees(i)), clearance });
        }
        prop_assert!(!motion.under_way(), "with a compass that is stuck, too");
    }
}
