//! Which drives are worth showing: the situations of the paper's tests, told from what the robot
//! met, and chosen without regard to how well it did.

use std::ops::Range;

use super::drive::Drive;
use rover_simulator::arena::{Motion, Obstacle, Side};

/// Of a drive to a target this much is shown: all that the paper allows (III-B).
pub(super) const SHOWN_AIMING: usize = 500;
/// Of a drive that follows directions, which has no end, less: it would cover the arena.
pub(super) const SHOWN_FOLLOWING: usize = 150;
/// Scenes besides the first trial.
const MOST: usize = 5;

/// A drive and what it shows.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    pub title: String,
    /// Which drive it is: "arena 4".
    pub place: String,
    pub drive: Drive,
}

impl Scene {
    /// Which drive it is, and how it went.
    pub fn outcome(&self) -> String {
        format!("{}: {}", self.place, outcome(&self.drive))
    }
}

pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

/// What the drives have in common, for titles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting {
    /// How far learning was: "Trained", "Late in learning"; nothing if that is not known.
    pub state: &'static str,
    /// What a drive is called: "arena", "trial".
    pub unit: &'static str,
    /// Whether directions are followed.
    pub follow_direction: bool,
}

impl Setting {
    /// A scene of a drive.
    pub fn scene(&self, situation: &str, drive: Drive) -> Scene {
        let parts = [self.state, situation];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        let title = match parts.as_slice() {
            [] => capitalised(self.unit),
            parts => capitalised(&parts.join(", ")),
        };
        Scene {
            title,
            place: format!("{} {}", self.unit, drive.number),
            drive,
        }
    }

    /// Of a drive, what is shown.
    pub fn shown(&self, drive: &Drive) -> Drive {
        drive.clone().first(if self.follow_direction {
            SHOWN_FOLLOWING
        } else {
            SHOWN_AIMING
        })
    }

    /// What is worth showing: of each situation the first drive in which it occurs; then others
    /// from the first on; and last the drive that met most.
    pub fn scenes(&self, drives: &[Drive]) -> Vec<Scene> {
        if self.follow_direction {
            self.following(drives)
        } else {
            self.aiming(drives)
        }
    }

