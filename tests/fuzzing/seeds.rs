//! Real files and frames, short ones: what is changed is to be met soon.

use std::cell::RefCell;
use std::rc::Rc;

use rover_boardless::{BoardlessPort, BoardlessRover};
use rover_link::Client;
use rover_log::recorder::Recorder;
use rover_log::recording::RecordingWriter;
use rover_log::{LogWriter, Origin};
use rover_shared::contract;
use rover_shared::learning::Mode;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::time::{Duration, Instant};
use rover_shared::wire::SCHEMA_HASH;
use rover_shared::wire::frame::{Encoder, MAX_FRAME};
use rover_shared::wire::message::Command;
use rover_simulator::arena::{ArenaSource, Layout};
use rover_simulator::experiment::{Known, SessionPlan, learn};

/// What goes over a wire: both ways, whole conversations and single frames.
pub fn frames() -> Vec<Vec<u8>> {
    let mut rover = BoardlessRover::in_empty_room(1);
    let mut encoder = Encoder::new();
    let mut frames = Vec::new();
    rover.open();
    let schema = SCHEMA_HASH;
    for command in [
        Command::Hello { schema },
        Command::ReadStatus,
        Command::PullKnowledge { offset: 0 },
        Command::Arm,
        Command::SetMode(contract::Mode::Learn),
        Command::Ping,
        Command::SetMode(contract::Mode::Run),
        Command::Disarm,
    ] {
        let mut buffer = [0; MAX_FRAME];
        let frame = encoder.encode(&command, &mut buffer).unwrap().to_vec();
        rover.receive(&frame);
        // The message alone, to be put into a frame again.
        frames.push(frame[3..frame.len().saturating_sub(5)].to_vec());
        frames.push(frame);
        rover.run(Duration::from_millis(5_000));
        let mut sent = vec![0; 10_000];
        let length = rover.take_sent(&mut sent);
        sent.truncate(length);
        let parts = sent.split_inclusive(|byte| *byte == 0);
        frames.extend(parts.map(<[u8]>::to_vec));
        sent.truncate(1_000);
        frames.push(sent);
    }
    frames
}

fn plan(parameters: &Parameters, trials: u32, steps: u32) -> (SessionPlan, Coefficients) {
    let plan = SessionPlan {
        seed: 3,
        trials,
        steps,
        follow_direction: false,
        arenas: ArenaSource::from(Layout::paper()),
    };
    (plan, Coefficients::new(parameters).unwrap())
}

/// Knowledge of nobody, of somebody, and of one that follows directions.
pub fn knowledge() -> Vec<Vec<u8>> {
    let (plan, coefficients) = plan(&Parameters::PAPER, 2, 40);
    let learned = learn(&plan, &coefficients, &mut (), |_| {});
    let bytes = |known: &Known, parameters| rover_log::knowledge::to_bytes(known, parameters);
    vec![
        bytes(&Known::new(&coefficients.learning), &Parameters::ROVER),
        bytes(&learned.knowledge, &Parameters::PAPER),
    ]
}

/// A simulation's log, whole and cut off, and a rover's recording.
pub fn logs() -> Vec<Vec<u8>> {
    let (plan, coefficients) = plan(&Parameters::PAPER, 2, 2);
    let origin = Origin {
        seed: plan.seed,
        mode: Mode::Learn,
        writer: "test".into(),
    };
    let before = rover_log::knowledge::to_bytes(
        &Known::new(&coefficients.learning),
        coefficients.parameters(),
    );
    let file = std::io::Cursor::new(Vec::new());
    let mut log = LogWriter::new(file, &origin, &before).unwrap();
    let learned = learn(&plan, &coefficients, &mut log, |_| {});
    let after = rover_log::knowledge::to_bytes(&learned.knowledge, coefficients.parameters());
    let log = log.finish(&after).unwrap().into_inner();
    vec![log, recording()]
}

/// A few seconds of a rover that learns.
fn recording() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let rover = Rc::new(RefCell::new(BoardlessRover::in_empty_room(1)));
    let client = Client::open(Box::new(BoardlessPort::new(rover))).unwrap();
    let log = RecordingWriter::create(&path, None, "test", None).unwrap();
    let mut recorder = Recorder::begin(client, None, log).unwrap();
    for command in [Command::Arm, Command::SetMode(contract::Mode::Learn)] {
        recorder.client().ask(&command).unwrap();
    }
    while recorder.client().now() < Instant(6_000_000) {
        recorder.next(Duration::from_millis(100)).unwrap();
    }
    recorder.client().ask(&Command::Disarm).unwrap();
    recorder.next(Duration::from_millis(100)).unwrap();
    recorder.finish(|_| {}).unwrap();
    std::fs::read(path).unwrap()
}

/// Arena files of all features, in rooms that take no long time.
pub fn arenas() -> Vec<Vec<u8>> {
    let small = "width_cm = 60\nheight_cm = 50\n\
        start = { x_cm = 10, y_cm = 25, heading_deg = -90 }\n\
        goal = { x_cm = 50, y_cm = 25, radius_cm = 5 }\n\
        [[rect]]\nx_cm = 20\ny_cm = 4\nw_cm = 2\nh_cm = 3\n\
        [[circle]]\nx_cm = 30\ny_cm = 40\nr_cm = 5\n\
        [[polygon]]\npoints_cm = [[32, 10], [36, 10], [34, 20]]\n\
        [robot]\nmodel = \"harder\"\nstep_cm = 3\ncontact_radius_cm = 1.5\n\
        front_range_cm = 50\nside_range_cm = 25\n";
    let random = "width_cm = 60.5\nheight_cm = 5e1\n[robot]\nmodel = \"rover\"\nbeam_deg = 30\n";
    [
        small,
        random,
        include_str!("../../host/arenas/paper.toml"),
        include_str!("../../host/arenas/harder.toml"),
    ]
    .map(|text| text.as_bytes().to_vec())
    .into()
}

/// Maps: YAML, a 0, image. Plain, raw and bit images.
pub fn maps() -> Vec<Vec<u8>> {
    let yaml = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\n\
        occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n";
    let images: [&[u8]; 4] = [
        b"P2\n# made by hand\n3 2\n255\n0 205 254\n254 215 255\n",
        b"P5\n3 2\n255\n\x00\xCD\xFE\xFE\xD7\xFF",
        b"P1\n3 2\n1 0 1\n0 0 0\n",
        b"P4\n3 2\n\xA0\x00",
    ];
    let mut maps: Vec<_> = images.map(|image| map(yaml, image)).into();
    let room = [&b"P5\n20 12\n255\n"[..], &[0xFE; 240]].concat();
    maps.push(map(yaml, &room));
    maps
}

fn map(yaml: &str, image: &[u8]) -> Vec<u8> {
    [yaml.as_bytes(), b"\0", image].concat()
}

/// Recorded drives, one with names for its columns, and parameters.
pub fn tables() -> Vec<Vec<u8>> {
    let head = |text: &str| text.lines().take(10).collect::<Vec<_>>().join("\n");
    let drive = head(include_str!("../data/drive.csv"));
    let named = head(include_str!("../data/other-columns.csv"));
    let names = "front=front_m,left=left_m,right=right_m";
    vec![
        drive.into_bytes(),
        format!("{names}\n{named}").into_bytes(),
        include_bytes!("../../host/parameters/fixed-phases.toml").to_vec(),
        b"[lattice]\nmu = 0.7\n[reward]\nfront_gain = 700.0\n".to_vec(),
    ]
}
