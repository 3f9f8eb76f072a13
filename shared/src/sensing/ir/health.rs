//! Health of a range sensor's channel: a state machine per channel, driven by its samples.

use super::adc::AdcCount;
use crate::contract::ChannelHealth;
use crate::time::{Duration, Instant};

/// At or below: cable open, or shorted to ground. 40 mV; the sensors give 0.25 V or more at
/// 80 cm, and some 0.1 V with nothing in sight.
pub const OPEN_LIMIT: u16 = 50;
/// At or above: shorted to the supply. 3.2 V; the peak at 6 to 9 cm stays below 3.0 V.
pub const SHORTED_LIMIT: u16 = 3_970;
/// How long samples must stay at a rail before that is a fault: four periods of the sensor, so that
/// one bad measurement (the supply dips as the motors start) is none.
pub const RAIL_TIME: Duration = Duration::from_millis(160);
/// How long the counts may stay the same: ten periods of the sensor. Its noise is several counts,
/// so they change even at rest, unless sensor or converter hangs.
pub const FROZEN_TIME: Duration = Duration::from_millis(400);
/// For how much of that the wheels must have been driven: three periods of the sensor. At rest a
/// hung sensor is not detected; once the rover moves, it is before the rover has come far.
pub const FROZEN_DRIVEN_TIME: Duration = Duration::from_millis(120);
/// How long samples must be plausible before a channel is good.
pub const RECOVERY_TIME: Duration = Duration::from_millis(200);
/// How long samples may be missing: five periods of the sensor.
pub const SILENT_TIME: Duration = Duration::from_millis(200);

/// Monitors one channel.
#[derive(Clone, Debug)]
pub struct ChannelMonitor {
    health: ChannelHealth,
    last: Option<(Instant, AdcCount)>,
    /// Duration of the present run of samples at the lower rail, the upper rail, or neither.
    run: (Look, Duration),
    /// For how long the counts have not changed.
    unchanged: Duration,
    /// For how much of that the wheels were driven.
    driven: Duration,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    Low,
    High,
    Plausible,
}

impl Look {
    const fn of(counts: AdcCount) -> Self {
        match counts.get() {
            ..=OPEN_LIMIT => Self::Low,
            SHORTED_LIMIT.. => Self::High,
            _ => Self::Plausible,
        }
    }
}

impl ChannelMonitor {
    /// A channel without samples.
    pub const fn new() -> Self {
        Self {
            health: ChannelHealth::Unknown,
            last: None,
            run: (Look::Plausible, Duration::ZERO),
            unchanged: Duration::ZERO,
            driven: Duration::ZERO,
        }
    }

    /// Processes a sample; `moving`: whether the wheels were driven since the last one.
    pub fn push(&mut self, now: Instant, counts: AdcCount, moving: bool) -> ChannelHealth {
        let look = Look::of(counts);
        let (elapsed, changed) = match self.last {
            Some((then, before)) if now.since(then) < SILENT_TIME => {
                (now.since(then), before != counts)
            }
            // After a silence, or at the start, the health is unknown.
            _ => {
                self.health = ChannelHealth::Unknown;
                self.run = (look, Duration::ZERO);
                (Duration::ZERO, true)
            }
        };
        self.last = Some((now, counts));
        let lasted = if self.run.0 == look {
            self.run.1.plus(elapsed)
        } else {
            Duration::ZERO
        };
        self.run = (look, lasted);
        if changed {
            self.unchanged = Duration::ZERO;
            self.driven = Duration::ZERO;
        } else {
            self.unchanged = self.unchanged.plus(elapsed);
            if moving {
                self.driven = self.driven.plus(elapsed);
            }
        }
        self.health = self.judge();
        self.health
    }

