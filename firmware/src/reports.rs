//! Reports that wait for the host: bounded queues. A report that finds its queue full is dropped,
//! and counted.

use core::sync::atomic::{AtomicU32, Ordering};

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, with_timeout};
use rover_shared::supervisor::Input;
use rover_shared::wire::message::Report;

use crate::guard;

/// How long an answer, and with it the next command, waits for room in the queue.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(25);

/// Answers to commands, with reports asked for: they go before telemetry. Room for those to all
/// commands that fit into one packet.
static ANSWERS: Channel<CriticalSectionRawMutex, Report, 12> = Channel::new();
/// Telemetry: room for all that changes in one control period.
static TELEMETRY: Channel<CriticalSectionRawMutex, Report, 16> = Channel::new();
/// Reports dropped and not yet told to the supervisor.
static DROPPED: AtomicU32 = AtomicU32::new(0);

/// Queues telemetry, or drops and counts it.
pub fn report(report: Report) {
    if TELEMETRY.try_send(report).is_err() {
        drop_one();
    }
}

/// Queues an answer, or drops and counts it if there is no room for it in time.
pub async fn answer(report: Report) {
    let queued = with_timeout(ANSWER_TIMEOUT, ANSWERS.send(report)).await;
    if queued.is_err() {
        drop_one();
    }
}

/// Returns the next report: answers first. Cancelled, it loses none.
pub async fn next() -> Report {
    match select(ANSWERS.receive(), TELEMETRY.receive()).await {
        Either::First(report) | Either::Second(report) => report,
    }
}

/// Discards all that is queued.
pub fn discard() {
    while ANSWERS.try_receive().is_ok() || TELEMETRY.try_receive().is_ok() {}
}

/// Counts a dropped report.
pub fn drop_one() {
    critical_section::with(|_| {
        let dropped = DROPPED.load(Ordering::Relaxed);
        DROPPED.store(dropped.saturating_add(1), Ordering::Relaxed);
    });
}

/// Tells the supervisor how many reports were dropped since it was last told.
pub fn tell_drops() {
    let dropped = critical_section::with(|_| {
        let dropped = DROPPED.load(Ordering::Relaxed);
        DROPPED.store(0, Ordering::Relaxed);
        dropped
    });
    if dropped > 0 {
        guard::tell(Input::QueueFull(dropped));
    }
}
