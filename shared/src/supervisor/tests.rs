use super::*;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

const LOOPS: [Loop; 5] = [
    Loop::Sense,
    Loop::Control,
    Loop::Drive,
    Loop::Link,
    Loop::Store,
];
const GOOD: [ChannelHealth; 4] = [ChannelHealth::Good; 4];

/// A rover whose parts all live, unless a test silences them.
struct Bench {
    supervisor: Supervisor,
    now: Instant,
    /// What comes every 10 ms.
    signals: Vec<Input>,
}

impl Bench {
    /// Everything is well; disarmed.
    fn new() -> Self {
        let mut signals: Vec<_> = LOOPS.map(Input::Alive).to_vec();
        signals.extend([
            Input::Ranges(GOOD),
            Input::Compass(CompassHealth::Good),
            Input::Heartbeat,
        ]);
        let mut bench = Self {
            supervisor: Supervisor::new(Instant(0), ResetReason::PowerOn),
            now: Instant(0),
            signals,
        };
        bench.ok(Input::Hello { matches: true });
        bench.ok(Input::Knowledge { valid: true });
        bench.run(50);
        bench
    }

    fn driving(mode: Mode) -> Self {
        let mut bench = Self::new();
        bench.ok(Input::Arm);
        bench.ok(Input::SetMode(mode));
        assert!(bench.supervisor.motors_enabled());
        bench
    }

    fn tell(&mut self, input: Input) -> Result<(), Refusal> {
        self.supervisor.handle(self.now, input)
    }

    fn ok(&mut self, input: Input) {
        assert_eq!(self.tell(input), Ok(()), "{input:?}");
    }

    fn without(&mut self, silent: Input) {
        let before = self.signals.len();
        self.signals.retain(|signal| *signal != silent);
        assert_eq!(self.signals.len(), before - 1);
    }

    /// Runs the guard's polls, and what comes beside them.
    fn run(&mut self, milliseconds: u32) {
        for _ in 0..milliseconds / 10 {
            self.now = self.now.after(GUARD_PERIOD);
            for signal in self.signals.clone() {
                self.ok(signal);
            }
            self.supervisor.poll(self.now);
        }
    }

    /// Milliseconds until this holds.
    fn time_to(&mut self, holds: fn(&Supervisor) -> bool) -> u32 {
        (0..10_000)
            .step_by(10)
            .find(|_| {
                let held = holds(&self.supervisor);
                if !held {
                    self.run(10);
                }
                held
            })
            .expect("it happens within 10 s")
    }

    fn count(&self, fault: Fault) -> u32 {
        self.supervisor.counters().of(fault)
    }

    fn state(&self) -> State {
        self.supervisor.state()
    }
}

fn off(supervisor: &Supervisor) -> bool {
    !supervisor.motors_enabled()
}

fn faulted(supervisor: &Supervisor) -> bool {
    matches!(supervisor.state(), State::Faulted(_))
}

#[test]
fn a_reset_comes_up_disarmed_with_its_reason() {
    let supervisor = Supervisor::new(Instant(0), ResetReason::Watchdog);
    assert_eq!(supervisor.state(), State::Disarmed);
    assert_eq!(supervisor.reset_reason(), ResetReason::Watchdog);
    assert_eq!(
        supervisor.gate(WheelCommand::new(500, 500)),
        WheelCommand::STOP
    );
}

