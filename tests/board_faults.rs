//! What the supervisor promises, row by row, kept by the real firmware on the emulated board: a fault
//! is injected, and the promise and its time are checked. Times are looked at every millisecond.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/bench.rs"]
mod bench;
#[path = "support/thumb.rs"]
mod thumb;

use bench::{Bench, FIRMWARE, ms, room};
use emulated_rp2040::incident::Kind;
use rover_emulator::Emulation;
use rover_shared::action::Action;
use rover_shared::contract::{
    ChannelHealth, CompassHealth, Fault, FaultReport, Mode, Outcome, Refusal, ResetReason, State,
};
use rover_shared::time::Duration;
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::{Command, EventKind, Report};

/// Slices that board and test may be apart.
const SLACK: Duration = ms(2);

// Any reset: disarmed, PWM 0, reason reported.

#[test]
fn a_brown_out_while_moving_comes_up_disarmed() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0:brown-out");
    bench.stops_within(SLACK, ms(3_000));
    bench.reconnect();
    assert_eq!(bench.client.hello().reset, ResetReason::PowerOn);
    bench.disarmed();
}

#[test]
fn the_run_pin_is_told_from_power() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.rover.borrow_mut().machine_mut().pulse_run_pin();
    bench.stops_within(SLACK, ms(3_000));
    bench.reconnect();
    assert_eq!(bench.client.hello().reset, ResetReason::RunPin);
    bench.disarmed();
}

#[test]
fn power_that_is_cut_while_moving_comes_back_disarmed() {
    let mut bench = Bench::driving(Mode::Learn, &[]);
    bench.fault("0+0.5:power-cut");
    bench.stops_within(SLACK, ms(3_000));
    bench.reconnect();
    assert_eq!(bench.client.hello().reset, ResetReason::PowerOn);
    bench.disarmed();
}

// Arm with a bad sensor, knowledge or schema: refused, reason named.

#[test]
fn arming_is_refused_with_a_bad_sensor() {
    for (what, refusal) in [
        (
            "ir left open",
            Refusal::RangeSensor {
                channel: 2,
                health: ChannelHealth::Open,
            },
        ),
        (
            "ir front right shorted",
            Refusal::RangeSensor {
                channel: 1,
                health: ChannelHealth::Shorted,
            },
        ),
        ("compass silent", Refusal::Compass(CompassHealth::Silent)),
        ("compass stuck", Refusal::Compass(CompassHealth::Silent)),
    ] {
        let mut bench = Bench::new(&[]);
        bench.fault(&format!("0:{what}"));
        bench.wait(ms(1_500));
        assert_eq!(bench.refused(Command::Arm), refusal, "{what}");
        bench.disarmed();
    }
}

#[test]
fn arming_is_refused_with_damaged_knowledge() {
    let mut bench = Bench::driving(Mode::Learn, &[]);
    bench.wait(ms(5_000));
    bench.done(Command::Disarm);
    bench.wait(ms(3_000));
    let rover = bench.rover.clone();
    // Both slots: what is whole in one would be loaded.
    for byte in &mut rover.borrow_mut().machine_mut().flash_mut()[0x1e_2000..0x1f_a000] {
        *byte &= 0x5a;
    }
    bench.fault("0:power-cut");
    bench.run(ms(2_000));
    bench.reconnect();
    assert_eq!(bench.client.hello().knowledge, None);
    bench.wait(ms(1_000));
    assert_eq!(bench.refused(Command::Arm), Refusal::KnowledgeInvalid);
    bench.done(Command::NewKnowledge);
    bench.done(Command::Arm);
}

#[test]
fn arming_is_refused_without_the_right_schema() {
    let mut bench = Bench::new(&[]);
    assert_eq!(
        bench.refused(Command::Hello { schema: 0 }),
        Refusal::SchemaMismatch
    );
    assert_eq!(bench.refused(Command::Arm), Refusal::SchemaMismatch);
}

// Control loop silent: 200 ms, PWM 0. Any task silent: 1 s, reset, comes up disarmed.

