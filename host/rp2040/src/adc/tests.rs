use super::*;
use crate::peripheral::Alias;

const THRESH_1: u32 = 1 << fcs::THRESH_SHIFT;

/// A converter that is on, with 100, 200, 300, 400 counts on its pins.
fn enabled() -> Adc {
    let mut adc = Adc::new();
    for (channel, counts) in [100, 200, 300, 400].into_iter().enumerate() {
        adc.set_input(channel, counts);
    }
    adc.write(CS, Write::plain(cs::EN), 0);
    adc
}

fn ainsel(channel: u32) -> u32 {
    channel << cs::AINSEL_SHIFT
}

fn rrobin(mask: u32) -> u32 {
    mask << cs::RROBIN_SHIFT
}

fn set(adc: &mut Adc, offset: u32, value: u32, now: Cycles) {
    let alias = Alias::Set;
    adc.write(offset, Write { value, alias }, now);
}

#[test]
fn nothing_is_ready_before_it_is_enabled() {
    let mut adc = Adc::new();
    assert_eq!(adc.read(CS, 0), 0);
    adc.write(CS, Write::plain(cs::START_ONCE), 0);
    assert_eq!(adc.next_event(), None);
    assert_eq!(adc.read(FCS, 0), fcs::EMPTY);
}

#[test]
fn one_conversion_takes_two_microseconds() {
    let mut adc = enabled();
    set(&mut adc, CS, cs::START_ONCE | ainsel(2), 1_000);
    assert_eq!(adc.next_event(), Some(1_250));
    assert_eq!(adc.read(CS, 1_249), cs::EN | ainsel(2));
    assert_eq!(adc.read(CS, 1_250), cs::EN | cs::READY | ainsel(2));
    assert_eq!(adc.read(RESULT, 1_250), 300);
    assert_eq!(adc.next_event(), None);
    assert_eq!(adc.read(FCS, 1_250) >> fcs::LEVEL_SHIFT, 0, "FIFO is off");
}

#[test]
fn paced_conversions_neither_drift_nor_overlap() {
    // (INT, FRAC), and when the thousandth conversion starts in 256ths of the 48 MHz clock
    for (div, period) in [
        (4_799 << 8, 4_800 * 256),
        (0, 96 * 256),
        (50 << 8, 96 * 256),
        (96 << 8 | 0x80, 97 * 256 + 128),
    ] {
        let mut adc = enabled();
        adc.write(DIV, Write::plain(div), 0);
        set(&mut adc, CS, cs::START_MANY, 77);
        let mut ends = Vec::new();
        while ends.len() < 1_000 {
            let due = adc.next_event().expect("it goes on");
            if adc.conversion.is_some() {
                ends.push(due);
            }
            adc.advance(due);
        }
        let exact = 999.0 * period as f64 / 256.0 * 125.0 / 48.0 + 327.0;
        let last = ends[999] as f64;
        assert!((last - exact).abs() <= 4.0, "{div:#x}: {last} {exact}");
        assert!(ends.is_sorted_by(|a, b| b - a >= CONVERSION));
    }
}

#[test]
fn a_write_to_the_divider_starts_its_period_anew() {
    let mut adc = enabled();
    adc.write(DIV, Write::plain(999 << 8), 0);
    set(&mut adc, CS, cs::START_MANY, 0);
    adc.advance(2_000);
    adc.write(DIV, Write::plain(1_999 << 8), 2_000);
    assert_eq!(adc.next_event(), Some(2_000));
    adc.advance(2_250);
    assert_eq!(adc.next_event(), Some(2_000 + 2_000 * 125 / 48 + 1));
}

#[test]
fn the_channels_go_round_from_the_selected_one() {
    let mut adc = enabled();
    set(&mut adc, CS, rrobin(0b1011) | ainsel(1), 0);
    adc.write(FCS, Write::plain(fcs::EN | THRESH_1), 0);
    set(&mut adc, CS, cs::START_MANY, 0);
    for (n, counts) in [200, 400, 100, 200].into_iter().enumerate() {
        assert_eq!(adc.read(FIFO, 250 * (n as Cycles + 1)), counts);
    }
    assert_eq!(adc.read(CS, 1_000) & cs::AINSEL, ainsel(3));
}

#[test]
fn the_temperature_sensor_has_to_be_switched_on() {
    let mut adc = enabled();
    set(&mut adc, CS, ainsel(4) | cs::START_ONCE, 0);
    assert_eq!(adc.read(RESULT, 250), 0);
    set(&mut adc, CS, cs::TS_EN | cs::START_ONCE, 250);
    assert_eq!(adc.read(RESULT, 500), u32::from(ROOM_TEMPERATURE));
}

