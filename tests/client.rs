//! The conversation of a client with a rover: introduced, refused, repeated, reconnected.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::cell::RefCell;
use std::rc::Rc;

use rover_boardless::{BoardlessPort, BoardlessRover};
use rover_emulator::vehicle;
use rover_link::{Client, LinkError, Port, PortError, Received};
use rover_shared::contract::{Fault, Mode, Outcome, Refusal, ResetReason, State, Task};
use rover_shared::time::{Duration, Instant};
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::frame::{Encoder, MAX_FRAME};
use rover_shared::wire::message::{Command, EventKind, Hello, Report};
use rover_shared::wire::{PROTOCOL_VERSION, SCHEMA_HASH};

/// The client, the rover behind it, and the cable between.
fn connected(seed: u64) -> (Client, Rc<RefCell<BoardlessRover>>, Rc<RefCell<bool>>) {
    let rover = Rc::new(RefCell::new(BoardlessRover::in_empty_room(seed)));
    let port = BoardlessPort::new(rover.clone());
    let cable = port.cable();
    (Client::open(Box::new(port)).unwrap(), rover, cable)
}

fn everything(client: &mut Client, span: Duration) -> Vec<Received> {
    let until = client.now().after(span);
    let mut heard = Vec::new();
    while client.now() < until {
        heard.extend(client.next(until.since(client.now())).unwrap());
    }
    heard
}

#[test]
fn they_introduce_themselves() {
    let (client, ..) = connected(5);
    assert_eq!(client.hello().board.as_str(), "boardless");
    assert_eq!(
        (client.hello().seed, client.hello().schema),
        (5, SCHEMA_HASH)
    );
}

#[test]
fn commands_are_done_or_refused_with_the_reason() {
    let (mut client, rover, _) = connected(1);
    client.ask(&Command::Ping).unwrap();
    let refused = client.ask(&Command::SetMode(Mode::Learn)).unwrap_err();
    assert!(
        refused.to_string().ends_with("`rover arm` first"),
        "{refused}"
    );
    let silent = [vehicle::Fault::CompassSilent];
    rover.borrow_mut().set_faults(&silent);
    client.wait(Duration::from_millis(100)).unwrap();
    let refused = client.ask(&Command::Arm).unwrap_err().to_string();
    assert!(
        refused.contains("refused `arm`: the compass is silent"),
        "{refused}"
    );
    rover.borrow_mut().set_faults(&[]);
    client.wait(Duration::from_millis(100)).unwrap();
    client.ask(&Command::Arm).unwrap();
    assert_eq!(client.status().unwrap().state, State::Armed);
}

#[test]
fn reports_wait_until_they_are_read() {
    let (mut client, ..) = connected(3);
    client
        .ask(&Command::SetTask(Task::FollowChangingDirection))
        .unwrap();
    client.ask(&Command::Arm).unwrap();
    client.ask(&Command::SetMode(Mode::Learn)).unwrap();
    let mut heard = everything(&mut client, Duration::from_millis(60_000));
    client.ask(&Command::Disarm).unwrap();
    heard.extend(everything(&mut client, Duration::from_millis(1_000)));
    assert!(heard.iter().all(|received| received.lost == 0));
    let actions = heard
        .iter()
        .filter(|r| matches!(r.report, Report::Action(_)));
    assert!(actions.count() > 20);
    let session = |r: &&Received| match &r.report {
        Report::Event(event) => matches!(event.kind, EventKind::Session { .. }),
        _ => false,
    };
    assert_eq!(heard.iter().filter(session).count(), 1);
    assert_eq!(client.counters().lost, 0);
}

#[test]
fn a_lost_answer_is_asked_for_again_and_the_gap_is_told() {
    let (mut client, rover, _) = connected(1);
    client.keep_answers(true);
    rover.borrow_mut().lose = 1;
    client.ask(&Command::Arm).unwrap();
    assert_eq!(client.status().unwrap().state, State::Armed);
    assert!(client.counters().lost >= 1);
    let lost: u32 = everything(&mut client, Duration::from_millis(100))
        .iter()
        .map(|received| received.lost)
        .sum();
    assert!(lost >= 1);
}

#[test]
fn a_move_is_never_asked_for_twice() {
    let (mut client, rover, _) = connected(1);
    client.ask(&Command::Arm).unwrap();
    client.send_heartbeats(true).unwrap();
    client.ask(&Command::SetMode(Mode::Host)).unwrap();
    rover.borrow_mut().lose = 1;
    let drive = Command::Drive {
        turn: Microdegrees::from_degrees(20),
        advance: Micrometres(0),
    };
    let silent = LinkError::Silent("drive".into());
    assert_eq!(client.ask(&drive), Err(silent));
    let heard = everything(&mut client, Duration::from_millis(5_000));
    let ended = |r: &&Received| match &r.report {
        Report::Event(event) => event.kind == EventKind::MoveEnded(Outcome::Completed),
        _ => false,
    };
    assert_eq!(heard.iter().filter(ended).count(), 1);
}

