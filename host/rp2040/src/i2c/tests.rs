use super::registers::*;
use super::settings::con;
use super::step::Step;
use super::*;
use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral as _, Write};

const CON: u32 = 0x00;
const TAR: u32 = 0x04;
const FS_SCL_HCNT: u32 = 0x1c;
const FS_SCL_LCNT: u32 = 0x20;
const INTR_MASK: u32 = 0x30;
const RX_TL: u32 = 0x38;
const TX_TL: u32 = 0x3c;
const DMA_CR: u32 = 0x88;
const FS_SPKLEN: u32 = 0xa0;

const READ: u32 = 1 << 8;
const STOP: u32 = 1 << 9;
const RESTART: u32 = 1 << 10;

/// A period of SCL and a byte with what embassy-rp sets for 100 kHz.
const HIGH: Cycles = 500 + 46 + 7;
const LOW: Cycles = 750 + 1;
const PERIOD: Cycles = HIGH + LOW;
const BYTE: Cycles = 9 * PERIOD;
/// A write of one byte: START, address, byte, STOP.
const WRITE_OF_ONE: Cycles = HIGH + 2 * BYTE + PERIOD;

#[derive(Clone, Debug, PartialEq, Eq)]
enum Event {
    Start(u16, bool),
    Write(u8),
    Read,
    Stop,
}

/// Answers at 0x60, refuses 0xee, and gives 1, 2, 3, ...
#[derive(Clone, Debug, Default)]
struct Recorder {
    events: Vec<Event>,
    given: u8,
}

impl I2cDevice for Recorder {
    fn start(&mut self, address: u16, read: bool) -> bool {
        self.events.push(Event::Start(address, read));
        address == 0x60
    }

    fn write(&mut self, byte: u8) -> bool {
        self.events.push(Event::Write(byte));
        byte != 0xee
    }

    fn read(&mut self) -> u8 {
        self.events.push(Event::Read);
        self.given += 1;
        self.given
    }

    fn stop(&mut self) {
        self.events.push(Event::Stop);
    }
}

fn events(i2c: &I2c) -> &[Event] {
    &i2c.device::<Recorder>().expect("it was attached").events
}

fn write(i2c: &mut I2c, offset: u32, value: u32, now: Cycles) {
    i2c.write(offset, Write::plain(value), now);
}

/// Set up for 100 kHz and address 0x60, as embassy-rp does it, and enabled.
fn rig() -> I2c {
    let mut i2c = I2c::new();
    i2c.attach(Recorder::default());
    for (offset, value) in [
        (FS_SCL_HCNT, 500),
        (FS_SCL_LCNT, 750),
        (FS_SPKLEN, 46),
        (INTR_MASK, 0),
        (TAR, 0x60),
        (ENABLE, 1),
    ] {
        write(&mut i2c, offset, value, 0);
    }
    i2c
}

/// Lets everything happen that happens by itself; when the last of it did.
fn settle(i2c: &mut I2c) -> Cycles {
    let mut last = 0;
    while let Some(due) = i2c.next_event() {
        i2c.advance(due);
        last = due;
    }
    last
}

fn raised(i2c: &mut I2c, interrupt: u32) -> bool {
    i2c.raw_interrupts() & interrupt != 0
}

#[test]
fn registers_after_a_reset() {
    let mut i2c = I2c::new();
    for (offset, value) in [
        (CON, 0x65),
        (TAR, 0x55),
        (0x14, 0x28),
        (0x18, 0x2f),
        (FS_SCL_HCNT, 6),
        (FS_SCL_LCNT, 0x0d),
        (INTR_MASK, 0x8ff),
        (RAW_INTR_STAT, 0),
        (STATUS, status::TFE | status::TFNF),
        (0x7c, 1),
        (0x94, 0x64),
        (FS_SPKLEN, 7),
        (0xf4, 0),
        (COMP_TYPE, 0x4457_0140),
    ] {
        assert_eq!(i2c.read(offset, 0), value, "{offset:#x}");
    }
    assert!(!i2c.line());
}

