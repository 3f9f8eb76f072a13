//! Whatever happens in whatever order: a connection loses no byte and doubles none while it stands.

use proptest::prelude::*;

use super::driver::Driver;
use super::{Board, MILLISECOND, OPEN};
use crate::peripheral::CYCLES_PER_MICROSECOND;

#[derive(Clone, Copy, Debug)]
enum Happens {
    HostSends(usize),
    HostReceives,
    HostReads(bool),
    DeviceWrites(usize),
    DeviceReads(bool),
    Dtr(bool),
    Plug,
    Unplug,
    Suspend,
    Resume,
    BoardResets,
    Microseconds(u64),
}

fn happens() -> impl Strategy<Value = Happens> {
    use Happens::*;
    prop_oneof![
        6 => (0..300usize).prop_map(HostSends),
        6 => (0..300usize).prop_map(DeviceWrites),
        3 => Just(HostReceives),
        2 => any::<bool>().prop_map(HostReads),
        2 => any::<bool>().prop_map(DeviceReads),
        2 => any::<bool>().prop_map(Dtr),
        3 => Just(Plug),
        1 => Just(Unplug),
        1 => Just(Suspend),
        2 => Just(Resume),
        1 => Just(BoardResets),
        8 => (0..1000u64).prop_map(Microseconds),
        4 => (0..400u64).prop_map(|ms| Microseconds(ms * 1000)),
    ]
}

/// The number that follows, modulo 251: lost and doubled packets show, as 64 does not divide it.
fn next(byte: u8) -> u8 {
    (byte + 1) % 251
}

#[derive(Default)]
struct Stream {
    next: u8,
}

impl Stream {
    fn peek(&self, length: usize) -> Vec<u8> {
        let bytes = std::iter::successors(Some(self.next), |byte| Some(next(*byte)));
        bytes.take(length).collect()
    }

    fn take(&mut self, length: usize) -> Vec<u8> {
        let bytes = self.peek(length);
        self.next = bytes.last().map_or(self.next, |last| next(*last));
        bytes
    }
}

fn unbroken(bytes: &[u8]) -> bool {
    bytes.windows(2).all(|pair| pair[1] == next(pair[0]))
}

struct Game {
    board: Board,
    to_device: Stream,
    to_host: Stream,
    /// What has come to the host, connection by connection.
    arrived: Vec<Vec<u8>>,
    inboxes: Vec<Vec<u8>>,
}

impl Game {
    fn fetch(&mut self) {
        let bytes = self.board.receive();
        self.arrived.last_mut().expect("one").extend(bytes);
    }

    fn play(&mut self, happens: Happens) {
        let now = self.board.now;
        match happens {
            Happens::HostSends(length) => {
                let bytes = self.to_device.peek(length);
                let accepted = self.board.usb.send(&bytes, now);
                self.to_device.take(accepted);
            }
            Happens::HostReceives => self.fetch(),
            Happens::HostReads(on) => self.board.usb.set_reading(on, now),
            Happens::DeviceWrites(length) => {
                let bytes = self.to_host.take(length);
                self.board.write(&bytes);
            }
            Happens::DeviceReads(on) => self.board.driver.reads = on,
            Happens::Dtr(on) => self.board.usb.set_dtr(on, now),
            Happens::Plug => self.board.usb.plug(now),
            Happens::Unplug => {
                self.board.usb.unplug(now);
                self.fetch();
                self.arrived.push(Vec::new());
            }
            Happens::Suspend => {
                self.board.usb.suspend(now);
            }
            Happens::Resume => {
                self.board.usb.resume(now);
            }
            Happens::BoardResets => {
                self.board.usb.reset(now);
                self.fetch();
                self.arrived.push(Vec::new());
                let inboxes = std::mem::take(&mut self.board.driver.inboxes);
                self.inboxes.extend(inboxes);
                let outbox = std::mem::take(&mut self.board.driver.outbox);
                self.board.driver = Driver::start(&mut self.board.usb, now);
                self.board.driver.outbox = outbox;
            }
            Happens::Microseconds(time) => self.board.run(time * CYCLES_PER_MICROSECOND),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn a_connection_is_a_pair_of_unbroken_streams(
        game in proptest::collection::vec(happens(), 0..120)
    ) {
        let mut play = Game {
            board: Board::new(),
            to_device: Stream::default(),
            to_host: Stream::default(),
            arrived: vec![Vec::new()],
            inboxes: Vec::new(),
        };
        for happens in game {
            play.play(happens);
        }
        // In the end both sides read, and all that is under way comes through.
        let now = play.board.now;
        play.board.driver.reads = true;
        play.board.usb.plug(now);
        play.board.usb.resume(now);
        play.board.usb.set_reading(true, now);
        play.board.usb.set_dtr(true, now);
        play.board.run(6_000 * MILLISECOND);
        prop_assert_eq!(play.board.usb.state(), OPEN);
        let now = play.board.now;
        let last_words = play.to_device.take(1000);
        prop_assert_eq!(play.board.usb.send(&last_words, now), 1000);
        let answer = play.to_host.take(1000);
        play.board.write(&answer);
        play.board.run(6_000 * MILLISECOND);
        play.fetch();

        prop_assert_eq!(play.board.usb.unsent(), 0);
        prop_assert!(play.board.driver.outbox.is_empty());
        prop_assert!(play.arrived.last().expect("one").ends_with(&answer));
        prop_assert!(play.board.driver.inboxes.last().expect("one").ends_with(&last_words));
        for arrived in &play.arrived {
            prop_assert!(unbroken(arrived), "to the host: {:?}", arrived);
        }
        for inbox in play.inboxes.iter().chain(&play.board.driver.inboxes) {
            prop_assert!(unbroken(inbox), "to the device: {:?}", inbox);
        }
        let counters = play.board.usb.counters();
        let arrived: usize = play.arrived.iter().map(Vec::len).sum();
        prop_assert_eq!(counters.bytes_in, arrived as u64);
        prop_assert_eq!(counters.repeated, 0);
    }
}
