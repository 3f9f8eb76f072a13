//! What each key means.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use rover_shared::contract::{Mode, Task};
use rover_shared::units::Microdegrees;
use rover_shared::wire::message::Command;

use super::feed::Control;
use rover_link::text::parse_compass;

/// How far an arrow key turns the direction.
const TURN: Microdegrees = Microdegrees::from_degrees(15);
/// Actions of a log that a page key passes.
const PAGE: i32 = 20;
/// Longest direction that can be typed.
const TYPED: usize = 8;

/// What a key asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Meaning {
    /// To be sent to the rover.
    Command(Command),
    /// A change of how a log is shown.
    Control(Control),
    /// The direction, turned by this.
    Turn(Microdegrees),
    /// Type a direction.
    Type,
    /// Show or hide all keys.
    Help,
    /// Disarm, and end.
    Quit,
    /// End, and leave the rover as it is.
    Leave,
}

/// The keys, for the help: key, then what it does.
pub const LIVE: [(&str, &str); 13] = [
    ("space, d", "disarm: the motors stop at once"),
    ("a", "arm; space first if a fault stands"),
    ("l", "mode learn: the rover drives and learns"),
    ("r", "mode run: it drives by what it knows"),
    ("i", "mode idle: it stands, still armed"),
    ("left, right", "turn the direction by 15 degrees"),
    ("g", "type a direction, compass degrees"),
    ("f", "task: follow this fixed direction"),
    ("w", "task: wander, directions drawn by chance"),
    ("s", "store what was learned in the flash"),
    ("?", "show or hide these keys"),
    ("q, Ctrl-C", "disarm and quit"),
    ("Q", "quit, and leave the rover as it is"),
];

/// The same for logs.
pub const LOG: [(&str, &str); 7] = [
    ("space, p", "play or pause"),
    ("left, right", "one action back or on"),
    ("page up, down", "twenty actions back or on"),
    ("+, -", "twice or half as fast"),
    ("0, $", "to the start or the end (also Home, End)"),
    ("?", "show or hide these keys"),
    ("q, Ctrl-C", "quit"),
];

/// What a key means; `None` if nothing.
pub fn meaning(key: KeyEvent, log: bool) -> Option<Meaning> {
    if key.kind == KeyEventKind::Release {
        return None;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return (key.code == KeyCode::Char('c')).then_some(Meaning::Quit);
    }
    match key.code {
        KeyCode::Char('?' | 'h') => Some(Meaning::Help),
        KeyCode::Char('q') => Some(Meaning::Quit),
        KeyCode::Char('Q') => Some(Meaning::Leave),
        code if log => of_log(code).map(Meaning::Control),
        code => of_rover(code),
    }
}

fn of_rover(code: KeyCode) -> Option<Meaning> {
    let command = match code {
        KeyCode::Char(' ' | 'd') => Command::Disarm,
        KeyCode::Char('a') => Command::Arm,
        KeyCode::Char('l') => Command::SetMode(Mode::Learn),
        KeyCode::Char('r') => Command::SetMode(Mode::Run),
        KeyCode::Char('i') => Command::SetMode(Mode::Idle),
        KeyCode::Char('f') => Command::SetTask(Task::FollowDirection),
        KeyCode::Char('w') => Command::SetTask(Task::FollowChangingDirection),
        KeyCode::Char('s') => Command::StoreKnowledge,
        KeyCode::Char('g') => return Some(Meaning::Type),
        KeyCode::Left => return Some(Meaning::Turn(TURN)),
        KeyCode::Right => return Some(Meaning::Turn(Microdegrees(-TURN.0))),
        _ => return None,
    };
    Some(Meaning::Command(command))
}

fn of_log(code: KeyCode) -> Option<Control> {
    match code {
        KeyCode::Char(' ' | 'p') => Some(Control::PlayOrPause),
        KeyCode::Char('+' | '=') => Some(Control::Faster),
        KeyCode::Char('-') => Some(Control::Slower),
        KeyCode::Right => Some(Control::Actions(1)),
        KeyCode::Left => Some(Control::Actions(-1)),
        KeyCode::PageDown => Some(Control::Actions(PAGE)),
        KeyCode::PageUp => Some(Control::Actions(-PAGE)),
        KeyCode::Char('0') | KeyCode::Home => Some(Control::Start),
        KeyCode::Char('$') | KeyCode::End => Some(Control::End),
        _ => None,
    }
}

/// A direction being typed.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Prompt {
    /// What was typed so far.
    pub text: String,
    /// What is wrong with it, after an attempt to end it.
    pub error: Option<String>,
}

/// What a key did to a [`Prompt`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Typed {
    /// It goes on.
    More,
    /// It is over, with nothing.
    Away,
    /// It is over, with this direction.
    Direction(Microdegrees),
}

