//! JSON Schemas of a recording's messages. Units stand in the descriptions: the messages are those
//! of the wire, whose types carry them.

use rover_shared::contract::Fault;
use rover_shared::wire::message::CHUNK_BYTES;
use serde_json::{Map, Value, json};

use super::Topic;
use crate::arena::ARENA_SCHEMA;
use crate::message::STEP_SCHEMA;

/// The schema of a channel's messages.
pub fn of(topic: Topic) -> Value {
    match topic {
        Topic::Hello => heard("Hello", "who the rover is", hello()),
        Topic::Action => heard("Action", "one complete action cycle", action()),
        Topic::Event => heard("Event", "something that happened", event()),
        Topic::Fault => heard("Fault", "a fault at the moment it was counted", fault()),
        Topic::Status => heard("Status", "the rover's state, when asked for", status()),
        Topic::Ack => heard("Ack", "the answer to a command", ack()),
        Topic::LastWords => heard("LastWords", "what was kept over a reset", last_words()),
        Topic::Knowledge => own("Knowledge", "what the rover knew", knowledge()),
        Topic::Gap => own("Gap", "what the rover said for a while is missing", gap()),
        Topic::Command => own("Command", "what the host asked for", asked()),
        Topic::Truth => own(
            "Truth",
            "where an emulated rover was before an action",
            truth(),
        ),
        Topic::Arena => serde_json::from_str(ARENA_SCHEMA).unwrap_or_default(),
    }
}

