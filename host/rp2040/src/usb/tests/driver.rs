//! The program's end of the cable, for tests: drives the controller's registers in the order in
//! which embassy-rp 0.10 and embassy-usb 0.6 do.

use std::collections::VecDeque;

use super::super::Usb;
use super::super::descriptor::tests::{A_DEVICE, A_SERIAL_PORT};
use super::super::registers as r;
use crate::peripheral::{Alias, Cycles, Peripheral, Write};

pub const AVAILABLE: u32 = 1 << 10;
pub const STALL: u32 = 1 << 11;
pub const DATA1: u32 = 1 << 13;
pub const FULL: u32 = 1 << 15;
const ENABLE: u32 = 1 << 31;
const ENABLED_INTERRUPTS: u32 = 1 << 4 | 1 << 12 | 1 << 14 | 1 << 15 | 1 << 16;

/// The bulk endpoints of [`A_SERIAL_PORT`], and where their control words are.
pub const IN_CONTROL: u32 = 0x08 + 8;
pub const OUT_CONTROL: u32 = 0x0c;
pub const IN_BUFFER_CONTROL: u32 = 0x80 + 16;
pub const OUT_BUFFER_CONTROL: u32 = 0x84 + 8;
const NOTIFICATION_CONTROL: u32 = 0x08;
const NOTIFICATION_BUFFER_CONTROL: u32 = 0x80 + 8;
const EP0_IN: u32 = 0x80;
const EP0_OUT: u32 = 0x84;
const OUT_BUFFER: u32 = 0x1c0;
const IN_BUFFER: u32 = 0x200;

/// What the control pipe is at.
#[derive(Debug)]
enum Control {
    Setup,
    DataIn(VecDeque<Vec<u8>>),
    DataOut([u8; 8]),
    Accept(Option<u8>),
}

/// The driver, and what a program has it do.
#[derive(Debug)]
pub struct Driver {
    control: Control,
    pub device: Vec<u8>,
    pub configuration: Vec<u8>,
    /// The descriptor that it refuses to give, by its type.
    pub refuses: Option<u8>,
    /// Whether it looks at the control pipe at all.
    pub serves: bool,
    /// Whether a bus reset ends what the control pipe is at. In embassy-rp 0.10 it does not: a
    /// request that the host has abandoned is waited for, and the bus is not looked at meanwhile.
    pub heeds_reset: bool,
    /// Whether its program reads what comes.
    pub reads: bool,
    /// Packets to be sent.
    pub outbox: VecDeque<Vec<u8>>,
    /// Bytes that came, of each configuration from the first one on.
    pub inboxes: Vec<Vec<u8>>,
    pub dtr: bool,
    pub line_coding: Vec<u8>,
    pub suspended: bool,
    pub resets: u32,
}

pub fn word(usb: &mut Usb, offset: u32, now: Cycles) -> u32 {
    u32::from_le_bytes(usb.read_memory(offset, now))
}

pub fn set_word(usb: &mut Usb, offset: u32, value: u32, now: Cycles) {
    usb.write_memory(offset, value.to_le_bytes(), now);
}

/// Hands a buffer over in two writes, as it has to be (datasheet 4.1.2.5.3).
pub fn hand_over(usb: &mut Usb, offset: u32, value: u32, now: Cycles) {
    set_word(usb, offset, value, now);
    set_word(usb, offset, value | AVAILABLE, now);
}

fn available(usb: &mut Usb, offset: u32, now: Cycles) -> bool {
    word(usb, offset, now) & AVAILABLE != 0
}

fn load(usb: &mut Usb, offset: u32, length: u32, now: Cycles) -> Vec<u8> {
    (0..length)
        .map(|i| usb.read_memory::<1>(offset + i, now)[0])
        .collect()
}

fn store(usb: &mut Usb, offset: u32, bytes: &[u8], now: Cycles) {
    for (i, byte) in bytes.iter().enumerate() {
        usb.write_memory(offset + i as u32, [*byte], now);
    }
}

fn write(usb: &mut Usb, offset: u32, value: u32, now: Cycles) {
    usb.write(offset, Write::plain(value), now);
}

