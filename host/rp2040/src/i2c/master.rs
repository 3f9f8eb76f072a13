//! What the master does on the bus, one step after the other.

use super::controller::I2c;
use super::registers::{FIFO_DEPTH, abort, interrupt};
use super::settings::con;
use super::step::{Command, Step};
use crate::peripheral::Cycles;

/// Bit of an entry of the receive FIFO: the first byte after an address.
const FIRST_DATA_BYTE: u16 = 1 << 11;
/// A byte and its acknowledgement.
const BITS: u8 = 9;
/// First byte of a 10-bit address, less its two upper bits.
const TEN_BIT_PREFIX: u8 = 0b1111_0000;

impl I2c {
    /// Whether the step cannot end for now.
    pub fn is_held(&self) -> bool {
        let full = self.receive.len() == FIFO_DEPTH;
        self.bus.clock_is_held()
            || match self.step {
                // SDA has to rise.
                Step::Stop => self.bus.data_is_held(),
                Step::Byte { command, .. } => {
                    command.read && full && self.settings.has(con::RX_FIFO_FULL_HLD_CTRL)
                }
                _ => false,
            }
    }

    /// Changes something that may have held the step; the time until now does not count then.
    pub fn changed<R>(&mut self, now: Cycles, change: impl FnOnce(&mut Self) -> R) -> R {
        let was_held = self.is_held();
        let result = change(self);
        if was_held && !self.is_held() {
            self.due = self.due.max(now);
        }
        result
    }

    /// Begins whatever there is to be done, if nothing is being done.
    pub fn go_on(&mut self, now: Cycles) {
        match self.step {
            Step::Idle => self.begin(now),
            Step::Waiting { read } => self.proceed(read, now),
            _ => {}
        }
    }

    fn take_step(&mut self, step: Step, ends: Cycles) {
        self.step = step;
        self.due = ends;
    }

    fn period(&self) -> Cycles {
        self.settings.high() + self.settings.low()
    }

    /// The bus is free.
    fn begin(&mut self, now: Cycles) {
        self.disabling = false;
        if !self.enabled {
            self.aborting = false;
            self.raised &= !interrupt::ACTIVITY;
            return;
        }
        if self.aborting {
            self.aborting = false;
            self.abort(abort::USER_ABRT);
        }
        let Some(&command) = self.transmit.front().filter(|_| !self.blocked) else {
            return;
        };
        if let Some(source) = self.refusal(command) {
            self.abort(source);
            return;
        }
        let start = now.max(self.free_at);
        self.send_address(command.read, start + self.settings.high());
    }

    /// Why the master does not even begin a transfer.
    fn refusal(&self, command: Command) -> Option<u32> {
        let ten_bits = self.settings.has(con::TEN_BIT_MASTER);
        if !self.settings.has(con::MASTER_MODE) {
            Some(abort::MASTER_DIS)
        } else if self.settings.calls_all() && command.read {
            Some(abort::GCALL_READ)
        } else if ten_bits && command.read && !self.settings.has(con::RESTART_EN) {
            Some(abort::RD_NORSTRT_10B)
        } else {
            None
        }
    }

    /// Sends the address, after the condition before it.
    fn send_address(&mut self, read: bool, condition_ends: Cycles) {
        self.raised |= interrupt::START_DET | interrupt::ACTIVITY;
        let address = self.settings.address();
        let ten_bits = self.settings.has(con::TEN_BIT_MASTER);
        if self.bus.data_is_held() {
            let first_byte = if ten_bits {
                TEN_BIT_PREFIX
            } else {
                (address << 1) as u8 | u8::from(read)
            };
            let pulses = first_byte.leading_zeros() as u8 + 1;
            let ends = condition_ends + Cycles::from(pulses) * self.period();
            self.take_step(Step::LosingArbitration { pulses }, ends);
            return;
        }
        // Before 10-bit reads the address is written, and its first byte repeated after another
        // START.
        let periods = u64::from(BITS)
            * match (ten_bits, read) {
                (false, _) => 1,
                (true, false) => 2,
                (true, true) => 3,
            };
        let ends = condition_ends + periods * self.period();
        self.take_step(Step::Address { read }, ends);
    }