type Fields = Vec<(&'static str, Value)>;

/// A message of the rover.
fn heard(title: &str, description: &str, fields: Fields) -> Value {
    let how = [
        (
            "frame",
            unsigned(
                "number of the frame, counted from 0 after each hello, wraps",
                65_535u64,
            ),
        ),
        (
            "lost_before",
            unsigned(
                "frames missing between the one recorded before and this",
                u32::MAX,
            ),
        ),
    ];
    own(title, description, how.into_iter().chain(fields).collect())
}

fn own(title: &str, description: &str, mut fields: Fields) -> Value {
    fields.push((
        "chain",
        unsigned("CRC-32 of this message and all before it", u32::MAX),
    ));
    let mut schema = object(description, fields);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!(title);
    schema
}

fn object(description: &str, fields: Fields) -> Value {
    let required: Vec<_> = fields.iter().map(|(name, _)| *name).collect();
    let properties: Map<String, Value> = fields
        .into_iter()
        .map(|(name, schema)| (name.to_owned(), schema))
        .collect();
    json!({
        "type": "object", "description": description,
        "properties": properties, "required": required, "additionalProperties": false,
    })
}

fn unsigned(description: &str, maximum: impl Into<u64>) -> Value {
    let maximum: u64 = maximum.into();
    json!({ "type": "integer", "description": description, "minimum": 0, "maximum": maximum })
}

fn integer(description: &str) -> Value {
    json!({ "type": "integer", "description": description })
}

fn text(description: &str) -> Value {
    json!({ "type": "string", "description": description })
}

fn or_null(mut schema: Value) -> Value {
    schema["type"] = json!([schema["type"], "null"]);
    schema
}

fn one_of(description: &str, names: &[&str]) -> Value {
    json!({ "type": "string", "description": description, "enum": names })
}

fn four(description: &str, item: Value) -> Value {
    json!({
        "type": "array", "description": description,
        "items": item, "minItems": 4, "maxItems": 4,
    })
}

/// An enum: names alone, or an object of one field named as the variant.
fn variants(description: &str, names: &[&str], with_content: Fields) -> Value {
    let mut options = Vec::new();
    if !names.is_empty() {
        options.push(json!({ "type": "string", "enum": names }));
    }
    for (name, content) in with_content {
        options.push(object("", vec![(name, content)]));
    }
    json!({ "description": description, "oneOf": options })
}

const TIME: &str = "microseconds since the rover's reset";
const CHANNELS: &str = "front left, front right, left, right";
const CHANNEL_HEALTH: [&str; 7] = [
    "Unknown",
    "Good",
    "Open",
    "Shorted",
    "Frozen",
    "Silent",
    "NotFitted",
];
const COMPASS_HEALTH: [&str; 4] = ["Unknown", "Good", "Silent", "Implausible"];
const MODES: [&str; 4] = ["Idle", "Learn", "Run", "Host"];
const TASKS: [&str; 3] = ["FollowDirection", "FollowChangingDirection", "AimAtTarget"];
const OUTCOMES: [&str; 7] = [
    "Completed",
    "Obstacle",
    "NoProgress",
    "TurnTimeout",
    "CompassLost",
    "Late",
    "Stopped",
];

fn time() -> Value {
    unsigned(TIME, u64::MAX)
}

fn faults(description: &str) -> Value {
    let names: Vec<_> = Fault::ALL
        .iter()
        .map(|fault| format!("{fault:?}"))
        .collect();
    json!({ "type": "string", "description": description, "enum": names })
}

fn counters() -> Value {
    let names: Vec<_> = Fault::ALL
        .iter()
        .map(|fault| format!("{fault:?}"))
        .collect();
    let description = format!("faults counted since the reset: {}", names.join(", "));
    json!({
        "type": "array", "description": description,
        "items": unsigned("a count", u32::MAX), "minItems": names.len(), "maxItems": names.len(),
    })
}

fn counts() -> Value {
    four(
        &format!("median counts of the ADC, 0 to 4095: {CHANNELS}"),
        unsigned("a count", 4_095u64),
    )
}

fn ranges() -> Value {
    let health = one_of("health of a range sensor", &CHANNEL_HEALTH);
    four(&format!("health of the range sensors: {CHANNELS}"), health)
}

fn compass() -> Value {
    one_of("health of the compass", &COMPASS_HEALTH)
}

fn fingerprint() -> Value {
    unsigned(
        "CRC-32/ISCSI of the whole knowledge, which names it",
        u32::MAX,
    )
}

fn state() -> Value {
    variants(
        "what the supervisor allows",
        &["Disarmed", "Armed"],
        vec![
            ("Driving", one_of("who drives", &MODES)),
            ("Faulted", faults("the fault that stands")),
        ],
    )
}

fn direction() -> Value {
    integer("direction to follow, microdegrees, counter-clockwise, -179999999 to 180000000")
}

/// A part of the schema of a simulation's steps, which holds the core's own records too.
fn of_step(name: &str) -> Value {
    serde_json::from_str::<Value>(STEP_SCHEMA)
        .ok()
        .and_then(|mut schema| {
            schema
                .pointer_mut(&format!("/properties/{name}"))
                .map(Value::take)
        })
        .unwrap_or_else(|| json!({ "type": "object" }))
}

fn hello() -> Fields {
    let reasons = [
        "PowerOn",
        "RunPin",
        "Watchdog",
        "Panic",
        "HardFault",
        "Requested",
    ];
    vec![
        ("schema", unsigned("hash of the wire's contract", u32::MAX)),
        ("board", text("the board the firmware was built for")),
        ("firmware", text("version of the firmware")),
        ("reset", one_of("why the rover last started", &reasons)),
        (
            "seed",
            unsigned("seed of the session, or of the next", u64::MAX),
        ),
        ("knowledge", or_null(fingerprint())),
    ]
}

fn action() -> Fields {
    vec![
        ("time", time()),
        ("counts", counts()),
        ("ranges", ranges()),
        ("compass", compass()),
        ("sample", of_step("sample")),
        ("step", of_step("record")),
        ("outcome", one_of("how the move ended", &OUTCOMES)),
        ("counters", counters()),
    ]
}

fn status() -> Fields {
    vec![
        ("time", time()),
        ("state", state()),
        (
            "motors_enabled",
            json!({ "type": "boolean", "description": "whether wheel commands reach the motors" }),
        ),
        ("task", one_of("what is to be done", &TASKS)),
        ("direction", direction()),
        ("steps", unsigned("action cycles since the reset", u32::MAX)),
        ("counts", counts()),
        (
            "distances",
            four(
                &format!("distances by the sensors' curves, micrometres: {CHANNELS}"),
                unsigned("micrometres", u32::MAX),
            ),
        ),
        (
            "heading",
            or_null(integer(
                "where the rover points, microdegrees, counter-clockwise; null without a compass",
            )),
        ),
        ("ranges", ranges()),
        ("compass", compass()),
        ("counters", counters()),
    ]
}

fn event() -> Fields {
    let range = object(
        "a range sensor's health changed",
        vec![
            ("channel", unsigned(&format!("0 to 3: {CHANNELS}"), 3u64)),
            ("health", one_of("from now on", &CHANNEL_HEALTH)),
        ],
    );
    let session = object(
        "the controller begins to drive",
        vec![
            ("mode", one_of("learning or not", &MODES)),
            ("seed", unsigned("what its generator starts from", u64::MAX)),
            ("knowledge", fingerprint()),
        ],
    );
    let stored = object(
        "knowledge is in the flash",
        vec![("fingerprint", fingerprint())],
    );
    let kind = variants(
        "what happened",
        &[],
        vec![
            ("State", state()),
            ("MoveEnded", one_of("how the host's move ended", &OUTCOMES)),
            ("Direction", direction()),
            ("KnowledgeStored", stored),
            ("Range", range),
            ("Compass", compass()),
            ("Session", session),
        ],
    );
    vec![("time", time()), ("kind", kind)]
}

fn fault() -> Fields {
    vec![
        ("time", time()),
        ("fault", faults("which")),
        ("count", unsigned("how often since the reset", u32::MAX)),
    ]
}

fn ack() -> Fields {
    let plain = [
        "NoHello",
        "SchemaMismatch",
        "NotArmed",
        "Armed",
        "KnowledgeInvalid",
        "ControlSilent",
        "FlashBusy",
        "NoHeartbeat",
        "NotHostDriven",
        "MoveUnderWay",
        "OutOfRange",
        "BadCalibration",
        "ChunkOutOfOrder",
        "TooLong",
        "BadChecksum",
        "BadKnowledge",
        "Unsupported",
    ];
    let sensor = object(
        "a range sensor is unfit for use",
        vec![
            ("channel", unsigned(&format!("0 to 3: {CHANNELS}"), 3u64)),
            ("health", one_of("what is wrong", &CHANNEL_HEALTH)),
        ],
    );
    let refusal = variants(
        "why not",
        &plain,
        vec![
            ("Fault", faults("the fault that stands")),
            ("RangeSensor", sensor),
            ("Compass", compass()),
        ],
    );
    let result = variants(
        "done, or why not",
        &[],
        vec![("Ok", json!({ "type": "null" })), ("Err", refusal)],
    );
    vec![
        (
            "sequence",
            unsigned("number of the command's frame", 65_535u64),
        ),
        ("result", result),
    ]
}

fn last_words() -> Fields {
    vec![(
        "text",
        text("what the run before the last reset ended with"),
    )]
}

fn knowledge() -> Fields {
    vec![
        ("fingerprint", fingerprint()),
        ("length_bytes", unsigned("its length in bytes", u32::MAX)),
    ]
}

fn asked() -> Fields {
    let sequence = unsigned(
        "number of the frame, which its acknowledgement names",
        65_535u64,
    );
    vec![("sequence", sequence), ("command", command())]
}

fn command() -> Value {
    let micrometres = |what: &str| unsigned(&format!("{what}, micrometres"), u32::MAX);
    let chunk = object(
        "a part of knowledge",
        vec![
            ("total", unsigned("length of the whole in bytes", u32::MAX)),
            ("fingerprint", fingerprint()),
            ("offset", unsigned("where this part starts", u32::MAX)),
            (
                "data",
                json!({
                    "type": "array", "description": "its bytes",
                    "items": unsigned("a byte", 255u64), "maxItems": CHUNK_BYTES,
                }),
            ),
        ],
    );
    variants(
        "a command",
        &[
            "Ping",
            "Heartbeat",
            "Arm",
            "Disarm",
            "ReadStatus",
            "StoreKnowledge",
            "NewKnowledge",
        ],
        vec![
            (
                "Hello",
                object(
                    "opens the conversation",
                    vec![("schema", unsigned("the host's schema hash", u32::MAX))],
                ),
            ),
            ("SetMode", one_of("who shall drive", &MODES)),
            ("SetTask", one_of("what is to be done", &TASKS)),
            ("SetDirection", direction()),
            (
                "Drive",
                object(
                    "a move",
                    vec![
                        ("turn", integer("turn, microdegrees, positive to the left")),
                        ("advance", micrometres("advance after the turn")),
                    ],
                ),
            ),
            ("SetSeed", unsigned("seed of the generator", u64::MAX)),
            ("Calibrate", calibration()),
            (
                "PullKnowledge",
                object(
                    "asks for a part of the knowledge",
                    vec![("offset", unsigned("first byte wanted", u32::MAX))],
                ),
            ),
            ("PushKnowledge", chunk),
        ],
    )
}

fn calibration() -> Value {
    let per_mille = |what: &str| unsigned(&format!("{what}, per mille"), 65_535u64);
    let point = object(
        "a point of the curve",
        vec![
            ("counts", unsigned("counts of the ADC", 65_535u64)),
            ("distance", unsigned("distance, micrometres", u32::MAX)),
        ],
    );
    variants(
        "a calibration",
        &[],
        vec![
            (
                "Range",
                object(
                    "the curve of a range sensor",
                    vec![
                        ("channel", unsigned(CHANNELS, 255u64)),
                        ("points", json!({ "type": "array", "items": point })),
                    ],
                ),
            ),
            (
                "Compass",
                object(
                    "how the compass is mounted",
                    vec![("offset", integer("added to its heading, microdegrees"))],
                ),
            ),
            (
                "Speed",
                object(
                    "how fast the rover goes",
                    vec![
                        ("duty", per_mille("duty of a straight advance")),
                        (
                            "speed",
                            unsigned("speed at that duty, micrometres a second", u32::MAX),
                        ),
                        (
                            "dead_band",
                            per_mille("duty at which the wheels just begin to turn"),
                        ),
                    ],
                ),
            ),
        ],
    )
}

fn truth() -> Fields {
    let pose = object(
        "where it was",
        vec![
            ("x_um", integer("from the left wall, micrometres")),
            ("y_um", integer("from the lower wall, micrometres")),
            (
                "heading_udeg",
                integer("counter-clockwise from right, microdegrees"),
            ),
        ],
    );
    vec![("time", time()), ("pose", pose)]
}

fn gap() -> Fields {
    vec![("reason", text("why"))]
}
