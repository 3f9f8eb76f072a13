//! How often the fixed-point lattice gives the code of the reference (eq. 1 in f64, Euler's
//! method with dt = 0.001 and N = 100,000). The seeds are not those the engine was tuned with.

use rayon::prelude::*;
use rover_shared::perception::{Corners, Lattice, LatticeParameters, Noise, PatternCode};
use rover_shared::random::Generator;
use rover_simulator::reference::{LatticeState, Reference};

const LATTICE: Lattice = match Lattice::new(&LatticeParameters::PAPER) {
    Ok(lattice) => lattice,
    Err(_) => panic!("the paper's parameters are admissible"),
};

type Start = (Corners, Noise);

/// `count` starts whose corners are drawn by `corners`.
fn starts(
    seed: u64,
    count: usize,
    mut corners: impl FnMut(&mut Generator) -> [i32; 4],
) -> Vec<Start> {
    let mut rng = Generator::new(seed);
    (0..count)
        .map(|_| (Corners(corners(&mut rng)), Noise::draw(&mut rng)))
        .collect()
}

/// A corner as early learning leaves it: the sum of 1 to 10 increments, uniform in +-0.5.
fn increments(rng: &mut Generator) -> i32 {
    let count = 1 + rng.bits() % 10;
    (0..count).map(|_| rng.symmetric(1 << 19)).sum()
}

fn uniform(rng: &mut Generator, limit: u32) -> [i32; 4] {
    std::array::from_fn(|_| rng.symmetric(limit << Corners::FRACTION_BITS))
}

/// The codes of the reference, in parallel.
fn reference_codes(reference: &Reference, starts: &[LatticeState]) -> Vec<PatternCode> {
    let chunks = starts.par_chunks(64);
    chunks
        .flat_map_iter(|chunk| reference.codes(chunk))
        .collect()
}

/// The codes of both engines, in this order: fixed point, reference.
fn codes(starts: &[Start]) -> Vec<(Option<PatternCode>, PatternCode)> {
    let exact: Vec<_> = starts
        .iter()
        .map(|(corners, noise)| LatticeState::from_fixed(corners, noise))
        .collect();
    let reference = reference_codes(&Reference::new(LatticeParameters::PAPER), &exact);
    let fixed: Vec<_> = starts
        .par_iter()
        .map(|(corners, noise)| {
            LATTICE
                .settle(corners, noise)
                .ok()
                .map(|settled| settled.code)
        })
        .collect();
    fixed.into_iter().zip(reference).collect()
}

/// Asserts that of 1,000 codes at most `allowed` differ, and reports how many do.
fn assert_agreement(kind: &str, codes: &[(Option<PatternCode>, PatternCode)], allowed: f64) {
    let different = codes
        .iter()
        .filter(|(fixed, reference)| *fixed != Some(*reference))
        .count();
    let share = 1000.0 * different as f64 / codes.len() as f64;
    println!(
        "{kind}: {different} of {} codes differ, {share:.2} per mille",
        codes.len()
    );
    assert!(share <= allowed, "{kind}: {different} of {}", codes.len());
}

#[test]
fn corners_of_early_learning() {
    let starts = starts(0xF1DE_0001, 20_000, |rng| {
        std::array::from_fn(|_| increments(rng))
    });
    assert_agreement("sums of increments", &codes(&starts), 1.0);
}

/// Each case is the state of every untrained robot, so noise alone decides the code. It counts if
/// the reference itself keeps its code when all initial states move by up to 1e-6.
#[test]
fn all_zero_corners() {
    let starts = starts(0xF1DE_0002, 4_000, |_| [0; 4]);
    let reference = Reference::new(LatticeParameters::PAPER);
    let mut rng = Generator::new(0xF1DE_1002);
    let mut stable = vec![true; starts.len()];
    let codes = codes(&starts);
    for _ in 0..2 {
        let mut moved =
            |state: f64| state + 1e-6 * f64::from(rng.symmetric(1 << 30)) / 2f64.powi(30);
        let perturbed: Vec<_> = starts
            .iter()
            .map(|(corners, noise)| {
                let mut state = LatticeState::from_fixed(corners, noise);
                for cell in Corners::CELLS {
                    state.x1[cell] = moved(state.x1[cell]);
                }
                state.x2 = state.x2.map(&mut moved);
                state
            })
            .collect();
        for (k, code) in reference_codes(&reference, &perturbed)
            .into_iter()
            .enumerate()
        {
            stable[k] &= code == codes[k].1;
        }
    }
    let kept: Vec<_> = codes
        .into_iter()
        .zip(stable)
        .filter_map(|(c, s)| s.then_some(c))
        .collect();
    assert!(kept.len() > 3_800, "only {} are stable", kept.len());
    assert_agreement("all-zero corners", &kept, 1.0);
}

#[test]
fn large_corners() {
    for (seed, limit) in [(4, 4), (5, 10), (6, 20), (7, 40)] {
        let starts = starts(0xF1DE_0000 + seed, 5_000, |rng| uniform(rng, limit));
        assert_agreement(&format!("uniform in +-{limit}"), &codes(&starts), 2.0);
    }
}

/// The hardest kind: the one large corner decides early, the others much later.
#[test]
fn one_large_corner() {
    let starts = starts(0xF1DE_0003, 5_000, |rng| {
        let mut corners = std::array::from_fn(|_| increments(rng));
        corners[rng.bits() as usize % 4] = rng.symmetric(40 << Corners::FRACTION_BITS);
        corners
    });
    assert_agreement("one corner uniform in +-40", &codes(&starts), 2.0);
}

/// The engine stops when all cells are saturated. In the reference this moment, too, lies beyond
/// the point where the code is proved to be final.
#[test]
fn a_saturated_lattice_is_decided() {
    let mut starts = starts(0xF1DE_0008, 1_000, |rng| {
        std::array::from_fn(|_| increments(rng))
    });
    starts.extend(self::starts(0xF1DE_0009, 500, |rng| uniform(rng, 40)));
    let exact: Vec<_> = starts
        .iter()
        .map(|(corners, noise)| LatticeState::from_fixed(corners, noise))
        .collect();
    let reference = Reference::new(LatticeParameters::PAPER);
    exact.par_chunks(64).for_each(|chunk| {
        for state in reference.run_until(chunk, LatticeState::is_saturated) {
            assert!(
                state.is_saturated() && reference.is_decided(&state),
                "{state:?}"
            );
        }
    });
}
