use std::boxed::Box;
use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::checksum::fingerprint;
use crate::contract::*;
use crate::controller::StepRecord;
use crate::knowledge::Knowledge;
use crate::motion::{Parameters as Chassis, WheelCommand};
use crate::parameters::Parameters;
use crate::reward::FollowDirection;
use crate::sensing::ir::{AdcCount, IrReading};
use crate::supervisor::{Input, Supervisor};
use crate::units::Micrometres;
use crate::wire::SCHEMA_HASH;
use crate::wire::message::{ActionRecord, Chunk, Command, Event, EventKind, Report};

static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are valid"),
};

const IDENTITY: Identity = Identity {
    board: "bench",
    firmware: "0",
};
const LOOPS: [crate::supervisor::Loop; 5] = {
    use crate::supervisor::Loop::{Control, Drive, Link, Sense, Store};
    [Sense, Control, Drive, Link, Store]
};

/// A rover on a bench: its wheels turn it, and how near things are is up to the test.
struct Bench {
    rover: Rover<'static>,
    supervisor: Supervisor,
    now: Instant,
    heading: Microdegrees,
    distance: Micrometres,
    compass: bool,
    reports: Vec<Report>,
    applied: WheelCommand,
}

impl Bench {
    fn new(seed: u64) -> Self {
        let knowledge = Box::leak(Box::new(Knowledge::EMPTY));
        let staging = Box::leak(Box::new(Staging::EMPTY));
        let motion = Motion::new(Chassis::LYNXMOTION_4WD2).expect("a chassis that is known");
        let make = (RangeCurve::GP2D12, motion);
        let mut bench = Self {
            rover: Rover::new(&COEFFICIENTS, knowledge, staging, make, IDENTITY, seed),
            supervisor: Supervisor::new(Instant(0), ResetReason::PowerOn),
            now: Instant(0),
            heading: Microdegrees(0),
            distance: Micrometres::from_cm(60),
            compass: true,
            reports: Vec::new(),
            applied: WheelCommand::STOP,
        };
        bench.rover.begin();
        bench
            .rover
            .announce(&mut (bench.now, &mut bench.supervisor));
        bench
    }

    /// One that has been introduced, and whose sensors are well.
    fn ready(seed: u64) -> Self {
        let mut bench = Self::new(seed);
        bench.run(10);
        bench.done(Command::Hello {
            schema: SCHEMA_HASH,
        });
        bench.reports.clear();
        bench
    }

    fn driving(seed: u64, mode: Mode) -> Self {
        let mut bench = Self::ready(seed);
        bench.done(Command::Arm);
        bench.done(Command::SetMode(mode));
        bench
    }

    fn seen(&self) -> Observation {
        Observation {
            time: self.now,
            ir: IrReading {
                counts: [AdcCount::ZERO; 4],
                distances: [self.distance; 4],
                health: [ChannelHealth::Good; 4],
            },
            heading: self.compass.then_some(self.heading),
            compass: if self.compass {
                CompassHealth::Good
            } else {
                CompassHealth::Silent
            },
        }
    }

    fn command(&mut self, command: &Command) -> (Result<(), Refusal>, Option<Report>) {
        let seen = self.seen();
        let mut watch = (self.now, &mut self.supervisor);
        let answer = self.rover.handle(self.now, command, &seen, &mut watch);
        // As the firmware's guard does whenever somebody has spoken to the supervisor.
        self.applied = self.supervisor.gate(self.applied);
        answer
    }

    fn done(&mut self, command: Command) -> Option<Report> {
        let (result, report) = self.command(&command);
        assert_eq!(result, Ok(()), "{command:?}");
        report
    }

    fn refused(&mut self, command: Command) -> Refusal {
        let (result, _) = self.command(&command);
        result.expect_err("is to be refused")
    }

