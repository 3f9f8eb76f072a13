//! The controller: FIFOs, interrupts and registers.

use std::collections::VecDeque;

use super::bus::{Bus, I2cDevice, LineFault, Lines};
use super::registers::*;
use super::settings::{DMA_RDLR, DMA_TDLR, INTR_MASK, RX_TL, Settings, TX_TL, con};
use super::step::{Command, Step};
use crate::peripheral::{Cycles, Peripheral, Write, flag};

/// A controller and the devices on its bus.
#[derive(Clone, Debug)]
pub struct I2c {
    pub(super) settings: Settings,
    pub(super) enabled: bool,
    /// ENABLE was written 0: the master comes to rest even if it is enabled again meanwhile.
    pub(super) disabling: bool,
    /// IC_ENABLE.ABORT.
    pub(super) aborting: bool,
    /// IC_ENABLE.TX_CMD_BLOCK.
    pub(super) blocked: bool,
    pub(super) transmit: VecDeque<Command>,
    pub(super) receive: VecDeque<u16>,
    /// Interrupt bits that stay until they are cleared.
    pub(super) raised: u32,
    pub(super) abort_source: u32,
    pub(super) step: Step,
    /// When the step ends, unless something holds the bus.
    pub(super) due: Cycles,
    /// When a START may follow the last STOP.
    pub(super) free_at: Cycles,
    pub(super) bus: Bus,
}

impl Default for I2c {
    fn default() -> Self {
        Self::new()
    }
}

impl I2c {
    /// A controller after power-up, with nothing on its bus.
    pub fn new() -> Self {
        Self::on(Bus::new())
    }

    fn on(bus: Bus) -> Self {
        Self {
            settings: Settings::default(),
            enabled: false,
            disabling: false,
            aborting: false,
            blocked: false,
            transmit: VecDeque::with_capacity(FIFO_DEPTH),
            receive: VecDeque::with_capacity(FIFO_DEPTH),
            raised: 0,
            abort_source: 0,
            step: Step::Idle,
            due: 0,
            free_at: 0,
            bus,
        }
    }

    /// Resets the controller, which lets go of the bus; devices and faults on it stay.
    pub fn reset(&mut self) {
        let bus = std::mem::replace(&mut self.bus, Bus::new());
        *self = Self::on(bus);
    }

    /// Puts one more device on the bus.
    pub fn attach(&mut self, device: impl I2cDevice) {
        self.bus.attach(Box::new(device));
    }

    /// The first device of this type on the bus.
    pub fn device<D: I2cDevice>(&self) -> Option<&D> {
        self.bus.device()
    }

    /// The first device of this type on the bus.
    pub fn device_mut<D: I2cDevice>(&mut self) -> Option<&mut D> {
        self.bus.device_mut()
    }

    /// Breaks the bus in this way from now on, or mends it.
    pub fn set_fault(&mut self, fault: LineFault, now: Cycles) {
        self.advance(now);
        self.changed(now, |this| this.bus.set_fault(fault));
    }

    /// What is wrong with the bus.
    pub fn fault(&self) -> LineFault {
        self.bus.fault()
    }

    /// Whether the controller reaches the devices: the pins that they are wired to have its function.
    /// Without, no device acknowledges anything.
    pub(crate) fn set_connected(&mut self, connected: bool) {
        self.bus.set_connected(connected);
    }

    /// Tells what the pins drive the lines to when they are not the controller's (false is low,
    /// true released): to be called when that changes, and with both true when the pins go
    /// back to the controller.
    pub(crate) fn pins(&mut self, driven: Lines, now: Cycles) {
        self.advance(now);
        self.changed(now, |this| this.bus.pins(driven));
    }

    /// The levels that pins read which are not the controller's. What the controller itself sends
    /// is not seen in them.
    pub fn lines(&self) -> Lines {
        self.bus.lines()
    }

    /// Whether the transmit FIFO asks the DMA controller for a transfer.
    pub fn transmit_request(&self) -> bool {
        let level = self.transmit.len() as u32;
        self.enabled && self.settings.dma_transmits() && level <= self.settings.read(DMA_TDLR)
    }

    /// Whether the receive FIFO asks the DMA controller for a transfer.
    pub fn receive_request(&self) -> bool {
        let level = self.receive.len() as u32;
        self.settings.dma_receives() && level > self.settings.read(DMA_RDLR)
    }

    /// The level of its interrupt line.
    pub fn line(&self) -> bool {
        self.raw_interrupts() & self.settings.read(INTR_MASK) != 0
    }

    /// IC_RAW_INTR_STAT.
    pub(super) fn raw_interrupts(&self) -> u32 {
        let few_to_send = self.transmit.len() as u32 <= self.settings.read(TX_TL);
        let waits_for_the_byte = self.settings.has(con::TX_EMPTY_CTRL) && self.step.sends();
        let tx_empty = self.enabled && few_to_send && !waits_for_the_byte;
        let rx_full = self.receive.len() as u32 > self.settings.read(RX_TL);
        self.raised | flag(tx_empty, interrupt::TX_EMPTY) | flag(rx_full, interrupt::RX_FULL)
    }

