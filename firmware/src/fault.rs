//! What a panic, a hard fault or a task that cannot be spawned does: motors off first, then a text
//! (the last words) into memory that survives a reset, then the reset. The next run reports the text.

use core::mem::MaybeUninit;
use core::panic::{Location, PanicInfo};

use cortex_m_rt::{ExceptionFrame, exception};
use embassy_rp::pac;
use embassy_rp::peripherals::WATCHDOG;
use embassy_rp::watchdog::{self, Watchdog};
use heapless::String;
use rover_shared::contract::{ResetReason, TEXT_BYTES};
use rover_shared::last_words::{Cause, LastWords, Text};

use crate::motors;

/// In memory that no start-up code clears. Any bits are valid: the checksum tells whether it holds a
/// text.
// SAFETY: `.uninit` is RAM that the linker script of cortex-m-rt sets aside for just this, and
// `MaybeUninit` asks nothing of its contents.
#[unsafe(link_section = ".uninit.LAST_WORDS")]
static mut LAST_WORDS: MaybeUninit<LastWords> = MaybeUninit::uninit();

/// Returns why the board started, and the last words of the run before, which it clears.
pub fn reset_reason(watchdog: &Watchdog) -> (ResetReason, Option<String<TEXT_BYTES>>) {
    let place = (&raw mut LAST_WORDS).cast::<LastWords>();
    // SAFETY: the place is valid, aligned, and made of integers, for which any bits are valid; the
    // handlers that also use it never return. Volatile, so that nothing is assumed of memory that
    // was never written in this run.
    let words = unsafe {
        let words = place.read_volatile();
        place.write_volatile(LastWords::NONE);
        words
    };
    let words = words.read();
    let text = words.and_then(|(_, text)| String::try_from(text.as_str()).ok());
    let chip = pac::VREG_AND_CHIP_RESET.chip_reset().read();
    let reason = match (watchdog.reset_reason(), words) {
        (Some(_), Some((cause, _))) => cause.into(),
        (Some(watchdog::ResetReason::TimedOut), None) => ResetReason::Watchdog,
        (Some(watchdog::ResetReason::Forced), None) => ResetReason::Requested,
        (None, _) if chip.had_run() => ResetReason::RunPin,
        (None, _) if chip.had_psm_restart() => ResetReason::Requested,
        (None, _) => ResetReason::PowerOn,
    };
    (reason, text)
}

/// Stops the motors: first, whatever else is broken.
fn stop() {
    cortex_m::interrupt::disable();
    motors::cut_off();
}

/// Stores the last words and resets the board.
fn end(cause: Cause, text: &Text) -> ! {
    let place = (&raw mut LAST_WORDS).cast::<LastWords>();
    // SAFETY: as in `reset_reason`; interrupts are masked and core 1 sleeps, so nothing else runs.
    unsafe { place.write_volatile(LastWords::new(cause, text)) };
    // SAFETY: the owner of the watchdog does not run any more.
    let mut watchdog = Watchdog::new(unsafe { WATCHDOG::steal() });
    watchdog.trigger_reset();
    loop {
        cortex_m::asm::nop();
    }
}

/// Ends the run because a task cannot be spawned.
pub fn not_spawned(task: &str) -> ! {
    stop();
    let text = Text::new().text("cannot spawn task ").text(task);
    end(Cause::Panic, &text)
}

/// Passes only the location on, inlined, so that the compiler sees that no message is used: then it
/// leaves out all messages, and the code that formats them (4 KB).
#[expect(
    unused_attributes,
    reason = "an exported function is not inlined elsewhere, but it is within core"
)]
#[inline(always)]
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    stop();
    #[cfg(feature = "defmt")]
    defmt::error!("{}", defmt::Display2Format(info));
    panicked(info.location())
}

#[inline(never)]
fn panicked(place: Option<&Location>) -> ! {
    let mut text = Text::new().text("panicked");
    if let Some(place) = place {
        text = text
            .text(" at ")
            .text(place.file())
            .text(":")
            .number(place.line());
    }
    end(Cause::Panic, &text)
}

// SAFETY: touches nothing but the motors' registers, the words and the watchdog, and never returns.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    stop();
    let text = Text::new().text("hard fault at 0x").address(frame.pc());
    let text = text.text(", called from 0x").address(frame.lr());
    end(Cause::HardFault, &text)
}
