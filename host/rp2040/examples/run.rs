//! Runs a program and prints what it writes over RTT, and each change of a pin that it drives.
//!
//! ```text
//! cargo run -p emulated-rp2040 --example run -- FILE.elf --seconds 2
//! ```
//!
//! Log lines of defmt are decoded with `--features defmt`.

use std::error::Error;

use emulated_rp2040::Machine;
use emulated_rp2040::bus::Boot;
use emulated_rp2040::elf::Image;
use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use emulated_rp2040::pins::{Output, PINS};
use emulated_rp2040::rtt::Reader;

const USAGE: &str = "usage: run FILE.elf [--seconds N]";
const SECOND: Cycles = 1_000_000 * CYCLES_PER_MICROSECOND;
/// How often RTT is read.
const READ_EVERY: Cycles = SECOND / 1_000;

/// What to run, and for how many seconds.
fn arguments() -> Result<(String, f64), Box<dyn Error>> {
    let (mut file, mut seconds) = (None, 1.0);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--seconds" => seconds = arguments.next().ok_or(USAGE)?.parse()?,
            _ if argument.starts_with('-') || file.is_some() => return Err(USAGE.into()),
            _ => file = Some(argument),
        }
    }
    Ok((file.ok_or(USAGE)?, seconds))
}

/// Where the program's lines come from.
enum Lines {
    Text(Reader),
    #[cfg(feature = "defmt")]
    Defmt(emulated_rp2040::defmt::Log),
}

impl Lines {
    #[cfg(feature = "defmt")]
    fn of(file: &[u8], image: &Image) -> Result<Self, Box<dyn Error>> {
        let log = emulated_rp2040::defmt::Log::new(file, image)?;
        Ok(log.map_or_else(|| Self::Text(Reader::new(image)), Self::Defmt))
    }

    #[cfg(not(feature = "defmt"))]
    fn of(_: &[u8], image: &Image) -> Result<Self, Box<dyn Error>> {
        Ok(Self::Text(Reader::new(image)))
    }

    fn take(&mut self, machine: &mut Machine) -> Vec<String> {
        match self {
            Self::Text(reader) => reader.lines(machine),
            #[cfg(feature = "defmt")]
            Self::Defmt(log) => log.lines(machine),
        }
    }
}

fn print(at: Cycles, what: &str) {
    println!("{:>12.6} s  {what}", at as f64 / SECOND as f64);
}

fn shown(output: Output) -> String {
    match output {
        Output::Floating => "input".into(),
        Output::Level(false) => "low".into(),
        Output::Level(true) => "high".into(),
        Output::Pulses(pulses) => format!("high {:.1} % of the time", 100.0 * pulses.duty()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (path, seconds) = arguments()?;
    let file = std::fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
    let image = Image::parse(&file).map_err(|error| format!("{path}: {error}"))?;
    let mut lines = Lines::of(&file, &image)?;
    let mut machine = Machine::new(&image, 0)?;
    let mut outputs = [Output::Floating; PINS];
    let end = (seconds * SECOND as f64) as Cycles;
    while machine.now() < end {
        let pause = (machine.now() + READ_EVERY).min(end);
        while machine.now() < pause {
            machine.run_to_event(pause);
            for (pin, known) in outputs.iter_mut().enumerate() {
                let output = machine.output(pin);
                if output != *known {
                    *known = output;
                    print(machine.now(), &format!("GPIO{pin} {}", shown(output)));
                }
            }
        }
        for line in lines.take(&mut machine) {
            print(machine.now(), &line);
        }
    }
    if machine.boot() != Boot::Started {
        println!("the flash has no valid second stage: the boot ROM starts nothing");
    }
    for incident in machine.incidents().first() {
        print(incident.at, &incident.kind.to_string());
    }
    if let Some(first) = machine.unmodelled() {
        let what = format!(
            "first access to a peripheral not modelled, {:#010x}",
            first.address
        );
        print(first.at, &what);
    }
    Ok(())
}
