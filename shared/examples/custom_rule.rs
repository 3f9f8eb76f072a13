//! A learning rule of one's own: each pattern chooses among four turns by what they were worth.
//!
//! The robot turns on the spot in an open field and is to face a target. `cargo run -p rover-shared
//! --example custom_rule` prints its mean error before and after learning.

use rover_shared::action::Action;
use rover_shared::action::pattern_vector::PatternVector;
use rover_shared::controller::Controller;
use rover_shared::knowledge::Knowledge;
use rover_shared::learning::{
    LearningCoefficients, LearningRule, Memory, Mode, SensingLayer, StaircaseChange, Transition,
};
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::PatternCode;
use rover_shared::random::Generator;
use rover_shared::reward::AimAtTarget;
use rover_shared::sensing::Sample;
use rover_shared::sensing::neuron::Activation;
use rover_shared::units::{Microdegrees, Micrometres};

const TURNS: [i32; 4] = [-60, -20, 20, 60];

/// The mean reward difference of each turn, in thousandths of reward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values([i16; 4]);

impl Values {
    fn best(&self) -> usize {
        (0..4).max_by_key(|&i| self.0[i]).unwrap_or_default()
    }
}

impl Memory for Values {
    const SIZE: usize = 8;

    fn phase(&self) -> Microdegrees {
        Microdegrees::from_degrees(TURNS[self.best()])
    }

    fn write(&self, bytes: &mut [u8]) {
        for (bytes, value) in bytes.chunks_exact_mut(2).zip(self.0) {
            bytes.copy_from_slice(&value.to_le_bytes());
        }
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let mut values = [0; 4];
        for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(2)) {
            *value = i16::from_le_bytes(bytes.try_into().ok()?);
        }
        Some(Self(values))
    }
}

/// Tries one turn in four at random, and averages what each turn was worth.
#[derive(Clone, Copy, Default)]
pub struct FourTurns;

impl LearningRule for FourTurns {
    type Memory = Values;
    const ID: u8 = 200;

    fn introduce<const N: usize>(
        &self,
        _code: PatternCode,
        _known: &PatternVector<Values, N>,
        _c: &LearningCoefficients,
        _rng: &mut Generator,
    ) -> Values {
        Values([0; 4])
    }

    fn act(
        &self,
        values: &Values,
        mode: Mode,
        _c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Action {
        let turn = match mode {
            Mode::Learn if rng.bits() < u32::MAX / 4 => (rng.bits() % 4) as usize,
            _ => values.best(),
        };
        Action {
            phase: Microdegrees::from_degrees(TURNS[turn]),
            module: Micrometres(0),
        }
    }

    fn learn(
        &self,
        transition: &Transition,
        values: &mut Values,
        sensing: &mut SensingLayer,
        c: &LearningCoefficients,
        rng: &mut Generator,
    ) -> Option<StaircaseChange> {
        let gain = transition.reward_difference() / 1_000;
        let tried = TURNS
            .iter()
            .position(|&turn| Microdegrees::from_degrees(turn) == transition.action.phase)?;
        let value = i32::from(values.0[tried]);
        let value = (value + (gain - value) / 4).clamp(i16::MIN.into(), i16::MAX.into());
        values.0[tried] = value as i16;
        // A failure changes the staircases, ever less, until different percepts are different
        // patterns.
        sensing.width = ((u64::from(sensing.width) * u64::from(c.sensing_ageing)) >> 32) as u32;
        (gain < 0).then(|| {
            let stimulus = transition.after.most_decreased(&transition.before);
            let step = transition.percept.0[stimulus as usize].step();
            let amount = rng.symmetric(sensing.width >> (32 - Activation::FRACTION_BITS));
            sensing.neurons[stimulus as usize].shift(step, amount, c.amplitude_limit);
            StaircaseChange {
                stimulus,
                step,
                amount,
            }
        })
    }
}

/// Mean error in degrees after eight actions from each of 100 headings.
fn error(
    knowledge: &mut Knowledge<Values>,
    coefficients: &Coefficients,
    (mode, seed): (Mode, u64),
) -> i32 {
    let rng = Generator::new(seed);
    let mut controller = Controller::new(coefficients, FourTurns, knowledge, rng, mode);
    let mut total = 0;
    for start in 0..100 {
        let mut heading = Microdegrees::wrapped((start * 37_000_000) % 360_000_000);
        let sample = |heading| Sample {
            front: Micrometres::from_cm(500),
            left: Micrometres::from_cm(500),
            right: Micrometres::from_cm(500),
            heading,
            target_bearing: Some(Microdegrees(0)),
        };
        for _ in 0..8 {
            let record = controller.step(&sample(heading), &AimAtTarget);
            heading = heading.turned(record.action.phase);
        }
        controller.conclude(&sample(heading), &AimAtTarget);
        total += heading.0.abs() / Microdegrees::PER_DEGREE;
    }
    total / 100
}

fn main() -> Result<(), rover_shared::range_check::ParameterError> {
    let coefficients = Coefficients::new(&Parameters::PAPER)?;
    let mut knowledge = Knowledge::new(&coefficients.learning);
    let before = error(&mut knowledge, &coefficients, (Mode::Run, 0));
    for seed in 1..=30 {
        error(&mut knowledge, &coefficients, (Mode::Learn, seed));
    }
    let after = error(&mut knowledge, &coefficients, (Mode::Run, 0));
    let patterns = knowledge.patterns.elements().len();
    println!("mean error {before} degrees before learning, {after} after; {patterns} patterns");
    assert!(after < before / 2, "it learned");
    Ok(())
}
