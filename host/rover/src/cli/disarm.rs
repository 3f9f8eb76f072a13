//! `rover disarm`

use rover_link::{Client, names};
use rover_shared::contract::State;
use serde_json::json;

use super::output::Failure;
use super::port::PortAndFormat;

pub fn run(arguments: &PortAndFormat) -> Result<(), Failure> {
    // Without an introduction: a rover of another revision must stop too.
    Client::disarm(arguments.port.open()?)?;
    let state = State::Disarmed;
    arguments.answer(&json!({ "state": state }), names::state(state))
}