fn hangs(task: &str, stops_within: Duration) {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault(&format!("0+1.2:task-{task}-hang"));
    bench.stops_within(stops_within, ms(1_000));
    let resets = |bench: &Bench| {
        let rover = bench.rover.borrow();
        let incidents = rover.machine().incidents().first().to_vec();
        incidents
            .into_iter()
            .filter(|incident| matches!(incident.kind, Kind::Watchdog { .. }))
            .count()
    };
    assert!(resets(&bench) >= 1, "{task}: no reset within 1 s");
    bench.run(ms(3_000));
    assert!(!bench.rover.borrow().motors_driven());
    bench.reconnect();
    assert_eq!(bench.client.hello().reset, ResetReason::Watchdog);
    bench.disarmed();
}

/// A task that does not come back keeps all others from their turns: they share one executor. So
/// control is silent too.
#[test]
fn a_hanging_control_task_stops_the_motors_and_resets_the_board() {
    hangs("control", ms(200));
}

#[test]
fn a_hanging_sense_task_stops_the_motors_and_resets_the_board() {
    hangs("sense", ms(200));
}

#[test]
fn a_hanging_drive_task_stops_the_motors_and_resets_the_board() {
    hangs("drive", ms(200));
}

#[test]
fn a_hanging_link_task_stops_the_motors_and_resets_the_board() {
    hangs("link", ms(1_000));
}

#[test]
fn a_hanging_store_task_stops_the_motors_and_resets_the_board() {
    hangs("store", ms(1_000));
}

#[test]
fn a_control_loop_that_overruns_goes_on_or_stops_but_never_blindly() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0+5:control-overrun");
    bench.wait(ms(5_500));
    // 50 ms a turn is within all limits: the rover goes on more slowly.
    assert_eq!(bench.status().state, State::Driving(Mode::Run));
    bench.wait(ms(5_000));
    assert!(bench.outcomes().contains(&Outcome::Completed));
}

// Obstacle closer than the hard stop while moving: stopped within a sensor period, counts as blocked.

#[test]
fn an_obstacle_stops_the_move_and_counts_as_blocked() {
    let mut scenario = room();
    // The upper wall is 34 cm from the front sensors.
    scenario.start.y_cm = 500.0 - 17.5 - 30.0;
    scenario.start.x_cm = 300.0;
    let mut bench = Bench::in_scenario(&scenario, &[]);
    bench.host_drives(0, 40);
    bench.wait(ms(5_000));
    let ended = EventKind::MoveEnded(Outcome::Obstacle);
    assert!(bench.events().contains(&ended));
    assert_eq!(bench.count(Fault::Blocked), 1);
    let rover = bench.rover.borrow();
    assert!(!rover.vehicle().touching(), "{:?}", rover.vehicle().pose());
}

// IR channel open, shorted or frozen while moving: treated as an obstacle, then stop, within 0.5 s.

fn range_fault(what: &str, health: ChannelHealth) {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.wait(ms(2_000));
    bench.events();
    bench.fault(&format!("0:{what}"));
    bench.wait(ms(4_000));
    let noticed =
        |kind: &EventKind| matches!(kind, EventKind::Range { health: h, .. } if *h == health);
    assert!(bench.events().iter().any(noticed), "{what}: not noticed");
    assert_eq!(
        bench.status().state,
        State::Faulted(Fault::RangeSensor),
        "{what}"
    );
    assert!(!bench.rover.borrow().motors_driven());
}

#[test]
fn an_open_range_sensor_stops_and_disarms() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0:ir-front-left-open");
    bench.stops_within(ms(500), ms(3_000));
    range_fault("ir-right-open", ChannelHealth::Open);
}

#[test]
fn a_shorted_range_sensor_stops_and_disarms() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0:ir-left-shorted");
    bench.stops_within(ms(500), ms(3_000));
    range_fault("ir-front-right-shorted", ChannelHealth::Shorted);
}

#[test]
fn a_frozen_range_sensor_stops_and_disarms() {
    range_fault("ir-front-left-frozen", ChannelHealth::Frozen);
}