#[test]
fn a_register_is_written_and_three_are_read() {
    let mut i2c = rig();
    write(&mut i2c, DATA_CMD, 0x01, 0);
    assert_eq!(i2c.read(TXFLR, 0), 1);
    assert!(raised(&mut i2c, interrupt::START_DET));
    assert_eq!(i2c.next_event(), Some(HIGH + BYTE));
    i2c.advance(HIGH + BYTE);
    assert_eq!(i2c.read(TXFLR, HIGH + BYTE), 0);
    let held = HIGH + 2 * BYTE;
    assert_eq!(settle(&mut i2c), held);
    assert!(matches!(i2c.step, Step::Waiting { .. }));
    let active = status::ACTIVITY | status::MST_ACTIVITY;
    assert_eq!(i2c.read(STATUS, held) & active, active);

    write(&mut i2c, DATA_CMD, READ | RESTART, held + 1_000);
    write(&mut i2c, DATA_CMD, READ, held + 1_000);
    write(&mut i2c, DATA_CMD, READ | STOP, held + 1_000);
    write(&mut i2c, RX_TL, 2, held + 1_000);
    write(&mut i2c, INTR_MASK, interrupt::RX_FULL, held + 1_000);
    let address = held + 1_000 + PERIOD + HIGH + BYTE;
    i2c.advance(address + 3 * BYTE - 1);
    assert!(!i2c.line());
    i2c.advance(address + 3 * BYTE);
    assert!(i2c.line());
    let end = settle(&mut i2c);
    assert_eq!(end, address + 3 * BYTE + PERIOD);
    assert!(raised(&mut i2c, interrupt::STOP_DET));
    let read: Vec<u32> = (0..3).map(|_| i2c.read(DATA_CMD, end)).collect();
    assert_eq!(read, [0x801, 2, 3], "the first is marked");
    assert!(!i2c.line());
    let expected = [
        Event::Start(0x60, false),
        Event::Write(1),
        Event::Start(0x60, true),
        Event::Read,
        Event::Read,
        Event::Read,
        Event::Stop,
    ];
    assert_eq!(events(&i2c), expected);
    assert_eq!(i2c.read(STATUS, end) & active, 0);
}

#[test]
fn six_bytes_at_100_khz_take_the_time_that_they_take() {
    let mut i2c = rig();
    for command in [1, READ | RESTART, READ, READ | STOP] {
        write(&mut i2c, DATA_CMD, command, 0);
    }
    let microseconds = settle(&mut i2c) / CYCLES_PER_MICROSECOND;
    // 54 periods of 95.9 kHz for the bytes, one for the STOP, one for the repeated START, and the
    // high times after both START conditions.
    assert_eq!(microseconds, 593);
    assert_eq!(microseconds, (56 * PERIOD + 2 * HIGH) / 125);
}

#[test]
fn an_address_that_nobody_acknowledges_aborts() {
    let mut i2c = rig();
    write(&mut i2c, ENABLE, 0, 0);
    write(&mut i2c, TAR, 0x61, 0);
    write(&mut i2c, ENABLE, 1, 0);
    write(&mut i2c, INTR_MASK, interrupt::TX_ABRT, 0);
    for _ in 0..3 {
        write(&mut i2c, DATA_CMD, READ, 0);
    }
    i2c.advance(HIGH + BYTE);
    assert!(i2c.line());
    let source = abort::ADDR_NOACK_7B | 3 << abort::FLUSHED_SHIFT;
    assert_eq!(i2c.read(TX_ABRT_SOURCE, HIGH + BYTE), source);
    assert_eq!(i2c.read(TXFLR, HIGH + BYTE), 0);
    assert!(!raised(&mut i2c, interrupt::STOP_DET), "not yet");
    write(&mut i2c, DATA_CMD, 5, HIGH + BYTE);
    assert_eq!(i2c.read(TXFLR, HIGH + BYTE), 0, "stays flushed");
    i2c.read(CLR_TX_ABRT, HIGH + BYTE);
    assert_eq!(i2c.read(TX_ABRT_SOURCE, HIGH + BYTE), 0);
    assert!(!i2c.line());
    assert_eq!(settle(&mut i2c), HIGH + BYTE + PERIOD);
    assert!(raised(&mut i2c, interrupt::STOP_DET));
    assert_eq!(i2c.read(CLR_STOP_DET, 99_999), 1);
    assert_eq!(i2c.read(CLR_STOP_DET, 99_999), 0);
}