    fn status(&self) -> u32 {
        let active = self.step != Step::Idle;
        flag(active, status::ACTIVITY | status::MST_ACTIVITY)
            | flag(self.transmit.len() < FIFO_DEPTH, status::TFNF)
            | flag(self.transmit.is_empty(), status::TFE)
            | flag(!self.receive.is_empty(), status::RFNE)
            | flag(self.receive.len() == FIFO_DEPTH, status::RFF)
    }

    fn read_enable(&self) -> u32 {
        flag(self.enabled, enable::ENABLE)
            | flag(self.aborting, enable::ABORT)
            | flag(self.blocked, enable::TX_CMD_BLOCK)
    }

    /// Reads a register that clears interrupts; returns whether one of them was there.
    fn clear(&mut self, interrupts: u32) -> u32 {
        let cleared = self.raised & interrupts;
        self.raised &= !interrupts;
        if interrupts & interrupt::TX_ABRT != 0 {
            self.abort_source = 0;
        }
        u32::from(cleared != 0)
    }

    /// While the master is active that stays.
    fn activity(&self) -> u32 {
        if self.step == Step::Idle {
            interrupt::ACTIVITY
        } else {
            0
        }
    }

    fn pop(&mut self, now: Cycles) -> u32 {
        let Some(entry) = self.receive.front().copied() else {
            self.raised |= interrupt::RX_UNDER;
            return 0;
        };
        // A bus that was held because the FIFO was full goes on.
        self.changed(now, |this| this.receive.pop_front());
        entry.into()
    }

    fn push(&mut self, command: Command, now: Cycles) {
        // After an abort the FIFO stays flushed until that is cleared.
        if !self.enabled || self.raised & interrupt::TX_ABRT != 0 {
            return;
        }
        if self.transmit.len() == FIFO_DEPTH {
            self.raised |= interrupt::TX_OVER;
            return;
        }
        self.transmit.push_back(command);
        self.go_on(now);
    }

    fn write_enable(&mut self, value: u32, now: Cycles) {
        let enabled = value & enable::ENABLE != 0;
        self.blocked = value & enable::TX_CMD_BLOCK != 0;
        if self.enabled && !enabled {
            self.disabling = true;
            self.transmit.clear();
            self.receive.clear();
            self.raised &= !(interrupt::RX_UNDER | interrupt::RX_OVER | interrupt::TX_OVER);
            self.abort_source &= (1 << abort::FLUSHED_SHIFT) - 1;
        }
        self.enabled = enabled;
        // It cannot be cleared by writing.
        self.aborting |= enabled && value & enable::ABORT != 0;
        self.go_on(now);
    }
}

impl Peripheral for I2c {
    fn read(&mut self, offset: u32, now: Cycles) -> u32 {
        self.advance(now);
        match offset {
            DATA_CMD => self.pop(now),
            INTR_STAT => self.raw_interrupts() & self.settings.read(INTR_MASK),
            RAW_INTR_STAT => self.raw_interrupts(),
            CLR_INTR => self.clear(!interrupt::ACTIVITY | self.activity()),
            CLR_RX_UNDER => self.clear(interrupt::RX_UNDER),
            CLR_RX_OVER => self.clear(interrupt::RX_OVER),
            CLR_TX_OVER => self.clear(interrupt::TX_OVER),
            CLR_TX_ABRT => self.clear(interrupt::TX_ABRT),
            CLR_ACTIVITY => self.clear(self.activity()),
            CLR_STOP_DET => self.clear(interrupt::STOP_DET),
            CLR_START_DET => self.clear(interrupt::START_DET),
            ENABLE => self.read_enable(),
            STATUS => self.status(),
            TXFLR => self.transmit.len() as u32,
            RXFLR => self.receive.len() as u32,
            TX_ABRT_SOURCE => self.abort_source,
            ENABLE_STATUS => u32::from(self.enabled || self.disabling),
            COMP_VERSION => 0x3230_312a,
            COMP_TYPE => 0x4457_0140,
            _ => self.settings.read(offset),
        }
    }

    fn write(&mut self, offset: u32, write: Write, now: Cycles) {
        self.advance(now);
        match offset {
            DATA_CMD => self.push(Command::new(write.onto(0)), now),
            ENABLE => self.write_enable(write.onto(self.read_enable()), now),
            _ => self.settings.write(offset, write, self.enabled),
        }
    }

    fn next_event(&self) -> Option<Cycles> {
        (self.step.takes_time() && !self.is_held()).then_some(self.due)
    }

    fn advance(&mut self, now: Cycles) {
        while let Some(due) = self.next_event().filter(|&due| due <= now) {
            self.finish_step(due);
        }
    }
}
