//! When the control task gets its turns, by the emulator's clock.

use std::fmt;

use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use emulated_rp2040::probe::ProbeId;
use rover_emulator::Emulation;
use rover_shared::rover::PERIOD;

use crate::bench::FIRMWARE;

const PERIOD_CYCLES: Cycles = PERIOD.0 * CYCLES_PER_MICROSECOND;

/// Turns of the control task, compared with a grid of 20 ms that began with the first of them.
pub struct Ticks {
    probe: ProbeId,
    first: Option<Cycles>,
    last: Cycles,
    /// How many there were.
    pub count: u64,
    /// The latest one's distance from the grid, in microseconds.
    pub latest_us: u64,
    /// The mean distance.
    pub mean_us: f64,
}

impl Ticks {
    /// Begins to measure; the board runs slower.
    pub fn begin(rover: &mut Emulation) -> Self {
        let probe = add_probe(rover);
        Self {
            probe,
            first: None,
            last: 0,
            count: 0,
            latest_us: 0,
            mean_us: 0.0,
        }
    }

    /// Takes what was measured since the last time.
    pub fn collect(&mut self, rover: &mut Emulation) {
        for call in rover.machine_mut().take_calls(self.probe) {
            let since = call.from - *self.first.get_or_insert(call.from);
            let off = since % PERIOD_CYCLES;
            let off_us = off.min(PERIOD_CYCLES - off) / CYCLES_PER_MICROSECOND;
            self.last = call.from;
            self.count += 1;
            self.latest_us = self.latest_us.max(off_us);
            self.mean_us += (off_us as f64 - self.mean_us) / self.count as f64;
        }
    }

    /// Ends measuring.
    pub fn end(mut self, rover: &mut Emulation) -> Self {
        self.collect(rover);
        rover.machine_mut().remove_probes();
        self
    }

    /// How many there had to be from the first to the last.
    pub fn due(&self) -> u64 {
        let span = self.last - self.first.expect("ticks");
        (span + PERIOD_CYCLES / 2) / PERIOD_CYCLES + 1
    }

    /// By how much this grid is shifted against another, in microseconds.
    pub fn shifted_us(&self, other: &Self) -> u64 {
        let [one, two] = [self, other].map(|ticks| ticks.first.expect("ticks"));
        let off = one.abs_diff(two) % PERIOD_CYCLES;
        off.min(PERIOD_CYCLES - off) / CYCLES_PER_MICROSECOND
    }
}

impl fmt::Display for Ticks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} ticks, {:.0} us off the grid of 20 ms on average, {} at most",
            self.count, self.mean_us, self.latest_us
        )
    }
}

/// Watches what the executor calls to give the control task its turn: the address is in the task's
/// header.
fn add_probe(rover: &mut Emulation) -> ProbeId {
    const HEADER_WORDS: u32 = 16;
    let storage = FIRMWARE.symbols_with(&["7control7control4POOL"]).next();
    let storage = storage.expect("the task's storage").address;
    let polls: Vec<u32> = FIRMWARE
        .symbols_with(&["TaskStorage", "4poll"])
        .map(|symbol| symbol.address)
        .collect();
    let word = |i| {
        let bytes = rover.machine().read(storage + 4 * i, 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let poll = (0..HEADER_WORDS)
        .filter_map(word)
        .find(|word| polls.contains(word));
    rover
        .machine_mut()
        .add_probe(poll.expect("the task was spawned"))
}
