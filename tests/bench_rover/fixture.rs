//! Rooms and the rovers in them.

use rover_boardless::BoardlessRover;
use rover_emulator::vehicle::{Build, Vehicle};
use rover_simulator::arena::{ArenaSource, Layout, Scenario};
use rover_simulator::experiment::numbered;

/// A rover in a random arena of a source.
pub fn scenario(source: &ArenaSource, seed: u64) -> Scenario {
    source.scenario(&mut rand_pcg::Pcg32::new(seed, 11))
}

/// Random rooms of 3 m, the paper's, or of 5 m, with three obstacles.
pub fn room(side_cm: f64, beam_deg: f64) -> ArenaSource {
    Layout::rover(side_cm, 3, beam_deg).into()
}

/// A rover that is switched on there.
pub fn bench(scenario: &Scenario, seed: u64) -> BoardlessRover {
    BoardlessRover::new(
        Vehicle::new(scenario, &Build::ROVER, numbered(seed, 1)),
        seed,
    )
}
