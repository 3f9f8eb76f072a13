//! What the paper says about its lattice (II-B), checked on the reference and in fixed point.

use std::f64::consts::PI;

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rayon::prelude::*;
use rover_shared::perception::{
    Corners, Lattice, LatticeError, LatticeParameters, MAX_TIME, Noise, PatternCode,
};
use rover_shared::random::Generator;
use rover_simulator::reference::{LatticeState, Layer, Reference};

const PAPER: LatticeParameters = LatticeParameters::PAPER;

const LATTICE: Lattice = match Lattice::new(&PAPER) {
    Ok(lattice) => lattice,
    Err(_) => panic!("the paper's parameters are admissible"),
};

/// What stands for 1 in a corner.
const ONE: i32 = 1 << Corners::FRACTION_BITS;

/// The larger eigenvalue of the unsaturated lattice for a wave with -L = `k_squared`.
fn growth(k_squared: f64) -> f64 {
    let LatticeParameters {
        mu,
        epsilon,
        s,
        d1,
        d2,
    } = PAPER;
    let (a, d) = (mu + epsilon - d1 * k_squared, mu - epsilon - d2 * k_squared);
    let half_trace = (a + d) / 2.0;
    half_trace + (half_trace * half_trace - (a * d + s * s)).sqrt()
}

fn unstable(wave: impl Fn(f64, f64) -> f64) -> usize {
    (0..16)
        .filter(|k| growth(wave(f64::from(k / 4), f64::from(k % 4))) > 0.0)
        .count()
}

#[test]
fn the_dispersion_curve_hosts_twelve_unstable_modes() {
    let continuous = |m: f64, n: f64| (PI / 4.0).powi(2) * (m * m + n * n);
    assert_eq!(unstable(continuous), 12);
}

#[test]
fn on_the_lattice_only_the_uniform_mode_is_stable() {
    let difference = |m: f64| 2.0 - 2.0 * (PI * m / 4.0).cos();
    assert_eq!(unstable(|m, n| difference(m) + difference(n)), 15);
    assert!((growth(0.0) + 0.068).abs() < 0.0005, "{}", growth(0.0));
}

#[test]
fn each_violated_condition_is_named() {
    use LatticeError::*;
    let with = |change: fn(&mut LatticeParameters)| {
        let mut parameters = PAPER;
        change(&mut parameters);
        parameters.validate()
    };
    assert_eq!(with(|_| ()), Ok(()));
    assert_eq!(with(|p| p.d2 = f64::NAN), Err(NotFinite));
    assert_eq!(with(|p| p.d1 = 0.0), Err(NotPositive));
    assert_eq!(with(|p| p.s = -0.9), Err(NotPositive));
    assert_eq!(with(|p| p.mu = 0.0), Err(UniformStateGrows));
    assert_eq!(with(|p| p.s = 0.8), Err(UniformStateUnstable));
    assert_eq!(with(|p| p.d2 = 0.2), Err(NoActivatorRange));
    assert_eq!(with(|p| p.d1 = 30.0), Err(NoActivatorRange));
    assert_eq!(with(|p| p.d2 = 0.3), Err(NoUnstableBand));
    assert_eq!(with(|p| p.s = 1.81), Err(LayerTwoSaturates));
    assert_eq!(with(|p| p.d2 = 150.0), Err(TooStiff));
    assert_eq!(
        with(|p| (p.d1, p.d2) = (1.5, 100.0)),
        Err(CoefficientOutOfRange)
    );
}

/// The states in which the lattice rests if its outputs are `sign`: a linear system.
fn equilibrium(sign: &Layer) -> LatticeState {
    let LatticeParameters {
        mu,
        epsilon,
        s,
        d1,
        d2,
    } = PAPER;
    let solve = |decay: f64, diffusion: f64, input: &dyn Fn(usize) -> f64| {
        let mut x = [0.0; 16];
        for _ in 0..5_000 {
            for cell in 0..16 {
                let (row, column) = (cell / 4, cell % 4);
                let neighbours =
                    (0..16usize).filter(|&n| (n / 4).abs_diff(row) + (n % 4).abs_diff(column) == 1);
                let (sum, count) = neighbours.fold((0.0, 0.0), |(s, k), n| (s + x[n], k + 1.0));
                x[cell] = (input(cell) + diffusion * sum) / (decay + diffusion * count);
            }
        }
        x
    };
    let x2 = solve(epsilon - mu, d2, &|cell| s * sign[cell]);
    let x1 = solve(1.0, d1, &|cell| {
        (1.0 + mu + epsilon) * sign[cell] - s * x2[cell]
    });
    LatticeState { x1, x2 }
}

fn margin(state: &LatticeState) -> f64 {
    state
        .x1
        .iter()
        .fold(f64::INFINITY, |least, x| least.min(x.abs()))
        - 1.0
}

