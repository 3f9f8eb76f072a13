//! `rover arm`

use rover_shared::contract::State;
use rover_shared::wire::message::Command;

use super::port::PortArguments;
use super::{Failure, print, print_json};
use rover_link::Client;
use rover_link::names;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut client = arguments.port.connect()?;
    client.ask(&Command::Arm)?;
    tell_state(&mut client, arguments.json)
}

/// Prints what the supervisor allows now.
pub fn tell_state(client: &mut Client, json: bool) -> Result<(), Failure> {
    let status = client.status()?;
    if json {
        #[derive(serde::Serialize)]
        struct Answer {
            state: State,
            motors_enabled: bool,
        }
        return print_json(&Answer {
            state: status.state,
            motors_enabled: status.motors_enabled,
        });
    }
    print(&format!("{}\n", names::state(status.state)))
}