#[test]
fn arming_is_refused_with_the_reason() {
    let mut open = GOOD;
    open[2] = ChannelHealth::Open;
    let mut three = GOOD;
    three[0] = ChannelHealth::NotFitted;
    let cases = [
        (
            vec![Input::Hello { matches: false }],
            Refusal::SchemaMismatch,
        ),
        (
            vec![Input::Knowledge { valid: false }],
            Refusal::KnowledgeInvalid,
        ),
        (vec![Input::FlashWrite], Refusal::FlashBusy),
        (
            vec![Input::Ranges(open)],
            Refusal::RangeSensor {
                channel: 2,
                health: ChannelHealth::Open,
            },
        ),
        (
            vec![Input::Ranges(three)],
            Refusal::RangeSensor {
                channel: 0,
                health: ChannelHealth::NotFitted,
            },
        ),
        (
            vec![Input::Compass(CompassHealth::Implausible)],
            Refusal::Compass(CompassHealth::Implausible),
        ),
    ];
    for (inputs, refusal) in cases {
        let mut bench = Bench::new();
        inputs.into_iter().for_each(|input| bench.ok(input));
        assert_eq!(bench.tell(Input::Arm), Err(refusal));
        assert_eq!(
            (bench.state(), bench.count(Fault::ArmRefused)),
            (State::Disarmed, 1)
        );
    }
    let silences = [
        (Input::Alive(Loop::Control), Refusal::ControlSilent),
        (
            Input::Compass(CompassHealth::Good),
            Refusal::Compass(CompassHealth::Silent),
        ),
        (
            Input::Ranges(GOOD),
            Refusal::RangeSensor {
                channel: 0,
                health: ChannelHealth::Silent,
            },
        ),
    ];
    for (silent, refusal) in silences {
        let mut bench = Bench::new();
        bench.without(silent);
        bench.run(300);
        assert_eq!(bench.tell(Input::Arm), Err(refusal));
    }
    let mut fresh = Supervisor::new(Instant(0), ResetReason::PowerOn);
    assert_eq!(fresh.handle(Instant(0), Input::Arm), Err(Refusal::NoHello));
}

#[test]
fn a_rover_with_one_front_sensor_can_be_armed() {
    let mut bench = Bench::new();
    let mut single = GOOD;
    single[FRONT_RIGHT] = ChannelHealth::NotFitted;
    bench.ok(Input::Ranges(single));
    bench.ok(Input::Arm);
}

#[test]
fn motors_run_while_driving_only() {
    let mut bench = Bench::new();
    let command = WheelCommand::new(300, -300);
    assert_eq!(
        bench.tell(Input::SetMode(Mode::Learn)),
        Err(Refusal::NotArmed)
    );
    bench.ok(Input::Arm);
    assert_eq!(bench.supervisor.gate(command), WheelCommand::STOP);
    bench.ok(Input::SetMode(Mode::Learn));
    assert_eq!(bench.supervisor.gate(command), command);
    bench.ok(Input::SetMode(Mode::Idle));
    assert_eq!(
        (bench.state(), off(&bench.supervisor)),
        (State::Armed, true)
    );
    bench.ok(Input::SetMode(Mode::Run));
    bench.ok(Input::Arm);
    assert_eq!(
        bench.state(),
        State::Driving(Mode::Run),
        "arming twice changes nothing"
    );
    bench.ok(Input::Disarm);
    assert_eq!(
        (bench.state(), off(&bench.supervisor)),
        (State::Disarmed, true)
    );
}

#[test]
fn a_silent_control_loop_is_a_fault_within_200_ms() {
    let mut bench = Bench::driving(Mode::Run);
    bench.without(Input::Alive(Loop::Control));
    assert!((150..=200).contains(&bench.time_to(off)));
    assert_eq!(bench.state(), State::Faulted(Fault::ControlSilent));
    assert_eq!(bench.count(Fault::ControlSilent), 1);
}

#[test]
fn any_silent_loop_lets_the_watchdog_reset_the_board_within_1_s() {
    for silent in LOOPS {
        for mut bench in [Bench::new(), Bench::driving(Mode::Learn)] {
            bench.run(5_000);
            assert!(bench.supervisor.feed_watchdog(), "nothing is silent");
            bench.without(Input::Alive(silent));
            let unfed = Duration::from_millis(bench.time_to(|s| !s.feed_watchdog()));
            assert!(
                unfed.plus(HARDWARE_WATCHDOG) <= Duration::from_millis(1_000),
                "{silent:?}"
            );
            assert!(off(&bench.supervisor));
            assert_eq!(bench.count(Fault::TaskSilent), 1);
            bench.ok(Input::Alive(silent));
            bench.run(100);
            assert!(
                !bench.supervisor.feed_watchdog(),
                "it stays hungry until the reset"
            );
        }
    }
}

