//! Ctrl-C ends a command in an orderly way: files are finished, rovers disarmed.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::output::Failure;

/// Whether the user interrupted.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on Ctrl-C and SIGTERM only set this; the second one ends the program.
    pub fn listen() -> Result<Self, Failure> {
        let flag = Arc::new(AtomicBool::new(false));
        let heard = flag.clone();
        ctrlc::set_handler(move || {
            if heard.swap(true, Ordering::SeqCst) {
                // As a shell reports a program that SIGINT ended.
                std::process::exit(130);
            }
        })?;
        Ok(Self(flag))
    }

    /// Whether it came.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
