//! Logs, recordings and knowledge that were written once are read, replayed and drawn, and what is
//! written today is what its schemas say.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

#[path = "support/formats.rs"]
mod formats;
#[path = "support/json_schema.rs"]
mod json_schema;
#[path = "support/rewrite.rs"]
mod rewrite;

use std::collections::BTreeMap;
use std::io::Cursor;

use formats::{contents, logs};
use json_schema::validate;
use mcap::WriteOptions;
use rewrite::{rewrite, rewrite_with};
use rover_figure::Recording as Drawn;
use rover_log::recording::{Recording, Topic, What};
use rover_log::replay::{self, Replayed};
use rover_log::replayable::Sessions;
use rover_log::{Log, LogWriter, Origin, knowledge};
use rover_shared::wire::message::Report;
use serde_json::Value;

fn replayed(files: &[Vec<u8>]) -> Replayed {
    replay::verify_sessions(&Sessions::read(files).unwrap()).unwrap()
}

#[test]
fn old_logs_replay_to_the_same_bits() {
    let counts = logs().into_iter().map(|files| {
        let replayed = replayed(&files);
        assert_eq!(replayed.difference, None);
        assert!(replayed.complete, "{replayed:?}");
        (replayed.sessions, replayed.trials, replayed.steps)
    });
    let expected = [(1, 3, 18), (1, 2, 16), (1, 0, 30), (1, 0, 8)];
    assert_eq!(counts.collect::<Vec<_>>(), expected);
}

#[test]
fn an_old_recording_has_all_its_kinds_of_messages() {
    let recording = Recording::read(&[contents("drive.mcap.lz4")]).unwrap();
    let count = |is: fn(&What) -> bool| {
        let messages = recording.messages.iter();
        messages.filter(|message| is(&message.what)).count()
    };
    let actions = count(|what| matches!(what, What::Report(r) if matches!(**r, Report::Action(_))));
    assert_eq!(actions, 30);
    assert_eq!(count(|what| matches!(what, What::Truth(_))), 30);
    assert!(count(|what| matches!(what, What::Command(_))) > 3);
    assert!(count(|what| matches!(what, What::Knowledge(_))) > 0);
    let scenario = recording.arena.unwrap().scenario(None).unwrap();
    assert_eq!(scenario.world.width_cm(), 500.0);
}

#[test]
fn a_part_that_is_missing_is_noticed_by_its_checksum() {
    let second = contents("parts-2.mcap.lz4");
    let other = contents("drive.mcap.lz4");
    let gap = |files: &[Vec<u8>]| {
        let recording = Recording::read(files).unwrap();
        recording
            .messages
            .iter()
            .any(|message| match &message.what {
                What::Gap(gap) => gap.reason.contains("does not follow"),
                _ => false,
            })
    };
    assert!(!gap(&[contents("parts.mcap.lz4"), second.clone()]));
    assert!(gap(&[other, second]));
}

#[test]
fn old_knowledge_is_read_and_written_alike() {
    for (name, patterns, steps) in [("target.rover", 8, 18), ("drive.rover", 12, 30)] {
        let bytes = contents(name);
        let (known, parameters) = knowledge::from_bytes(&bytes).unwrap();
        assert_eq!(known.patterns.elements().len(), patterns);
        assert_eq!(known.steps, steps);
        assert_eq!(knowledge::to_bytes(&known, &parameters), bytes);
    }
    let log = Log::read(&contents("target.mcap")).unwrap();
    assert_eq!(log.after, Some(contents("target.rover")));
}

#[test]
fn figures_are_drawn_from_old_logs() {
    for files in logs() {
        let log = Log::read_parts(&files).unwrap();
        let drawn = vec![("old.mcap".into(), Drawn::new(&log).unwrap())];
        let figures = rover_figure::of_recordings(&drawn, Default::default()).unwrap();
        assert!(figures.figures.len() > 5, "{}", figures.figures.len());
        for figure in &figures.figures {
            roxmltree::Document::parse(&figure.svg).unwrap();
        }
    }
}

/// Today's schemas of all channels.
fn schemas() -> BTreeMap<String, Value> {
    let mut schemas = BTreeMap::new();
    let origin = Origin {
        seed: 1,
        mode: rover_shared::learning::Mode::Learn,
        writer: "test".into(),
    };
    let log = LogWriter::new(Cursor::new(Vec::new()), &origin, &[]).unwrap();
    let file = log.finish(&[]).unwrap().into_inner();
    for channel in mcap::Summary::read(&file)
        .unwrap()
        .unwrap()
        .channels
        .values()
    {
        let schema = &channel.schema.as_ref().unwrap().data;
        schemas.insert(
            channel.topic.clone(),
            serde_json::from_slice(schema).unwrap(),
        );
    }
    for topic in Topic::ALL {
        schemas.insert(topic.name().into(), topic.schema().to_value());
    }
    schemas
}

#[test]
fn old_messages_are_what_their_schemas_and_todays_say() {
    let today = schemas();
    let mut topics = BTreeMap::new();
    for file in logs().concat() {
        for message in mcap::MessageStream::new(&file).unwrap() {
            let message = message.unwrap();
            let topic = message.channel.topic.as_str();
            let theirs = &message.channel.schema.as_ref().unwrap().data;
            let theirs: Value = serde_json::from_slice(theirs).unwrap();
            let mut value: Value = serde_json::from_slice(&message.data).unwrap();
            validate(&theirs, &value).unwrap_or_else(|error| panic!("{topic}: {error}"));
            // The checksum of format 1.
            assert!(value.as_object_mut().unwrap().remove("chain").is_some());
            validate(&today[topic], &value).unwrap_or_else(|error| panic!("{topic}: {error}"));
            *topics.entry(topic.to_owned()).or_insert(0) += 1;
            // No schema allows for other fields, or goes without one.
            let fields = value.as_object_mut().unwrap();
            fields.insert("other".into(), 1.into());
            assert!(validate(&today[topic], &value).is_err(), "{topic}");
            let fields = value.as_object_mut().unwrap();
            fields.remove("other");
            let name = fields.keys().next().unwrap().clone();
            fields.remove(&name);
            assert!(
                validate(&today[topic], &value).is_err(),
                "{topic} without {name}"
            );
        }
    }
    for topic in [
        "/arena",
        "/step",
        "/end",
        "/action",
        "/truth",
        "/command",
        "/knowledge",
    ] {
        assert!(topics[topic] > 0, "{topic}");
    }
}

#[test]
fn what_other_tools_write_anew_replays_too() {
    let all: fn(&str, &mut String) -> bool = |_, _| true;
    for files in logs() {
        let expected = replayed(&files);
        // Without checksums, without chunks.
        for chunks in [true, false] {
            let options = WriteOptions::new()
                .use_chunks(chunks)
                .calculate_chunk_crcs(false)
                .calculate_data_section_crc(false)
                .calculate_attachment_crcs(false);
            let anew: Vec<_> = files
                .iter()
                .map(|file| rewrite_with(options.clone(), file, all))
                .collect();
            assert_eq!(replayed(&anew), expected);
        }
        // Without channels that no replay needs.
        let filtered: Vec<_> = files
            .iter()
            .map(|file| rewrite(file, |topic, _| !["/status", "/arena"].contains(&topic)))
            .collect();
        let replayed = replayed(&filtered);
        assert_eq!(replayed.steps, expected.steps);
        assert!(replayed.complete && replayed.difference.is_none());
    }
}
