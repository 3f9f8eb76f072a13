//! What has to come out alike on every machine, in groups: of each a checksum is reported.
//!
//! Included by the program for the board's processor and by the test that compares the two.

use core::fmt::{self, Write};

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};
use rover_shared::contract::{ChannelHealth, CompassHealth, ResetReason};
use rover_shared::controller::Controller;
use rover_shared::knowledge::Knowledge;
use rover_shared::learning::Mode;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::math;
use rover_shared::motion::{self, Motion, Senses};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::{Corners, Noise};
use rover_shared::random::Generator;
use rover_shared::reward::AimAtTarget;
use rover_shared::sensing::Sample;
use rover_shared::sensing::compass::Compass;
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::sensing::ir::{AdcCount, Ranges};
use rover_shared::supervisor::{Input, Loop, Supervisor};
use rover_shared::time::{Duration, Instant};
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::frame::{Encoder, MAX_FRAME};

/// Where results go.
pub trait Report {
    /// The checksum of a group.
    fn group(&mut self, name: &str, checksum: u32);

    /// Does the work, and may count its cycles.
    fn timed<T>(&mut self, work: impl FnOnce() -> T) -> T {
        work()
    }
}

/// All groups, one after the other.
pub fn run(report: &mut impl Report) {
    report.group("random", random());
    report.group("math", trigonometry());
    lattice(report);
    controller(report);
    report.group("ranges", ranges());
    report.group("compass", compass());
    report.group("motion", moves());
    report.group("supervisor", supervision());
}

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::PAPER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the paper's parameters are valid"),
};