    /// Control periods; a full duty turns by 180 degrees a second.
    fn run(&mut self, periods: u32) {
        for _ in 0..periods {
            self.now = self.now.after(PERIOD);
            let turn = i32::from(self.applied.right()) - i32::from(self.applied.left());
            self.heading = self.heading.turned(Microdegrees(turn * 1_800));
            let seen = self.seen();
            let mut watch = (self.now, &mut self.supervisor);
            for of in LOOPS {
                assert_eq!(watch.handle(Input::Alive(of)), Ok(()));
            }
            assert_eq!(watch.handle(Input::Ranges(seen.ir.health)), Ok(()));
            assert_eq!(watch.handle(Input::Compass(seen.compass)), Ok(()));
            let reports = &mut self.reports;
            let mut report = |report| reports.push(report);
            let command = self.rover.step(self.now, &seen, &mut watch, &mut report);
            self.applied = self.supervisor.gate(command);
        }
    }

    fn actions(&self) -> Vec<ActionRecord> {
        let action = |report: &Report| match report {
            Report::Action(record) => Some(*record),
            _ => None,
        };
        self.reports.iter().filter_map(action).collect()
    }

    fn events(&self) -> Vec<EventKind> {
        let event = |report: &Report| match report {
            Report::Event(event) => Some(event.kind),
            _ => None,
        };
        self.reports.iter().filter_map(event).collect()
    }

    fn pull(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        loop {
            let offset = bytes.len() as u32;
            let Some(Report::Knowledge(chunk)) = self.done(Command::PullKnowledge { offset })
            else {
                panic!("a pull is answered with knowledge");
            };
            bytes.extend_from_slice(&chunk.data);
            if bytes.len() as u32 == chunk.total {
                assert_eq!(fingerprint(&bytes), chunk.fingerprint);
                return bytes;
            }
        }
    }

    fn push(&mut self, bytes: &[u8]) -> Result<(), Refusal> {
        for offset in (0..bytes.len()).step_by(crate::wire::message::CHUNK_BYTES) {
            let chunk = crate::wire::transfer::chunk_at(bytes, fingerprint(bytes), offset as u32);
            let chunk: Chunk = chunk.expect("within the bytes");
            self.command(&Command::PushKnowledge(chunk)).0?;
        }
        Ok(())
    }

    fn take_save(&mut self) -> Option<Save> {
        let mut watch = (self.now, &mut self.supervisor);
        self.rover.take_save(&mut watch)
    }

    fn saved(&mut self, fingerprint: Option<u32>) -> Option<Report> {
        let mut watch = (self.now, &mut self.supervisor);
        self.rover.saved(self.now, fingerprint, &mut watch)
    }
}

/// What a log of the reports would replay to: knowledge and records.
fn replay(bench: &Bench, start: &[u8]) -> (RoverKnowledge, Vec<StepRecord>) {
    let mut knowledge = Knowledge::EMPTY;
    knowledge.read::<Rule>(start).expect("was just written");
    let mut direction = Microdegrees(0);
    let mut records = Vec::new();
    let rng = Generator::new(0);
    let mode = learning::Mode::Learn;
    let mut controller = Controller::new(&COEFFICIENTS, Rule::default(), &mut knowledge, rng, mode);
    for report in &bench.reports {
        match report {
            Report::Event(Event {
                kind: EventKind::Session { seed, .. },
                ..
            }) => {
                controller.restart(Generator::new(*seed), mode);
            }
            Report::Event(Event {
                kind: EventKind::Direction(to),
                ..
            }) => {
                direction = *to;
                controller.interrupt();
            }
            Report::Action(action) => {
                records.push(controller.step(&action.sample, &FollowDirection(direction)));
                if interrupts(action.outcome) {
                    controller.interrupt();
                }
            }
            _ => {}
        }
    }
    (knowledge, records)
}

#[test]
fn actions_follow_each_other_and_learning_turns_the_rover() {
    let mut bench = Bench::driving(7, Mode::Learn);
    bench.run(3_000);
    let actions = bench.actions();
    assert!(actions.len() > 20, "{} actions in a minute", actions.len());
    assert!(actions.iter().all(|a| a.outcome == Outcome::Completed));
    let settled = |pair: &[ActionRecord]| pair[1].time.since(pair[0].time) >= SETTLE;
    assert!(actions.windows(2).all(settled));
    assert!(actions[1..].iter().all(|a| a.step.learned.is_some()));
    let Some(Report::Status(status)) = bench.done(Command::ReadStatus) else {
        panic!("a status was asked for");
    };
    // The last one is under way, or has just ended.
    assert!(status.steps as usize - actions.len() <= 1);
    assert!(status.motors_enabled);
}

