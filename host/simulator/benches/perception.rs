//! One perception in fixed point, and the paper's 100,000 Euler steps it replaces.

use std::cell::Cell;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group};
use rover_shared::perception::{Corners, Lattice, LatticeParameters, Noise};
use rover_shared::random::Generator;
use rover_simulator::reference::{LatticeState, Reference};

static LATTICE: Lattice = match Lattice::new(&LatticeParameters::PAPER) {
    Ok(lattice) => lattice,
    Err(_) => panic!("the paper's parameters are admissible"),
};

/// Starts as early learning leaves them: corners are sums of 1 to 10 increments within +-0.5.
fn starts() -> Vec<(Corners, Noise)> {
    let mut rng = Generator::new(1);
    let corner = |rng: &mut Generator| {
        let count = 1 + rng.bits() % 10;
        (0..count).map(|_| rng.symmetric(1 << 19)).sum()
    };
    (0..512)
        .map(|_| {
            let corners = Corners(std::array::from_fn(|_| corner(&mut rng)));
            (corners, Noise::draw(&mut rng))
        })
        .collect()
}

fn perception(criterion: &mut Criterion) {
    let starts = starts();
    let turn = Cell::new(0);
    let next = || {
        turn.set((turn.get() + 1) % starts.len());
        &starts[turn.get()]
    };
    let mut group = criterion.benchmark_group("perception");
    group.bench_function("fixed", |bencher| {
        bencher.iter(|| {
            let (corners, noise) = next();
            black_box(LATTICE.settle(black_box(corners), black_box(noise)))
        });
    });
    let reference = Reference::new(LatticeParameters::PAPER);
    group
        .measurement_time(Duration::from_secs(10))
        .sample_size(20);
    group.bench_function("reference", |bencher| {
        bencher.iter(|| {
            let (corners, noise) = next();
            black_box(reference.run(black_box(LatticeState::from_fixed(corners, noise))))
        });
    });
    group.finish();
}

criterion_group!(benches, perception);

/// The ratio of the two, from turns taken one after another, so that both meet the same machine.
fn ratio() {
    let reference = Reference::new(LatticeParameters::PAPER);
    let starts = starts();
    let (mut fixed_time, mut reference_time) = (Duration::ZERO, Duration::ZERO);
    for chunk in starts.chunks(64) {
        let begin = Instant::now();
        for (corners, noise) in chunk {
            let _ = black_box(LATTICE.settle(black_box(corners), black_box(noise)));
        }
        fixed_time += begin.elapsed();
        let (corners, noise) = &chunk[0];
        let begin = Instant::now();
        black_box(reference.run(black_box(LatticeState::from_fixed(corners, noise))));
        reference_time += begin.elapsed();
    }
    let runs = starts.chunks(64).count() as f64;
    let fixed = fixed_time.as_secs_f64() / starts.len() as f64;
    let reference = reference_time.as_secs_f64() / runs;
    println!(
        "fixed {:.2} us, reference {:.0} us: the reference takes {:.0} times as long",
        fixed * 1e6,
        reference * 1e6,
        reference / fixed
    );
}

fn main() {
    benches();
    ratio();
}
