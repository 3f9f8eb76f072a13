//! Getting to know devices, good ones and bad ones.

use super::super::{DescriptorError, EnumerationError, Request, State, Usb};
use super::driver::Driver;
use super::{Board, CLOSED, MILLISECOND};
use crate::peripheral::{CYCLES_PER_MICROSECOND, Cycles, Peripheral};

#[test]
fn a_device_is_found_and_described() {
    let board = Board::open();
    let description = board.usb.description().expect("a device in use");
    assert_eq!((description.vendor, description.product), (0x1209, 1));
    assert_eq!(description.manufacturer_name.as_deref(), Some("1"));
    assert_eq!(description.product_name.as_deref(), Some("2"));
    assert_eq!(description.serial_number.as_deref(), Some("3"));
    assert_eq!(board.driver.line_coding, [0, 0xc2, 1, 0, 0, 0, 8]);
    assert!(board.driver.dtr);
    assert_eq!(board.driver.resets, 1);
    assert_eq!(board.usb.counters().connections, 1);
    assert_eq!(board.usb.counters().failed_attempts, 0);
}

#[test]
fn a_device_may_appear_after_the_cable() {
    let mut usb = Usb::new();
    usb.plug(0);
    assert_eq!(usb.state(), State::NoDevice);
    assert_eq!(usb.next_event(), None);
    let driver = Driver::start(&mut usb, 1000);
    assert_eq!(usb.state(), State::Enumerating);
    let mut board = Board {
        usb,
        driver,
        now: 1000,
        events: 0,
    };
    board.run(500 * MILLISECOND);
    assert_eq!(board.usb.state(), CLOSED);
    assert!(!board.driver.dtr);
}

/// Pulls the cable at every 10 us of enumeration, and at every 7 ms before it, and plugs it in again.
fn pulled_while_enumerating(heeds_reset: bool) -> impl Iterator<Item = (Cycles, Board)> {
    let before = (0..160).step_by(7).map(|ms| ms * MILLISECOND);
    let requests = (0..400).map(|i| 160 * MILLISECOND + i * 10 * CYCLES_PER_MICROSECOND);
    before.chain(requests).map(move |after| {
        let mut board = Board::new();
        board.driver.heeds_reset = heeds_reset;
        board.usb.plug(0);
        board.run(after);
        board.usb.unplug(board.now);
        board.run(5 * MILLISECOND);
        board.usb.plug(board.now);
        board.run(20_000 * MILLISECOND);
        (after, board)
    })
}

#[test]
fn a_cable_pulled_while_enumerating_does_no_harm_to_drivers_that_heed_a_reset() {
    for (after, mut board) in pulled_while_enumerating(true) {
        assert_eq!(board.usb.state(), CLOSED, "pulled after {after} cycles");
        board.usb.send(b"hello", board.now);
        board.run(MILLISECOND);
        assert_eq!(board.driver.inboxes.last().expect("one"), b"hello");
    }
}

#[test]
fn drivers_that_do_not_heed_a_reset_may_be_stuck_and_the_host_says_so() {
    let mut stuck = 0;
    for (after, mut board) in pulled_while_enumerating(false) {
        match board.usb.state() {
            State::Failed(_) => stuck += 1,
            state => assert_eq!(state, CLOSED, "pulled after {after} cycles"),
        }
        board.usb.reset(board.now);
        board.driver = Driver::start(&mut board.usb, board.now);
        board.run(500 * MILLISECOND);
        assert_eq!(board.usb.state(), CLOSED, "pulled after {after} cycles");
    }
    assert!(stuck > 0, "a request takes long enough to be hit");
}

/// What becomes of a device like this.
fn failure(change: impl Fn(&mut Driver)) -> (EnumerationError, Board) {
    let mut board = Board::new();
    change(&mut board.driver);
    board.usb.plug(0);
    board.run(20_000 * MILLISECOND);
    let State::Failed(error) = board.usb.state() else {
        panic!("{:?}", board.usb.state())
    };
    assert_eq!(board.usb.counters().failed_attempts, 3);
    assert_eq!(board.usb.next_event(), None, "it is left alone");
    (error, board)
}

#[test]
fn broken_devices_are_told_what_is_wrong() {
    let (error, _) = failure(|driver| driver.serves = false);
    assert_eq!(error, EnumerationError::TimeOut(Request::FirstPacket));
    let (error, _) = failure(|driver| driver.refuses = Some(2));
    let refused = EnumerationError::Refused(Request::ConfigurationHead);
    assert_eq!(error, refused);
    let (error, _) = failure(|driver| driver.device[1] = 7);
    assert_eq!(
        error.to_string(),
        "the device's reply to GET_DESCRIPTOR (device, first packet) is not usable: \
         it is of type 7, but type 1 was asked for"
    );
    let (error, _) = failure(|driver| driver.configuration[22] = 3);
    let none = DescriptorError::NoSerialPort;
    let request = Request::Configuration(70);
    assert_eq!(error, EnumerationError::Descriptor(request, none));
    let (error, _) = failure(|driver| driver.device[7] = 8);
    let babble = EnumerationError::Babble(Request::Device, 18);
    assert_eq!(error, babble, "packets larger than said");
}

#[test]
fn a_device_gets_a_new_chance_with_a_new_connection() {
    let (_, mut board) = failure(|driver| driver.refuses = Some(2));
    assert!(board.driver.suspended);
    board.driver.refuses = None;
    board.usb.unplug(board.now);
    board.usb.plug(board.now);
    board.run(500 * MILLISECOND);
    assert_eq!(board.usb.state(), CLOSED);
}

#[test]
fn a_device_needs_no_strings() {
    let mut board = Board::new();
    board.driver.refuses = Some(3);
    board.usb.plug(0);
    board.run(500 * MILLISECOND);
    assert_eq!(board.usb.state(), CLOSED);
    let description = board.usb.description().expect("a device in use");
    assert_eq!(description.product_name, None);
}
