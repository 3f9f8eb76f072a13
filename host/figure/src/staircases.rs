//! Fig. 4: the four learned staircases.

use rover_shared::sensing::neuron::{Activation, STEPS, SensingNeuron};
use rover_shared::sensing::{DistanceRange, SensorRanges, Stimulus};
use rover_shared::units::Micrometres;
use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale, Tick};
use super::palette::COLOURS;
use super::shape::{
    Area, FAINT_INK, GRID, HEADER, Heading, Outline, TEXT_SIZE, group, line, number, panel_area,
    sheet, text,
};

const PANEL: [f64; 2] = [400.0, 190.0];
/// From one panel to the next.
const PITCH: [f64; 2] = [480.0, 322.0];
const SHEET: [f64; 2] = [980.0, HEADER + 2.0 * PITCH[1] + 30.0];

const LEARNED: &str = COLOURS[0];

/// Draws what the four sensing neurons have learned.
pub(super) fn draw(
    neurons: &[SensingNeuron; 4],
    ranges: &SensorRanges,
    heading: &Heading,
) -> String {
    let mut parts = vec![legend()];
    let panels = Stimulus::ALL.iter().zip(neurons).enumerate();
    for (i, (stimulus, neuron)) in panels {
        let area = panel_area(i, [68.0, HEADER + 96.0], PITCH, PANEL);
        parts.push(panel(area, i, *stimulus, neuron, ranges));
    }
    sheet(SHEET, heading, parts)
}

/// The ten amplitudes as numbers.
pub(super) fn amplitudes(neuron: &SensingNeuron) -> [f64; STEPS] {
    let one = f64::from(Activation::ONE);
    neuron.amplitudes().map(|a| f64::from(a.0) / one)
}

/// The staircases in words: where each begins and ends.
pub(super) fn described(neurons: &[SensingNeuron; 4]) -> String {
    let ends = Stimulus::ALL.iter().zip(neurons).map(|(stimulus, neuron)| {
        let a = amplitudes(neuron);
        let name = short_name(*stimulus);
        format!(
            "{name} from {} to {}",
            number(a[0], 1),
            number(a[STEPS - 1], 1)
        )
    });
    let ends = ends.collect::<Vec<_>>().join("; ");
    format!("Amplitudes from the first step to the tenth: {ends}.")
}

/// A stimulus as the paper calls it.
pub(super) fn short_name(stimulus: Stimulus) -> &'static str {
    match stimulus {
        Stimulus::Front => "front, F",
        Stimulus::Left => "left, L",
        Stimulus::Right => "right, R",
        Stimulus::Target => "target, T",
    }
}

fn panel(
    area: Area,
    number: usize,
    stimulus: Stimulus,
    neuron: &SensingNeuron,
    ranges: &SensorRanges,
) -> Group {
    let amplitudes = amplitudes(neuron);
    let [low, high] = extent(&amplitudes);
    let x = Scale::linear([-1.0, 1.0], [area.left, area.right()]);
    let y = Scale::linear([low, high], [area.bottom(), area.top]);
    let y_ticks = axes::ticks([low, high], 6);
    let mut panel = group("panel");
    let letter = char::from(b'a' + number as u8);
    let heading = format!("({letter}) {}", name(stimulus));
    panel.append(text([area.left, area.top - 48.0], 13.0, heading).set("font-weight", "bold"));
    panel.append(axes::frame(area, &y, &y_ticks));
    for border in 1..STEPS {
        let x = x.at(-1.0 + 0.2 * border as f64);
        panel.append(line([x, area.top], [x, area.bottom()], GRID, 1.0));
    }
    panel.append(zero([area.left, y.at(0.0)], [area.right(), y.at(0.0)]));
    let (treads, risers) = outlines(&amplitudes, &x, &y);
    panel.append(risers.stroked(LEARNED, 1.0));
    panel.append(treads.stroked(LEARNED, 3.0));
    panel.append(axes::border(area));
    panel.append(axes::beside(
        area,
        &y,
        &y_ticks,
        "step amplitude (dimensionless)",
    ));
    let scaled: Vec<Tick> = axes::ticks([-1.0, 1.0], 5);
    panel.append(axes::below(area, &x, &scaled, "scaled input"));
    let (physical, label) = physical_axis(stimulus, ranges);
    panel.append(axes::above(area, &x, &physical, label));
    panel
}

