use proptest::prelude::*;

use super::*;

/// Slice 0 at 20 kHz: 125 MHz, 6250 counts, 20 kHz.
fn running() -> Pwm {
    let mut pwm = Pwm::new();
    pwm.write(TOP, Write::plain(6_249), 0);
    pwm.write(CSR, Write::plain(csr::EN), 0);
    pwm
}

#[test]
fn registers_after_a_reset() {
    let mut pwm = Pwm::new();
    for slice in 0..SLICES as u32 {
        let registers = [CSR, DIV, CTR, CC, TOP].map(|r| pwm.read(slice * STRIDE + r, 0));
        assert_eq!(registers, [0, 0x10, 0, 0, 0xffff]);
    }
    assert_eq!([EN, INTR, INTE, INTF, INTS].map(|r| pwm.read(r, 0)), [0; 5]);
    assert_eq!(pwm.next_event(), None);
}

#[test]
fn new_compare_values_take_over_at_the_wrap() {
    let mut pwm = running();
    assert_eq!(pwm.next_event(), None, "nothing waits");
    pwm.write(CC, Write::plain(3_125 | 625 << 16), 1_000);
    assert_eq!(pwm.output(0).duty(), 0.0);
    assert_eq!(pwm.next_event(), Some(6_250));
    pwm.advance(6_250);
    assert_eq!((pwm.output(0).duty(), pwm.output(1).duty()), (0.5, 0.1));
    assert_eq!(pwm.next_event(), None);
    pwm.write(CC, Write::plain(0), 7_000);
    pwm.advance(12_499);
    assert_eq!(pwm.output(0).duty(), 0.5);
    pwm.advance(12_500);
    assert_eq!(pwm.output(0).duty(), 0.0);
}

#[test]
fn pins_of_the_upper_half_repeat_those_of_the_lower() {
    let mut pwm = running();
    pwm.write(CC, Write::plain(6_250), 0);
    pwm.advance(6_250);
    assert_eq!(pwm.output(16).duty(), 1.0);
    assert_eq!(pwm.output(2).duty(), 0.0);
}

#[test]
fn outputs_can_be_inverted_and_the_period_doubled() {
    let mut pwm = running();
    pwm.write(CC, Write::plain(625), 0);
    pwm.write(CSR, Write::plain(csr::EN | csr::A_INV | csr::PH_CORRECT), 0);
    assert_eq!(pwm.next_event(), Some(12_500));
    pwm.advance(12_500);
    assert_eq!(pwm.output(0).duty(), 0.9);
    assert_eq!(pwm.read(CTR, 12_500 + 6_249), 6_249);
    assert_eq!(pwm.read(CTR, 12_500 + 6_260), 6_239);
}

#[test]
fn the_divider_slows_the_counter() {
    let mut pwm = running();
    pwm.write(DIV, Write::plain(2 << 4 | 8), 0);
    assert_eq!(pwm.read(CTR, 1_000), 400);
}

#[test]
fn a_divider_below_one_stands_for_256_and_more() {
    for (div, cycles) in [(0, 256 * 16), (8, 256 * 16 + 8)] {
        let mut pwm = running();
        pwm.write(DIV, Write::plain(div), 0);
        assert_eq!(pwm.read(CTR, cycles - 1), 15);
        assert_eq!(pwm.read(CTR, cycles), 16);
    }
}

#[test]
fn a_slice_that_stands_takes_values_at_once_and_keeps_its_level() {
    let mut pwm = Pwm::new();
    pwm.write(CC, Write::plain(5), 0);
    assert_eq!(pwm.output(0).duty(), 1.0, "0 is below 5");
    pwm.write(CTR, Write::plain(5), 0);
    assert_eq!(pwm.output(0).duty(), 0.0);
    assert_eq!(pwm.read(CTR, 1_000_000), 5);
}

#[test]
fn wraps_interrupt_if_asked_to() {
    let mut pwm = running();
    pwm.advance(10_000);
    assert_eq!(pwm.read(INTR, 10_000), 1);
    assert!(!pwm.interrupt());
    pwm.write(INTR, Write::plain(1), 10_000);
    pwm.write(INTE, Write::plain(1), 10_000);
    assert_eq!(pwm.next_event(), Some(12_500));
    pwm.advance(12_500);
    assert!(pwm.interrupt());
    assert_eq!(pwm.next_event(), None, "it stands already");
    pwm.write(INTR, Write::plain(1), 12_600);
    assert!(!pwm.interrupt());
    pwm.write(INTF, Write::plain(4), 12_600);
    assert!(pwm.interrupt() && pwm.read(INTS, 12_600) == 4);
}

#[test]
fn wraps_ask_for_dma_if_a_channel_waits() {
    let mut pwm = running();
    pwm.advance(10_000);
    assert_eq!(pwm.take_wraps(), 0, "nothing waitsed");
    pwm.await_wraps(0b11);
    assert_eq!(pwm.next_event(), Some(12_500));
    pwm.advance(12_500);
    assert_eq!(pwm.next_event(), Some(18_750));
    assert_eq!((pwm.take_wraps(), pwm.take_wraps()), (1, 0));
    pwm.advance(18_750);
    pwm.await_wraps(0);
    assert_eq!(pwm.take_wraps(), 0, "nothing waits any more");
    assert_eq!(pwm.next_event(), None);
}

#[test]
fn slices_are_enabled_together_and_advanced_by_single_counts() {
    let mut pwm = Pwm::new();
    pwm.write(EN, Write::plain(0b101), 0);
    assert_eq!(pwm.read(2 * STRIDE + CSR, 0), 1);
    assert_eq!(pwm.read(EN, 0), 0b101);
    pwm.write(CSR, Write::plain(csr::EN | csr::PH_ADV), 10);
    assert_eq!(pwm.read(CSR, 10), 1);
    assert_eq!(pwm.read(CTR, 10), 11);
    assert_eq!(pwm.read(2 * STRIDE + CTR, 10), 10);
}

proptest! {
    #[test]
    fn looking_often_or_seldom_makes_no_difference(
        top in 0u32..2_000, div in 0u32..0x200, compare: u32, phase_correct: bool,
        looks in prop::collection::vec(1u64..100_000, 1..20),
    ) {
        let mut often = Pwm::new();
        often.write(TOP, Write::plain(top), 0);
        often.write(DIV, Write::plain(div), 0);
        let mode = if phase_correct { csr::PH_CORRECT } else { 0 };
        often.write(CSR, Write::plain(csr::EN | mode), 0);
        often.write(CC, Write::plain(compare), 0);
        let mut seldom = often.clone();
        let end: u64 = looks.iter().sum();
        let mut now = 0;
        for look in looks {
            now += look;
            often.advance(now);
        }
        seldom.advance(end);
        prop_assert_eq!(often.read(CTR, end), seldom.read(CTR, end));
        prop_assert_eq!(often.output(0), seldom.output(0));
        prop_assert!(often.output(0).high <= often.output(0).period);
    }
}
