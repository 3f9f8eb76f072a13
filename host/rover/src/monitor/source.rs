//! Where a dashboard gets what it shows: a rover, an emulated board, a log.

use std::time::Duration;

use rover_shared::wire::message::Command;

use super::happening::Happening;

/// Something that can be watched.
pub trait Source {
    /// The time on the source's own clock: the wall clock's for a rover, emulated time for an
    /// emulated one, and for a log the time that it was shown.
    fn now(&self) -> Duration;

    /// Waits until something happens, at most for `timeout`, and gives what happened, in order.
    /// A source with a time of its own lets `timeout` of that time pass. One that has to connect anew
    /// may take a quarter of a second at a time.
    fn poll(&mut self, timeout: Duration) -> Vec<Happening>;

    /// Sends a command. Its answer is a [`Happening::Answer`], or a [`Happening::Unanswered`]
    /// after a bounded wait, of this poll or a later one.
    fn send(&mut self, command: &Command);

    /// Changes how a log is shown; nothing to a rover.
    fn control(&mut self, _control: Control) {}

    /// Whether it is a log: then there is nobody to send commands to.
    fn is_log(&self) -> bool {
        false
    }

    /// Whether everything that there is has been shown.
    fn ended(&self) -> bool {
        false
    }
}

/// How the showing of a log is to change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on if it stands, stand if it goes on.
    PlayOrPause,
    /// Twice as fast.
    Faster,
    /// Half as fast.
    Slower,
    /// So many actions on, or back if negative, and stand. Entries, where there are no actions.
    Actions(i32),
    /// To the start.
    Start,
    /// To the end.
    End,
}
