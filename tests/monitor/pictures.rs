//! Pictures of the dashboard, compared with those that were looked at. A wanted change is written
//! by `UPDATE_PICTURES=1 cargo test --test monitor`, and is to be looked at too.

use std::path::Path;
use std::time::Duration;

use proptest::prelude::*;
use rover_cli::monitor::model::{HISTORY, NOTES};
use rover_cli::monitor::plain::{Plain, Topic};
use rover_cli::monitor::player::Player;
use rover_cli::monitor::view::Look;
use rover_cli::monitor::{App, Control, Feed as _};
use rover_emulator::vehicle::Fault;

use crate::anything::feed_event;
use crate::scene::{Scene, picture, simulation, watched};

const ASCII: Look = Look {
    colour: false,
    ascii: true,
};

fn compare(name: &str, picture: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/monitor/pictures");
    let path = folder.join(format!("{name}.txt"));
    if std::env::var_os("UPDATE_PICTURES").is_some() {
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        std::fs::write(&path, picture).expect("the picture can be written");
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        picture == expected,
        "{name} has changed; it was:\n{expected}\nand is:\n{picture}"
    );
}

#[test]
fn a_rover_that_learns() {
    let scene = Scene::learning(7, 240);
    compare("learning-80x24", &scene.picture(80, 24));
    compare("learning-120x40", &scene.picture(120, 40));
    let ascii = picture(&scene.app, false, 80, 24, ASCII);
    assert!(ascii.is_ascii(), "{ascii}");
    compare("learning-80x24-ascii", &ascii);
}

#[test]
fn a_rover_that_was_just_found() {
    compare("found-80x24", &Scene::new(7).picture(80, 24));
}

#[test]
fn a_refusal() {
    let mut scene = Scene::new(7);
    scene.rover.borrow_mut().set_faults(&[Fault::CompassSilent]);
    scene.run(1);
    scene.press("a");
    compare("refused-80x24", &scene.picture(80, 24));
}

#[test]
fn a_rover_that_is_watched_from_the_middle_of_a_drive() {
    let mut scene = Scene::learning(7, 30);
    // Another program begins to watch: the knowledge cannot be read while the rover drives.
    scene.app = Default::default();
    *scene.cable.borrow_mut() = false;
    scene.run(1);
    compare("unplugged-80x24", &scene.picture(80, 24));
    *scene.cable.borrow_mut() = true;
    scene.run(20);
    compare("joined-80x24", &scene.picture(80, 24));
}

#[test]
fn all_keys() {
    let mut scene = Scene::new(7);
    scene.press("?");
    compare("keys-80x24", &scene.picture(80, 24));
    scene.press("?g-1");
    compare("typing-80x24", &scene.picture(80, 24));
}

#[test]
fn a_log_of_a_simulation() {
    let mut player = Player::of_simulation("learn.mcap".into(), simulation());
    player.control(Control::End);
    let app = watched(&mut player, Duration::from_secs(60));
    compare("log-80x24", &picture(&app, true, 80, 24, Look::default()));
    compare("log-120x40", &picture(&app, true, 120, 40, Look::default()));
}

#[test]
fn a_terminal_that_is_too_small_says_so() {
    let scene = Scene::learning(7, 10);
    let small = scene.picture(40, 10);
    for part in [
        "DRIVING",
        "40 columns and 10 rows",
        "80 and 24",
        "space disarms",
    ] {
        let text = small.replace('\n', " ");
        assert!(text.contains(part), "no \"{part}\" in:\n{small}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_course_of_events_can_be_drawn(
        events in prop::collection::vec(feed_event(), 0..60),
        columns in 1u16..200,
        rows in 0u16..60,
        help in any::<bool>(),
    ) {
        let mut app = App::default();
        app.help = help;
        let mut plain = Plain::new(Duration::ZERO);
        for (time, event) in (0..).map(Duration::from_secs).zip(&events) {
            app.take(time, event);
            plain.lines(time, event, &app.dashboard);
            picture(&app, false, columns, rows, ASCII);
            picture(&app, true, 80, 24, Look::default());
        }
        for topic in [Topic::Status, Topic::Patterns, Topic::Staircases] {
            topic.lines(&app.dashboard);
        }
        prop_assert!(app.dashboard.history.len() <= HISTORY);
        prop_assert!(app.dashboard.notes.len() <= NOTES);
    }

    #[test]
    fn every_size_can_be_drawn(columns in 0u16..300, rows in 0u16..100, ascii in any::<bool>()) {
        thread_local!(static SCENE: Scene = Scene::learning(3, 60));
        let look = Look { colour: true, ascii };
        SCENE.with(|scene| picture(&scene.app, false, columns.max(1), rows, look));
    }
}