    fn judge(&self) -> ChannelHealth {
        match self.run {
            (Look::Low, lasted) if lasted >= RAIL_TIME => ChannelHealth::Open,
            (Look::High, lasted) if lasted >= RAIL_TIME => ChannelHealth::Shorted,
            _ if self.unchanged >= FROZEN_TIME && self.driven >= FROZEN_DRIVEN_TIME => {
                ChannelHealth::Frozen
            }
            (Look::Plausible, lasted) if lasted >= RECOVERY_TIME => ChannelHealth::Good,
            _ => self.health,
        }
    }

    /// Returns the health at this time, also when samples have stopped.
    pub fn health(&self, now: Instant) -> ChannelHealth {
        match self.last {
            Some((then, _)) if now.since(then) >= SILENT_TIME => ChannelHealth::Silent,
            _ => self.health,
        }
    }
}

impl Default for ChannelMonitor {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::collection::vec;
    use proptest::prelude::*;

    /// One sensor period in milliseconds, rounded.
    const PERIOD: u32 = 40;

    struct Bench {
        monitor: ChannelMonitor,
        now: Instant,
    }

    impl Bench {
        /// A good channel.
        fn good() -> Self {
            let mut bench = Self {
                monitor: ChannelMonitor::new(),
                now: Instant(0),
            };
            assert_eq!(bench.feed(10, true, |i| 1_000 + i % 2), ChannelHealth::Good);
            bench
        }

        fn feed(&mut self, samples: u16, moving: bool, counts: fn(u16) -> u16) -> ChannelHealth {
            let mut health = self.monitor.health(self.now);
            for i in 0..samples {
                self.now = self.now.after(Duration::from_millis(PERIOD));
                let counts = AdcCount::new(counts(i)).expect("12 bits");
                health = self.monitor.push(self.now, counts, moving);
            }
            health
        }

        /// Milliseconds until the health is this.
        fn time_to(&mut self, wanted: ChannelHealth, counts: fn(u16) -> u16) -> u32 {
            let samples = (1..50).find(|_| self.feed(1, true, counts) == wanted);
            samples.expect("it is found out at all") * PERIOD
        }
    }

    #[test]
    fn a_good_channel_is_believed_only_after_a_while() {
        let mut bench = Bench {
            monitor: ChannelMonitor::new(),
            now: Instant(0),
        };
        assert_eq!(bench.feed(1, false, |_| 1_000), ChannelHealth::Unknown);
        assert_eq!(bench.time_to(ChannelHealth::Good, |_| 1_000), 200);
    }

    #[test]
    fn every_fault_is_found_within_half_a_second() {
        assert!(Bench::good().time_to(ChannelHealth::Open, |_| 3) < 500);
        assert!(Bench::good().time_to(ChannelHealth::Shorted, |_| 4_095) < 500);
        assert!(Bench::good().time_to(ChannelHealth::Frozen, |_| 1_234) < 500);
    }

    #[test]
    fn a_short_dip_or_peak_is_no_fault() {
        let mut bench = Bench::good();
        assert_eq!(bench.feed(4, true, |_| 0), ChannelHealth::Good);
        assert_eq!(bench.feed(1, true, |_| 900), ChannelHealth::Good);
        assert_eq!(bench.feed(4, true, |_| 4_095), ChannelHealth::Good);
    }

    #[test]
    fn a_still_rover_may_see_a_still_world() {
        let mut bench = Bench::good();
        assert_eq!(bench.feed(1_000, false, |_| 1_234), ChannelHealth::Good);
        assert_eq!(bench.feed(2, true, |_| 1_234), ChannelHealth::Good);
        assert_eq!(
            bench.feed(1, true, |_| 1_234),
            ChannelHealth::Frozen,
            "moving it may not"
        );
    }

    #[test]
    fn driven_time_adds_up_over_moves() {
        let mut bench = Bench::good();
        bench.feed(2, true, |_| 1_234);
        assert_eq!(bench.feed(50, false, |_| 1_234), ChannelHealth::Good);
        assert_eq!(bench.feed(2, true, |_| 1_234), ChannelHealth::Frozen);
    }

