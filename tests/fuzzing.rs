//! Bytes from outside, damaged in every way: no reader panics, none takes more memory than its
//! input is worth.
//!
//! The entry points are those of the cargo-fuzz targets in `tests/fuzz`. Here they get real files,
//! changed at random: a few thousand in every run, and ten million by
//!
//! ```sh
//! cargo test --release --test fuzzing -- --ignored --nocapture
//! ```
//!
//! (Without `--release` it takes twice as long, and overflows are found too.)

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "fuzzing/allocation.rs"]
mod allocation;
#[path = "fuzz/entry_points/mod.rs"]
mod entry_points;
#[path = "fuzzing/mutation.rs"]
mod mutation;
#[path = "fuzzing/seeds.rs"]
mod seeds;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use proptest::prelude::*;
use rand_pcg::Pcg32;
use rayon::prelude::*;

use allocation::Peak;
use mutation::Mutation;

#[global_allocator]
static ALLOCATOR: allocation::Counting = allocation::Counting;

/// An entry point and what it is tried with.
struct Target {
    name: &'static str,
    enter: fn(&[u8]),
    seeds: Vec<Vec<u8>>,
    /// Bytes of memory that it may take whatever the input, and for each of the input's bytes.
    memory: (usize, usize),
    /// Its share of ten million inputs, in millionths.
    share: u64,
}

const MB: usize = 1 << 20;

fn frames() -> Target {
    Target {
        name: "frames",
        enter: entry_points::frames,
        seeds: seeds::frames(),
        memory: (64 << 10, 8),
        share: 500_000,
    }
}

fn knowledge() -> Target {
    Target {
        name: "knowledge",
        enter: entry_points::knowledge,
        seeds: seeds::knowledge(),
        memory: (MB / 8, 8),
        share: 150_000,
    }
}

fn logs() -> Target {
    Target {
        name: "logs",
        enter: entry_points::logs,
        seeds: seeds::logs(),
        // JSON as values takes several times its text, but only one message at a time.
        memory: (MB / 2, 16),
        share: 50_000,
    }
}

fn arenas() -> Target {
    Target {
        name: "arenas",
        enter: entry_points::arenas,
        seeds: seeds::arenas(),
        // The lattice on which places are drawn has at most 512 by 512 points.
        memory: (8 * MB, 16),
        share: 100_000,
    }
}

fn maps() -> Target {
    Target {
        name: "maps",
        enter: entry_points::maps,
        seeds: seeds::maps(),
        // Eight pixels a byte at most, and each a cell that may be a surface.
        memory: (8 * MB, 1_024),
        share: 50_000,
    }
}

fn tables() -> Target {
    Target {
        name: "tables",
        enter: entry_points::tables,
        seeds: seeds::tables(),
        memory: (MB, 16),
        share: 150_000,
    }
}

impl Target {
    fn memory_for(&self, input: &[u8]) -> usize {
        self.memory.0 + self.memory.1 * input.len()
    }

    /// Enters, and gives the most memory that was taken.
    fn enter(&self, input: &[u8]) -> usize {
        let peak = Peak::begin();
        (self.enter)(input);
        peak.bytes()
    }

    fn check(&self, input: &[u8]) -> Result<(), TestCaseError> {
        let (taken, most) = (self.enter(input), self.memory_for(input));
        prop_assert!(
            taken <= most,
            "{taken} bytes taken, expected {most} at most"
        );
        Ok(())
    }

    /// Changed seeds; what is drawn shrinks.
    fn inputs(&self) -> impl Strategy<Value = Vec<u8>> + use<> {
        let seeds = self.seeds.clone();
        let changes = prop::collection::vec(any::<Mutation>(), 0..8);
        (prop::sample::select(self.seeds.clone()), changes).prop_map(move |(seed, changes)| {
            let change = |input: Vec<u8>, change: &Mutation| change.apply(input, &seeds);
            changes.iter().fold(seed, change)
        })
    }
}

