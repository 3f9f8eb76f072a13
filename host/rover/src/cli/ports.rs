//! `rover ports`

use std::fmt::Write as _;

use super::output::{Failure, answer};
use rover_link::discovery;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// List all serial ports, not only rovers
    #[arg(long)]
    all: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut found = discovery::ports()?;
    found.retain(|port| arguments.all || port.rover);
    if found.is_empty() && !arguments.json {
        eprintln!(
            "rover: no {} found: connect the rover by USB, or try `rover emulate`",
            if arguments.all {
                "serial port"
            } else {
                "rover"
            }
        );
    }
    let mut text = String::new();
    for port in &found {
        let usb = port.usb.as_ref();
        let name = usb.and_then(|usb| usb.product_name.as_deref());
        let number = port.serial_number().unwrap_or("-");
        let mark = if port.rover { "rover" } else { "-" };
        let name = name.unwrap_or("-");
        let _ = writeln!(text, "{:<20} {mark:<6} {number:<18} {name}", port.path);
    }
    answer(arguments.json, &found, text)
}
