//! The supervisor as the rover sees it.

use crate::contract::{Counters, FaultReport, Mode, Refusal, ResetReason, State};
use crate::supervisor::{Input, Supervisor};
use crate::time::Instant;

/// The supervisor's outputs at one moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Its state.
    pub state: State,
    /// Whether the motors may run.
    pub motors_enabled: bool,
    /// How often each fault was counted.
    pub counters: Counters,
    /// Why the board last started.
    pub reset: ResetReason,
}

/// Access to the supervisor, which may be shared with interrupts.
pub trait Supervision {
    /// Passes an input to the supervisor.
    ///
    /// # Errors
    /// The request is refused, with the reason.
    fn handle(&mut self, input: Input) -> Result<(), Refusal>;

    /// Returns its outputs now.
    fn view(&mut self) -> View;

    /// Returns the next fault to report.
    fn take_fault(&mut self) -> Option<FaultReport>;
}

/// A supervisor that is not shared, and the present time.
impl Supervision for (Instant, &mut Supervisor) {
    fn handle(&mut self, input: Input) -> Result<(), Refusal> {
        self.1.handle(self.0, input)
    }

    fn view(&mut self) -> View {
        self.1.poll(self.0);
        View {
            state: self.1.state(),
            motors_enabled: self.1.motors_enabled(),
            counters: *self.1.counters(),
            reset: self.1.reset_reason(),
        }
    }

    fn take_fault(&mut self) -> Option<FaultReport> {
        self.1.take_fault()
    }
}

/// Refuses while the motors may be armed.
pub(super) fn must_be_disarmed(watch: &mut impl Supervision) -> Result<(), Refusal> {
    match watch.view().state {
        State::Disarmed | State::Faulted(_) => Ok(()),
        State::Armed | State::Driving(_) => Err(Refusal::Armed),
    }
}

/// Refuses while the controller drives: then its knowledge and seed must not be touched.
pub(super) fn must_not_drive(watch: &mut impl Supervision) -> Result<(), Refusal> {
    match watch.view().state {
        State::Driving(Mode::Learn | Mode::Run) => Err(Refusal::Armed),
        _ => Ok(()),
    }
}
