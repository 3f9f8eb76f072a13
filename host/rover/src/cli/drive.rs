//! `rover drive`

use rover_link::{Client, LinkError, names};
use rover_shared::contract::{Mode, Outcome, State};
use rover_shared::time::Duration;
use rover_shared::units::{Microdegrees, Micrometres};
use rover_shared::wire::message::{Command, EventKind, Report};
use serde_json::json;

use super::interrupt::Interrupt;
use super::output::Failure;
use super::port::PortAndFormat;
use super::{parse, steering, watch};

/// A turn ends after 4 s at the latest, and the longest advance takes some ten.
const MOVE_WITHIN: Duration = Duration::from_millis(60_000);

#[derive(Debug, clap::Args)]
#[command(
    after_help = "The rover has to be armed (--arm, or `rover arm` before), and is disarmed afterwards.
Example:  rover drive --arm --left 20 --advance 7"
)]
pub struct Arguments {
    /// Turn to the left first, in degrees
    #[arg(long, value_name = "DEG", value_parser = parse::turn, conflicts_with = "right")]
    left: Option<Microdegrees>,
    /// Turn to the right first, in degrees
    #[arg(long, value_name = "DEG", value_parser = parse::turn)]
    right: Option<Microdegrees>,
    /// Then advance, in cm, at most 100
    #[arg(long, value_name = "CM", value_parser = parse::advance,
          required_unless_present_any = ["left", "right"])]
    advance: Option<Micrometres>,
    /// Arm first
    #[arg(long)]
    arm: bool,
    #[command(flatten)]
    common: PortAndFormat,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let turn = match (arguments.left, arguments.right) {
        (Some(left), _) => left,
        (None, Some(right)) => Microdegrees(-right.0),
        (None, None) => Microdegrees(0),
    };
    let advance = arguments.advance.unwrap_or_default();
    let mut client = arguments.common.port.connect()?;
    let interrupt = Interrupt::listen()?;
    let began = client.now();
    let armed = if arguments.arm {
        client.ask(&Command::Arm).map_err(Failure::from)
    } else {
        Ok(())
    };
    let drive = Command::Drive { turn, advance };
    let moved = armed.and_then(|()| make(&mut client, &interrupt, &drive));
    let took = client.now().since(began);
    // Whatever happened, it is disarmed.
    steering::stop(&mut client)?;
    let outcome = moved?;
    let seconds = took.0 as f64 / 1e6;
    let value = json!({ "outcome": outcome, "took_s": seconds });
    let text = format!("{} after {seconds:.1} s, disarmed", names::outcome(outcome));
    arguments.common.answer(&value, text)?;
    match outcome {
        Outcome::Completed => Ok(()),
        other => Err(Failure::Failed(format!(
            "the move was not completed: {}: `rover status` tells more",
            names::outcome(other)
        ))),
    }
}

fn make(client: &mut Client, interrupt: &Interrupt, drive: &Command) -> Result<Outcome, Failure> {
    client.send_heartbeats(true)?;
    client.ask(&Command::SetMode(Mode::Host))?;
    client.ask(drive)?;
    let until = client.now().after(MOVE_WITHIN);
    while client.now() < until && !interrupt.is_set() {
        let Some(received) = client.next(Duration::from_millis(100))? else {
            continue;
        };
        if let Some(line) = watch::line(&received.report) {
            eprintln!("rover: {line}");
        }
        if let Report::Event(event) = received.report {
            match event.kind {
                EventKind::MoveEnded(outcome) => return Ok(outcome),
                EventKind::State(State::Faulted(_) | State::Disarmed) => {
                    return Ok(Outcome::Stopped);
                }
                _ => {}
            }
        }
    }
    if interrupt.is_set() {
        return Ok(Outcome::Stopped);
    }
    Err(LinkError::Silent(names::command(drive)).into())
}