#[test]
fn the_papers_patterns_are_stable_fixed_points() {
    let reference = Reference::new(PAPER);
    for (code, expected) in [(12_703, 0.116), (37_156, 0.0099), (63_884, 0.116)] {
        let code = PatternCode(code);
        let sign: Layer = std::array::from_fn(|cell| if code.cell(cell) { 1.0 } else { -1.0 });
        let rest = equilibrium(&sign);
        assert!(
            (margin(&rest) - expected).abs() < 0.05 * expected,
            "{code} {}",
            margin(&rest)
        );

        let mut pushed = rest;
        for (cell, x) in pushed.x1.iter_mut().enumerate() {
            *x += if cell % 3 == 0 { 0.008 } else { -0.008 };
        }
        let end = reference.run(pushed);
        assert_eq!((end.code, end.saturated), (code, true));
        for (x, at_rest) in end.state.x1.iter().zip(rest.x1) {
            assert!((x - at_rest).abs() < 1e-9, "{code}");
        }
    }
}

#[test]
fn the_papers_two_headings_grow_from_their_corners() {
    let reference = Reference::new(PAPER);
    for (corners, code) in [([1, 1, 1, -1], 12_703), ([-1, 1, 1, 1], 63_884)] {
        for magnitude in [1, 3, 20] {
            let corners = Corners(corners.map(|corner| corner * magnitude * ONE));
            let noise = Noise::default();
            let settled = LATTICE.settle(&corners, &noise).expect("settles");
            assert_eq!(settled.code, PatternCode(code));
            let start = LatticeState::from_fixed(&corners, &noise);
            let ended = reference.run(start);
            assert_eq!(ended.code, PatternCode(code));
            let time = ended.settle_time.expect("settles");
            let difference = (f64::from(settled.time.0) / 64.0 - time).abs();
            assert!(difference < 0.5, "settled {difference} apart");
        }
    }
}

#[test]
fn the_all_zero_state_forms_no_pattern() {
    let given_up = LATTICE.settle(&Corners::default(), &Noise::default());
    assert!(given_up.is_err_and(|error| error.code == PatternCode(0) && error.steps > 800));
    let end = Reference::new(PAPER).settle([0.0; 4], [0.0; 16]);
    assert!(!end.saturated && end.settle_time.is_none());
}

#[test]
fn noise_alone_forms_patterns() {
    let mut rng = Generator::new(16);
    let mut codes: Vec<_> = (0..500)
        .filter_map(|_| {
            LATTICE
                .settle(&Corners::default(), &Noise::draw(&mut rng))
                .ok()
        })
        .map(|settled| settled.code)
        .collect();
    assert!(codes.len() >= 499, "{} settled", codes.len());
    codes.sort();
    codes.dedup();
    assert!(codes.len() > 100, "only {} patterns", codes.len());
}

#[test]
fn the_observer_sees_the_pattern_grow_from_the_corners() {
    let corners = Corners([2 * ONE, ONE, -ONE, 3 * ONE]);
    let mut seen = Vec::new();
    let settled = LATTICE
        .settle_observed(&corners, &Noise::default(), &mut |time, x1| {
            seen.push((time, *x1))
        })
        .expect("settles");
    assert_eq!(LATTICE.settle(&corners, &Noise::default()), Ok(settled));
    let (first, last) = (&seen[0], seen[seen.len() - 1]);
    assert!(first.0.0 == 1 && (first.1[15] - 3 * ONE).abs() < ONE / 10);
    assert_eq!(last.0, settled.time);
    assert!(last.1.iter().all(|x1| x1.abs() >= ONE));
    assert!(seen.windows(2).all(|pair| pair[0].0 < pair[1].0));
}

/// Other admissible parameters are followed as well as the paper's.
#[test]
fn other_parameters_follow_their_reference() {
    let sets = [
        LatticeParameters { d1: 0.02, ..PAPER },
        LatticeParameters { d2: 40.0, ..PAPER },
        LatticeParameters {
            mu: -0.5,
            epsilon: 0.8,
            s: 0.75,
            d1: 0.04,
            d2: 10.0,
        },
        LatticeParameters {
            mu: -0.3,
            epsilon: 0.7,
            s: 0.8,
            ..PAPER
        },
    ];
    for parameters in sets {
        let lattice = Lattice::new(&parameters).expect("admissible");
        let mut rng = Generator::new(17);
        let starts: Vec<_> = (0..400)
            .map(|_| {
                let corners = Corners(std::array::from_fn(|_| rng.symmetric(2 * ONE as u32)));
                (corners, Noise::draw(&mut rng))
            })
            .collect();
        let exact: Vec<_> = starts
            .iter()
            .map(|(c, n)| LatticeState::from_fixed(c, n))
            .collect();
        let reference = Reference::new(parameters);
        let chunks = exact.par_chunks(64);
        let codes: Vec<_> = chunks
            .flat_map_iter(|chunk| reference.codes(chunk))
            .collect();
        let different = starts
            .iter()
            .zip(codes)
            .filter(|((c, n), code)| lattice.settle(c, n).map(|s| s.code) != Ok(*code))
            .count();
        assert!(different <= 2, "{different} of 400 for {parameters:?}");
    }
}

