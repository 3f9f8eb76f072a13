//! What results look like as text.

use std::fmt::Write as _;

use rover_link::text;
use rover_shared::perception::{PatternCode, SettleTime};
use rover_simulator::experiment::{Estimate, ExamResult, Known, Trial, mean};

/// How learning went, over trials in groups that grow, because most is learned at the start: the
/// share of targets reached, collisions, actions and directedness; or, where a direction was
/// followed, collisions and the angle to it with nothing in sight.
pub fn learning_curve(trials: &[Trial], follow_direction: bool) -> String {
    let mut text = String::from(if follow_direction {
        "  trials  collisions  actions  angle to the direction, free (deg)\n"
    } else {
        "  trials   reached  collisions  actions  directedness\n"
    });
    let mut from = 0;
    for size in [1, 4, 5, 10, 30, 50]
        .into_iter()
        .chain(std::iter::repeat(100))
    {
        let group = &trials[from..(from + size).min(trials.len())];
        if group.is_empty() {
            break;
        }
        let to = from + group.len();
        let span = if group.len() == 1 {
            to.to_string()
        } else {
            format!("{}-{to}", from + 1)
        };
        let average = |of: fn(&Trial) -> Option<f64>| {
            mean(&group.iter().filter_map(of).collect::<Vec<_>>()).map_or(f64::NAN, |m| m.value)
        };
        let collisions = average(|t| Some(f64::from(t.collisions)));
        let actions = average(|t| Some(f64::from(t.steps)));
        let _ = if follow_direction {
            let angle = average(|t| t.free_angle_deg);
            writeln!(
                text,
                "{span:>8} {collisions:>11.2} {actions:>8.0} {angle:>12.1}"
            )
        } else {
            let reached = 100.0 * average(|t| Some(f64::from(u8::from(t.reached()))));
            let directedness = average(|t| t.directedness);
            writeln!(
                text,
                "{span:>8} {reached:>8.0}% {collisions:>11.2} {actions:>8.0} {directedness:>13.2}"
            )
        };
        from = to;
    }
    text
}

/// The patterns used most, drawn side by side, each with its code, use and action.
pub fn patterns(known: &Known, count: usize) -> String {
    let mut elements: Vec<_> = known.patterns.elements().iter().collect();
    elements.sort_by_key(|element| std::cmp::Reverse(element.occurrences));
    elements.truncate(count);
    if elements.is_empty() {
        return "no patterns yet\n".into();
    }
    let mut lines = vec![String::new(); 7];
    for element in elements {
        for (line, row) in lines.iter_mut().zip(drawing(element.code)) {
            let _ = write!(line, "  {row:<14}");
        }
        let degrees = f64::from(element.memory.phase.0) / 1e6;
        let side = if degrees >= 0.0 { "left" } else { "right" };
        let _ = write!(lines[4], "  {:<14}", format!("code {}", element.code.0));
        let _ = write!(
            lines[5],
            "  {:<14}",
            format!("{} times", element.occurrences)
        );
        let _ = write!(
            lines[6],
            "  {:<14}",
            format!("{:.1} deg {side}", degrees.abs())
        );
    }
    lines
        .into_iter()
        .map(|line| line.trim_end().to_owned() + "\n")
        .collect()
}

/// A settling time in the network's own time units.
pub fn time_units(time: SettleTime) -> f64 {
    time.thousandths() as f64 / 1e3
}

/// A pattern as four lines of four cells.
pub fn drawing(code: PatternCode) -> [String; 4] {
    text::pattern(code, ["··", "██"])
}

/// A test's result.
pub fn exam(result: &ExamResult) -> String {
    let mut text = String::new();
    let mut line = |name: &str, estimate: Option<Estimate>, digits: usize| {
        if let Some(e) = estimate {
            let interval = if e.low.is_finite() {
                format!("95 %: {:.digits$} to {:.digits$}", e.low, e.high)
            } else {
                "of a single value".into()
            };
            let _ = writeln!(text, "  {name:<34} {:>7.digits$}   ({interval})", e.value);
        }
    };
    line("target reached", result.reached, 3);
    line("reached without a collision", result.clean, 3);
    line("directedness", result.directedness, 3);
    line("way driven / straight distance", result.path_ratio, 3);
    line("actions", result.steps, 1);
    line("share of blocked moves", result.blocked, 4);
    line(
        "angle to the direction, free (deg)",
        result.free_angle_deg,
        1,
    );
    text
}