#[test]
fn a_session_replays_from_its_reports_to_the_same_bits() {
    let mut bench = Bench::ready(11);
    let start = bench.pull();
    bench.done(Command::SetTask(Task::FollowChangingDirection));
    bench.done(Command::Arm);
    bench.done(Command::SetMode(Mode::Learn));
    for i in 0u32..60 {
        bench.run(100);
        // Odd things happen: obstacles, a compass that fails, a new order, another session.
        bench.distance = Micrometres::from_cm(11 + i * 7 % 50);
        match i % 12 {
            3 => {
                bench.compass = false;
                bench.run(8);
                bench.compass = true;
            }
            7 => assert_eq!(
                bench.done(Command::SetDirection(Microdegrees::from_degrees(i as i32))),
                None
            ),
            11 => {
                bench.done(Command::SetMode(Mode::Idle));
                bench.run(1);
                bench.done(Command::SetMode(Mode::Learn));
            }
            _ => {}
        }
    }
    bench.done(Command::Disarm);
    bench.run(1);
    let (knowledge, records) = replay(&bench, &start);
    let driven: Vec<_> = bench.actions().iter().map(|action| action.step).collect();
    assert!(driven.len() > 100);
    assert_eq!(records, driven);
    assert!(knowledge == *bench.rover.controller.knowledge());
    let kinds = bench.events();
    let sessions = kinds.iter().filter_map(|kind| match kind {
        EventKind::Session { seed, .. } => Some(*seed),
        _ => None,
    });
    let seeds: Vec<_> = sessions.collect();
    assert!(seeds.len() > 3 && seeds.windows(2).all(|pair| pair[0] != pair[1]));
    let redrawn = |kind: &&EventKind| matches!(kind, EventKind::Direction(_));
    assert!(kinds.iter().filter(redrawn).count() >= seeds.len() + 5);
}

#[test]
fn a_seed_that_was_set_is_the_next_sessions() {
    let mut bench = Bench::ready(1);
    bench.done(Command::SetSeed(77));
    bench.done(Command::Arm);
    bench.done(Command::SetMode(Mode::Run));
    bench.run(1);
    let session = |kind: &EventKind| {
        matches!(
            kind,
            EventKind::Session {
                seed: 77,
                mode: Mode::Run,
                ..
            }
        )
    };
    assert!(bench.events().iter().any(session));
    assert_eq!(bench.refused(Command::SetSeed(78)), Refusal::Armed);
    // At once after a session, and before the rover noticed its end.
    bench.done(Command::Disarm);
    bench.done(Command::SetSeed(77));
    bench.done(Command::Arm);
    bench.run(1);
    bench.done(Command::SetMode(Mode::Run));
    bench.run(1);
    assert_eq!(
        bench.events().iter().filter(|kind| session(kind)).count(),
        2
    );
    bench.done(Command::Disarm);
    bench.run(1);
    bench.done(Command::Arm);
    bench.done(Command::SetMode(Mode::Run));
    bench.run(1);
    assert_eq!(
        bench.events().iter().filter(|kind| session(kind)).count(),
        2
    );
}

#[test]
fn what_happened_to_a_stopped_action_is_not_learned_from() {
    let mut bench = Bench::driving(3, Mode::Learn);
    while bench.applied == WheelCommand::STOP {
        bench.run(1);
    }
    bench.compass = false;
    bench.run(10);
    let stopped = bench
        .actions()
        .pop()
        .expect("the action under way was reported");
    assert!(interrupts(stopped.outcome), "{:?}", stopped.outcome);
    assert_eq!(bench.applied, WheelCommand::STOP);
    bench.compass = true;
    let before = bench.actions().len();
    while bench.actions().len() == before {
        bench.run(1);
    }
    assert_eq!(bench.actions()[before].step.learned, None);
}

#[test]
fn an_obstacle_blocks_and_is_learned_from() {
    let mut bench = Bench::driving(3, Mode::Learn);
    bench.distance = Micrometres::from_cm(11);
    bench.run(600);
    let actions = bench.actions();
    assert!(actions.iter().all(|a| a.outcome == Outcome::Obstacle));
    assert!(actions.len() > 5 && actions[1..].iter().all(|a| a.step.learned.is_some()));
    let blocked = bench.supervisor.counters().of(Fault::Blocked);
    assert_eq!(blocked as usize, actions.len());
}

