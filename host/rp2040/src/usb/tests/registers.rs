//! Registers and memory by themselves.

use super::super::controller::{Answer, Controller, Pid, Reply};
use super::super::dpram::{Direction, Endpoint};
use super::super::registers as r;
use super::driver::{AVAILABLE, DATA1, Driver, FULL, STALL, hand_over, set_word, word};
use super::{MILLISECOND, Usb};
use crate::peripheral::{Alias, Peripheral, Write};

const IN_1: Endpoint = Endpoint::new(1, Direction::In);
const OUT_1: Endpoint = Endpoint::new(1, Direction::Out);

/// A controller with its pull-up on that answers to address 0.
fn attached() -> Controller {
    let mut controller = Controller::new();
    controller.write(r::USB_MUXING, Write::plain(r::TO_PHY));
    controller.write(r::MAIN_CTRL, Write::plain(r::CONTROLLER_EN));
    let control = r::PULLUP_EN | r::EP0_INT_1BUF;
    controller.write(r::SIE_CTRL, Write::plain(control));
    controller
}

fn set(controller: &mut Controller, offset: u32, word: u32) {
    controller.write_dpram(offset, word.to_le_bytes());
}

fn get(controller: &Controller, offset: u32) -> u32 {
    u32::from_le_bytes(controller.read_dpram(offset))
}

#[test]
fn registers_start_and_are_written_as_the_datasheet_says() {
    let mut usb = Usb::new();
    assert_eq!(usb.read(r::NAK_POLL, 0), 0x0010_0010);
    assert_eq!(usb.read(r::USBPHY_TRIM, 0), 0x1f1f);
    for offset in [r::ADDR_ENDP, r::MAIN_CTRL, r::SIE_CTRL, r::INTE, 0xffc] {
        assert_eq!(usb.read(offset, 0), 0, "{offset:#x}");
    }
    usb.write(r::SIE_CTRL, Write::plain(u32::MAX), 0);
    assert_eq!(usb.read(r::SIE_CTRL, 0), 0xff07_8f4e);
    let alias = |value, alias| Write { value, alias };
    usb.write(r::INTE, alias(0x11, Alias::Set), 0);
    usb.write(r::INTE, alias(0x01, Alias::Clear), 0);
    usb.write(r::INTE, alias(0x03, Alias::Xor), 0);
    assert_eq!(usb.read(r::INTE, 0), 0x13);
    usb.reset(0);
    assert_eq!(usb.read(r::INTE, 0), 0);
}

#[test]
fn memory_takes_bytes_halfwords_and_words_and_outlives_a_reset() {
    let mut usb = Usb::new();
    usb.write_memory(0x180, [1, 2, 3, 4], 0);
    usb.write_memory(0x182, [9, 8], 0);
    usb.write_memory(0x181, [7], 0);
    usb.reset(0);
    assert_eq!(word(&mut usb, 0x180, 0), 0x0809_0701);
    assert_eq!(usb.read_memory(0x182, 0), [9, 8]);
}

#[test]
fn power_is_what_the_program_says() {
    let mut usb = Usb::new();
    usb.plug(0);
    assert_eq!(usb.read(r::SIE_STATUS, 0) & r::VBUS_DETECTED, 0);
    Driver::start(&mut usb, 0);
    let status = usb.read(r::SIE_STATUS, 0);
    assert_eq!(status, r::VBUS_DETECTED | r::CONNECTED | 1 << 2, "idle, J");
    assert_ne!(usb.read(r::INTR, 0) & r::INT_DEV_CONN_DIS, 0);
    usb.write(r::SIE_STATUS, Write::plain(r::CONNECTED), 0);
    assert_eq!(usb.read(r::INTR, 0) & r::INT_DEV_CONN_DIS, 0);
    usb.unplug(0);
    let status = usb.read(r::SIE_STATUS, 0);
    assert_ne!(status & r::CONNECTED, 0, "the device cannot know");
}

#[test]
fn a_reset_is_seen_and_interrupts() {
    let mut usb = Usb::new();
    Driver::start(&mut usb, 0);
    usb.plug(0);
    usb.advance(99 * MILLISECOND);
    assert_ne!(
        usb.read(r::INTS, 99 * MILLISECOND) & 1 << 14,
        0,
        "idle until then"
    );
    usb.write(r::SIE_STATUS, Write::plain(r::SUSPENDED), 99 * MILLISECOND);
    assert!(!usb.interrupt());
    assert_eq!(usb.next_event(), Some(100 * MILLISECOND));
    usb.advance(100 * MILLISECOND);
    assert!(usb.interrupt());
    let status = usb.read(r::SIE_STATUS, 100 * MILLISECOND);
    assert_eq!(status & (r::BUS_RESET | 3 << 2), r::BUS_RESET, "SE0");
    let clear = Write {
        value: r::BUS_RESET,
        alias: Alias::Clear,
    };
    usb.write(r::SIE_STATUS, clear, 100 * MILLISECOND);
    assert!(!usb.interrupt());
}

