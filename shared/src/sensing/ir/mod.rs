//! Infrared range sensors: from ADC counts to free distances (IV-A: two GP2D12 ahead, one each
//! at 45 degrees to the left and right).
//!
//! An [`IrArray`] turns one set of [`medians`] per sensor period into distance and health of each
//! channel. A reading has two kinds of distance:
//!
//! * the percept's, clipped to the paper's 14 to 64 cm ([`IrReading::ranges`]);
//! * the unclipped one, by which a move is stopped ([`IrReading::clearance`]); there a sensor
//!   that is not good counts as an obstacle at distance 0.
//!
//! **Below 10 cm these sensors fold back**: their output falls again as an obstacle comes
//! closer than the peak (at 6 to 9 cm), so that 4 cm reads like 15. No curve can undo this; the
//! hard-stop distance of [`crate::motion`] therefore lies above the peak, and sensors should be
//! mounted 10 cm behind the bumper's edge where the body allows it.
//!
//! **Wiring the curves hold for**: sensor supplied with 5 V, output straight to the pin (its
//! peak of 2.4 to 2.6 V lies below the ADC's reference of 3.3 V, so there is no divider), 1 kOhm
//! in series to protect the pin, 100 kOhm from the pin to ground so that an open cable reads 0,
//! 10 uF at each sensor's supply. A new value comes every 38 +- 10 ms.

mod adc;
pub mod curve;
pub mod health;

pub use adc::{AdcCount, CHANNELS, medians};

use crate::contract::ChannelHealth;
use crate::time::Instant;
use crate::units::Micrometres;
use curve::RangeCurve;
use health::ChannelMonitor;

/// Index of the front left sensor.
pub const FRONT_LEFT: usize = 0;
/// Index of the front right sensor.
pub const FRONT_RIGHT: usize = 1;
/// Index of the left sensor.
pub const LEFT: usize = 2;
/// Index of the right sensor.
pub const RIGHT: usize = 3;

/// Nearest distance of the percept: below it noise grows (IV-A).
pub const NEAREST: Micrometres = Micrometres::from_cm(14);
/// Farthest distance of the percept (IV-A); ten steps of 5 cm lie between.
pub const FARTHEST: Micrometres = Micrometres::from_cm(64);

/// The front sensors that a board can read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fitted {
    /// Two sensors ahead, as in the paper.
    FrontPair,
    /// One sensor ahead, on the front left channel: boards with three ADC pins (a stock
    /// Raspberry Pi Pico).
    FrontSingle,
}

/// Three free distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ranges {
    /// Ahead: the shorter one of the pair.
    pub front: Micrometres,
    /// On the left.
    pub left: Micrometres,
    /// On the right.
    pub right: Micrometres,
}

/// Distance and health of all channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IrReading {
    /// The counts.
    pub counts: [AdcCount; CHANNELS],
    /// Distance by each channel's curve, unclipped.
    pub distances: [Micrometres; CHANNELS],
    /// The channels' health.
    pub health: [ChannelHealth; CHANNELS],
}

impl IrReading {
    /// The distances for the percept: between [`NEAREST`] and [`FARTHEST`].
    ///
    /// A sensor that is not good reads [`NEAREST`].
    pub fn ranges(&self) -> Ranges {
        let Ranges { front, left, right } = self.clearance();
        let [front, left, right] = [front, left, right].map(|d| d.clamp(NEAREST, FARTHEST));
        Ranges { front, left, right }
    }

    /// The distances to stop by: unclipped, and 0 for a sensor that is not good.
    pub fn clearance(&self) -> Ranges {
        let front = match self.health[FRONT_RIGHT] {
            ChannelHealth::NotFitted => self.distance_if_good(FRONT_LEFT),
            _ => self
                .distance_if_good(FRONT_LEFT)
                .min(self.distance_if_good(FRONT_RIGHT)),
        };
        Ranges {
            front,
            left: self.distance_if_good(LEFT),
            right: self.distance_if_good(RIGHT),
        }
    }

    fn distance_if_good(&self, channel: usize) -> Micrometres {
        match self.health[channel] {
            ChannelHealth::Good => self.distances[channel],
            _ => Micrometres(0),
        }
    }
}

/// All range sensors of a rover.
#[derive(Clone, Debug)]
pub struct IrArray {
    fitted: Fitted,
    curves: [RangeCurve; CHANNELS],
    monitors: [ChannelMonitor; CHANNELS],
}

impl IrArray {
    /// Sensors that all have the same curve, without samples.
    pub const fn new(fitted: Fitted, curve: RangeCurve) -> Self {
        Self {
            fitted,
            curves: [curve; CHANNELS],
            monitors: [const { ChannelMonitor::new() }; CHANNELS],
        }
    }

