//! Values on the command line that have units.

use std::path::PathBuf;

use rover_shared::motion::LONGEST_ADVANCE;
use rover_shared::time::Duration;
use rover_shared::units::{Microdegrees, Micrometres};

pub use rover_link::text::parse_compass as compass;

/// A span of time: `90s`, `10m`, `1h`, `500ms`.
pub fn duration(text: &str) -> Result<Duration, String> {
    let units = [("ms", 1e3), ("s", 1e6), ("m", 60e6), ("h", 3_600e6)];
    let micros = with_unit(text, &units).ok_or("expected a time as in 90s, 10m or 1h")?;
    Ok(Duration(micros as u64))
}

/// A number of bytes: `500kB`, `64MB`, `1GB`.
pub fn size(text: &str) -> Result<u64, String> {
    let units = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9)];
    let bytes = with_unit(text, &units).ok_or("expected a size as in 500kB, 64MB or 1GB")?;
    if bytes < 1e5 {
        return Err("expected at least 100kB: a file's beginning alone takes half of that".into());
    }
    Ok(bytes as u64)
}

/// A turn: degrees, 0 to 180.
pub fn turn(text: &str) -> Result<Microdegrees, String> {
    let degrees = finite(text)
        .filter(|d| (0.0..=180.0).contains(d))
        .ok_or("expected degrees, 0 to 180")?;
    Ok(Microdegrees((degrees * 1e6).round() as i32))
}

/// A distance in cm, above 0, at most 1000.
pub fn centimetres(text: &str) -> Result<Micrometres, String> {
    let cm = finite(text)
        .filter(|cm| *cm > 0.0 && *cm <= 1_000.0)
        .ok_or("expected centimetres, above 0 and at most 1000")?;
    Ok(Micrometres(
        (cm * f64::from(Micrometres::PER_CM)).round() as u32
    ))
}

/// The length of a move, in cm.
pub fn advance(text: &str) -> Result<Micrometres, String> {
    let longest = LONGEST_ADVANCE.0 / Micrometres::PER_CM;
    centimetres(text)
        .ok()
        .filter(|length| *length <= LONGEST_ADVANCE)
        .ok_or(format!(
            "expected centimetres, above 0 and at most {longest}"
        ))
}

/// The path of a log to write.
pub fn log_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("mcap") => Ok(path),
        _ => Err("expected a name that ends in .mcap".into()),
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, unit) = text.split_at(text.find(|c: char| c.is_ascii_alphabetic())?);
    let (_, factor) = units.iter().find(|(name, _)| *name == unit)?;
    let value = finite(number.trim())? * factor;
    (0.0..1e16).contains(&value).then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_need_their_units() {
        assert_eq!(duration("1.5m"), Ok(Duration(90_000_000)));
        assert_eq!(duration("20 ms"), Ok(Duration(20_000)));
        assert_eq!(size("64MB"), Ok(64_000_000));
        for bad in ["", "10", "m", "-1s", "1d", "infs", "1e30h", "NaNs"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
        assert!(size("1kB").is_err());
    }

    #[test]
    fn moves_have_limits() {
        assert_eq!(centimetres("7.5"), Ok(Micrometres(75_000)));
        assert!(centimetres("0").is_err() && turn("-1").is_err());
    }
}
