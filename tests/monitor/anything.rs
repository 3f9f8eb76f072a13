//! Whatever could be heard, the impossible included.

use proptest::prelude::*;
use proptest::sample::select;
use rover_cli::monitor::{Connection, FeedEvent, Origin, Playback};
use rover_link::Counters as FrameCounters;
use rover_shared::action::Action;
use rover_shared::contract::*;
use rover_shared::controller::{Familiarity, Learned, Perceived, Sensed, StepRecord};
use rover_shared::learning::StaircaseChange;
use rover_shared::perception::{Corners, PatternCode, SettleTime};
use rover_shared::reward::Reward;
use rover_shared::sensing::neuron::StepIndex;
use rover_shared::sensing::{Percept, Sample, Scaled, Stimulus};
use rover_shared::time::Instant;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::*;

fn health() -> impl Strategy<Value = ChannelHealth> {
    use ChannelHealth::*;
    select(vec![
        Unknown, Good, Open, Shorted, Frozen, Silent, NotFitted,
    ])
}

fn compass() -> impl Strategy<Value = CompassHealth> {
    use CompassHealth::*;
    select(vec![Unknown, Good, Silent, Implausible])
}

fn fault() -> impl Strategy<Value = Fault> {
    select(Fault::ALL.to_vec())
}

fn mode() -> impl Strategy<Value = Mode> {
    select(vec![Mode::Idle, Mode::Learn, Mode::Run, Mode::Host])
}

fn state() -> impl Strategy<Value = State> {
    prop_oneof![
        Just(State::Disarmed),
        Just(State::Armed),
        mode().prop_map(State::Driving),
        fault().prop_map(State::Faulted),
    ]
}

fn task() -> impl Strategy<Value = Task> {
    use Task::*;
    select(vec![FollowDirection, FollowChangingDirection, AimAtTarget])
}

fn outcome() -> impl Strategy<Value = Outcome> {
    use Outcome::*;
    select(vec![
        Completed,
        Obstacle,
        NoProgress,
        TurnTimeout,
        CompassLost,
        Late,
        Stopped,
    ])
}

fn angle() -> impl Strategy<Value = Microdegrees> {
    any::<i32>().prop_map(Microdegrees)
}

fn distance() -> impl Strategy<Value = Micrometres> {
    any::<u32>().prop_map(Micrometres)
}

fn time() -> impl Strategy<Value = Instant> {
    any::<u64>().prop_map(Instant)
}

fn counters() -> impl Strategy<Value = Counters> {
    prop_oneof![Just([0; 20]), any::<[u32; 20]>()].prop_map(Counters)
}

/// Few codes, so that patterns occur again.
fn code() -> impl Strategy<Value = PatternCode> {
    (0u16..5).prop_map(|i| PatternCode(i * 13_107))
}

fn sample() -> impl Strategy<Value = Sample> {
    (distance(), distance(), distance(), angle()).prop_map(|(front, left, right, heading)| Sample {
        front,
        left,
        right,
        heading,
        target_bearing: None,
    })
}

fn sensed() -> impl Strategy<Value = Sensed> {
    // Rewards are bounded by 2000 in all.
    let reward = prop::array::uniform4(-500_000_000..=500_000_000);
    (angle(), any::<[i32; 4]>(), reward).prop_map(|(target_angle, percept, reward)| Sensed {
        target_angle,
        percept: Percept(percept.map(|p| Scaled::saturating(p.into()))),
        reward: Reward(reward),
    })
}

fn learned() -> impl Strategy<Value = Learned> {
    let change =
        (0usize..4, 0u32..10, any::<i32>()).prop_map(|(of, step, amount)| StaircaseChange {
            stimulus: Stimulus::ALL[of],
            step: StepIndex::saturating(step),
            amount,
        });
    (code(), any::<i32>(), angle(), prop::option::of(change)).prop_map(
        |(code, reward_difference, phase, staircase)| Learned {
            code,
            reward_difference,
            phase,
            staircase,
        },
    )
}

fn perceived() -> impl Strategy<Value = Perceived> {
    let familiarity = prop_oneof![
        Just(Familiarity::Known),
        Just(Familiarity::New),
        code().prop_map(Familiarity::Replaced),
    ];
    (any::<[i32; 4]>(), code(), familiarity).prop_map(|(corners, code, familiarity)| Perceived {
        corners: Corners(corners),
        code,
        settle_time: SettleTime(0),
        familiarity,
    })
}

fn step() -> impl Strategy<Value = StepRecord> {
    let number = prop_oneof![0u32..20, any::<u32>()];
    let (sensed, learned) = (prop::option::of(sensed()), prop::option::of(learned()));
    let action = (angle(), distance()).prop_map(|(phase, module)| Action { phase, module });
    (
        number,
        sensed,
        learned,
        prop::option::of(perceived()),
        action,
    )
        .prop_map(|(step, sensed, learned, perceived, action)| StepRecord {
            step,
            sensed,
            learned,
            perceived,
            action,
        })
}

