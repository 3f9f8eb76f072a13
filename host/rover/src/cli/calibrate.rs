//! `rover calibrate`

use std::str::FromStr;

use rover_shared::contract::{CURVE_POINTS, Calibration, ChannelHealth, CompassHealth, CurvePoint};
use rover_shared::motion::Parameters as Chassis;
use rover_shared::sensing::ir::curve::RangeCurve;
use rover_shared::time::Duration;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::Command;
use serde_json::json;

use super::output::Failure;
use super::parse;
use super::port::PortAndFormat;
use rover_link::Client;
use rover_link::names;

/// Statuses that a reading is the median of: a second of a sensor that gives a value every 38 ms.
const READINGS: usize = 25;
const BETWEEN: Duration = Duration::from_millis(40);

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Set where the rover points
    Compass {
        /// Where it points now, in degrees clockwise as compasses have it
        #[arg(value_name = "DEG", value_parser = parse::compass, allow_hyphen_values = true)]
        points_to: Microdegrees,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Set how fast the rover drives
    Speed {
        /// Its speed at that duty, in cm/s
        #[arg(value_name = "CM", value_parser = parse::centimetres)]
        speed: Micrometres,
        /// Duty of a straight advance, per mille
        #[arg(long, default_value_t = Chassis::LYNXMOTION_4WD2.cruise)]
        duty: u16,
        /// Duty at which the wheels just begin to turn, per mille
        #[arg(long, default_value_t = Chassis::LYNXMOTION_4WD2.dead_band)]
        dead_band: u16,
        #[command(flatten)]
        common: PortAndFormat,
    },
    /// Set the distances of a range sensor's counts
    #[command(after_help = "Examples:
  rover calibrate range left --at 10,15,20,30,40,60,80     asks for each distance and reads counts
  rover calibrate range left 496:80 943:40 1712:20         counts and distances in cm")]
    Range {
        /// Which sensor
        #[arg(value_enum)]
        channel: Channel,
        /// Counts and the distance in cm at which the sensor gives them, 2 to 12 points
        #[arg(value_name = "COUNTS:CM", required_unless_present = "at")]
        points: Vec<Point>,
        /// Distances in cm at which to hold a white sheet of paper, one after the other
        #[arg(long, value_name = "CM,...", value_delimiter = ',', conflicts_with = "points",
              value_parser = parse::centimetres)]
        at: Vec<Micrometres>,
        #[command(flatten)]
        common: PortAndFormat,
    },
}

/// The range sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Channel {
    FrontLeft,
    FrontRight,
    Left,
    Right,
}

/// A point of a curve, as `COUNTS:CM`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Point(CurvePoint);

impl FromStr for Point {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected COUNTS:CM, as in 943:40";
        let (counts, cm) = text.split_once(':').ok_or(expected)?;
        let counts = counts.parse().ok().filter(|counts| *counts <= 4_095);
        Ok(Self(CurvePoint {
            counts: counts.ok_or("expected counts from 0 to 4095 before the colon")?,
            distance: parse::centimetres(cm)?,
        }))
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.what {
        What::Compass { points_to, common } => compass(*points_to, common),
        What::Speed {
            speed,
            duty,
            dead_band,
            common,
        } => {
            let calibration = Calibration::Speed {
                duty: *duty,
                speed: *speed,
                dead_band: *dead_band,
            };
            let mut client = common.port.connect()?;
            client.ask(&Command::Calibrate(calibration.clone()))?;
            let cm = f64::from(speed.0) / 1e4;
            tell(
                common,
                &calibration,
                &format!("{cm:.1} cm/s at {duty} per mille"),
            )
        }
        What::Range {
            channel,
            points,
            at,
            common,
        } => range(*channel, points, at, common),
    }
}