/// The eight symmetries of the square: where each sends a cell.
fn sent(symmetry: usize, cell: usize) -> usize {
    let (mut row, mut column) = (cell / 4, cell % 4);
    if symmetry & 1 == 1 {
        (row, column) = (column, row);
    }
    if symmetry & 2 == 2 {
        row = 3 - row;
    }
    if symmetry & 4 == 4 {
        column = 3 - column;
    }
    4 * row + column
}

fn moved<T: Copy + Default>(symmetry: usize, cells: &[T; 16]) -> [T; 16] {
    let mut result = [T::default(); 16];
    for (cell, &value) in cells.iter().enumerate() {
        result[sent(symmetry, cell)] = value;
    }
    result
}

fn moved_corners(symmetry: usize, corners: &Corners) -> Corners {
    let mut cells = [0; 16];
    for (cell, corner) in Corners::CELLS.into_iter().zip(corners.0) {
        cells[cell] = corner;
    }
    Corners(Corners::CELLS.map(|cell| moved(symmetry, &cells)[cell]))
}

fn moved_code(symmetry: usize, code: PatternCode) -> PatternCode {
    let cells: [bool; 16] = std::array::from_fn(|cell| code.cell(cell));
    let bits = moved(symmetry, &cells).into_iter().enumerate();
    PatternCode(bits.map(|(cell, bit)| u16::from(bit) << cell).sum())
}

fn corners() -> impl Strategy<Value = Corners> {
    let corner = prop_oneof![
        Just(0),
        -(ONE / 100)..=ONE / 100,
        -2 * ONE..=2 * ONE,
        -Corners::MAX..=Corners::MAX
    ];
    prop::array::uniform4(corner).prop_map(Corners)
}

fn noise() -> impl Strategy<Value = Noise> {
    prop::array::uniform16(-Noise::AMPLITUDE..=Noise::AMPLITUDE).prop_map(Noise)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(18),
        ..ProptestConfig::default()
    })]

    /// Exact in fixed point, also in the time it takes: all sums and roundings commute with the
    /// symmetries.
    #[test]
    fn the_lattice_has_the_symmetries_of_the_square(
        corners in corners(), noise in noise(), symmetry in 1usize..8,
    ) {
        let image = (moved_corners(symmetry, &corners), Noise(moved(symmetry, &noise.0)));
        match (LATTICE.settle(&corners, &noise), LATTICE.settle(&image.0, &image.1)) {
            (Ok(one), Ok(other)) => {
                prop_assert_eq!(moved_code(symmetry, one.code), other.code);
                prop_assert_eq!(one.time, other.time);
            }
            (one, other) => prop_assert_eq!(one.is_err(), other.is_err()),
        }
    }

    /// Exact in fixed point: all roundings are odd.
    #[test]
    fn a_negated_start_gives_the_complement(corners in corners(), noise in noise()) {
        let negated = (Corners(corners.0.map(|x| -x)), Noise(noise.0.map(|x| -x)));
        match (LATTICE.settle(&corners, &noise), LATTICE.settle(&negated.0, &negated.1)) {
            (Ok(one), Ok(other)) => {
                prop_assert_eq!(PatternCode(!one.code.0), other.code);
                prop_assert_eq!(one.time, other.time);
            }
            (one, other) => prop_assert_eq!(one.is_err(), other.is_err()),
        }
    }

    /// Nothing overflows (the tests check that) and nothing runs for ever, whatever it starts from.
    #[test]
    fn every_start_ends(
        corners in prop_oneof![
            corners(),
            prop::array::uniform4(any::<i32>()).prop_map(Corners),
            prop::array::uniform4(prop::sample::select(vec![Corners::MAX, -Corners::MAX])).prop_map(Corners),
        ],
        noise in prop_oneof![noise(), prop::array::uniform16(any::<i32>()).prop_map(Noise)],
    ) {
        if let Ok(settled) = LATTICE.settle(&corners, &noise) {
            prop_assert!(settled.time <= MAX_TIME);
        }
    }
}

/// Corners of one sign, of all signs, with the strongest noise: the extremes of the number format.
#[test]
fn the_extreme_starts_do_not_overflow() {
    for signs in 0..16 {
        let corners = Corners(std::array::from_fn(|corner| {
            if signs >> corner & 1 == 1 {
                i32::MAX
            } else {
                i32::MIN
            }
        }));
        for noise in [i32::MIN, -1, 0, i32::MAX] {
            assert!(LATTICE.settle(&corners, &Noise([noise; 16])).is_ok());
        }
    }
}
