//! Learning curves: how trials went, from the first to the last.

use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::palette::{COLOURS, OTHERS};
use super::shape::{
    Area, HEADER, Heading, Outline, TEXT_SIZE, circle, group, line, number, panel_area, rectangle,
    sheet, text,
};
use rover_simulator::experiment::Trial;

const PANEL: [f64; 2] = [390.0, 200.0];
const PITCH: [f64; 2] = [470.0, 290.0];
/// More would only blacken the panel, and swell the file.
const MOST_DOTS: usize = 1_000;
const LINE: &str = COLOURS[0];
const BAND: &str = "#b9d8ec";

/// Something measured in every trial.
struct Measure {
    title: &'static str,
    axis: &'static str,
    /// Whether the axis counts something per trial.
    per_trial: bool,
    of: fn(&Trial) -> Option<f64>,
    /// Upper end of the axis, if it is always the same.
    high: Option<f64>,
    /// Either happens or not: a median over sessions would be either too, so the mean is drawn.
    yes_or_no: bool,
}

const REACHED: Measure = Measure {
    title: "Target reached",
    axis: "share of trials",
    per_trial: false,
    of: |trial| Some(f64::from(u8::from(trial.reached()))),
    high: Some(1.0),
    yes_or_no: true,
};

const BLOCKED: Measure = Measure {
    title: "Collisions",
    axis: "blocked moves",
    per_trial: true,
    of: |trial| Some(f64::from(trial.collisions)),
    high: None,
    yes_or_no: false,
};

const ACTIONS: Measure = Measure {
    title: "Actions",
    axis: "actions",
    per_trial: true,
    of: |trial| Some(f64::from(trial.steps)),
    high: None,
    yes_or_no: false,
};

const DIRECTEDNESS: Measure = Measure {
    title: "Directedness (8)",
    axis: "directedness (0 to 1)",
    per_trial: false,
    of: |trial| trial.directedness,
    high: Some(1.0),
    yes_or_no: false,
};

const ANGLE: Measure = Measure {
    title: "Angle to the direction, nothing in sight",
    axis: "mean angle (degrees)",
    per_trial: false,
    of: |trial| trial.free_angle_deg,
    high: None,
    yes_or_no: false,
};

/// Draws the learning curves of one or more sessions, which consist of trials, or of what `unit` calls
/// them.
pub(super) fn draw(
    sessions: &[&[Trial]],
    follow_direction: bool,
    unit: &str,
    heading: &Heading,
) -> String {
    let measures = measures(follow_direction);
    let mut parts = vec![legend(sessions, !follow_direction, unit)];
    for (i, measure) in measures.iter().enumerate() {
        let area = panel_area(i, [72.0, HEADER + 62.0], PITCH, PANEL);
        parts.push(panel(area, i, measure, sessions, unit));
    }
    let rows = measures.len().div_ceil(2) as f64;
    let size = [950.0, HEADER + 14.0 + PITCH[1] * rows];
    sheet(size, heading, parts)
}

fn measures(follow_direction: bool) -> &'static [Measure] {
    if follow_direction {
        // All trials have the same number of actions, and wind about after changing directions.
        &[ANGLE, BLOCKED]
    } else {
        &[REACHED, BLOCKED, ACTIONS, DIRECTEDNESS]
    }
}

/// The curves in words: where they begin and end.
pub(super) fn described(sessions: &[&[Trial]], follow_direction: bool) -> String {
    let trials = sessions
        .iter()
        .map(|session| session.len())
        .max()
        .unwrap_or(0);
    let groups = groups(trials);
    let ends = measures(follow_direction).iter().filter_map(|measure| {
        let point = |group: Option<&[usize; 2]>| Point::new(*group?, measure, sessions);
        let (first, last) = (point(groups.first())?, point(groups.last())?);
        let [first, last] = [first, last].map(|point| number(point.middle, 2));
        Some(format!(
            "{}: {first} at first, {last} at last",
            measure.title
        ))
    });
    ends.collect::<Vec<_>>().join("; ") + "."
}

