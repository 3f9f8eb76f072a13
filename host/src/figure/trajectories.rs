//! Fig. 5 to 9: trajectories before and after learning.

use rover_shared::units::Microdegrees;
use svg::Node as _;
use svg::node::element::Group;

use super::drive::Drive;
use super::palette::{OTHERS, Palette};
use super::shape::{Area, FAINT_INK, HEADER, Outline, TEXT_SIZE, group, pattern, sheet, text};
use super::view::{
    MARK_EVERY, View, blocked_mark, direction_mark, heading_mark, start_mark, target,
};
use crate::arena::{Motion, Obstacle, Side};

/// Of a drive to a target this much is shown: all that the paper allows (III-B).
pub(super) const SHOWN_AIMING: usize = 500;
/// Of a drive that follows directions, which has no end, less: it would cover the arena.
pub(super) const SHOWN_FOLLOWING: usize = 150;

const SHEET_WIDTH: f64 = 1060.0;
/// Left of a panel, for its axis.
const LEFT: f64 = 58.0;
/// Above a panel, for two lines of text.
const ABOVE: f64 = 42.0;
/// Below a panel, for its axis.
const BELOW: f64 = 40.0;
const MOST_HEIGHT: f64 = 340.0;
const LEGEND_HEIGHT: f64 = 92.0;

/// A drive and what it shows.
pub(super) struct Scene<'a> {
    pub title: String,
    pub drive: &'a Drive,
}

/// A situation of the paper's tests (III-C), told from what the robot met.
struct Situation {
    title: &'static str,
    is_met: fn(&Drive) -> bool,
}

/// The paper's figures 5b to 8 in order.
const SITUATIONS: [Situation; 4] = [
    Situation {
        title: "nothing in the way",
        is_met: |drive| {
            !drive.events.is_empty()
                && encounters(drive) == 0
                && start_angle_deg(drive).abs() < 90.0
        },
    },
    Situation {
        title: "target behind",
        is_met: |drive| encounters(drive) == 0 && start_angle_deg(drive).abs() > 100.0,
    },
    Situation {
        title: "obstacle in front",
        is_met: |drive| seen(drive, &[Side::Front]) > 0 && begins_free(drive),
    },
    Situation {
        title: "obstacle at the side",
        is_met: |drive| {
            seen(drive, &[Side::Left, Side::Right]) > seen(drive, &[Side::Front])
                && begins_free(drive)
        },
    },
];

/// Trained drives shown.
const MOST_TRAINED: usize = 5;

/// Actions before which a sensor on one of these sides saw something.
fn seen(drive: &Drive, sides: &[Side]) -> usize {
    drive
        .events
        .iter()
        .filter(|event| sides.iter().any(|side| drive.saw(event, *side)))
        .count()
}

/// Actions before which any sensor saw something.
fn encounters(drive: &Drive) -> usize {
    seen(drive, &ALL_SIDES)
}

const ALL_SIDES: [Side; 3] = [Side::Front, Side::Left, Side::Right];

/// Whether nothing is in sight at the start, but something will be in the way that is not a wall.
fn begins_free(drive: &Drive) -> bool {
    let free = |event| !ALL_SIDES.iter().any(|side| drive.saw(event, *side));
    drive.events.first().is_some_and(free) && obstacles_on_the_way(drive) > 0
}

/// The angle to the target at the start, positive on the left.
fn start_angle_deg(drive: &Drive) -> f64 {
    let sensed = drive.events.first().and_then(|event| event.record.sensed);
    sensed.map_or(0.0, |sensed| f64::from(sensed.target_angle.0) / 1e6)
}

/// How many obstacles come within a side sensor's range of the straight line from start to target,
/// whatever way the robot took.
fn obstacles_on_the_way(drive: &Drive) -> usize {
    let scenario = &drive.scenario;
    let (Some(goal), [_, range]) = (scenario.goal, scenario.robot.range_cm(Side::Left)) else {
        return 0;
    };
    let (start, goal) = (scenario.start.position(), goal.position());
    let near = |obstacle: &&Obstacle| {
        let [low, high] = obstacle.bounds_cm();
        (0..=100)
            .map(|i| start + (goal - start) * (f64::from(i) / 100.0))
            .any(|point| {
                let nearest = point.max(low).min(high);
                nearest.distance(point) <= range
            })
    };
    scenario.world.obstacles().iter().filter(near).count()
}

