//! Arming and fail-safes: whether the motors may run, and nothing else.
//!
//! | state | `Arm` | `Disarm` | `SetMode` | a rule's fault, or stuck |
//! |---|---|---|---|---|
//! | disarmed | armed, if all is well; else refused, with the reason | - | refused | - |
//! | armed | - | disarmed | driving, by that mode | faulted |
//! | driving | - | disarmed | driving, by that mode; armed if idle | faulted |
//! | faulted | refused: the fault stands | disarmed | refused | (the first fault stays) |
//!
//! The motors run while **driving** and while no stop stands, nowhere else. What is watched by
//! time stands in [`RULES`], the rest in [`Supervisor::handle`]. A reset starts at disarmed.
//!
//! The firmware calls [`Supervisor::poll`] from its guard interrupt every [`GUARD_PERIOD`] and
//! switches the PWM off there if [`Supervisor::motors_enabled`] says no; every other part tells
//! what happened with `handle`. Time comes with each call. A clock that runs ahead makes
//! everything look silent, which stops; a clock that steps back is a fault, because no limit of
//! time could be kept with it.

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

/// How much earlier than the latest one a time may be: calls from tasks and interrupts overtake
/// each other between reading the clock and being heard.
pub const OUT_OF_ORDER: Duration = Duration::from_millis(10);

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// A loop went round.
    Alive(Loop),
    /// The range sensors were sampled.
    Ranges([ChannelHealth; 4]),
    /// The compass was read, or did not answer.
    Compass(CompassHealth),
    /// The host says that it drives.
    Heartbeat,
    /// A move ended. One that was completed ends a row of moves without progress, so it is not to be
    /// told of where nothing proves that the rover moved
    /// ([`Move::proven`](crate::motion::Move::proven)).
    Moved(Outcome),
    /// Somebody wants the motors allowed.
    Arm,
    /// Somebody wants them off; also acknowledges a fault.
    Disarm,
    /// Somebody chooses who drives.
    SetMode(Mode),
    /// Knowledge was loaded, or could not be.
    Knowledge {
        /// Whether it is whole and of this version.
        valid: bool,
    },
    /// A host said hello.
    Hello {
        /// Whether version and schema are ours.
        matches: bool,
    },
    /// Somebody wants to write to the flash.
    FlashWrite,
    /// The write is over.
    FlashDone {
        /// Whether everything was written.
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
    /// The latest time heard.
    latest: Instant,
    /// When each signal last came, and was good.
    seen: [Option<Instant>; Signal::COUNT],
    ranges: [ChannelHealth; 4],
    compass: CompassHealth,
    knowledge: bool,
    /// Whether the last host's contract is ours; `None` before any hello.
    hello: Option<bool>,
    flash_busy: bool,
    /// Moves without progress since the last that had some.
    without_progress: u8,
    /// Which rules' responses stand.
    standing: [bool; RULES.len()],
    /// A loop fell silent: the watchdog is never fed again.
    starved: bool,
    counters: Counters,
    /// When each fault that was not reported yet was last counted.
    unreported: [Option<Instant>; Fault::COUNT],
    /// Until when the rules would find what they found last, if nothing else happens than that good
    /// signals keep coming. The firmware asks a thousand times a second, and on the processor of a
    /// rover going through the table each time was a third of all computing.
    settled_until: Option<Instant>,
}

impl Supervisor {
    /// After a reset: disarmed, and nothing is known to be well.
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

    /// Loops get their time to begin; everything else has to be seen first.
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
        matches!(self.state, State::Driving(_)) && !self.stands(Response::Stop) && !self.starved
    }

    /// The command, if the motors may run; else STOP.
    pub fn gate(&self, command: WheelCommand) -> WheelCommand {
        if self.motors_enabled() {
            command
        } else {
            WheelCommand::STOP
        }
    }

    /// Whether the hardware watchdog is to be fed.
    pub const fn feed_watchdog(&self) -> bool {
        !self.starved
    }

    /// Whether the driving host is late.
    pub fn warns(&self) -> bool {
        self.stands(Response::Warn)
    }

    /// The next fault that was not reported yet, if any; several of a kind come as one.
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

    /// When the first of the rules that do not stand will, if its signal does not come. Rules that
    /// hold in other states are included: that costs a look too many.
    fn next_due(&self) -> Instant {
        let due = |(rule, stands): (&Rule, &bool)| {
            let seen = self.seen[rule.signal.index()].filter(|_| !stands)?;
            let due = seen.after(rule.limit());
            (due > self.latest).then_some(due)
        };
        let rules = RULES.iter().zip(&self.standing);
        rules.filter_map(due).min().unwrap_or(Instant(u64::MAX))
    }

    /// Takes what happened, and applies the rules.
    ///
    /// # Errors
    /// What was asked for is refused, and why.
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

    /// Whether an input can only put off what the rules would do: a sign of life, or sensors that are
    /// as they were, while no rule stands that it could lift.
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
            // Asked again: the acknowledgement was lost.
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

    /// Whether everything is well that must be before arming; the order is that of who can help.
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
            // The rule for the compass counts; a stop is nobody's fault.
            Outcome::CompassLost | Outcome::Stopped => {}
        }
    }

    /// The first range sensor that is unfit for use.
    fn unfit_range(&self) -> Option<(u8, ChannelHealth)> {
        let unfit = |&(channel, health): &(usize, ChannelHealth)| match health {
            ChannelHealth::Good => false,
            // Only the second one ahead can be done without.
            ChannelHealth::NotFitted => channel != FRONT_RIGHT,
            _ => true,
        };
        let (channel, health) = self.ranges.into_iter().enumerate().find(unfit)?;
        Some((channel as u8, health))
    }

    /// Whether the rule's signal is away for too long, or says that it is bad.
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

    fn stands(&self, response: Response) -> bool {
        RULES
            .iter()
            .zip(&self.standing)
            .any(|(rule, stands)| rule.response == response && *stands)
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

    /// The first fault stays: it is the cause.
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
