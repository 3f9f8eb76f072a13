//! The compass module CMPS03: what its registers hold while the vehicle turns.

use super::noise::{Noise, Use};

/// How a compass behaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompassModel {
    /// Milliseconds between two bearings, and for which the field is averaged: two periods of the
    /// mains, of which the module takes out the hum.
    pub period_ms: u32,
    /// Standard deviation of a bearing, in degrees.
    pub noise_deg: f64,
    /// Iron on the vehicle: the largest error, in degrees; it changes with the heading, once in a
    /// turn.
    pub iron_deg: f64,
    /// Where north lies, counter-clockwise from the arena's x axis, in degrees.
    pub north_deg: f64,
}

impl CompassModel {
    /// A calibrated compass: 0.5 degrees of noise, and 2 of the 3 to 4 degrees of error that its
    /// documentation admits. North lies where x grows, so that the headings of a firmware without
    /// a compass offset are those of the arena.
    pub const ROVER: Self = Self {
        period_ms: 40,
        noise_deg: 0.5,
        iron_deg: 2.0,
        north_deg: 0.0,
    };
}

/// What the compass answers on its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompassAnswer {
    /// Registers 0 to 3: version of its software, bearing as a byte, and bearing in tenths of a
    /// degree clockwise from north, high byte first.
    Registers([u8; 4]),
    /// It does not acknowledge its address.
    Silent,
    /// It holds the data line low.
    Stuck,
}

/// What is wrong with the compass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(super) enum Defect {
    #[default]
    None,
    Silent,
    Stuck,
    Garbage,
    Rotated,
}

/// The compass at work.
#[derive(Clone, Debug)]
pub(super) struct Compass {
    model: CompassModel,
    noise: Noise,
    garbage: Noise,
    /// Sum of the headings of this period in radians, and how many they are.
    sum: f64,
    count: u32,
    /// Bearings so far.
    made: u64,
    tenths: u16,
    defect: Defect,
}

/// Tenths of a degree in a turn.
const TURN: u16 = 3_600;
/// Version of the module's software.
const VERSION: u8 = 14;

impl Compass {
    pub(super) fn new(model: CompassModel, seed: u64, heading_rad: f64) -> Self {
        let mut compass = Self {
            model,
            noise: Noise::new(seed, Use::Compass, 0),
            garbage: Noise::new(seed, Use::Garbage, 0),
            sum: 0.0,
            count: 0,
            made: 0,
            tenths: 0,
            defect: Defect::None,
        };
        compass.renew(heading_rad);
        compass
    }

    /// One millisecond at a heading, counter-clockwise, any number of turns.
    pub(super) fn step(&mut self, heading_rad: f64) {
        self.sum += heading_rad;
        self.count += 1;
        if self.count >= self.model.period_ms {
            self.renew(self.sum / f64::from(self.count));
            (self.sum, self.count) = (0.0, 0);
        }
    }

    fn renew(&mut self, heading_rad: f64) {
        let iron = self.model.iron_deg * libm::sin(heading_rad);
        let noise = self.model.noise_deg * self.noise.normal(self.made);
        self.made += 1;
        let bearing = self.model.north_deg - heading_rad.to_degrees() + iron + noise;
        let tenths = (bearing * 10.0).round() as i64;
        self.tenths = tenths.rem_euclid(TURN.into()) as u16;
    }

    pub(super) fn set_defect(&mut self, defect: Defect) {
        self.defect = defect;
    }

    /// Tenths of a degree, clockwise from north.
    pub(super) fn tenths(&self) -> u16 {
        let turned = match self.defect {
            Defect::Rotated => TURN / 4,
            _ => 0,
        };
        (self.tenths + turned) % TURN
    }

    pub(super) fn answer(&self) -> CompassAnswer {
        match self.defect {
            Defect::Silent => CompassAnswer::Silent,
            Defect::Stuck => CompassAnswer::Stuck,
            Defect::Garbage => {
                let [a, b, c, d, ..] = self.garbage.bits(self.made).to_le_bytes();
                CompassAnswer::Registers([a, b, c, d])
            }
            Defect::None | Defect::Rotated => {
                let tenths = self.tenths();
                let [high, low] = tenths.to_be_bytes();
                let byte = u32::from(tenths) * 256 / u32::from(TURN);
                CompassAnswer::Registers([VERSION, byte as u8, high, low])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rover_shared::sensing::compass::Bearing;

    use super::*;

    const EXACT: CompassModel = CompassModel {
        noise_deg: 0.0,
        iron_deg: 0.0,
        ..CompassModel::ROVER
    };

    fn decoded(compass: &Compass) -> Option<Bearing> {
        match compass.answer() {
            CompassAnswer::Registers([_, byte, high, low]) => Bearing::decode([byte, high, low]),
            CompassAnswer::Silent | CompassAnswer::Stuck => None,
        }
    }

    #[test]
    fn headings_come_out_of_the_firmwares_decoder_as_they_are() {
        for degrees in [-179, -90, -1, 0, 1, 90, 180] {
            let heading = f64::from(degrees).to_radians();
            let compass = Compass::new(EXACT, 1, heading);
            let bearing = decoded(&compass).expect("its registers agree");
            assert_eq!(bearing.counter_clockwise().0, degrees * 1_000_000);
        }
    }

    #[test]
    fn a_bearing_is_the_mean_of_its_period_and_holds_for_the_next() {
        let mut compass = Compass::new(EXACT, 1, 0.0);
        for ms in 1..=40 {
            assert_eq!(compass.tenths(), 0);
            compass.step(f64::from(-ms).to_radians());
        }
        // The mean of 1 to 40 degrees.
        assert_eq!(compass.tenths(), 205);
    }

    #[test]
    fn iron_and_noise_err_by_what_they_are_said_to() {
        let mut compass = Compass::new(CompassModel::ROVER, 5, 0.0);
        let mut errors = Vec::new();
        for degrees in 0..360 {
            (0..40).for_each(|_| compass.step(f64::from(-degrees).to_radians()));
            let error = f64::from(compass.tenths()) / 10.0 - f64::from(degrees);
            errors.push((error + 540.0).rem_euclid(360.0) - 180.0);
        }
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / 360.0;
        assert!(
            (1.9..2.7).contains(&variance),
            "2^2 / 2 + 0.5^2 is {variance}"
        );
        assert!(errors.iter().all(|e| e.abs() < 4.0));
    }

    #[test]
    fn defects_are_what_they_are_called() {
        let mut compass = Compass::new(EXACT, 1, 0.0);
        compass.set_defect(Defect::Rotated);
        assert_eq!(decoded(&compass).map(Bearing::tenths), Some(900));
        compass.set_defect(Defect::Silent);
        assert_eq!(compass.answer(), CompassAnswer::Silent);
        compass.set_defect(Defect::Stuck);
        assert_eq!(compass.answer(), CompassAnswer::Stuck);
        compass.set_defect(Defect::Garbage);
        let believed = (0..1_000)
            .filter(|_| {
                (0..40).for_each(|_| compass.step(0.0));
                decoded(&compass).is_some()
            })
            .count();
        assert!(believed < 20, "{believed} of 1000 look like bearings");
    }

    proptest! {
        #[test]
        fn its_registers_always_agree(heading in -100.0..100.0f64, seed: u64) {
            let compass = Compass::new(CompassModel::ROVER, seed, heading);
            prop_assert_eq!(decoded(&compass).map(Bearing::tenths), Some(compass.tenths()));
        }
    }
}
