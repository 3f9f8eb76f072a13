//! docs/wire.md is true: its tables are what serde says of the contract's types and what is really
//! encoded, its examples are real frames, its numbers are the code's, and its sources are there.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::fs;
use std::path::Path;

use rover_shared::action::Action;
use rover_shared::checksum;
use rover_shared::contract::{
    CURVE_POINTS, Calibration, ChannelHealth, CompassHealth, Counters, CurvePoint, Fault, Mode,
    Outcome, Refusal, ResetReason, State, TEXT_BYTES, Task,
};
use rover_shared::controller::{Familiarity, Learned, Perceived, Sensed, StepRecord};
use rover_shared::learning::StaircaseChange;
use rover_shared::motion::LONGEST_ADVANCE;
use rover_shared::perception::{Corners, PatternCode, SettleTime};
use rover_shared::reward::Reward;
use rover_shared::rover::{MOST_BYTES, PERIOD, SETTLE};
use rover_shared::sensing::{Percept, Sample, Scaled, Stimulus};
use rover_shared::supervisor::{RULES, Signal};
use rover_shared::time::{Duration, Instant};
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::frame::{Decoder, Encoder, Frame, MAX_FRAME, MAX_PLAIN};
use rover_shared::wire::message::{
    Ack, ActionRecord, CHUNK_BYTES, Chunk, Command, Event, EventKind, Hello, NAME_BYTES, Report,
    Status,
};
use rover_shared::wire::{PROTOCOL_VERSION, SCHEMA_HASH, usb};
use serde::Serialize;
use serde::de::DeserializeOwned;

#[path = "support/shape.rs"]
mod shape;

use shape::{Shape, Shapes, sample};

const PAGE: &str = include_str!("../docs/wire.md");
const CLIENT: &str = include_str!("../docs/telemetry.py");

/// The page from a heading on to the next of its level or above.
fn section(heading: &str) -> &'static str {
    let level = heading.find(' ').unwrap();
    let begins = PAGE.find(&format!("\n{heading}\n")).expect(heading) + heading.len() + 2;
    let rest = &PAGE[begins..];
    let above = |(at, line): (usize, &str)| {
        let hashes = line.trim_start_matches('\n').find(' ').unwrap_or(0);
        (1..=level).contains(&hashes).then_some(at)
    };
    let headings = rest
        .match_indices("\n#")
        .map(|(at, _)| (at, rest[at..].trim_start()));
    &rest[..headings.filter_map(above).next().unwrap_or(rest.len())]
}

/// The rows of a section's first table, without its head; cells without their back-ticks.
fn rows(section: &str) -> impl Iterator<Item = Vec<String>> {
    let lines = section.lines().skip_while(|line| !line.starts_with('|'));
    let lines = lines.take_while(|line| line.starts_with('|'));
    let cells = |line: &str| {
        let line = line.trim().trim_matches('|');
        let plain = |cell: &str| cell.trim().replace('`', "");
        line.split('|').map(plain).collect()
    };
    lines.skip(2).map(cells)
}

/// Names of the page's sections that are of this level.
fn headings(level: &str) -> impl Iterator<Item = &str> {
    PAGE.lines()
        .filter_map(move |line| line.strip_prefix(level)?.strip_prefix(' '))
}

/// Structs and enums as the page has them.
fn described() -> BTreeMap<String, Shape> {
    headings("###")
        .map(|heading| {
            let section = section(&format!("### {heading}"));
            let rows: Vec<_> = rows(section).collect();
            let pair = |a: &str, b: &str| (a.to_string(), b.to_string());
            let shape = if section.contains("| number | variant | contents |") {
                for (i, row) in rows.iter().enumerate() {
                    assert_eq!(row[0], i.to_string(), "{heading}: {row:?}");
                }
                Shape::Enum(rows.iter().map(|row| pair(&row[1], &row[2])).collect())
            } else {
                assert!(section.contains("| field | type | unit |"), "{heading}");
                Shape::Struct(rows.iter().map(|row| pair(&row[0], &row[1])).collect())
            };
            (heading.replace('`', ""), shape)
        })
        .collect()
}

