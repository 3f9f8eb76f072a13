//! A rover in this process, and somebody who watches it.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use ratatui::buffer::Buffer;
use ratatui::crossterm::event::KeyCode;
use ratatui::layout::Rect;
use rover_boardless::{BoardlessPort, BoardlessRover};
use rover_cli::monitor::rover_feed::RoverFeed;
use rover_cli::monitor::terminal::TICK;
use rover_cli::monitor::view::{self, Look};
use rover_cli::monitor::{App, Feed};
use rover_link::Client;
use rover_log::knowledge;
use rover_log::{Log, LogWriter, Origin};
use rover_shared::learning::Mode;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_simulator::arena::{ArenaSource, Layout};
use rover_simulator::experiment::{Known, SessionPlan, learn};

/// A watched rover.
pub struct Scene {
    pub rover: Rc<RefCell<BoardlessRover>>,
    pub cable: Rc<RefCell<bool>>,
    pub feed: RoverFeed,
    pub app: App,
}

impl Scene {
    /// A rover that was just found.
    pub fn new(seed: u64) -> Self {
        let mut scene = Self::unseen(seed);
        scene.run(2);
        scene
    }

    /// A rover of which nothing was heard yet.
    pub fn unseen(seed: u64) -> Self {
        let rover = Rc::new(RefCell::new(BoardlessRover::in_empty_room(seed)));
        let port = BoardlessPort::new(rover.clone());
        let cable = port.cable();
        let client = Client::open(Box::new(port)).expect("the rover answers");
        Self {
            rover,
            cable,
            feed: RoverFeed::new(client),
            app: App::default(),
        }
    }

    /// One that learns for so many seconds.
    pub fn learning(seed: u64, seconds: u64) -> Self {
        let mut scene = Self::new(seed);
        scene.press("al");
        scene.run(seconds);
        scene
    }

    /// Lets seconds pass.
    pub fn run(&mut self, seconds: u64) {
        let ticks = 1_000 * seconds / TICK.as_millis() as u64;
        for _ in 0..ticks {
            for event in self.feed.poll(TICK) {
                self.app.take(self.feed.now(), &event);
            }
            self.app.ask(&mut self.feed);
        }
    }

    /// Presses keys, one after the other, and lets a tick pass after each.
    pub fn press(&mut self, keys: &str) {
        for key in keys.chars() {
            self.press_code(KeyCode::Char(key));
        }
    }

    pub fn press_code(&mut self, code: KeyCode) {
        self.app.key(code.into(), &mut self.feed);
        for event in self.feed.poll(TICK) {
            self.app.take(self.feed.now(), &event);
        }
    }

    /// The notes so far.
    pub fn notes(&self) -> Vec<&str> {
        let notes = self.app.dashboard.notes.iter();
        notes.map(|note| note.line.text.as_str()).collect()
    }

    pub fn picture(&self, columns: u16, rows: u16) -> String {
        picture(
            &self.app,
            self.feed.is_log(),
            columns,
            rows,
            Look::default(),
        )
    }
}

/// Shows a source until it has ended or this much of its time has passed.
pub fn watched(feed: &mut dyn Feed, span: Duration) -> App {
    let mut app = App::default();
    let until = feed.now() + span;
    while feed.now() < until && !feed.ended() {
        for event in feed.poll(TICK) {
            app.take(feed.now(), &event);
        }
        app.ask(feed);
    }
    app
}

/// The dashboard as text, without the blanks at the lines' ends.
pub fn picture(app: &App, log: bool, columns: u16, rows: u16, look: Look) -> String {
    let area = Rect::new(0, 0, columns, rows);
    let mut buffer = Buffer::empty(area);
    view::draw(area, &mut buffer, app, log, look);
    let mut text = String::new();
    for row in buffer.content().chunks(columns.into()) {
        let line: String = row.iter().map(|cell| cell.symbol()).collect();
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// The log of a few trials of learning.
pub fn simulation() -> Log {
    let coefficients = Coefficients::new(&Parameters::PAPER).expect("the paper's are valid");
    let plan = SessionPlan {
        seed: 3,
        trials: 4,
        steps: 120,
        follow_direction: false,
        arenas: ArenaSource::from(Layout::paper()),
    };
    let origin = Origin {
        seed: plan.seed,
        mode: Mode::Learn,
        writer: "test".into(),
    };
    let nothing = Known::new(&coefficients.learning);
    let before = knowledge::to_bytes(&nothing, coefficients.parameters());
    let file = std::io::Cursor::new(Vec::new());
    let mut log = LogWriter::new(file, &origin, &before).expect("memory takes it");
    let learned = learn(&plan, &coefficients, &mut log, |_| {});
    let after = knowledge::to_bytes(&learned.knowledge, coefficients.parameters());
    let file = log.finish(&after).expect("memory takes it");
    Log::read(file.get_ref()).expect("it was just written")
}
