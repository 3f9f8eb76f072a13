//! What the firmware makes of a bus or a converter that fails, down to the lines.

use emulated_rp2040::i2c::LineFault;
use rover_shared::contract::{ChannelHealth, CompassHealth, Fault};
use rover_shared::wire::message::{Command, Report, Status};

use crate::rig::Bench;

/// A rover at rest that has heard its sensors for a while.
fn settled() -> Bench {
    let mut bench = Bench::connected(1);
    bench.run(1_000);
    let status = status(&mut bench);
    assert_eq!(status.compass, CompassHealth::Good);
    assert_eq!(status.ranges, [ChannelHealth::Good; 4]);
    assert_eq!(status.counters.of(Fault::BusRecovered), 0);
    bench
}

fn status(bench: &mut Bench) -> Status {
    bench.send(&Command::ReadStatus);
    let answer = bench.wait(1_000, |report| matches!(report, Report::Status(_)));
    let Some(Report::Status(status)) = answer else {
        panic!("no status");
    };
    status
}

fn break_bus(bench: &mut Bench, fault: LineFault) {
    let now = bench.machine.now();
    bench.machine.i2c_mut(1).set_fault(fault, now);
}

#[test]
fn a_device_that_lost_count_is_freed_by_nine_pulses() {
    let mut bench = settled();
    break_bus(&mut bench, LineFault::DataLowFor { pulses: 9 });
    bench.run(200);
    let fault = bench.machine.i2c_mut(1).fault();
    assert_eq!(fault, LineFault::None);
    let status = status(&mut bench);
    assert_eq!(status.compass, CompassHealth::Good);
    assert_eq!(status.counters.of(Fault::BusRecovered), 1);
}

/// The bus hangs for two seconds; everything else goes on.
fn hangs(fault: LineFault) {
    let mut bench = settled();
    break_bus(&mut bench, fault);
    bench.run(2_000);
    let hung = status(&mut bench);
    assert_eq!(hung.compass, CompassHealth::Silent);
    assert_eq!(hung.ranges, [ChannelHealth::Good; 4]);
    // At once, and then every 200 ms and its time-out.
    let attempts = hung.counters.of(Fault::BusRecovered);
    assert!((8..=12).contains(&attempts), "{attempts} attempts");
    break_bus(&mut bench, LineFault::None);
    bench.run(500);
    assert_eq!(status(&mut bench).compass, CompassHealth::Good);
    assert_eq!(bench.machine.incidents().first(), []);
}

#[test]
fn a_data_line_held_low_is_waited_out() {
    hangs(LineFault::DataLow);
}

#[test]
fn a_clock_line_held_low_is_waited_out() {
    hangs(LineFault::ClockLow);
}

#[test]
fn a_device_that_stretches_the_clock_for_ever_is_waited_out() {
    hangs(LineFault::Stretch);
}

#[test]
fn failing_conversions_are_counted_and_the_ranges_not_believed() {
    let mut bench = settled();
    bench.machine.adc_mut().set_failing(true);
    bench.run(1_000);
    let failing = status(&mut bench);
    // One for each period of 20 ms.
    let errors = failing.counters.of(Fault::AdcError);
    assert!((45..=52).contains(&errors), "{errors} errors");
    assert!(!failing.ranges.contains(&ChannelHealth::Good));
    bench.machine.adc_mut().set_failing(false);
    bench.run(1_000);
    assert_eq!(status(&mut bench).ranges, [ChannelHealth::Good; 4]);
    assert_eq!(bench.machine.incidents().first(), []);
}
