//! Measures of how well a robot does, with their uncertainty.

use serde::Serialize;

/// The normal distribution's 97.5th percentile: intervals are 95 % intervals.
const Z: f64 = 1.959_964;

/// A measured value with its 95 % confidence interval. A mean of one value says nothing about how
/// far it scatters: its interval is infinite, `null` in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// A share of successes, with the Wilson score interval, which stays inside [0, 1] and is right
/// even when all or none succeed. `None` if nothing was tried.
pub fn proportion(successes: usize, trials: usize) -> Option<Estimate> {
    if trials == 0 {
        return None;
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let centre = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt() / (1.0 + Z * Z / n);
    // Rounding may leave the value a hair outside its own interval at 0 and 1.
    Some(Estimate {
        value: p,
        low: (centre - half).clamp(0.0, p),
        high: (centre + half).clamp(p, 1.0),
    })
}

/// A mean, with the interval of the normal approximation. `None` of no values.
pub fn mean(values: &[f64]) -> Option<Estimate> {
    if values.is_empty() {
        return None;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    let half = if values.len() < 2 {
        f64::INFINITY
    } else {
        Z * (squares / (n - 1.0) / n).sqrt()
    };
    Some(Estimate {
        value: mean,
        low: mean - half,
        high: mean + half,
    })
}

/// Directedness, (7) and (8): the length of the mean of the directions of all moves, 1 for a
/// straight line, near 0 for wandering. Steps on which the robot did not move have no direction
/// and do not count. `None` if it never moved.
///
/// (The paper's (8) has the number of moves under the root, which would exceed 1; it belongs
/// outside.)
pub fn directedness(path_cm: &[[f64; 2]]) -> Option<f64> {
    let mut moves = 0u32;
    let mut sum = [0.0, 0.0];
    for step in path_cm.windows(2) {
        let (dx, dy) = (step[1][0] - step[0][0], step[1][1] - step[0][1]);
        let length = libm::hypot(dx, dy);
        if length > 0.0 {
            moves += 1;
            sum[0] += dx / length;
            sum[1] += dy / length;
        }
    }
    (moves > 0).then(|| libm::hypot(sum[0], sum[1]) / f64::from(moves))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_is_fully_directed_and_a_closed_square_not_at_all() {
        let line: Vec<_> = (0..10).map(|i| [f64::from(i), f64::from(2 * i)]).collect();
        assert!((directedness(&line).unwrap() - 1.0).abs() < 1e-12);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert!(directedness(&square).unwrap() < 1e-12);
        assert_eq!(directedness(&[[1.0, 1.0], [1.0, 1.0]]), None);
    }

    #[test]
    fn steps_that_go_nowhere_do_not_count() {
        let path = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        assert_eq!(directedness(&path), Some(1.0));
    }

    #[test]
    fn wilson_intervals_are_those_of_the_literature() {
        // Newcombe (1998), table I: 81 of 263 gives 0.2553 to 0.3662, 0 of 20 gives 0 to 0.1611.
        let e = proportion(81, 263).unwrap();
        assert!(
            (e.low - 0.2553).abs() < 1e-4 && (e.high - 0.3662).abs() < 1e-4,
            "{e:?}"
        );
        let none = proportion(0, 20).unwrap();
        assert!(
            none.low == 0.0 && (none.high - 0.1611).abs() < 1e-4,
            "{none:?}"
        );
        assert_eq!(proportion(0, 0), None);
    }
}
