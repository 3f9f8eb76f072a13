//! The synchronous serial interface to the flash (RP2040 datasheet 4.10), as far as boot loaders
//! need it: short commands by its FIFO, and the set-up in which it serves reads of the flash's
//! addresses.
//!
//! Frames of a command are answered at once. The command is over, and the chip deselected, when the
//! program next looks at the status register: by then the FIFO of the hardware has run empty.

use std::collections::VecDeque;

use super::peripheral::{Cycles, Peripheral, Write};

const CTRLR0: u32 = 0x00;
const CTRLR1: u32 = 0x04;
const SSIENR: u32 = 0x08;
const TXFLR: u32 = 0x20;
const RXFLR: u32 = 0x24;
const SR: u32 = 0x28;
const IDR: u32 = 0x58;
const SSI_VERSION_ID: u32 = 0x5c;
const DR0: u32 = 0x60;
const SPI_CTRLR0: u32 = 0xf4;
/// Behind the last register.
const END: usize = 0xfc;

/// CTRLR0: frame size minus 1, transfer mode.
const DFS_32_SHIFT: u32 = 16;
const TMOD_SHIFT: u32 = 8;
/// TMOD: a command is sent, then CTRLR1 + 1 frames are received.
const EEPROM_READ: u32 = 3;
/// SPI_CTRLR0: length of the instruction, and the instruction for reads of the flash's addresses.
const INST_L_SHIFT: u32 = 8;
const XIP_CMD_SHIFT: u32 = 24;
/// SR: transmit FIFO not full and empty, receive FIFO not empty.
const TFNF: u32 = 1 << 1;
const TFE: u32 = 1 << 2;
const RFNE: u32 = 1 << 3;
/// Frames that the FIFOs hold.
const FIFO_DEPTH: usize = 16;

/// Commands of the flash.
mod command {
    pub const WRITE_STATUS: u8 = 0x01;
    pub const READ: u8 = 0x03;
    pub const READ_STATUS_1: u8 = 0x05;
    pub const WRITE_ENABLE: u8 = 0x06;
    pub const FAST_READ: u8 = 0x0b;
    pub const READ_STATUS_2: u8 = 0x35;
    pub const FAST_READ_DUAL: u8 = 0xbb;
    pub const READ_UNIQUE_ID: u8 = 0x4b;
    pub const READ_JEDEC_ID: u8 = 0x9f;
    pub const FAST_READ_QUAD: u8 = 0xeb;
}

/// Winbond, W25Q16.
const JEDEC_ID: [u8; 3] = [0xef, 0x40, 0x15];
/// Mode bits after which reads need no command.
const CONTINUOUS: u32 = 0xa0;
/// Status register 2 of a chip that was used before: quad enabled.
const QUAD_ENABLED: u8 = 0x02;

/// The interface, and what is behind it but for the memory.
#[derive(Clone, Debug)]
pub struct Ssi {
    registers: [u32; END / 4],
    /// The frames of the command under way.
    sent: Vec<u32>,
    received: VecDeque<u32>,
    unique_id: [u8; 8],
    write_enabled: bool,
    status_2: u8,
    /// The chip takes addresses without commands.
    continuous: bool,
}

impl Ssi {
    /// After a reset, in front of a chip with this number.
    pub fn new(unique_id: u64) -> Self {
        Self {
            registers: [0; END / 4],
            sent: Vec::new(),
            received: VecDeque::new(),
            unique_id: unique_id.to_be_bytes(),
            write_enabled: false,
            status_2: QUAD_ENABLED,
            continuous: false,
        }
    }

    /// A reset of the interface; the chip behind it keeps what it has.
    pub fn reset(&mut self) {
        self.registers = [0; END / 4];
        self.sent.clear();
        self.received.clear();
        self.continuous = false;
    }

    /// The chip takes commands again (the boot ROM's `flash_exit_xip`).
    pub fn exit_continuous_read(&mut self) {
        self.continuous = false;
        self.registers[SSIENR as usize / 4] = 0;
    }

    fn register(&self, offset: u32) -> u32 {
        self.registers[offset as usize / 4]
    }

    fn enabled(&self) -> bool {
        self.register(SSIENR) & 1 != 0
    }

    fn reads_after_command(&self) -> bool {
        self.register(CTRLR0) >> TMOD_SHIFT & 3 == EEPROM_READ
    }

    fn whole_words(&self) -> bool {
        self.register(CTRLR0) >> DFS_32_SHIFT & 31 == 31
    }

