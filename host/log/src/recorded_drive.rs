//! A recorded drive, sample by sample through sensing, perception and action, and what to say
//! about it.

use std::collections::BTreeMap;
use std::fmt;

use rover_shared::controller::{Controller, StepRecord};
use rover_shared::learning::Mode;
use rover_shared::learning::paper_rule::PaperRule;
use rover_shared::perception::PatternCode;
use rover_shared::random::Generator;
use rover_shared::reward::FollowDirection;
use rover_shared::sensing::neuron::StepIndex;
use rover_shared::units::Microdegrees;
use serde::Serialize;

use crate::knowledge::Loaded;
use crate::results::{drawing, time_units};
use crate::table::{Drive, Row};

/// What was made of a drive.
#[derive(Clone, Debug, Serialize)]
pub struct DriveReport {
    /// Each sample.
    #[serde(skip)]
    pub samples: Vec<SampleReport>,
    /// How many samples there were.
    pub sample_count: usize,
    /// On how many of them the network did not settle.
    pub unsettled: usize,
    /// Each code met, the most frequent first.
    pub codes: Vec<CodeReport>,
    /// Share of neighbouring samples with different codes.
    pub flicker: f64,
    /// Share of neighbouring samples with different codes although all four stimuli stayed within
    /// their steps: what the noise of layer 2 alone decided.
    pub flicker_within_steps: f64,
    /// Codes met that the knowledge has no action for.
    pub unseen_codes: usize,
    /// Samples on which one of those arose.
    pub unseen_samples: usize,
    /// Mean settling time, in the network's time units.
    pub mean_settle_time: f64,
    /// Whether the drive has headings; without them the robot counts as pointing where it should.
    pub has_heading: bool,
}

/// One sample.
#[derive(Clone, Debug, Serialize)]
pub struct SampleReport {
    /// Seconds.
    pub t_s: f64,
    /// Steps of the sensing neurons, 0 to 9.
    pub front_step: usize,
    /// Of the left sensor.
    pub left_step: usize,
    /// Of the right sensor.
    pub right_step: usize,
    /// Of the angle to the direction to follow.
    pub target_step: usize,
    /// The pattern's code; empty if the network did not settle.
    pub code: Option<u16>,
    /// Settling time, in the network's time units.
    pub settle_time: Option<f64>,
    /// Whether the knowledge had an action for the pattern.
    pub seen: bool,
    /// The action's turn, positive to the left.
    pub phase_deg: f64,
}

/// One code.
#[derive(Clone, Debug, Serialize)]
pub struct CodeReport {
    /// The code.
    pub code: u16,
    /// Samples on which it arose.
    pub count: usize,
    /// Share of all samples.
    pub share: f64,
    /// The action's turn, positive to the left.
    pub phase_deg: f64,
    /// Whether the knowledge had an action for it; otherwise its turn is drawn by chance.
    pub seen: bool,
}

/// Runs a drive through the core, which learns nothing from it: what would it have done?
pub fn drive(drive: &Drive, loaded: &Loaded, direction: Microdegrees, seed: u64) -> DriveReport {
    let mut known = loaded.known.clone();
    let rng = Generator::new(seed);
    let mut controller =
        Controller::new(&loaded.coefficients, PaperRule, &mut known, rng, Mode::Run);
    let mut samples = Vec::with_capacity(drive.rows.len());
    for row in &drive.rows {
        // Without headings, the robot counts as pointing where it should.
        let wanted = if drive.has_heading {
            direction
        } else {
            row.sample.heading
        };
        let record = controller.step(&row.sample, &FollowDirection(wanted));
        let known_before = |code| loaded.known.patterns.get(code).is_some();
        samples.push(SampleReport::new(row, &record, known_before));
    }
    DriveReport::new(samples, drive.has_heading)
}

impl SampleReport {
    fn new(row: &Row, record: &StepRecord, seen: impl Fn(PatternCode) -> bool) -> Self {
        let steps = record
            .sensed
            .map_or([StepIndex::saturating(0); 4], |s| s.percept.steps());
        let [front_step, left_step, right_step, target_step] = steps.map(StepIndex::index);
        Self {
            t_s: row.t_s,
            front_step,
            left_step,
            right_step,
            target_step,
            code: record.perceived.map(|perceived| perceived.code.0),
            settle_time: record.perceived.map(|p| time_units(p.settle_time)),
            seen: record
                .perceived
                .is_some_and(|perceived| seen(perceived.code)),
            phase_deg: f64::from(record.action.phase.0) / 1e6,
        }
    }