/// The checksum of numbers, and of whatever can be formatted.
struct Sum(Digest<'static, u32, Table<1>>);

impl Sum {
    fn new() -> Self {
        Self(CRC.digest())
    }

    fn add(&mut self, number: u32) {
        self.0.update(&number.to_le_bytes());
    }

    fn add_debug(&mut self, value: &impl fmt::Debug) {
        // Sum's write_str never fails.
        let _ = write!(self, "{value:?}");
    }

    fn value(self) -> u32 {
        self.0.finalize()
    }
}

impl Write for Sum {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

fn random() -> u32 {
    let mut sum = Sum::new();
    let mut rng = Generator::new(1);
    for amplitude in 0..1_000 {
        sum.add(rng.bits());
        sum.add(rng.normal() as u32);
        sum.add(rng.symmetric(amplitude * 1_000) as u32);
    }
    sum.value()
}

/// Floating point, in software on the board.
fn trigonometry() -> u32 {
    let mut sum = Sum::new();
    for i in -1_000i16..=1_000 {
        let x = f32::from(i) / 159.0;
        sum.add(math::sin(x).to_bits());
        sum.add(math::cos(x).to_bits());
        sum.add(math::atan2(x, 0.7 - x / 3.0).to_bits());
    }
    sum.value()
}

/// Corners as learned staircases give them (up to ten increments of up to 0.5), as they are before
/// any learning, and large ones.
fn lattice(report: &mut impl Report) {
    const HALF: u32 = 1 << (Corners::FRACTION_BITS - 1);
    let mut rng = Generator::new(2);
    let mut sum = Sum::new();
    for i in 0..300 {
        let corners = Corners([(); 4].map(|()| {
            let increments = 1 + rng.symmetric(1 << 20).unsigned_abs() % 10;
            (0..increments).map(|_| rng.symmetric(HALF)).sum()
        }));
        settle(report, &mut sum, &mut rng, &corners);
        if i % 30 == 0 {
            let large = Corners([(); 4].map(|()| rng.symmetric(Corners::MAX.unsigned_abs())));
            for corners in [Corners::default(), large] {
                settle_untimed(&mut sum, &mut rng, &corners);
            }
        }
    }
    report.group("lattice", sum.value());
}

fn settle(report: &mut impl Report, sum: &mut Sum, rng: &mut Generator, corners: &Corners) {
    let noise = Noise::draw(rng);
    let settled = report.timed(|| COEFFICIENTS.lattice.settle(corners, &noise));
    sum.add_debug(&settled);
}

fn settle_untimed(sum: &mut Sum, rng: &mut Generator, corners: &Corners) {
    sum.add_debug(&COEFFICIENTS.lattice.settle(corners, &Noise::draw(rng)));
}

/// A robot that drives about, learns, and tells of it.
fn controller(report: &mut impl Report) {
    let mut knowledge = Knowledge::new(&COEFFICIENTS.learning);
    let (mut records, mut frames) = (Sum::new(), Sum::new());
    let mut encoder = Encoder::new();
    let mut buffer = [0; MAX_FRAME];
    let mut world = Generator::with_stream(3, 7);
    let rng = Generator::new(3);
    let mut controller =
        Controller::new(&COEFFICIENTS, PaperRule, &mut knowledge, rng, Mode::Learn);
    for i in 0..400 {
        if i == 300 {
            controller.set_mode(Mode::Run);
        }
        let record = controller.step(&sample(&mut world), &AimAtTarget);
        records.add_debug(&record);
        match encoder.encode(&record, &mut buffer) {
            Ok(frame) => frames.0.update(frame),
            Err(error) => frames.add_debug(&error),
        }
    }
    let mut bytes = Sum::new();
    let written = knowledge.write::<PaperRule, ()>(&Parameters::PAPER, |part| {
        bytes.0.update(part);
        Ok(())
    });
    bytes.add_debug(&written);
    report.group("controller", records.value());
    report.group("frames", frames.value());
    report.group("knowledge", bytes.value());
}

fn sample(world: &mut Generator) -> Sample {
    let mut distance = |cm| Micrometres(world.symmetric(cm * Micrometres::PER_CM).unsigned_abs());
    let (front, left, right) = (distance(50), distance(30), distance(30));
    let half_turn = Microdegrees::HALF_TURN.0.unsigned_abs();
    Sample {
        front,
        left,
        right,
        heading: Microdegrees(world.symmetric(half_turn)),
        target_bearing: Some(Microdegrees(world.symmetric(half_turn))),
    }
}

fn ranges() -> u32 {
    let mut sum = Sum::new();
    for curve in [RangeCurve::GP2D12, RangeCurve::GP2Y0A21] {
        for counts in (0..=AdcCount::MAX).filter_map(AdcCount::new) {
            sum.add(curve.distance(counts).0);
        }
    }
    sum.value()
}

/// Bearings that turn slowly, now and then out of order.
fn compass() -> u32 {
    let mut sum = Sum::new();
    let mut rng = Generator::new(4);
    let mut compass = Compass::new(Microdegrees::from_degrees(30));
    for i in 0..1_000u32 {
        let now = Instant(20_000 * u64::from(i));
        let wild = if i % 50 < 3 { 1_800 } else { 20 };
        let tenths = (i * 7 + 3_600).wrapping_add_signed(rng.symmetric(wild)) % 3_600;
        let [_, _, high, low] = tenths.to_be_bytes();
        compass.push(now, [(tenths * 256 / 3_600) as u8, high, low]);
        sum.add_debug(&(compass.heading(now), compass.health(now)));
    }
    sum.value()
}

/// Moves of a rover that turns and rolls as its wheels say, more or less.
fn moves() -> u32 {
    let mut sum = Sum::new();
    let mut rng = Generator::new(5);
    let Ok(mut motion) = Motion::new(motion::Parameters::LYNXMOTION_4WD2) else {
        return 0;
    };
    let mut heading = Microdegrees(0);
    for period in 0..4_000u32 {
        let now = Instant(20_000 * u64::from(period));
        if !motion.under_way() {
            let turn = Microdegrees(rng.symmetric(180_000_000));
            sum.add_debug(&motion.start(turn, Micrometres(rng.symmetric(300_000).unsigned_abs())));
        }
        let clearance = Ranges {
            front: Micrometres::from_cm(60 - period / 70),
            left: Micrometres::from_cm(50),
            right: Micrometres::from_cm(50),
        };
        let heard = (period % 900 < 890).then_some(heading);
        let (wheels, event) = motion.step(
            now,
            Senses {
                heading: heard,
                clearance,
            },
        );
        let turn = i32::from(wheels.right()) - i32::from(wheels.left());
        heading = heading.turned(Microdegrees(turn * 1_800 + rng.symmetric(50_000)));
        sum.add_debug(&(wheels, event));
    }
    sum.value()
}

/// Anything at any time.
fn supervision() -> u32 {
    let mut sum = Sum::new();
    let mut rng = Generator::new(6);
    let mut now = Instant(0);
    let mut supervisor = Supervisor::new(now, ResetReason::PowerOn);
    let usual = [
        Input::Alive(Loop::Sense),
        Input::Alive(Loop::Control),
        Input::Alive(Loop::Drive),
        Input::Alive(Loop::Link),
        Input::Alive(Loop::Store),
        Input::Ranges([ChannelHealth::Good; 4]),
        Input::Compass(CompassHealth::Good),
        Input::Knowledge { valid: true },
        Input::Hello { matches: true },
        Input::Arm,
    ];
    let rare = [
        Input::Ranges([ChannelHealth::Open; 4]),
        Input::Compass(CompassHealth::Silent),
        Input::Disarm,
        Input::Unsettled,
        Input::QueueFull(3),
        Input::BadFrames(2),
        Input::BusRecovered,
        Input::AdcError,
    ];
    for _ in 0..3_000 {
        now = now.after(Duration(u64::from(rng.symmetric(20_000).unsigned_abs())));
        let draw = rng.symmetric(1 << 16).unsigned_abs() as usize;
        let input = if draw.is_multiple_of(40) {
            rare[draw % rare.len()]
        } else {
            usual[draw % usual.len()]
        };
        sum.add_debug(&supervisor.handle(now, input));
        sum.add_debug(&(
            supervisor.state(),
            supervisor.motors_enabled(),
            supervisor.take_fault(),
        ));
    }
    sum.add_debug(supervisor.counters());
    sum.value()
}
