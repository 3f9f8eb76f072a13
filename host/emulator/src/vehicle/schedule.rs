//! When faults begin and end: `--fault AT[+FOR]:WHAT`.
//!
//! | part | is |
//! |---|---|
//! | `AT` | seconds since the board was switched on, such as `12` or `0.5`; `action N`: when the rover has done N actions; `flash N`: at the N-th flash operation (erase or program), from 1 |
//! | `FOR` | seconds after which the fault is over; without it, it stays |
//! | `WHAT` | a [`Fault`], its words separated by spaces or hyphens |
//!
//! For example `12:ir-front-left-open`, `"action 40+5:compass silent"`, `flash-3:power-cut`.

use std::fmt;
use std::str::FromStr;

use rover_shared::time::{Duration, Instant};
use thiserror::Error;

use super::fault::{Fault, UnknownFault};

/// How a fault is written, for help texts.
pub const GRAMMAR: &str = "AT[+FOR]:WHAT, where AT is seconds, \"action N\" or \"flash N\" (the \
    N-th flash operation), FOR is seconds after which the fault is over, and WHAT is a fault";

/// When a fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// At this time since the board was first switched on.
    Time(Instant),
    /// When so many actions are done.
    Action(u32),
    /// At this flash operation, erase or program, counted from 1: when it has begun, or for a power
    /// cut in the middle of it.
    FlashOperation(u32),
}

/// A fault, when it begins and how long it lasts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScheduledFault {
    /// When it begins.
    pub at: Moment,
    /// How long it lasts; `None` for good.
    pub lasts: Option<Duration>,
    /// What it is.
    pub fault: Fault,
}

/// Why a text is no [`ScheduledFault`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ScheduleError {
    /// There is no colon.
    #[error(
        "a fault is written {GRAMMAR}, such as 12:compass-silent; there is no colon in \"{0}\""
    )]
    NoColon(String),
    /// The moment cannot be parsed.
    #[error(
        "expected seconds (such as 12 or 0.5), \"action N\" or \"flash N\" with N from 1, not \
         \"{0}\""
    )]
    Moment(String),
    /// The duration cannot be parsed, or is out of range.
    #[error(
        "expected seconds that the fault lasts, more than 0 and at most {LONGEST_S}, not \"{0}\""
    )]
    Length(String),
    /// There is no such fault.
    #[error(transparent)]
    Fault(#[from] UnknownFault),
}

/// Longest time that can be written: some 31 years.
const LONGEST_S: u32 = 1_000_000_000;

impl FromStr for ScheduledFault {
    type Err = ScheduleError;

    fn from_str(text: &str) -> Result<Self, ScheduleError> {
        let (when, what) = text
            .split_once(':')
            .ok_or_else(|| ScheduleError::NoColon(text.to_owned()))?;
        let (at, lasts) = match when.split_once('+') {
            None => (when, None),
            Some((at, length)) => {
                let lasts = seconds(length).filter(|lasts| *lasts > Duration::ZERO);
                let length = || ScheduleError::Length(length.trim().to_owned());
                (at, Some(lasts.ok_or_else(length)?))
            }
        };
        let at = moment(at).ok_or_else(|| ScheduleError::Moment(at.trim().to_owned()))?;
        let fault = what.parse()?;
        Ok(Self { at, lasts, fault })
    }
}

fn moment(text: &str) -> Option<Moment> {
    let counted = |word: &str| {
        let rest = text.trim().strip_prefix(word)?;
        let number = rest.strip_prefix('-').unwrap_or(rest.trim_start());
        number.parse::<u32>().ok()
    };
    if let Some(n) = counted("action") {
        return Some(Moment::Action(n));
    }
    if let Some(n) = counted("flash") {
        return (n > 0).then_some(Moment::FlashOperation(n));
    }
    let since = seconds(text)?;
    Some(Moment::Time(Instant(0).after(since)))
}

