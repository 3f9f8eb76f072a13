use super::channel::ctrl::*;
use super::registers::*;
use super::*;
use crate::peripheral::{Alias, Cycles, Peripheral as _, Write};

const READ_ADDR: u32 = 0x00;
const WRITE_ADDR: u32 = 0x04;
const TRANS_COUNT: u32 = 0x08;
const CTRL_TRIG: u32 = 0x0c;
const AL1_CTRL: u32 = 0x10;
const AL1_TRANS_COUNT_TRIG: u32 = 0x1c;
const AL2_WRITE_ADDR_TRIG: u32 = 0x2c;
const AL3_READ_ADDR_TRIG: u32 = 0x3c;

const WORD: u32 = 2 << DATA_SIZE_SHIFT;
const ADC: u32 = treq::ADC << TREQ_SEL_SHIFT;
const UNPACED: u32 = treq::PERMANENT << TREQ_SEL_SHIFT;

const fn chain_to(channel: u32) -> u32 {
    channel << CHAIN_TO_SHIFT
}

const fn register(channel: u32, register: u32) -> u32 {
    channel * CHANNEL_STRIDE + register
}

fn write(dma: &mut Dma, offset: u32, value: u32) {
    dma.write(offset, Write::plain(value), 0);
}

fn read(dma: &mut Dma, offset: u32) -> u32 {
    dma.read(offset, 0)
}

/// Sets a channel up and starts it.
fn start(dma: &mut Dma, channel: u32, [from, to, count, ctrl]: [u32; 4]) {
    write(dma, register(channel, READ_ADDR), from);
    write(dma, register(channel, WRITE_ADDR), to);
    write(dma, register(channel, TRANS_COUNT), count);
    write(dma, register(channel, CTRL_TRIG), ctrl);
}

/// Makes all transfers that may be made, up to a thousand: (channel, from, to) of each.
fn run(dma: &mut Dma, requests: u64, now: Cycles) -> Vec<(usize, u32, u32)> {
    let mut made = Vec::new();
    while made.len() < 1_000
        && let Some(transfer) = dma.next_transfer(requests, now)
    {
        made.push((transfer.channel, transfer.from, transfer.to));
        dma.completed(transfer, Outcome::Moved(0));
    }
    made
}

#[test]
fn a_block_is_copied_and_the_interrupt_raised() {
    let mut dma = Dma::new();
    assert!(dma.is_idle());
    let ctrl = EN | WORD | INCR_READ | INCR_WRITE | UNPACED | chain_to(2);
    start(&mut dma, 2, [0x100, 0x200, 3, ctrl]);
    assert!(!dma.is_idle());
    assert_eq!(read(&mut dma, register(2, CTRL_TRIG)), ctrl | BUSY);
    assert_eq!(
        run(&mut dma, 0, 0),
        [(2, 0x100, 0x200), (2, 0x104, 0x204), (2, 0x108, 0x208)]
    );
    assert!(dma.is_idle());
    assert_eq!(read(&mut dma, register(2, CTRL_TRIG)), ctrl);
    assert_eq!(read(&mut dma, register(2, READ_ADDR)), 0x10c);
    assert_eq!(read(&mut dma, register(2, TRANS_COUNT)), 0);
    assert_eq!(read(&mut dma, DEBUG + register(2, 4)), 3, "reload");

    assert_eq!((read(&mut dma, INTR), read(&mut dma, INTS0)), (0b100, 0));
    assert_eq!(dma.lines(), [false, false]);
    let alias = Alias::Set;
    dma.write(INTE1, Write { value: 4, alias }, 0);
    assert_eq!(dma.lines(), [false, true]);
    assert_eq!(read(&mut dma, INTS1), 4);
    write(&mut dma, INTS1, 4);
    assert_eq!((read(&mut dma, INTR), dma.lines()), (0, [false; 2]));
    write(&mut dma, INTF0, 8);
    assert_eq!((read(&mut dma, INTS0), dma.lines()), (8, [true, false]));
}

