//! The compass: Devantech CMPS03 or one of its successors CMPS11, CMPS12, CMPS14, at I2C address
//! [`ADDRESS`], which all keep the registers
//!
//! | register | holds |
//! |---|---|
//! | 1 | bearing, 0 to 255 for a full circle |
//! | 2, 3 | bearing in tenths of a degree, 0 to 3599, high byte first |
//!
//! Bearings grow clockwise from north. Everywhere else angles are counter-clockwise; they are
//! converted here only.
//!
//! A bearing is accepted if the two registers agree and the rover can have turned to it since the
//! last one. A bearing that is wrong but steady (motors and mains magnetise rooms) is not detected.

use crate::contract::CompassHealth;
use crate::math;
use crate::time::{Duration, Instant};
use crate::units::Microdegrees;

/// I2C address, 7 bits (0xC0 in the data sheet's 8-bit way of writing).
pub const ADDRESS: u8 = 0x60;
/// First register of the block that is read.
pub const FIRST_REGISTER: u8 = 1;
/// Bytes of the block.
pub const BLOCK: usize = 3;

/// How often to read the compass. It renews its bearing every 20 to 50 ms by type.
pub const PERIOD: Duration = Duration::from_millis(20);
/// Without an accepted bearing for this long there is no heading: moves must stop within 100 ms,
/// which leaves 20 ms to react.
pub const TIMEOUT: Duration = Duration::from_millis(80);
/// Fastest turn that is accepted, in degrees a second: a rover this size spins at 180 at most.
const FASTEST_TURN: u64 = 360;
/// Deviation that is always accepted: magnetic noise of motors starting, and the two readings'
/// quantisation.
const NOISE: Microdegrees = Microdegrees::from_degrees(10);
/// Consecutive bearings that must agree before a jump is accepted: the rover was turned by hand
/// while the bus was silent.
const CONFIRMATIONS: u8 = 5;
/// Bearings averaged: enough to halve their noise, and 20 ms late on average.
const AVERAGED: usize = 3;

/// How long one read may take: six bytes at 100 kHz and a compass that stretches the clock need
/// 1 ms.
pub const READ_TIMEOUT: Duration = Duration::from_millis(5);
/// How often a bus is retried that keeps hanging.
const RETRY_PERIOD: Duration = Duration::from_millis(200);

/// When to use the bus: less often while it hangs, because each attempt costs its time-out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Retry {
    hung: bool,
    not_before: Instant,
}

impl Retry {
    /// A bus that has not been used.
    pub const fn new() -> Self {
        Self {
            hung: false,
            not_before: Instant(0),
        }
    }

    /// Whether to try a read now.
    pub fn due(&self, now: Instant) -> bool {
        now >= self.not_before
    }

    /// The bus answered, even if only with a missing acknowledgement.
    pub fn answered(&mut self) {
        self.hung = false;
    }

    /// The bus hung and was freed: it is retried at once, then every 200 ms.
    pub fn hung(&mut self, now: Instant) {
        let wait = if self.hung {
            RETRY_PERIOD
        } else {
            Duration::ZERO
        };
        self.hung = true;
        self.not_before = now.after(wait);
    }
}

/// A bearing as read from the compass: tenths of a degree, clockwise from north, 0 to 3599.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bearing(u16);

impl Bearing {
    /// Tenths of a degree in a turn.
    const TURN: u16 = 3600;
    /// How far the two registers may differ, in 256ths of a turn: one by rounding, one because
    /// the compass may renew them between the two.
    const BYTE_TOLERANCE: u8 = 2;

    /// Reads registers 1 to 3; `None` if the word is out of range or the byte disagrees with it.
    ///
    /// A floating bus reads 255 and 65535, which is out of range.
    pub fn decode([byte, high, low]: [u8; BLOCK]) -> Option<Self> {
        let tenths = u16::from_be_bytes([high, low]);
        if tenths >= Self::TURN {
            return None;
        }
        let expected = (u32::from(tenths) * 256 / u32::from(Self::TURN)) as u8;
        let difference = byte.wrapping_sub(expected).cast_signed().unsigned_abs();
        (difference <= Self::BYTE_TOLERANCE).then_some(Self(tenths))
    }

