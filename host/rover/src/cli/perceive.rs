//! `rover perceive`

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::perception::{Corners, Noise};
use rover_shared::random::Generator;
use serde::{Deserialize, Serialize};

use super::{Failure, print, print_json, read_parameters};
use rover_log::results::{drawing, time_units};
use rover_simulator::reference::Reference;

#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("input").required(true)))]
pub struct Arguments {
    /// Initial states of the corners: front, left, right, target
    #[arg(
        long,
        value_name = "F,L,R,T",
        group = "input",
        allow_hyphen_values = true
    )]
    #[arg(value_delimiter = ',', num_args = 1)]
    corners: Option<Vec<f64>>,
    /// Table of initial states with the columns f,l,r,t,n0..n15 (corners, noise of layer 2)
    #[arg(long, value_name = "FILE.csv", group = "input")]
    from: Option<PathBuf>,
    /// Seed of the noise that layer 2 starts from
    #[arg(long, default_value_t = 1, conflicts_with = "from")]
    noise_seed: u64,
    /// Fixed point as on the board, or the paper's Euler integration in floating point
    #[arg(long, value_enum, default_value_t = Engine::Fixed)]
    engine: Engine,
    /// Parameters of the network (TOML, section [lattice]); what it leaves out is the paper's
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
enum Engine {
    /// The exponential integrator in fixed point that runs on the board
    Fixed,
    /// Explicit Euler in f64, dt = 0.001, N = 100,000: the paper to the letter, some 400 times slower
    Reference,
}

/// Where the network starts from.
#[derive(Clone, Copy, Debug)]
struct Start {
    corners: [f64; 4],
    noise: [f64; 16],
}

/// Where it went: no code if it did not settle.
#[derive(Clone, Copy, Debug, Serialize)]
struct Grown {
    code: Option<u16>,
    settle_time: Option<f64>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let parameters = read_parameters(arguments.parameters.as_deref(), Parameters::PAPER)?;
    let coefficients = Coefficients::new(&parameters)?;
    match (&arguments.from, &arguments.corners) {
        (Some(path), _) => table(arguments, path, &coefficients),
        (None, corners) => single(
            arguments,
            corners.as_deref().unwrap_or_default(),
            &coefficients,
        ),
    }
}

fn single(arguments: &Arguments, corners: &[f64], c: &Coefficients) -> Result<(), Failure> {
    let corners = <[f64; 4]>::try_from(corners).map_err(|_| {
        let found = corners.len();
        Failure::Usage(format!(
            "--corners has {found} values, expected 4: front,left,right,target"
        ))
    })?;
    let noise = Noise::draw(&mut Generator::new(arguments.noise_seed));
    let noise = noise.0.map(|raw| f64::from(raw) / NOISE_ONE);
    let start = Start { corners, noise };
    check(&start).map_err(|problem| Failure::Usage(format!("--corners: {problem}")))?;
    let grown = grow(arguments.engine, &start, c);
    if arguments.json {
        return print_json(&grown);
    }
    let Some((code, time)) = grown.code.zip(grown.settle_time) else {
        return Err(Failure::Failed(
            "the network did not settle; another --noise-seed decides".into(),
        ));
    };
    let picture = drawing(rover_shared::perception::PatternCode(code)).join("\n");
    print(&format!(
        "{picture}\ncode {code}, settled at t = {time:.1}\n"
    ))
}

/// A line of the table.
#[derive(Debug, Deserialize)]
struct Line {
    f: f64,
    l: f64,
    r: f64,
    t: f64,
    n0: f64,
    n1: f64,
    n2: f64,
    n3: f64,
    n4: f64,
    n5: f64,
    n6: f64,
    n7: f64,
    n8: f64,
    n9: f64,
    n10: f64,
    n11: f64,
    n12: f64,
    n13: f64,
    n14: f64,
    n15: f64,
}

impl Line {
    fn start(&self) -> Start {
        let Self {
            f,
            l,
            r,
            t,
            n0,
            n1,
            n2,
            n3,
            n4,
            n5,
            n6,
            n7,
            n8,
            n9,
            ..
        } = *self;
        let Self {
            n10,
            n11,
            n12,
            n13,
            n14,
            n15,
            ..
        } = *self;
        Start {
            corners: [f, l, r, t],
            noise: [
                n0, n1, n2, n3, n4, n5, n6, n7, n8, n9, n10, n11, n12, n13, n14, n15,
            ],
        }
    }
}