    /// Replaces one channel's curve. `None` if there is no such channel.
    pub fn calibrate(&mut self, channel: u8, curve: RangeCurve) -> Option<()> {
        *self.curves.get_mut(usize::from(channel))? = curve;
        Some(())
    }

    /// Replaces all curves.
    pub fn set_curves(&mut self, curves: [RangeCurve; CHANNELS]) {
        self.curves = curves;
    }

    /// Processes one set of medians. `moving`: whether the wheels are driven.
    pub fn push(&mut self, now: Instant, counts: [AdcCount; CHANNELS], moving: bool) -> IrReading {
        let distances = core::array::from_fn(|i| self.curves[i].distance(counts[i]));
        let health = core::array::from_fn(|i| {
            if self.has(i) {
                self.monitors[i].push(now, counts[i], moving)
            } else {
                ChannelHealth::NotFitted
            }
        });
        IrReading {
            counts,
            distances,
            health,
        }
    }

    /// Returns the health of all channels, also when samples have stopped.
    pub fn health(&self, now: Instant) -> [ChannelHealth; CHANNELS] {
        core::array::from_fn(|channel| {
            if self.has(channel) {
                self.monitors[channel].health(now)
            } else {
                ChannelHealth::NotFitted
            }
        })
    }

    fn has(&self, channel: usize) -> bool {
        channel != FRONT_RIGHT || self.fitted == Fitted::FrontPair
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Duration;
    use proptest::prelude::*;

    fn counts(raw: [u16; 4]) -> [AdcCount; 4] {
        raw.map(|c| AdcCount::new(c).expect("12 bits"))
    }

    /// Pushes the counts, with one count of noise, long enough for the channels to be good.
    fn settled(array: &mut IrArray, raw: [u16; 4]) -> IrReading {
        let mut now = Instant(0);
        let mut reading = array.push(now, counts(raw), false);
        for i in 0..20 {
            now = now.after(Duration::from_millis(40));
            reading = array.push(now, counts(raw.map(|c| c + i % 2)), false);
        }
        reading
    }

    #[test]
    fn the_nearer_of_the_front_pair_counts() {
        let mut array = IrArray::new(Fitted::FrontPair, RangeCurve::GP2D12);
        let reading = settled(&mut array, [1_000, 1_600, 800, 600]);
        assert_eq!(reading.clearance().front, reading.distances[FRONT_RIGHT]);
        let reading = settled(&mut array, [1_600, 1_000, 800, 600]);
        assert_eq!(reading.clearance().front, reading.distances[FRONT_LEFT]);
    }

    #[test]
    fn a_single_front_sensor_does_not_wait_for_its_twin() {
        let mut array = IrArray::new(Fitted::FrontSingle, RangeCurve::GP2D12);
        let reading = settled(&mut array, [1_000, 0, 800, 600]);
        assert_eq!(reading.health[FRONT_RIGHT], ChannelHealth::NotFitted);
        assert_eq!(reading.clearance().front, reading.distances[FRONT_LEFT]);
        assert_eq!(
            array.health(Instant(800_000))[FRONT_RIGHT],
            ChannelHealth::NotFitted
        );
    }

    #[test]
    fn a_blind_sensor_is_an_obstacle() {
        let mut array = IrArray::new(Fitted::FrontPair, RangeCurve::GP2D12);
        let reading = settled(&mut array, [1_000, 4_090, 800, 600]);
        assert_eq!(reading.health[FRONT_RIGHT], ChannelHealth::Shorted);
        assert_eq!(reading.clearance().front, Micrometres(0));
        assert_eq!(reading.ranges().front, NEAREST);
        let never = IrArray::new(Fitted::FrontPair, RangeCurve::GP2D12).push(
            Instant(0),
            counts([1_000; 4]),
            false,
        );
        assert_eq!(never.clearance().front, Micrometres(0), "nothing known yet");
    }

    #[test]
    fn only_channels_that_exist_are_calibrated() {
        let mut array = IrArray::new(Fitted::FrontPair, RangeCurve::GP2D12);
        assert_eq!(array.calibrate(4, RangeCurve::GP2Y0A21), None);
        assert_eq!(array.calibrate(3, RangeCurve::GP2Y0A21), Some(()));
    }

    proptest! {
        #[test]
        fn the_percept_stays_in_its_range(raw in [0u16..4094, 0u16..4094, 0u16..4094, 0u16..4094]) {
            let mut array = IrArray::new(Fitted::FrontPair, RangeCurve::GP2D12);
            let Ranges { front, left, right } = settled(&mut array, raw).ranges();
            for distance in [front, left, right] {
                prop_assert!((NEAREST..=FARTHEST).contains(&distance));
            }
        }
    }
}