#[test]
fn the_fifo_overflows_and_underflows() {
    let mut adc = enabled();
    adc.write(FCS, Write::plain(fcs::EN | 4 << fcs::THRESH_SHIFT), 0);
    adc.write(INTE, Write::plain(1), 0);
    set(&mut adc, CS, cs::START_MANY, 0);
    adc.advance(999);
    assert!(!adc.line());
    adc.advance(1_000);
    assert!(adc.line(), "at the threshold");
    let status = fcs::FULL | 4 << fcs::LEVEL_SHIFT;
    assert_eq!(adc.read(FCS, 1_000) & !fcs::STORED, status);
    assert_eq!(adc.read(FCS, 1_250) & !fcs::STORED, status | fcs::OVER);
    adc.write(CS, Write::plain(cs::EN), 1_250);
    for _ in 0..4 {
        assert_eq!(adc.read(FIFO, 1_600), 100);
    }
    assert!(!adc.line());
    assert_eq!(adc.read(FIFO, 1_600), 0);
    let status = fcs::EMPTY | fcs::OVER | fcs::UNDER;
    assert_eq!(adc.read(FCS, 1_600) & !fcs::STORED, status);
    set(&mut adc, FCS, fcs::OVER, 1_600);
    assert_eq!(adc.read(FCS, 1_600) & !fcs::STORED, fcs::EMPTY | fcs::UNDER);
}

#[test]
fn results_are_shifted_to_bytes_and_marked() {
    let mut adc = enabled();
    adc.set_input(0, 0xabc);
    adc.set_failing(true);
    let control = fcs::EN | fcs::SHIFT | fcs::ERR;
    adc.write(FCS, Write::plain(control), 0);
    set(&mut adc, CS, cs::START_ONCE, 0);
    assert_eq!(adc.read(FIFO, 250), 0x80ab);
    assert_eq!(
        adc.read(CS, 250),
        cs::EN | cs::READY | cs::ERR | cs::ERR_STICKY
    );
    adc.set_failing(false);
    set(&mut adc, CS, cs::START_ONCE, 250);
    assert_eq!(adc.read(FIFO, 500), 0xab);
    assert_eq!(adc.read(CS, 500), cs::EN | cs::READY | cs::ERR_STICKY);
    set(&mut adc, CS, cs::ERR_STICKY, 500);
    assert_eq!(adc.read(CS, 500), cs::EN | cs::READY);
}

#[test]
fn dma_is_asked_while_the_threshold_is_reached() {
    let mut adc = enabled();
    adc.write(FCS, Write::plain(fcs::EN | fcs::DREQ_EN | THRESH_1), 0);
    assert!(!adc.dma_request());
    set(&mut adc, CS, cs::START_ONCE, 0);
    adc.advance(250);
    assert!(adc.dma_request());
    adc.read(FIFO, 250);
    assert!(!adc.dma_request());
}

#[test]
fn interrupts_can_be_forced() {
    let mut adc = enabled();
    adc.write(FCS, Write::plain(THRESH_1), 0);
    adc.write(INTF, Write::plain(1), 0);
    assert!(adc.line());
    assert_eq!((adc.read(INTR, 0), adc.read(INTS, 0)), (0, 1));
}

#[test]
fn stopping_lets_the_running_conversion_end() {
    let mut adc = enabled();
    set(&mut adc, CS, cs::START_MANY, 0);
    adc.advance(100);
    let alias = Alias::Clear;
    let value = cs::START_MANY;
    adc.write(CS, Write { value, alias }, 100);
    assert_eq!(adc.next_event(), Some(250));
    adc.advance(250);
    assert_eq!(adc.next_event(), None);
    assert_eq!(adc.read(RESULT, 300), 100);
}

#[test]
fn wide_codes_swallow_their_neighbours() {
    let mut adc = enabled();
    adc.set_wide_codes(true);
    for (counts, result) in [
        (507, 507),
        (508, 512),
        (516, 512),
        (517, 517),
        (3_587, 3_584),
    ] {
        adc.set_input(0, counts);
        set(&mut adc, CS, cs::START_ONCE, 0);
        adc.advance(250);
        assert_eq!(adc.read(RESULT, 250), result);
    }
}

#[test]
fn a_reset_keeps_what_is_connected() {
    let mut adc = enabled();
    adc.write(DIV, Write::plain(0x1234), 0);
    set(&mut adc, CS, cs::START_MANY, 0);
    adc.reset();
    assert_eq!(adc.next_event(), None);
    assert_eq!((adc.read(CS, 9), adc.read(DIV, 9)), (0, 0));
    adc.write(CS, Write::plain(cs::EN | cs::START_ONCE), 10);
    assert_eq!(adc.read(RESULT, 260), 100);
}
