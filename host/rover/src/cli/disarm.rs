//! `rover disarm`

use super::port::PortArguments;
use super::{Failure, print, print_json};
use rover_link::Client;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    port: PortArguments,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    // Without an introduction: a rover of another revision is to be stopped too.
    Client::disarm(arguments.port.open()?)?;
    if arguments.json {
        return print_json(&serde_json::json!({ "state": "Disarmed" }));
    }
    print("disarmed\n")
}
