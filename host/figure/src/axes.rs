//! Scales and axes.

use svg::Node as _;
use svg::node::element::Group;

use super::shape::{Area, GRID, INK, TEXT_SIZE, centred, group, line, number, px, rectangle, text};

/// Maps values to pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    values: [f64; 2],
    pixels: [f64; 2],
    logarithmic: bool,
}

impl Scale {
    /// Equal differences are equally long.
    pub fn linear(values: [f64; 2], pixels: [f64; 2]) -> Self {
        Self {
            values,
            pixels,
            logarithmic: false,
        }
    }

    /// Equal ratios are equally long; `values` are positive.
    pub fn logarithmic(values: [f64; 2], pixels: [f64; 2]) -> Self {
        Self {
            values: values.map(libm::log10),
            pixels,
            logarithmic: true,
        }
    }

    /// Where a value lies. If all values are one, in the middle.
    pub fn at(&self, value: f64) -> f64 {
        let value = if self.logarithmic {
            libm::log10(value)
        } else {
            value
        };
        let [low, high] = self.values;
        let share = if high == low {
            0.5
        } else {
            (value - low) / (high - low)
        };
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }
}

/// Distances between ticks, and the decimals that their labels need.
const TICK_STEPS: [(f64, usize); 18] = [
    (0.05, 2),
    (0.1, 1),
    (0.2, 1),
    (0.5, 1),
    (1.0, 0),
    (2.0, 0),
    (5.0, 0),
    (10.0, 0),
    (20.0, 0),
    (50.0, 0),
    (100.0, 0),
    (200.0, 0),
    (500.0, 0),
    (1_000.0, 0),
    (2_000.0, 0),
    (5_000.0, 0),
    (10_000.0, 0),
    (100_000.0, 0),
];

/// A value on an axis, and what is written there.
pub(super) type Tick = (f64, String);

/// At most about `most` ticks at round values of a linear scale.
pub(super) fn ticks([low, high]: [f64; 2], most: usize) -> Vec<Tick> {
    let fits = |(step, _): &&(f64, usize)| (high - low) / step <= most as f64;
    let (step, decimals) = *TICK_STEPS.iter().find(fits).unwrap_or(&TICK_STEPS[17]);
    // A rounding error must not lose a tick at the very end.
    let first = (low / step - 1e-6).ceil() as i64;
    let last = (high / step + 1e-6).floor() as i64;
    (first..=last)
        .take(4 * most)
        .map(|i| {
            let value = i as f64 * step;
            (value, number(value, decimals))
        })
        .collect()
}

/// Ticks of a logarithmic scale at 1, 2 and 5 times powers of ten.
pub(super) fn logarithmic_ticks([low, high]: [f64; 2]) -> Vec<Tick> {
    let decades = (0..7).map(|power| libm::exp10(f64::from(power)).round());
    let values = decades.flat_map(|decade| [decade, 2.0 * decade, 5.0 * decade]);
    let inside = values.filter(|value| (low..=high).contains(value));
    inside.map(|value| (value, number(value, 0))).collect()
}

/// The least upper end of an axis from 0 that holds `largest` and ends at a tick.
pub(super) fn rounded_up(largest: f64, most: usize) -> f64 {
    let fits = |(step, _): &&(f64, usize)| largest / step <= most as f64;
    let (step, _) = *TICK_STEPS.iter().find(fits).unwrap_or(&TICK_STEPS[17]);
    (largest / step - 1e-9).ceil().max(1.0) * step
}

/// A frame around an area, with horizontal grid lines.
pub(super) fn frame(area: Area, y: &Scale, y_ticks: &[Tick]) -> Group {
    let mut frame = group("frame");
    for (value, _) in y_ticks {
        let y = y.at(*value);
        frame.append(line([area.left, y], [area.right(), y], GRID, 1.0));
    }
    frame.append(border(area));
    frame
}

/// The outline of an area.
pub(super) fn border(area: Area) -> svg::node::element::Rectangle {
    rectangle(area, "none")
        .set("stroke", INK)
        .set("stroke-width", 1)
}

/// The axis below an area; without a `label` only its ticks.
pub(super) fn below(area: Area, x: &Scale, ticks: &[Tick], label: &str) -> Group {
    let mut axis = group("axis");
    for (value, name) in ticks {
        let (x, y) = (x.at(*value), area.bottom());
        axis.append(line([x, y], [x, y + 4.0], INK, 1.0));
        axis.append(centred([x, y + 16.0], 11.0, name));
    }
    if !label.is_empty() {
        let middle = area.left + area.width / 2.0;
        axis.append(centred([middle, area.bottom() + 32.0], TEXT_SIZE, label));
    }
    axis
}

/// The axis above an area.
pub(super) fn above(area: Area, x: &Scale, ticks: &[Tick], label: &str) -> Group {
    let mut axis = group("axis");
    for (value, name) in ticks {
        let (x, y) = (x.at(*value), area.top);
        axis.append(line([x, y], [x, y - 4.0], INK, 1.0));
        axis.append(centred([x, y - 7.0], 11.0, name));
    }
    let middle = area.left + area.width / 2.0;
    axis.append(centred([middle, area.top - 22.0], TEXT_SIZE, label));
    axis
}

/// The axis left of an area; without a `label` only its ticks.
pub(super) fn beside(area: Area, y: &Scale, ticks: &[Tick], label: &str) -> Group {
    let mut axis = group("axis");
    for (value, name) in ticks {
        let (x, y) = (area.left, y.at(*value));
        axis.append(line([x - 4.0, y], [x, y], INK, 1.0));
        axis.append(text([x - 7.0, y + 4.0], 11.0, name).set("text-anchor", "end"));
    }
    if !label.is_empty() {
        // Room for labels of four characters.
        let (x, y) = (area.left - 40.0, area.top + area.height / 2.0);
        let upwards = format!("rotate(-90 {} {})", px(x), px(y));
        axis.append(centred([x, y], TEXT_SIZE, label).set("transform", upwards));
    }
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|(_, name)| name.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_and_reach_both_ends() {
        assert_eq!(
            names(&ticks([0.0, 1.0], 5)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            names(&ticks([-40.0, 35.0], 4)),
            ["\u{2212}40", "\u{2212}20", "0", "20"]
        );
        assert_eq!(
            names(&ticks([0.0, 489.0], 5)),
            ["0", "100", "200", "300", "400"]
        );
        assert_eq!(
            names(&logarithmic_ticks([1.0, 30.0])),
            ["1", "2", "5", "10", "20"]
        );
    }

    #[test]
    fn an_axis_from_zero_holds_its_largest_value() {
        assert_eq!(rounded_up(16.4, 5), 20.0);
        assert_eq!(rounded_up(500.0, 5), 500.0);
        assert_eq!(rounded_up(0.0, 5), 0.05);
    }

    #[test]
    fn a_scale_without_extent_puts_everything_in_the_middle() {
        assert_eq!(Scale::linear([3.0, 3.0], [10.0, 30.0]).at(3.0), 20.0);
        assert_eq!(Scale::logarithmic([1.0, 1.0], [10.0, 30.0]).at(1.0), 20.0);
        let scale = Scale::logarithmic([1.0, 100.0], [0.0, 100.0]);
        assert!((scale.at(10.0) - 50.0).abs() < 1e-9);
    }
}