#[test]
fn nothing_but_hello_and_disarm_is_served_before_an_introduction() {
    let mut bench = Bench::new(1);
    bench.run(10);
    for command in [
        Command::Ping,
        Command::Arm,
        Command::ReadStatus,
        Command::NewKnowledge,
    ] {
        assert_eq!(bench.refused(command), Refusal::NoHello);
    }
    assert_eq!(bench.done(Command::Disarm), None);
    let (result, answer) = bench.command(&Command::Hello {
        schema: !SCHEMA_HASH,
    });
    assert_eq!(result, Err(Refusal::SchemaMismatch));
    assert!(
        matches!(answer, Some(Report::Hello(_))),
        "so that the host can say what to update"
    );
    assert!(!bench.rover.talks());
    assert_eq!(bench.refused(Command::Arm), Refusal::SchemaMismatch);
    assert!(
        bench
            .done(Command::Hello {
                schema: SCHEMA_HASH
            })
            .is_some()
    );
    assert!(bench.rover.talks());
    bench.rover.closed();
    assert_eq!(bench.refused(Command::Ping), Refusal::NoHello);
}

#[test]
fn hello_tells_who_it_is() {
    let mut bench = Bench::new(5);
    let mut watch = (bench.now, &mut bench.supervisor);
    let Report::Hello(hello) = bench.rover.hello(&mut watch) else {
        panic!("a hello is a hello");
    };
    assert_eq!((hello.board.as_str(), hello.seed), ("bench", 5));
    assert_eq!(hello.reset, ResetReason::PowerOn);
    let mut bench = Bench::ready(5);
    assert_eq!(hello.knowledge, Some(fingerprint(&bench.pull())));
}

#[test]
fn the_host_moves_the_rover_and_hears_how_it_went() {
    let mut bench = Bench::ready(1);
    let turn = Command::Drive {
        turn: Microdegrees::from_degrees(90),
        advance: Micrometres::from_cm(10),
    };
    assert_eq!(bench.refused(turn.clone()), Refusal::NotHostDriven);
    bench.done(Command::Arm);
    bench.done(Command::Heartbeat);
    bench.done(Command::SetMode(Mode::Host));
    // At once, before the rover took a step.
    bench.done(turn.clone());
    bench.run(2);
    assert_eq!(bench.refused(turn), Refusal::MoveUnderWay);
    for _ in 0..20 {
        bench.done(Command::Heartbeat);
        bench.run(20);
    }
    assert!(
        bench
            .events()
            .contains(&EventKind::MoveEnded(Outcome::Completed))
    );
    let error = Microdegrees::from_degrees(90).turn_from(bench.heading);
    assert!(error.0.abs() < 4_000_000, "{}", error.0);
    let far = Command::Drive {
        turn: Microdegrees(0),
        advance: Micrometres::from_cm(101),
    };
    assert_eq!(bench.refused(far), Refusal::OutOfRange);
}

#[test]
fn orders_that_make_no_sense_are_refused() {
    let mut bench = Bench::ready(1);
    assert_eq!(
        bench.refused(Command::SetTask(Task::AimAtTarget)),
        Refusal::Unsupported
    );
    let beyond = Microdegrees::from_degrees(181);
    assert_eq!(
        bench.refused(Command::SetDirection(beyond)),
        Refusal::OutOfRange
    );
    assert_eq!(
        bench.refused(Command::SetMode(Mode::Learn)),
        Refusal::NotArmed
    );
}