fn panel(area: Area, number: usize, measure: &Measure, sessions: &[&[Trial]], unit: &str) -> Group {
    let trials = sessions
        .iter()
        .map(|session| session.len())
        .max()
        .unwrap_or(0);
    let last = trials.max(2) as f64;
    let groups = groups(trials);
    let points: Vec<Point> = groups
        .iter()
        .filter_map(|group| Point::new(*group, measure, sessions))
        .collect();
    let single = (sessions.len() == 1).then(|| dots(measure, sessions[0]));
    let dots = single.unwrap_or_default();
    let highest = points
        .iter()
        .map(|p| p.high.max(p.middle))
        .chain(dots.iter().map(|dot| dot[1]));
    let high = measure
        .high
        .unwrap_or_else(|| axes::rounded_up(highest.fold(1.0, f64::max), 6));

    let x = Scale::logarithmic([1.0, last], [area.left + 8.0, area.right() - 8.0]);
    // Room for the dots at both ends.
    let y = Scale::linear([0.0, high], [area.bottom() - 5.0, area.top + 5.0]);
    let y_ticks = axes::ticks([0.0, high], 6);
    let mut panel = group("panel");
    let heading = format!("({}) {}", char::from(b'a' + number as u8), measure.title);
    panel.append(text([area.left, area.top - 10.0], 13.0, heading).set("font-weight", "bold"));
    panel.append(axes::frame(area, &y, &y_ticks));
    let dots = Outline::dots(
        dots.into_iter()
            .map(|[trial, value]| [x.at(trial), y.at(value)]),
    );
    panel.append(dots.dotted(OTHERS, 3.6));
    if sessions.len() > 1 {
        let upper = points.iter().map(|p| [x.at(p.trial), y.at(p.high)]);
        let lower = points.iter().rev().map(|p| [x.at(p.trial), y.at(p.low)]);
        let mut band = Outline::through(upper.chain(lower));
        if !band.is_empty() {
            band.close();
            panel.append(band.filled(BAND).set("fill-opacity", 0.7));
        }
    }
    let middle: Vec<[f64; 2]> = points
        .iter()
        .map(|p| [x.at(p.trial), y.at(p.middle)])
        .collect();
    if !middle.is_empty() {
        let line = Outline::through(middle.iter().copied()).stroked(LINE, 2.0);
        panel.append(line.set("stroke-linejoin", "round"));
    }
    for point in middle {
        panel.append(circle(point, 2.6, LINE));
    }
    panel.append(axes::border(area));
    let axis = if measure.per_trial {
        format!("{} per {unit}", measure.axis)
    } else {
        measure.axis.into()
    };
    panel.append(axes::beside(area, &y, &y_ticks, &axis));
    let x_ticks = axes::logarithmic_ticks([1.0, last]);
    panel.append(axes::below(
        area,
        &x,
        &x_ticks,
        &format!("{unit} (number, logarithmic)"),
    ));
    panel
}

/// The trials of a session, one by one, or one of several if there are very many: number and value.
fn dots(measure: &Measure, session: &[Trial]) -> Vec<[f64; 2]> {
    let numbered = (1u32..).zip(session).step_by(thinning(session.len()));
    numbered
        .filter_map(|(i, trial)| Some([f64::from(i), (measure.of)(trial)?]))
        .collect()
}

/// One of how many trials is drawn as a dot.
fn thinning(trials: usize) -> usize {
    trials.div_ceil(MOST_DOTS).max(1)
}

/// What sessions did in a group of trials.
struct Point {
    /// The group's geometric middle.
    trial: f64,
    low: f64,
    middle: f64,
    high: f64,
}

