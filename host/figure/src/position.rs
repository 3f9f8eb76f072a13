//! Fig. 7: the place of one action, the steps that its readings activate, and what follows.

use rover_shared::perception::Corners;
use rover_shared::sensing::neuron::SensingNeuron;
use rover_shared::sensing::{SensorRanges, Stimulus};
use svg::Node as _;
use svg::node::element::Group;

use super::axes::{self, Scale};
use super::drive::Drive;
use super::lattice::cells_drawn;
use super::palette::Palette;
use super::shape::{
    Area, FAINT_INK, GRID, HEADER, Heading, INK, Outline, TEXT_SIZE, centred, circle, group, line,
    number, pattern, rectangle, sheet, text,
};
use super::situations::outcome;
use super::staircases::{amplitudes, borders, extent, outlines, physical_axis, short_name, zero};
use super::trajectories::{mark_legend, pattern_legend};
use super::view::View;
use rover_simulator::experiment::Event;

/// One action of a drive, with all that led to it.
pub(super) struct Closeup<'a> {
    pub drive: &'a Drive,
    /// Its number, from 0.
    pub at: usize,
    /// The staircases at that time.
    pub neurons: &'a [SensingNeuron; 4],
    pub ranges: &'a SensorRanges,
}

const SHEET_WIDTH: f64 = 1000.0;
/// Actions of the way that are shown before and after the place, of drives that have no end.
const AROUND: usize = 60;

/// In words.
pub(super) fn described(drive: &Drive, at: usize) -> String {
    let Some(event) = drive.events.get(at) else {
        return "There was no action.".into();
    };
    let readings = readings(event).into_iter().flatten();
    let readings =
        readings
            .zip(steps(event))
            .zip(Stimulus::ALL)
            .map(|((reading, step), stimulus)| {
                format!("{} {reading}, step {}", short_name(stimulus), step + 1)
            });
    let readings: Vec<String> = readings.collect();
    format!("{}: {}.", readings.join("; "), conclusion(event))
}

/// The pattern and the action.
fn conclusion(event: &Event) -> String {
    let turn = f64::from(event.record.action.phase.0) / 1e6;
    let turn = match turn {
        t if t < 0.0 => format!("turn of {:.1}° to the right", -t),
        t => format!("turn of {t:.1}° to the left"),
    };
    match event.record.perceived {
        None => "no pattern".into(),
        Some(perceived) => format!("pattern {}, {turn}", perceived.code),
    }
}

/// What was sensed, as people say it, in the order of [`Stimulus`].
fn readings(event: &Event) -> Option<[String; 4]> {
    let sensed = event.record.sensed?;
    let cm = |length: rover_shared::units::Micrometres| {
        format!("{} cm", number(f64::from(length.0) / 1e4, 1))
    };
    let angle = f64::from(sensed.target_angle.0) / 1e6;
    let side = if angle < 0.0 { "right" } else { "left" };
    let sample = event.sample;
    let distance = |i: usize, length| {
        if sensed.percept.0[i].millionths() == 1_000_000 {
            "nothing in range".to_owned()
        } else {
            cm(length)
        }
    };
    Some([
        distance(0, sample.front),
        distance(1, sample.left),
        distance(2, sample.right),
        format!("{:.1}° {side}", angle.abs()),
    ])
}

/// The steps in use, from 0; none without a percept.
fn steps(event: &Event) -> Vec<usize> {
    let sensed = event.record.sensed.into_iter();
    sensed
        .flat_map(|sensed| sensed.percept.steps())
        .map(|step| step.index())
        .collect()
}