#[test]
fn every_order_of_the_registers_shows_the_same_and_triggers_at_its_end() {
    for (trigger, value) in [
        (CTRL_TRIG, EN | UNPACED | chain_to(1)),
        (AL1_TRANS_COUNT_TRIG, 7),
        (AL2_WRITE_ADDR_TRIG, 0x2000),
        (AL3_READ_ADDR_TRIG, 0x1000),
    ] {
        let mut dma = Dma::new();
        write(&mut dma, register(1, AL1_CTRL), EN | UNPACED | chain_to(1));
        write(&mut dma, register(1, READ_ADDR), 0x1000);
        write(&mut dma, register(1, WRITE_ADDR), 0x2000);
        write(&mut dma, register(1, TRANS_COUNT), 7);
        assert!(dma.is_idle());
        write(&mut dma, register(1, trigger), value);
        assert!(!dma.is_idle(), "{trigger:#x}");
        let busy = EN | UNPACED | chain_to(1) | BUSY;
        for (order, expected) in [
            (0x00, [0x1000, 0x2000, 7, busy]),
            (0x10, [busy, 0x1000, 0x2000, 7]),
            (0x20, [busy, 7, 0x1000, 0x2000]),
            (0x30, [busy, 0x2000, 7, 0x1000]),
        ] {
            let values = [0, 4, 8, 12].map(|n| read(&mut dma, register(1, order + n)));
            assert_eq!(values, expected);
        }
    }
}

#[test]
fn null_triggers_nothing_and_ends_a_quiet_chain() {
    let mut dma = Dma::new();
    write(&mut dma, register(0, AL1_CTRL), EN | UNPACED);
    write(&mut dma, register(0, TRANS_COUNT), 1);
    write(&mut dma, register(0, AL3_READ_ADDR_TRIG), 0);
    assert!(dma.is_idle());
    assert_eq!(read(&mut dma, INTR), 0);
    write(&mut dma, register(0, AL1_CTRL), EN | UNPACED | IRQ_QUIET);
    write(&mut dma, register(0, AL3_READ_ADDR_TRIG), 0x1000);
    assert_eq!(run(&mut dma, 0, 0).len(), 1);
    assert_eq!(read(&mut dma, INTR), 0, "quiet");
    write(&mut dma, register(0, AL3_READ_ADDR_TRIG), 0);
    assert_eq!(read(&mut dma, INTR), 1);
}

#[test]
fn the_count_is_reloaded_by_each_trigger() {
    let mut dma = Dma::new();
    start(&mut dma, 0, [0, 0, 2, EN | UNPACED]);
    let transfer = dma.next_transfer(0, 0).expect("unpaced");
    dma.completed(transfer, Outcome::Moved(0));
    write(&mut dma, register(0, TRANS_COUNT), 5);
    assert_eq!(read(&mut dma, register(0, TRANS_COUNT)), 1);
    write(&mut dma, MULTI_CHAN_TRIGGER, 1);
    assert_eq!(read(&mut dma, register(0, TRANS_COUNT)), 1, "busy");
    assert_eq!(run(&mut dma, 0, 0).len(), 1);
    write(&mut dma, MULTI_CHAN_TRIGGER, 1);
    assert_eq!(run(&mut dma, 0, 0).len(), 5);
}

#[test]
fn peripherals_pace_channels_by_their_requests() {
    let mut dma = Dma::new();
    let halfwords = 1 << DATA_SIZE_SHIFT | INCR_WRITE;
    start(
        &mut dma,
        0,
        [0x4004_c00c, 0x2000_0000, 2, EN | ADC | halfwords],
    );
    assert_eq!(dma.awaited(), 1 << treq::ADC);
    assert_eq!(dma.next_transfer(!(1 << treq::ADC), 0), None);
    let transfer = dma.next_transfer(1 << treq::ADC, 0).expect("requested");
    assert_eq!(transfer.size, Size::Halfword);
    dma.completed(transfer, Outcome::Moved(0));
    assert_eq!(
        run(&mut dma, 1 << treq::ADC, 0),
        [(0, 0x4004_c00c, 0x2000_0002)]
    );
    assert_eq!(dma.awaited(), 0);
}

