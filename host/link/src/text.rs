//! Quantities as text, and text from outside made safe for a terminal.

use rover_shared::perception::PatternCode;
use rover_shared::units::{Microdegrees, Micrometres};

/// Text that a terminal takes for text, whatever was in it: control characters are shown as `?`.
pub fn printable(text: &str, ascii: bool) -> String {
    let strange = |c: char| c.is_control() || (ascii && !c.is_ascii());
    text.chars()
        .map(|c| if strange(c) { '?' } else { c })
        .collect()
}

/// A pattern as four lines of four cells, of which those at -1 look like `off`, those at +1 like `on`.
pub fn pattern(code: PatternCode, [off, on]: [&str; 2]) -> [String; PatternCode::SIDE] {
    let mut lines: [String; PatternCode::SIDE] = Default::default();
    for (line, row) in lines.iter_mut().zip(code.rows()) {
        *line = row.map(|cell| if cell { on } else { off }).concat();
    }
    lines
}

/// A turn, with its side.
pub fn turn(turn: Microdegrees) -> String {
    // Whole tenths, so that no turn of 0.0 has a side.
    let tenths = (f64::from(turn.0) / 1e5).round();
    let side = match tenths {
        ..0.0 => " right",
        0.0 => "",
        _ => " left",
    };
    format!("{:.1} deg{side}", (tenths / 10.0).abs())
}

/// A compass direction as it is typed: degrees clockwise, -360 to 360.
///
/// # Errors
/// What is expected.
pub fn parse_compass(text: &str) -> Result<Microdegrees, String> {
    let degrees = text.parse().ok();
    let degrees = degrees
        .filter(|degrees: &f64| (-360.0..=360.0).contains(degrees))
        .ok_or("expected degrees clockwise, -360 to 360")?;
    Ok(Microdegrees::wrapped(-(degrees * 1e6).round() as i64))
}

/// A direction as a compass shows it: clockwise, 0 to 359.9 degrees.
pub fn compass(direction: Microdegrees) -> String {
    // Whole tenths, so that nothing is rounded up to 360.0.
    let tenths = (-i64::from(direction.0) + 50_000).div_euclid(100_000);
    let tenths = tenths.rem_euclid(3_600);
    format!("{}.{} deg", tenths / 10, tenths % 10)
}

/// A distance in centimetres.
pub fn centimetres(distance: Micrometres) -> String {
    format!("{:.1}", f64::from(distance.0) / 1e4)
}

/// A time since the board's reset: minutes and seconds, or hours before them.
pub fn clock(microseconds: u64) -> String {
    let tenths = microseconds / 100_000;
    let (minutes, tenths) = (tenths / 600, tenths % 600);
    let seconds = format!("{:02}.{}", tenths / 10, tenths % 10);
    match minutes / 60 {
        0 => format!("{minutes}:{seconds}"),
        hours => format!("{hours}:{:02}:{seconds}", minutes % 60),
    }
}

/// A count in at most `width` characters: thousands and millions are shortened, never cut.
pub fn count(count: u32, width: usize) -> String {
    let shortened = [
        (1u32, ""),
        (1_000, "k"),
        (1_000_000, "M"),
        (1_000_000_000, "G"),
    ];
    let texts = shortened.map(|(unit, letter)| format!("{}{letter}", count / unit));
    let fitting = texts.iter().find(|text| text.len() <= width);
    fitting.unwrap_or(&texts[3]).clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_a_compasss() {
        let of = |degrees: f64| compass(Microdegrees((degrees * 1e6) as i32));
        assert_eq!(
            [
                of(0.0),
                of(15.0),
                of(-15.0),
                of(180.0),
                of(0.01),
                of(-359.96)
            ],
            [
                "0.0 deg",
                "345.0 deg",
                "15.0 deg",
                "180.0 deg",
                "0.0 deg",
                "0.0 deg"
            ]
        );
        compass(Microdegrees(i32::MIN));
    }

    #[test]
    fn directions_are_typed_as_they_are_shown() {
        assert_eq!(parse_compass("90"), Ok(Microdegrees(-90_000_000)));
        assert_eq!(parse_compass("270"), Ok(Microdegrees(90_000_000)));
        for degrees in ["0.0", "90.0", "180.0", "359.9"] {
            let shown = parse_compass(degrees).map(compass);
            assert_eq!(shown, Ok(format!("{degrees} deg")));
        }
        for wrong in ["", "-", "361", "-361", "1e9", "inf", "NaN", "north"] {
            assert!(parse_compass(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_papers_pattern_is_drawn_from_the_upper_left() {
        // 12703 = 0x319F: rows F, 9, 1, 3 with the lowest bit on the left.
        let lines = pattern(PatternCode(12_703), [".", "#"]);
        assert_eq!(lines, ["####", "#..#", "#...", "##.."]);
    }

    #[test]
    fn turns_name_their_side() {
        assert_eq!(turn(Microdegrees(9_230_000)), "9.2 deg left");
        assert_eq!(turn(Microdegrees(-8_100_000)), "8.1 deg right");
        assert_eq!(turn(Microdegrees(-49_999)), "0.0 deg");
        turn(Microdegrees(i32::MIN));
    }

    #[test]
    fn counts_are_shortened_and_never_cut() {
        assert_eq!(count(999, 3), "999");
        assert_eq!(count(12_345, 4), "12k");
        assert_eq!(count(u32::MAX, 3), "4G");
        assert_eq!(count(u32::MAX, 10), "4294967295");
    }

    #[test]
    fn nothing_that_was_said_steers_the_terminal() {
        assert_eq!(printable("a\x1b[2Jb\u{9b}\n", false), "a?[2Jb??");
        assert_eq!(printable("caf\u{e9}", true), "caf?");
    }

    #[test]
    fn times_are_minutes_and_seconds() {
        assert_eq!(clock(754_500_000), "12:34.5");
        assert_eq!(clock(3_600_000_000), "1:00:00.0");
        clock(u64::MAX);
    }
}
