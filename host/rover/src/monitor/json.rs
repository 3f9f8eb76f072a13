//! The dashboard as lines of JSON: one object an event, with the messages of logs.
//!
//! `{"at_us": 1500000, "topic": "/action", "message": {...}}`: `at_us` is the feed's own time;
//! topics and messages are those of [recordings](rover_log::recording) and of
//! [simulations' logs](rover_log), and beside them `/connection`, `/answer`, `/frames`, `/begin`
//! and `/said`.

use std::time::Duration;

use rover_shared::checksum::fingerprint;
use rover_shared::wire::message::Report;
use serde::Serialize;
use serde_json::{Value, json};

use super::feed::{Connection, FeedEvent, Origin};
use rover_link::{explain_by_keys, names};
use rover_log::Entry;
use rover_log::recording::{Gap, LastWords, Pulled, Topic};

/// The line for an event; `None` for those of the display only.
pub fn line(now: Duration, event: &FeedEvent) -> Option<String> {
    let (topic, message) = message(event)?;
    Some(object(now, topic, message))
}

/// The line for a message of this program.
pub fn said(now: Duration, text: &str) -> String {
    object(now, "/said", json!({ "text": text }))
}

fn object(now: Duration, topic: &str, message: Value) -> String {
    let at = u64::try_from(now.as_micros()).unwrap_or(u64::MAX);
    json!({ "at_us": at, "topic": topic, "message": message }).to_string()
}

fn message(event: &FeedEvent) -> Option<(&'static str, Value)> {
    Some(match event {
        FeedEvent::Report(report) => return report_message(report),
        FeedEvent::Connection(connection) => ("/connection", self::connection(connection)),
        FeedEvent::Answer { command, result } => (
            "/answer",
            json!({
                "command": names::command(command),
                "done": result.is_ok(),
                "refusal": result.err().map(value),
                "reason": result.err().map(explain_by_keys),
            }),
        ),
        FeedEvent::Unanswered { command, reason } => (
            "/answer",
            json!({
                "command": names::command(command),
                "done": false,
                "refusal": null,
                "reason": reason,
            }),
        ),
        FeedEvent::Frames(counters) => ("/frames", value(counters)),
        FeedEvent::Begin(Some(Origin { seed, knowledge })) => (
            "/begin",
            json!({ "seed": seed, "knowledge": fingerprint(knowledge) }),
        ),
        FeedEvent::Knowledge(bytes) => (
            Topic::Knowledge.name(),
            value(Pulled {
                fingerprint: fingerprint(bytes),
                length_bytes: u32::try_from(bytes.len()).unwrap_or(u32::MAX),
            }),
        ),
        FeedEvent::Gap(reason) => {
            let reason = reason.clone();
            (Topic::Gap.name(), value(Gap { reason }))
        }
        FeedEvent::Logged(Entry::Step(step)) => ("/step", value(step)),
        FeedEvent::Logged(Entry::End(end)) => ("/end", value(end)),
        FeedEvent::Begin(None) | FeedEvent::Playback(_) => return None,
    })
}

fn report_message(report: &Report) -> Option<(&'static str, Value)> {
    let (topic, message) = match report {
        Report::Hello(hello) => (Topic::Hello, value(hello)),
        Report::Status(status) => (Topic::Status, value(status)),
        Report::Action(action) => (Topic::Action, value(action)),
        Report::Event(event) => (Topic::Event, value(event)),
        Report::Fault(fault) => (Topic::Fault, value(fault)),
        Report::LastWords(text) => {
            let text = text.clone();
            (Topic::LastWords, value(LastWords { text }))
        }
        Report::Ack(_) | Report::Knowledge(_) => return None,
    };
    Some((topic.name(), message))
}

fn connection(connection: &Connection) -> Value {
    let (state, of) = match connection {
        Connection::None => ("none", ""),
        Connection::Searching(port) => ("searching", port.as_str()),
        Connection::Open(port) => ("open", port.as_str()),
        Connection::Lost(reason) => ("lost", reason.as_str()),
        Connection::Log(file) => ("log", file.as_str()),
    };
    json!({ "state": state, "of": of })
}

/// Never fails: types of the contract and of logs have only what JSON has.
fn value(message: impl Serialize) -> Value {
    serde_json::to_value(message).unwrap_or_default()
}