#[test]
fn the_tables_are_the_types_of_the_contract() {
    let mut shapes = Shapes::default();
    shapes.add::<Command>();
    shapes.add::<Report>();
    let described = described();
    for (name, shape) in &shapes.found {
        assert_eq!(described.get(name), Some(shape), "{name}");
    }
    assert_eq!(
        described.len(),
        shapes.found.len(),
        "{:?}",
        described.keys()
    );
}

/// A frame, and its bytes before stuffing.
fn pack(sequence: u16, message: &impl Serialize) -> (Vec<u8>, Vec<u8>) {
    let mut buffer = [0; MAX_FRAME];
    let mut encoder = Encoder::new();
    while encoder.next_sequence() != sequence {
        encoder.encode(&0u8, &mut buffer).unwrap();
    }
    let frame = encoder.encode(message, &mut buffer).unwrap().to_vec();
    let plain = unstuff(&frame);
    (frame, plain)
}

/// By the page's words.
fn unstuff(frame: &[u8]) -> Vec<u8> {
    let (&end, mut rest) = frame.split_last().unwrap();
    assert_eq!(end, 0);
    let mut plain = Vec::new();
    while let Some((&code, after)) = rest.split_first() {
        let (piece, left) = after.split_at(usize::from(code) - 1);
        plain.extend_from_slice(piece);
        rest = left;
        if code != 255 && !rest.is_empty() {
            plain.push(0);
        }
    }
    plain
}

fn unpack<T: DeserializeOwned>(frame: &[u8]) -> Frame<T> {
    let mut decoder = Decoder::new();
    let mut found = frame.iter().filter_map(|&byte| decoder.push::<T>(byte));
    found.next().expect("a whole frame").expect("a sound frame")
}

/// Every variant of an enum: its number in the page is what is encoded, and it comes back as itself.
fn numbered<T>(name: &str)
where
    T: Serialize + DeserializeOwned + PartialEq + Debug,
{
    let described = described();
    let Some(Shape::Enum(variants)) = described.get(name) else {
        panic!("{name} is no enum in the page");
    };
    for (number, (variant, _)) in variants.iter().enumerate() {
        let value: T = sample(number as u32);
        let (frame, plain) = pack(0, &value);
        assert_eq!(usize::from(plain[3]), number, "{name}::{variant}");
        assert_eq!(unpack::<T>(&frame).message, value);
        let debug = format!("{value:?}");
        let called = debug.split(|c: char| !c.is_alphanumeric()).next().unwrap();
        assert!(called.eq_ignore_ascii_case(variant), "{debug} is {variant}");
    }
}

#[test]
fn the_numbers_of_variants_are_what_is_encoded() {
    numbered::<Command>("Command");
    numbered::<Report>("Report");
    numbered::<EventKind>("EventKind");
    numbered::<State>("State");
    numbered::<Mode>("Mode");
    numbered::<Task>("Task");
    numbered::<Outcome>("Outcome");
    numbered::<Fault>("Fault");
    numbered::<ResetReason>("ResetReason");
    numbered::<ChannelHealth>("ChannelHealth");
    numbered::<CompassHealth>("CompassHealth");
    numbered::<Refusal>("Refusal");
    numbered::<Calibration>("Calibration");
    numbered::<Stimulus>("Stimulus");
    numbered::<Familiarity>("Familiarity");
    numbered::<Result<(), Refusal>>("Result");
}

/// What an example's title stands for.
enum Example {
    Said(u16, Command),
    Heard(u16, Report),
}

