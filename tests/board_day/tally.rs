//! What a host hears of a drive, counted.

use std::collections::BTreeMap;
use std::fmt;

use rover_emulator::Emulation;
use rover_shared::contract::{Counters, Fault, Outcome, State};
use rover_shared::rover::PERIOD;
use rover_shared::wire::message::{ActionRecord, EventKind, Report, Status};
use rover_simulator::arena::Pose;

/// All that was heard so far.
pub struct Tally {
    /// What the rover said of its state.
    pub state: State,
    /// How often it was armed again after it had disarmed itself.
    pub armed_again: u32,
    /// Hellos that nobody asked for.
    pub hellos: u32,
    actions: u32,
    outcomes: BTreeMap<String, u32>,
    unsettled: u32,
    faults: Counters,
    last: Option<(ActionRecord, Pose)>,
    /// Of completed moves: what was wanted and how far the rover came, in centimetres.
    wanted_cm: f64,
    came_cm: f64,
    /// When in its period the first sample was taken, in microseconds.
    phase_us: Option<u64>,
    /// By how much samples were away from that, at most: in this part, and in all before.
    off_us: u64,
    most_off_us: u64,
}

impl Tally {
    /// A drive that begins in this state.
    pub fn new(before: &Status) -> Self {
        Self {
            state: before.state,
            armed_again: 0,
            hellos: 0,
            actions: 0,
            outcomes: BTreeMap::new(),
            unsettled: 0,
            faults: before.counters,
            last: None,
            wanted_cm: 0.0,
            came_cm: 0.0,
            phase_us: None,
            off_us: 0,
            most_off_us: 0,
        }
    }

    /// Counts a report.
    pub fn hear(&mut self, report: &Report, rover: &Emulation) {
        match report {
            Report::Hello(_) => self.hellos += 1,
            Report::Fault(fault) => self.faults.0[fault.fault as usize] = fault.count,
            Report::Event(event) => {
                if let EventKind::State(state) = event.kind {
                    self.state = state;
                }
            }
            Report::Action(action) => self.act(action, rover),
            _ => {}
        }
    }

    fn act(&mut self, action: &ActionRecord, rover: &Emulation) {
        self.actions += 1;
        let outcome = format!("{:?}", action.outcome);
        *self.outcomes.entry(outcome).or_default() += 1;
        self.unsettled += u32::from(action.step.unsettled());
        let phase = action.time.0 % PERIOD.0;
        let off = phase.abs_diff(*self.phase_us.get_or_insert(phase));
        self.off_us = self.off_us.max(off.min(PERIOD.0 - off));
        let pose = rover.pose_at(action.time).expect("seconds ago");
        if let Some((before, from)) = self.last.replace((*action, pose)) {
            assert_eq!(
                action.step.step,
                before.step.step + 1,
                "an action is missing"
            );
            if before.outcome == Outcome::Completed {
                self.wanted_cm += f64::from(before.step.action.module.0) / 1e4;
                self.came_cm += pose.position().distance(from.position());
            }
        }
    }

    /// A new part of the drive begins.
    pub fn next_part(&mut self) {
        self.most_off_us = self.latest_sample_us();
        self.off_us = 0;
    }

    /// The largest distance of a sample's time from the grid of 20 ms that the first one began.
    pub fn latest_sample_us(&self) -> u64 {
        self.most_off_us.max(self.off_us)
    }

    fn ended(&self, outcome: Outcome) -> u32 {
        let outcome = format!("{outcome:?}");
        self.outcomes.get(&outcome).copied().unwrap_or(0)
    }

    /// Holds all that was heard against what the rover says in the end.
    pub fn check(&self, before: &Status, after: &Status) {
        assert_eq!(after.steps - before.steps, self.actions);
        assert_eq!(after.counters, self.faults);
        let counted = |fault| after.counters.of(fault) - before.counters.of(fault);
        assert_eq!(counted(Fault::Blocked), self.ended(Outcome::Obstacle));
        assert_eq!(counted(Fault::NoProgress), self.ended(Outcome::NoProgress));
        assert_eq!(
            counted(Fault::TurnTimeout),
            self.ended(Outcome::TurnTimeout)
        );
        assert_eq!(counted(Fault::Unsettled), self.unsettled);
        assert_eq!(counted(Fault::Stuck), self.armed_again);
        // Nothing else goes wrong in a day.
        use Fault::{Blocked, NoProgress, Stuck, TurnTimeout, Unsettled};
        let expected = [Blocked, NoProgress, Stuck, TurnTimeout, Unsettled];
        for fault in Fault::ALL {
            assert!(
                expected.contains(&fault) || counted(fault) == 0,
                "{fault:?}"
            );
        }
        let ratio = self.came_cm / self.wanted_cm;
        assert!((0.9..1.1).contains(&ratio), "{ratio} of the way");
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} actions {:?}, {:.0} of {:.0} m, samples off by {} us at most, armed again {} times",
            self.actions,
            self.outcomes,
            self.came_cm / 100.0,
            self.wanted_cm / 100.0,
            self.off_us,
            self.armed_again
        )
    }
}
