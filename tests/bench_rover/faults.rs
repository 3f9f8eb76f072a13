//! Faults of the vehicle against the promises of the supervisor's table.

use std::collections::BTreeMap;

use rover_boardless::BoardlessRover;
use rover_emulator::vehicle::{Channel, Fault, Side};
use rover_shared::contract::{
    ChannelHealth, CompassHealth, Fault as Counted, Mode, Outcome, State, Task,
};
use rover_shared::rover::PERIOD;
use rover_shared::time::Duration;
use rover_shared::wire::message::{EventKind, Report};

use super::fixture::{bench, room, scenario};

/// What happened from the beginning of a fault on, with the milliseconds after which it did.
struct Course {
    outcomes: Vec<(u64, Outcome)>,
    events: Vec<(u64, EventKind)>,
    /// When the wheels were last driven.
    driven: u64,
    /// For how long the wheels were driven, from the beginning or a rest to the next rest.
    drives: Vec<u64>,
}

/// Lets a rover drive, breaks something in the middle of a move, and looks for `span`.
fn course<R>(
    fault: Fault,
    span: Duration,
    look: impl FnOnce(&mut BoardlessRover, Course) -> R,
) -> R {
    let into_a_move = |bench: &mut BoardlessRover| {
        bench.run(Duration::from_millis(60_000));
        let mut driven = 0;
        while driven < 10 {
            bench.period();
            driven = if bench.driven() { driven + 1 } else { 0 };
        }
    };
    course_from(fault, span, into_a_move, look)
}

/// Lets a rover drive, goes on to the moment when something is to break, and looks for `span`.
fn course_from<R>(
    fault: Fault,
    span: Duration,
    go_on: impl FnOnce(&mut BoardlessRover),
    look: impl FnOnce(&mut BoardlessRover, Course) -> R,
) -> R {
    let scenario = scenario(&room(500.0, 10.0), 4);
    let mut bench = bench(&scenario, 4);
    bench
        .drive(Mode::Learn, Task::FollowChangingDirection)
        .expect("all is well");
    bench.run(Duration::from_millis(5_000));
    go_on(&mut bench);
    bench.set_faults(&[fault]);
    let (began, mut course) = (bench.now(), Course::new());
    let mut drives = vec![0];
    while bench.now().since(began) < span {
        let reports = bench.period();
        let since = bench.now().since(began).0 / 1_000;
        if bench.driven() {
            course.driven = since;
            *drives.last_mut().expect("one is under way") += 20;
        } else if drives.last() != Some(&0) {
            drives.push(0);
        }
        for report in reports {
            match report {
                Report::Action(record) => course.outcomes.push((since, record.outcome)),
                Report::Event(event) => course.events.push((since, event.kind)),
                _ => {}
            }
        }
    }
    course.drives = drives;
    look(&mut bench, course)
}

impl Course {
    fn new() -> Self {
        Self {
            outcomes: Vec::new(),
            events: Vec::new(),
            driven: 0,
            drives: Vec::new(),
        }
    }

    /// For how long the wheels were driven without a rest, at most.
    fn longest_drive(&self) -> u64 {
        self.drives.iter().copied().max().unwrap_or_default()
    }

    /// Milliseconds until this was first reported.
    fn first(&self, wanted: impl Fn(&EventKind) -> bool) -> u64 {
        let event = self.events.iter().find(|(_, kind)| wanted(kind));
        event
            .unwrap_or_else(|| panic!("it is found out: {:?}", self.events))
            .0
    }
}

const TEN_SECONDS: Duration = Duration::from_millis(10_000);

#[test]
fn a_range_sensor_that_breaks_stops_the_rover_within_half_a_second() {
    for (index, channel) in (0..).zip(Channel::ALL) {
        for (fault, health) in [
            (Fault::IrOpen(channel), ChannelHealth::Open),
            (Fault::IrShorted(channel), ChannelHealth::Shorted),
        ] {
            course(fault, TEN_SECONDS, |bench, course| {
                let found = EventKind::Range {
                    channel: index,
                    health,
                };
                let found = course.first(|kind| *kind == found);
                assert!(found < 500, "{fault}: {found} ms");
                assert!(
                    course.driven < 500,
                    "{fault}: driven until {}",
                    course.driven
                );
                // And it does not go on by itself once it has long been forgotten.
                assert_eq!(bench.state(), State::Faulted(Counted::RangeSensor));
                assert!(!bench.driven() && bench.vehicle().at_rest());
            });
        }
    }
}