/// A test of a target: its seeds as they are, bytes by chance, and changed seeds.
macro_rules! bounded {
    ($name:ident, $target:ident, $cases:expr) => {
        #[test]
        fn $name() {
            let target = $target();
            for seed in &target.seeds {
                target.check(seed).unwrap();
            }
            let config = ProptestConfig {
                cases: $cases,
                failure_persistence: None,
                ..ProptestConfig::default()
            };
            let chance = prop::collection::vec(any::<u8>(), 0..600);
            let inputs = prop_oneof![1 => chance, 9 => target.inputs()];
            proptest!(config, |(input in inputs)| target.check(&input)?);
        }
    };
}

bounded!(frames_of_any_bytes, frames, 3_000);
bounded!(knowledge_of_any_bytes, knowledge, 2_000);
bounded!(logs_of_any_bytes, logs, 400);
bounded!(arenas_of_any_text, arenas, 400);
bounded!(maps_of_any_bytes, maps, 400);
bounded!(tables_of_any_text, tables, 2_000);

#[test]
fn the_seeds_reach_what_lies_behind_the_checks() {
    use rover_log::replayable::Sessions;
    use rover_log::table::{Columns, Drive};
    use rover_shared::wire::frame::Decoder;
    use rover_shared::wire::message::Report;
    use rover_simulator::arena::ArenaSource;
    let reports = seeds::frames();
    let whole = |bytes: &Vec<u8>| {
        let mut decoder = Decoder::new();
        bytes
            .iter()
            .any(|byte| matches!(decoder.push::<Report>(*byte), Some(Ok(_))))
    };
    assert!(reports.iter().filter(|seed| whole(seed)).count() > 5);
    for seed in seeds::knowledge() {
        assert!(rover_log::knowledge::from_bytes(&seed).is_ok());
        assert_eq!(entry_points::seal::knowledge(&seed), seed);
    }
    for seed in seeds::logs() {
        let sessions = Sessions::read(&[&seed]).unwrap();
        assert!(sessions.sessions.iter().any(|s| !s.entries.is_empty()));
        assert_eq!(entry_points::seal::log(&seed), seed);
    }
    for seed in seeds::arenas() {
        assert!(ArenaSource::read("a.toml".as_ref(), &mut |_| Ok(seed.clone())).is_ok());
    }
    let drive = &seeds::tables()[0];
    let drive = Drive::from_csv("a".into(), &drive[..], &Columns::default()).unwrap();
    assert!(drive.rows.len() > 5);
}

/// Ten million inputs, or as many as the environment variable `FUZZ_INPUTS` says.
#[test]
#[ignore = "takes many minutes, in release"]
fn ten_million_inputs() {
    let inputs = std::env::var("FUZZ_INPUTS").map_or(10_000_000, |n| n.parse().unwrap());
    let mut failures = Vec::new();
    // One panic's message is enough; the input that caused it is printed below.
    for target in [frames(), knowledge(), logs(), arenas(), maps(), tables()] {
        let count = inputs * target.share / 1_000_000;
        let (start, most) = (Instant::now(), AtomicUsize::new(0));
        let failure = (0..count).into_par_iter().find_map_any(|number| {
            let mut rng = Pcg32::new(number, target.share);
            let input = mutation::input(&mut rng, &target.seeds);
            let entered = catch_unwind(AssertUnwindSafe(|| target.enter(&input)));
            match entered {
                Ok(taken) if taken <= target.memory_for(&input) => {
                    most.fetch_max(taken, Ordering::Relaxed);
                    None
                }
                Ok(taken) => Some((number, format!("{taken} bytes taken"), input)),
                Err(_) => Some((number, "a panic".into(), input)),
            }
        });
        let (seconds, most) = (start.elapsed().as_secs(), most.into_inner() / 1024);
        println!(
            "{:10} {count:>9} inputs, {seconds:>5} s, {most:>6} kB at most",
            target.name
        );
        if let Some((number, what, input)) = failure {
            let path = std::env::temp_dir().join(format!("fuzzing-{}-{number}", target.name));
            std::fs::write(&path, input).unwrap();
            failures.push(format!(
                "{} {number}: {what}: {}",
                target.name,
                path.display()
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
