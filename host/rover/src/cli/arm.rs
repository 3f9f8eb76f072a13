//! `rover arm`

use rover_link::names;
use rover_shared::wire::message::{Command, Status};
use serde_json::json;

use super::output::Failure;
use super::port::PortAndFormat;

pub fn run(arguments: &PortAndFormat) -> Result<(), Failure> {
    let mut client = arguments.port.connect()?;
    client.ask(&Command::Arm)?;
    let Status {
        state,
        motors_enabled,
        ..
    } = client.status()?;
    let value = json!({ "state": state, "motors_enabled": motors_enabled });
    arguments.answer(&value, names::state(state))
}
