//! Loading and saving knowledge: flash and host.

use super::Rover;
use super::rule::{RoverKnowledge, Rule};
use super::state::Save;
use super::supervision::{Supervision, must_be_disarmed, must_not_drive};
use crate::contract::{Refusal, State};
use crate::parameters::Parameters;
use crate::supervisor::Input;
use crate::time::Instant;
use crate::wire::message::{Chunk, Event, EventKind, Report};

impl Rover<'_> {
    /// Loads stored knowledge: `fill` copies it into the buffer and returns its length, or `None`.
    /// [`announce`](Self::announce) it to the supervisor afterwards.
    ///
    /// # Errors
    /// [`Refusal::BadKnowledge`]; the rover is left without usable knowledge.
    pub fn load(&mut self, fill: impl FnOnce(&mut [u8]) -> Option<usize>) -> Result<(), Refusal> {
        self.valid = false;
        let length = fill(self.staging.room());
        let bytes = length.and_then(|length| self.staging.room().get(..length));
        if let Some(bytes) = bytes
            && usable(bytes, self.coefficients.parameters())
        {
            let read = self.controller.knowledge_mut().read::<Rule>(bytes);
            self.valid = read.is_ok();
        }
        if self.valid {
            Ok(())
        } else {
            Err(Refusal::BadKnowledge)
        }
    }

    /// Starts with untrained knowledge. [`announce`](Self::announce) it to the supervisor
    /// afterwards.
    pub fn begin(&mut self) {
        self.controller
            .knowledge_mut()
            .begin(&self.coefficients.learning);
        self.staging.changed();
        self.valid = true;
        // Not worth a write: the flash keeps its content until something is learned.
        self.saving.knowledge = false;
    }

    /// Restores stored calibrations; false, and nothing changed, if the bytes are none.
    pub fn restore_calibrations(&mut self, bytes: &[u8]) -> bool {
        let restored = self.calibrations.restore(bytes);
        self.adjust_motion();
        restored
    }

    /// Returns what is to be written to the flash now, if anything, with the supervisor's
    /// permission. The caller reports the end of the write with [`saved`](Self::saved).
    pub fn take_save(&mut self, watch: &mut impl Supervision) -> Option<Save> {
        if self.saving.granted.is_none() && watch.view().state == State::Disarmed {
            let wanted = if self.saving.calibrations {
                Save::Calibrations
            } else if self.saving.knowledge && self.valid {
                Save::Knowledge
            } else {
                return None;
            };
            watch.handle(Input::FlashWrite).ok()?;
            self.saving.granted = Some(wanted);
        }
        match self.saving.granted? {
            Save::Knowledge => {
                self.saving.knowledge = false;
                self.current();
            }
            Save::Calibrations => self.saving.calibrations = false,
        }
        self.saving.granted
    }

    /// Ends a write. `fingerprint`: of the flash's content; `None` if the write failed.
    pub fn saved(
        &mut self,
        now: Instant,
        fingerprint: Option<u32>,
        watch: &mut impl Supervision,
    ) -> Option<Report> {
        // Never refused.
        let written = fingerprint.is_some();
        let _ = watch.handle(Input::FlashDone { written });
        let saved = self.saving.granted.take()?;
        let kind = EventKind::KnowledgeStored {
            fingerprint: fingerprint?,
        };
        (saved == Save::Knowledge).then_some(Report::Event(Event { time: now, kind }))
    }

    /// Returns the knowledge in use as bytes, between [`take_save`](Self::take_save) and
    /// [`saved`](Self::saved).
    pub fn knowledge_bytes(&self) -> &[u8] {
        self.staging.staged()
    }

    pub(super) fn current(&mut self) -> (&[u8], u32) {
        self.staging
            .current(self.controller.knowledge(), self.coefficients.parameters())
    }

    pub(super) fn pull(
        &mut self,
        offset: u32,
        watch: &mut impl Supervision,
    ) -> Result<Report, Refusal> {
        if !self.valid {
            return Err(Refusal::KnowledgeInvalid);
        }
        must_not_drive(watch)?;
        let parameters = self.coefficients.parameters();
        let chunk = self
            .staging
            .chunk(self.controller.knowledge(), parameters, offset)?;
        Ok(Report::Knowledge(chunk))
    }

    pub(super) fn push(
        &mut self,
        chunk: &Chunk,
        watch: &mut impl Supervision,
    ) -> Result<(), Refusal> {
        must_be_disarmed(watch)?;
        self.must_not_save()?;
        let Some(bytes) = self.staging.accept(chunk)? else {
            return Ok(());
        };
        if !usable(bytes, self.coefficients.parameters()) {
            return Err(Refusal::BadKnowledge);
        }
        let read = self.controller.knowledge_mut().read::<Rule>(bytes);
        self.staging.received();
        self.valid = read.is_ok();
        self.announce(watch);
        read.map_err(|_| Refusal::BadKnowledge)?;
        self.save_knowledge(watch)
    }

    pub(super) fn save_knowledge(&mut self, watch: &mut impl Supervision) -> Result<(), Refusal> {
        if !self.valid {
            return Err(Refusal::KnowledgeInvalid);
        }
        watch.handle(Input::FlashWrite)?;
        self.saving.granted = Some(Save::Knowledge);
        Ok(())
    }

    /// Refuses while the knowledge is being written to the flash.
    pub(super) fn must_not_save(&self) -> Result<(), Refusal> {
        match self.saving.granted {
            Some(_) => Err(Refusal::FlashBusy),
            None => Ok(()),
        }
    }

    /// Informs the supervisor whether the knowledge is usable.
    pub fn announce(&self, watch: &mut impl Supervision) {
        // Never refused.
        let _ = watch.handle(Input::Knowledge { valid: self.valid });
    }
}

/// Whether bytes are knowledge learned with exactly this rover's parameters: staircases and phases
/// are meaningless with others.
fn usable(bytes: &[u8], ours: &Parameters) -> bool {
    let bits = |parameters: &Parameters| parameters.to_array().map(f64::to_bits);
    RoverKnowledge::inspect::<Rule>(bytes).is_ok_and(|theirs| bits(&theirs) == bits(ours))
}