#[test]
fn a_byte_that_is_refused_aborts() {
    let mut i2c = rig();
    for byte in [0x01, 0xee, 0x02 | STOP] {
        write(&mut i2c, DATA_CMD, byte, 0);
    }
    let end = settle(&mut i2c);
    let source = abort::TXDATA_NOACK | 1 << abort::FLUSHED_SHIFT;
    assert_eq!(i2c.read(TX_ABRT_SOURCE, end), source);
    assert_eq!(events(&i2c).last(), Some(&Event::Stop));
    i2c.read(CLR_INTR, end);
    assert_eq!(i2c.raised, 0);
}

#[test]
fn the_transmit_fifo_tells_when_it_runs_low_and_over() {
    let mut i2c = rig();
    write(&mut i2c, TX_TL, 1, 0);
    write(&mut i2c, INTR_MASK, interrupt::TX_EMPTY, 0);
    assert!(i2c.line(), "empty");
    for byte in 0..FIFO_DEPTH as u32 + 1 {
        write(&mut i2c, DATA_CMD, byte, 0);
    }
    assert!(!i2c.line());
    assert!(raised(&mut i2c, interrupt::TX_OVER));
    assert_eq!(i2c.read(STATUS, 0) & (status::TFNF | status::TFE), 0);
    i2c.advance(HIGH + 15 * BYTE - 1);
    assert!(!i2c.line());
    i2c.advance(HIGH + 15 * BYTE);
    assert_eq!(i2c.read(TXFLR, HIGH + 15 * BYTE), 1);
    assert!(i2c.line());
    assert_eq!(i2c.read(CLR_TX_OVER, 0), 1);
}

#[test]
fn tx_empty_can_wait_for_the_byte() {
    let mut i2c = rig();
    write(&mut i2c, ENABLE, 0, 0);
    write(&mut i2c, CON, 0x65 | con::TX_EMPTY_CTRL, 0);
    write(&mut i2c, ENABLE, 1, 0);
    write(&mut i2c, DATA_CMD, 7, 0);
    i2c.advance(HIGH + 2 * BYTE - 1);
    assert!(!raised(&mut i2c, interrupt::TX_EMPTY));
    i2c.advance(HIGH + 2 * BYTE);
    assert!(raised(&mut i2c, interrupt::TX_EMPTY));
}

#[test]
fn the_receive_fifo_overflows_or_holds_the_bus() {
    for (control, waits) in [(0x65, false), (0x65 | con::RX_FIFO_FULL_HLD_CTRL, true)] {
        let mut i2c = rig();
        write(&mut i2c, ENABLE, 0, 0);
        write(&mut i2c, CON, control, 0);
        write(&mut i2c, ENABLE, 1, 0);
        for _ in 0..FIFO_DEPTH {
            write(&mut i2c, DATA_CMD, READ, 0);
        }
        let full = settle(&mut i2c);
        write(&mut i2c, DATA_CMD, READ | STOP, full);
        settle(&mut i2c);
        let end = full + BYTE;
        assert_eq!(raised(&mut i2c, interrupt::RX_OVER), !waits);
        assert_eq!(raised(&mut i2c, interrupt::STOP_DET), !waits);
        if waits {
            assert_eq!(i2c.read(DATA_CMD, end + 90_000), 0x801);
            assert_eq!(settle(&mut i2c), end + 90_000 + PERIOD);
            assert!(raised(&mut i2c, interrupt::STOP_DET));
        }
        for _ in 0..FIFO_DEPTH {
            i2c.read(DATA_CMD, end + 200_000);
        }
        assert!(!raised(&mut i2c, interrupt::RX_UNDER));
        assert_eq!(i2c.read(RXFLR, end + 200_000), 0);
        i2c.read(DATA_CMD, end + 200_000);
        assert!(raised(&mut i2c, interrupt::RX_UNDER));
    }
}

#[test]
fn settings_are_locked_while_enabled() {
    let mut i2c = rig();
    write(&mut i2c, TAR, 0x10, 0);
    write(&mut i2c, CON, 0, 0);
    assert_eq!((i2c.read(TAR, 0), i2c.read(CON, 0)), (0x60, 0x65));
    write(&mut i2c, ENABLE, 0, 0);
    assert_eq!(i2c.read(ENABLE_STATUS, 0), 0);
    write(&mut i2c, CON, 0x67, 0);
    assert_eq!(i2c.read(CON, 0), 0x65, "no high speed");
    write(&mut i2c, FS_SCL_LCNT, 3, 0);
    assert_eq!(i2c.read(FS_SCL_LCNT, 0), 8);
}