/// By the clock, whether it hangs while turning, while advancing, or in the pause between.
#[test]
fn a_range_sensor_that_hangs_stops_the_rover_within_half_a_second() {
    let latest = |channel: Channel, index: u8, periods: u32| {
        course_from(
            Fault::IrFrozen(channel),
            Duration::from_millis(3_000),
            |bench| {
                bench.run(Duration(PERIOD.0 * u64::from(periods)));
            },
            |bench, course| {
                let found = EventKind::Range {
                    channel: index,
                    health: ChannelHealth::Frozen,
                };
                let found = course.first(|kind| *kind == found);
                assert!(found < 500, "{channel:?}, {periods}: found by {found} ms");
                assert!(course.driven < 500, "driven until {}", course.driven);
                assert_eq!(bench.state(), State::Faulted(Counted::RangeSensor));
                found
            },
        )
    };
    // 1.6 s, longer than an action takes.
    let found = (0..80).map(|periods| {
        let index = periods as usize % Channel::ALL.len();
        latest(Channel::ALL[index], index as u8, periods)
    });
    println!("found after {} ms at the latest", found.max().unwrap_or(0));
}

#[test]
fn a_compass_that_is_lost_stops_the_rover_within_a_tenth_of_a_second() {
    for (fault, health) in [
        (Fault::CompassSilent, CompassHealth::Silent),
        (Fault::CompassStuck, CompassHealth::Silent),
        (Fault::CompassGarbage, CompassHealth::Implausible),
    ] {
        course(fault, TEN_SECONDS, |bench, course| {
            assert!(
                course.driven <= 120,
                "{fault}: driven until {}",
                course.driven
            );
            let found = course.first(|kind| *kind == EventKind::Compass(health));
            assert!(found <= 120, "{fault}: {found} ms");
            assert!(matches!(
                course.outcomes.first(),
                Some((..=120, Outcome::CompassLost | Outcome::Stopped))
            ));
            assert_eq!(bench.state(), State::Faulted(Counted::Compass));
            assert!(bench.vehicle().at_rest());
        });
    }
}

/// Wherever it happens. A move that proves nothing (in the open an advance cannot be told from
/// wheels that spin) may be completed in between; the moves without progress are still in a row.
#[test]
fn wheels_that_do_not_move_the_rover_are_stopped_and_disarmed_at_the_third_time() {
    let from = |fault: Fault, periods: u32| {
        course_from(
            fault,
            Duration::from_millis(120_000),
            |bench| {
                bench.run(Duration(PERIOD.0 * u64::from(periods)));
            },
            |bench, course| {
                let what = format!("{fault}, {periods}: {:?}", course.outcomes);
                let stalls = course.outcomes.iter();
                let stalls = stalls.filter(|(_, outcome)| *outcome == Outcome::NoProgress);
                assert_eq!(stalls.count(), 3, "{what}");
                assert_eq!(bench.state(), State::Faulted(Counted::Stuck), "{what}");
                // A second, and once more in the move that the fault falls into: noise may add what
                // a turn of its last moments lacked to be a change.
                let first = course.drives[0];
                let later = course.drives.iter().skip(1).copied().max();
                assert!(first <= 1_940, "{what}: {first} ms");
                assert!(later <= Some(1_020), "{what}: {later:?} ms");
                (course.driven, first, later)
            },
        )
    };
    for fault in [
        Fault::WheelsSlipping(Side::Both),
        Fault::MotorDead(Side::Both),
    ] {
        // Over ten seconds of driving.
        let courses: Vec<_> = (0..40).map(|i| from(fault, i * 13)).collect();
        println!(
            "{fault}: driven for at most {:?} ms, then {:?} ms; for the last time after {:?} ms",
            courses.iter().map(|(_, first, _)| first).max(),
            courses.iter().map(|(_, _, later)| later).max(),
            courses.iter().map(|(driven, _, _)| driven).max(),
        );
    }
}

#[test]
fn half_a_drive_never_drives_for_long_without_a_rest() {
    for side in [Side::Left, Side::Right] {
        for fault in [Fault::WheelsSlipping(side), Fault::MotorDead(side)] {
            course(fault, Duration::from_millis(120_000), |bench, course| {
                // One side alone still turns the rover, so that turns may be made.
                assert!(
                    course.longest_drive() < 4_000,
                    "{fault}: {}",
                    course.longest_drive()
                );
                println!("{fault}: {:?}, {:?}", bench.state(), tally(&course));
            });
        }
    }
}

#[test]
fn what_cannot_be_told_from_the_world_drives_no_longer_than_a_move() {
    let faults = [
        Fault::CompassRotated,
        Fault::IrNoisy(Channel::FrontLeft),
        Fault::IrNoisy(Channel::Right),
    ];
    for fault in faults {
        course(fault, Duration::from_millis(120_000), |bench, course| {
            println!("{fault}: {:?}, {:?}", bench.state(), tally(&course));
            assert!(
                course.longest_drive() < 4_000,
                "{fault}: {}",
                course.longest_drive()
            );
        });
    }
}

/// How often moves ended how.
fn tally(course: &Course) -> BTreeMap<String, u32> {
    let mut tally = BTreeMap::new();
    for (_, outcome) in &course.outcomes {
        *tally.entry(format!("{outcome:?}")).or_default() += 1;
    }
    tally
}
