//! A day of driving by the real firmware on the emulated board: nothing resets, drifts, leaks or is
//! miscounted.
//!
//! Last run of the whole day, in 21 minutes: 57,026 actions, 1,260 of them stopped by an obstacle, no
//! reset, never disarmed by itself; 180,004 control periods in the first hour and in the last, at most
//! 63 us off the grid of 20 ms; 7,060 bytes of stack after the first hour as after the last.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/bench.rs"]
#[allow(dead_code, reason = "it serves the faults, too")]
mod bench;
#[path = "board_day/tally.rs"]
mod tally;
#[path = "support/thumb.rs"]
mod thumb;
#[path = "board_day/ticks.rs"]
mod ticks;

use std::time::Instant;

use bench::{Bench, ms, room};
use rover_shared::contract::{Fault, Mode, ResetReason, State, Task};
use rover_shared::time::Duration;
use rover_shared::wire::frame::{Encoder, MAX_FRAME};
use rover_shared::wire::message::{Command, Report, Status};
use tally::Tally;
use ticks::Ticks;

/// Parts of the drive of which figures are shown: the hours of the day.
const PARTS: u32 = 24;

/// Drives for 24 parts of so many seconds each.
fn drive(part_s: u32) {
    let began = Instant::now();
    let mut bench = Bench::in_scenario(&room(), &[]);
    let burst = longest_burst(&mut bench);
    let before = bench.status();
    let behind = clock_offset(&bench);
    start(&mut bench);
    bench.client.send_heartbeats(true).unwrap();
    let mut tally = Tally::new(&before);
    let mut stack = None;
    let mut ticks = Vec::new();
    for part in 1..=PARTS {
        let ends_of_day = part == 1 || part == PARTS;
        let mut measured = ends_of_day.then(|| Ticks::begin(&mut bench.rover.borrow_mut()));
        for _ in 0..part_s {
            bench.wait(ms(1_000));
            if hear(&mut bench, &mut tally) {
                start(&mut bench);
                tally.armed_again += 1;
            }
            if let Some(measured) = &mut measured {
                measured.collect(&mut bench.rover.borrow_mut());
            }
        }
        if let Some(measured) = measured {
            ticks.push(measured.end(&mut bench.rover.borrow_mut()));
        }
        let rover = bench.rover.borrow();
        let deepest = rover.machine().stack_high_water().unwrap();
        stack.get_or_insert(deepest);
        eprintln!(
            "{part:2} of {PARTS}, {:.0} s emulated in {:.0}: {tally}; stack {deepest} bytes",
            rover.now().0 as f64 / 1e6,
            began.elapsed().as_secs_f64(),
        );
        tally.next_part();
    }
    let deepest = bench.rover.borrow().machine().stack_high_water().unwrap();
    let after = stop(&mut bench, &mut tally);
    let burst_after = longest_burst(&mut bench);
    for ticks in &ticks {
        eprintln!("control: {ticks}");
    }
    eprintln!("pings at once that are answered: {burst} before, {burst_after} after");

    // No reset.
    let rover = bench.rover.clone();
    assert_eq!(rover.borrow().machine().incidents().count(), 0);
    assert_eq!(bench.client.hello().reset, ResetReason::PowerOn);
    assert_eq!(tally.hellos, 0);
    // No drift: of the board's clock, and of the ticks that come by it.
    assert_eq!(clock_offset(&bench), behind);
    let seconds = u64::from(part_s);
    for ticks in &ticks {
        // A second of listening ends with what was heard in it, some milliseconds late at times.
        assert!(ticks.count >= 50 * seconds - 1, "{ticks}");
        assert_eq!(ticks.count, ticks.due(), "{ticks}");
        assert!(ticks.latest_us < 20_000, "{ticks}");
    }
    assert!(ticks[1].shifted_us(&ticks[0]) < 1_000);
    assert!(ticks[1].mean_us < ticks[0].mean_us + 100.0);
    assert!(tally.latest_sample_us() < 5_000);
    // No leak.
    assert_eq!(bench.client.counters().lost, 0);
    assert_eq!(bench.client.counters().damaged, 0);
    assert!(deepest <= stack.unwrap() + 256, "{deepest} after {stack:?}");
    assert_eq!(burst_after, burst);
    // All counters agree.
    tally.check(&before, &after);
}

/// By how many microseconds the board's clock is behind the emulator's.
fn clock_offset(bench: &Bench) -> u64 {
    let rover = bench.rover.borrow();
    rover.now().0 - rover.machine().timer_us()
}

/// Arms and has the rover learn.
fn start(bench: &mut Bench) {
    bench.done(Command::SetTask(Task::FollowChangingDirection));
    bench.done(Command::Arm);
    bench.done(Command::SetMode(Mode::Learn));
}

/// Counts what was heard; gives whether the rover has disarmed itself and is free to be armed.
fn hear(bench: &mut Bench, tally: &mut Tally) -> bool {
    for report in std::mem::take(&mut bench.heard) {
        tally.hear(&report, &bench.rover.borrow());
    }
    let State::Faulted(fault) = tally.state else {
        return false;
    };
    eprintln!("disarmed: {fault:?} at {:.0} s", bench.now().0 as f64 / 1e6);
    stop(bench, tally);
    true
}

/// Disarms, and waits until the knowledge is kept.
fn stop(bench: &mut Bench, tally: &mut Tally) -> Status {
    bench.done(Command::Disarm);
    bench.wait(ms(4_000));
    for report in std::mem::take(&mut bench.heard) {
        tally.hear(&report, &bench.rover.borrow());
    }
    bench.status()
}

/// How many pings at once are all answered by a disarmed rover whose host does not listen for a while
/// that is too short for any write to be given up: what fits into the queue of answers, and into
/// those who fill and empty it.
fn longest_burst(bench: &mut Bench) -> usize {
    const LONGEST: usize = 30;
    bench.client.send_heartbeats(false).unwrap();
    bench.client.keep_answers(true);
    let all_answered = |&pings: &usize| {
        bench.wait(ms(500));
        bench.heard.clear();
        bench.fault("0+0.035:usb-deaf");
        bench.run(ms(2));
        let mut encoder = Encoder::new();
        for _ in 0..pings {
            let mut buffer = [0; MAX_FRAME];
            let frame = encoder.encode(&Command::Ping, &mut buffer).unwrap();
            bench.rover.borrow_mut().send(frame);
        }
        bench.wait(ms(1_000));
        let answers = bench.heard.iter();
        let answers = answers.filter(|report| matches!(report, Report::Ack(_)));
        answers.count() == pings
    };
    let longest = (1..LONGEST).take_while(all_answered).last().unwrap_or(0);
    bench.client.keep_answers(false);
    bench.heard.clear();
    assert!((2..LONGEST - 1).contains(&longest), "{longest}");
    assert!(
        bench.count(Fault::QueueFull) > 0,
        "one ping more is too many"
    );
    longest
}

/// The same for minutes, so that the day is known to work.
#[test]
fn some_minutes_of_driving_add_up() {
    drive(10);
}

/// `cargo test --release --test board_day -- --ignored --nocapture`
#[test]
#[ignore = "24 hours of the board: some 25 minutes"]
fn a_day_of_driving_adds_up() {
    let hour = Duration::from_millis(3_600_000);
    drive((hour.0 / 1_000_000) as u32);
}
