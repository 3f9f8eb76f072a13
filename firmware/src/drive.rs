//! Applies wheel commands, as far as the supervisor permits.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, with_timeout};
use rover_shared::motion::WheelCommand;
use rover_shared::supervisor::{Input, Loop};

use crate::guard;
use crate::motors::Motors;

/// How long a command is valid: control sends one every 20 ms, and takes some 30 ms more at the start
/// of a session. (Without this the guard would stop the motors, 200 ms after control went silent.)
const HOLD: Duration = Duration::from_millis(60);

/// The latest command.
pub static COMMAND: Signal<CriticalSectionRawMutex, WheelCommand> = Signal::new();

static DRIVEN: AtomicBool = AtomicBool::new(false);

/// Whether the wheels are driven.
pub fn driven() -> bool {
    DRIVEN.load(Ordering::Relaxed)
}

/// Applies commands; never returns.
#[embassy_executor::task]
pub async fn drive(mut motors: Motors) -> ! {
    loop {
        let command = with_timeout(HOLD, COMMAND.wait())
            .await
            .unwrap_or(WheelCommand::STOP);
        guard::tell(Input::Alive(Loop::Drive));
        guard::gated(command, |command| {
            motors.apply(command);
            DRIVEN.store(command.drives(), Ordering::Relaxed);
        });
    }
}