fn example(title: &str) -> Example {
    use Example::{Heard, Said};
    let schema = 0x1234_5678;
    match title {
        "Hello of the host" => Said(0, Command::Hello { schema }),
        "Arm" => Said(2, Command::Arm),
        "Drive" => Said(
            2,
            Command::Drive {
                turn: Microdegrees::from_degrees(-20),
                advance: Micrometres::from_cm(7),
            },
        ),
        "Calibrate" => {
            let points = [(2_900, 10), (500, 80)].map(|(counts, cm)| CurvePoint {
                counts,
                distance: Micrometres::from_cm(cm),
            });
            let (channel, points) = (2, points.into_iter().collect());
            Said(
                2,
                Command::Calibrate(Calibration::Range { channel, points }),
            )
        }
        "PushKnowledge" => Said(
            2,
            Command::PushKnowledge(Chunk {
                total: 40_000,
                fingerprint: 0xdead_beef,
                offset: 256,
                data: (0..16).map(|i| i * 7).collect(),
            }),
        ),
        "Hello of the rover" => Heard(
            0,
            Report::Hello(Hello {
                schema,
                board: "feather-rp2040".try_into().unwrap(),
                firmware: "0.1.0".try_into().unwrap(),
                reset: ResetReason::PowerOn,
                seed: 7,
                knowledge: Some(0xcafe_f00d),
            }),
        ),
        "Ack, done" => {
            let (sequence, result) = (300, Ok(()));
            Heard(1, Report::Ack(Ack { sequence, result }))
        }
        "Ack, refused" => {
            let (channel, health) = (1, ChannelHealth::Frozen);
            let (sequence, result) = (3, Err(Refusal::RangeSensor { channel, health }));
            Heard(2, Report::Ack(Ack { sequence, result }))
        }
        "Event" => Heard(
            2,
            Report::Event(Event {
                time: Instant(1_000_000),
                kind: EventKind::State(State::Faulted(Fault::Stuck)),
            }),
        ),
        "Status" => Heard(
            2,
            Report::Status(Status {
                time: Instant(2_000_000),
                state: State::Driving(Mode::Run),
                motors_enabled: true,
                task: Task::FollowChangingDirection,
                direction: Microdegrees::from_degrees(80),
                steps: 12,
                counts: [500, 510, 1_004, 900],
                distances: [60, 59, 30, 33].map(Micrometres::from_cm),
                heading: Some(Microdegrees::from_degrees(-12)),
                ranges: [ChannelHealth::Good; 4],
                compass: CompassHealth::Good,
                counters: Counters::default(),
            }),
        ),
        "Action" => Heard(2, Report::Action(action())),
        _ => panic!("an example without its value here: {title}"),
    }
}

fn action() -> ActionRecord {
    let percept = [1_000_000, -1_000_000, -172_880, 250_000].map(Scaled::saturating);
    let code = PatternCode(12_703);
    ActionRecord {
        time: Instant(60_000_000),
        counts: [500, 510, 1_900, 900],
        ranges: [ChannelHealth::Good; 4],
        compass: CompassHealth::Good,
        sample: Sample {
            front: Micrometres::from_cm(64),
            left: Micrometres::from_cm(14),
            right: Micrometres(345_678),
            heading: Microdegrees::from_degrees(-90),
            target_bearing: None,
        },
        step: StepRecord {
            step: 1_000,
            sensed: Some(Sensed {
                target_angle: Microdegrees::from_degrees(45),
                percept: Percept(percept),
                reward: Reward([-12_000_000, -400_000_000, -30_000_000, -7_853_981]),
            }),
            learned: Some(Learned {
                code,
                reward_difference: -1_234_567,
                phase: Microdegrees(8_300_000),
                staircase: Some(StaircaseChange {
                    stimulus: Stimulus::Left,
                    step: percept[1].step(),
                    amount: -200_000,
                }),
            }),
            perceived: Some(Perceived {
                corners: Corners([524_288, -1_048_576, 0, 3_000_000]),
                code,
                settle_time: SettleTime(1_400),
                familiarity: Familiarity::Known,
            }),
            action: Action {
                phase: Microdegrees(8_600_000),
                module: Micrometres::from_cm(7),
            },
        },
        outcome: Outcome::Completed,
        counters: Counters::default(),
    }
}

/// The bytes of an example's line: between its label and what two spaces or more set off.
fn bytes(line: &str) -> (&str, Vec<u8>) {
    let (label, rest) = line.split_once(' ').unwrap_or((line, ""));
    let hex = rest.trim_start().split("  ").next().unwrap_or_default();
    let byte = |digits| u8::from_str_radix(digits, 16).unwrap_or_else(|_| panic!("{line}"));
    (label, hex.split_whitespace().map(byte).collect())
}

