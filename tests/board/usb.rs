//! The firmware's USB: the cable pulled and plugged in at any time, hosts that sleep or do not read.

use emulated_rp2040::Machine;
use emulated_rp2040::usb::State;
use rover_shared::contract::{Fault, ResetReason};
use rover_shared::wire::frame::{Decoder, Encoder, MAX_FRAME};
use rover_shared::wire::message::{Command, Hello, Report, Status};
use rover_shared::wire::{SCHEMA_HASH, usb};

use crate::rig::{FIRMWARE, MS};

const OPEN: State = State::Configured { dtr: true };
const CLOSED: State = State::Configured { dtr: false };

/// A board, and a program with its port.
#[derive(Clone)]
struct Port {
    machine: Machine,
    decoder: Decoder,
    encoder: Encoder,
}

impl Port {
    /// The program runs; the cable is not plugged in.
    fn unplugged() -> Self {
        let mut port = Self {
            machine: Machine::new(&FIRMWARE, 1).expect("the firmware fits into the flash"),
            decoder: Decoder::new(),
            encoder: Encoder::new(),
        };
        port.run(100);
        port
    }

    /// Plugged in and opened; the board has said hello.
    fn open() -> (Self, Hello) {
        let mut port = Self::unplugged();
        port.plug();
        port.set_dtr(true);
        let hello = port.hello();
        (port, hello)
    }

    fn plug(&mut self) {
        let now = self.machine.now();
        self.machine.usb_mut().plug(now);
    }

    fn unplug(&mut self) {
        let now = self.machine.now();
        self.machine.usb_mut().unplug(now);
    }

    fn set_dtr(&mut self, on: bool) {
        let now = self.machine.now();
        self.machine.usb_mut().set_dtr(on, now);
    }

    fn set_reading(&mut self, on: bool) {
        let now = self.machine.now();
        self.machine.usb_mut().set_reading(on, now);
    }

    fn state(&self) -> State {
        self.machine.usb().state()
    }

    /// Runs for so many milliseconds; gives what the board has said, broken frames left out.
    fn run(&mut self, milliseconds: u64) -> Vec<Report> {
        let now = self.machine.now() + milliseconds * MS;
        self.machine.run_until(now);
        let now = self.machine.now();
        let bytes = self.machine.usb_mut().receive(now);
        let frames = bytes.iter().filter_map(|byte| self.decoder.push(*byte));
        frames.flatten().map(|frame| frame.message).collect()
    }

    fn send(&mut self, command: &Command) -> usize {
        let mut buffer = [0; MAX_FRAME];
        let frame = self.encoder.encode(command, &mut buffer);
        let now = self.machine.now();
        let usb = self.machine.usb_mut();
        usb.send(frame.expect("it fits"), now)
    }

    /// Waits for such a report, for a second at most.
    fn wait<T>(&mut self, what: impl Fn(&Report) -> Option<T>) -> Option<T> {
        (0..1_000).find_map(|_| self.run(1).iter().find_map(&what))
    }

    fn hello(&mut self) -> Hello {
        let hello = self.wait(|report| match report {
            Report::Hello(hello) => Some(hello.clone()),
            _ => None,
        });
        hello.expect("a hello when the port is opened")
    }

    fn status(&mut self) -> Status {
        let schema = SCHEMA_HASH;
        self.send(&Command::Hello { schema });
        self.send(&Command::ReadStatus);
        let status = self.wait(|report| match report {
            Report::Status(status) => Some(*status),
            _ => None,
        });
        status.expect("an answer")
    }
}

#[test]
fn it_describes_itself_as_a_rover() {
    let (port, _) = Port::open();
    assert_eq!(port.state(), OPEN);
    let description = port.machine.usb().description().expect("in use");
    let numbers = (description.vendor, description.product);
    assert_eq!(numbers, (usb::VENDOR, usb::PRODUCT));
    let name = description.product_name.as_deref();
    assert_eq!(name, Some(usb::PRODUCT_NAME));
    let maker = description.manufacturer_name.as_deref();
    assert_eq!(maker, Some(usb::MANUFACTURER_NAME));
    // The board's flash has the machine's seed for a number.
    let number = description.serial_number.as_deref();
    assert_eq!(
        number,
        Some(usb::serial_number(1_u64.to_be_bytes()).as_str())
    );
    let counters = port.machine.usb().counters();
    assert_eq!((counters.connections, counters.failed_attempts), (1, 0));
    assert_eq!((counters.stalls, counters.repeated), (0, 0));
}

