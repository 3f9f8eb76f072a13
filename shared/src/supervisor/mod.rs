//! Arming and fail-safes: whether the motors may run, and nothing else.
//!
//! | state | `Arm` | `Disarm` | `SetMode` | a rule's fault, or stuck |
//! |---|---|---|---|---|
//! | disarmed | armed, if all is well; else refused, with the reason | - | refused | - |
//! | armed | - | disarmed | driving, by that mode | faulted |
//! | driving | - | disarmed | driving, by that mode; armed if idle | faulted |
//! | faulted | refused: the fault stands | disarmed | refused | (the first fault stays) |
//!
//! The motors run only while **driving** and while no stop is active. Time limits are in [`RULES`],
//! the rest in [`Supervisor::handle`]. A reset starts at disarmed.
//!
//! The firmware calls [`Supervisor::poll`] from its guard interrupt every [`GUARD_PERIOD`] and
//! switches the PWM off there unless [`Supervisor::motors_enabled`]; every other part reports what
//! happened with [`Supervisor::handle`]. Time is an argument of each call. A clock that runs ahead
//! makes every signal look silent, which stops the motors; a clock that steps back is a fault,
//! because no time limit could be kept with it.

mod counters;
mod table;

pub use table::{
    GUARD_PERIOD, HARDWARE_WATCHDOG, LOOP_SILENCE, Loop, RULES, Response, Rule, STUCK_AFTER,
    Signal, When,
};

use crate::contract::{
    ChannelHealth, CompassHealth, Counters, Fault, FaultReport, Mode, Outcome, Refusal,
    ResetReason, State,
};
use crate::motion::WheelCommand;
use crate::sensing::ir::FRONT_RIGHT;
use crate::time::{Duration, Instant};

/// How much earlier than the latest one a time may be: tasks and interrupts can overtake each other
/// between reading the clock and calling the supervisor.
pub const OUT_OF_ORDER: Duration = Duration::from_millis(10);

/// An input of the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// A loop has completed a turn.
    Alive(Loop),
    /// The range sensors were sampled.
    Ranges([ChannelHealth; 4]),
    /// The compass was read, or did not answer.
    Compass(CompassHealth),
    /// The driving host's heartbeat.
    Heartbeat,
    /// A move ended. A completed one resets the count of moves without progress, so it is reported
    /// only if the rover is known to have moved ([`Move::proven`](crate::motion::Move::proven)).
    Moved(Outcome),
    /// Request to allow the motors.
    Arm,
    /// Request to forbid them; also acknowledges a fault.
    Disarm,
    /// Request to change who drives.
    SetMode(Mode),
    /// Knowledge was loaded, or could not be.
    Knowledge {
        /// Whether it is whole and of this version.
        valid: bool,
    },
    /// A host opened the conversation.
    Hello {
        /// Whether version and schema are ours.
        matches: bool,
    },
    /// Request to write to the flash.
    FlashWrite,
    /// The write is over.
    FlashDone {
        /// Whether the write succeeded.
        written: bool,
    },
    /// A percept did not settle.
    Unsettled,
    /// This many reports were dropped since the last call.
    QueueFull(u32),
    /// This many frames were dropped since the last call.
    BadFrames(u32),
    /// The I2C bus had to be freed.
    BusRecovered,
    /// An ADC conversion failed.
    AdcError,
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct Supervisor {
    state: State,
    reset: ResetReason,
    /// The latest time passed in.
    latest: Instant,
    /// When each signal was last present and good.
    seen: [Option<Instant>; Signal::COUNT],
    ranges: [ChannelHealth; 4],
    compass: CompassHealth,
    knowledge: bool,
    /// Whether the last host's contract is ours; `None` before any hello.
    hello: Option<bool>,
    flash_busy: bool,
    /// Moves without progress since the last that had some.
    without_progress: u8,
    /// Which rules' responses are active.
    standing: [bool; RULES.len()],
    /// A loop is silent: the watchdog is never fed again.
    starved: bool,
    counters: Counters,
    /// When each fault that was not reported yet was last counted.
    unreported: [Option<Instant>; Fault::COUNT],
    /// Until when the rules' result stays the same as long as good signals keep coming. The
    /// firmware polls a thousand times a second, and evaluating the table each time took a third of
    /// the board's computing time.
    settled_until: Option<Instant>,
}

