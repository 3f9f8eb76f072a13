//! Keys, from the keyboard to the rover and back to the screen.

use std::collections::VecDeque;
use std::time::Duration;

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use rover_cli::monitor::feed::Control;
use rover_cli::monitor::terminal::{ShowError, TICK, show};
use rover_cli::monitor::view::Look;
use rover_cli::monitor::{Feed, FeedEvent};
use rover_shared::contract::{Mode, State, Task};
use rover_shared::wire::message::Command;

use crate::scene::Scene;

fn direction(scene: &Scene) -> Option<f64> {
    let direction = scene.app.dashboard.direction?;
    Some(f64::from(direction.0) / 1e6)
}

#[test]
fn a_rover_is_armed_driven_and_stopped() {
    let mut scene = Scene::new(1);
    let state = |scene: &Scene| scene.app.dashboard.state;
    assert_eq!(state(&scene), Some(State::Disarmed));
    for (key, expected) in [
        ("a", State::Armed),
        ("l", State::Driving(Mode::Learn)),
        ("i", State::Armed),
        ("r", State::Driving(Mode::Run)),
        (" ", State::Disarmed),
        ("a", State::Armed),
        ("l", State::Driving(Mode::Learn)),
        ("d", State::Disarmed),
    ] {
        scene.press(key);
        scene.run(1);
        assert_eq!(state(&scene), Some(expected), "{key}");
    }
}

#[test]
fn a_refusal_is_shown_until_something_succeeds() {
    let mut scene = Scene::new(1);
    scene.press("l");
    assert!(scene.app.dashboard.refused.is_some());
    let picture = scene.picture(80, 24);
    assert!(picture.contains("refused: mode learn: the rover is disarmed; arm it first"));
    scene.press("a");
    assert_eq!(scene.app.dashboard.refused, None);
}

#[test]
fn directions_are_turned_and_typed() {
    let mut scene = Scene::new(1);
    scene.press_code(KeyCode::Left);
    scene.press_code(KeyCode::Left);
    scene.run(2);
    assert_eq!(direction(&scene), Some(30.0));
    scene.press_code(KeyCode::Right);
    scene.run(2);
    assert_eq!(direction(&scene), Some(15.0));
    scene.press("g90");
    scene.press_code(KeyCode::Enter);
    scene.run(2);
    assert_eq!(direction(&scene), Some(-90.0), "clockwise, as on a compass");
    scene.press("g4");
    scene.press_code(KeyCode::Esc);
    assert_eq!(scene.app.prompt, None);
    assert_eq!(direction(&scene), Some(-90.0));
}

#[test]
fn stopping_comes_before_a_half_typed_number() {
    let mut scene = Scene::learning(1, 2);
    scene.press("g1 ");
    scene.run(1);
    assert_eq!(scene.app.dashboard.state, Some(State::Disarmed));
    assert_eq!(scene.app.prompt, None);
}

#[test]
fn tasks_are_chosen_and_knowledge_is_stored() {
    let mut scene = Scene::learning(1, 60);
    scene.press(" w");
    scene.run(2);
    let task = |scene: &Scene| scene.app.dashboard.task;
    assert_eq!(task(&scene), Some(Task::FollowChangingDirection));
    scene.press("f");
    scene.run(2);
    assert_eq!(task(&scene), Some(Task::FollowDirection));
    scene.press("s");
    scene.run(2);
    assert!(!scene.rover.borrow().stored().is_empty());
}

/// Shows a source on a screen of the test, with these keys, one every 2 seconds of the source's time.
fn shown(feed: &mut dyn Feed, keys: Vec<KeyEvent>) -> Result<String, ShowError> {
    let mut keys = VecDeque::from(keys);
    let mut screen = Terminal::new(TestBackend::new(80, 24)).expect("it never fails");
    let mut ticks = 0;
    let mut next = |_: Duration| {
        ticks += 1;
        assert!(ticks < 10_000, "it does not end");
        Ok((ticks % 40 == 0).then(|| keys.pop_front()).flatten())
    };
    show(&mut screen, feed, &mut next, Look::default())?;
    Ok(screen.backend().to_string())
}

fn typed(keys: &str) -> Vec<KeyEvent> {
    keys.chars().map(|key| KeyCode::Char(key).into()).collect()
}

/// Whether the rover drives, as it says itself.
fn drives(scene: &mut Scene) -> bool {
    scene.app = Default::default();
    scene.run(2);
    matches!(scene.app.dashboard.state, Some(State::Driving(_)))
}

#[test]
fn leaving_disarms_unless_it_is_not_to() {
    let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    for (end, drives_on) in [
        (typed("q"), false),
        (vec![ctrl_c], false),
        (typed("Q"), true),
    ] {
        let mut scene = Scene::unseen(1);
        let keys = [typed("al"), end.clone()].concat();
        let screen = shown(&mut scene.feed, keys).expect("the rover acknowledges");
        assert!(screen.contains("DRIVING (learn)"), "{screen}");
        // The dashboard says hello again only if the cable was pulled.
        *scene.cable.borrow_mut() = false;
        scene.run(1);
        *scene.cable.borrow_mut() = true;
        assert_eq!(drives(&mut scene), drives_on, "{end:?}");
    }
}

