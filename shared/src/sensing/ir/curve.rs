//! The characteristic of a range sensor: distance over counts, by calibration points.
//!
//! A triangulating sensor's voltage is nearly a straight line over the **reciprocal** distance
//! (Sharp's data sheets draw it so), so this is the variable in which the points are joined by
//! straight lines: two points 10 cm apart then err by some millimetres between them, where lines
//! over the distance itself would err by up to half a centimetre at the near end.

use super::adc::AdcCount;
use crate::contract::{CURVE_POINTS, CurvePoint};
use crate::units::Micrometres;

/// Reciprocals are kept as this over micrometres, which fills 32 bits at the shortest distance
/// and resolves 0.02 cm at 80 cm.
const RECIPROCAL: u32 = 4_000_000_000;
/// Shortest and longest distance of a curve.
const SHORTEST: Micrometres = Micrometres::from_cm(1);
const LONGEST: Micrometres = Micrometres::from_cm(600);

/// The characteristic of a range sensor: counts rising, distances falling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RangeCurve {
    points: [CurvePoint; CURVE_POINTS],
    used: usize,
}

/// Why calibration points do not make a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveError {
    /// Fewer than two points, or more than [`CURVE_POINTS`].
    Number,
    /// Counts above 4095, or a distance outside 1 cm to 6 m.
    Range,
    /// Counts do not rise, or distances do not fall, from point to point.
    NotFalling,
}

impl RangeCurve {
    /// Sharp GP2D12: output over distance read off the data sheet's typical curve (white paper,
    /// 5 V), at the ADC's 3.3 V = 4096 counts without a divider.
    ///
    /// Single sensors differ from it by some 10 %, as their data sheet allows (0.25 to 0.55 V at
    /// 80 cm): good enough to drive, better calibrated.
    pub const GP2D12: Self = Self::of_millivolts([
        (400, 80),
        (460, 70),
        (530, 60),
        (620, 50),
        (760, 40),
        (980, 30),
        (1_150, 25),
        (1_380, 20),
        (1_760, 15),
        (2_380, 10),
    ]);

    /// Sharp GP2Y0A21YK0F, the GP2D12's successor: read off its data sheet's typical curve in
    /// the same way.
    pub const GP2Y0A21: Self = Self::of_millivolts([
        (400, 80),
        (450, 70),
        (520, 60),
        (610, 50),
        (740, 40),
        (930, 30),
        (1_080, 25),
        (1_300, 20),
        (1_650, 15),
        (2_300, 10),
    ]);

    const fn of_millivolts<const N: usize>(table: [(u32, u32); N]) -> Self {
        let mut points = [CurvePoint {
            counts: 0,
            distance: Micrometres(0),
        }; N];
        let mut i = 0;
        while i < N {
            let (millivolts, cm) = table[i];
            points[i] = CurvePoint {
                counts: (millivolts * 4096 / 3300) as u16,
                distance: Micrometres::from_cm(cm),
            };
            i += 1;
        }
        match Self::new(&points) {
            Ok(curve) => curve,
            Err(_) => panic!("a built-in curve is wrong: the build fails"),
        }
    }

    /// A curve through these points, in the order of rising counts.
    ///
    /// # Errors
    /// See [`CurveError`].
    pub const fn new(points: &[CurvePoint]) -> Result<Self, CurveError> {
        if points.len() < 2 || points.len() > CURVE_POINTS {
            return Err(CurveError::Number);
        }
        let mut curve = Self {
            points: [points[0]; CURVE_POINTS],
            used: points.len(),
        };
        let mut i = 0;
        while i < points.len() {
            let CurvePoint { counts, distance } = points[i];
            if counts > AdcCount::MAX || distance.0 < SHORTEST.0 || distance.0 > LONGEST.0 {
                return Err(CurveError::Range);
            }
            if i > 0 && (counts <= points[i - 1].counts || distance.0 >= points[i - 1].distance.0) {
                return Err(CurveError::NotFalling);
            }
            curve.points[i] = points[i];
            i += 1;
        }
        Ok(curve)
    }

    /// The points, counts rising.
    pub fn points(&self) -> &[CurvePoint] {
        &self.points[..self.used]
    }