#[test]
fn disabling_ends_the_transfer_after_the_byte() {
    let mut i2c = rig();
    for byte in [1, 2, 3] {
        write(&mut i2c, DATA_CMD, byte, 0);
    }
    let within_the_first = HIGH + BYTE + 100;
    i2c.advance(within_the_first);
    write(&mut i2c, ENABLE, 0, within_the_first);
    assert_eq!(i2c.read(ENABLE, within_the_first), 0);
    assert_eq!(i2c.read(ENABLE_STATUS, within_the_first), 1, "still busy");
    assert_eq!(settle(&mut i2c), WRITE_OF_ONE);
    assert_eq!(i2c.read(ENABLE_STATUS, WRITE_OF_ONE), 0);
    let expected = [Event::Start(0x60, false), Event::Write(1), Event::Stop];
    assert_eq!(events(&i2c), expected);
}

#[test]
fn a_controller_enabled_again_at_once_still_ends_the_old_transfer() {
    let mut i2c = rig();
    write(&mut i2c, DATA_CMD, 1, 0);
    let held = settle(&mut i2c);
    write(&mut i2c, ENABLE, 0, held);
    write(&mut i2c, ENABLE, 1, held);
    write(&mut i2c, DATA_CMD, 2 | STOP, held);
    let end = settle(&mut i2c);
    assert_eq!(end, held + PERIOD + LOW + WRITE_OF_ONE);
    let expected = [
        Event::Start(0x60, false),
        Event::Write(1),
        Event::Stop,
        Event::Start(0x60, false),
        Event::Write(2),
        Event::Stop,
    ];
    assert_eq!(events(&i2c), expected);
}

#[test]
fn the_program_can_abort() {
    let mut i2c = rig();
    for byte in [1, 2, 3] {
        write(&mut i2c, DATA_CMD, byte, 0);
    }
    let within_the_first = HIGH + BYTE + 100;
    write(&mut i2c, ENABLE, 3, within_the_first);
    write(&mut i2c, ENABLE, 1, within_the_first);
    assert_eq!(i2c.read(ENABLE, within_the_first), 3, "not cleared by that");
    assert_eq!(settle(&mut i2c), WRITE_OF_ONE);
    assert_eq!(i2c.read(ENABLE, WRITE_OF_ONE), 1);
    let source = abort::USER_ABRT | 2 << abort::FLUSHED_SHIFT;
    assert_eq!(i2c.read(TX_ABRT_SOURCE, WRITE_OF_ONE), source);
}

#[test]
fn commands_can_be_blocked() {
    let mut i2c = rig();
    write(&mut i2c, ENABLE, 5, 0);
    write(&mut i2c, DATA_CMD, 1 | STOP, 0);
    assert_eq!(i2c.next_event(), None);
    write(&mut i2c, ENABLE, 1, 5_000);
    assert_eq!(settle(&mut i2c), 5_000 + WRITE_OF_ONE);
}

#[test]
fn what_the_master_may_not_do_aborts() {
    for (control, target, source) in [
        (0x64, 0x60, abort::MASTER_DIS),
        (0x65, 0x800, abort::GCALL_READ),
        (0x55, 0x60, abort::RD_NORSTRT_10B),
    ] {
        let mut i2c = rig();
        write(&mut i2c, ENABLE, 0, 0);
        write(&mut i2c, CON, control, 0);
        write(&mut i2c, TAR, target, 0);
        write(&mut i2c, ENABLE, 1, 0);
        write(&mut i2c, DATA_CMD, READ, 0);
        assert_eq!(i2c.abort_source, source | 1 << abort::FLUSHED_SHIFT);
        assert_eq!(i2c.next_event(), None);
    }
}

#[test]
fn without_restarts_directions_change_by_a_stop() {
    let mut i2c = rig();
    write(&mut i2c, ENABLE, 0, 0);
    write(&mut i2c, CON, 0x45, 0);
    write(&mut i2c, ENABLE, 1, 0);
    write(&mut i2c, DATA_CMD, 1, 0);
    write(&mut i2c, DATA_CMD, READ | STOP, 0);
    settle(&mut i2c);
    let expected = [
        Event::Start(0x60, false),
        Event::Write(1),
        Event::Stop,
        Event::Start(0x60, true),
        Event::Read,
        Event::Stop,
    ];
    assert_eq!(events(&i2c), expected);
}