    /// Whether it serves reads of the flash's addresses: it reads words, with a command that the
    /// chip knows, or without one that the chip does not wait for.
    pub fn serves_reads(&self) -> bool {
        let set_up = self.register(SPI_CTRLR0);
        let understood = if set_up >> INST_L_SHIFT & 3 == 0 {
            self.continuous
        } else {
            matches!(
                (set_up >> XIP_CMD_SHIFT) as u8,
                command::READ
                    | command::FAST_READ
                    | command::FAST_READ_DUAL
                    | command::FAST_READ_QUAD
            )
        };
        self.enabled() && self.reads_after_command() && self.whole_words() && understood
    }

    /// What the chip answers to the frame at `at` of a command.
    fn answer(&self, at: usize) -> u8 {
        let byte = |bytes: &[u8], from: usize| {
            let index = at.checked_sub(from);
            index.and_then(|i| bytes.get(i)).copied().unwrap_or(0xff)
        };
        match self.sent.first().map(|frame| *frame as u8) {
            // Nothing is under way when the interface is looked at: never busy.
            Some(command::READ_STATUS_1) if at > 0 => u8::from(self.write_enabled) << 1,
            Some(command::READ_STATUS_2) if at > 0 => self.status_2,
            Some(command::READ_JEDEC_ID) => byte(&JEDEC_ID, 1),
            // After four bytes of which the chip takes no notice.
            Some(command::READ_UNIQUE_ID) => byte(&self.unique_id, 5),
            _ => 0xff,
        }
    }

    fn send(&mut self, frame: u32) {
        let at = self.sent.len();
        if at >= FIFO_DEPTH {
            return;
        }
        self.sent.push(frame);
        if !self.reads_after_command() {
            let answer = self.answer(at);
            self.received.push_back(answer.into());
        }
    }

    /// The chip is deselected: it does what the command said.
    fn end_command(&mut self) {
        if self.sent.is_empty() {
            return;
        }
        if self.reads_after_command() {
            let first = self.sent.len();
            let frames = (self.register(CTRLR1) & 0xffff) as usize + 1;
            for at in first..first + frames.min(FIFO_DEPTH) {
                let answer = self.answer(at);
                self.received.push_back(answer.into());
            }
        }
        match (self.sent[0] as u8, self.sent.get(2)) {
            (command::WRITE_ENABLE, _) => self.write_enabled = true,
            (command::WRITE_STATUS, Some(status_2)) if self.write_enabled => {
                self.status_2 = *status_2 as u8;
                self.write_enabled = false;
            }
            (command::FAST_READ_QUAD, _) => {
                let mode = self.sent.get(1).map_or(0, |frame| frame & 0xf0);
                self.continuous = mode == CONTINUOUS && self.status_2 & QUAD_ENABLED != 0;
            }
            _ => {}
        }
        self.sent.clear();
    }
}

impl Peripheral for Ssi {
    fn read(&mut self, offset: u32, _now: Cycles) -> u32 {
        match offset {
            SR => {
                self.end_command();
                let ready = if self.received.is_empty() { 0 } else { RFNE };
                TFNF | TFE | ready
            }
            TXFLR => 0,
            RXFLR => self.received.len() as u32,
            IDR => 0x5135_3049,
            SSI_VERSION_ID => 0x3430_312a,
            DR0..SPI_CTRLR0 if offset < 0xf0 => {
                self.end_command();
                self.received.pop_front().unwrap_or(0)
            }
            _ => self
                .registers
                .get(offset as usize / 4)
                .copied()
                .unwrap_or(0),
        }
    }

