//! Sharp's triangulating range sensors GP2D12 and GP2Y0A21: volts over distance, and when they
//! change.

use rover_shared::sensing::ir::AdcCount;
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::units::Micrometres;

use super::noise::{Noise, Use};

/// A make of sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorType {
    /// Sharp GP2D12, the paper's
    Gp2d12,
    /// Sharp GP2Y0A21YK0F, its successor
    Gp2y0a21,
}

/// A point of the characteristic.
#[derive(Clone, Copy, Debug)]
struct Knot {
    cm: f64,
    volts: f64,
}

/// The typical output over distance.
///
/// From 10 to 80 cm it is the inverse of the firmware's [`RangeCurve`] of this type: joined by
/// straight lines over the reciprocal distance. Nearer, the output folds back: the spot of light
/// leaves the detector; these points are estimates by the typical curves of the data sheets, which
/// are drawn but not specified there. Farther, the law goes on until too little light comes back.
#[derive(Clone, Debug)]
pub struct Characteristic(Vec<Knot>);

/// What stands for the ADC's reference of 3.3 V.
const VOLTS_PER_COUNT: f64 = 3.3 / 4096.0;
/// Nothing is seen beyond.
const FARTHEST_CM: f64 = 130.0;

impl SensorType {
    /// The curve that the firmware has for it.
    pub const fn curve(self) -> RangeCurve {
        match self {
            Self::Gp2d12 => RangeCurve::GP2D12,
            Self::Gp2y0a21 => RangeCurve::GP2Y0A21,
        }
    }

    /// Output below 10 cm.
    const fn near(self) -> [Knot; 4] {
        const fn knot(cm: f64, volts: f64) -> Knot {
            Knot { cm, volts }
        }
        match self {
            Self::Gp2d12 => [
                knot(0.0, 0.30),
                knot(4.0, 1.75),
                knot(7.0, 2.55),
                knot(8.5, 2.52),
            ],
            Self::Gp2y0a21 => [
                knot(0.0, 0.30),
                knot(4.0, 1.90),
                knot(6.5, 2.95),
                knot(8.0, 2.72),
            ],
        }
    }
}

impl Characteristic {
    /// The typical one of a type.
    pub fn of(sensor: SensorType) -> Self {
        let curve = sensor.curve();
        let mut knots = sensor.near().to_vec();
        let points = curve.points().iter().rev();
        knots.extend(points.map(|point| Knot {
            cm: f64::from(point.distance.0) / f64::from(Micrometres::PER_CM),
            volts: f64::from(point.counts) * VOLTS_PER_COUNT,
        }));
        if let [.., before, last] = knots[..] {
            let slope = (last.volts - before.volts) / (1.0 / last.cm - 1.0 / before.cm);
            let volts = last.volts + slope * (1.0 / FARTHEST_CM - 1.0 / last.cm);
            knots.push(Knot {
                cm: FARTHEST_CM,
                volts,
            });
        }
        Self(knots)
    }

    /// The output at a distance of 0 or more.
    pub fn volts(&self, cm: f64) -> f64 {
        let above = self.0.partition_point(|knot| knot.cm <= cm);
        match (
            above.checked_sub(1).and_then(|i| self.0.get(i)),
            self.0.get(above),
        ) {
            (Some(near), Some(far)) if near.cm < 10.0 => {
                near.volts + (far.volts - near.volts) * (cm - near.cm) / (far.cm - near.cm)
            }
            (Some(near), Some(far)) => {
                let along = (1.0 / cm - 1.0 / near.cm) / (1.0 / far.cm - 1.0 / near.cm);
                near.volts + (far.volts - near.volts) * along
            }
            (Some(end), None) | (None, Some(end)) => end.volts,
            (None, None) => 0.0,
        }
    }

    /// The distance at which the output is highest: below it, it folds back.
    pub fn peak_cm(&self) -> f64 {
        let highest = self.0.iter().max_by(|a, b| a.volts.total_cmp(&b.volts));
        highest.map_or(0.0, |knot| knot.cm)
    }
}

/// How the sensors of a vehicle behave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorModel {
    /// Their make.
    pub kind: SensorType,
    /// Standard deviation of the sensors' gains around 1.
    pub gain_spread: f64,
    /// Standard deviation of the sensors' offsets, in volts.
    pub offset_spread_volts: f64,
    /// Standard deviation of what one measurement errs by, in volts.
    pub noise_volts: f64,
    /// Standard deviation of the ripple that each conversion of the ADC meets, in counts.
    pub ripple_counts: f64,
}

impl SensorModel {
    /// Sensors that the firmware's curve fits to a few per cent. A measurement errs by 6 mV, which
    /// is 1 mm at 15 cm and 1 cm at 60.
    pub const ROVER: Self = Self {
        kind: SensorType::Gp2d12,
        gain_spread: 0.015,
        offset_spread_volts: 0.010,
        noise_volts: 0.006,
        ripple_counts: 2.0,
    };
}