impl Supervisor {
    /// The state after a reset: disarmed, and no signal known to be good.
    pub const fn new(now: Instant, reset: ResetReason) -> Self {
        Self {
            state: State::Disarmed,
            reset,
            latest: now,
            seen: Self::loops_alive(now),
            ranges: [ChannelHealth::Unknown; 4],
            compass: CompassHealth::Unknown,
            knowledge: false,
            hello: None,
            flash_busy: false,
            without_progress: 0,
            standing: [false; RULES.len()],
            starved: false,
            counters: Counters([0; Fault::COUNT]),
            unreported: [None; Fault::COUNT],
            settled_until: None,
        }
    }

    /// Loops are given their time to start; every other signal is missing until it comes.
    const fn loops_alive(now: Instant) -> [Option<Instant>; Signal::COUNT] {
        let mut seen = [None; Signal::COUNT];
        let loops = [
            Loop::Sense,
            Loop::Control,
            Loop::Drive,
            Loop::Link,
            Loop::Store,
        ];
        let mut i = 0;
        while i < loops.len() {
            seen[Signal::Alive(loops[i]).index()] = Some(now);
            i += 1;
        }
        seen
    }

    /// The state.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Why the board last started.
    pub const fn reset_reason(&self) -> ResetReason {
        self.reset
    }

    /// How often each fault was counted.
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Whether the motors may run.
    pub fn motors_enabled(&self) -> bool {
        matches!(self.state, State::Driving(_)) && !self.stopped() && !self.starved
    }

    /// Returns the command if the motors may run, else STOP.
    pub fn gate(&self, command: WheelCommand) -> WheelCommand {
        if self.motors_enabled() {
            command
        } else {
            WheelCommand::STOP
        }
    }

    /// Whether to feed the hardware watchdog.
    pub const fn feed_watchdog(&self) -> bool {
        !self.starved
    }

    /// Returns the next unreported fault, if any; several of a kind are reported as one.
    pub fn take_fault(&mut self) -> Option<FaultReport> {
        let waiting = |fault: &Fault| self.unreported[*fault as usize].is_some();
        let fault = Fault::ALL.into_iter().find(waiting)?;
        let time = self.unreported[fault as usize].take()?;
        Some(FaultReport {
            time,
            fault,
            count: self.counters.of(fault),
        })
    }

    /// Applies [`RULES`] at this time.
    pub fn poll(&mut self, now: Instant) {
        self.keep_time(now);
        if self.settled_until.is_some_and(|until| self.latest < until) {
            return;
        }
        let state = self.state;
        for (i, rule) in RULES.iter().enumerate() {
            let due = rule.when.holds(self.state) && self.missing(rule);
            if due && !self.standing[i] {
                self.count(rule.fault, 1);
                match rule.response {
                    Response::Warn | Response::Stop => {}
                    Response::Fault => self.fail(rule.fault),
                    Response::Reset => self.starved = true,
                }
            }
            self.standing[i] = due;
        }
        // A fault may have changed which rules hold.
        self.settled_until = (self.state == state).then(|| self.next_due());
    }

    /// When the first inactive rule becomes active if its signal stays away. Rules of other states
    /// are included, at the cost of some needless evaluations.
    fn next_due(&self) -> Instant {
        let due = |(rule, stands): (&Rule, &bool)| {
            let seen = self.seen[rule.signal.index()].filter(|_| !stands)?;
            let due = seen.after(rule.limit());
            (due > self.latest).then_some(due)
        };
        let rules = RULES.iter().zip(&self.standing);
        rules.filter_map(due).min().unwrap_or(Instant(u64::MAX))
    }

