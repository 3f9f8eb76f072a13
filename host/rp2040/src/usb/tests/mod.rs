//! Controller, host and a driver, together.

mod driver;
mod enumeration;
mod interleavings;
mod registers;

use driver::Driver;

use super::{State, Usb};
use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral};

const MILLISECOND: Cycles = 1_000 * CYCLES_PER_MICROSECOND;
const OPEN: State = State::Configured { dtr: true };
const CLOSED: State = State::Configured { dtr: false };

/// A chip whose program is the driver.
struct Board {
    usb: Usb,
    driver: Driver,
    now: Cycles,
    events: u64,
}

impl Board {
    fn new() -> Self {
        let mut usb = Usb::new();
        let driver = Driver::start(&mut usb, 0);
        Self {
            usb,
            driver,
            now: 0,
            events: 0,
        }
    }

    /// Plugged in, the port open.
    fn open() -> Self {
        let mut board = Self::new();
        board.usb.plug(0);
        board.usb.set_dtr(true, 0);
        board.run(500 * MILLISECOND);
        assert_eq!(board.usb.state(), OPEN);
        board
    }

    /// Runs for some time; the program reacts to an interrupt within 5 us.
    fn run(&mut self, time: Cycles) {
        let end = self.now + time;
        self.poll();
        loop {
            if self.usb.interrupt() {
                self.now += 5 * CYCLES_PER_MICROSECOND;
                self.poll();
            } else if let Some(event) = self.usb.next_event().filter(|event| *event <= end) {
                assert!(event >= self.now, "time goes on");
                self.now = event;
                self.events += 1;
                self.usb.advance(event);
            } else {
                break;
            }
        }
        self.now = self.now.max(end);
        self.usb.advance(self.now);
    }

    fn poll(&mut self) {
        self.driver.poll(&mut self.usb, self.now);
    }

    fn write(&mut self, bytes: &[u8]) {
        let packets = bytes.chunks(64).map(<[u8]>::to_vec);
        self.driver.outbox.extend(packets);
    }

    fn receive(&mut self) -> Vec<u8> {
        self.usb.receive(self.now)
    }
}

fn numbers(length: usize) -> Vec<u8> {
    (0..length).map(|i| (i % 251) as u8).collect()
}

#[test]
fn bytes_go_both_ways_at_full_speed() {
    let mut board = Board::open();
    let sent = numbers(4096);
    assert_eq!(board.usb.send(&sent, board.now), 4096);
    assert_eq!(board.usb.send(&[1], board.now), 0, "bounded");
    board.write(&sent);
    board.run(8 * MILLISECOND);
    assert_eq!(board.driver.inboxes, std::slice::from_ref(&sent));
    assert_eq!(board.receive(), sent);
    let counters = board.usb.counters();
    assert_eq!((counters.packets_in, counters.packets_out), (64, 64));
    assert_eq!((counters.bytes_in, counters.bytes_out), (4096, 4096));
    // One way alone: no more than 19 packets in a frame, and not many fewer.
    board.write(&[0; 64 * 200]);
    board.run(10 * MILLISECOND);
    let packets = board.usb.counters().packets_in - 64;
    assert!((150..=190).contains(&packets), "{packets}");
}

#[test]
fn an_idle_bus_has_no_events() {
    let mut board = Board::open();
    let before = board.events;
    board.run(1_000_000 * MILLISECOND);
    assert_eq!(board.events, before);
    assert_eq!(board.usb.next_event(), None);
}

#[test]
fn a_device_that_does_not_read_holds_the_host_up() {
    let mut board = Board::open();
    board.driver.reads = false;
    board.usb.send(&numbers(200), board.now);
    board.run(100 * MILLISECOND);
    assert_eq!(
        board.usb.unsent(),
        200 - 64,
        "one packet lies in the buffer"
    );
    assert_eq!(board.usb.next_event(), None, "NAK is not played");
    board.driver.reads = true;
    board.run(MILLISECOND);
    assert_eq!(board.driver.inboxes, [numbers(200)]);
}

#[test]
fn a_host_that_does_not_read_holds_the_device_up() {
    let mut board = Board::open();
    board.usb.set_reading(false, board.now);
    board.write(&numbers(300));
    board.run(100 * MILLISECOND);
    assert!(board.receive().is_empty());
    assert_eq!(
        board.driver.outbox.len(),
        4,
        "one packet lies in the buffer"
    );
    board.usb.send(b"still heard", board.now);
    board.run(MILLISECOND);
    assert_eq!(board.driver.inboxes, [b"still heard"]);
    board.usb.set_reading(true, board.now);
    board.run(MILLISECOND);
    assert_eq!(board.receive(), numbers(300));
}

#[test]
fn the_receive_buffer_is_bounded() {
    let mut board = Board::open();
    board.write(&numbers(70_000));
    board.run(100 * MILLISECOND);
    let mut received = board.receive();
    assert_eq!(received.len(), 65_536);
    board.run(10 * MILLISECOND);
    received.extend(board.receive());
    assert_eq!(received, numbers(70_000));
}

#[test]
fn the_receive_buffer_has_room_for_whole_packets_or_none() {
    let mut board = Board::open();
    let packets = [[1; 63]; 1050];
    board.driver.outbox.extend(packets.map(Vec::from));
    board.run(100 * MILLISECOND);
    let received = board.receive().len();
    assert_eq!(received, 1040 * 63, "room for 16 more, not for 64");
    board.run(10 * MILLISECOND);
    assert_eq!(received + board.receive().len(), 1050 * 63);
}

