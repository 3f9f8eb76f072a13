//! Moves that a host asks for: how far they lead, what stops them, and calibrating by them.

use rover_boardless::BoardlessRover;
use rover_shared::contract::{Calibration, Mode, Outcome, Task};
use rover_shared::time::Duration;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{Command, EventKind, Report};
use rover_simulator::arena::{Pose, RobotModel, Scenario, World, degrees};

use super::fixture::bench;

/// An empty room of 4 m, the rover 70 cm from its left wall, its heading as given.
fn in_an_empty_room<R>(heading_deg: f64, act: impl FnOnce(&mut BoardlessRover) -> R) -> R {
    let scenario = Scenario {
        world: World::new(400.0, 400.0, Vec::new()).into(),
        robot: RobotModel::rover(10.0),
        start: Pose {
            x_cm: 70.0,
            y_cm: 200.0,
            heading: degrees(heading_deg),
        },
        goal: None,
    };
    let mut bench = bench(&scenario, 5);
    bench
        .drive(Mode::Idle, Task::FollowDirection)
        .expect("all is well");
    act(&mut bench)
}

fn say(bench: &mut BoardlessRover, command: Command) {
    bench.command(&command).expect("all is well");
}

/// One move, and a second of rest. How it ended, and how far it led.
fn drive(bench: &mut BoardlessRover, turn_deg: i32, advance_cm: u32) -> (Outcome, f64) {
    let from = bench.vehicle().pose().position();
    say(bench, Command::Heartbeat);
    say(bench, Command::SetMode(Mode::Host));
    say(
        bench,
        Command::Drive {
            turn: Microdegrees::from_degrees(turn_deg),
            advance: Micrometres::from_cm(advance_cm),
        },
    );
    let mut outcome = None;
    for _ in 0..100 {
        say(bench, Command::Heartbeat);
        for report in bench.run(Duration::from_millis(200)) {
            if let Report::Event(event) = report
                && let EventKind::MoveEnded(ended) = event.kind
            {
                outcome = Some(ended);
            }
        }
        if outcome.is_some() {
            break;
        }
    }
    bench.run(Duration::from_millis(1_000));
    let way = bench.vehicle().pose().position().distance(from);
    (outcome.expect("every move ends"), way)
}

#[test]
fn a_wall_stops_the_rover_before_it_is_touched() {
    for aside_deg in [-50.0, -30.0, 0.0, 20.0, 45.0] {
        in_an_empty_room(180.0 + aside_deg, |bench| {
            let (outcome, way) = drive(bench, 0, 100);
            assert_eq!(outcome, Outcome::Obstacle, "{aside_deg} degrees");
            assert!(!bench.vehicle().touching(), "{aside_deg} degrees: {way} cm");
            // And it does not begin another advance there.
            let (outcome, way) = drive(bench, 0, 7);
            assert!(outcome == Outcome::Obstacle && way < 1.0, "{way} cm");
        });
    }
}

#[test]
fn an_obstacle_that_comes_up_stops_the_rover_when_its_sensors_have_seen_it() {
    in_an_empty_room(0.0, |bench| {
        say(bench, Command::Heartbeat);
        say(bench, Command::SetMode(Mode::Host));
        say(
            bench,
            Command::Drive {
                turn: Microdegrees(0),
                advance: Micrometres::from_cm(100),
            },
        );
        bench.run(Duration::from_millis(400));
        assert!(bench.driven());
        // The right wall, 10.5 cm before the front sensors.
        let near = Pose {
            x_cm: 400.0 - 15.2 - 10.5,
            ..bench.vehicle().pose()
        };
        bench.vehicle_mut().put(near);
        let began = bench.now();
        while bench.driven() {
            bench.period();
        }
        // A measurement that sees both places, one that sees the wall, and a control period.
        let took = bench.now().since(began);
        assert!(took <= Duration::from_millis(2 * 48 + 40), "{took:?}");
        bench.run(Duration::from_millis(500));
        assert!(bench.vehicle().at_rest() && !bench.vehicle().touching());
    });
}

#[test]
fn turns_end_where_they_should() {
    for turn in [-180, -120, -45, -10, 10, 45, 90, 180] {
        in_an_empty_room(20.0, |bench| {
            let before = bench.vehicle().pose().heading;
            let (outcome, way) = drive(bench, turn, 0);
            assert_eq!(outcome, Outcome::Completed, "{turn} degrees");
            let turned = bench.vehicle().pose().heading.turn_from(before).0;
            let off = f64::from(turned) / 1e6 - f64::from(turn);
            let off = (off + 540.0).rem_euclid(360.0) - 180.0;
            // The tolerance, and twice the compass's iron. Unequal sides lead it astray a little.
            assert!(
                off.abs() < 6.0 && way < 1.5,
                "{turn} degrees: {off} off, {way} cm"
            );
        });
    }
}

/// As the firmware's README says: drive a metre, measure it, and tell the rover.
#[test]
fn a_measured_metre_makes_advances_right() {
    in_an_empty_room(0.0, |bench| {
        let (outcome, metre) = drive(bench, 0, 100);
        assert_eq!(outcome, Outcome::Completed);
        assert!((90.0..110.0).contains(&metre), "{metre} cm");
        say(bench, Command::Disarm);
        let chassis = rover_shared::motion::Parameters::LYNXMOTION_4WD2;
        let speed = f64::from(chassis.cruise_speed.0) * metre / 100.0;
        say(
            bench,
            Command::Calibrate(Calibration::Speed {
                duty: chassis.cruise,
                speed: Micrometres(speed as u32),
                dead_band: chassis.dead_band,
            }),
        );
        say(bench, Command::Arm);
        let ways: Vec<f64> = (0..10).map(|_| drive(bench, 0, 7).1).collect();
        let mean = ways.iter().sum::<f64>() / 10.0;
        assert!((6.65..7.35).contains(&mean), "{mean} cm: {ways:?}");
        let (_, again) = drive(bench, 0, 50);
        assert!((48.5..51.5).contains(&again), "{again} cm");
    });
}