#[test]
fn an_obstacle_counts_as_blocked_and_the_rover_goes_on() {
    let mut bench = Bench::driving(Mode::Run);
    for times in 1..=5 {
        bench.ok(Input::Moved(Outcome::Obstacle));
        assert_eq!(bench.count(Fault::Blocked), times);
    }
    assert!(bench.supervisor.motors_enabled());
}

#[test]
fn an_unfit_range_sensor_stops_at_once_and_disarms_when_it_lasts() {
    for health in [
        ChannelHealth::Open,
        ChannelHealth::Shorted,
        ChannelHealth::Frozen,
    ] {
        let mut bench = Bench::driving(Mode::Run);
        bench.without(Input::Ranges(GOOD));
        let mut ranges = GOOD;
        ranges[1] = health;
        bench.signals.push(Input::Ranges(ranges));
        assert!(bench.time_to(off) <= 10, "{health:?}");
        assert_eq!(
            bench.state(),
            State::Driving(Mode::Run),
            "stopped, not yet disarmed"
        );
        assert!((1_900..=2_000).contains(&bench.time_to(faulted)));
        assert_eq!(bench.state(), State::Faulted(Fault::RangeSensor));
    }
}

#[test]
fn silent_range_sensors_stop_within_200_ms() {
    let mut bench = Bench::driving(Mode::Run);
    bench.without(Input::Ranges(GOOD));
    assert!((150..=200).contains(&bench.time_to(off)));
}

#[test]
fn a_silent_compass_stops_within_100_ms_and_disarms_when_it_lasts() {
    let mut bench = Bench::driving(Mode::Learn);
    bench.without(Input::Compass(CompassHealth::Good));
    assert!((50..=100).contains(&bench.time_to(off)));
    assert_eq!(
        (bench.state(), bench.count(Fault::Compass)),
        (State::Driving(Mode::Learn), 1)
    );
    assert!(bench.time_to(faulted) <= 2_000);
}

#[test]
fn an_implausible_compass_stops_at_once_until_it_is_back() {
    let mut bench = Bench::driving(Mode::Learn);
    bench.ok(Input::Compass(CompassHealth::Implausible));
    assert!(off(&bench.supervisor));
    bench.ok(Input::Compass(CompassHealth::Implausible));
    assert_eq!(bench.count(Fault::Compass), 1, "counted once");
    bench.ok(Input::Compass(CompassHealth::Good));
    assert!(bench.supervisor.motors_enabled());
}

#[test]
fn three_moves_without_progress_in_a_row_disarm() {
    let mut bench = Bench::driving(Mode::Run);
    let stuck = Input::Moved(Outcome::NoProgress);
    for input in [stuck, stuck, Input::Moved(Outcome::Completed), stuck, stuck] {
        bench.ok(input);
        assert!(bench.supervisor.motors_enabled());
    }
    bench.ok(Input::Moved(Outcome::Obstacle));
    bench.ok(stuck);
    assert_eq!(
        bench.state(),
        State::Faulted(Fault::Stuck),
        "a bump is no progress"
    );
    assert_eq!(
        (bench.count(Fault::NoProgress), bench.count(Fault::Stuck)),
        (5, 1)
    );
}

fn late(supervisor: &Supervisor) -> bool {
    supervisor.counters().of(Fault::HostLate) > 0
}

#[test]
fn a_lost_host_is_warned_of_and_then_disarmed_if_it_drives() {
    let mut bench = Bench::driving(Mode::Host);
    bench.without(Input::Heartbeat);
    assert!((400..=500).contains(&bench.time_to(late)));
    assert!(bench.supervisor.motors_enabled());
    assert_eq!(bench.count(Fault::HostLate), 1);
    assert!(bench.time_to(off) <= 1_600);
    assert_eq!(bench.state(), State::Faulted(Fault::HostLost));
}

#[test]
fn a_host_that_drives_must_be_heard_first() {
    let mut bench = Bench::new();
    bench.without(Input::Heartbeat);
    bench.run(1_000);
    bench.ok(Input::Arm);
    assert_eq!(
        bench.tell(Input::SetMode(Mode::Host)),
        Err(Refusal::NoHeartbeat)
    );
    bench.ok(Input::Heartbeat);
    bench.ok(Input::SetMode(Mode::Host));
}