#[test]
fn the_port_opens_and_closes() {
    let mut board = Board::open();
    board.usb.set_dtr(false, board.now);
    board.run(MILLISECOND);
    assert!(!board.driver.dtr);
    assert_eq!(board.usb.state(), CLOSED);
    board.usb.set_dtr(true, board.now);
    assert_eq!(board.usb.state(), CLOSED, "not acknowledged yet");
    board.run(MILLISECOND);
    assert!(board.driver.dtr);
    assert_eq!(board.usb.state(), OPEN);
}

#[test]
fn a_pulled_cable_stops_everything() {
    let mut board = Board::open();
    board.write(&numbers(640));
    board.usb.send(&numbers(640), board.now);
    board.run(150 * CYCLES_PER_MICROSECOND);
    board.usb.unplug(board.now);
    assert_eq!(board.usb.state(), State::Unplugged);
    assert_eq!(board.usb.send(b"x", board.now), 0);
    let before = board.usb.counters();
    assert_eq!(before.unsent, 640 - before.bytes_out);
    assert!(before.bytes_in > 0 && before.bytes_out > 0);
    board.run(10 * MILLISECOND);
    assert_eq!(board.usb.counters(), before);
    assert!(board.driver.suspended, "all that the device can see");
    assert!(board.driver.dtr, "it was not told");
    assert_eq!(board.receive(), numbers(before.bytes_in as usize));

    board.usb.plug(board.now);
    board.run(500 * MILLISECOND);
    assert_eq!(board.usb.state(), CLOSED);
    assert!(!board.driver.dtr && !board.driver.suspended);
    board.usb.set_dtr(true, board.now);
    board.usb.send(b"again", board.now);
    board.run(5 * MILLISECOND);
    assert_eq!(board.driver.inboxes[1], b"again");
    // The packet that was in the buffer is gone with its connection.
    let missed = before.bytes_in as usize + 64;
    assert_eq!(board.receive(), numbers(640)[missed..]);
}

#[test]
fn a_board_that_resets_is_found_again() {
    let mut board = Board::open();
    board.usb.send(&numbers(500), board.now);
    board.usb.reset(board.now);
    assert_eq!(board.usb.state(), State::NoDevice);
    assert_eq!(board.usb.counters().unsent, 500);
    board.driver = Driver::start(&mut board.usb, board.now);
    board.run(500 * MILLISECOND);
    assert_eq!(board.usb.state(), CLOSED, "the port has to be opened again");
    assert_eq!(board.usb.counters().connections, 2);
}

#[test]
fn a_sleeping_host_is_noticed_and_wakes() {
    let mut board = Board::open();
    assert!(!board.usb.resume(board.now), "it does not sleep");
    assert!(board.usb.suspend(board.now));
    assert_eq!(board.usb.state(), State::Suspended);
    assert_eq!(board.usb.send(b"later", board.now), 5);
    board.run(2 * MILLISECOND);
    assert!(!board.driver.suspended);
    board.run(2 * MILLISECOND);
    assert!(board.driver.suspended);
    board.run(10_000 * MILLISECOND);
    assert!(board.usb.resume(board.now));
    board.run(29 * MILLISECOND);
    assert_eq!(board.usb.unsent(), 5);
    board.run(2 * MILLISECOND);
    assert!(!board.driver.suspended);
    assert_eq!(board.driver.inboxes, [b"later"]);
    assert_eq!(board.usb.state(), OPEN, "no new connection");
}

#[test]
fn a_host_that_falls_asleep_moves_nothing_and_loses_nothing() {
    let mut board = Board::open();
    board.write(&numbers(640));
    board.usb.send(&numbers(640), board.now);
    board.run(220 * CYCLES_PER_MICROSECOND);
    assert!(board.usb.suspend(board.now));
    let asleep = board.usb.counters();
    assert!(asleep.bytes_in > 0 && asleep.bytes_out > 0 && asleep.bytes_in < 640);
    board.run(100 * MILLISECOND);
    assert_eq!(board.usb.counters(), asleep);
    board.usb.resume(board.now);
    board.run(40 * MILLISECOND);
    assert_eq!(board.receive(), numbers(640));
    assert_eq!(board.driver.inboxes, [numbers(640)]);
}

#[test]
fn a_halted_endpoint_is_freed() {
    let mut board = Board::open();
    driver::set_word(
        &mut board.usb,
        driver::OUT_BUFFER_CONTROL,
        driver::STALL | driver::AVAILABLE | 64,
        board.now,
    );
    board.usb.send(b"through", board.now);
    board.run(MILLISECOND);
    assert_eq!(board.usb.counters().stalls, 1);
    assert_eq!(board.driver.inboxes, [b"through"]);
    assert_eq!(board.usb.counters().failed_requests, 0);
}

#[test]
fn packets_that_come_again_are_dropped() {
    let mut board = Board::open();
    board.write(b"once");
    board.run(MILLISECOND);
    // The same buffer once more, with the same PID.
    let control = driver::word(&mut board.usb, driver::IN_BUFFER_CONTROL, board.now);
    let again = control | driver::FULL;
    driver::hand_over(&mut board.usb, driver::IN_BUFFER_CONTROL, again, board.now);
    board.run(MILLISECOND);
    assert_eq!(board.receive(), b"once");
    assert_eq!(board.usb.counters().repeated, 1);
}

#[test]
fn a_controller_that_changes_its_address_is_not_found() {
    let mut board = Board::open();
    let write = crate::peripheral::Write::plain(9);
    board
        .usb
        .write(super::registers::ADDR_ENDP, write, board.now);
    board.usb.send(b"lost", board.now);
    board.usb.set_dtr(false, board.now);
    board.run(10 * MILLISECOND);
    assert_eq!(board.usb.unsent(), 4);
    assert_eq!(board.usb.counters().failed_requests, 1);
    assert_eq!(board.usb.next_event(), None);
}
