//! What is followed from outside is what the rover knows.

use std::time::Duration;

use rover_cli::monitor::model::{Knowledge, Why};
use rover_cli::monitor::player::Player;
use rover_cli::monitor::{Control, Feed as _};
use rover_log::knowledge::followed::Followed;
use rover_shared::contract::{ResetReason, State};

use crate::scene::{Scene, simulation, watched};

const DIFFERED: &str = "what was followed differed";

#[test]
fn a_drive_that_is_followed_ends_with_what_the_rover_knows() {
    for seed in 1..4 {
        let mut scene = Scene::learning(seed, 600);
        let followed = scene.app.dashboard.mirror().cloned();
        let followed = followed.expect("it was read before the drive, and followed");
        assert!(followed.steps() > 100 && followed.patterns().len() > 5);
        assert!(!followed.is_exact());
        scene.press("i");
        scene.run(10);
        let read = scene.app.dashboard.mirror();
        let read = read.expect("it can be read when nobody drives");
        assert!(read.is_exact(), "it was read anew");
        // The move that was under way when the drive ended is an action too.
        assert!(read.steps() >= followed.steps());
        let differed = |note: &&str| note.starts_with(DIFFERED);
        assert!(!scene.notes().iter().any(differed), "{:?}", scene.notes());
    }
}

#[test]
fn a_drive_of_which_an_action_was_lost_is_not_followed() {
    let mut scene = Scene::learning(1, 60);
    assert!(scene.app.dashboard.mirror().is_some());
    scene.rover.borrow_mut().lose = 8;
    scene.run(20);
    let dashboard = &scene.app.dashboard;
    assert!(dashboard.frames.lost > 0);
    assert!(dashboard.missed > 0, "an action was among them");
    assert_eq!(dashboard.knowledge, Knowledge::Unknown(Why::Missed));
    scene.press("i");
    scene.run(10);
    assert!(scene.app.dashboard.mirror().is_some_and(Followed::is_exact));
}

#[test]
fn a_rover_that_restarts_is_asked_anew() {
    let mut scene = Scene::learning(1, 60);
    // A board that restarts is gone from the bus for a moment.
    *scene.cable.borrow_mut() = false;
    scene.run(1);
    scene.rover.borrow_mut().reset(ResetReason::Watchdog, 2);
    *scene.cable.borrow_mut() = true;
    scene.run(5);
    let dashboard = &scene.app.dashboard;
    assert_eq!(dashboard.state, Some(State::Disarmed));
    let mirror = dashboard.mirror().expect("it was read");
    assert!(mirror.is_exact());
    assert!(mirror.patterns().is_empty(), "nothing was stored");
    let restarted = |note: &&str| note.contains("the watchdog reset it");
    assert!(scene.notes().iter().any(restarted), "{:?}", scene.notes());
}

#[test]
fn an_unplugged_rover_is_watched_on_when_it_is_back() {
    let mut scene = Scene::learning(1, 30);
    let cable = scene.cable.clone();
    for _ in 0..20 {
        *cable.borrow_mut() = false;
        scene.run(2);
        assert_eq!(scene.app.dashboard.state, None, "nobody knows");
        *cable.borrow_mut() = true;
        scene.run(3);
        assert!(scene.app.dashboard.state.is_some());
    }
    assert_eq!(scene.app.dashboard.frames.reconnected, 20);
}

#[test]
fn a_log_that_is_followed_ends_with_what_was_learned() {
    let log = simulation();
    let after = log.after.clone().expect("the log is whole");
    let read = Followed::new(&after).expect("it is knowledge");
    let mut player = Player::of_simulation("learn.mcap".into(), log);
    player.control(Control::End);
    let app = watched(&mut player, Duration::from_secs(60));
    let followed = app.dashboard.mirror().expect("no action is missing");
    assert!(followed.agrees_with(&read));
    assert!(read.patterns().len() > 5);
}
