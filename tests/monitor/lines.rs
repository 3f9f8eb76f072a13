//! The dashboard as lines.

use std::collections::VecDeque;
use std::time::Duration;

use rover_cli::monitor::Feed;
use rover_cli::monitor::plain::{Plain, understand};
use rover_cli::monitor::player::Player;
use rover_cli::monitor::terminal::{Input, Lines, tell};

use crate::scene::{Scene, simulation};

const SECOND: Duration = Duration::from_secs(1);

/// What is told, with lines typed at these seconds.
fn told(feed: &mut dyn Feed, every: Duration, typed: &[(u64, &str)]) -> Vec<String> {
    told_as(feed, Lines::Plain(Plain::new(every)), typed)
}

fn told_as(feed: &mut dyn Feed, made: Lines, typed: &[(u64, &str)]) -> Vec<String> {
    let mut typed = VecDeque::from(typed.to_vec());
    let start = feed.now();
    let mut next = |now: Duration| {
        let due = |&&(second, _): &&(u64, &str)| now - start >= SECOND * second as u32;
        let (_, line) = *typed.front().filter(due)?;
        typed.pop_front();
        Some(match line {
            "^C" => Input::Interrupt,
            line => Input::Line(line.into()),
        })
    };
    let mut lines = Vec::new();
    let mut print = |line: &str| {
        lines.push(line.to_owned());
        true
    };
    tell(feed, made, &mut next, &mut print).expect("the rover acknowledges");
    lines
}

fn assert_has(lines: &[String], part: &str) {
    let found = lines.iter().any(|line| line.contains(part));
    assert!(found, "no \"{part}\" in:\n{}", lines.join("\n"));
}

#[test]
fn a_rover_is_steered_and_heard_by_lines() {
    let mut scene = Scene::unseen(1);
    let typed = [
        (1, "learn"),
        (2, "arm"),
        (3, "learn"),
        (30, "status"),
        (31, "patterns"),
        (32, "staircases"),
        (33, "direction 90"),
        (34, "direction north"),
        (35, "dance"),
        (36, ""),
        (40, "quit"),
    ];
    let lines = told(&mut scene.feed, SECOND, &typed);
    for part in [
        "refused: mode learn: the rover is disarmed; arm it first",
        "done: arm",
        "DRIVING (learn)",
        "connected to boardless",
        ": pattern ",
        " patterns after ",
        "range sensor front left: ",
        "frames lost",
        " times, ",
        "front steps ",
        "done: direction 90.0 deg",
        "\"north\": expected degrees clockwise",
        "not understood; type: arm",
        "done: disarm",
        "DISARMED",
    ] {
        assert_has(&lines, part);
    }
    for line in &lines {
        assert!(line.is_ascii(), "{line}");
        assert!(!line.contains('\u{1b}'), "{line}");
    }
}

#[test]
fn actions_are_told_no_more_often_than_asked_for() {
    let actions = |every| {
        let mut scene = Scene::unseen(1);
        let typed = [(1, "arm"), (2, "learn"), (62, "^C")];
        let lines = told(&mut scene.feed, every, &typed);
        let action = |line: &&String| line.contains(" action ");
        lines.iter().filter(action).count()
    };
    let all = actions(Duration::ZERO);
    assert!(all > 30, "{all} actions in a minute");
    let few = actions(10 * SECOND);
    assert!((5..=7).contains(&few), "{few} in a minute");
}

#[test]
fn a_log_that_was_cut_off_says_so_at_its_end() {
    let told_of = |cut_off| {
        let mut log = simulation();
        log.cut_off = cut_off;
        let mut player = Player::of_simulation("learn.mcap".into(), log);
        let lines = told(&mut player, 10 * SECOND, &[]);
        lines
            .iter()
            .filter(|line| line.contains("cut off here"))
            .count()
    };
    assert_eq!([told_of(false), told_of(true)], [0, 1]);
}

#[test]
fn a_log_is_told_to_its_end() {
    let mut player = Player::of_simulation("learn.mcap".into(), simulation());
    let lines = told(&mut player, 10 * SECOND, &[]);
    assert_has(&lines, "trial 4 ended");
    assert_has(&lines, "actions before it not told");
}

#[test]
fn when_nobody_reads_the_rover_is_stopped() {
    let mut scene = Scene::learning(1, 10);
    let mut read = 3;
    let mut print = |_: &str| {
        read -= 1;
        read > 0
    };
    let made = Lines::Plain(Plain::new(Duration::ZERO));
    let told = tell(&mut scene.feed, made, &mut |_| None, &mut print);
    assert_eq!(told, Ok(()));
    scene.run(2);
    assert!(scene.picture(80, 24).contains("DISARMED"));
}

#[test]
fn programs_are_told_everything_as_json() {
    let mut scene = Scene::unseen(1);
    let typed = [(1, "arm"), (2, "learn"), (3, "dance"), (60, "quit")];
    let lines = told_as(&mut scene.feed, Lines::Json, &typed);
    let mut topics = std::collections::BTreeMap::<String, u32>::new();
    for line in &lines {
        let value: serde_json::Value = serde_json::from_str(line).expect("each is JSON");
        assert!(
            value["at_us"].is_u64() && value["message"].is_object(),
            "{line}"
        );
        let topic = value["topic"].as_str().expect("each has a topic");
        *topics.entry(topic.into()).or_default() += 1;
    }
    for topic in [
        "/connection",
        "/hello",
        "/status",
        "/action",
        "/event",
        "/answer",
        "/said",
    ] {
        assert!(topics.contains_key(topic), "no {topic} in {topics:?}");
    }
    assert!(topics["/action"] > 20, "no action is left out: {topics:?}");
}

#[test]
fn every_line_that_the_help_names_is_understood() {
    for line in [
        "arm",
        "disarm",
        "",
        "learn",
        "run",
        "idle",
        "direction 15",
        "fixed",
        "wander",
        "store",
        "status",
        "patterns",
        "staircases",
        "help",
        "quit",
        "leave",
    ] {
        assert!(understand(line).is_ok(), "{line}");
    }
    for line in [
        "arm now",
        "direction",
        "direction 1 2",
        "direction 400",
        "x",
    ] {
        assert!(understand(line).is_err(), "{line}");
    }
}