impl Prompt {
    /// Takes a key.
    pub fn take(&mut self, key: KeyEvent) -> Typed {
        if key.kind == KeyEventKind::Release {
            return Typed::More;
        }
        match key.code {
            KeyCode::Esc => return Typed::Away,
            KeyCode::Enter => match direction(&self.text) {
                Ok(direction) => return Typed::Direction(direction),
                Err(error) => self.error = Some(error),
            },
            KeyCode::Backspace => {
                self.text.pop();
            }
            KeyCode::Char(c @ ('0'..='9' | '.' | '-')) if self.text.len() < TYPED => {
                self.text.push(c);
            }
            _ => {}
        }
        Typed::More
    }
}

/// A typed direction, or a sentence that says what is wrong with it.
///
/// # Errors
/// It is none.
pub fn direction(text: &str) -> Result<Microdegrees, String> {
    parse_compass(text.trim()).map_err(|expected| format!("\"{text}\": {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn live(code: KeyCode) -> Option<Meaning> {
        meaning(code.into(), false)
    }

    fn char(c: char) -> Option<Meaning> {
        live(KeyCode::Char(c))
    }

    #[test]
    fn every_key_of_a_rover_does_what_the_help_says() {
        for (key, command) in [
            (' ', Command::Disarm),
            ('d', Command::Disarm),
            ('a', Command::Arm),
            ('l', Command::SetMode(Mode::Learn)),
            ('r', Command::SetMode(Mode::Run)),
            ('i', Command::SetMode(Mode::Idle)),
            ('f', Command::SetTask(Task::FollowDirection)),
            ('w', Command::SetTask(Task::FollowChangingDirection)),
            ('s', Command::StoreKnowledge),
        ] {
            assert_eq!(char(key), Some(Meaning::Command(command)), "{key}");
        }
        let left = Meaning::Turn(Microdegrees::from_degrees(15));
        let right = Meaning::Turn(Microdegrees::from_degrees(-15));
        assert_eq!(live(KeyCode::Left), Some(left));
        assert_eq!(live(KeyCode::Right), Some(right));
        assert_eq!(char('g'), Some(Meaning::Type));
        assert_eq!(char('?'), Some(Meaning::Help));
        assert_eq!(char('q'), Some(Meaning::Quit));
        assert_eq!(char('Q'), Some(Meaning::Leave));
        assert_eq!(char('x'), None);
    }

    #[test]
    fn a_log_is_played_and_takes_no_commands() {
        let log = |code: KeyCode| meaning(code.into(), true);
        for (code, control) in [
            (KeyCode::Char(' '), Control::PlayOrPause),
            (KeyCode::Char('p'), Control::PlayOrPause),
            (KeyCode::Char('+'), Control::Faster),
            (KeyCode::Char('-'), Control::Slower),
            (KeyCode::Right, Control::Actions(1)),
            (KeyCode::Left, Control::Actions(-1)),
            (KeyCode::PageDown, Control::Actions(20)),
            (KeyCode::PageUp, Control::Actions(-20)),
            (KeyCode::Home, Control::Start),
            (KeyCode::Char('0'), Control::Start),
            (KeyCode::End, Control::End),
            (KeyCode::Char('$'), Control::End),
        ] {
            assert_eq!(log(code), Some(Meaning::Control(control)), "{code}");
        }
        for c in "adlrifwsg".chars() {
            assert_eq!(log(KeyCode::Char(c)), None, "{c}");
        }
        assert_eq!(log(KeyCode::Char('q')), Some(Meaning::Quit));
    }

    #[test]
    fn ctrl_c_quits_and_releases_mean_nothing() {
        let ctrl_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(meaning(ctrl_c, false), Some(Meaning::Quit));
        let ctrl_a = KeyEvent::new(KeyCode::Char('a'), KeyModifiers::CONTROL);
        assert_eq!(meaning(ctrl_a, false), None);
        let mut released = KeyEvent::from(KeyCode::Char('a'));
        released.kind = KeyEventKind::Release;
        assert_eq!(meaning(released, false), None);
    }

    #[test]
    fn directions_are_typed_as_on_a_compass() {
        assert_eq!(direction(" -12.5 "), Ok(Microdegrees(12_500_000)));
        let error = direction("north").unwrap_err();
        assert!(error.starts_with("\"north\": expected degrees"), "{error}");
    }

    #[test]
    fn a_prompt_takes_numbers_and_says_what_is_wrong() {
        let mut prompt = Prompt::default();
        for c in "4x5-".chars() {
            assert_eq!(prompt.take(KeyCode::Char(c).into()), Typed::More);
        }
        assert_eq!(prompt.text, "45-");
        assert_eq!(prompt.take(KeyCode::Enter.into()), Typed::More);
        assert!(prompt.error.is_some());
        prompt.take(KeyCode::Backspace.into());
        let done = prompt.take(KeyCode::Enter.into());
        assert_eq!(done, Typed::Direction(Microdegrees::from_degrees(-45)));
        assert_eq!(prompt.take(KeyCode::Esc.into()), Typed::Away);
        for _ in 0..100 {
            prompt.take(KeyCode::Char('1').into());
        }
        assert_eq!(prompt.text.len(), TYPED);
    }
}