/// While turning, while advancing, in the pause between two moves: half a second by the clock.
#[test]
fn a_range_sensor_that_freezes_at_any_moment_of_the_action_cycle_stops_in_time() {
    const STEP_MS: u32 = 60;
    const CHANNELS: [&str; 4] = ["front-left", "front-right", "left", "right"];
    // Some 1.4 s an action.
    for (moment, channel) in (0..25).zip(CHANNELS.iter().cycle()) {
        let mut bench = Bench::driving(Mode::Run, &[]);
        bench.wait(ms(1_000 + moment * STEP_MS));
        bench.events();
        bench.fault(&format!("0:ir-{channel}-frozen"));
        let last = bench.driven_last(ms(1_500));
        println!("{} ms: {} ms", moment * STEP_MS, last.0 / 1_000);
        assert!(last <= ms(500), "{} ms: {last:?}", moment * STEP_MS);
        bench.wait(ms(1_500));
        assert_eq!(bench.status().state, State::Faulted(Fault::RangeSensor));
        let health = |kind: &EventKind| match kind {
            EventKind::Range { health, .. } => Some(*health),
            _ => None,
        };
        let noticed: Vec<_> = bench.events().iter().filter_map(health).collect();
        assert_eq!(noticed, [ChannelHealth::Frozen], "{} ms", moment * STEP_MS);
    }
}

/// At rest nothing tells it from a still picture: so the first move is short.
#[test]
fn a_range_sensor_that_froze_at_rest_stops_the_first_move() {
    let mut bench = Bench::new(&[]);
    bench.fault("0:ir-right-frozen");
    bench.wait(ms(3_000));
    assert_eq!(bench.status().ranges, [ChannelHealth::Good; 4]);
    bench.drive(Mode::Run);
    // 120 ms of driving, a sampling and a control period.
    bench.stops_within(ms(170), ms(3_000));
    assert_eq!(bench.status().state, State::Faulted(Fault::RangeSensor));
}

#[test]
fn a_noisy_range_sensor_does_no_harm() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0+20:ir-left-noisy");
    for _ in 0..20 {
        bench.wait(ms(1_000));
        assert!(!bench.rover.borrow().vehicle().touching());
    }
}

// Compass silent or implausible: 100 ms, finish no turn blindly: stop.

fn compass_fault(what: &str, health: CompassHealth) {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault(&format!("0:{what}"));
    bench.stops_within(ms(100), ms(1_500));
    bench.wait(ms(2_000));
    assert_eq!(bench.status().compass, health, "{what}");
    assert_eq!(
        bench.status().state,
        State::Faulted(Fault::Compass),
        "{what}"
    );
    bench.done(Command::Disarm);
    bench.disarmed();
}

#[test]
fn a_silent_compass_stops_and_disarms() {
    compass_fault("compass-silent", CompassHealth::Silent);
}

#[test]
fn a_compass_that_holds_the_bus_stops_and_disarms() {
    compass_fault("compass-stuck", CompassHealth::Silent);
}

#[test]
fn a_compass_that_talks_nonsense_stops_and_disarms() {
    compass_fault("compass-garbage", CompassHealth::Implausible);
}

#[test]
fn a_stuck_bus_is_freed_and_the_compass_comes_back() {
    let mut bench = Bench::new(&[]);
    bench.fault("0+1:compass-stuck");
    bench.wait(ms(4_000));
    assert!(bench.count(Fault::BusRecovered) >= 1);
    assert_eq!(bench.status().compass, CompassHealth::Good);
    bench.done(Command::Arm);
}

/// A bearing that jumps by 90 degrees cannot be true; one that stays there can.
#[test]
fn a_compass_that_jumps_stops_the_motors() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0:compass-rotated");
    bench.wait(ms(300));
    assert!(bench.count(Fault::Compass) >= 1);
}

// Wheels driven, but neither heading nor ranges change: 1 s, blocked; 3 in a row disarm.

fn no_progress(what: &str) {
    let mut bench = Bench::new(&[]);
    // In sight of a wall: ranges tell that it does not come nearer.
    let pose = rover_simulator::arena::Pose {
        x_cm: 250.0,
        y_cm: 500.0 - 17.5 - 35.0,
        heading: Microdegrees::from_degrees(90),
    };
    bench.rover.borrow_mut().vehicle_mut().put(pose);
    bench.wait(ms(1_000));
    bench.drive(Mode::Run);
    bench.fault(&format!("0:{what}"));
    // The move that the fault falls into may take as long again, by what changed just before.
    const LOOK: Duration = ms(20);
    let (mut longest, mut driven) = ([Duration::ZERO; 2], Duration::ZERO);
    let mut first = 0;
    for _ in 0..600 {
        bench.wait(LOOK);
        if bench.rover.borrow().motors_driven() {
            driven = driven.plus(LOOK);
            longest[first] = longest[first].max(driven);
        } else {
            (driven, first) = (Duration::ZERO, 1);
        }
    }
    assert!(longest[0] <= ms(1_960), "{what}: {longest:?}");
    assert!(longest[1] <= ms(1_040), "{what}: {longest:?}");
    println!("{what}: {longest:?}");
    assert!(bench.count(Fault::NoProgress) >= 3, "{what}");
    assert_eq!(bench.status().state, State::Faulted(Fault::Stuck), "{what}");
    bench.stops_within(Duration::ZERO, ms(2_000));
}

