//! The host's connection: frames over USB CDC-ACM.
//!
//! Nothing is sent unless somebody has opened the port (DTR), and no write waits longer than
//! [`WRITE_TIMEOUT`]: on the RP2040 the program cannot see the cable being pulled (the bus's voltage
//! is not wired to the controller), a write would wait for ever.
//!
//! Erratum RP2040-E15 (the USB controller can hang after a bus error in an IN transfer) is not worked
//! around by embassy-rp's driver. If it strikes, every write runs into its time-out, reports are
//! dropped and counted, and a rover driven by the host stops for want of heartbeats; a reset frees it.

use core::cell::RefCell;

use embassy_futures::join::join4;
use embassy_futures::yield_now;
use embassy_time::{Duration, Timer, with_timeout};
use embassy_usb::class::cdc_acm::{Receiver, Sender};
use heapless::String;
use rover_shared::contract::TEXT_BYTES;
use rover_shared::rover::Rover;
use rover_shared::storage::LONGEST_ERASURE;
use rover_shared::supervisor::{GUARD_PERIOD, Input, LOOP_SILENCE, Loop};
use rover_shared::wire::frame::{Decoder, Encoder, Frame, FrameError, MAX_FRAME};
use rover_shared::wire::message::{Ack, Command, Report};

use crate::guard::Watch;
use crate::reports::{self, answer};
use crate::usb::{PACKET, Usb};
use crate::{guard, sense, usb};

type Text = String<TEXT_BYTES>;

/// How often the port is checked while there is nothing to send.
const PERIOD: Duration = Duration::from_millis(40);
/// How long a packet may wait for the host. A listening host fetches it within 1 ms.
const WRITE_TIMEOUT: Duration = Duration::from_millis(40);

// This loop reports to the supervisor before it waits and afterwards, and the erasure of a sector,
// which pauses everything, may come in between.
const _: () =
    assert!(WRITE_TIMEOUT.as_micros() + LONGEST_ERASURE.0 < LOOP_SILENCE.minus(GUARD_PERIOD).0);

/// Runs the link; never returns. `last_words`: what the run before this one ended with.
#[embassy_executor::task]
pub async fn link(
    usb: (usb::Device, usb::Port),
    rover: &'static RefCell<Rover<'static>>,
    last_words: Option<Text>,
) -> ! {
    let (mut device, port) = usb;
    let (sender, receiver) = port.split();
    join4(
        device.run(),
        usb::free_endpoint_zero(),
        transmit(sender, rover, last_words),
        receive(receiver, rover),
    )
    .await
    .0
}

/// Sends answers and telemetry while the port is open.
async fn transmit(
    mut sender: Sender<'static, Usb>,
    rover: &'static RefCell<Rover<'static>>,
    last_words: Option<Text>,
) -> ! {
    loop {
        while !sender.dtr() {
            guard::tell(Input::Alive(Loop::Link));
            reports::discard();
            Timer::after(PERIOD).await;
        }
        log!("port opened");
        // An empty frame ends an unfinished one that the host may hold from the last connection.
        let mut outbox = Outbox {
            encoder: Encoder::new(),
            broken: true,
        };
        let hello = rover.borrow_mut().hello(&mut Watch);
        outbox.send(&mut sender, &hello).await;
        if let Some(text) = &last_words {
            outbox
                .send(&mut sender, &Report::LastWords(text.clone()))
                .await;
        }
        while sender.dtr() {
            guard::tell(Input::Alive(Loop::Link));
            if let Ok(report) = with_timeout(PERIOD, reports::next()).await {
                outbox.send(&mut sender, &report).await;
            }
        }
        rover.borrow_mut().closed();
        log!("port closed");
    }
}

/// Packs frames into packets.
struct Outbox {
    encoder: Encoder,
    /// The last frame was not sent to its end.
    broken: bool,
}

impl Outbox {
    async fn send(&mut self, sender: &mut Sender<'static, Usb>, report: &Report) {
        let mut buffer = [0; 1 + MAX_FRAME];
        let [end, room @ ..] = &mut buffer;
        *end = 0;
        let Ok(frame) = self.encoder.encode(report, room) else {
            // Does not happen: a test compares every message's length with MAX_FRAME.
            return reports::drop_one();
        };
        let length = frame.len();
        let start = if self.broken { 0 } else { 1 };
        let bytes = buffer.get(start..=length).unwrap_or_default();
        // One byte short of full, so that no packet needs an empty one to end the transfer.
        for packet in bytes.chunks(usize::from(PACKET) - 1) {
            // A host that is slow to fetch packets must not cause a reset.
            guard::tell(Input::Alive(Loop::Link));
            let written = with_timeout(WRITE_TIMEOUT, sender.write_packet(packet)).await;
            if !matches!(written, Ok(Ok(()))) {
                self.broken = true;
                return reports::drop_one();
            }
        }
        self.broken = false;
    }
}

/// Receives commands and answers them.
async fn receive(
    mut receiver: Receiver<'static, Usb>,
    rover: &'static RefCell<Rover<'static>>,
) -> ! {
    let mut packet = [0; PACKET as usize];
    loop {
        receiver.wait_connection().await;
        let mut decoder = Decoder::new();
        while let Ok(length) = receiver.read_packet(&mut packet).await {
            let before = decoder.counters().dropped();
            for byte in packet.iter().take(length) {
                match decoder.push::<Command>(*byte) {
                    Some(Ok(frame)) => obey(rover, &frame).await,
                    // The hello tells the host which version this is.
                    Some(Err(FrameError::Version(_))) => {
                        let hello = rover.borrow_mut().hello(&mut Watch);
                        answer(hello).await;
                    }
                    Some(Err(_)) | None => {}
                }
            }
            let bad = decoder.counters().dropped().saturating_sub(before);
            if bad > 0 {
                guard::tell(Input::BadFrames(bad));
            }
            // A host that sends without pause must not block the other tasks.
            yield_now().await;
        }
    }
}

async fn obey(rover: &RefCell<Rover<'static>>, frame: &Frame<Command>) {
    let seen = sense::latest();
    let handled = rover
        .borrow_mut()
        .handle(guard::now(), &frame.message, &seen, &mut Watch);
    let (result, report) = handled;
    let sequence = frame.sequence;
    answer(Report::Ack(Ack { sequence, result })).await;
    if let Some(report) = report {
        answer(report).await;
    }
}