/// What is wrong with a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) enum Defect {
    #[default]
    None,
    Open,
    Shorted,
    Frozen,
    Noisy,
}

/// Of a noisy sensor's measurement, in volts.
const NOISY_VOLTS: f64 = 0.5;
/// Microseconds that a measurement takes, and by how much sensors and measurements may differ
/// from it. The data sheet allows 38.3 +- 9.6 ms; most of it is between sensors.
const PERIOD_US: f64 = 38_300.0;
const PERIOD_SPREAD_US: f64 = 6_000.0;
const JITTER_US: f64 = 3_600.0;

/// One sensor at work.
#[derive(Clone, Debug)]
pub(super) struct Infrared {
    gain: f64,
    offset: f64,
    model: SensorModel,
    period_us: f64,
    noise: Noise,
    jitter: Noise,
    ripple: Noise,
    /// When the measurement that is under way ends, in microseconds.
    due_us: u64,
    /// Measurements so far.
    measured: u64,
    /// Typical output where the measurement under way began.
    began: f64,
    /// Output.
    volts: f64,
    defect: Defect,
    /// Counts that do not change any more.
    frozen: u16,
}

impl Infrared {
    /// Sensor number `channel`. `volts`: the typical output where it stands.
    pub(super) fn new(model: SensorModel, channel: usize, seed: u64, volts: f64) -> Self {
        let spread = Noise::new(seed, Use::SensorSpread, channel);
        let jitter = Noise::new(seed, Use::SensorPeriod, channel);
        let period_us = PERIOD_US + PERIOD_SPREAD_US * spread.uniform(2);
        let mut sensor = Self {
            gain: 1.0 + model.gain_spread * spread.normal(0),
            offset: model.offset_spread_volts * spread.normal(1),
            model,
            period_us,
            noise: Noise::new(seed, Use::SensorNoise, channel),
            jitter,
            ripple: Noise::new(seed, Use::Ripple, channel),
            // A phase of its own.
            due_us: (period_us * (0.5 + 0.5 * spread.uniform(3))) as u64,
            measured: 0,
            began: volts,
            volts: 0.0,
            defect: Defect::None,
            frozen: 0,
        };
        sensor.put_out(volts);
        sensor
    }

    /// Whether a measurement has ended by this time.
    pub(super) fn due(&self, now_us: u64) -> bool {
        now_us >= self.due_us
    }

    /// Ends a measurement. `volts`: the typical output where the sensor is now. The sensor gathers
    /// light for all of its period, so that it sees what lies between begin and end of it.
    pub(super) fn measure(&mut self, volts: f64) {
        self.put_out((self.began + volts) / 2.0);
        self.began = volts;
        let period = self.period_us + JITTER_US * self.jitter.uniform(self.measured);
        self.due_us += period as u64;
        self.measured += 1;
    }

    fn put_out(&mut self, typical: f64) {
        let noise = match self.defect {
            Defect::Noisy => NOISY_VOLTS,
            _ => self.model.noise_volts,
        };
        let error = noise * self.noise.normal(self.measured);
        self.volts = (typical * self.gain + self.offset + error).max(0.0);
    }

    pub(super) fn set_defect(&mut self, defect: Defect, now_us: u64) {
        if defect == Defect::Frozen && self.defect != Defect::Frozen {
            self.frozen = self.counts(now_us, 0);
        }
        self.defect = defect;
    }

    /// The result of the `n`-th conversion at this time.
    pub(super) fn counts(&self, now_us: u64, n: u32) -> u16 {
        let moment = now_us << 8 | u64::from(n & 0xff);
        let ripple = self.model.ripple_counts * self.ripple.normal(moment);
        let volts = match self.defect {
            Defect::Frozen => return self.frozen,
            // The resistor to ground.
            Defect::Open => 0.0,
            // The sensor's supply.
            Defect::Shorted => 5.0,
            Defect::None | Defect::Noisy => self.volts,
        };
        // `as` saturates at 0.
        ((volts / VOLTS_PER_COUNT + ripple + 0.5) as u16).min(AdcCount::MAX)
    }

