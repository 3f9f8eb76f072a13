//! Trigonometry in `f32` with the same bits on the board and on the host.
//!
//! The functions are micromath's, always called by their full path: `x.sin()` would mean std's
//! `sin` in any build that links std, and another one on the board. micromath uses nothing but
//! IEEE additions, multiplications, divisions and bit patterns, which both sides round alike.
//!
//! Measured over a whole turn in steps of 0.01 degrees (the tests below hold the bounds): sine
//! and cosine are within 0.0011 of the exact value, the arc tangent within 0.0029 rad (0.17
//! degrees); for small angles it is short by 6 % of the angle. That is far below the error of a
//! magnetic compass in a room (3 to 4 degrees) and too coarse for learning: only the compass's mean
//! uses this module.

use micromath::F32Ext;

/// The sine of an angle in radians, within 0.0011 for angles of up to a turn.
pub fn sin(radians: f32) -> f32 {
    F32Ext::sin(radians)
}

/// The cosine of an angle in radians, within 0.0011 for angles of up to a turn.
pub fn cos(radians: f32) -> f32 {
    F32Ext::cos(radians)
}

/// The angle of the vector (x, y) in radians, in [-pi, pi], within 0.0029; 0 for the zero vector.
pub fn atan2(y: f32, x: f32) -> f32 {
    // micromath returns NaN there.
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    F32Ext::atan2(y, x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn() -> impl Iterator<Item = f64> {
        (-18_000..=18_000).map(|i| f64::from(i) * core::f64::consts::PI / 18_000.0)
    }

    #[test]
    fn the_documented_errors_hold() {
        let worst = |error: &dyn Fn(f64) -> f64| turn().map(error).fold(0.0, f64::max);
        let sine = worst(&|a| (f64::from(sin(a as f32)) - f64::sin(a)).abs());
        let cosine = worst(&|a| (f64::from(cos(a as f32)) - f64::cos(a)).abs());
        let tangent = worst(&|a| {
            let found = f64::from(atan2(f64::sin(a) as f32, f64::cos(a) as f32));
            let error = (found - a).abs();
            error.min(2.0 * core::f64::consts::PI - error)
        });
        assert!(sine < 0.0011, "sine {sine}");
        assert!(cosine < 0.0011, "cosine {cosine}");
        assert!(tangent < 0.0029, "arc tangent {tangent}");
    }

    #[test]
    fn the_arc_tangent_never_overshoots_a_small_angle() {
        for degrees in 1..=10 {
            let angle = f64::from(degrees).to_radians();
            let found = f64::from(atan2(f64::sin(angle) as f32, f64::cos(angle) as f32));
            assert!(
                (0.93..=1.0).contains(&(found / angle)),
                "{degrees} degrees: {found}"
            );
        }
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }

    /// The exact bits, so that a change of micromath or of the target's arithmetic shows.
    #[test]
    fn the_bits_are_pinned() {
        let bits = [sin(0.3), cos(0.3), atan2(0.1, 0.9)].map(f32::to_bits);
        assert_eq!(bits, [0x3e96_d813, 0x3f74_a34d, 0x3ddc_d88f]);
    }
}
