//! Fig. 3: the function of one sensing neuron, and how it is learned by (5) and (6).

use rover_shared::learning::StaircaseChange;
use rover_shared::sensing::Stimulus;
use rover_shared::sensing::neuron::{Activation, SensingNeuron};
use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::palette::COLOURS;
use super::shape::{
    Area, FAINT_INK, GRID, HEADER, Heading, INK, Outline, TEXT_SIZE, group, line, number,
    rectangle, sheet, text,
};
use super::staircases::{amplitudes, borders, extent, outlines, short_name, zero};
use rover_simulator::experiment::History;

/// Shares of all changes after which the staircase is shown.
const STAGES: [f64; 4] = [0.005, 0.02, 0.1, 1.0];
/// How the stages are drawn: ink, width, dashes.
const STYLES: [(&str, f64, &str); 4] = [
    ("#999999", 1.4, "1 2"),
    ("#6e6e6e", 1.6, "4 2"),
    (INK, 1.4, "none"),
    (COLOURS[0], 3.0, "none"),
];

/// What one neuron learned, and two moments of it.
pub(super) struct Lesson {
    stimulus: Stimulus,
    /// Changes of this neuron so far, and the staircase then.
    stages: Vec<(usize, SensingNeuron)>,
    /// The largest rise and the largest fall.
    examples: [Option<Example>; 2],
}

struct Example {
    change: StaircaseChange,
    /// The action after which it was made, from 1.
    action: u64,
    before: SensingNeuron,
    after: SensingNeuron,
}

impl Lesson {
    /// Of the neuron that was changed most often.
    pub fn new(history: &History) -> Self {
        let changes_of = |stimulus: Stimulus| {
            let changes = history.changes().iter().enumerate();
            changes.filter(move |(_, (_, change))| change.stimulus == stimulus)
        };
        let stimulus = Stimulus::ALL
            .into_iter()
            .max_by_key(|stimulus| changes_of(*stimulus).count())
            .unwrap_or(Stimulus::Target);
        let neuron = |changes: usize| history.after(changes)[stimulus as usize];
        let own: Vec<usize> = changes_of(stimulus).map(|(i, _)| i).collect();
        let stage = |share: &f64| {
            let count = (share * own.len() as f64).ceil() as usize;
            let changes = count.checked_sub(1).map_or(0, |last| own[last] + 1);
            (count, neuron(changes))
        };
        let example = |sign: i32| {
            // Of equals the first: early changes are large beside what they change.
            let largest = changes_of(stimulus)
                .filter(|(_, (_, change))| change.amount.signum() == sign)
                .min_by_key(|(_, (_, change))| std::cmp::Reverse(change.amount.unsigned_abs()))?;
            let (i, (action, change)) = largest;
            Some(Example {
                change: *change,
                action: *action,
                before: neuron(i),
                after: neuron(i + 1),
            })
        };
        let mut stages: Vec<_> = STAGES.iter().map(stage).collect();
        stages.dedup_by_key(|(count, _)| *count);
        Self {
            stimulus,
            stages,
            examples: [1, -1].map(example),
        }
    }

    /// In words.
    pub fn described(&self) -> String {
        let changes = self.stages.last().map_or(0, |(count, _)| *count);
        let mut text = format!("Neuron {}, {changes} changes", short_name(self.stimulus));
        for example in self.examples.iter().flatten() {
            let amount = real(example.change.amount);
            let step = example.change.step.index() + 1;
            text += &format!(
                "; {} in step {step} after action {}",
                number(amount, 3),
                example.action
            );
        }
        text + "."
    }

    pub fn draw(&self, heading: &Heading) -> String {
        let area = |i: usize| Area {
            left: 68.0 + 330.0 * i as f64,
            top: HEADER + 54.0,
            width: 262.0,
            height: 220.0,
        };
        let names = ["(b) A rise, by (5)", "(c) A fall, by (6)"];
        let mut parts = vec![self.growth(area(0))];
        for (i, (example, name)) in self.examples.iter().zip(names).enumerate() {
            parts.push(panel(area(i + 1), name, example.as_ref()));
        }
        parts.push(self.legend(area(0).bottom() + 62.0));
        sheet([1030.0, area(0).bottom() + 118.0], heading, parts)
    }

    fn growth(&self, area: Area) -> Group {
        let staircases: Vec<_> = self.stages.iter().map(|(_, n)| amplitudes(n)).collect();
        let (mut drawing, [x, y]) = frame(area, &staircases);
        let name = format!("(a) Neuron for {}: as it grew", short_name(self.stimulus));
        drawing.append(text([area.left, area.top - 26.0], 13.0, name).set("font-weight", "bold"));
        drawing.append(zero([area.left, y.at(0.0)], [area.right(), y.at(0.0)]));
        let styles = &STYLES[STYLES.len() - staircases.len()..];
        for (staircase, (ink, width, dashes)) in staircases.iter().zip(styles) {
            let (treads, risers) = outlines(staircase, &x, &y);
            for (outline, width) in [(risers, 0.7 * width), (treads, *width)] {
                drawing.append(outline.stroked(ink, width).set("stroke-dasharray", *dashes));
            }
        }
        drawing.append(axes::border(area));
        drawing
    }