impl Driver {
    /// Sets the controller up and switches the pull-up on.
    pub fn start(usb: &mut Usb, now: Cycles) -> Self {
        for offset in (0..0x9c).step_by(4) {
            write(usb, offset, 0, now);
        }
        for offset in (0..0x100).step_by(4) {
            set_word(usb, offset, 0, now);
        }
        write(usb, r::USB_MUXING, 1 | 1 << 3, now);
        write(usb, r::USB_PWR, 1 << 2 | 1 << 3, now);
        write(usb, r::MAIN_CTRL, 1, now);
        set_word(usb, NOTIFICATION_CONTROL, 1 << 29 | 3 << 26 | 0x180, now);
        set_word(usb, OUT_CONTROL, 1 << 29 | 2 << 26 | OUT_BUFFER, now);
        set_word(usb, IN_CONTROL, 1 << 29 | 2 << 26 | IN_BUFFER, now);
        write(usb, r::INTE, ENABLED_INTERRUPTS, now);
        write(usb, r::INT_EP_CTRL, 0xfffe, now);
        write(usb, r::SIE_CTRL, r::EP0_INT_1BUF | r::PULLUP_EN, now);
        Self {
            control: Control::Setup,
            device: A_DEVICE.to_vec(),
            configuration: A_SERIAL_PORT.to_vec(),
            refuses: None,
            serves: true,
            heeds_reset: true,
            reads: true,
            outbox: VecDeque::new(),
            inboxes: Vec::new(),
            dtr: false,
            line_coding: Vec::new(),
            suspended: false,
            resets: 0,
        }
    }

    /// Interrupt handler and tasks, until all of them wait.
    pub fn poll(&mut self, usb: &mut Usb, now: Cycles) {
        self.interrupt(usb, now);
        loop {
            if self.heeds_reset || matches!(self.control, Control::Setup) {
                self.bus(usb, now);
            }
            if self.suspended || !self.serves || !self.control(usb, now) {
                break;
            }
        }
        self.bulk(usb, now);
    }

    fn interrupt(&mut self, usb: &mut Usb, now: Cycles) {
        let ints = usb.read(r::INTS, now);
        let once = ints & (1 << 12 | 1 << 14 | 1 << 15 | 1 << 16);
        let clear = Write {
            value: once,
            alias: Alias::Clear,
        };
        usb.write(r::INTE, clear, now);
        if ints & 1 << 4 != 0 {
            let done = usb.read(r::BUFF_STATUS, now);
            write(usb, r::BUFF_STATUS, done, now);
        }
    }

    fn bus(&mut self, usb: &mut Usb, now: Cycles) {
        loop {
            let status = usb.read(r::SIE_STATUS, now);
            let raw = usb.read(r::INTR, now);
            if status & r::RESUME != 0 || raw & 1 << 15 != 0 {
                write(usb, r::SIE_STATUS, r::RESUME, now);
                self.suspended = false;
            } else if status & r::BUS_RESET != 0 {
                write(usb, r::SIE_STATUS, r::BUS_RESET | r::SETUP_REC, now);
                write(usb, r::BUFF_STATUS, u32::MAX, now);
                write(usb, r::ADDR_ENDP, 0, now);
                for offset in (0x08..0x80).step_by(4) {
                    let control = word(usb, offset, now);
                    set_word(usb, offset, control & !ENABLE, now);
                }
                if self.heeds_reset {
                    set_word(usb, EP0_IN, 0, now);
                    set_word(usb, EP0_OUT, 0, now);
                    self.control = Control::Setup;
                }
                self.suspended = false;
                self.dtr = false;
                self.resets += 1;
            } else if status & r::SUSPENDED != 0 && raw & 1 << 14 != 0 {
                write(usb, r::SIE_STATUS, r::SUSPENDED, now);
                self.suspended = true;
            } else {
                break;
            }
        }
        let set = Write {
            value: 1 << 12 | 1 << 14 | 1 << 15,
            alias: Alias::Set,
        };
        usb.write(r::INTE, set, now);
    }

    /// Returns true if it has got on.
    fn control(&mut self, usb: &mut Usb, now: Cycles) -> bool {
        match &mut self.control {
            Control::Setup => {
                let set = Write {
                    value: 1 << 16,
                    alias: Alias::Set,
                };
                usb.write(r::INTE, set, now);
                if usb.read(r::SIE_STATUS, now) & r::SETUP_REC == 0 {
                    return false;
                }
                let packet = usb.read_memory(0, now);
                write(usb, r::SIE_STATUS, r::SETUP_REC, now);
                set_word(usb, EP0_IN, 0, now);
                set_word(usb, EP0_OUT, 0, now);
                self.request(usb, packet, now);
            }
            Control::DataIn(_) if available(usb, EP0_IN, now) => return false,
            Control::DataIn(packets) => match packets.pop_front() {
                Some(packet) => Self::data_in(usb, &packet, now),
                None => {
                    hand_over(usb, EP0_OUT, DATA1, now);
                    self.control = Control::Setup;
                }
            },
            Control::DataOut(_) | Control::Accept(_)
                if available(usb, EP0_OUT, now) || available(usb, EP0_IN, now) =>
            {
                return false;
            }
            Control::DataOut(packet) => {
                let packet = *packet;
                let length = word(usb, EP0_OUT, now) & 0x3ff;
                let data = load(usb, 0x100, length, now);
                self.carry_out(usb, packet, data, now);
            }
            Control::Accept(address) => {
                if let Some(address) = address {
                    write(usb, r::ADDR_ENDP, u32::from(*address), now);
                }
                self.control = Control::Setup;
            }
        }
        true
    }