#[test]
fn autonomous_modes_need_no_host() {
    for mode in [Mode::Learn, Mode::Run] {
        let mut bench = Bench::driving(mode);
        bench.without(Input::Heartbeat);
        bench.run(60_000);
        assert!(bench.supervisor.motors_enabled());
        assert_eq!(bench.count(Fault::HostLate), 0);
    }
}

#[test]
fn the_flash_is_not_written_while_armed() {
    let mut bench = Bench::driving(Mode::Run);
    assert_eq!(bench.tell(Input::FlashWrite), Err(Refusal::Armed));
    bench.ok(Input::SetMode(Mode::Idle));
    assert_eq!(bench.tell(Input::FlashWrite), Err(Refusal::Armed));
    assert_eq!(bench.count(Fault::FlashWhileArmed), 2);
    bench.ok(Input::Disarm);
    bench.ok(Input::FlashWrite);
    assert_eq!(bench.tell(Input::FlashWrite), Err(Refusal::FlashBusy));
    bench.ok(Input::FlashDone { written: true });
    bench.ok(Input::Arm);
}

#[test]
fn what_is_only_counted_is_counted_and_harms_nobody() {
    let mut bench = Bench::driving(Mode::Run);
    let inputs = [
        (Input::BadFrames(3), Fault::BadFrame, 3),
        (Input::QueueFull(2), Fault::QueueFull, 2),
        (Input::Unsettled, Fault::Unsettled, 1),
        (Input::BusRecovered, Fault::BusRecovered, 1),
        (Input::AdcError, Fault::AdcError, 1),
        (Input::Moved(Outcome::TurnTimeout), Fault::TurnTimeout, 1),
        (Input::Moved(Outcome::Late), Fault::LateStep, 1),
    ];
    for (input, fault, times) in inputs {
        bench.ok(input);
        assert_eq!(bench.count(fault), times);
    }
    assert!(bench.supervisor.motors_enabled());
    assert_eq!(bench.tell(Input::QueueFull(0)), Ok(()));
    assert_eq!(bench.count(Fault::QueueFull), 2);
}

#[test]
fn a_fault_stands_until_disarmed_and_the_first_one_stays() {
    let mut bench = Bench::driving(Mode::Run);
    bench.without(Input::Alive(Loop::Control));
    bench.run(300);
    let fault = Refusal::Fault(Fault::ControlSilent);
    (0..5).for_each(|_| bench.ok(Input::Moved(Outcome::NoProgress)));
    bench.signals.push(Input::Alive(Loop::Control));
    bench.run(100);
    assert_eq!(bench.tell(Input::Arm), Err(fault));
    assert_eq!(bench.tell(Input::SetMode(Mode::Run)), Err(fault));
    bench.ok(Input::Disarm);
    bench.ok(Input::Arm);
}

#[test]
fn every_counted_fault_is_reported_once() {
    let mut bench = Bench::driving(Mode::Run);
    bench.ok(Input::Unsettled);
    bench.ok(Input::QueueFull(4));
    bench.ok(Input::Unsettled);
    let time = bench.now;
    let reports: Vec<_> = core::iter::from_fn(|| bench.supervisor.take_fault()).collect();
    assert_eq!(
        reports,
        [
            FaultReport {
                time,
                fault: Fault::Unsettled,
                count: 2
            },
            FaultReport {
                time,
                fault: Fault::QueueFull,
                count: 4
            },
        ]
    );
}

#[test]
fn a_clock_that_steps_back_is_a_fault() {
    let mut bench = Bench::driving(Mode::Run);
    let slightly = Instant(bench.now.0 - OUT_OF_ORDER.0);
    assert_eq!(bench.supervisor.handle(slightly, Input::Unsettled), Ok(()));
    assert!(bench.supervisor.motors_enabled());
    bench.supervisor.poll(Instant(slightly.0 - 1));
    assert_eq!(bench.state(), State::Faulted(Fault::ClockStepped));
}

#[test]
fn a_clock_that_runs_ahead_stops() {
    let mut bench = Bench::driving(Mode::Run);
    bench
        .supervisor
        .poll(bench.now.after(Duration::from_millis(1_000)));
    assert!(off(&bench.supervisor));
}

