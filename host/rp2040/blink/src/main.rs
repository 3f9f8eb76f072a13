//! Blinks the LED of a Raspberry Pi Pico (GPIO 25) and writes a line for each change over RTT. A
//! button between GPIO 15 and ground switches between slow and fast.

#![no_std]
#![no_main]

use core::panic::PanicInfo;

use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_time::{Duration, Ticker};
use rtt_target::{rprintln, rtt_init_print};

const SLOW_MS: u64 = 250;
const FAST_MS: u64 = 50;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    rtt_init_print!();
    let pins = embassy_rp::init(embassy_rp::config::Config::default());
    let mut led = Output::new(pins.PIN_25, Level::Low);
    let mut button = Input::new(pins.PIN_15, Pull::Up);
    let mut period = SLOW_MS;
    let mut ticker = Ticker::every(Duration::from_millis(period));
    loop {
        match select(ticker.next(), button.wait_for_falling_edge()).await {
            Either::First(()) => {
                led.toggle();
                rprintln!("LED {}", if led.is_set_high() { "on" } else { "off" });
            }
            Either::Second(()) => {
                period = SLOW_MS + FAST_MS - period;
                ticker = Ticker::every(Duration::from_millis(period));
                rprintln!("every {} ms", period);
            }
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    rprintln!("panicked");
    loop {}
}