    fn legend(&self, y: f64) -> Group {
        let mut legend = group("legend");
        let styles = &STYLES[STYLES.len() - self.stages.len()..];
        legend.append(text([68.0, y], TEXT_SIZE, "(a) after"));
        let mut x = 130.0;
        for ((count, _), (ink, width, dashes)) in self.stages.iter().zip(styles) {
            let sample = line([x, y - 4.0], [x + 26.0, y - 4.0], ink, *width);
            legend.append(sample.set("stroke-dasharray", *dashes));
            let name = match count {
                1 => "1 change".into(),
                n => format!("{n} changes"),
            };
            legend.append(text([x + 33.0, y], TEXT_SIZE, name));
            x += 135.0;
        }
        legend.append(zero([x, y - 4.0], [x + 26.0, y - 4.0]));
        legend.append(text([x + 33.0, y], TEXT_SIZE, "before learning"));
        let y = y + 24.0;
        legend.append(text([68.0, y], TEXT_SIZE, "(b, c)"));
        legend.append(
            line([130.0, y - 4.0], [156.0, y - 4.0], FAINT_INK, 1.4).set("stroke-dasharray", "4 2"),
        );
        legend.append(text([163.0, y], TEXT_SIZE, "before the change"));
        legend.append(line([300.0, y - 4.0], [326.0, y - 4.0], COLOURS[0], 3.0));
        legend.append(text([333.0, y], TEXT_SIZE, "after it"));
        let swatch = Area {
            left: 420.0,
            top: y - 11.0,
            width: 26.0,
            height: 13.0,
        };
        legend.append(rectangle(swatch, GRID));
        legend.append(text(
            [453.0, y],
            TEXT_SIZE,
            "step i, in which the input lay",
        ));
        legend
    }
}

fn real(amount: i32) -> f64 {
    f64::from(amount) / f64::from(Activation::ONE)
}

/// An empty panel for staircases, and its scales.
fn frame(area: Area, staircases: &[[f64; 10]]) -> (Group, [Scale; 2]) {
    let ends = staircases.iter().map(|staircase| extent(staircase));
    let [low, high] = ends
        .reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
        .unwrap_or([-1.0, 1.0]);
    let x = Scale::linear([-1.0, 1.0], [area.left, area.right()]);
    let y = Scale::linear([low, high], [area.bottom(), area.top]);
    let y_ticks = axes::ticks([low, high], 6);
    let mut drawing = group("panel");
    drawing.append(axes::frame(area, &y, &y_ticks));
    drawing.append(axes::beside(
        area,
        &y,
        &y_ticks,
        "step amplitude (dimensionless)",
    ));
    let x_ticks = axes::ticks([-1.0, 1.0], 5);
    drawing.append(axes::below(
        area,
        &x,
        &x_ticks,
        "scaled input (dimensionless)",
    ));
    (drawing, [x, y])
}

fn panel(area: Area, name: &str, example: Option<&Example>) -> Group {
    let both: Vec<[f64; 10]> = example
        .map(|example| [&example.before, &example.after].map(amplitudes).to_vec())
        .unwrap_or_default();
    let (mut drawing, [x, y]) = frame(area, &both);
    drawing.append(text([area.left, area.top - 26.0], 13.0, name).set("font-weight", "bold"));
    let below = match example {
        None => "did not occur".into(),
        Some(example) => format!(
            "r = {} in step i = {}, after action {}",
            number(real(example.change.amount), 3),
            example.change.step.index() + 1,
            example.action
        ),
    };
    drawing.append(text([area.left, area.top - 9.0], TEXT_SIZE, below).set("fill", FAINT_INK));
    let Some(example) = example else {
        return drawing;
    };
    let [from, to] = borders(example.change.step.index()).map(|border| x.at(border));
    let step = Area {
        left: from,
        width: to - from,
        ..area
    };
    drawing.append(rectangle(step, GRID));
    drawing.append(zero([area.left, y.at(0.0)], [area.right(), y.at(0.0)]));
    let styles = [(FAINT_INK, 1.4, "4 2"), (COLOURS[0], 3.0, "none")];
    for (staircase, (ink, width, dashes)) in both.iter().zip(styles).rev() {
        let (treads, risers): (Outline, Outline) = outlines(staircase, &x, &y);
        for (outline, width) in [(risers, 0.5 * width), (treads, width)] {
            drawing.append(outline.stroked(ink, width).set("stroke-dasharray", dashes));
        }
    }
    drawing.append(axes::border(area));
    drawing
}
