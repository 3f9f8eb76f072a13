//! Rooms and the rovers in them.

use rover_emulator::vehicle::bench::{BenchRover, Memory};
use rover_emulator::vehicle::{Build, Vehicle};
use rover_shared::motion::Parameters as Chassis;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_simulator::arena::{ArenaSource, Layout, Scenario};
use rover_simulator::experiment::numbered;

pub static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are valid"),
};

/// A rover in a random arena of a source.
pub fn scenario(source: &ArenaSource, seed: u64) -> Scenario {
    source.scenario(&mut rand_pcg::Pcg32::new(seed, 11))
}

/// Random rooms of 3 m, the paper's, or of 5 m, with three obstacles.
pub fn room(side_cm: f64, beam_deg: f64) -> ArenaSource {
    Layout::rover(side_cm, 3, beam_deg).into()
}

/// A bench rover that is switched on there.
pub fn bench<'m>(memory: &'m mut Memory, scenario: &Scenario, seed: u64) -> BenchRover<'m> {
    let vehicle = Vehicle::new(scenario, &Build::ROVER, numbered(seed, 1));
    BenchRover::new(
        &COEFFICIENTS,
        memory,
        Chassis::LYNXMOTION_4WD2,
        vehicle,
        seed,
    )
    .expect("a chassis that is known")
}