#[test]
fn each_single_request_is_good_for_one_transfer() {
    let mut dma = Dma::new();
    let wrap = treq::PWM_WRAP0 + 3;
    dma.request_once(wrap);
    start(&mut dma, 0, [0, 0, 100, EN | wrap << TREQ_SEL_SHIFT]);
    assert_eq!(run(&mut dma, 0, 0).len(), 0, "nothing waitsed");
    dma.request_once(wrap);
    dma.request_once(wrap);
    dma.request_once(wrap + 1);
    assert_eq!(read(&mut dma, DEBUG), 2);
    assert_eq!(run(&mut dma, 0, 0).len(), 2);
    for _ in 0..100 {
        dma.request_once(wrap);
    }
    assert_eq!(run(&mut dma, 0, 0).len(), 63, "the counter has six bits");
}

#[test]
fn timers_pace_channels() {
    let mut dma = Dma::new();
    dma.write(TIMER0 + 4, Write::plain(1 << 16 | 100), 1_000);
    assert_eq!(dma.next_event(), None, "nothing waits");
    start(
        &mut dma,
        0,
        [0, 0, 9, EN | (treq::TIMER0 + 1) << TREQ_SEL_SHIFT],
    );
    assert_eq!(dma.next_event(), Some(1_100));
    assert_eq!(run(&mut dma, !0, 1_099).len(), 0);
    assert_eq!(run(&mut dma, 0, 1_100).len(), 1);
    assert_eq!(dma.next_event(), Some(1_200));
    assert_eq!(run(&mut dma, 0, 1_350).len(), 2);
    assert_eq!(read(&mut dma, TIMER0 + 4), 1 << 16 | 100);
}

#[test]
fn channels_take_turns_and_high_priority_goes_first() {
    let mut dma = Dma::new();
    for channel in [1, 4, 9] {
        start(
            &mut dma,
            channel,
            [0, 0, 2, EN | UNPACED | chain_to(channel)],
        );
    }
    let order = |dma: &mut Dma| -> Vec<usize> {
        run(dma, 0, 0)
            .iter()
            .map(|&(channel, ..)| channel)
            .collect()
    };
    assert_eq!(order(&mut dma), [1, 4, 9, 1, 4, 9]);
    for channel in [1, 4, 9] {
        let priority = if channel == 4 { HIGH_PRIORITY } else { 0 };
        let ctrl = EN | UNPACED | priority | chain_to(channel);
        start(&mut dma, channel, [0, 0, 2, ctrl]);
    }
    assert_eq!(order(&mut dma), [4, 4, 9, 1, 9, 1]);
}

#[test]
fn rings_wrap_the_address_chosen() {
    let mut dma = Dma::new();
    let ring = EN | UNPACED | INCR_READ | INCR_WRITE | 2 << RING_SIZE_SHIFT;
    start(&mut dma, 0, [0x1003, 0x2003, 3, ring]);
    assert_eq!(
        run(&mut dma, 0, 0),
        [
            (0, 0x1003, 0x2003),
            (0, 0x1000, 0x2004),
            (0, 0x1001, 0x2005)
        ]
    );
    start(&mut dma, 0, [0x1003, 0x2003, 2, ring | RING_SEL]);
    assert_eq!(
        run(&mut dma, 0, 0),
        [(0, 0x1003, 0x2003), (0, 0x1004, 0x2000)]
    );
}

#[test]
fn a_channel_starts_the_one_it_is_chained_to() {
    let mut dma = Dma::new();
    write(&mut dma, register(7, AL1_CTRL), EN | UNPACED | chain_to(7));
    write(&mut dma, register(7, TRANS_COUNT), 1);
    start(&mut dma, 3, [0, 0, 2, EN | UNPACED | chain_to(7)]);
    let channels: Vec<_> = run(&mut dma, 0, 0).iter().map(|made| made.0).collect();
    assert_eq!(channels, [3, 3, 7]);
    assert_eq!(read(&mut dma, INTR), 1 << 3 | 1 << 7);
}