#[test]
fn heartbeats_keep_a_host_driven_rover_and_their_end_stops_it() {
    let (mut client, ..) = connected(1);
    client.ask(&Command::Arm).unwrap();
    client.send_heartbeats(true).unwrap();
    client.ask(&Command::SetMode(Mode::Host)).unwrap();
    everything(&mut client, Duration::from_millis(10_000));
    assert_eq!(client.status().unwrap().state, State::Driving(Mode::Host));
    client.send_heartbeats(false).unwrap();
    everything(&mut client, Duration::from_millis(2_100));
    let state = client.status().unwrap().state;
    assert_eq!(state, State::Faulted(Fault::HostLost));
}

#[test]
fn knowledge_comes_and_goes_whole() {
    let (mut client, rover, _) = connected(9);
    client.ask(&Command::Arm).unwrap();
    client.ask(&Command::SetMode(Mode::Learn)).unwrap();
    everything(&mut client, Duration::from_millis(30_000));
    let refused = client.pull_knowledge(|_, _| {}).unwrap_err().to_string();
    assert!(refused.contains("`rover disarm` first"), "{refused}");
    client.ask(&Command::Disarm).unwrap();
    client.wait(Duration::from_millis(100)).unwrap();
    let mut told = 0;
    let learned = client.pull_knowledge(|done, _| told = done).unwrap();
    assert_eq!(
        (told as usize, rover.borrow().stored()),
        (learned.len(), &learned[..])
    );

    let (mut pupil, other, _) = connected(10);
    // Losses on the way are made good, also of the last acknowledgement.
    other.borrow_mut().lose = 2;
    pupil.push_knowledge(&learned, |_, _| {}).unwrap();
    assert_eq!(other.borrow().stored(), learned);
    pupil.ask(&Command::Arm).unwrap();
    let refused = pupil.push_knowledge(&learned, |_, _| {}).unwrap_err();
    assert!(matches!(
        refused,
        LinkError::Refused {
            refusal: Refusal::Armed,
            ..
        }
    ));
}

#[test]
fn a_pulled_cable_is_noticed_and_the_rover_found_again() {
    let (mut client, rover, cable) = connected(1);
    for round in 1..20 {
        *cable.borrow_mut() = false;
        let lost = client.ask(&Command::Ping).unwrap_err();
        assert!(
            matches!(lost, LinkError::Port(PortError::Lost(..))),
            "{lost}"
        );
        let before = client.now();
        let patience = Duration::from_millis(5_000);
        assert!(client.reconnect(patience, &|| false).is_err());
        assert!(client.now().since(before) >= patience, "it has patience");
        *cable.borrow_mut() = true;
        if round % 3 == 0 {
            rover.borrow_mut().reset(ResetReason::Watchdog, round);
        }
        client.reconnect(patience, &|| false).unwrap();
        client.ask(&Command::Ping).unwrap();
        assert_eq!(client.counters().reconnected, round);
    }
    assert_eq!(client.hello().reset, ResetReason::Watchdog);
    *cable.borrow_mut() = false;
    assert!(client.ask(&Command::Ping).is_err());
    let before = client.now();
    assert!(
        client
            .reconnect(Duration::from_millis(60_000), &|| true)
            .is_err()
    );
    assert!(
        client.now().since(before) < Duration::from_millis(100),
        "it can be called off"
    );
}

/// Says what it is told to, whatever is asked.
struct Parrot {
    now: Instant,
    words: Vec<u8>,
}

impl Port for Parrot {
    fn name(&self) -> &str {
        "parrot"
    }
    fn now(&self) -> Instant {
        self.now
    }
    fn send(&mut self, _: &[u8]) -> Result<(), PortError> {
        Ok(())
    }
    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError> {
        self.now = self.now.after(patience);
        let length = buffer.len().min(self.words.len());
        buffer[..length].copy_from_slice(&self.words[..length]);
        Ok(length)
    }
    fn wait(&mut self, span: Duration) {
        self.now = self.now.after(span);
    }
    fn reopen(&mut self) -> Result<(), PortError> {
        Ok(())
    }
}

fn parrot(words: Vec<u8>) -> LinkError {
    let now = Instant(0);
    Client::open(Box::new(Parrot { now, words })).err().unwrap()
}

#[test]
fn others_at_the_port_are_told_from_rovers() {
    let silent = parrot(Vec::new());
    assert!(matches!(silent, LinkError::NoAnswer(_)), "{silent}");
    let noise = parrot((0..=255).cycle().take(1_000).collect());
    assert!(matches!(noise, LinkError::NoAnswer(_)), "{noise}");

    let hello = Hello {
        schema: !SCHEMA_HASH,
        ..connected(1).0.hello().clone()
    };
    let mut buffer = [0; MAX_FRAME];
    let frame = Encoder::new()
        .encode(&Report::Hello(hello), &mut buffer)
        .unwrap();
    let other = parrot(frame.to_vec()).to_string();
    assert!(other.contains("from the same revision"), "{other}");
}

#[test]
fn a_newer_rover_is_refused_with_what_to_update() {
    // A frame of the next version: its header and checksum are the same in all versions.
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut plain = vec![PROTOCOL_VERSION + 1, 0, 0, 0, 1, 2, 3];
    plain.extend(crc.checksum(&plain).to_le_bytes());
    let mut stuffed = Vec::new();
    for run in plain.split(|byte| *byte == 0) {
        stuffed.push(run.len() as u8 + 1);
        stuffed.extend(run);
    }
    stuffed.push(0);
    let error = parrot(stuffed).to_string();
    assert!(error.contains("update this side"), "{error}");
}