/// Draws the way, the four staircases, and the network.
pub(super) fn draw(closeup: &Closeup, palette: &Palette, heading: &Heading) -> String {
    let Closeup { drive, at, .. } = *closeup;
    let event = drive.events.get(at);
    let mut parts = Vec::new();
    let within = Area {
        left: 90.0,
        top: HEADER + 34.0,
        width: 860.0,
        height: 340.0,
    };
    let view = View::centred(&drive.scenario.world, within);
    parts.push(way(closeup, &view, palette));

    let top = view.area.bottom() + 62.0;
    parts.push(pattern_legend(60.0, top - 6.0, palette));
    parts.push(mark_legend([60.0, top + 70.0], &[drive]));
    let top = top + 110.0;
    let title = text([20.0, top], 13.0, "(b) Activated steps at A (bold)");
    parts.push(group("heading").add(title.set("font-weight", "bold")));
    let mut bottom = top;
    for (i, stimulus) in Stimulus::ALL.into_iter().enumerate() {
        let area = Area {
            left: 60.0 + 240.0 * i as f64,
            top: top + 46.0,
            width: 176.0,
            height: 130.0,
        };
        parts.push(staircase(area, stimulus, closeup, i == 0));
        bottom = area.bottom();
    }
    let top = bottom + 68.0;
    let title = text(
        [20.0, top],
        13.0,
        "(c) From the corners to the pattern and its action",
    );
    parts.push(group("heading").add(title.set("font-weight", "bold")));
    parts.push(match event {
        Some(event) => growth(event, top + 16.0, palette),
        None => group("panel").add(text([60.0, top + 40.0], TEXT_SIZE, "There was no action.")),
    });
    sheet([SHEET_WIDTH, top + 132.0], heading, parts)
}

/// The way, with the place marked.
fn way(closeup: &Closeup, view: &View, palette: &Palette) -> Group {
    let Closeup { drive, at, .. } = *closeup;
    let mut way = group("panel");
    let title = format!("(a) The way, with the place A: {}", outcome(drive));
    way.append(text([20.0, view.area.top - 12.0], 13.0, title).set("font-weight", "bold"));
    let near = if drive.scenario.goal.is_none() && drive.events.len() > 2 * AROUND {
        drive.stretch(at.saturating_sub(AROUND)..at + AROUND)
    } else {
        drive.clone()
    };
    way.append(view.arena(drive));
    if let Some(event) = drive.events.get(at) {
        way.append(view.fields(drive, event));
    }
    way.append(view.path(&near, palette));
    way.append(view.marks(&near));
    if let Some(event) = drive.events.get(at) {
        let [x, y] = view.at(event.pose.position());
        let ring = circle([x, y], 7.0, "none").set("stroke", INK);
        way.append(ring.set("stroke-width", 1.8));
        // On the side of the ring that has more room.
        let right = x < view.area.right() - 40.0;
        let above = y > view.area.top + 30.0;
        let at = [
            if right { x + 14.0 } else { x - 14.0 },
            if above { y - 9.0 } else { y + 18.0 },
        ];
        let name = centred(at, 15.0, "A").set("font-weight", "bold");
        way.append(
            name.set("stroke", "#ffffff")
                .set("stroke-width", 4)
                .set("paint-order", "stroke")
                .set("stroke-linejoin", "round"),
        );
    }
    for axis in view.axes(&drive.scenario.world, true, true) {
        way.append(axis);
    }
    way
}