#[test]
fn empty_sequences_complete_without_end_or_transfer() {
    let mut dma = Dma::new();
    start(&mut dma, 0, [0, 0, 0, EN | UNPACED]);
    assert_eq!(run(&mut dma, 0, 0), []);
    assert_eq!((dma.is_idle(), read(&mut dma, INTR)), (true, 1));
    // Two that start each other for ever do not hang the emulator.
    write(&mut dma, register(1, AL1_CTRL), EN | UNPACED);
    start(&mut dma, 0, [0, 0, 0, EN | UNPACED | chain_to(1)]);
    assert_eq!(run(&mut dma, 0, 0), []);
    assert!(!dma.is_idle());
}

#[test]
fn pausing_keeps_the_sequence_and_aborting_ends_it() {
    let mut dma = Dma::new();
    start(&mut dma, 0, [0, 0, 4, EN | ADC]);
    write(&mut dma, register(0, AL1_CTRL), ADC);
    assert!(dma.is_idle());
    assert_eq!(run(&mut dma, !0, 0).len(), 0);
    assert_eq!(read(&mut dma, register(0, CTRL_TRIG)), ADC | BUSY);
    write(&mut dma, register(0, AL1_CTRL), EN | ADC);
    let transfer = dma.next_transfer(!0, 0).expect("resumed");
    dma.completed(transfer, Outcome::Moved(0));
    write(&mut dma, CHAN_ABORT, 1);
    assert_eq!(read(&mut dma, CHAN_ABORT), 0);
    assert_eq!(read(&mut dma, register(0, CTRL_TRIG)), EN | ADC);
    assert_eq!(read(&mut dma, register(0, TRANS_COUNT)), 3);
    assert!(dma.is_idle());
    assert_eq!(read(&mut dma, INTR), 0);
}

#[test]
fn bus_errors_halt_the_channel_and_always_interrupt() {
    for (outcome, error) in [
        (Outcome::ReadError, READ_ERROR),
        (Outcome::WriteError, WRITE_ERROR),
    ] {
        let mut dma = Dma::new();
        write(&mut dma, register(1, AL1_CTRL), EN | UNPACED | chain_to(1));
        write(&mut dma, register(1, TRANS_COUNT), 1);
        let ctrl = EN | UNPACED | IRQ_QUIET | chain_to(1);
        start(&mut dma, 0, [0, 0, 4, ctrl]);
        let transfer = dma.next_transfer(0, 0).expect("unpaced");
        dma.completed(transfer, outcome);
        assert!(dma.is_idle(), "not chained either");
        assert_eq!(read(&mut dma, INTR), 1);
        let status = register(0, CTRL_TRIG);
        assert_eq!(read(&mut dma, status), ctrl | AHB_ERROR | error);
        write(&mut dma, register(0, AL1_CTRL), error);
        assert_eq!(read(&mut dma, status), 0);
    }
}

#[test]
fn bytes_are_swapped() {
    let swapped = |size, byte_swap| {
        let transfer = Transfer {
            channel: 0,
            from: 0,
            to: 0,
            size,
            byte_swap,
        };
        transfer.swapped(0x0102_0304)
    };
    assert_eq!(swapped(Size::Word, false), 0x0102_0304);
    assert_eq!(swapped(Size::Word, true), 0x0403_0201);
    assert_eq!(swapped(Size::Halfword, true), 0x0403);
    assert_eq!(swapped(Size::Byte, true), 0x04);
}

#[test]
fn the_controller_tells_its_size_and_forgets_all_by_a_reset() {
    let mut dma = Dma::new();
    assert_eq!(read(&mut dma, N_CHANNELS), 12);
    start(&mut dma, 11, [1, 2, 3, EN | UNPACED]);
    write(&mut dma, INTE0, !0);
    assert_eq!(read(&mut dma, INTE0), 0xfff);
    dma.reset();
    assert!(dma.is_idle());
    assert_eq!(read(&mut dma, register(11, READ_ADDR)), 0);
}