#[test]
fn interrupts_are_enabled_and_forced() {
    let mut controller = attached();
    assert!(controller.setup(0, [1; 8]));
    assert_eq!(controller.read(r::INTR) & 1 << 16, 1 << 16);
    assert!(!controller.interrupt());
    controller.write(r::INTE, Write::plain(1 << 16));
    assert!(controller.interrupt());
    controller.write(r::SIE_STATUS, Write::plain(r::SETUP_REC));
    assert!(!controller.interrupt());
    controller.write(r::INTF, Write::plain(1 << 4));
    assert_eq!(controller.read(r::INTS), 1 << 4);
}

#[test]
fn frames_are_counted_for_whoever_looks() {
    let mut usb = Usb::new();
    Driver::start(&mut usb, 0);
    usb.plug(0);
    let first = 150 * MILLISECOND;
    let at = |frame| first + frame * MILLISECOND + 17;
    usb.advance(at(0));
    assert_eq!(usb.read(r::SOF_RD, at(3)), 3);
    assert_eq!(usb.read(r::INTR, at(3)) & r::INT_DEV_SOF, 0);
    assert_ne!(usb.read(r::INTR, at(4)) & r::INT_DEV_SOF, 0);
    assert_eq!(usb.read(r::SOF_RD, at(2048 + 5)), 5, "11 bits");
    usb.write(r::INTE, Write::plain(r::INT_DEV_SOF), at(2054));
    usb.read(r::SOF_RD, at(2054));
    assert!(!usb.interrupt());
    assert_eq!(usb.next_event(), Some(first + 2055 * MILLISECOND));
    usb.advance(first + 2055 * MILLISECOND);
    assert!(usb.interrupt());
}