#[test]
fn every_rule_acts_in_the_states_it_names() {
    for rule in RULES {
        assert!(rule.within > GUARD_PERIOD);
        assert!(rule.when != When::Always || rule.response == Response::Reset);
    }
    let reset = LOOP_SILENCE.plus(HARDWARE_WATCHDOG).plus(GUARD_PERIOD);
    assert!(reset <= Duration::from_millis(1_000));
}

/// A second opinion, written without the table: what must have happened for motors to run.
#[derive(Default)]
struct Oracle {
    armed: bool,
    mode: Option<Mode>,
    control: Option<u64>,
    ranges: Option<u64>,
    compass: Option<u64>,
    heartbeat: Option<u64>,
    stuck: u32,
    latest: u64,
}

impl Oracle {
    /// The control loop gets its time to begin.
    fn after_reset(now: u64) -> Self {
        Self {
            latest: now,
            control: Some(now),
            ..Self::default()
        }
    }

    fn hear(&mut self, now: u64, input: Option<Input>, accepted: bool) {
        if now + 10_000 < self.latest {
            *self = Self::after_reset(now);
        }
        let now = now.max(self.latest);
        self.latest = now;
        let good = |ranges: [ChannelHealth; 4]| {
            let fit = |i: usize| ranges[i] == ChannelHealth::Good;
            fit(0) && fit(2) && fit(3) && (fit(1) || ranges[1] == ChannelHealth::NotFitted)
        };
        match input {
            Some(Input::Alive(Loop::Control)) => self.control = Some(now),
            Some(Input::Ranges(ranges)) => self.ranges = good(ranges).then_some(now),
            Some(Input::Compass(health)) => {
                self.compass = (health == CompassHealth::Good).then_some(now);
            }
            Some(Input::Heartbeat) => self.heartbeat = Some(now),
            Some(Input::Disarm) => self.armed = false,
            Some(Input::Arm) if accepted => {
                if !self.armed {
                    (self.mode, self.stuck) = (None, 0);
                }
                self.armed = true;
            }
            Some(Input::SetMode(mode)) if accepted => self.mode = Some(mode),
            Some(Input::Moved(Outcome::NoProgress)) => self.stuck += 1,
            Some(Input::Moved(Outcome::Completed)) => self.stuck = 0,
            _ => {}
        }
    }

    fn permits(&self) -> bool {
        let within = |seen: Option<u64>, limit| seen.is_some_and(|t| self.latest - t < limit);
        self.armed
            && self.stuck < 3
            && match self.mode {
                None | Some(Mode::Idle) => false,
                Some(Mode::Host) => within(self.heartbeat, 2_000_000),
                Some(Mode::Learn | Mode::Run) => true,
            }
            && within(self.control, 200_000)
            && within(self.ranges, 200_000)
            && within(self.compass, 100_000)
    }
}

fn any_input() -> impl Strategy<Value = Input> {
    let health = prop_oneof![
        12 => Just(ChannelHealth::Good),
        1 => Just(ChannelHealth::Frozen),
        1 => Just(ChannelHealth::NotFitted),
        1 => Just(ChannelHealth::Unknown),
    ];
    let outcome = prop_oneof![
        1 => Just(Outcome::Completed),
        1 => Just(Outcome::Obstacle),
        3 => Just(Outcome::NoProgress),
        1 => Just(Outcome::Stopped),
    ];
    let mode = prop::sample::select(vec![Mode::Idle, Mode::Learn, Mode::Run, Mode::Host]);
    let compass = prop_oneof![
        20 => Just(CompassHealth::Good),
        1 => Just(CompassHealth::Silent),
        1 => Just(CompassHealth::Implausible),
    ];
    prop_oneof![
        8 => prop::sample::select(LOOPS.to_vec()).prop_map(Input::Alive),
        3 => Just(Input::Alive(Loop::Control)),
        5 => Just(Input::Ranges(GOOD)),
        1 => prop::array::uniform4(health).prop_map(Input::Ranges),
        6 => compass.prop_map(Input::Compass),
        2 => Just(Input::Heartbeat),
        1 => outcome.prop_map(Input::Moved),
        3 => Just(Input::Arm),
        1 => Just(Input::Disarm),
        5 => mode.prop_map(Input::SetMode),
        1 => prop::bool::weighted(0.9).prop_map(|valid| Input::Knowledge { valid }),
        1 => prop::bool::weighted(0.9).prop_map(|matches| Input::Hello { matches }),
        1 => Just(Input::FlashWrite),
        2 => any::<bool>().prop_map(|written| Input::FlashDone { written }),
        1 => Just(Input::Unsettled),
    ]
}