#[test]
fn a_rover_that_cannot_be_told_to_stop_is_not_left_in_silence() {
    let mut scene = Scene::unseen(1);
    let cable = scene.cable.clone();
    let mut keys = VecDeque::from(typed("alq"));
    let mut screen = Terminal::new(TestBackend::new(80, 24)).expect("it never fails");
    let mut ticks = 0;
    let mut next = |_: Duration| {
        ticks += 1;
        *cable.borrow_mut() = ticks < 60;
        Ok((ticks % 40 == 0).then(|| keys.pop_front()).flatten())
    };
    let left = show(&mut screen, &mut scene.feed, &mut next, Look::default());
    let error = left
        .expect_err("it was unplugged while it drove")
        .to_string();
    assert!(error.contains("may still drive"), "{error}");
}

#[test]
fn a_rover_that_says_nothing_keeps_no_key_waiting_and_is_called_silent() {
    let mut scene = Scene::learning(1, 20);
    scene.rover.borrow_mut().lose = u32::MAX;
    scene.run(1);
    let began = scene.feed.now();
    scene.press("aaa");
    // A tick a key, in whole control periods.
    assert!(scene.feed.now() - began < 5 * TICK);
    scene.run(1);
    let picture = scene.picture(80, 24);
    assert!(picture.contains("boardless silent for 2."), "{picture}");
    assert!(picture.contains("as last heard"), "{picture}");
    scene.run(3);
    let unanswered = |note: &&str| note.starts_with("arm: the rover did not answer");
    let notes = scene.notes();
    assert_eq!(
        notes.iter().filter(|n| unanswered(n)).count(),
        3,
        "{notes:?}"
    );
    scene.rover.borrow_mut().lose = 0;
    scene.run(1);
    assert!(!scene.picture(80, 24).contains("silent"));
}

#[test]
fn a_repeated_command_never_comes_after_a_later_one() {
    for (keys, armed) in [("al ", false), ("ali", true), ("a ", false)] {
        let mut scene = Scene::learning(1, 2);
        scene.press(" ");
        scene.run(1);
        // All answers but those to the last key are lost, so that the commands before it are taken
        // for lost, too.
        let (before, last) = keys.split_at(keys.len() - 1);
        scene.rover.borrow_mut().lose = u32::MAX;
        scene.press(before);
        scene.rover.borrow_mut().lose = 0;
        scene.press(last);
        scene.run(5);
        let state = scene.app.dashboard.state;
        let expected = if armed { State::Armed } else { State::Disarmed };
        assert_eq!(state, Some(expected), "{keys:?}: {:?}", scene.notes());
        assert!(!drives(&mut scene), "{keys:?}");
    }
}

#[test]
fn one_clock_tells_when_things_happened() {
    let mut scene = Scene::new(1);
    scene.run(4);
    scene.press("al");
    scene.run(3);
    let notes = &scene.app.dashboard.notes;
    let times: Vec<_> = notes.iter().filter_map(|note| note.time).collect();
    assert!(times.len() > 4 && times.is_sorted(), "{notes:?}");
    let at = |text| {
        notes
            .iter()
            .find(|n| n.line.text == text)
            .unwrap()
            .time
            .unwrap()
    };
    assert!(at("done: arm").abs_diff(at("ARMED")) < 100_000, "{notes:?}");
}

#[test]
fn a_terminal_that_is_lost_disarms() {
    let mut scene = Scene::unseen(1);
    let mut keys = VecDeque::from(typed("al"));
    let mut screen = Terminal::new(TestBackend::new(80, 24)).expect("it never fails");
    let mut ticks = 0;
    let mut next = |_: Duration| {
        ticks += 1;
        if ticks > 200 {
            return Err(std::io::ErrorKind::BrokenPipe.into());
        }
        Ok((ticks % 40 == 0).then(|| keys.pop_front()).flatten())
    };
    let lost = show(&mut screen, &mut scene.feed, &mut next, Look::default());
    assert!(matches!(lost, Err(ShowError::Terminal(_))), "{lost:?}");
    *scene.cable.borrow_mut() = false;
    scene.run(1);
    *scene.cable.borrow_mut() = true;
    assert!(!drives(&mut scene));
}

/// Notes what it is asked for.
#[derive(Default)]
struct Asked {
    now: Duration,
    commands: Vec<Command>,
    controls: Vec<Control>,
    log: bool,
}

impl Feed for Asked {
    fn now(&self) -> Duration {
        self.now
    }

    fn poll(&mut self, timeout: Duration) -> Vec<FeedEvent> {
        self.now += timeout;
        Vec::new()
    }

    fn send(&mut self, command: &Command) {
        self.commands.push(command.clone());
    }

    fn control(&mut self, control: Control) {
        self.controls.push(control);
    }

    fn is_log(&self) -> bool {
        self.log
    }
}

#[test]
fn keys_send_what_the_help_says_and_nothing_is_asked_of_nobody() {
    let mut feed = Asked::default();
    shown(&mut feed, typed("alri dfwsq")).expect("nobody has to acknowledge");
    let expected = [
        Command::Arm,
        Command::SetMode(Mode::Learn),
        Command::SetMode(Mode::Run),
        Command::SetMode(Mode::Idle),
        Command::Disarm,
        Command::Disarm,
        Command::SetTask(Task::FollowDirection),
        Command::SetTask(Task::FollowChangingDirection),
        Command::StoreKnowledge,
        Command::Disarm,
    ];
    assert_eq!(feed.commands, expected);
}

#[test]
fn a_log_is_asked_for_nothing_but_to_play() {
    let mut feed = Asked {
        log: true,
        ..Asked::default()
    };
    shown(&mut feed, typed(" +-a0$q")).expect("a log cannot drive");
    assert_eq!(feed.commands, []);
    assert_eq!(
        feed.controls,
        [
            Control::PlayOrPause,
            Control::Faster,
            Control::Slower,
            Control::Start,
            Control::End
        ]
    );
}