#[test]
fn fifos_ask_for_dma() {
    let mut i2c = rig();
    assert!(!i2c.transmit_request());
    write(&mut i2c, DMA_CR, 3, 0);
    assert!(i2c.transmit_request() && !i2c.receive_request());
    write(&mut i2c, DATA_CMD, READ | STOP, 0);
    assert!(!i2c.transmit_request());
    let end = settle(&mut i2c);
    assert!(i2c.transmit_request() && i2c.receive_request());
    i2c.read(DATA_CMD, end);
    assert!(!i2c.receive_request());
}

#[test]
fn sda_held_low_loses_the_arbitration_without_a_stop() {
    let mut i2c = rig();
    i2c.set_fault(LineFault::DataLow, 0);
    write(&mut i2c, DATA_CMD, 1 | STOP, 0);
    // 0x60 begins with a 1.
    assert_eq!(settle(&mut i2c), HIGH + PERIOD);
    assert_eq!(i2c.abort_source & 0xffff, abort::LOST);
    assert!(!raised(&mut i2c, interrupt::STOP_DET));
    assert_eq!(events(&i2c), []);
    assert!(!i2c.lines().data && i2c.lines().clock);
}

#[test]
fn nine_pulses_free_sda() {
    let mut i2c = rig();
    i2c.set_fault(LineFault::DataLowFor { pulses: 9 }, 0);
    let mut pins = |clock, data| {
        i2c.pins(Lines { clock, data }, 0);
        i2c.lines()
    };
    for _ in 0..9 {
        assert!(!pins(false, true).data);
        assert!(!pins(true, true).data);
    }
    assert!(pins(false, true).data, "the ninth is over");
    pins(false, false);
    pins(true, false);
    assert_eq!(pins(true, true), Lines::HIGH);
    assert_eq!(i2c.fault(), LineFault::None);
    assert_eq!(events(&i2c), [Event::Stop]);
    write(&mut i2c, DATA_CMD, 1 | STOP, 0);
    settle(&mut i2c);
    assert_eq!(i2c.abort_source, 0);
}

#[test]
fn reading_while_sda_is_held_gives_zeros_and_no_stop() {
    let mut i2c = rig();
    write(&mut i2c, DATA_CMD, READ | STOP, 0);
    i2c.advance(HIGH + BYTE);
    i2c.set_fault(LineFault::DataLow, HIGH + BYTE);
    settle(&mut i2c);
    assert_eq!(i2c.receive, [0x800]);
    assert!(!raised(&mut i2c, interrupt::STOP_DET));
    i2c.set_fault(LineFault::None, 100_000);
    assert_eq!(i2c.next_event(), Some(100_000));
    settle(&mut i2c);
    assert!(raised(&mut i2c, interrupt::STOP_DET));
}

#[test]
fn scl_held_low_stops_everything_until_it_is_let_go() {
    let mut i2c = rig();
    i2c.set_fault(LineFault::ClockLow, 0);
    write(&mut i2c, DATA_CMD, 1 | STOP, 0);
    assert_eq!(i2c.next_event(), None);
    i2c.advance(1_000_000);
    assert_eq!(i2c.read(RAW_INTR_STAT, 1_000_000) & interrupt::STOP_DET, 0);
    i2c.set_fault(LineFault::None, 1_000_000);
    assert_eq!(settle(&mut i2c), 1_000_000 + BYTE + PERIOD);
}

#[test]
fn a_device_can_stretch_the_clock_for_ever() {
    let mut i2c = rig();
    i2c.set_fault(LineFault::Stretch, 0);
    assert!(i2c.lines().clock);
    write(&mut i2c, DATA_CMD, READ | STOP, 0);
    assert_eq!(settle(&mut i2c), HIGH + BYTE);
    assert!(i2c.receive.is_empty());
    assert!(!i2c.lines().clock);
    i2c.reset();
    assert!(!i2c.lines().clock, "the device does not care");
    i2c.set_fault(LineFault::None, 500_000);
    assert_eq!(i2c.lines(), Lines::HIGH);
}

#[test]
fn a_reset_keeps_what_is_connected() {
    let mut i2c = rig();
    write(&mut i2c, DATA_CMD, 1, 0);
    i2c.reset();
    assert_eq!(i2c.next_event(), None);
    assert_eq!(i2c.read(TAR, 0), 0x55);
    assert_eq!(events(&i2c).len(), 0);
    i2c.set_fault(LineFault::ClockLow, 0);
    i2c.reset();
    assert_eq!(i2c.fault(), LineFault::ClockLow);
}