#[test]
fn it_goes_on_when_the_cable_is_pulled_and_says_hello_again() {
    let (mut port, first) = Port::open();
    // In the middle of an answer, and in peace.
    for pause in [0, 1, 700] {
        port.send(&Command::ReadStatus);
        port.run(pause);
        port.unplug();
        port.run(3_000);
        assert_eq!(port.machine.incidents().count(), 0, "no reset");
        port.decoder = Decoder::new();
        port.plug();
        port.run(400);
        assert_eq!(port.state(), CLOSED);
        port.set_dtr(true);
        let again = port.hello();
        assert_eq!((again.reset, again.seed), (first.reset, first.seed));
        assert_eq!(again.reset, ResetReason::PowerOn);
        let bad = port.status().counters.of(Fault::BadFrame);
        assert_eq!(bad, 0);
    }
    assert_eq!(port.machine.usb().counters().connections, 4);
}

#[test]
fn a_host_that_reads_nothing_costs_reports_and_nothing_else() {
    let (mut port, _) = Port::open();
    let before = port.status().counters.of(Fault::QueueFull);
    port.set_reading(false);
    for _ in 0..100 {
        port.send(&Command::Ping);
        port.run(100);
    }
    assert_eq!(port.machine.incidents().count(), 0, "no reset");
    assert_eq!(port.state(), OPEN);
    port.set_reading(true);
    port.run(500);
    let lost = port.status().counters.of(Fault::QueueFull) - before;
    // Some answers fit into the queues; telemetry is lost besides.
    assert!(lost >= 80, "{lost} lost");
    assert_eq!(port.machine.usb().unsent(), 0);
}

#[test]
fn a_host_that_sends_without_pause_keeps_nobody_else_waiting() {
    let (mut port, _) = Port::open();
    let before = port.status().counters;
    let garbage = [0x55; 512];
    for _ in 0..1_000 {
        let now = port.machine.now();
        port.machine.usb_mut().send(&garbage, now);
        port.run(1);
    }
    // What was garbage ends here.
    let now = port.machine.now();
    port.machine.usb_mut().send(&[0], now);
    port.run(50);
    let after = port.status().counters;
    assert!(after.of(Fault::BadFrame) > before.of(Fault::BadFrame));
    for fault in [Fault::ControlSilent, Fault::LateStep] {
        assert_eq!(after.of(fault), 0, "{fault:?}");
    }
    assert_eq!(port.machine.incidents().count(), 0, "no reset");
    let sent = port.machine.usb().counters().bytes_out;
    println!("{sent} bytes in a second");
    assert!(sent > 300_000, "as fast as the bus carries it: {sent}");
}

#[test]
fn a_host_that_sleeps_finds_the_port_open() {
    let (mut port, _) = Port::open();
    port.run(100);
    let now = port.machine.now();
    assert!(port.machine.usb_mut().suspend(now));
    port.run(5_000);
    assert_eq!(port.state(), State::Suspended);
    let now = port.machine.now();
    assert!(port.machine.usb_mut().resume(now));
    port.run(50);
    assert_eq!(port.state(), OPEN);
    port.status();
    assert_eq!(port.machine.incidents().count(), 0);
    assert_eq!(port.machine.usb().counters().connections, 1);
}

/// embassy-rp 0.10 waits for the end of a request that a bus reset has ended, and does not look at the
/// bus meanwhile: without help (`free_endpoint_zero`) a cable pulled within some of these moments would
/// leave the firmware deaf until it is reset.
#[test]
fn a_cable_may_be_pulled_at_any_moment_of_the_enumeration() {
    let mut port = Port::unplugged();
    port.plug();
    while port.state() == State::NoDevice {
        port.run(1);
    }
    // Debouncing, reset and recovery; then the requests.
    port.run(158);
    let start = port.machine.now();
    let mut points = 0;
    while port.state() != CLOSED {
        port.machine.run_until(start + points * MS / 20);
        points += 1;
        // Plugged in again before the firmware can have noticed, and after.
        for pause in [5, 300] {
            let mut pulled = port.clone();
            pulled.unplug();
            pulled.run(pause);
            pulled.plug();
            // Not a request waits for its limit of 5 s.
            pulled.run(400);
            let moment = format!("pulled {points} x 50 us after, for {pause} ms");
            assert_eq!(pulled.state(), CLOSED, "{moment}");
            assert_eq!(
                pulled.machine.usb().counters().failed_attempts,
                0,
                "{moment}"
            );
            pulled.set_dtr(true);
            pulled.hello();
        }
    }
    println!("pulled at {points} moments");
    assert!(points > 40, "the requests take some milliseconds");
}
