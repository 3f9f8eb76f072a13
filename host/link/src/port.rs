//! What a port is.

use std::time::SystemTime;

use rover_shared::time::{Duration, Instant};

/// Bytes to a rover and from it, and the time that passes meanwhile.
pub trait Port {
    /// What to call it in a sentence: the path of a serial port.
    fn name(&self) -> &str;

    /// The time since the port was first opened, on the port's own clock.
    fn now(&self) -> Instant;

    /// The wall-clock time at which [`now`](Self::now) was 0; `None` if the port's clock is another.
    fn epoch(&self) -> Option<SystemTime> {
        None
    }

    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// The port is gone, or takes no bytes. After that nothing works before
    /// [`reopen`](Self::reopen).
    fn send(&mut self, bytes: &[u8]) -> Result<(), PortError>;

    /// Reads what has come into the beginning of `buffer`, and returns its length. Waits at most
    /// for `patience`; 0 if nothing came.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> Result<usize, PortError>;

    /// Waits; what comes meanwhile is kept.
    fn wait(&mut self, span: Duration);

    /// Tries once to close and open the port, after an error or to begin anew: the rover sees that
    /// the host was gone. The clock goes on.
    ///
    /// # Errors
    /// It is not there (yet).
    fn reopen(&mut self) -> Result<(), PortError>;
}

/// What is wrong with a port; the text says what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PortError {
    /// No rover is connected.
    #[error(
        "no rover found: connect one by USB, or name its port with --port PATH (`rover ports \
         --all` lists all ports)"
    )]
    NoRover,
    /// The rover that was connected is not.
    #[error("the rover with serial number {0} is not connected: plug it in")]
    Away(String),
    /// More than one rover is connected.
    #[error("several rovers found ({0}): choose one with --port and its path or serial number")]
    Several(String),
    /// The ports cannot be listed.
    #[error("serial ports cannot be listed ({0}): name the rover's port with --port PATH")]
    NoList(String),
    /// There is no such port.
    #[error("{0}: no such port: `rover ports --all` lists what there is")]
    Missing(String),
    /// This user may not open it.
    #[error(
        "{0}: no permission to open it: copy host/udev/60-turing-rover.rules to \
         /etc/udev/rules.d/, run `sudo udevadm control --reload-rules` and plug the rover in again"
    )]
    Permission(String),
    /// Another program has it.
    #[error("{0}: another program uses it: close that first")]
    Busy(String),
    /// It cannot be opened for another reason.
    #[error(
        "{0}: cannot be opened as a serial port ({1}): `rover ports --all` lists what there is"
    )]
    Open(String, String),
    /// It was open and is gone.
    #[error("{0}: the connection is lost ({1}): check the cable")]
    Lost(String, String),
    /// It takes no more bytes.
    #[error("{0}: takes no bytes: reset the rover, and check that it runs the rover's firmware")]
    Stuck(String),
}