fn seconds(text: &str) -> Option<Duration> {
    let number = text.trim().trim_end_matches('s');
    let seconds: f64 = number.parse().ok()?;
    let allowed = (0.0..=f64::from(LONGEST_S)).contains(&seconds);
    allowed.then(|| Duration((seconds * 1e6).round() as u64))
}

impl fmt::Display for ScheduledFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = |us: u64| us as f64 / 1e6;
        match self.at {
            Moment::Time(Instant(us)) => write!(f, "{}", seconds(us))?,
            Moment::Action(n) => write!(f, "action {n}")?,
            Moment::FlashOperation(n) => write!(f, "flash {n}")?,
        }
        if let Some(Duration(us)) = self.lasts {
            write!(f, "+{}", seconds(us))?;
        }
        write!(f, ":{}", self.fault)
    }
}

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct RunProgress {
    /// Time since the board was first switched on; resets do not set it back.
    pub time: Instant,
    /// Actions done.
    pub actions: u32,
    /// Flash operations begun.
    pub flash_operations: u32,
}

/// The faults of a run.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    waiting: Vec<ScheduledFault>,
    /// Those that last, and until when.
    active: Vec<(Fault, Option<Instant>)>,
}

/// What changed at an update.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Changes {
    /// These began, with the time that was given for them. Momentary ones are only here, and never
    /// among the active.
    pub began: Vec<(Fault, Option<Duration>)>,
    /// These are over.
    pub ended: Vec<Fault>,
}

impl Changes {
    /// Whether nothing changed.
    pub fn is_empty(&self) -> bool {
        self.began.is_empty() && self.ended.is_empty()
    }
}

impl Schedule {
    /// A run with these faults, all still to come.
    pub fn new(faults: Vec<ScheduledFault>) -> Self {
        Self {
            waiting: faults,
            active: Vec::new(),
        }
    }

    /// Adds faults to those still to come.
    pub fn extend(&mut self, faults: &[ScheduledFault]) {
        self.waiting.extend_from_slice(faults);
    }

    /// Removes the power cuts in the middle of a flash operation, whose moment only the flash
    /// itself knows, and returns them: the operation's number from 1, and for how long.
    pub fn take_cuts_of_operations(&mut self) -> Vec<(u32, Option<Duration>)> {
        let mut taken = Vec::new();
        self.waiting.retain(|next| match (next.fault, next.at) {
            (Fault::PowerCut, Moment::FlashOperation(n)) => {
                taken.push((n, next.lasts));
                false
            }
            _ => true,
        });
        taken
    }

    /// Those still to come.
    pub fn waiting(&self) -> &[ScheduledFault] {
        &self.waiting
    }

    /// The faults that last at this moment.
    pub fn active(&self) -> Vec<Fault> {
        self.active.iter().map(|(fault, _)| *fault).collect()
    }