/// The outlines of a staircase: its steps, and what joins them.
pub(super) fn outlines(amplitudes: &[f64; STEPS], x: &Scale, y: &Scale) -> (Outline, Outline) {
    let (mut treads, mut risers) = (Outline::default(), Outline::default());
    for (i, amplitude) in amplitudes.iter().enumerate() {
        let [from, to] = borders(i).map(|border| x.at(border));
        let y_here = y.at(*amplitude);
        treads.move_to([from, y_here]);
        treads.line_to([to, y_here]);
        if let Some(next) = amplitudes.get(i + 1) {
            risers.move_to([to, y_here]);
            risers.line_to([to, y.at(*next)]);
        }
    }
    (treads, risers)
}

/// Where a step begins and ends on the scaled axis.
pub(super) fn borders(step: usize) -> [f64; 2] {
    [step, step + 1].map(|border| -1.0 + 0.2 * border as f64)
}

/// The extent of the amplitude axis: all amplitudes and 0, with some room.
pub(super) fn extent(amplitudes: &[f64]) -> [f64; 2] {
    let low = amplitudes.iter().copied().fold(0.0, f64::min);
    let high = amplitudes.iter().copied().fold(0.0, f64::max);
    if low == high {
        return [-1.0, 1.0];
    }
    let room = 0.08 * (high - low);
    [low - room, high + room]
}

fn name(stimulus: Stimulus) -> &'static str {
    match stimulus {
        Stimulus::Front => "Front, F (upper left corner)",
        Stimulus::Left => "Left, L (upper right corner)",
        Stimulus::Right => "Right, R (lower left corner)",
        Stimulus::Target => "Target, T (lower right corner)",
    }
}

/// What the borders between steps are in centimetres or degrees.
pub(super) fn physical_axis(
    stimulus: Stimulus,
    ranges: &SensorRanges,
) -> (Vec<Tick>, &'static str) {
    let cm = |length: Micrometres| f64::from(length.0) / f64::from(Micrometres::PER_CM);
    let distance = |range: &DistanceRange| [cm(range.near), cm(range.far)];
    let ([low, high], label) = match stimulus {
        Stimulus::Front => (distance(&ranges.front), "free distance (cm)"),
        Stimulus::Left | Stimulus::Right => (distance(&ranges.side), "free distance (cm)"),
        Stimulus::Target => (
            [-180.0, 180.0],
            "angle to the target (degrees, positive = left)",
        ),
    };
    let tick = |i: u32| {
        let share = f64::from(i) / 10.0;
        let value = low + share * (high - low);
        let decimals = usize::from((value - value.round()).abs() > 1e-6);
        (2.0 * share - 1.0, number(value, decimals))
    };
    ((0..=10).map(tick).collect(), label)
}

/// The line on which all steps lie before learning.
pub(super) fn zero(from: [f64; 2], to: [f64; 2]) -> svg::node::element::Line {
    line(from, to, FAINT_INK, 1.0).set("stroke-dasharray", "5 4")
}

fn legend() -> Group {
    let mut legend = group("legend");
    let (x, y) = (620.0, 42.0);
    legend.append(line([x, y], [x + 26.0, y], LEARNED, 3.0));
    legend.append(text([x + 34.0, y + 4.0], TEXT_SIZE, "after learning"));
    legend.append(zero([x + 150.0, y], [x + 176.0, y]));
    legend.append(text([x + 184.0, y + 4.0], TEXT_SIZE, "before learning"));
    legend
}

#[cfg(test)]
mod tests {
    use rover_shared::parameters::{Coefficients, Parameters};

    use super::*;

    #[test]
    fn the_physical_axis_has_the_borders_of_the_steps() {
        let coefficients = Coefficients::new(&Parameters::ROVER).unwrap();
        let (ticks, _) = physical_axis(Stimulus::Front, &coefficients.ranges);
        let names: Vec<_> = ticks.iter().map(|(_, name)| name.as_str()).collect();
        // IV-A: from 14 to 64 cm in steps of 5.
        assert_eq!(
            names,
            [
                "14", "19", "24", "29", "34", "39", "44", "49", "54", "59", "64"
            ]
        );
    }

    #[test]
    fn a_flat_staircase_has_an_axis_too() {
        assert_eq!(extent(&[0.0; 10]), [-1.0, 1.0]);
        assert_eq!(extent(&[-2.0, 0.0, 8.0]), [-2.8, 8.8]);
    }
}
