use std::sync::Arc;

use proptest::prelude::*;
use rover_shared::motion::WheelCommand;

use super::*;
use rover_simulator::arena::{Obstacle, Rect, degrees};

/// A room of 300 by 300 with a block in its middle.
fn scenario(x_cm: f64, y_cm: f64, heading_deg: f64) -> Scenario {
    let block = Rect {
        x_cm: 140.0,
        y_cm: 140.0,
        w_cm: 20.0,
        h_cm: 20.0,
    };
    Scenario {
        world: Arc::new(World::new(300.0, 300.0, vec![Obstacle::Rect(block)])),
        robot: RobotModel::rover(10.0),
        start: Pose {
            x_cm,
            y_cm,
            heading: degrees(heading_deg),
        },
        goal: None,
    }
}

fn vehicle(seed: u64) -> Vehicle {
    Vehicle::new(&scenario(60.0, 150.0, 0.0), &Build::ROVER, seed)
}

fn pins(left: i32, right: i32) -> [SidePins; 2] {
    SidePins::of(WheelCommand::new(left, right))
}

const SECOND: Duration = Duration::from_millis(1_000);

/// Everything that comes out of a vehicle.
fn outputs(vehicle: &mut Vehicle) -> (Pose, [u16; 4], [f64; 4], CompassAnswer, bool) {
    (
        vehicle.pose(),
        vehicle.counts(3),
        vehicle.distances_cm(),
        vehicle.compass(),
        vehicle.touching(),
    )
}

#[test]
fn its_sensors_see_what_the_simulators_see() {
    let scenario = scenario(60.0, 150.0, 0.0);
    let mut vehicle = Vehicle::new(&scenario, &Build::ROVER, 1);
    let robot = Robot::new(&scenario);
    for (channel, seen) in vehicle.distances_cm().into_iter().enumerate() {
        assert_eq!(seen, robot.distance_cm(channel, 150.0));
    }
    // And its counts say so, within the spread of sensors.
    let counts = vehicle.counts(0);
    let curve = vehicle.curve();
    let found =
        curve.distance(rover_shared::sensing::ir::AdcCount::new(counts[0]).expect("12 bits"));
    let (found, true_cm) = (f64::from(found.0) / 1e4, vehicle.distances_cm()[0]);
    assert!(
        (found / true_cm - 1.0).abs() < 0.15,
        "{found} for {true_cm} cm"
    );
}

#[test]
fn it_drives_to_the_block_and_stops_there() {
    let mut vehicle = vehicle(2);
    for _ in 0..10 {
        vehicle.advance(SECOND, pins(450, 450));
    }
    assert!(vehicle.touching());
    let gap = 140.0 - vehicle.pose().x_cm;
    assert!((17.4..18.6).contains(&gap), "{gap}");
}

#[test]
fn sensors_follow_within_their_period() {
    let mut vehicle = vehicle(3);
    let far = vehicle.volts();
    let pose = Pose {
        x_cm: 100.0,
        ..vehicle.pose()
    };
    vehicle.put(pose);
    assert_eq!(vehicle.volts(), far, "a measurement takes its time");
    // The first measurement after it saw both places.
    vehicle.advance(Duration::from_millis(96), pins(0, 0));
    let expected = Characteristic::of(SensorType::Gp2d12).volts(vehicle.distances_cm()[0]);
    assert!((vehicle.volts()[0] / expected - 1.0).abs() < 0.1);
}

#[test]
fn faults_begin_and_end() {
    let mut vehicle = vehicle(4);
    let well = vehicle.counts(0);
    vehicle.set_faults(&[
        Fault::IrOpen(Channel::Left),
        Fault::IrShorted(Channel::Right),
        Fault::CompassStuck,
        Fault::MotorDead(Side::Left),
        Fault::UsbDeaf,
    ]);
    assert!(vehicle.counts(0)[2] < 20 && vehicle.counts(0)[3] == 4_095);
    assert_eq!(vehicle.counts(0)[..2], well[..2]);
    assert_eq!(vehicle.compass(), CompassAnswer::Stuck);
    vehicle.advance(SECOND, pins(450, 450));
    assert!(
        vehicle.pose().heading.0 > 10_000_000,
        "the right side turns it"
    );
    vehicle.set_faults(&[]);
    assert!(matches!(vehicle.compass(), CompassAnswer::Registers(_)));
    assert!(vehicle.counts(0)[2] > 100);
}

#[test]
fn slipping_wheels_lead_nowhere() {
    let mut vehicle = vehicle(5);
    let before = vehicle.pose();
    vehicle.set_faults(&[Fault::WheelsSlipping(Side::Both)]);
    vehicle.advance(SECOND, pins(600, -600));
    assert_eq!(vehicle.pose(), before);
    assert!(!vehicle.at_rest());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// However time is sliced, and however often it is observed.
    #[test]
    fn a_run_repeats_in_slices_of_any_length(
        seed: u64, slices in prop::collection::vec(1u64..30_000, 1..60),
        left in -700i32..700, right in -700i32..700,
    ) {
        let (mut sliced, mut whole) = (vehicle(seed), vehicle(seed));
        for slice in &slices {
            sliced.advance(Duration(*slice), pins(left, right));
            outputs(&mut sliced);
        }
        whole.advance(Duration(slices.iter().sum()), pins(left, right));
        prop_assert_eq!(outputs(&mut sliced), outputs(&mut whole));
    }

    #[test]
    fn at_rest_nothing_but_noise_changes(seed: u64) {
        let mut vehicle = vehicle(seed);
        let (pose, distances) = (vehicle.pose(), vehicle.distances_cm());
        for _ in 0..20 {
            vehicle.advance(Duration::from_millis(250), pins(0, 0));
            prop_assert!(vehicle.at_rest());
            prop_assert_eq!(vehicle.pose(), pose);
            prop_assert_eq!(vehicle.distances_cm(), distances);
        }
    }

    #[test]
    fn whatever_is_driven_the_body_stays_outside(
        seed: u64,
        moves in prop::collection::vec((-1_000i32..=1_000, -1_000i32..=1_000, 1u32..1_500), 1..30),
    ) {
        let mut vehicle = vehicle(seed);
        for (left, right, milliseconds) in moves {
            vehicle.advance(Duration::from_millis(milliseconds), pins(left, right));
            let clearance = vehicle.world().clearance(vehicle.pose().position());
            prop_assert!(clearance >= vehicle.model().contact_radius_cm, "{clearance}");
            prop_assert!(vehicle.counts(0).iter().all(|&counts| counts <= 4_095));
        }
    }
}