fn table(arguments: &Arguments, path: &Path, c: &Coefficients) -> Result<(), Failure> {
    let (header, starts) = read(path)?;
    let grown: Vec<Grown> = starts
        .par_iter()
        .map(|(_, start)| grow(arguments.engine, start, c))
        .collect();
    if arguments.json {
        return print_json(&grown);
    }
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(header.iter().chain(["code", "settle_time"]))?;
    for ((input, _), grown) in starts.iter().zip(&grown) {
        let code = grown.code.map_or(String::new(), |code| code.to_string());
        let time = grown
            .settle_time
            .map_or(String::new(), |time| time.to_string());
        out.write_record(input.iter().chain([code.as_str(), time.as_str()]))?;
    }
    let bytes = out.into_inner().map_err(|error| error.into_error())?;
    print(&String::from_utf8_lossy(&bytes))
}

type Inputs = (csv::StringRecord, Vec<(csv::StringRecord, Start)>);

fn read(path: &Path) -> Result<Inputs, Failure> {
    let name = path.display();
    let fail = |what: String| Failure::Failed(format!("{name}: {what}"));
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| fail(format!("cannot be read: {error}")))?;
    let header = reader
        .headers()
        .map_err(|error| fail(format!("line 1: {error}")))?
        .clone();
    let names = ["f", "l", "r", "t"].map(String::from).into_iter();
    let missing: Vec<_> = names
        .chain((0..16).map(|i| format!("n{i}")))
        .filter(|name| !header.iter().any(|column| column == name))
        .collect();
    if !missing.is_empty() {
        let missing = missing.join(", ");
        return Err(fail(format!(
            "line 1: column {missing} is missing, expected f,l,r,t,n0..n15"
        )));
    }
    let mut starts = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| fail(error.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let parsed: Line = record
            .deserialize(Some(&header))
            .map_err(|error| fail(format!("line {line}: {error}, expected 20 numbers")))?;
        let start = parsed.start();
        check(&start).map_err(|problem| fail(format!("line {line}: {problem}")))?;
        starts.push((record, start));
    }
    if starts.is_empty() {
        return Err(fail("has no lines below the column names".into()));
    }
    Ok((header, starts))
}

/// What stands for 1 in [`Corners`] and in [`Noise`].
const CORNER_ONE: f64 = (1u32 << Corners::FRACTION_BITS) as f64;
const NOISE_ONE: f64 = (1u32 << Noise::FRACTION_BITS) as f64;
/// Noise that layer 2 can start from.
const LARGEST_NOISE: f64 = Noise::MAX as f64 / NOISE_ONE;

fn check(start: &Start) -> Result<(), String> {
    let largest = f64::from(Corners::MAX) / CORNER_ONE;
    if let Some(bad) = start
        .corners
        .iter()
        .find(|c| c.is_nan() || c.abs() > largest)
    {
        return Err(format!(
            "corner {bad}, expected a number from -{largest} to {largest}"
        ));
    }
    if let Some(bad) = start
        .noise
        .iter()
        .find(|n| n.is_nan() || n.abs() > LARGEST_NOISE)
    {
        return Err(format!(
            "noise {bad}, expected a number from -{LARGEST_NOISE} to {LARGEST_NOISE}"
        ));
    }
    Ok(())
}

fn grow(engine: Engine, start: &Start, c: &Coefficients) -> Grown {
    match engine {
        Engine::Fixed => {
            let corners = Corners(start.corners.map(|x| (x * CORNER_ONE).round() as i32));
            let noise = Noise(start.noise.map(|x| (x * NOISE_ONE).round() as i32));
            match c.lattice.settle(&corners, &noise) {
                Ok(settled) => Grown {
                    code: Some(settled.code.0),
                    settle_time: Some(time_units(settled.time)),
                },
                Err(_) => Grown {
                    code: None,
                    settle_time: None,
                },
            }
        }
        Engine::Reference => {
            let reference = Reference::new(c.parameters().lattice);
            let pattern = reference.settle(start.corners, start.noise);
            Grown {
                code: pattern.saturated.then_some(pattern.code.0),
                settle_time: pattern.settle_time,
            }
        }
    }
}