/// Mostly a few milliseconds on; sometimes nothing, a leap, or a step back.
fn any_lapse() -> impl Strategy<Value = i64> {
    prop_oneof![
        150 => 0i64..10_000,
        4 => Just(0),
        2 => 0i64..3_000_000,
        1 => -50_000i64..0,
        1 => any::<i32>().prop_map(|far| i64::from(far) * 1_000),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Whatever happens in whatever order at whatever times: motors run only if the oracle
    /// permits it.
    #[test]
    fn motors_never_run_without_permission(
        begin_well in any::<bool>(),
        story in prop::collection::vec((any_lapse(), prop::option::weighted(0.9, any_input())), 1..120),
    ) {
        let mut supervisor = Supervisor::new(Instant(0), ResetReason::PowerOn);
        let mut oracle = Oracle::after_reset(0);
        let mut now = 0u64;
        let start = [
            Input::Hello { matches: true }, Input::Knowledge { valid: true }, Input::Ranges(GOOD),
            Input::Compass(CompassHealth::Good), Input::Heartbeat, Input::Arm,
            Input::SetMode(Mode::Run),
        ];
        let begin = start.iter().filter(|_| begin_well).map(|&input| (0, Some(input)));
        for (lapse, input) in begin.chain(story) {
            now = now.saturating_add_signed(lapse);
            let accepted = match input {
                Some(input) => supervisor.handle(Instant(now), input).is_ok(),
                None => {
                    supervisor.poll(Instant(now));
                    true
                }
            };
            oracle.hear(now, input, accepted);
            let command = WheelCommand::new(400, 400);
            let gated = supervisor.gate(command);
            prop_assert_eq!(gated == command, supervisor.motors_enabled());
            if supervisor.motors_enabled() {
                prop_assert!(matches!(supervisor.state(), State::Driving(_)));
                prop_assert!(oracle.permits(), "{:?}", supervisor);
            } else {
                prop_assert_eq!(gated, WheelCommand::STOP);
            }
        }
    }

    /// Looking at the rules only when they can find something else than before finds the same.
    #[test]
    fn a_supervisor_that_looks_only_when_it_must_sees_all(
        story in prop::collection::vec((any_lapse(), prop::option::weighted(0.9, any_input())), 1..120),
    ) {
        let mut supervisor = Supervisor::new(Instant(0), ResetReason::PowerOn);
        let mut anxious = supervisor.clone();
        let mut now = 0u64;
        for (lapse, input) in story {
            now = now.saturating_add_signed(lapse);
            let answers = [&mut supervisor, &mut anxious].map(|one| match input {
                Some(input) => one.handle(Instant(now), input),
                None => {
                    one.poll(Instant(now));
                    Ok(())
                }
            });
            prop_assert_eq!(answers[0], answers[1]);
            // This one has to look at every rule every time.
            anxious.settled_until = None;
            prop_assert_eq!(supervisor.state(), anxious.state());
            prop_assert_eq!(supervisor.counters(), anxious.counters());
            prop_assert_eq!(supervisor.motors_enabled(), anxious.motors_enabled());
            prop_assert_eq!(supervisor.feed_watchdog(), anxious.feed_watchdog());
        }
    }
}

/// The story of the property test above is worth something only if motors do run in it.
#[test]
fn a_healthy_rover_runs_for_an_hour() {
    let mut bench = Bench::driving(Mode::Run);
    for _ in 0..3_600 {
        bench.run(1_000);
        bench.ok(Input::Moved(Outcome::Completed));
        assert!(bench.supervisor.motors_enabled());
    }
    assert_eq!(bench.supervisor.counters(), &Counters::default());
}