    fn write(&mut self, offset: u32, write: Write, _now: Cycles) {
        match offset {
            DR0..SPI_CTRLR0 if offset < 0xf0 => {
                if self.enabled() {
                    self.send(write.value);
                }
            }
            SR | TXFLR | RXFLR | IDR | SSI_VERSION_ID => {}
            _ => {
                if let Some(register) = self.registers.get_mut(offset as usize / 4) {
                    *register = write.onto(*register);
                }
                if offset == SSIENR && !self.enabled() {
                    self.end_command();
                    self.received.clear();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(ssi: &mut Ssi, offset: u32, value: u32) {
        ssi.write(offset, Write::plain(value), 0);
    }

    /// Sends bytes, each of which brings one back.
    fn exchange(ssi: &mut Ssi, bytes: &[u8]) -> Vec<u32> {
        write(ssi, SSIENR, 0);
        write(ssi, CTRLR0, 7 << DFS_32_SHIFT);
        write(ssi, SSIENR, 1);
        for byte in bytes {
            write(ssi, DR0, (*byte).into());
        }
        assert_eq!(ssi.read(SR, 0), TFE | TFNF | RFNE);
        let answers = bytes.iter().map(|_| ssi.read(DR0, 0)).collect();
        assert_eq!(ssi.read(SR, 0), TFE | TFNF);
        answers
    }

    #[test]
    fn the_status_is_read_and_written() {
        let mut ssi = Ssi::new(0);
        assert_eq!(exchange(&mut ssi, &[command::READ_STATUS_2, 0])[1], 2);
        exchange(&mut ssi, &[command::WRITE_STATUS, 0, 0]);
        assert_eq!(exchange(&mut ssi, &[command::READ_STATUS_2, 0])[1], 2);
        exchange(&mut ssi, &[command::WRITE_ENABLE]);
        assert_eq!(exchange(&mut ssi, &[command::READ_STATUS_1, 0])[1], 2);
        exchange(&mut ssi, &[command::WRITE_STATUS, 0, 0]);
        assert_eq!(exchange(&mut ssi, &[command::READ_STATUS_1, 0])[1], 0);
        assert_eq!(exchange(&mut ssi, &[command::READ_STATUS_2, 0])[1], 0);
    }

    #[test]
    fn the_chip_says_who_it_is() {
        let mut ssi = Ssi::new(0x0102_0304_0506_0708);
        let id = exchange(&mut ssi, &[command::READ_JEDEC_ID, 0, 0, 0]);
        assert_eq!(id[1..], [0xef, 0x40, 0x15]);
        // As embassy-rp reads it: the command, then frames that are only received.
        write(&mut ssi, SSIENR, 0);
        write(
            &mut ssi,
            CTRLR0,
            7 << DFS_32_SHIFT | EEPROM_READ << TMOD_SHIFT,
        );
        write(&mut ssi, CTRLR1, 4 + 8 - 1);
        write(&mut ssi, SSIENR, 1);
        write(&mut ssi, DR0, command::READ_UNIQUE_ID.into());
        let mut answers = vec![];
        while ssi.read(SR, 0) & RFNE != 0 {
            answers.push(ssi.read(DR0, 0));
        }
        assert_eq!(answers[4..], [1, 2, 3, 4, 5, 6, 7, 8]);
    }

    /// What boot2_w25q080 does: a quad read that leaves the chip without commands, then the set-up
    /// for it.
    fn set_up_quad(ssi: &mut Ssi) {
        let words = 2 << 21 | 31 << DFS_32_SHIFT | EEPROM_READ << TMOD_SHIFT;
        write(ssi, SSIENR, 0);
        write(ssi, CTRLR0, words);
        write(ssi, CTRLR1, 0);
        write(ssi, SPI_CTRLR0, 8 << 2 | 4 << 11 | 2 << INST_L_SHIFT | 1);
        write(ssi, SSIENR, 1);
        assert!(!ssi.serves_reads());
        write(ssi, DR0, command::FAST_READ_QUAD.into());
        write(ssi, DR0, CONTINUOUS);
        ssi.read(SR, 0);
        write(ssi, SSIENR, 0);
        write(
            ssi,
            SPI_CTRLR0,
            CONTINUOUS << XIP_CMD_SHIFT | 8 << 2 | 4 << 11 | 2,
        );
        write(ssi, SSIENR, 1);
    }

    #[test]
    fn it_serves_reads_once_set_up() {
        let mut ssi = Ssi::new(0);
        set_up_quad(&mut ssi);
        assert!(ssi.serves_reads());
        ssi.exit_continuous_read();
        assert!(!ssi.serves_reads());
        // Plain reads, which need no mode.
        write(
            &mut ssi,
            CTRLR0,
            31 << DFS_32_SHIFT | EEPROM_READ << TMOD_SHIFT,
        );
        write(
            &mut ssi,
            SPI_CTRLR0,
            0x03 << XIP_CMD_SHIFT | 6 << 2 | 2 << INST_L_SHIFT,
        );
        write(&mut ssi, SSIENR, 1);
        assert!(ssi.serves_reads());
    }

    #[test]
    fn quad_reads_need_the_quad_bit() {
        let mut ssi = Ssi::new(0);
        exchange(&mut ssi, &[command::WRITE_ENABLE]);
        exchange(&mut ssi, &[command::WRITE_STATUS, 0, 0]);
        set_up_quad(&mut ssi);
        assert!(!ssi.serves_reads());
    }
}