    /// Returns the distance for these counts, beyond either end that of the end. It never grows
    /// with the counts.
    pub fn distance(&self, counts: AdcCount) -> Micrometres {
        let counts = counts.get();
        let points = self.points();
        let above = points
            .iter()
            .position(|p| p.counts >= counts)
            .unwrap_or(points.len());
        let (far, near) = match (above.checked_sub(1).map(|i| points[i]), points.get(above)) {
            (Some(far), Some(near)) if near.counts > counts => (far, near),
            // At a point, or before the first one.
            (_, Some(near)) => return near.distance,
            (_, None) => return points[points.len() - 1].distance,
        };
        let (from, to) = (RECIPROCAL / far.distance.0, RECIPROCAL / near.distance.0);
        let along = u32::from(counts - far.counts);
        let whole = u32::from(near.counts - far.counts);
        // At most 400,000 * 4095, which fits.
        let reciprocal = from + (to - from) * along / whole;
        Micrometres((RECIPROCAL / reciprocal).clamp(near.distance.0, far.distance.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn points(table: &[(u16, u32)]) -> Vec<CurvePoint> {
        table
            .iter()
            .map(|&(counts, cm)| CurvePoint {
                counts,
                distance: Micrometres::from_cm(cm),
            })
            .collect()
    }

    fn cm(curve: &RangeCurve, counts: u16) -> f64 {
        f64::from(curve.distance(AdcCount::new(counts).unwrap()).0) / 10_000.0
    }

    #[test]
    fn the_points_are_met_exactly() {
        for curve in [RangeCurve::GP2D12, RangeCurve::GP2Y0A21] {
            for point in curve.points() {
                assert_eq!(
                    curve.distance(AdcCount::new(point.counts).unwrap()),
                    point.distance
                );
            }
        }
    }

    /// The sensor's own law, V = a / (d + 4) + b, which joins the points better than any table.
    #[test]
    fn between_the_points_the_sensors_law_is_followed() {
        for tenths in 100..=800 {
            let distance = f64::from(tenths) / 10.0;
            let volts = (6787.0 / (distance + 4.0) + 3.0) * 5.0 / 1024.0;
            let found = cm(&RangeCurve::GP2D12, (volts * 4096.0 / 3.3) as u16);
            let error = (found / distance - 1.0).abs();
            assert!(error < 0.03, "{distance} cm reads {found}");
        }
    }

    #[test]
    fn beyond_the_ends_the_end_is_given() {
        assert_eq!(cm(&RangeCurve::GP2D12, 0), 80.0);
        assert_eq!(cm(&RangeCurve::GP2D12, 4_095), 10.0);
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        let refused = |table: &[(u16, u32)]| RangeCurve::new(&points(table)).unwrap_err();
        assert_eq!(refused(&[(500, 80)]), CurveError::Number);
        assert_eq!(refused(&[(1, 99); CURVE_POINTS + 1]), CurveError::Number);
        assert_eq!(refused(&[(500, 80), (4_096, 10)]), CurveError::Range);
        assert_eq!(refused(&[(500, 80), (600, 0)]), CurveError::Range);
        assert_eq!(refused(&[(500, 601), (600, 10)]), CurveError::Range);
        assert_eq!(refused(&[(500, 80), (500, 10)]), CurveError::NotFalling);
        assert_eq!(refused(&[(500, 80), (600, 80)]), CurveError::NotFalling);
    }

    proptest! {
        #[test]
        fn more_counts_are_never_farther(
            mut counts in prop::collection::btree_set(0u16..=4_095, 2..=CURVE_POINTS),
            distances in prop::collection::btree_set(10_000u32..=6_000_000, CURVE_POINTS),
        ) {
            let table: Vec<_> = counts.iter().zip(distances.iter().rev())
                .map(|(&counts, &d)| CurvePoint { counts, distance: Micrometres(d) }).collect();
            let curve = RangeCurve::new(&table).unwrap();
            let mut last = u32::MAX;
            counts.extend(0..=4_095);
            for count in counts {
                let distance = curve.distance(AdcCount::new(count).unwrap()).0;
                prop_assert!(distance <= last);
                last = distance;
            }
        }
    }
}