/// What is worth showing of a test, chosen without regard to how well the robot did: of each
/// situation the first arena in which it occurs; then other arenas from the first on; and last the
/// arena with most obstacles along the straight way, which is the farthest one of several.
///
/// Drives from one place to another that is already shown are left out: a file can fix both.
pub(super) fn scenes(drives: &[Drive], follow_direction: bool) -> Vec<Scene<'_>> {
    let mut left: Vec<(usize, &Drive)> = Vec::new();
    for (i, drive) in (1..).zip(drives) {
        let ends = |drive: &Drive| (drive.scenario.start, drive.scenario.goal);
        if left.iter().all(|(_, other)| ends(other) != ends(drive)) {
            left.push((i, drive));
        }
    }
    let mut scenes = Vec::new();
    let scene = |what: &str, (i, drive)| Scene {
        title: format!("{what} (test arena {i})"),
        drive,
    };
    let mut last = None;
    if !follow_direction && left.len() > 1 {
        let fullest = (0..left.len()).rev().max_by(|a, b| {
            let [a, b] = [a, b].map(|i| {
                let drive = left[*i].1;
                (
                    obstacles_on_the_way(drive),
                    drive.scenario.straight_cm().unwrap_or(0.0),
                )
            });
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        last = fullest.map(|i| scene("Trained, most obstacles on the way", left.remove(i)));
        for situation in &SITUATIONS {
            if let Some(i) = left.iter().position(|(_, drive)| (situation.is_met)(drive)) {
                scenes.push(scene(
                    &format!("Trained, {}", situation.title),
                    left.remove(i),
                ));
            }
        }
    }
    let room = MOST_TRAINED - scenes.len() - usize::from(last.is_some());
    scenes.extend(
        left.into_iter()
            .take(room)
            .map(|numbered| scene("Trained", numbered)),
    );
    scenes.extend(last);
    scenes
}

/// How a drive went.
pub(super) fn outcome(drive: &Drive) -> String {
    let trial = &drive.trial;
    let blocked = drive
        .events
        .iter()
        .filter(|event| event.motion == Motion::Blocked)
        .count();
    let shown = drive.events.len();
    let mut text = if trial.steps as usize > shown {
        format!("first {shown} of {} actions", trial.steps)
    } else if drive.scenario.goal.is_none() {
        format!("{shown} actions")
    } else if trial.reached() {
        format!("reached in {shown} actions")
    } else {
        format!("not reached in {shown} actions")
    };
    if blocked > 0 {
        text += &format!(", {blocked} blocked");
    }
    if let (Some(directedness), true) = (trial.directedness, drive.scenario.goal.is_some()) {
        text += &format!(", directedness {directedness:.2}");
    }
    text
}

/// Whether an arena takes the width of two columns.
fn is_wide(drive: &Drive) -> bool {
    drive.scenario.world.width_cm() > 1.6 * drive.scenario.world.height_cm()
}

/// Draws scenes side by side, with a legend below.
pub(super) fn draw(scenes: &[Scene], palette: &Palette, title: &str, subtitle: &str) -> String {
    let mut parts = Vec::new();
    // Drives without a target have less to say above their panels.
    let narrow = scenes
        .iter()
        .all(|s| s.drive.scenario.goal.is_none() && !is_wide(s.drive));
    let columns = if narrow && scenes.len() > 2 { 3 } else { 2 };
    let width = (SHEET_WIDTH - 20.0) / columns as f64 - LEFT - 6.0;
    let mut top = HEADER;
    for (row, in_row) in scenes.chunks(columns).enumerate() {
        let mut height = 0.0f64;
        for (column, scene) in in_row.iter().enumerate() {
            let left = LEFT + (SHEET_WIDTH - 20.0) / columns as f64 * column as f64;
            let number = row * columns + column;
            let within = Area {
                left,
                top: top + ABOVE,
                width,
                height: MOST_HEIGHT,
            };
            let last_of_column = number + columns >= scenes.len();
            let labels = [last_of_column, column == 0];
            let view = View::new(&scene.drive.scenario.world, within);
            height = height.max(view.area.height);
            parts.push(panel(scene, number, &view, palette, labels));
        }
        top += ABOVE
            + height
            + if (row + 1) * columns >= scenes.len() {
                BELOW
            } else {
                22.0
            };
    }
    parts.push(legend(top + 12.0, palette, scenes));
    sheet(
        [SHEET_WIDTH, top + LEGEND_HEIGHT + 12.0],
        title,
        subtitle,
        parts,
    )
}

/// One scene with its axes.
fn panel(scene: &Scene, number: usize, view: &View, palette: &Palette, labels: [bool; 2]) -> Group {
    let letter = char::from(b'a' + number.min(25) as u8);
    let Area { left, top, .. } = view.area;
    let mut panel = group("panel");
    let heading = format!("({letter}) {}", scene.title);
    panel.append(text([left, top - 22.0], 13.0, heading).set("font-weight", "bold"));
    let below = text([left, top - 7.0], TEXT_SIZE, outcome(scene.drive));
    panel.append(below.set("fill", FAINT_INK));
    panel.append(view.arena(scene.drive));
    panel.append(view.path(scene.drive, palette));
    panel.append(view.marks(scene.drive));
    for axis in view.axes(&scene.drive.scenario.world, labels[0], labels[1]) {
        panel.append(axis);
    }
    panel
}

/// What colours and marks mean.
fn legend(top: f64, palette: &Palette, scenes: &[Scene]) -> Group {
    let drives: Vec<&Drive> = scenes.iter().map(|scene| scene.drive).collect();
    let mut legend = pattern_legend(LEFT, top, palette);
    legend.append(mark_legend([LEFT, top + 66.0], &drives));
    legend
}

/// The marks that occur in drives.
pub(super) fn mark_legend([left, y]: [f64; 2], drives: &[&Drive]) -> Group {
    let mut legend = group("legend");
    let mut x = left;
    let mut entry = |mark: &dyn Fn([f64; 2]) -> Group, width: f64, name: &str| {
        legend.append(mark([x + 8.0, y]));
        legend.append(text([x + 24.0, y + 4.0], TEXT_SIZE, name));
        x += width;
    };
    let shows = |found: fn(&Drive) -> bool| drives.iter().any(|drive| found(drive));
    let ahead = Microdegrees(0);
    entry(&|at| start_mark(at, ahead), 100.0, "start");
    let name = format!("heading, every {MARK_EVERY} actions");
    entry(
        &|at| group("mark").add(heading_mark(at, ahead)),
        230.0,
        &name,
    );
    if shows(|drive| drive.scenario.goal.is_some()) {
        entry(&|at| target(at, 8.0), 110.0, "target");
    }
    if shows(|drive| {
        drive
            .events
            .iter()
            .any(|event| event.motion == Motion::Blocked)
    }) {
        entry(
            &|at| group("mark").add(blocked_mark(at)),
            150.0,
            "move blocked",
        );
    }
    if shows(|drive| drive.scenario.goal.is_none()) {
        entry(
            &|[x, y]| direction_mark([x - 9.0, y], ahead),
            200.0,
            "new direction to follow",
        );
    }
    legend
}

/// The coloured patterns, each with its drawing, code and turn.
fn pattern_legend(left: f64, top: f64, palette: &Palette) -> Group {
    let mut legend = group("legend");
    let heading =
        "Colour of a move: the pattern that chose it, with its code and the turn it stands for";
    legend.append(text([left, top], TEXT_SIZE, heading));
    let mut x = left;
    for (used, colour) in palette.coloured() {
        legend.append(pattern([x, top + 12.0], 28.0, used.code, colour));
        legend.append(
            text([x + 36.0, top + 23.0], TEXT_SIZE, used.code.to_string())
                .set("font-weight", "bold"),
        );
        legend.append(text([x + 36.0, top + 38.0], TEXT_SIZE, used.turn()));
        x += 140.0;
    }
    let others = palette
        .ranked()
        .len()
        .saturating_sub(palette.coloured().count());
    if others > 0 {
        let y = top + 26.0;
        legend.append(Outline::through([[x, y], [x + 24.0, y]]).stroked(OTHERS, 3.0));
        legend.append(text([x + 32.0, y + 4.0], TEXT_SIZE, "all others"));
    }
    legend
}