    /// Begins and ends what is due now that the run has come this far; returns what did.
    pub fn update(&mut self, progress: &RunProgress) -> Changes {
        let mut changes = Changes::default();
        let Self { waiting, active } = self;
        if waiting.is_empty() && active.is_empty() {
            return changes;
        }
        active.retain(|&(fault, until)| {
            let over = until.is_some_and(|until| progress.time >= until);
            if over {
                changes.ended.push(fault);
            }
            !over
        });
        waiting.retain(|next| {
            let due = match next.at {
                Moment::Time(time) => progress.time >= time,
                Moment::Action(n) => progress.actions >= n,
                Moment::FlashOperation(n) => progress.flash_operations >= n,
            };
            if due {
                changes.began.push((next.fault, next.lasts));
                if !next.fault.momentary() {
                    let until = next.lasts.map(|lasts| progress.time.after(lasts));
                    active.push((next.fault, until));
                }
            }
            !due
        });
        changes
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::fault::{Channel, Side};
    use super::*;

    fn parsed(text: &str) -> ScheduledFault {
        text.parse().expect(text)
    }

    #[test]
    fn the_grammar_is_as_documented() {
        assert_eq!(
            parsed("12:ir-front-left-open"),
            ScheduledFault {
                at: Moment::Time(Instant(12_000_000)),
                lasts: None,
                fault: Fault::IrOpen(Channel::FrontLeft),
            }
        );
        assert_eq!(
            parsed(" action 40 + 5 : compass silent"),
            ScheduledFault {
                at: Moment::Action(40),
                lasts: Some(Duration(5_000_000)),
                fault: Fault::CompassSilent,
            }
        );
        assert_eq!(parsed("flash-3:power-cut").at, Moment::FlashOperation(3));
        assert_eq!(
            parsed("0.25s+1.5s:motor both dead").lasts,
            Some(Duration(1_500_000))
        );
    }

    #[test]
    fn errors_say_what_was_expected() {
        let error = |text: &str| text.parse::<ScheduledFault>().expect_err(text).to_string();
        assert!(error("compass silent").contains("AT[+FOR]:WHAT"));
        for moment in [
            "",
            "x",
            "-1",
            "NaN",
            "inf",
            "action",
            "action -1",
            "flash 0",
            "1e30",
        ] {
            let error = error(&format!("{moment}:power cut"));
            assert!(
                error.contains("expected seconds") && error.contains("action N"),
                "{error}"
            );
        }
        for length in ["", "0", "-2", "long"] {
            let error = error(&format!("1+{length}:power cut"));
            assert!(error.contains("lasts"), "{error}");
        }
        assert!(error("1:fire").contains("there is no fault \"fire\"; possible are"));
    }

    #[test]
    fn faults_begin_when_they_are_due_and_end_when_their_time_is_over() {
        let slipping = Fault::WheelsSlipping(Side::Both);
        let mut schedule = Schedule::new(vec![
            parsed("2+3:compass silent"),
            parsed("action 4:wheels both slipping"),
            parsed("flash 2+9:flash slow"),
            parsed("flash 3+8:power cut"),
        ]);
        let eight = Some(Duration(8_000_000));
        assert_eq!(schedule.take_cuts_of_operations(), [(3, eight)]);
        let mut progress = RunProgress::default();
        assert!(schedule.update(&progress).is_empty());
        progress.time = Instant(2_000_000);
        let silent = Fault::CompassSilent;
        assert_eq!(
            schedule.update(&progress).began,
            [(silent, Some(Duration(3_000_000)))]
        );
        assert!(schedule.update(&progress).is_empty());
        progress.actions = 4;
        assert_eq!(schedule.update(&progress).began, [(slipping, None)]);
        assert_eq!(schedule.active(), [silent, slipping]);
        progress.time = Instant(5_000_000);
        assert_eq!(schedule.update(&progress).ended, [silent]);
        progress.flash_operations = 2;
        assert_eq!(
            schedule.update(&progress).began,
            [(Fault::FlashSlow, Some(Duration(9_000_000)))]
        );
        progress.time = Instant(14_000_000);
        assert_eq!(schedule.update(&progress).ended, [Fault::FlashSlow]);
        assert_eq!(schedule.active(), [slipping]);
        assert_eq!(schedule.waiting(), []);
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(
            at in 0u64..10_000_000_000, lasts in prop::option::of(1u64..10_000_000_000),
            kind in 0..3, fault in prop::sample::select(Fault::all()),
        ) {
            let n = (at % 1_000) as u32;
            let at = match kind {
                0 => Moment::Time(Instant(at)),
                1 => Moment::Action(n),
                _ => Moment::FlashOperation(n + 1),
            };
            let fault = ScheduledFault { at, lasts: lasts.map(Duration), fault };
            prop_assert_eq!(fault.to_string().parse(), Ok(fault));
        }

        #[test]
        fn nothing_that_is_written_makes_it_panic(text in "\\PC{0,40}") {
            let _ = text.parse::<ScheduledFault>();
        }
    }
}