    /// Drives to a target. Drives from one place to another that is already shown are left out: a
    /// file can fix both.
    fn aiming(&self, drives: &[Drive]) -> Vec<Scene> {
        let mut left: Vec<Drive> = Vec::new();
        for drive in drives {
            let ends = |drive: &Drive| (drive.scenario.start, drive.scenario.goal);
            if left.iter().all(|other| ends(other) != ends(drive)) {
                left.push(self.shown(drive));
            }
        }
        let mut scenes = Vec::new();
        let mut last = None;
        if left.len() > 1 && left.iter().any(|drive| drive.scenario.goal.is_some()) {
            let fullest = (0..left.len()).rev().max_by(|a, b| {
                let [a, b] = [a, b].map(|i| {
                    let drive = &left[*i];
                    let straight = drive.scenario.straight_cm().unwrap_or(0.0);
                    (obstacles_on_the_way(drive), straight)
                });
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            last = fullest.map(|i| self.scene("most obstacles on the way", left.remove(i)));
            for situation in &SITUATIONS {
                if let Some(i) = left.iter().position(situation.is_met) {
                    scenes.push(self.scene(situation.title, left.remove(i)));
                }
            }
        }
        let room = MOST - scenes.len() - usize::from(last.is_some());
        let others = left.into_iter().take(room);
        scenes.extend(others.map(|drive| self.scene("", drive)));
        scenes.extend(last);
        scenes
    }

    /// Drives along directions.
    fn following(&self, drives: &[Drive]) -> Vec<Scene> {
        let mut left: Vec<&Drive> = drives.iter().collect();
        let mut scenes = Vec::new();
        let mut last = None;
        if left.len() > 1 {
            let met = |drive: &Drive| meetings(&self.shown(drive));
            // Of equals the first.
            let fullest = (0..left.len()).rev().max_by_key(|i| met(left[*i]));
            last = fullest.map(|i| self.scene("most encounters", self.shown(left.remove(i))));
            let stretches: [(&str, FindStretch); 2] = [
                ("a new direction", new_direction),
                ("obstacle in front", obstacle_in_front),
            ];
            for (title, find) in stretches {
                let found = (0..left.len()).find_map(|i| Some((i, find(left[i])?)));
                if let Some((i, actions)) = found {
                    let stretch = left.remove(i).stretch(actions);
                    scenes.push(self.scene(title, stretch));
                }
            }
        }
        let room = MOST - scenes.len() - usize::from(last.is_some());
        let others = left.into_iter().take(room);
        scenes.extend(others.map(|drive| self.scene("", self.shown(drive))));
        scenes.extend(last);
        scenes
    }
}

/// Finds the actions of a drive in which a situation occurs.
type FindStretch = fn(&Drive) -> Option<Range<usize>>;

/// A situation of the paper's tests (III-C).
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

const ALL_SIDES: [Side; 3] = [Side::Front, Side::Left, Side::Right];

/// Actions before which a sensor on one of these sides saw something.
fn seen(drive: &Drive, sides: &[Side]) -> usize {
    let events = drive.events.iter();
    let saw = |event: &&_| sides.iter().any(|side| drive.saw(event, *side));
    events.filter(saw).count()
}

/// Actions before which any sensor saw something.
fn encounters(drive: &Drive) -> usize {
    seen(drive, &ALL_SIDES)
}

/// How often something came into sight of a sensor that saw nothing before. A robot that is stuck
/// has few.
fn meetings(drive: &Drive) -> usize {
    let saw = |i: usize, side| drive.saw(&drive.events[i], side);
    let comes = |(i, side): &(usize, Side)| saw(*i, *side) && !saw(*i - 1, *side);
    let all = (1..drive.events.len()).flat_map(|i| ALL_SIDES.map(|side| (i, side)));
    all.filter(comes).count()
}

/// Whether nothing is in sight at the start, but something will be in the way that is not a wall.
fn begins_free(drive: &Drive) -> bool {
    is_free(drive, 0) && obstacles_on_the_way(drive) > 0
}

/// Whether there is an action with this number, before which nothing was in sight.
fn is_free(drive: &Drive, action: usize) -> bool {
    let event = drive.events.get(action);
    event.is_some_and(|event| !ALL_SIDES.iter().any(|side| drive.saw(event, *side)))
}

/// The angle to the target or the direction, positive on the left; 0 if it was not known.
fn angle_deg(drive: &Drive, action: usize) -> f64 {
    let sensed = drive
        .events
        .get(action)
        .and_then(|event| event.record.sensed);
    sensed.map_or(0.0, |sensed| f64::from(sensed.target_angle.0) / 1e6)
}

fn start_angle_deg(drive: &Drive) -> f64 {
    angle_deg(drive, 0)
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

/// The actions from one change of direction to the next.
fn legs(drive: &Drive) -> Vec<Range<usize>> {
    let changes = drive.events.iter().enumerate();
    let mut starts: Vec<usize> = changes
        .filter(|(i, event)| *i == 0 || event.interrupted)
        .map(|(i, _)| i)
        .collect();
    starts.push(drive.events.len());
    starts.windows(2).map(|ends| ends[0]..ends[1]).collect()
}

/// Most actions of a stretch.
const STRETCH: usize = 60;

/// Fig. 12: the direction lies 60 to 110 degrees aside, nothing is in sight, and later a side
/// sensor sees something.
fn new_direction(drive: &Drive) -> Option<Range<usize>> {
    legs(drive).into_iter().find_map(|leg| {
        let aside = (60.0..=110.0).contains(&angle_deg(drive, leg.start).abs());
        let end = leg.end.min(leg.start + STRETCH);
        let beside = |i: &usize| {
            let event = &drive.events[*i];
            [Side::Left, Side::Right]
                .iter()
                .any(|side| drive.saw(event, *side))
        };
        let met = (leg.start..end).find(beside)?;
        (aside && is_free(drive, leg.start) && met > leg.start + 5).then_some(leg.start..end)
    })
}

/// Fig. 13: on its direction, the robot comes upon something ahead.
fn obstacle_in_front(drive: &Drive) -> Option<Range<usize>> {
    /// Actions shown before the encounter, and least after it.
    const AROUND: usize = 10;
    legs(drive).into_iter().find_map(|leg| {
        let ahead = |i: &usize| drive.saw(&drive.events[*i], Side::Front);
        let met = leg.clone().find(ahead)?;
        let on_direction = angle_deg(drive, met).abs() < 25.0;
        let (before, after) = (met - leg.start, leg.end - met);
        (on_direction && before >= AROUND && after >= AROUND)
            .then(|| met - AROUND..leg.end.min(met + STRETCH - AROUND))
    })
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
    let mut text = if drive.from > 0 {
        let last = drive.from + shown;
        format!("actions {} to {last} of {}", drive.from + 1, trial.steps)
    } else if trial.steps as usize > shown {
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