impl Point {
    /// Of each session the mean over the group; of these the middle and the spread.
    fn new([first, last]: [usize; 2], measure: &Measure, sessions: &[&[Trial]]) -> Option<Self> {
        let mean_of = |session: &&[Trial]| {
            let trials = session.get(first - 1..last.min(session.len()))?;
            mean(&trials.iter().filter_map(measure.of).collect::<Vec<_>>())
        };
        let mut means: Vec<f64> = sessions.iter().filter_map(mean_of).collect();
        means.sort_unstable_by(f64::total_cmp);
        let middle = if measure.yes_or_no {
            mean(&means)
        } else {
            quantile(&means, 0.5)
        };
        Some(Self {
            trial: libm::sqrt(first as f64 * last as f64),
            low: quantile(&means, 0.1)?,
            middle: middle?,
            high: quantile(&means, 0.9)?,
        })
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The value below which a share of sorted values lies, interpolated.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (
        sorted[place.floor() as usize],
        sorted[place.ceil() as usize],
    );
    Some(below + (above - below) * place.fract())
}

/// Groups of trials, first and last, counted from 1, that grow by a third: most is learned at the
/// start. They are about equally wide on a logarithmic axis.
fn groups(trials: usize) -> Vec<[usize; 2]> {
    let mut groups = Vec::new();
    let mut first = 1;
    while first <= trials {
        let next = first * 4 / 3 + 1;
        groups.push([first, (next - 1).min(trials)]);
        first = next;
    }
    groups
}

fn legend(sessions: &[&[Trial]], with_target: bool, unit: &str) -> Group {
    let mut legend = group("legend");
    let (x, y) = (72.0, HEADER + 16.0);
    legend.append(line([x, y], [x + 26.0, y], LINE, 2.0));
    legend.append(circle([x + 13.0, y], 2.6, LINE));
    let entry = |x: f64, name: String| text([x, y + 4.0], TEXT_SIZE, name);
    if let [session] = sessions {
        legend.append(entry(
            x + 34.0,
            format!("mean over groups of successive {unit}s"),
        ));
        legend.append(circle([x + 290.0, y], 2.5, OTHERS));
        let name = match thinning(session.len()) {
            1 => format!("one {unit}"),
            n => format!("one {unit}, one of every {n}"),
        };
        legend.append(entry(x + 300.0, name));
    } else {
        let except = if with_target { " (a: mean)" } else { "" };
        let lengths = || sessions.iter().map(|session| session.len());
        let (shortest, longest) = (lengths().min(), lengths().max());
        let fewer = match shortest {
            Some(all) if shortest < longest => format!(", fewer from {unit} {} on", all + 1),
            _ => String::new(),
        };
        // Side by side, whatever the first says.
        let x_of_band = if with_target && !fewer.is_empty() {
            x + 60.0
        } else {
            x
        };
        legend.append(entry(
            x + 34.0,
            format!("median of {} sessions{except}{fewer}", sessions.len()),
        ));
        let x = x_of_band;
        let band = Area {
            left: x + 290.0,
            top: y - 6.0,
            width: 26.0,
            height: 12.0,
        };
        legend.append(rectangle(band, BAND).set("fill-opacity", 0.7));
        let name =
            format!("10 to 90 % of the sessions, each averaged over groups of successive {unit}s");
        legend.append(entry(x + 324.0, name));
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_hold_every_trial_once() {
        for trials in [0, 1, 2, 7, 200] {
            let all: Vec<usize> = groups(trials).iter().flat_map(|[a, b]| *a..=*b).collect();
            assert_eq!(all, (1..=trials).collect::<Vec<_>>());
        }
        assert_eq!(
            groups(12),
            [[1, 1], [2, 2], [3, 4], [5, 6], [7, 9], [10, 12]]
        );
    }

    #[test]
    fn quantiles_are_interpolated() {
        let values = [0.0, 1.0, 2.0, 3.0, 4.0];
        assert_eq!(quantile(&values, 0.5), Some(2.0));
        assert_eq!(quantile(&values, 0.125), Some(0.5));
        assert_eq!(quantile(&[7.0], 0.9), Some(7.0));
        assert_eq!(quantile(&[], 0.5), None);
    }
}