    /// Tenths of a degree, clockwise from north.
    pub const fn tenths(self) -> u16 {
        self.0
    }

    /// The same direction, counter-clockwise from north.
    pub const fn counter_clockwise(self) -> Microdegrees {
        Microdegrees::wrapped(-(self.0 as i64) * (Microdegrees::PER_DEGREE as i64 / 10))
    }
}

/// Checks and averages bearings.
#[derive(Clone, Debug)]
pub struct Compass {
    /// Added to every heading, for the compass's mounting and the frame's zero.
    offset: Microdegrees,
    /// When the bus last answered, rightly or not.
    answered: Option<Instant>,
    /// The last bearing whose registers agreed.
    decoded: Option<(Instant, Microdegrees)>,
    /// How many of those in a row agreed with the one before.
    agreeing: u8,
    /// When a bearing was last accepted.
    accepted: Option<Instant>,
    /// The last `count` accepted ones, newest first.
    window: [Microdegrees; AVERAGED],
    count: usize,
}

impl Compass {
    /// A compass mounted with this offset, without readings.
    pub const fn new(offset: Microdegrees) -> Self {
        Self {
            offset,
            answered: None,
            decoded: None,
            agreeing: 0,
            accepted: None,
            window: [Microdegrees(0); AVERAGED],
            count: 0,
        }
    }

    /// Changes the offset, with immediate effect.
    pub fn set_offset(&mut self, offset: Microdegrees) {
        self.offset = offset;
    }

    /// Processes the answer to a read of [`BLOCK`] bytes from [`FIRST_REGISTER`]. Not to be called
    /// when the bus did not answer.
    pub fn push(&mut self, now: Instant, block: [u8; BLOCK]) {
        self.answered = Some(now);
        let Some(bearing) = Bearing::decode(block) else {
            return;
        };
        let heading = bearing.counter_clockwise();
        let consistent = self
            .decoded
            .is_some_and(|(then, before)| reachable(before, heading, now.since(then)));
        self.decoded = Some((now, heading));
        self.agreeing = if consistent {
            self.agreeing.saturating_add(1)
        } else {
            0
        };
        let known = self.fresh(now).zip(self.window.first());
        let continues = known.is_some_and(|(age, &last)| reachable(last, heading, age));
        if continues {
            self.window.rotate_right(1);
            self.count = AVERAGED.min(self.count + 1);
        } else if self.agreeing >= CONFIRMATIONS {
            self.count = 1;
        } else {
            return;
        }
        self.window[0] = heading;
        self.accepted = Some(now);
    }

    /// Returns the heading, counter-clockwise; `None` unless a bearing was accepted within
    /// [`TIMEOUT`].
    pub fn heading(&self, now: Instant) -> Option<Microdegrees> {
        self.fresh(now)?;
        let mean = circular_mean(self.window.get(..self.count)?)?;
        Some(mean.turned(self.offset))
    }

    /// Returns the compass's health at this time.
    pub fn health(&self, now: Instant) -> CompassHealth {
        if self.fresh(now).is_some() {
            return CompassHealth::Good;
        }
        match self.answered {
            Some(then) if now.since(then) >= TIMEOUT => CompassHealth::Silent,
            Some(_) if self.agreeing < CONFIRMATIONS && self.accepted.is_none() => {
                CompassHealth::Unknown
            }
            Some(_) => CompassHealth::Implausible,
            None => CompassHealth::Unknown,
        }
    }

    /// Age of the last accepted bearing, if below [`TIMEOUT`].
    fn fresh(&self, now: Instant) -> Option<Duration> {
        self.accepted
            .map(|then| now.since(then))
            .filter(|age| *age < TIMEOUT)
    }
}

/// Whether the rover can have turned this far in this time.
fn reachable(from: Microdegrees, to: Microdegrees, within: Duration) -> bool {
    // Degrees a second are microdegrees a microsecond. No turn is longer than half a circle.
    let allowed = within
        .0
        .saturating_mul(FASTEST_TURN)
        .saturating_add(NOISE.0 as u64);
    u64::from(to.turn_from(from).0.unsigned_abs()) <= allowed
}

