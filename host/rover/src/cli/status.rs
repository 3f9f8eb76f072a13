//! `rover status`

use std::fmt::Write as _;

use rover_shared::wire::message::{Hello, Status};
use serde::Serialize;

use super::output::Failure;
use super::port::PortAndFormat;
use crate::lines;
use rover_link::{names, text};

#[derive(Serialize)]
struct Answer<'a> {
    port: &'a str,
    hello: &'a Hello,
    status: Status,
}

pub fn run(arguments: &PortAndFormat) -> Result<(), Failure> {
    let mut client = arguments.port.connect()?;
    let status = client.status()?;
    let answer = Answer {
        port: client.port_name(),
        hello: client.hello(),
        status,
    };
    arguments.answer(&answer, describe(&answer))
}

fn describe(answer: &Answer<'_>) -> String {
    let Answer {
        port,
        hello,
        status,
    } = answer;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<12} {value}");
    };
    line("port", (*port).into());
    line("rover", lines::hello(hello));
    line(
        "running for",
        format!("{:.1} s", status.time.0 as f64 / 1e6),
    );
    let (state, motors) = (status.state, lines::motors(status.motors_enabled));
    line("state", format!("{}, {motors}", names::state(state)));
    line("task", names::task(status.task).into());
    line("direction", text::compass(status.direction));
    line("actions", status.steps.to_string());
    line(
        "compass",
        match status.heading {
            Some(heading) => text::compass(heading),
            None => names::compass_health(status.compass).into(),
        },
    );
    for (channel, health) in (0..).zip(status.ranges) {
        let i = usize::from(channel);
        let cm = text::centimetres(status.distances[i]);
        let counts = status.counts[i];
        line(
            names::channel(channel),
            format!(
                "{counts:>4} counts, {cm:>5} cm, {}",
                names::channel_health(health)
            ),
        );
    }
    let faults: Vec<_> = lines::counted(&status.counters)
        .map(|(fault, count)| format!("{} {count}", names::fault(fault)))
        .collect();
    line(
        "faults",
        if faults.is_empty() {
            "none".into()
        } else {
            faults.join(", ")
        },
    );
    text
}