#[test]
fn dead_motors_are_noticed_and_disarm() {
    no_progress("motor-both-dead");
}

#[test]
fn slipping_wheels_are_noticed_and_disarm() {
    no_progress("wheels-both-slipping");
}

#[test]
fn a_dead_motor_on_one_side_does_no_harm() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0:motor-left-dead");
    for _ in 0..15 {
        bench.wait(ms(1_000));
        assert!(!bench.rover.borrow().vehicle().touching());
    }
}

// Host's heartbeat lost while host-driven: 0.5 s warn, 2 s stop, disarm. Autonomous modes go on.

#[test]
fn a_driving_host_that_is_unplugged_stops_the_rover() {
    let mut bench = Bench::new(&[]);
    bench.host_drives(0, 60);
    bench.fault("0+4:usb-unplugged");
    bench.stops_within(ms(2_000), ms(4_500));
    bench.reconnect();
    assert_eq!(bench.status().state, State::Faulted(Fault::HostLost));
    assert!(bench.count(Fault::HostLate) >= 1);
}

#[test]
fn a_rover_that_drives_by_itself_goes_on_without_a_host() {
    let mut bench = Bench::driving(Mode::Learn, &[]);
    bench.fault("0+10:usb-unplugged");
    bench.run(ms(8_000));
    assert!(bench.driven_within(ms(2_000)));
    bench.run(ms(3_000));
    bench.reconnect();
    assert_eq!(bench.status().state, State::Driving(Mode::Learn));
    assert!(bench.status().steps > 5);
}

// Flash write asked while armed: refused.

#[test]
fn the_flash_is_not_written_while_armed() {
    let mut bench = Bench::driving(Mode::Learn, &[]);
    bench.wait(ms(3_000));
    let before = bench.rover.borrow().machine().flash_operations();
    assert_eq!(bench.refused(Command::StoreKnowledge), Refusal::Armed);
    bench.wait(ms(3_000));
    assert_eq!(bench.rover.borrow().machine().flash_operations(), before);
    assert_eq!(bench.count(Fault::FlashWhileArmed), 1);
}

/// Saves what was learned in the last seconds, which disarming does.
fn learn_and_disarm(bench: &mut Bench) {
    bench.drive(Mode::Learn);
    bench.wait(ms(3_000));
    bench.done(Command::Disarm);
}

#[test]
fn a_flash_at_its_slowest_and_a_deaf_host_together_reset_nothing() {
    let mut bench = Bench::new(&[]);
    bench.fault("0:flash-slow");
    for save in 0..8u32 {
        let before = bench.rover.borrow().machine().flash_operations();
        learn_and_disarm(&mut bench);
        bench.fault("0+6:usb-deaf");
        // Answers are written to the deaf host from different moments of the erasure on.
        bench.run(ms(10 * save));
        for _ in 0..100 {
            let _ = bench.client.post(&Command::ReadStatus);
            bench.run(ms(60));
        }
        bench.wait(ms(500));
        let operations = bench.rover.borrow().machine().flash_operations() - before;
        assert!(operations >= 3, "{operations} operations");
        let hello = bench.client.hello().reset;
        assert_eq!(hello, ResetReason::PowerOn, "save {save}");
        let incidents = bench.rover.borrow().machine().incidents().first().to_vec();
        assert!(incidents.is_empty(), "save {save}: {incidents:?}");
        assert_eq!(bench.count(Fault::FlashFailed), 0);
        assert_eq!(bench.count(Fault::TaskSilent), 0);
    }
}

#[test]
fn commands_wait_for_a_save_to_end() {
    let mut bench = Bench::new(&[]);
    learn_and_disarm(&mut bench);
    let saves = |rover: &Emulation| rover.machine().flash_busy();
    assert!(bench.rover.borrow_mut().run_until(ms(1_000), saves));
    let asked = bench.now();
    bench.done(Command::Arm);
    assert!(bench.now().since(asked) > ms(40), "it was too late");
    bench.done(Command::Disarm);
}

