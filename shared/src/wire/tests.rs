use std::format;
use std::string::String as StdString;
use std::vec;
use std::vec::Vec as StdVec;

use heapless::{String, Vec};
use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::frame::*;
use super::message::*;
use super::*;
use crate::action::Action;
use crate::checksum::CRC32;
use crate::contract::*;
use crate::controller::{Familiarity, Learned, Perceived, Sensed, StepRecord};
use crate::learning::StaircaseChange;
use crate::perception::{Corners, PatternCode, SettleTime};
use crate::reward::Reward;
use crate::sensing::{Percept, Sample, Scaled, Stimulus};
use crate::time::Instant;
use crate::units::{Microdegrees, Micrometres};

/// Every version that was ever released: number, schema, and a checksum of the golden frames,
/// which see what the schema does not, the types of other files. Changing a message without
/// raising [`PROTOCOL_VERSION`] and adding a line fails the test below.
const VERSIONS: [(u8, u32, u32); 2] = [
    (1, 0x3b72_f1dd, 0xff78_f3fc),
    // A status shows what the sensors say, so that they can be looked at while disarmed.
    (2, 0x3a77_0282, 0xeaf7_88b7),
];

#[test]
fn messages_change_only_with_the_version() {
    let frames = GOLDEN.lines().fold(CRC32.digest(), |mut digest, line| {
        digest.update(line.as_bytes());
        digest
    });
    let now = (PROTOCOL_VERSION, SCHEMA_HASH, frames.finalize());
    assert_eq!(
        VERSIONS.last(),
        Some(&now),
        "the contract changed: raise PROTOCOL_VERSION, and add ({}, {:#010x}, {:#010x})",
        now.0,
        now.1,
        now.2,
    );
    let mut versions: StdVec<u8> = VERSIONS.iter().map(|v| v.0).collect();
    versions.dedup();
    assert_eq!(versions.len(), VERSIONS.len(), "one line for each version");
}

#[test]
fn the_schema_hash_sees_code_and_nothing_else() {
    let plain = schema_hash(&[b"struct A { b: u8 }"]);
    assert_eq!(
        schema_hash(&[b"// why\nstruct A {\r\n", b"    b: u8 // what\n}"]),
        plain
    );
    assert_ne!(schema_hash(&[b"struct A { b: u16 }"]), plain);
    assert_eq!(plain, CRC32.checksum(b"structA{b:u8}"));
}

fn sample() -> Sample {
    Sample {
        front: Micrometres::from_cm(64),
        left: Micrometres::from_cm(14),
        right: Micrometres(345_678),
        heading: Microdegrees::from_degrees(-90),
        target_bearing: None,
    }
}

