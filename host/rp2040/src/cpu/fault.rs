//! How an instruction ends: its cycles, or why it did not complete.

use std::fmt;

/// Cycles of an instruction, or why it did not complete.
pub(super) type Executed = Result<u32, Trap>;

/// Most instructions.
pub(super) const SINGLE_CYCLE: Executed = Ok(1);
/// Whatever writes the PC.
pub(super) const TAKEN_BRANCH: Executed = Ok(2);

/// Why an instruction did not complete.
#[derive(Clone, Copy, Debug)]
pub(super) enum Trap {
    Fault(FaultCause),
    SupervisorCall,
}

/// What led to a HardFault.
// As wide as the cycles, so that a result of either is two registers and is never packed into one:
// every instruction returns this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[repr(u32)]
pub enum FaultCause {
    /// The instruction is UDF, or not allocated.
    #[error("undefined instruction")]
    Undefined,
    /// A branch or vector had bit 0 clear.
    #[error("execution without the Thumb bit")]
    NotThumb,
    /// The instruction fetch ended in a bus error.
    #[error("no memory to fetch an instruction from")]
    Fetch,
    /// The bus refused a load or store, or unprivileged code wanted the System Control Space.
    #[error("bus error")]
    Bus,
    /// A load or store of a word or halfword was not aligned.
    #[error("unaligned access")]
    Unaligned,
    /// BKPT without a debugger.
    #[error("breakpoint without a debugger")]
    Breakpoint,
    /// SVC where the supervisor call's priority is too low for it to be taken.
    #[error("supervisor call at a priority that masks it")]
    SupervisorCall,
    /// A return value or frame that does not belong to the exceptions active.
    #[error("impossible exception return")]
    ExceptionReturn,
    /// Bus error while an exception frame was written.
    #[error("bus error while stacking")]
    Stacking,
    /// Bus error while an exception frame was read.
    #[error("bus error while unstacking")]
    Unstacking,
    /// Bus error while a vector was read.
    #[error("bus error while reading a vector")]
    VectorRead,
}

/// A HardFault, or what locked the core up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultReport {
    /// What happened.
    pub cause: FaultCause,
    /// Address of the instruction; of the next one if an exception entry or return failed.
    pub instruction: u32,
    /// The address accessed by a load or store.
    pub address: Option<u32>,
}

impl fmt::Display for FaultReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            cause, instruction, ..
        } = self;
        write!(f, "{cause}")?;
        if let Some(address) = self.address {
            write!(f, ", address {address:#010x}")?;
        }
        write!(f, ", instruction at {instruction:#010x}")
    }
}