    fn steps(&self) -> [usize; 4] {
        [
            self.front_step,
            self.left_step,
            self.right_step,
            self.target_step,
        ]
    }
}

impl DriveReport {
    fn new(samples: Vec<SampleReport>, has_heading: bool) -> Self {
        let count = samples.len();
        let share = |n: usize, of: usize| if of == 0 { 0.0 } else { n as f64 / of as f64 };
        let pairs = || samples.windows(2).map(|pair| (&pair[0], &pair[1]));
        let changes = pairs().filter(|(a, b)| a.code != b.code).count();
        let alike = pairs().filter(|(a, b)| a.steps() == b.steps());
        let (within, unchanged) = alike.fold((0, 0), |(n, m), (a, b)| {
            (n + usize::from(a.code != b.code), m + 1)
        });
        let times: Vec<f64> = samples
            .iter()
            .filter_map(|sample| sample.settle_time)
            .collect();
        let codes = count_codes(&samples);
        Self {
            sample_count: count,
            unsettled: samples
                .iter()
                .filter(|sample| sample.code.is_none())
                .count(),
            flicker: share(changes, count.saturating_sub(1)),
            flicker_within_steps: share(within, unchanged),
            unseen_codes: codes.iter().filter(|code| !code.seen).count(),
            unseen_samples: codes.iter().filter(|c| !c.seen).map(|c| c.count).sum(),
            mean_settle_time: times.iter().sum::<f64>() / times.len().max(1) as f64,
            codes,
            has_heading,
            samples,
        }
    }
}

fn count_codes(samples: &[SampleReport]) -> Vec<CodeReport> {
    let mut codes: BTreeMap<u16, CodeReport> = BTreeMap::new();
    for sample in samples {
        if let Some(code) = sample.code {
            let (phase_deg, seen) = (sample.phase_deg, sample.seen);
            let fresh = CodeReport {
                code,
                count: 0,
                share: 0.0,
                phase_deg,
                seen,
            };
            codes.entry(code).or_insert(fresh).count += 1;
        }
    }
    let mut codes: Vec<_> = codes.into_values().collect();
    for code in &mut codes {
        code.share = code.count as f64 / samples.len() as f64;
    }
    codes.sort_by_key(|code| (std::cmp::Reverse(code.count), code.code));
    codes
}

/// Codes that are drawn; the rest are summed up.
const DRAWN: usize = 12;

impl fmt::Display for DriveReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} samples, {} different patterns",
            self.sample_count,
            self.codes.len()
        )?;
        if !self.has_heading {
            writeln!(
                f,
                "no headings: the robot counts as pointing where it should"
            )?;
        }
        writeln!(f, "\npattern    code  samples   share  turn (deg, + left)")?;
        for code in self.codes.iter().take(DRAWN) {
            let [a, b, c, d] = drawing(PatternCode(code.code));
            let unseen = if code.seen { "" } else { "  never learned" };
            writeln!(f, "{a}")?;
            writeln!(
                f,
                "{b}  {:>5}  {:>7}  {:>5.1}%  {:>+10.1}{unseen}",
                code.code,
                code.count,
                100.0 * code.share,
                code.phase_deg
            )?;
            writeln!(f, "{c}\n{d}\n")?;
        }
        if let Some(rest) = self.codes.get(DRAWN..).filter(|rest| !rest.is_empty()) {
            let samples: usize = rest.iter().map(|code| code.count).sum();
            writeln!(
                f,
                "and {} more patterns on {samples} samples (see --json)\n",
                rest.len()
            )?;
        }
        writeln!(
            f,
            "between neighbouring samples the pattern changes {:.1} % of the time,\n\
             {:.1} % where no stimulus left its step (noise alone)",
            100.0 * self.flicker,
            100.0 * self.flicker_within_steps
        )?;
        writeln!(
            f,
            "{} patterns on {} samples were never learned; {} samples did not settle",
            self.unseen_codes, self.unseen_samples, self.unsettled
        )?;
        writeln!(f, "mean settling time {:.1}", self.mean_settle_time)
    }
}