    /// Processes an input and applies the rules.
    ///
    /// # Errors
    /// The request is refused, with the reason.
    pub fn handle(&mut self, now: Instant, input: Input) -> Result<(), Refusal> {
        self.poll(now);
        let result = self.take(input);
        self.poll(now);
        result
    }

    fn take(&mut self, input: Input) -> Result<(), Refusal> {
        if !self.changes_nothing(input) {
            self.settled_until = None;
        }
        match input {
            Input::Alive(of) => self.see(Signal::Alive(of)),
            Input::Ranges(health) => {
                self.ranges = health;
                if self.unfit_range().is_none() {
                    self.see(Signal::Ranges);
                }
            }
            Input::Compass(health) => {
                self.compass = health;
                if health == CompassHealth::Good {
                    self.see(Signal::Compass);
                }
            }
            Input::Heartbeat => self.see(Signal::Heartbeat),
            Input::Moved(outcome) => self.moved(outcome),
            Input::Arm => return self.arm(),
            Input::Disarm => self.state = State::Disarmed,
            Input::SetMode(mode) => return self.set_mode(mode),
            Input::Knowledge { valid } => self.knowledge = valid,
            Input::Hello { matches } => self.hello = Some(matches),
            Input::FlashWrite => return self.flash_write(),
            Input::FlashDone { written } => {
                self.flash_busy = false;
                self.count(Fault::FlashFailed, u32::from(!written));
            }
            Input::Unsettled => self.count(Fault::Unsettled, 1),
            Input::QueueFull(times) => self.count(Fault::QueueFull, times),
            Input::BadFrames(times) => self.count(Fault::BadFrame, times),
            Input::BusRecovered => self.count(Fault::BusRecovered, 1),
            Input::AdcError => self.count(Fault::AdcError, 1),
        }
        Ok(())
    }

    /// Whether an input can only postpone the rules' responses: a sign of life or unchanged
    /// sensors, while no rule is active that it could clear.
    fn changes_nothing(&self, input: Input) -> bool {
        let as_before = match input {
            Input::Alive(_) | Input::Heartbeat => true,
            Input::Ranges(health) => health == self.ranges,
            Input::Compass(health) => health == self.compass,
            _ => false,
        };
        as_before && !self.standing.contains(&true)
    }

    fn arm(&mut self) -> Result<(), Refusal> {
        let result = match self.state {
            // Repeated: the acknowledgement was lost.
            State::Armed | State::Driving(_) => return Ok(()),
            State::Faulted(fault) => Err(Refusal::Fault(fault)),
            State::Disarmed => self.ready(),
        };
        match result {
            Ok(()) => {
                self.state = State::Armed;
                self.without_progress = 0;
            }
            Err(_) => self.count(Fault::ArmRefused, 1),
        }
        result
    }

    /// Checks what arming requires. The order is that in which an operator can act on it.
    fn ready(&self) -> Result<(), Refusal> {
        match self.hello {
            None => return Err(Refusal::NoHello),
            Some(false) => return Err(Refusal::SchemaMismatch),
            Some(true) => {}
        }
        if self.flash_busy {
            return Err(Refusal::FlashBusy);
        }
        if !self.knowledge {
            return Err(Refusal::KnowledgeInvalid);
        }
        if let Some((channel, health)) = self.unfit_range() {
            return Err(Refusal::RangeSensor { channel, health });
        }
        if self.compass != CompassHealth::Good {
            return Err(Refusal::Compass(self.compass));
        }
        let armed = |rule: &&Rule| rule.when == When::Armed && self.missing(rule);
        match RULES.iter().find(armed).map(|rule| rule.signal) {
            None => Ok(()),
            Some(Signal::Ranges) => Err(Refusal::RangeSensor {
                channel: 0,
                health: ChannelHealth::Silent,
            }),
            Some(Signal::Compass) => Err(Refusal::Compass(CompassHealth::Silent)),
            Some(Signal::Heartbeat) => Err(Refusal::NoHeartbeat),
            Some(Signal::Alive(_)) => Err(Refusal::ControlSilent),
        }
    }

