//! Where bytes from outside come in. Each function takes any bytes, and panics only if something
//! is wrong with the reader: by itself, or because a law does not hold.
//!
//! Most formats end with a checksum, behind which chance never gets. So the same bytes are also
//! given with their checksums put right ([`seal`]).

pub mod seal;

use std::io::ErrorKind;
use std::path::Path;

use rover_cli::monitor::player::Player as Shown;
use rover_cli::monitor::{App, Control, Feed as _};
use rover_log::knowledge;
use rover_log::recording::Recording;
use rover_log::replay;
use rover_log::replayable::Sessions;
use rover_log::table::{Columns, Drive};
use rover_log::{Log, recording};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::wire::frame::{Decoder, Encoder, MAX_FRAME};
use rover_shared::wire::message::{Command, Report};
use rover_simulator::arena::ArenaSource;
use rover_simulator::parameters;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Sessions that are replayed have at most so many messages, so that one input does not take long.
const FEW: usize = 50;

/// The frame decoder, with bytes as they come, and with bytes as the content of a whole frame.
pub fn frames(bytes: &[u8]) {
    decode::<Report>(bytes);
    decode::<Command>(bytes);
    let frame = seal::frame(bytes);
    decode::<Report>(&frame);
    decode::<Command>(&frame);
}

/// Law: what is decoded can be sent, and arrives as what it is.
fn decode<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(bytes: &[u8]) {
    let mut decoder = Decoder::new();
    for byte in bytes {
        let Some(Ok(frame)) = decoder.push::<T>(*byte) else {
            continue;
        };
        let mut buffer = [0; MAX_FRAME];
        let sent = Encoder::new().encode(&frame.message, &mut buffer);
        let sent = sent.expect("what fitted a frame fits one again");
        let mut other = Decoder::new();
        let received = sent.iter().find_map(|byte| other.push::<T>(*byte));
        let received = received.expect("a frame ends").expect("and is whole");
        assert_eq!(received.message, frame.message);
    }
}

/// Knowledge, as it is and with its length and checksum put right.
pub fn knowledge(bytes: &[u8]) {
    read_knowledge(bytes);
    read_knowledge(&seal::knowledge(bytes));
}

/// Law: what is read is written as the same bytes.
fn read_knowledge(bytes: &[u8]) {
    if let Ok((known, parameters)) = knowledge::from_bytes(bytes) {
        assert_eq!(knowledge::to_bytes(&known, &parameters), bytes);
        // Whatever the parameters are, they are refused or can be calculated with.
        let _ = Coefficients::new(&parameters);
    }
}

/// Logs of simulations and recordings of rovers: read, replayed, shown.
pub fn logs(bytes: &[u8]) {
    read_log(bytes);
    read_log(&seal::log(bytes));
}

fn read_log(bytes: &[u8]) {
    if let Ok(sessions) = Sessions::read(&[bytes]) {
        let messages = sessions.sessions.iter().map(|s| s.entries.len());
        if messages.sum::<usize>() <= FEW {
            let _ = replay::verify_sessions(&sessions);
        }
    }
    if recording::Recording::is_one(bytes) {
        // Twice the same file follows nothing.
        if let Ok(recorded) = Recording::read(&[bytes, bytes]) {
            show(Shown::of_rover("fuzz".into(), recorded));
        }
    } else if let Ok(log) = Log::read(bytes) {
        show(Shown::of_simulation("fuzz".into(), log));
    }
}

fn show(mut shown: Shown) {
    let mut app = App::default();
    shown.control(Control::End);
    for _ in 0..3 {
        for event in shown.poll(rover_cli::monitor::terminal::TICK) {
            app.take(shown.now(), &event);
        }
    }
}

/// An arena file. Law: what is accepted yields an arena.
pub fn arenas(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let mut read = |path: &Path| match path.to_str() {
        Some("fuzz.toml") => Ok(text.into()),
        _ => Err(ErrorKind::NotFound.into()),
    };
    if let Ok(arena) = ArenaSource::read("fuzz.toml".as_ref(), &mut read) {
        draw(&arena);
    }
}

/// A map: its YAML file, a 0, and its image.
pub fn maps(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == 0);
    let (yaml, image) = bytes.split_at(end.unwrap_or(bytes.len()));
    let image = image.get(1..).unwrap_or_default();
    let mut read = |path: &Path| match path.to_str() {
        Some("fuzz.yaml") => Ok(yaml.into()),
        _ => Ok(image.into()),
    };
    if let Ok(arena) = ArenaSource::read("fuzz.yaml".as_ref(), &mut read) {
        draw(&arena);
    }
}

fn draw(arena: &ArenaSource) {
    let mut chance =
        rover_simulator::experiment::generator(1, rover_simulator::experiment::Stream::Testing);
    let scenario = arena.scenario(&mut chance);
    let (start, world) = (scenario.start, &scenario.world);
    assert!((0.0..=world.width_cm()).contains(&start.x_cm), "{start:?}");
    assert!((0.0..=world.height_cm()).contains(&start.y_cm), "{start:?}");
}

/// A recorded drive: CSV, whose first line may be names of columns for `--columns`; and parameters,
/// which are text of the same kind of origin.
pub fn tables(bytes: &[u8]) {
    let named = |columns: &Columns, csv: &[u8]| {
        if let Ok(drive) = Drive::from_csv("fuzz.csv".into(), csv, columns) {
            assert!(!drive.rows.is_empty(), "an empty drive is refused");
        }
    };
    named(&Columns::default(), bytes);
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let (first, rest) = bytes.split_at(end.unwrap_or(bytes.len()));
    if let Ok(first) = std::str::from_utf8(first)
        && let Ok(columns) = first.parse::<Columns>()
    {
        named(&columns, rest.get(1..).unwrap_or_default());
    }
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(parameters) = parameters::overlay(Parameters::PAPER, text)
    {
        let _ = Coefficients::new(&parameters);
    }
}