fn record() -> ActionRecord {
    let percept = Percept([1_000_000, -1_000_000, -172_880, 250_000].map(Scaled::saturating));
    let code = PatternCode(12_703);
    ActionRecord {
        time: Instant(60_000_000),
        counts: [500, 510, 1_900, 900],
        ranges: [ChannelHealth::Good; 4],
        compass: CompassHealth::Good,
        sample: sample(),
        step: StepRecord {
            step: 1_000,
            sensed: Some(Sensed {
                target_angle: Microdegrees::from_degrees(45),
                percept,
                reward: Reward([-12_000_000, -400_000_000, -30_000_000, -7_853_981]),
            }),
            learned: Some(Learned {
                code,
                reward_difference: -1_234_567,
                phase: Microdegrees(8_300_000),
                staircase: Some(StaircaseChange {
                    stimulus: Stimulus::Left,
                    step: percept.0[1].step(),
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

/// The record with the longest encoding of every number.
fn longest_record() -> ActionRecord {
    let code = PatternCode(u16::MAX);
    let base = record();
    ActionRecord {
        time: Instant(u64::MAX),
        counts: [u16::MAX; 4],
        ranges: [ChannelHealth::NotFitted; 4],
        compass: CompassHealth::Implausible,
        sample: Sample {
            front: Micrometres(u32::MAX),
            left: Micrometres(u32::MAX),
            right: Micrometres(u32::MAX),
            heading: Microdegrees(i32::MIN),
            target_bearing: Some(Microdegrees(i32::MIN)),
        },
        step: StepRecord {
            step: u32::MAX,
            sensed: Some(Sensed {
                target_angle: Microdegrees(i32::MIN),
                percept: Percept([Scaled::saturating(i64::MIN); 4]),
                reward: Reward([i32::MIN; 4]),
            }),
            learned: base.step.learned.map(|learned| Learned {
                code,
                reward_difference: i32::MIN,
                phase: Microdegrees(i32::MIN),
                staircase: learned.staircase.map(|s| StaircaseChange {
                    amount: i32::MIN,
                    ..s
                }),
            }),
            perceived: Some(Perceived {
                corners: Corners([i32::MIN; 4]),
                code,
                settle_time: SettleTime(u32::MAX),
                familiarity: Familiarity::Replaced(code),
            }),
            action: Action {
                phase: Microdegrees(i32::MIN),
                module: Micrometres(u32::MAX),
            },
        },
        outcome: Outcome::Stopped,
        counters: Counters([u32::MAX; 20]),
    }
}

fn chunk(bytes: usize) -> Chunk {
    let data = (0..bytes).map(|i| (i * 7) as u8).collect();
    Chunk {
        total: 40_000,
        fingerprint: 0xdead_beef,
        offset: 256,
        data,
    }
}

fn commands() -> StdVec<(&'static str, Command)> {
    let points = [(2_900, 100_000), (500, 800_000)].map(|(counts, um)| CurvePoint {
        counts,
        distance: Micrometres(um),
    });
    vec![
        (
            "hello",
            Command::Hello {
                schema: 0x1234_5678,
            },
        ),
        ("ping", Command::Ping),
        ("heartbeat", Command::Heartbeat),
        ("arm", Command::Arm),
        ("disarm", Command::Disarm),
        ("set_mode", Command::SetMode(Mode::Learn)),
        ("set_task", Command::SetTask(Task::FollowDirection)),
        (
            "set_direction",
            Command::SetDirection(Microdegrees::from_degrees(80)),
        ),
        (
            "drive",
            Command::Drive {
                turn: Microdegrees::from_degrees(-20),
                advance: Micrometres::from_cm(7),
            },
        ),
        ("set_seed", Command::SetSeed(7)),
        (
            "calibrate_range",
            Command::Calibrate(Calibration::Range {
                channel: 2,
                points: Vec::from_slice(&points).unwrap(),
            }),
        ),
        (
            "calibrate_compass",
            Command::Calibrate(Calibration::Compass {
                offset: Microdegrees::from_degrees(3),
            }),
        ),
        (
            "calibrate_speed",
            Command::Calibrate(Calibration::Speed {
                duty: 450,
                speed: Micrometres::from_cm(15),
                dead_band: 180,
            }),
        ),
        ("read_status", Command::ReadStatus),
        ("pull_knowledge", Command::PullKnowledge { offset: 128 }),
        ("push_knowledge", Command::PushKnowledge(chunk(16))),
        ("store_knowledge", Command::StoreKnowledge),
        ("new_knowledge", Command::NewKnowledge),
    ]
}

fn reports() -> StdVec<(&'static str, Report)> {
    let event = |kind| {
        Report::Event(Event {
            time: Instant(1_000_000),
            kind,
        })
    };
    vec![
        (
            "hello",
            Report::Hello(Hello {
                schema: 0x1234_5678,
                board: String::try_from("feather-rp2040").unwrap(),
                firmware: String::try_from("0.1.0").unwrap(),
                reset: ResetReason::PowerOn,
                seed: 7,
                knowledge: Some(0xcafe_f00d),
            }),
        ),
        (
            "ack",
            Report::Ack(Ack {
                sequence: 2,
                result: Ok(()),
            }),
        ),
        (
            "refused",
            Report::Ack(Ack {
                sequence: 3,
                result: Err(Refusal::RangeSensor {
                    channel: 1,
                    health: ChannelHealth::Frozen,
                }),
            }),
        ),
        (
            "status",
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
        ("action", Report::Action(record())),
        ("longest_action", Report::Action(longest_record())),
        (
            "state",
            event(EventKind::State(State::Faulted(Fault::Stuck))),
        ),
        ("move_ended", event(EventKind::MoveEnded(Outcome::Obstacle))),
        (
            "direction",
            event(EventKind::Direction(Microdegrees::from_degrees(-170))),
        ),
        (
            "stored",
            event(EventKind::KnowledgeStored {
                fingerprint: 0xcafe_f00d,
            }),
        ),
        (
            "range",
            event(EventKind::Range {
                channel: 3,
                health: ChannelHealth::Open,
            }),
        ),
        ("compass", event(EventKind::Compass(CompassHealth::Silent))),
        (
            "session",
            event(EventKind::Session {
                mode: Mode::Learn,
                seed: 7,
                knowledge: 0xcafe_f00d,
            }),
        ),
        (
            "fault",
            Report::Fault(FaultReport {
                time: Instant(3_000_000),
                fault: Fault::HostLost,
                count: 1,
            }),
        ),
        ("knowledge", Report::Knowledge(chunk(CHUNK_BYTES))),
        (
            "last_words",
            Report::LastWords(String::try_from("panicked at board.rs:3").unwrap()),
        ),
    ]
}

fn pack<T: Serialize>(sequence: u16, message: &T) -> StdVec<u8> {
    let mut buffer = [0; MAX_FRAME];
    let mut encoder = Encoder::new();
    while encoder.next_sequence() != sequence {
        encoder.encode(&0u8, &mut buffer).expect("a byte fits");
    }
    encoder
        .encode(message, &mut buffer)
        .expect("every message fits")
        .to_vec()
}

fn unpack<T: DeserializeOwned>(
    decoder: &mut Decoder,
    bytes: &[u8],
) -> StdVec<Result<Frame<T>, FrameError>> {
    bytes
        .iter()
        .filter_map(|&byte| decoder.push(byte))
        .collect()
}

fn hex(bytes: &[u8]) -> StdString {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The contract as bytes on the wire: name and frame, one line a message. The frames also pin
/// the types of other files that messages contain.
const GOLDEN: &str = include_str!("golden.txt");

#[test]
fn frames_are_the_golden_ones() {
    let commands = commands()
        .into_iter()
        .map(|(name, m)| (format!("command {name}"), pack(2, &m)));
    let reports = reports()
        .into_iter()
        .map(|(name, m)| (format!("report {name}"), pack(2, &m)));
    let found: StdVec<_> = commands
        .chain(reports)
        .map(|(name, frame)| format!("{name} {} {}", frame.len(), hex(&frame)))
        .collect();
    for (found, golden) in found.iter().zip(GOLDEN.lines()) {
        assert_eq!(found, golden);
    }
    assert_eq!(
        found.len(),
        GOLDEN.lines().count(),
        "golden.txt should be\n{}",
        found.join("\n")
    );
}

#[test]
fn the_documented_example_is_right() {
    let frame = hex(&pack(2, &Command::Arm));
    assert_eq!(
        frame, "03020206034392c01100",
        "see the module's documentation"
    );
}

#[test]
fn the_longest_record_fits_with_room_to_spare() {
    let plain = pack(2, &Report::Action(longest_record())).len() - 3;
    assert_eq!(plain, 269);
    assert!(plain <= MAX_PLAIN);
    assert_eq!(
        pack(2, &Report::Action(record())).len(),
        139,
        "a usual record"
    );
}

#[test]
fn a_buffer_too_short_is_an_error_and_uses_up_no_number() {
    let mut encoder = Encoder::new();
    for length in 0..9 {
        assert_eq!(
            encoder.encode(&Command::Arm, &mut [0; 16][..length]),
            Err(TooLong)
        );
    }
    assert_eq!(encoder.next_sequence(), 0);
    assert!(encoder.encode(&Command::Arm, &mut [0; 16]).is_ok());
    assert_eq!(encoder.next_sequence(), 1);
}

#[test]
fn every_message_comes_back() {
    let mut decoder = Decoder::new();
    for (sequence, (_, command)) in commands().into_iter().enumerate() {
        let sequence = sequence as u16;
        let frames = unpack(&mut decoder, &pack(sequence, &command));
        assert_eq!(
            frames,
            [Ok(Frame {
                sequence,
                lost: 0,
                message: command
            })]
        );
    }
    let mut decoder = Decoder::new();
    for (sequence, (_, report)) in reports().into_iter().enumerate() {
        let sequence = sequence as u16;
        let frames = unpack(&mut decoder, &pack(sequence, &report));
        assert_eq!(
            frames,
            [Ok(Frame {
                sequence,
                lost: 0,
                message: report
            })]
        );
    }
    assert_eq!(decoder.counters(), &FrameCounters::default());
}

#[test]
fn gaps_in_the_numbers_are_counted() {
    let mut decoder = Decoder::new();
    let lost: StdVec<u16> = [5, 6, 9, 0, 1]
        .into_iter()
        .flat_map(|sequence| unpack::<Command>(&mut decoder, &pack(sequence, &Command::Ping)))
        .map(|frame| frame.unwrap().lost)
        .collect();
    assert_eq!(lost, [0, 0, 2, 0, 0]);
    assert_eq!(decoder.counters().lost, 2);
}

/// A frame of anything, with a right checksum.
fn plain_frame(content: &[u8]) -> StdVec<u8> {
    let mut plain = content.to_vec();
    plain.extend(CRC32.checksum(content).to_le_bytes());
    let mut frame = vec![0; plain.len() + plain.len() / 254 + 1];
    // The crate postcard uses: a second opinion on the stuffing.
    let length = cobs::encode(&plain, &mut frame);
    frame.truncate(length);
    frame.push(0);
    frame
}

#[test]
fn every_reason_to_drop_a_frame_is_named_and_counted() {
    let mut long = vec![1; MAX_PLAIN + 2];
    long.push(0);
    let mut wrong_crc = pack(0, &Command::Arm);
    wrong_crc[4] ^= 1;
    let mut trailing = vec![PROTOCOL_VERSION, 0, 0, 3];
    trailing.push(9);
    let cases: [(&[u8], FrameError); 8] = [
        (&[5, 1, 0], FrameError::Cobs),
        (&long, FrameError::Overlong),
        (&[3, 1, 2, 0], FrameError::Truncated),
        (&plain_frame(&[PROTOCOL_VERSION, 0]), FrameError::Truncated),
        (&wrong_crc, FrameError::Crc),
        (
            &plain_frame(&[PROTOCOL_VERSION + 1, 0, 0, 77]),
            FrameError::Version(Mismatch::TheyAreNewer {
                theirs: PROTOCOL_VERSION + 1,
            }),
        ),
        (
            &plain_frame(&[PROTOCOL_VERSION, 0, 0, 200]),
            FrameError::Message,
        ),
        (&plain_frame(&trailing), FrameError::Message),
    ];
    let mut decoder = Decoder::new();
    for (bytes, error) in cases {
        assert_eq!(unpack::<Command>(&mut decoder, bytes), [Err(error)]);
    }
    let counters = FrameCounters {
        cobs: 1,
        overlong: 1,
        truncated: 2,
        crc: 1,
        version: 1,
        message: 2,
        lost: 0,
    };
    assert_eq!(decoder.counters(), &counters);
    assert_eq!(counters.dropped(), 8);
}

#[test]
fn a_mismatch_says_what_to_update() {
    let text = |version, schema| format!("{}", compatible(version, schema).unwrap_err());
    assert!(text(PROTOCOL_VERSION + 1, SCHEMA_HASH).ends_with("update this side"));
    assert!(text(PROTOCOL_VERSION - 1, SCHEMA_HASH).ends_with("update the other side"));
    assert!(text(PROTOCOL_VERSION, !SCHEMA_HASH).contains("the same revision"));
    assert_eq!(compatible(PROTOCOL_VERSION, SCHEMA_HASH), Ok(()));
}

/// Whatever single byte is hit by whatever error: the frame is dropped, or was not changed, and
/// at the latest the next but one frame is heard.
fn survives_every_corrupted_byte<T>(message: &T)
where
    T: Serialize + DeserializeOwned + PartialEq + core::fmt::Debug,
{
    let frame = pack(1, message);
    let (second, third) = (pack(2, message), pack(3, message));
    for place in 0..frame.len() {
        for error in 1..=u8::MAX {
            let mut bytes = frame.clone();
            bytes[place] ^= error;
            bytes.extend(&second);
            bytes.extend(&third);
            let heard = unpack::<T>(&mut Decoder::new(), &bytes);
            assert!(
                heard
                    .iter()
                    .flatten()
                    .all(|f| f.message == *message && f.sequence > 1),
                "byte {place} ^ {error}: {heard:?}"
            );
            assert!(
                heard
                    .last()
                    .is_some_and(|f| f.as_ref().is_ok_and(|f| f.sequence == 3))
            );
        }
    }
}

#[test]
fn no_corrupted_byte_makes_another_message() {
    commands()
        .iter()
        .for_each(|(_, command)| survives_every_corrupted_byte(command));
    reports()
        .iter()
        .for_each(|(_, report)| survives_every_corrupted_byte(report));
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic_and_the_next_frame_is_heard(
        noise in prop::collection::vec(any::<u8>(), 0..2_000),
    ) {
        let mut decoder = Decoder::new();
        unpack::<Command>(&mut decoder, &noise);
        prop_assert_eq!(unpack::<Command>(&mut decoder, &[0]).iter().flatten().count(), 0);
        let heard = unpack::<Command>(&mut decoder, &pack(0, &Command::Disarm));
        prop_assert_eq!(heard, [Ok(Frame { sequence: 0, lost: 0, message: Command::Disarm })]);
    }

    /// Past the checksum: what a wrong, but careful sender could say.
    #[test]
    fn arbitrary_messages_never_panic(
        variant in 0u8..20,
        content in prop::collection::vec(any::<u8>(), 0..MAX_PLAIN - 8),
    ) {
        let mut plain = vec![PROTOCOL_VERSION, 0, 0, variant];
        plain.extend(content);
        let frame = plain_frame(&plain);
        prop_assert_eq!(unpack::<Command>(&mut Decoder::new(), &frame).len(), 1);
        prop_assert_eq!(unpack::<Report>(&mut Decoder::new(), &frame).len(), 1);
    }

    #[test]
    fn any_numbers_come_back(
        step: u32, time: u64, counts: [u16; 4], corners: [i32; 4], code: u16, reward: [i32; 4],
        counters: [u32; 20], turn: i32, target: Option<i32>, blind: bool,
    ) {
        let base = record();
        let message = Report::Action(ActionRecord {
            time: Instant(time),
            counts,
            sample: Sample { target_bearing: target.map(Microdegrees), ..base.sample },
            step: StepRecord {
                step,
                sensed: base.step.sensed.map(|s| Sensed { reward: Reward(reward), ..s }),
                perceived: base.step.perceived.filter(|_| !blind).map(|p| Perceived {
                    corners: Corners(corners), code: PatternCode(code), ..p
                }),
                action: Action { phase: Microdegrees(turn), ..base.step.action },
                ..base.step
            },
            counters: Counters(counters),
            ..base
        });
        let heard = unpack::<Report>(&mut Decoder::new(), &pack(0, &message));
        prop_assert_eq!(heard, [Ok(Frame { sequence: 0, lost: 0, message })]);
    }

    /// Zeros are rare, so that blocks of 254 bytes without one occur.
    #[test]
    fn the_stuffing_is_undone_as_the_reference_does(
        plain in prop::collection::vec(
            prop_oneof![1 => Just(0u8), 299 => 1u8..], MAX_PLAIN - 40..MAX_PLAIN - 8),
    ) {
        // A right checksum and version get a frame as far as its message.
        let mut content = vec![PROTOCOL_VERSION, 1, 1];
        content.extend(plain);
        let heard = unpack::<(u32, u32)>(&mut Decoder::new(), &plain_frame(&content));
        prop_assert!(matches!(heard[..], [Err(FrameError::Message)]), "{heard:?}");
    }
}