    /// The voltage on the pin, without ripple, between 0 and the supply of the board, 3.3 V.
    pub(super) fn pin_volts(&self) -> f64 {
        match self.defect {
            Defect::Open => 0.0,
            Defect::Shorted => 3.3,
            Defect::Frozen => f64::from(self.frozen) * VOLTS_PER_COUNT,
            Defect::None | Defect::Noisy => self.volts.min(3.3),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TYPES: [SensorType; 2] = [SensorType::Gp2d12, SensorType::Gp2y0a21];

    #[test]
    fn beyond_ten_centimetres_the_firmwares_curve_gives_the_distance_back() {
        for kind in TYPES {
            let characteristic = Characteristic::of(kind);
            for millimetres in 100..=800 {
                let cm = f64::from(millimetres) / 10.0;
                let counts = (characteristic.volts(cm) / VOLTS_PER_COUNT).round() as u16;
                let found = kind
                    .curve()
                    .distance(AdcCount::new(counts).expect("12 bits"));
                let found = f64::from(found.0) / 1e4;
                // Half a count is 1 mm at 30 cm and 5 mm at 80.
                assert!((found / cm - 1.0).abs() < 0.008, "{cm} cm reads {found}");
            }
        }
    }

    #[test]
    fn below_the_peak_it_folds_back() {
        let characteristic = Characteristic::of(SensorType::Gp2d12);
        assert!((6.0..9.0).contains(&characteristic.peak_cm()));
        // "4 cm reads like 15", says the firmware.
        let alike = characteristic.volts(4.0) - characteristic.volts(15.0);
        assert!(alike.abs() < 0.05, "{alike} V apart");
        assert!(characteristic.volts(7.0) < 2.6);
    }

    #[test]
    fn a_sensor_renews_its_output_as_its_data_sheet_says() {
        for channel in 0..4 {
            let mut sensor = Infrared::new(SensorModel::ROVER, channel, 7, 1.0);
            let mut ends = Vec::new();
            for now in (0..20_000_000).step_by(1_000) {
                if sensor.due(now) {
                    sensor.measure(1.0);
                    ends.push(sensor.due_us);
                }
            }
            let allowed = 28_700..=47_900;
            assert!(ends.windows(2).all(|w| allowed.contains(&(w[1] - w[0]))));
        }
    }

    #[test]
    fn output_lags_by_the_light_of_the_whole_period() {
        let quiet = SensorModel {
            gain_spread: 0.0,
            offset_spread_volts: 0.0,
            noise_volts: 0.0,
            ripple_counts: 0.0,
            ..SensorModel::ROVER
        };
        let mut sensor = Infrared::new(quiet, 0, 1, 1.0);
        sensor.measure(2.0);
        assert_eq!(sensor.pin_volts(), 1.5);
        sensor.measure(2.0);
        assert_eq!(sensor.pin_volts(), 2.0);
        assert_eq!(sensor.counts(5, 0), 2482);
    }

    #[test]
    fn defects_look_as_the_firmware_expects_them() {
        let mut sensor = Infrared::new(SensorModel::ROVER, 2, 1, 1.0);
        let counts = |sensor: &Infrared| -> Vec<u16> {
            (0..50).map(|i| sensor.counts(1_000 * i, 0)).collect()
        };
        let changes = |counts: &[u16]| counts.windows(2).filter(|w| w[0] != w[1]).count();
        assert!(changes(&counts(&sensor)) > 30, "noise of several counts");
        sensor.set_defect(Defect::Frozen, 9);
        sensor.measure(2.0);
        assert_eq!(changes(&counts(&sensor)), 0);
        sensor.set_defect(Defect::Open, 9);
        assert!(counts(&sensor).iter().all(|&c| c < 10));
        sensor.set_defect(Defect::Shorted, 9);
        assert!(counts(&sensor).iter().all(|&c| c == 4_095));
        sensor.set_defect(Defect::Noisy, 9);
        let noisy: Vec<f64> = (0..200)
            .map(|_| {
                sensor.measure(1.0);
                sensor.pin_volts()
            })
            .collect();
        let spread = noisy.iter().map(|v| (v - 1.0).abs()).sum::<f64>() / 200.0;
        assert!((0.25..0.6).contains(&spread), "{spread} V");
        sensor.set_defect(Defect::None, 9);
        sensor.measure(1.0);
        assert!((sensor.pin_volts() - 1.0).abs() < 0.15);
    }

    proptest! {
        #[test]
        fn beyond_the_peak_farther_is_never_more(
            kind in prop::sample::select(&TYPES[..]), near in 0.0..200.0f64, more in 0.0..200.0f64
        ) {
            let characteristic = Characteristic::of(kind);
            let near = characteristic.peak_cm() + near;
            prop_assert!(characteristic.volts(near + more) <= characteristic.volts(near));
        }

        #[test]
        fn below_the_peak_nearer_is_never_more(
            kind in prop::sample::select(&TYPES[..]), one in 0.0..1.0f64, two in 0.0..1.0f64
        ) {
            let characteristic = Characteristic::of(kind);
            let [near, far] = [one.min(two), one.max(two)].map(|x| x * characteristic.peak_cm());
            prop_assert!(characteristic.volts(near) <= characteristic.volts(far));
        }

        #[test]
        fn output_stays_between_ground_and_what_no_rail_is_mistaken_for(
            kind in prop::sample::select(&TYPES[..]), cm in 0.0..1_000.0f64
        ) {
            let volts = Characteristic::of(kind).volts(cm);
            prop_assert!((0.2..3.0).contains(&volts));
        }
    }
}