    /// A step has ended.
    pub fn finish_step(&mut self, now: Cycles) {
        match self.step {
            Step::Idle | Step::Waiting { .. } => {}
            Step::Address { read } => self.finish_address(read, now),
            Step::LosingArbitration { pulses } => {
                self.bus.clock(pulses);
                self.lose_arbitration();
            }
            Step::Byte { command, first } => self.finish_byte(command, first, now),
            Step::Stop => {
                self.bus.stop();
                self.raised |= interrupt::STOP_DET;
                self.free_at = now + self.settings.low();
                self.step = Step::Idle;
                self.begin(now);
            }
        }
    }

    fn finish_address(&mut self, read: bool, now: Cycles) {
        let data_is_held = self.bus.data_is_held();
        self.bus.clock(BITS);
        if data_is_held {
            self.lose_arbitration();
        } else if self.bus.start(self.settings.address(), read) {
            match self.next_command() {
                Some(command) if command.read == read => self.transfer(command, true, now),
                _ => self.proceed(read, now),
            }
        } else {
            self.abort(if self.settings.calls_all() {
                abort::GCALL_NOACK
            } else if self.settings.has(con::TEN_BIT_MASTER) {
                abort::ADDR1_NOACK_10B
            } else {
                abort::ADDR_NOACK_7B
            });
            self.send_stop(now);
        }
    }

    fn finish_byte(&mut self, command: Command, first: bool, now: Cycles) {
        let data_is_held = self.bus.data_is_held();
        self.bus.clock(BITS);
        if command.read {
            let byte = if data_is_held { 0 } else { self.bus.read() };
            self.take(byte, first);
        } else if data_is_held && command.data != 0 {
            self.lose_arbitration();
            return;
        } else if !data_is_held && !self.bus.write(command.data) {
            self.abort(abort::TXDATA_NOACK);
            self.send_stop(now);
            return;
        }
        if command.stop {
            self.send_stop(now);
        } else {
            self.proceed(command.read, now);
        }
    }

    fn take(&mut self, byte: u8, first: bool) {
        // Disabled, its FIFO is kept empty.
        if !self.enabled || self.disabling {
            return;
        }
        if self.receive.len() == FIFO_DEPTH {
            self.raised |= interrupt::RX_OVER;
            return;
        }
        let mark = if first { FIRST_DATA_BYTE } else { 0 };
        self.receive.push_back(u16::from(byte) | mark);
    }

    /// The command that may be carried out now.
    fn next_command(&self) -> Option<Command> {
        let stops = self.disabling || self.aborting;
        let command = self.transmit.front().filter(|_| !stops && !self.blocked);
        command.copied()
    }

    /// Goes on with a transfer that has begun, in this direction so far.
    fn proceed(&mut self, read: bool, now: Cycles) {
        if self.disabling || self.aborting {
            self.send_stop(now);
            return;
        }
        match self.next_command() {
            None => self.step = Step::Waiting { read },
            Some(command) if !command.restart && command.read == read => {
                self.transfer(command, false, now);
            }
            Some(command) if self.settings.has(con::RESTART_EN) => {
                let condition = self.period() + self.settings.high();
                self.send_address(command.read, now + condition);
            }
            Some(_) => self.send_stop(now),
        }
    }

    fn transfer(&mut self, command: Command, first: bool, now: Cycles) {
        self.transmit.pop_front();
        let ends = now + u64::from(BITS) * self.period();
        self.take_step(Step::Byte { command, first }, ends);
    }

    fn send_stop(&mut self, now: Cycles) {
        self.take_step(Step::Stop, now + self.period());
    }

    /// Arbitration is lost: the master releases the bus without a STOP.
    fn lose_arbitration(&mut self) {
        self.abort(abort::LOST);
        self.step = Step::Idle;
        self.disabling = false;
    }

    /// TX_ABRT, for this reason. Both FIFOs are flushed.
    fn abort(&mut self, source: u32) {
        let flushed = (self.transmit.len() as u32) << abort::FLUSHED_SHIFT;
        self.abort_source |= source | flushed;
        self.raised |= interrupt::TX_ABRT;
        self.transmit.clear();
        self.receive.clear();
    }
}