#[test]
fn power_is_cut_in_the_middle_of_the_flash_operations_that_were_named() {
    let mut bench = Bench::new(&["flash 2+0.7:power-cut", "flash 3:power-cut"]);
    for (operations, away) in [(2, ms(700)), (3, ms(100))] {
        learn_and_disarm(&mut bench);
        let rover = bench.rover.clone();
        let cut = |rover: &Emulation| !rover.machine().powered();
        assert!(rover.borrow_mut().run_until(ms(3_000), cut));
        assert_eq!(rover.borrow().machine().flash_operations(), operations);
        let began = bench.now();
        assert!(rover.borrow_mut().run_until(ms(3_000), |rover| !cut(rover)));
        let was_away = bench.now().since(began);
        assert!(was_away.0.abs_diff(away.0) <= SLACK.0, "{was_away:?}");
        bench.reconnect();
        bench.disarmed();
        bench.wait(ms(1_000));
    }
}

// Panic, hard fault: PWM 0 in the handler, text kept over the reset.

fn last_words(bench: &mut Bench) -> String {
    bench.run(ms(2_500));
    bench.reconnect();
    bench.wait(ms(500));
    let text = bench.heard.iter().find_map(|report| match report {
        Report::LastWords(text) => Some(text.to_string()),
        _ => None,
    });
    text.expect("last words")
}

#[test]
fn a_hard_fault_switches_the_motors_off_and_says_where_it_was() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.rover.borrow_mut().machine_mut().jump(0x3000_0000);
    bench.stops_within(SLACK, ms(500));
    let words = last_words(&mut bench);
    assert!(words.contains("hard fault at 0x30000000"), "{words}");
    assert_eq!(bench.client.hello().reset, ResetReason::HardFault);
    bench.disarmed();
}

// (A panic, which needs a place in the program to name: `board/resets.rs`.)

// Bad frame: dropped, counted, resynchronised at the next 0.

#[test]
fn garbage_on_the_cable_is_dropped_and_counted() {
    let mut bench = Bench::new(&[]);
    bench.fault("0+2:usb-garbage-in");
    bench.run(ms(2_100));
    assert!(bench.count(Fault::BadFrame) > 10);
    bench.done(Command::Arm);
}

#[test]
fn garbage_from_the_rover_is_dropped_and_counted_by_the_host() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0+4:usb-garbage-out");
    bench.wait(ms(5_000));
    assert!(bench.client.counters().damaged > 10);
    bench.done(Command::Disarm);
}

#[test]
fn truncated_frames_are_dropped_and_the_next_is_heard() {
    let mut bench = Bench::new(&[]);
    bench.fault("0+5:usb-truncated-in");
    bench.run(SLACK);
    let mut heard = 0;
    for _ in 0..60 {
        heard += u32::from(bench.client.ask(&Command::Ping).is_ok());
    }
    assert!(heard > 20, "{heard} of 60 heard");
    bench.run(ms(5_000));
    assert!(bench.count(Fault::BadFrame) > 0);
}

#[test]
fn truncated_frames_from_the_rover_are_dropped_and_counted_by_the_host() {
    let mut bench = Bench::driving(Mode::Run, &[]);
    bench.fault("0+20:usb-truncated-out");
    bench.wait(ms(20_500));
    let counters = bench.client.counters();
    assert!(counters.damaged > 0 && counters.lost > 0, "{counters:?}");
    assert!(counters.received > 5, "{counters:?}");
    bench.done(Command::Disarm);
    bench.disarmed();
}

// Lattice unsettled at the step cap: safe action, counted.