/// The direction of the sum of unit vectors in these directions, the newest first; `None` if
/// there is none.
///
/// The vectors are turned so that the newest lies at 0, and the result is turned back: then
/// micromath's arc tangent, short by 6 % of a small angle and never off by more than 0.17
/// degrees ([`math`]), errs by 6 % of the little by which the mean differs from the newest, and
/// not at all when the rover stands still. The compass itself errs by 3 to 4 degrees.
fn circular_mean(headings: &[Microdegrees]) -> Option<Microdegrees> {
    /// Radians in a microdegree.
    const RADIAN: f32 = core::f32::consts::PI / 180e6;
    let newest = *headings.first()?;
    let (mut x, mut y) = (0.0, 0.0);
    for heading in headings {
        let angle = heading.turn_from(newest).0 as f32 * RADIAN;
        x += math::cos(angle);
        y += math::sin(angle);
    }
    let mean = Microdegrees((math::atan2(y, x) / RADIAN) as i32);
    Some(newest.turned(mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn block(tenths: u16) -> [u8; 3] {
        let [high, low] = tenths.to_be_bytes();
        [(u32::from(tenths) * 256 / 3600) as u8, high, low]
    }

    struct Bench {
        compass: Compass,
        now: Instant,
    }

    impl Bench {
        fn new() -> Self {
            Self {
                compass: Compass::new(Microdegrees(0)),
                now: Instant(0),
            }
        }

        fn at(tenths: u16) -> Self {
            let mut bench = Self::new();
            bench.feed(10, tenths);
            assert_eq!(bench.health(), CompassHealth::Good);
            bench
        }

        fn feed(&mut self, samples: u32, tenths: u16) {
            self.feed_raw(samples, block(tenths));
        }

        fn feed_raw(&mut self, samples: u32, block: [u8; 3]) {
            for _ in 0..samples {
                self.now = self.now.after(PERIOD);
                self.compass.push(self.now, block);
            }
        }

        fn health(&self) -> CompassHealth {
            self.compass.health(self.now)
        }

        fn heading(&self) -> Option<i32> {
            self.compass.heading(self.now).map(|h| h.0)
        }
    }

    #[test]
    fn a_bus_that_hangs_is_tried_at_once_and_then_less_often() {
        let mut retry = Retry::new();
        let at = |ms: u64| Instant(1_000 * ms);
        retry.hung(at(100));
        assert!(retry.due(at(100)));
        retry.hung(at(105));
        assert!(!retry.due(at(304)) && retry.due(at(305)));
        retry.answered();
        retry.hung(at(310));
        assert!(retry.due(at(310)));
    }

    #[test]
    fn bearings_become_counter_clockwise_headings() {
        let heading = |tenths| {
            Bearing::decode(block(tenths))
                .unwrap()
                .counter_clockwise()
                .0
        };
        assert_eq!(
            [
                heading(0),
                heading(900),
                heading(1_800),
                heading(2_700),
                heading(3_599)
            ],
            [0, -90_000_000, 180_000_000, 90_000_000, 100_000]
        );
    }

    #[test]
    fn registers_that_disagree_are_refused() {
        assert!(Bearing::decode([255, 255, 255]).is_none(), "a floating bus");
        assert!(Bearing::decode([0, 0x0e, 0x10]).is_none(), "3600 tenths");
        assert!(Bearing::decode([128, 0, 0]).is_none());
        assert!(Bearing::decode([3, 0, 0]).is_none());
        assert!(Bearing::decode([2, 0, 0]).is_some());
        assert!(
            Bearing::decode([255, 0, 0]).is_some(),
            "just renewed over north"
        );
        assert!(Bearing::decode([0, 0x0e, 0x0f]).is_some());
    }

    #[test]
    fn it_takes_some_agreement_to_be_believed() {
        let mut bench = Bench::new();
        assert_eq!(bench.health(), CompassHealth::Unknown);
        bench.feed(5, 450);
        assert_eq!(
            (bench.health(), bench.heading()),
            (CompassHealth::Unknown, None)
        );
        bench.feed(1, 450);
        assert_eq!(
            (bench.health(), bench.heading()),
            (CompassHealth::Good, Some(-45_000_000))
        );
    }

    #[test]
    fn silence_ends_the_heading_in_time() {
        let bench = Bench::at(450);
        let health = |ms| {
            bench
                .compass
                .health(bench.now.after(Duration::from_millis(ms)))
        };
        assert_eq!(
            (health(79), health(80)),
            (CompassHealth::Good, CompassHealth::Silent)
        );
        assert_eq!(bench.compass.heading(bench.now.after(TIMEOUT)), None);
    }

    #[test]
    fn nonsense_ends_the_heading_in_time() {
        let mut bench = Bench::at(450);
        bench.feed_raw(3, [255; 3]);
        assert_eq!(bench.health(), CompassHealth::Good);
        bench.feed_raw(1, [255; 3]);
        assert_eq!(
            (bench.health(), bench.heading()),
            (CompassHealth::Implausible, None)
        );
    }

    #[test]
    fn a_spike_is_not_believed_and_does_no_harm() {
        let mut bench = Bench::at(450);
        bench.feed(1, 2_250);
        assert_eq!(bench.heading(), Some(-45_000_000));
        bench.feed(1, 450);
        assert_eq!(bench.heading(), Some(-45_000_000));
    }

    #[test]
    fn a_jump_ends_the_heading_until_it_proves_lasting() {
        let mut bench = Bench::at(450);
        bench.feed(4, 2_250);
        assert_eq!(bench.health(), CompassHealth::Implausible);
        bench.feed(1, 2_250);
        assert_eq!(bench.heading(), None);
        bench.feed(1, 2_250);
        assert_eq!(bench.heading(), Some(135_000_000));
    }

    #[test]
    fn jitter_between_two_directions_is_never_believed() {
        let mut bench = Bench::new();
        for i in 0..100 {
            bench.feed(1, if i % 2 == 0 { 450 } else { 2_250 });
            assert_eq!(bench.heading(), None);
        }
    }

    #[test]
    fn the_offset_is_added() {
        let mut bench = Bench::at(450);
        bench.compass.set_offset(Microdegrees::from_degrees(-170));
        assert_eq!(bench.heading(), Some(145_000_000));
    }

    #[test]
    fn a_steady_turn_is_followed_across_north() {
        let mut bench = Bench::at(3_500);
        for i in 0..30u16 {
            bench.feed(1, (3_500 + 12 * i) % 3_600); // 60 degrees a second
        }
        let lag = Microdegrees(bench.heading().unwrap())
            .turn_from(Bearing((3_500 + 12 * 29) % 3_600).counter_clockwise());
        assert!(
            (1_000_000..1_300_000).contains(&lag.0),
            "one period behind: {lag:?}"
        );
    }

    proptest! {
        #[test]
        fn the_mean_lies_among_its_headings(
            newest in -180_000_000i32..=180_000_000,
            others in prop::collection::vec(-20_000_000i32..=20_000_000, 0..3),
        ) {
            let newest = Microdegrees(newest);
            let mut headings = std::vec![newest];
            headings.extend(others.iter().map(|&d| newest.turned(Microdegrees(d))));
            let sum: i64 = others.iter().map(|&d| i64::from(d)).sum();
            let exact = sum as f64 / headings.len() as f64;
            let mean = circular_mean(&headings).unwrap().turn_from(newest).0;
            // 6 % by the arc tangent, and the little that the mean of vectors differs from that
            // of angles.
            prop_assert!((f64::from(mean) - exact).abs() < 0.08 * exact.abs() + 150_000.0, "{mean} {exact}");
        }

        #[test]
        fn no_answers_panic(blocks in prop::collection::vec((any::<[u8; 3]>(), any::<u64>()), 0..50)) {
            let mut compass = Compass::new(Microdegrees(0));
            for (block, time) in blocks {
                compass.push(Instant(time), block);
                let health = compass.health(Instant(time));
                prop_assert_eq!(compass.heading(Instant(time)).is_some(), health == CompassHealth::Good);
            }
        }
    }
}