fn action() -> impl Strategy<Value = ActionRecord> {
    let sensors = (
        any::<[u16; 4]>(),
        prop::array::uniform4(health()),
        compass(),
        sample(),
    );
    (time(), sensors, step(), outcome(), counters()).prop_map(
        |(time, (counts, ranges, compass, sample), step, outcome, counters)| ActionRecord {
            time,
            counts,
            ranges,
            compass,
            sample,
            step,
            outcome,
            counters,
        },
    )
}

fn status() -> impl Strategy<Value = Status> {
    let sensors = (
        any::<[u16; 4]>(),
        prop::array::uniform4(distance()),
        prop::option::of(angle()),
        prop::array::uniform4(health()),
        compass(),
    );
    let doing = (state(), any::<bool>(), task(), angle(), any::<u32>());
    (time(), doing, sensors, counters()).prop_map(|(time, doing, sensors, counters)| {
        let (state, motors_enabled, task, direction, steps) = doing;
        let (counts, distances, heading, ranges, compass) = sensors;
        Status {
            time,
            state,
            motors_enabled,
            task,
            direction,
            steps,
            counts,
            distances,
            heading,
            ranges,
            compass,
            counters,
        }
    })
}

fn event() -> impl Strategy<Value = Event> {
    let kind = prop_oneof![
        state().prop_map(EventKind::State),
        outcome().prop_map(EventKind::MoveEnded),
        angle().prop_map(EventKind::Direction),
        any::<u32>().prop_map(|fingerprint| EventKind::KnowledgeStored { fingerprint }),
        (any::<u8>(), health()).prop_map(|(channel, health)| EventKind::Range { channel, health }),
        compass().prop_map(EventKind::Compass),
        (mode(), any::<u64>(), any::<u32>()).prop_map(|(mode, seed, knowledge)| {
            EventKind::Session {
                mode,
                seed,
                knowledge,
            }
        }),
    ];
    (time(), kind).prop_map(|(time, kind)| Event { time, kind })
}

fn text<const N: usize>() -> impl Strategy<Value = heapless::String<N>> {
    any::<String>().prop_map(|text| {
        let mut cut = heapless::String::new();
        for c in text.chars() {
            if cut.push(c).is_err() {
                break;
            }
        }
        cut
    })
}

fn report() -> impl Strategy<Value = Report> {
    let hello = (text(), text(), any::<u64>(), any::<Option<u32>>()).prop_map(
        |(board, firmware, seed, knowledge)| Hello {
            schema: 0,
            board,
            firmware,
            reset: ResetReason::Watchdog,
            seed,
            knowledge,
        },
    );
    let fault = (time(), fault(), any::<u32>()).prop_map(|(time, fault, count)| FaultReport {
        time,
        fault,
        count,
    });
    prop_oneof![
        hello.prop_map(Report::Hello),
        status().prop_map(Report::Status),
        action().prop_map(Report::Action),
        event().prop_map(Report::Event),
        fault.prop_map(Report::Fault),
        text().prop_map(Report::LastWords),
    ]
}

fn refusal() -> impl Strategy<Value = Refusal> {
    prop_oneof![
        fault().prop_map(Refusal::Fault),
        compass().prop_map(Refusal::Compass),
        (any::<u8>(), health())
            .prop_map(|(channel, health)| Refusal::RangeSensor { channel, health }),
        Just(Refusal::NotArmed),
    ]
}

fn connection() -> impl Strategy<Value = Connection> {
    prop_oneof![
        Just(Connection::None),
        any::<String>().prop_map(Connection::Searching),
        any::<String>().prop_map(Connection::Open),
        any::<String>().prop_map(Connection::Lost),
        any::<String>().prop_map(Connection::Log),
    ]
}

/// Anything.
pub fn feed_event() -> impl Strategy<Value = FeedEvent> {
    let answer = prop::result::maybe_ok(Just(()), refusal()).prop_map(|result| {
        let command = Command::Arm;
        FeedEvent::Answer { command, result }
    });
    // Knowledge of the rover's, and what is none.
    let begin = any::<bool>().prop_map(|valid| {
        let parameters = rover_shared::parameters::Parameters::ROVER;
        let known = rover_simulator::experiment::Known::default();
        FeedEvent::Begin(Some(Origin {
            seed: 1,
            knowledge: if valid {
                rover_log::knowledge::to_bytes(&known, &parameters)
            } else {
                vec![1, 2, 3]
            },
        }))
    });
    let playback = (any::<bool>(), any::<f64>(), any::<usize>(), any::<usize>()).prop_map(
        |(playing, speed, at, of)| {
            FeedEvent::Playback(Playback {
                playing,
                speed,
                at,
                of,
                cut_off: playing,
            })
        },
    );
    let frames = any::<[u64; 5]>().prop_map(|[received, lost, damaged, unread, reconnected]| {
        FeedEvent::Frames(FrameCounters {
            received,
            lost,
            damaged,
            unread,
            reconnected,
        })
    });
    prop_oneof![
        20 => report().prop_map(FeedEvent::report),
        2 => connection().prop_map(FeedEvent::Connection),
        2 => answer,
        1 => begin,
        1 => any::<String>().prop_map(FeedEvent::Gap),
        1 => playback,
        1 => frames,
    ]
}