#[test]
fn knowledge_goes_out_and_comes_back() {
    let mut teacher = Bench::driving(9, Mode::Learn);
    teacher.run(2_000);
    assert_eq!(
        teacher.refused(Command::PullKnowledge { offset: 0 }),
        Refusal::Armed
    );
    teacher.done(Command::Disarm);
    teacher.run(1);
    let learned = teacher.pull();

    let mut pupil = Bench::ready(10);
    assert_eq!(pupil.push(&learned), Ok(()));
    assert_eq!(pupil.pull(), learned);
    assert!(pupil.rover.controller.knowledge() == teacher.rover.controller.knowledge());
    assert_eq!(
        pupil.refused(Command::Arm),
        Refusal::FlashBusy,
        "until it is stored"
    );
    assert_eq!(pupil.refused(Command::NewKnowledge), Refusal::FlashBusy);
    assert_eq!(pupil.push(&learned), Err(Refusal::FlashBusy));
    assert_eq!(pupil.take_save(), Some(Save::Knowledge));
    assert_eq!(pupil.rover.knowledge_bytes(), learned);
    let stored = pupil.saved(Some(fingerprint(&learned)));
    assert!(matches!(
        stored,
        Some(Report::Event(Event {
            kind: EventKind::KnowledgeStored { .. },
            ..
        }))
    ));
    assert_eq!(pupil.take_save(), None);
    pupil.done(Command::Arm);
    assert_eq!(pupil.push(&learned), Err(Refusal::Armed));
    assert_eq!(pupil.refused(Command::NewKnowledge), Refusal::Armed);
}

#[test]
fn bad_knowledge_is_refused_and_the_own_kept() {
    let mut bench = Bench::driving(2, Mode::Learn);
    bench.run(500);
    bench.done(Command::Disarm);
    bench.run(1);
    let own = bench.pull();
    let mut damaged = own.clone();
    damaged[300] ^= 1;
    assert_eq!(bench.push(&damaged), Err(Refusal::BadKnowledge));
    let mut foreign = Vec::new();
    let written = RoverKnowledge::new(&COEFFICIENTS.learning).write::<Rule, ()>(
        &Parameters::PAPER,
        |piece| {
            foreign.extend_from_slice(piece);
            Ok(())
        },
    );
    assert_eq!(written, Ok(()));
    assert_eq!(
        bench.push(&foreign),
        Err(Refusal::BadKnowledge),
        "of other parameters"
    );
    assert_eq!(bench.pull(), own);
    bench.done(Command::Arm);
}

#[test]
fn what_was_learned_is_saved_once_disarmed_and_only_then() {
    let mut bench = Bench::driving(4, Mode::Learn);
    bench.run(200);
    assert_eq!(bench.take_save(), None, "armed");
    assert_eq!(bench.refused(Command::StoreKnowledge), Refusal::Armed);
    bench.done(Command::Disarm);
    assert_eq!(bench.take_save(), Some(Save::Knowledge));
    assert_eq!(bench.saved(None), None, "the flash failed");
    let failed = Fault::FlashFailed;
    assert_eq!(bench.supervisor.counters().of(failed), 1);
    assert_eq!(
        bench.take_save(),
        None,
        "and is not worn out by trying again"
    );
    bench.done(Command::StoreKnowledge);
    assert_eq!(bench.take_save(), Some(Save::Knowledge));
    assert!(bench.saved(Some(1)).is_some());

    bench.done(Command::Arm);
    bench.done(Command::SetMode(Mode::Run));
    bench.run(200);
    bench.done(Command::Disarm);
    assert_eq!(bench.take_save(), None, "nothing was learned");
}

#[test]
fn calibrations_hold_at_once_and_are_saved() {
    let mut bench = Bench::ready(1);
    let offset = Microdegrees::from_degrees(90);
    bench.done(Command::Calibrate(Calibration::Compass { offset }));
    assert_eq!(bench.rover.calibrations().compass_offset, offset);
    let speed = Micrometres::from_cm(33);
    bench.done(Command::Calibrate(Calibration::Speed {
        duty: 500,
        speed,
        dead_band: 100,
    }));
    assert_eq!(bench.rover.motion.parameters().cruise_speed, speed);
    assert_eq!(bench.take_save(), Some(Save::Calibrations));
    assert_eq!(bench.saved(Some(1)), None, "is no knowledge");
    assert_eq!(bench.take_save(), None);

    let mut buffer = [0; crate::calibration::MOST_BYTES];
    let bytes = bench.rover.calibrations().encode(&mut buffer);
    let mut other = Bench::ready(2);
    assert!(other.rover.restore_calibrations(bytes));
    assert_eq!(other.rover.motion.parameters().cruise_speed, speed);
    other.done(Command::Arm);
    let again = Command::Calibrate(Calibration::Compass { offset });
    assert_eq!(other.refused(again), Refusal::Armed);
}