    fn request(&mut self, usb: &mut Usb, packet: [u8; 8], now: Cycles) {
        let wanted = usize::from(u16::from_le_bytes([packet[6], packet[7]]));
        let reply = match packet {
            [0x80, 6, _, kind, ..] if self.refuses == Some(kind) => None,
            [0x80, 6, _, 1, ..] => Some(self.device.clone()),
            [0x80, 6, _, 2, ..] => Some(self.configuration.clone()),
            [0x80, 6, 0, 3, ..] => Some(vec![4, 3, 9, 4]),
            [0x80, 6, index, 3, ..] => Some(vec![4, 3, b'0' + index, 0]),
            [0x80, ..] | [0xa1, ..] => None,
            _ if wanted > 0 => {
                let pid = !word(usb, EP0_OUT, now) & DATA1;
                hand_over(usb, EP0_OUT, 64 | pid, now);
                self.control = Control::DataOut(packet);
                return;
            }
            _ => return self.carry_out(usb, packet, Vec::new(), now),
        };
        let Some(mut reply) = reply else {
            return Self::reject(usb, now);
        };
        reply.truncate(wanted);
        let mut packets: VecDeque<Vec<u8>> = reply.chunks(64).map(<[u8]>::to_vec).collect();
        if reply.len() < wanted && reply.len().is_multiple_of(64) {
            packets.push_back(Vec::new());
        }
        if let Some(first) = packets.pop_front() {
            Self::data_in(usb, &first, now);
        }
        self.control = Control::DataIn(packets);
    }

    fn data_in(usb: &mut Usb, packet: &[u8], now: Cycles) {
        store(usb, 0x100, packet, now);
        let pid = !word(usb, EP0_IN, now) & DATA1;
        hand_over(usb, EP0_IN, packet.len() as u32 | pid | FULL, now);
    }

    fn carry_out(&mut self, usb: &mut Usb, packet: [u8; 8], data: Vec<u8>, now: Cycles) {
        let mut address = None;
        match packet {
            [0, 5, new, ..] => address = Some(new),
            [0, 9, 1, ..] => self.configure(usb, now),
            [0x21, 0x20, ..] => self.line_coding = data,
            [0x21, 0x22, lines, ..] => self.dtr = lines & 1 != 0,
            [0x02, 1, 0, 0, endpoint, ..] => {
                let offset = match endpoint {
                    0x82 => IN_BUFFER_CONTROL,
                    _ => OUT_BUFFER_CONTROL,
                };
                let control = word(usb, offset, now);
                set_word(usb, offset, control & !STALL, now);
            }
            _ => {
                self.control = Control::Setup;
                return Self::reject(usb, now);
            }
        }
        hand_over(usb, EP0_IN, DATA1 | FULL, now);
        self.control = Control::Accept(address);
    }

    fn configure(&mut self, usb: &mut Usb, now: Cycles) {
        for (control, buffer) in [
            (NOTIFICATION_CONTROL, NOTIFICATION_BUFFER_CONTROL),
            (IN_CONTROL, IN_BUFFER_CONTROL),
            (OUT_CONTROL, OUT_BUFFER_CONTROL),
        ] {
            let enabled = word(usb, control, now) | ENABLE;
            set_word(usb, control, enabled, now);
            if control == OUT_CONTROL {
                hand_over(usb, buffer, 64, now);
            } else {
                set_word(usb, buffer, DATA1, now);
            }
        }
        self.inboxes.push(Vec::new());
    }

    fn reject(usb: &mut Usb, now: Cycles) {
        let set = Write {
            value: 3,
            alias: Alias::Set,
        };
        usb.write(r::EP_STALL_ARM, set, now);
        set_word(usb, EP0_OUT, STALL, now);
        set_word(usb, EP0_IN, STALL, now);
    }

    fn bulk(&mut self, usb: &mut Usb, now: Cycles) {
        while self.reads
            && word(usb, OUT_CONTROL, now) & ENABLE != 0
            && !available(usb, OUT_BUFFER_CONTROL, now)
        {
            let control = word(usb, OUT_BUFFER_CONTROL, now);
            let bytes = load(usb, OUT_BUFFER, control & 0x3ff, now);
            if let Some(inbox) = self.inboxes.last_mut() {
                inbox.extend(bytes);
            }
            hand_over(usb, OUT_BUFFER_CONTROL, !control & DATA1 | 64, now);
        }
        while !available(usb, IN_BUFFER_CONTROL, now) {
            let Some(packet) = self.outbox.pop_front() else {
                break;
            };
            store(usb, IN_BUFFER, &packet, now);
            let pid = !word(usb, IN_BUFFER_CONTROL, now) & DATA1;
            let value = packet.len() as u32 | pid | FULL;
            hand_over(usb, IN_BUFFER_CONTROL, value, now);
        }
    }
}