#[test]
fn the_examples_are_real_frames() {
    let mut examples = 0;
    for title in headings("####") {
        let block = section(&format!("#### {title}"));
        let lines = block.split("```").nth(1).unwrap().lines().skip(1);
        let (mut plain, mut frame) = (Vec::new(), Vec::new());
        for (label, bytes) in lines.map(bytes) {
            let to = if label == "frame" {
                &mut frame
            } else {
                &mut plain
            };
            to.extend(bytes);
        }
        let real = match example(&title.replace('`', "")) {
            Example::Said(sequence, command) => {
                let heard = unpack(&frame);
                assert_eq!((heard.sequence, &heard.message), (sequence, &command));
                pack(sequence, &command)
            }
            Example::Heard(sequence, report) => {
                let heard = unpack(&frame);
                assert_eq!((heard.sequence, &heard.message), (sequence, &report));
                pack(sequence, &report)
            }
        };
        assert_eq!(real, (frame, plain), "{title}");
        examples += 1;
    }
    assert_eq!(examples, 11);
}

#[test]
fn the_numbers_are_the_codes() {
    let milliseconds = |of: Duration| format!("{} ms", of.0 / 1_000);
    let mut heartbeats = RULES
        .iter()
        .filter(|rule| rule.signal == Signal::Heartbeat)
        .map(|rule| milliseconds(rule.within));
    let mut heartbeat = || heartbeats.next().unwrap();
    let real = [
        ("PROTOCOL_VERSION", PROTOCOL_VERSION.to_string()),
        ("SCHEMA_HASH", format!("{SCHEMA_HASH:08x}")),
        ("MAX_PLAIN", MAX_PLAIN.to_string()),
        ("MAX_FRAME", MAX_FRAME.to_string()),
        ("CHUNK_BYTES", CHUNK_BYTES.to_string()),
        ("MOST_BYTES", MOST_BYTES.to_string()),
        ("NAME_BYTES", NAME_BYTES.to_string()),
        ("TEXT_BYTES", TEXT_BYTES.to_string()),
        ("CURVE_POINTS", CURVE_POINTS.to_string()),
        ("PERIOD", milliseconds(PERIOD)),
        ("SETTLE", milliseconds(SETTLE)),
        ("HOST_LATE", heartbeat()),
        ("HOST_LOST", heartbeat()),
        ("LONGEST_ADVANCE", format!("{} µm", LONGEST_ADVANCE.0)),
    ];
    let real: Vec<_> = real.map(|(name, value)| vec![name.into(), value]).into();
    let written: Vec<_> = rows(section("## Numbers"))
        .map(|row| row[..2].to_vec())
        .collect();
    assert_eq!(written, real);

    let latest = rows(section("## Versions")).last().unwrap();
    assert_eq!(latest[..2], [real[0][1].clone(), real[1][1].clone()]);
    let transport = section("## Transport");
    let numbers = format!("`{:04x}`, `{:04x}`", usb::VENDOR, usb::PRODUCT);
    assert!(transport.contains(&numbers), "{numbers}");
    let names = format!("`{}`, `{}`", usb::MANUFACTURER_NAME, usb::PRODUCT_NAME);
    assert!(transport.contains(&names), "{names}");
    let check = format!("`{:08x}`", checksum::fingerprint(b"123456789"));
    assert!(section("## Knowledge").contains(&check), "{check}");
    let client = format!("PROTOCOL, SCHEMA = {PROTOCOL_VERSION}, {SCHEMA_HASH:#010x}\n");
    assert!(CLIENT.contains(&client), "docs/telemetry.py: {client}");
}

/// Each type has its file, and each file has what the page says.
#[test]
fn what_is_defined_where_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let root = { root }.find(|folder| folder.join("docs/wire.md").exists());
    let root = root.expect("the tests stand in the repository");
    let mut defined = Vec::new();
    for line in section("## Where it is defined").lines().skip(4) {
        let quoted: Vec<_> = line.split('`').skip(1).step_by(2).collect();
        let (path, names) = quoted.split_first().unwrap();
        let text = fs::read_to_string(root.join(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
        for name in names {
            let of = ["struct", "enum", "const", "static", "fn"]
                .into_iter()
                .find(|kind| defines(&text, kind, name))
                .unwrap_or_else(|| panic!("{path} does not define {name}"));
            if ["struct", "enum"].contains(&of) {
                defined.push(name.to_string());
            }
        }
    }
    for name in described().keys().filter(|name| *name != "Result") {
        assert!(defined.contains(name), "where is {name} defined?");
    }
}

fn defines(source: &str, kind: &str, name: &str) -> bool {
    let definition = format!("{kind} {name}");
    let mut after = source.split(&definition).skip(1);
    after.any(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}