#[test]
fn stored_knowledge_is_loaded_or_arming_is_refused() {
    let mut teacher = Bench::driving(9, Mode::Learn);
    teacher.run(1_000);
    teacher.done(Command::Disarm);
    teacher.run(1);
    let learned = teacher.pull();
    let mut bench = Bench::ready(1);
    let load = |bench: &mut Bench, bytes: &[u8]| {
        let loaded = bench.rover.load(|room| {
            room[..bytes.len()].copy_from_slice(bytes);
            Some(bytes.len())
        });
        bench
            .rover
            .announce(&mut (bench.now, &mut bench.supervisor));
        loaded
    };
    assert_eq!(load(&mut bench, &learned), Ok(()));
    assert_eq!(bench.pull(), learned);
    assert_eq!(load(&mut bench, &learned[1..]), Err(Refusal::BadKnowledge));
    assert_eq!(bench.refused(Command::Arm), Refusal::KnowledgeInvalid);
    assert_eq!(
        bench.refused(Command::PullKnowledge { offset: 0 }),
        Refusal::KnowledgeInvalid
    );
    bench.done(Command::NewKnowledge);
    bench.done(Command::Arm);
}

#[test]
fn changes_of_health_and_state_are_reported_once() {
    let mut bench = Bench::driving(1, Mode::Run);
    bench.run(50);
    bench.compass = false;
    bench.run(50);
    let kinds = bench.events();
    let silent = |kind: &&EventKind| matches!(kind, EventKind::Compass(CompassHealth::Silent));
    assert_eq!(kinds.iter().filter(silent).count(), 1);
    let driving = |kind: &&EventKind| matches!(kind, EventKind::State(State::Driving(Mode::Run)));
    assert_eq!(kinds.iter().filter(driving).count(), 1);
    assert!(
        bench
            .reports
            .iter()
            .any(|report| matches!(report, Report::Fault(_)))
    );
}

fn commands() -> impl Strategy<Value = Command> {
    let angle = any::<i32>().prop_map(Microdegrees);
    prop_oneof![
        Just(Command::Hello {
            schema: SCHEMA_HASH
        }),
        Just(Command::Heartbeat),
        Just(Command::Arm),
        Just(Command::Disarm),
        prop::sample::select(&[Mode::Idle, Mode::Learn, Mode::Run, Mode::Host][..])
            .prop_map(Command::SetMode),
        prop::sample::select(&[Task::FollowDirection, Task::FollowChangingDirection][..])
            .prop_map(Command::SetTask),
        angle.clone().prop_map(Command::SetDirection),
        (angle, any::<u32>()).prop_map(|(turn, advance)| Command::Drive {
            turn,
            advance: Micrometres(advance)
        }),
        any::<u64>().prop_map(Command::SetSeed),
        Just(Command::ReadStatus),
        any::<u32>().prop_map(|offset| Command::PullKnowledge { offset }),
        Just(Command::StoreKnowledge),
        Just(Command::NewKnowledge),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever is asked for and whatever is sensed: wheels are driven only while driving, a move's
    /// end is told once, and nothing panics.
    #[test]
    fn no_course_of_events_moves_a_rover_that_is_not_driving(
        course in prop::collection::vec((commands(), 0u32..40, 5u32..70, any::<bool>()), 1..60),
        saves: bool,
    ) {
        let mut bench = Bench::ready(1);
        for (command, periods, cm, compass) in course {
            let _ = bench.command(&command);
            bench.distance = Micrometres::from_cm(cm);
            // Mostly well, or hardly anything would ever be driven.
            bench.compass = compass || cm > 20;
            for _ in 0..periods {
                bench.run(1);
                if bench.applied.drives() {
                    prop_assert!(matches!(bench.supervisor.state(), State::Driving(_)));
                    prop_assert!(bench.supervisor.motors_enabled());
                }
            }
            if saves && bench.take_save().is_some() {
                prop_assert!(!bench.applied.drives());
                bench.saved(Some(0));
            }
        }
        bench.done(Command::Disarm);
        bench.run(1);
        prop_assert_eq!(bench.applied, WheelCommand::STOP);
        prop_assert!(!bench.rover.motion.under_way());
    }
}