fn compass(points_to: Microdegrees, common: &PortAndFormat) -> Result<(), Failure> {
    let mut client = common.port.connect()?;
    // What the compass says itself, without an offset that it was given before.
    let none = Calibration::Compass {
        offset: Microdegrees(0),
    };
    client.ask(&Command::Calibrate(none))?;
    client.wait(Duration::from_millis(300))?;
    let status = client.status()?;
    let Some(heading) = status
        .heading
        .filter(|_| status.compass == CompassHealth::Good)
    else {
        return Err(Failure::Failed(format!(
            "the compass is {}: check it with `rover status`, then calibrate again",
            names::compass_health(status.compass)
        )));
    };
    let offset = points_to.turn_from(heading);
    let calibration = Calibration::Compass { offset };
    client.ask(&Command::Calibrate(calibration.clone()))?;
    let degrees = f64::from(offset.0) / 1e6;
    tell(
        common,
        &calibration,
        &format!("offset {degrees:.1} degrees"),
    )
}

fn range(
    channel: Channel,
    points: &[Point],
    at: &[Micrometres],
    common: &PortAndFormat,
) -> Result<(), Failure> {
    let number = if at.is_empty() {
        points.len()
    } else {
        at.len()
    };
    if !(2..=CURVE_POINTS).contains(&number) {
        return Err(Failure::Usage(format!(
            "{number} points, expected 2 to {CURVE_POINTS}"
        )));
    }
    let mut client = common.port.connect()?;
    let mut points = if at.is_empty() {
        points.iter().map(|point| point.0).collect()
    } else {
        measure(&mut client, channel, at)?
    };
    points.sort_by_key(|point| point.counts);
    if RangeCurve::new(&points).is_err() {
        return Err(Failure::Failed(format!(
            "{} is no curve of such a sensor: counts have to rise where distances fall; below \
             10 cm they do not, so keep farther away",
            listed(&points)
        )));
    }
    let calibration = Calibration::Range {
        channel: channel as u8,
        points: points.iter().copied().collect(),
    };
    client.ask(&Command::Calibrate(calibration.clone()))?;
    tell(common, &calibration, &listed(&points))
}

fn listed(points: &[CurvePoint]) -> String {
    let point =
        |point: &CurvePoint| format!("{}:{}", point.counts, f64::from(point.distance.0) / 1e4);
    points.iter().map(point).collect::<Vec<_>>().join(" ")
}

/// Asks for a sheet of paper at each distance, and reads the counts.
fn measure(
    client: &mut Client,
    channel: Channel,
    at: &[Micrometres],
) -> Result<Vec<CurvePoint>, Failure> {
    let mut lines = std::io::stdin().lines();
    at.iter()
        .map(|&distance| {
            let cm = f64::from(distance.0) / 1e4;
            eprintln!("rover: a white sheet of paper at {cm} cm, then Enter");
            if lines.next().transpose()?.is_none() {
                return Err(Failure::Failed(
                    "the input ended before all distances were measured: start again".into(),
                ));
            }
            let counts = read_counts(client, channel)?;
            eprintln!("rover: {counts} counts");
            Ok(CurvePoint { counts, distance })
        })
        .collect()
}

fn read_counts(client: &mut Client, channel: Channel) -> Result<u16, Failure> {
    let mut counts = [0; READINGS];
    for reading in &mut counts {
        let status = client.status()?;
        let health = status.ranges[channel as usize];
        if health != ChannelHealth::Good {
            return Err(Failure::Failed(format!(
                "the sensor is {}: check it with `rover status`, then calibrate again",
                names::channel_health(health)
            )));
        }
        *reading = status.counts[channel as usize];
        client.wait(BETWEEN)?;
    }
    counts.sort_unstable();
    Ok(counts[READINGS / 2])
}

fn tell(common: &PortAndFormat, calibration: &Calibration, text: &str) -> Result<(), Failure> {
    let value = json!({ "calibration": calibration });
    common.answer(
        &value,
        format_args!("{text}: in force, and stored in the flash"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counts_and_centimetres() {
        let point = |text: &str| text.parse::<Point>().map(|p| (p.0.counts, p.0.distance.0));
        assert_eq!(point("943:40.5"), Ok((943, 405_000)));
        for bad in ["", "943", "943:", ":40", "5000:40", "943:-1", "a:b"] {
            assert!(point(bad).is_err(), "{bad}");
        }
    }
}