/// A small staircase with the activated step in bold.
fn staircase(area: Area, stimulus: Stimulus, closeup: &Closeup, labelled: bool) -> Group {
    let event = closeup.drive.events.get(closeup.at);
    let neuron = &closeup.neurons[stimulus as usize];
    let staircase = amplitudes(neuron);
    let [low, high] = extent(&staircase);
    let x = Scale::linear([-1.0, 1.0], [area.left, area.right()]);
    let y = Scale::linear([low, high], [area.bottom(), area.top]);
    let y_ticks = axes::ticks([low, high], 5);
    let mut panel = group("staircase");
    let name = short_name(stimulus);
    panel.append(text([area.left, area.top - 22.0], TEXT_SIZE, name).set("font-weight", "bold"));
    panel.append(axes::frame(area, &y, &y_ticks));
    panel.append(zero([area.left, y.at(0.0)], [area.right(), y.at(0.0)]));
    let (treads, risers) = outlines(&staircase, &x, &y);
    panel.append(risers.stroked(FAINT_INK, 0.8));
    panel.append(treads.stroked(FAINT_INK, 1.4));
    if let Some((event, step)) = event.and_then(|event| {
        let step = *steps(event).get(stimulus as usize)?;
        Some((event, step))
    }) {
        let [from, to] = borders(step).map(|border| x.at(border));
        let level = y.at(staircase[step]);
        let column = Area {
            left: from,
            width: to - from,
            ..area
        };
        panel.append(rectangle(column, GRID).set("fill-opacity", 0.8));
        panel.append(line([from, level], [to, level], INK, 5.0).set("class", "active"));
        let reading = readings(event).map_or(String::new(), |r| r[stimulus as usize].clone());
        let says = format!(
            "{reading}: step {}, {}",
            step + 1,
            number(staircase[step], 2)
        );
        panel.append(text([area.left, area.top - 7.0], 11.0, says));
    }
    panel.append(axes::border(area));
    let (ticks, label) = physical_axis(stimulus, closeup.ranges);
    let every = ticks.into_iter().enumerate();
    // Every other border: the panels are small.
    let fewer: Vec<_> = every.filter(|(i, _)| i % 2 == 0).map(|(_, t)| t).collect();
    let label = if stimulus == Stimulus::Target {
        "angle, + = left (degrees)"
    } else {
        label
    };
    panel.append(axes::below(area, &x, &fewer, label));
    let label = if labelled { "amplitude" } else { "" };
    panel.append(axes::beside(area, &y, &y_ticks, label));
    panel
}

/// The corners, the pattern, and the action.
fn growth(event: &Event, top: f64, palette: &Palette) -> Group {
    const SIDE: f64 = 76.0;
    let mut panel = group("panel");
    let arrow = |x: f64| {
        let y = top + SIDE / 2.0;
        let mut arrow = Outline::through([[x, y], [x + 34.0, y]]);
        for dy in [-5.0, 5.0] {
            arrow.move_to([x + 27.0, y + dy]);
            arrow.line_to([x + 34.0, y]);
        }
        arrow.stroked(INK, 1.6)
    };
    let Some(perceived) = event.record.perceived else {
        let none = "No pattern arose: the target was not known, or the network did not settle.";
        panel.append(text([60.0, top + 30.0], TEXT_SIZE, none));
        return panel;
    };
    let unit = f64::from(1 << Corners::FRACTION_BITS);
    let mut cells = [0.0; 16];
    for (cell, corner) in Corners::CELLS.into_iter().zip(perceived.corners.0) {
        cells[cell] = f64::from(corner) / unit;
    }
    let left = 110.0;
    panel.append(cells_drawn([left, top], SIDE, &cells, true));
    // Names of the corners, outside.
    for (name, x, y) in [
        ("F", left - 12.0, top + 14.0),
        ("L", left + SIDE + 12.0, top + 14.0),
        ("R", left - 12.0, top + SIDE - 5.0),
        ("T", left + SIDE + 12.0, top + SIDE - 5.0),
    ] {
        panel.append(centred([x, y], TEXT_SIZE, name).set("font-weight", "bold"));
    }
    panel.append(centred(
        [left + SIDE / 2.0, top + SIDE + 18.0],
        11.0,
        "layer 1 at first",
    ));
    panel.append(arrow(230.0));
    let time = format!("{} time units", perceived.settle_time);
    panel.append(centred([247.0, top + SIDE / 2.0 + 20.0], 10.0, time));
    let colour = palette.colour(Some(perceived.code));
    panel.append(pattern([310.0, top], SIDE, perceived.code, colour));
    let code = format!("code {}", perceived.code);
    panel.append(centred([310.0 + SIDE / 2.0, top + SIDE + 18.0], 11.0, code));
    panel.append(arrow(412.0));
    let (x, y) = (468.0, top + 34.0);
    panel.append(text([x, y], 14.0, conclusion(event)).set("font-weight", "bold"));
    let module = f64::from(event.record.action.module.0) / 1e4;
    let move_on = format!("then a move of {} cm ahead", number(module, 1));
    panel.append(text([x, y + 20.0], TEXT_SIZE, move_on).set("fill", FAINT_INK));
    panel
}