    #[test]
    fn pauses_between_moves_count_too() {
        let mut bench = Bench::good();
        bench.feed(3, true, |_| 1_234);
        bench.feed(4, false, |_| 1_234);
        assert_eq!(bench.feed(3, true, |_| 1_234), ChannelHealth::Good);
        // Ten periods since the counts last changed.
        assert_eq!(bench.feed(1, true, |_| 1_234), ChannelHealth::Frozen);
    }

    #[test]
    fn one_count_of_change_is_life() {
        let mut bench = Bench::good();
        assert_eq!(
            bench.feed(400, true, |i| 1_234 + u16::from(i % 9 == 0)),
            ChannelHealth::Good
        );
    }

    #[test]
    fn a_fault_heals_after_a_while_of_good_samples() {
        let mut bench = Bench::good();
        bench.feed(10, true, |_| 0);
        assert_eq!(bench.feed(5, true, |i| 900 + i), ChannelHealth::Open);
        assert_eq!(bench.feed(1, true, |_| 950), ChannelHealth::Good);
    }

    #[test]
    fn silence_is_noticed_without_a_sample_and_mistrusted_afterwards() {
        let mut bench = Bench::good();
        let later = bench.now.after(SILENT_TIME);
        assert_eq!(
            bench.monitor.health(bench.now.after(Duration(199_999))),
            ChannelHealth::Good
        );
        assert_eq!(bench.monitor.health(later), ChannelHealth::Silent);
        bench.now = later;
        assert_eq!(bench.feed(1, true, |_| 900), ChannelHealth::Unknown);
    }

    /// The firmware's period of sampling.
    const SAMPLING: Duration = Duration::from_millis(20);

    proptest! {
        /// Whatever moves and pauses are like, and however late the samples: a channel that hangs
        /// is found within half a second, as soon as the wheels are driven for a while.
        #[test]
        fn a_hung_channel_is_found_within_half_a_second(
            stretches in vec((1usize..50, any::<bool>()), 1..12),
            lateness in vec(0u64..3_000, 600),
        ) {
            let mut bench = Bench::good();
            let hung = bench.now;
            let counts = AdcCount::new(1_234).expect("12 bits");
            let moves = stretches.iter().flat_map(|&(n, moving)| core::iter::repeat_n(moving, n));
            let mut driven = Duration::ZERO;
            for ((i, moving), late) in (1..).zip(moves).zip(lateness) {
                let sampled = hung.after(Duration(SAMPLING.0 * i + late));
                let elapsed = sampled.since(bench.now);
                bench.now = sampled;
                let health = bench.monitor.push(sampled, counts, moving);
                // The first of the hung samples may differ from the last good one.
                driven = driven.plus(if moving && i > 1 { elapsed } else { Duration::ZERO });
                let rested = driven < FROZEN_DRIVEN_TIME;
                let frozen = health == ChannelHealth::Frozen;
                prop_assert!(!(frozen && rested));
                let promised = Duration::from_millis(500).minus(SAMPLING);
                prop_assert!(frozen || rested || sampled.since(hung) < promised);
            }
        }

        /// Noise that moves the counts by one now and then is life, moving or not.
        #[test]
        fn a_channel_that_flickers_is_never_frozen(
            changes in vec(1usize..19, 1..60),
            moving in vec(any::<bool>(), 60),
        ) {
            let mut bench = Bench::good();
            for (i, (&samples, &moving)) in changes.iter().zip(&moving).enumerate() {
                let counts = AdcCount::new(1_000 + i as u16 % 2).expect("12 bits");
                for _ in 0..samples {
                    bench.now = bench.now.after(SAMPLING);
                    let health = bench.monitor.push(bench.now, counts, moving);
                    prop_assert_eq!(health, ChannelHealth::Good);
                }
            }
        }
    }
}