/// Where the lattice's coefficients for the modes are in the flash: in front of what says how long
/// a step is and until when, with 16 64-bit factors between.
fn mode_coefficients() -> Vec<std::ops::Range<usize>> {
    const FLASH: u32 = 0x1000_0000;
    /// Four words for each of 16 modes.
    const MODES: usize = 16 * 4 * 4;
    const FACTORS: usize = 16 * 8;
    let table = FIRMWARE.symbols_with(&["14rover_firmware12COEFFICIENTS"]);
    let table = table.last().expect("the tables are in the firmware");
    let flash = Bench::new(&[]).rover.borrow().machine().flash().to_vec();
    let start = (table.address - FLASH) as usize;
    let place = |length: u32, until: u32| {
        let bytes = [length.to_le_bytes(), until.to_le_bytes()].concat();
        let mut places = (start + MODES + FACTORS..start + table.size as usize)
            .step_by(4)
            .filter(|&place| flash[place..].starts_with(&bytes));
        let (place, None) = (places.next().expect("a schedule"), places.next()) else {
            panic!("two schedules with steps of {length}");
        };
        let modes = place - FACTORS - MODES;
        modes..modes + MODES
    };
    [(2, 64), (4, 192), (8, 768), (16, u32::MAX)]
        .map(|(length, until)| place(length, until))
        .to_vec()
}

/// With coefficients that read as zeros the lattice stays where it started, and never saturates.
#[test]
fn a_lattice_that_does_not_settle_keeps_the_rover_where_it_is() {
    let places = mode_coefficients();
    let mut bench = Bench::driving(Mode::Learn, &[]);
    bench.wait(ms(10_000));
    let before = bench.actions();
    assert!(before.iter().all(|action| !action.step.unsettled()));
    assert!(before.len() > 3, "{} actions", before.len());
    let rover = bench.rover.clone();
    let swap = |contents: &mut [Vec<u8>]| {
        for (place, content) in places.iter().zip(contents) {
            rover.borrow_mut().machine_mut().flash_mut()[place.clone()].swap_with_slice(content);
        }
    };
    let mut contents: Vec<_> = places.iter().map(|place| vec![0; place.len()]).collect();
    swap(&mut contents);
    // The action under way, and the first that is not chosen.
    bench.wait(ms(3_000));
    let pose = rover.borrow().vehicle().pose();
    bench
        .heard
        .retain(|report| matches!(report, Report::Action(action) if action.step.unsettled()));
    assert_eq!(bench.driven_last(ms(5_000)), Duration::ZERO);
    bench.wait(ms(5_000));
    assert_eq!(rover.borrow().vehicle().pose(), pose);
    let counted = bench.count(Fault::Unsettled);
    let told = bench.heard.iter().filter_map(|report| match report {
        Report::Fault(FaultReport {
            fault: Fault::Unsettled,
            count,
            ..
        }) => Some(*count),
        _ => None,
    });
    assert_eq!(told.max(), Some(counted));
    let actions = bench.actions();
    assert_eq!(counted as usize, actions.len());
    for (i, action) in actions.iter().enumerate() {
        assert_eq!(action.step.perceived, None);
        assert_eq!(action.step.action, Action::STAY);
        assert_eq!(action.outcome, Outcome::Completed);
        // What the action before it led to, there was one only at first.
        assert!(i == 0 || action.step.learned.is_none());
    }
    assert_eq!(bench.status().state, State::Driving(Mode::Learn));
    // The longest perception there can be holds nothing up.
    for fault in [Fault::ControlSilent, Fault::TaskSilent, Fault::LateStep] {
        assert_eq!(bench.count(fault), 0, "{fault:?}");
    }
    // And the next that settles decides.
    swap(&mut contents);
    bench.wait(ms(8_000));
    let mut after = bench.actions();
    after.retain(|action| !action.step.unsettled());
    assert!(after.len() > 3 && after[0].step.learned.is_none());
    assert!(
        after[1..]
            .iter()
            .any(|action| action.step.learned.is_some())
    );
    assert_ne!(rover.borrow().vehicle().pose(), pose);
}

// Telemetry queue full: dropped and counted; control never waits.

#[test]
fn a_host_that_reads_nothing_holds_nothing_up() {
    let mut deaf = Bench::driving(Mode::Run, &[]);
    deaf.fault("0+60:usb-deaf");
    deaf.run(ms(60_500));
    deaf.wait(ms(500));
    let mut listening = Bench::driving(Mode::Run, &[]);
    listening.wait(ms(61_000));
    let (deaf_steps, steps) = (deaf.status().steps, listening.status().steps);
    assert!(deaf_steps.abs_diff(steps) <= 1, "{deaf_steps} and {steps}");
    assert!(deaf.count(Fault::QueueFull) > 0);
    assert_eq!(listening.count(Fault::QueueFull), 0);
}