#[test]
fn setup_packets_are_always_taken() {
    let mut controller = attached();
    controller.write(r::EP_STALL_ARM, Write::plain(3));
    set(&mut controller, 0x80, STALL);
    assert_eq!(controller.answer(0, Endpoint::CONTROL_IN), Answer::Stall);
    assert!(!controller.setup(5, [9; 8]), "another address");
    assert!(controller.setup(0, [1, 2, 3, 4, 5, 6, 7, 8]));
    assert_eq!(controller.read_dpram(0), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(controller.read(r::EP_STALL_ARM), 0, "SETUP ends a stall");
    assert_eq!(controller.answer(0, Endpoint::CONTROL_IN), Answer::Nak);
}

#[test]
fn endpoints_answer_when_enabled_and_available() {
    let mut controller = attached();
    assert_eq!(controller.answer(0, IN_1), Answer::Silence);
    set(&mut controller, 0x08, 1 << 31 | 0x180);
    assert_eq!(controller.answer(0, IN_1), Answer::Nak);
    set(&mut controller, 0x88, AVAILABLE | 5);
    assert_eq!(controller.answer(0, IN_1), Answer::Nak, "not full");
    set(&mut controller, 0x88, AVAILABLE | FULL | 5);
    assert_eq!(controller.answer(0, IN_1), Answer::Ready(5));
    assert_eq!(controller.answer(1, IN_1), Answer::Silence);
    controller.write(r::EP_ABORT, Write::plain(IN_1.mask()));
    assert_eq!(controller.answer(0, IN_1), Answer::Nak);
    assert_eq!(controller.read(r::EP_ABORT_DONE), IN_1.mask());
    controller.write(r::EP_ABORT, Write::plain(0));
    controller.write(r::MAIN_CTRL, Write::plain(0));
    assert_eq!(controller.answer(0, IN_1), Answer::Silence, "off");
}

#[test]
fn buffers_come_back_with_what_was_done() {
    let mut controller = attached();
    set(&mut controller, 0x08, 1 << 31 | 1 << 29 | 0x180);
    set(&mut controller, 0x0c, 1 << 31 | 1 << 29 | 0x1c0);
    controller.write_dpram(0x180, *b"data");
    set(
        &mut controller,
        0x88,
        AVAILABLE | FULL | DATA1 | 1 << 14 | 4,
    );
    let reply = controller.give(0, IN_1);
    assert_eq!(reply, Reply::Data(Pid::Data1, b"data".to_vec()));
    assert_eq!(get(&controller, 0x88), DATA1 | 1 << 14 | 4);
    assert_eq!(controller.read(r::BUFF_STATUS), IN_1.mask());
    assert_ne!(controller.read(r::SIE_STATUS) & r::TRANS_COMPLETE, 0);
    let nothing = Reply::None(Answer::Nak);
    assert_eq!(controller.give(0, IN_1), nothing);

    set(&mut controller, 0x8c, AVAILABLE | 64);
    let wrong = controller.take(0, OUT_1, Pid::Data1, b"again");
    assert_eq!(wrong, Answer::Ready(64), "acknowledged, and dropped");
    assert_ne!(controller.read(r::SIE_STATUS) & r::DATA_SEQ_ERROR, 0);
    assert_eq!(get(&controller, 0x8c), AVAILABLE | 64);
    let taken = controller.take(0, OUT_1, Pid::Data0, b"bytes");
    assert_eq!(taken, Answer::Ready(64));
    assert_eq!(get(&controller, 0x8c), FULL | 5);
    assert_eq!(controller.read_dpram(0x1c0), *b"bytes");
    assert_eq!(controller.read(r::BUFF_STATUS), IN_1.mask() | OUT_1.mask());
    controller.write(r::BUFF_STATUS, Write::plain(IN_1.mask()));
    assert_eq!(controller.read(r::BUFF_STATUS), OUT_1.mask());
}

#[test]
fn two_buffers_take_turns() {
    let mut controller = attached();
    let both = (AVAILABLE | FULL | 1) | (AVAILABLE | FULL | DATA1 | 2) << 16;
    set(&mut controller, 0x08, 1 << 31 | 1 << 30 | 1 << 28 | 0x180);
    controller.write_dpram(0x180, [1]);
    controller.write_dpram(0x1c0, [2, 3]);
    set(&mut controller, 0x88, both);
    assert_eq!(controller.give(0, IN_1), Reply::Data(Pid::Data0, vec![1]));
    assert_eq!(controller.read(r::BUFF_STATUS), 0, "after both");
    let second = Reply::Data(Pid::Data1, vec![2, 3]);
    assert_eq!(controller.give(0, IN_1), second);
    assert_eq!(controller.read(r::BUFF_STATUS), IN_1.mask());
    assert_eq!(controller.read(r::BUFF_CPU_SHOULD_HANDLE), IN_1.mask());
    assert_eq!(get(&controller, 0x88), 1 | (DATA1 | 2) << 16);
    // The first again; and once more, if told so.
    set(&mut controller, 0x88, both);
    controller.give(0, IN_1);
    set(&mut controller, 0x88, both | 1 << 12);
    assert_eq!(controller.give(0, IN_1), Reply::Data(Pid::Data0, vec![1]));
    assert_eq!(get(&controller, 0x88) & 1 << 12, 0);
}

#[test]
fn refusals_are_told_if_wanted() {
    let mut controller = attached();
    set(&mut controller, 0x08, 1 << 31 | 1 << 16);
    set(&mut controller, 0x0c, 1 << 31 | 1 << 17);
    controller.give(0, IN_1);
    controller.take(0, OUT_1, Pid::Data0, &[]);
    assert_eq!(controller.read(r::EP_STATUS_STALL_NAK), IN_1.mask());
    set(&mut controller, 0x8c, STALL);
    controller.take(0, OUT_1, Pid::Data0, &[]);
    let both = IN_1.mask() | OUT_1.mask();
    assert_eq!(controller.read(r::EP_STATUS_STALL_NAK), both);
    assert_ne!(controller.read(r::INTR) & r::INT_EP_STALL_NAK, 0);
}

#[test]
fn nonsense_in_memory_does_no_harm() {
    let mut usb = Usb::new();
    Driver::start(&mut usb, 0);
    usb.plug(0);
    for (i, word) in [u32::MAX, 0x8000_ffff, 0xffff_8000].iter().enumerate() {
        let now = (i as u64 + 1) * 400 * MILLISECOND;
        for offset in (0..0x1000).step_by(4) {
            set_word(&mut usb, offset, *word, now);
        }
        hand_over(&mut usb, 0x80, 0x83ff, now);
        usb.advance(now + 300 * MILLISECOND);
    }
}
