//! The guard: an interrupt of its own that asks the supervisor every 10 ms whether the motors may
//! run, switches them off if not, and feeds the hardware watchdog.
//!
//! It depends on no task. It uses alarm 1 of the timer (Embassy's clock uses alarm 0) at the highest
//! priority. Should even it stop, because interrupts stay masked, the watchdog resets the board, and a
//! reset switches the motors off.

use core::cell::RefCell;

use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_rp::pac;
use embassy_rp::watchdog::Watchdog;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use rover_shared::contract::{FaultReport, Refusal, ResetReason};
use rover_shared::motion::WheelCommand;
use rover_shared::rover::{Supervision, View};
use rover_shared::supervisor::{GUARD_PERIOD, HARDWARE_WATCHDOG, Input, Supervisor};
use rover_shared::time::Instant;

use crate::motors;

/// The timer's alarm.
const ALARM: usize = 1;

struct Guard {
    supervisor: Supervisor,
    watchdog: Option<Watchdog>,
}

static GUARD: Mutex<CriticalSectionRawMutex, RefCell<Guard>> = Mutex::new(RefCell::new(Guard {
    supervisor: Supervisor::new(Instant(0), ResetReason::PowerOn),
    watchdog: None,
}));

/// Microseconds since the reset.
pub fn now() -> Instant {
    Instant(embassy_time::Instant::now().as_micros())
}

/// A duration as Embassy's clock counts.
pub const fn duration(span: rover_shared::time::Duration) -> embassy_time::Duration {
    embassy_time::Duration::from_micros(span.0)
}

/// Starts the guard: from now on every loop has to report within its time.
pub fn start(reset: ResetReason, watchdog: Watchdog) {
    GUARD.lock(|guard| {
        let mut guard = guard.borrow_mut();
        guard.supervisor = Supervisor::new(now(), reset);
        guard.watchdog = Some(watchdog);
    });
    // After a reset all priorities are the highest: at that, the others could not be interrupted.
    interrupt::TIMER_IRQ_0.set_priority(Priority::P1);
    interrupt::USBCTRL_IRQ.set_priority(Priority::P2);
    interrupt::I2C1_IRQ.set_priority(Priority::P2);
    interrupt::ADC_IRQ_FIFO.set_priority(Priority::P2);
    interrupt::DMA_IRQ_0.set_priority(Priority::P2);
    interrupt::TIMER_IRQ_1.set_priority(Priority::P0);
    critical_section::with(|_| {
        // In a critical section because Embassy's clock, too, has its bit in this register.
        pac::TIMER.inte().modify(|w| w.set_alarm(ALARM, true));
        set_alarm();
    });
    // SAFETY: unmasking the interrupt breaks no critical section, as none is open here, and its
    // handler only uses GUARD, which was filled above.
    unsafe { interrupt::TIMER_IRQ_1.enable() };
}

/// Sets the alarm one period ahead.
fn set_alarm() {
    let period = GUARD_PERIOD.0 as u32;
    loop {
        let due = pac::TIMER.timerawl().read().wrapping_add(period);
        pac::TIMER.alarm(ALARM).write_value(due);
        // The alarm only compares for equality: set too late it would fire in 72 minutes. Nothing
        // should delay this by a period; if something did, try again.
        let left = due.wrapping_sub(pac::TIMER.timerawl().read());
        if left <= period && left > 0 {
            return;
        }
    }
}

#[interrupt]
fn TIMER_IRQ_1() {
    // Written 1 to clear.
    pac::TIMER.intr().write(|w| w.set_alarm(ALARM, true));
    set_alarm();
    GUARD.lock(|guard| {
        let Guard {
            supervisor,
            watchdog,
        } = &mut *guard.borrow_mut();
        supervisor.poll(now());
        if !supervisor.motors_enabled() {
            motors::off();
        }
        if supervisor.feed_watchdog()
            && let Some(watchdog) = watchdog
        {
            // Twice as many counts as microseconds: the watchdog counts down by two (erratum
            // RP2040-E1, worked around in the driver).
            watchdog.feed(duration(HARDWARE_WATCHDOG));
        }
    });
}

/// Tells the supervisor something that it cannot refuse.
pub fn tell(input: Input) {
    let told = Watch.handle(input);
    debug_assert_eq!(told, Ok(()));
}

/// Calls `apply` with what the supervisor permits of a wheel command, so that no decision of the guard
/// can come between asking and applying.
pub fn gated(command: WheelCommand, apply: impl FnOnce(WheelCommand)) {
    GUARD.lock(|guard| {
        let mut guard = guard.borrow_mut();
        guard.supervisor.poll(now());
        apply(guard.supervisor.gate(command));
    });
}

/// The one supervisor.
pub struct Watch;

impl Watch {
    /// Calls `f` with the supervisor. If that withdraws the motors' permission, they are off when this
    /// returns, not only at the guard's next interrupt: a write to the flash, which may follow a
    /// disarming at once, masks that for up to 400 ms.
    fn with<R>(f: impl FnOnce(&mut (Instant, &mut Supervisor)) -> R) -> R {
        GUARD.lock(|guard| {
            let supervisor = &mut guard.borrow_mut().supervisor;
            let answer = f(&mut (now(), supervisor));
            if !supervisor.motors_enabled() {
                motors::off();
            }
            answer
        })
    }
}

impl Supervision for Watch {
    fn handle(&mut self, input: Input) -> Result<(), Refusal> {
        Self::with(|supervisor| supervisor.handle(input))
    }

    fn view(&mut self) -> View {
        Self::with(|supervisor| supervisor.view())
    }

    fn take_fault(&mut self) -> Option<FaultReport> {
        Self::with(|supervisor| supervisor.take_fault())
    }
}