    fn set_mode(&mut self, mode: Mode) -> Result<(), Refusal> {
        match (self.state, mode) {
            (State::Disarmed, Mode::Idle) => {}
            (State::Disarmed, _) => return Err(Refusal::NotArmed),
            (State::Faulted(fault), _) => return Err(Refusal::Fault(fault)),
            (_, Mode::Idle) => self.state = State::Armed,
            (_, Mode::Host)
                if RULES
                    .iter()
                    .any(|r| r.when == When::HostDriven && self.missing(r)) =>
            {
                return Err(Refusal::NoHeartbeat);
            }
            (_, mode) => self.state = State::Driving(mode),
        }
        Ok(())
    }

    fn flash_write(&mut self) -> Result<(), Refusal> {
        if When::Armed.holds(self.state) {
            self.count(Fault::FlashWhileArmed, 1);
            return Err(Refusal::Armed);
        }
        if self.flash_busy {
            return Err(Refusal::FlashBusy);
        }
        self.flash_busy = true;
        Ok(())
    }

    fn moved(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Completed => self.without_progress = 0,
            Outcome::Obstacle => self.count(Fault::Blocked, 1),
            Outcome::NoProgress => {
                self.count(Fault::NoProgress, 1);
                self.without_progress = self.without_progress.saturating_add(1);
                if self.without_progress >= STUCK_AFTER && When::Armed.holds(self.state) {
                    self.count(Fault::Stuck, 1);
                    self.fail(Fault::Stuck);
                }
            }
            Outcome::TurnTimeout => self.count(Fault::TurnTimeout, 1),
            Outcome::Late => self.count(Fault::LateStep, 1),
            // The compass's rule counts the former; a stop is no fault.
            Outcome::CompassLost | Outcome::Stopped => {}
        }
    }

    /// The first range sensor that is unfit for use.
    fn unfit_range(&self) -> Option<(u8, ChannelHealth)> {
        let unfit = |&(channel, health): &(usize, ChannelHealth)| match health {
            ChannelHealth::Good => false,
            // Only the second front sensor is optional.
            ChannelHealth::NotFitted => channel != FRONT_RIGHT,
            _ => true,
        };
        let (channel, health) = self.ranges.into_iter().enumerate().find(unfit)?;
        Some((channel as u8, health))
    }

    /// Whether the rule's signal has been missing for too long, or reports that it is bad.
    fn missing(&self, rule: &Rule) -> bool {
        let bad = match rule.signal {
            Signal::Ranges => self.unfit_range().is_some(),
            Signal::Compass => self.compass != CompassHealth::Good,
            Signal::Alive(_) | Signal::Heartbeat => false,
        };
        let silent = self.seen[rule.signal.index()]
            .is_none_or(|then| self.latest.since(then) >= rule.limit());
        silent || (bad && rule.response == Response::Stop)
    }

    /// Whether the response of a rule that stops the motors is active.
    fn stopped(&self) -> bool {
        let mut rules = RULES.iter().zip(&self.standing);
        rules.any(|(rule, stands)| *stands && rule.response == Response::Stop)
    }

    fn see(&mut self, signal: Signal) {
        self.seen[signal.index()] = Some(self.latest);
    }

    fn count(&mut self, fault: Fault, times: u32) {
        if times > 0 {
            self.counters.count(fault, times);
            self.unreported[fault as usize] = Some(self.latest);
        }
    }

    /// Disarms with a fault. A later one does not replace it: the first is the cause.
    fn fail(&mut self, fault: Fault) {
        if When::Armed.holds(self.state) {
            self.state = State::Faulted(fault);
        }
    }

    fn keep_time(&mut self, now: Instant) {
        if self.latest.since(now) > OUT_OF_ORDER {
            self.settled_until = None;
            self.latest = now;
            self.seen = Self::loops_alive(now);
            self.count(Fault::ClockStepped, 1);
            self.fail(Fault::ClockStepped);
        }
        self.latest = self.latest.max(now);
    }
}

#[cfg(test)]
mod tests;
