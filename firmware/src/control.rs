//! Lets the rover go on by one control period every 20 ms.

use core::cell::RefCell;

use embassy_time::Ticker;
use rover_shared::contract::State;
use rover_shared::rover::{PERIOD, Rover, Supervision};
use rover_shared::supervisor::{Input, Loop};

use crate::board::Led;
use crate::guard::Watch;
use crate::{drive, guard, link, sense};

/// Periods that the light is on and off when a fault stands: 5 Hz.
const BLINK: u32 = 5;

/// Controls for ever.
#[embassy_executor::task]
pub async fn control(rover: &'static RefCell<Rover<'static>>, mut led: Led) -> ! {
    let mut ticker = Ticker::every(guard::duration(PERIOD));
    let mut periods = 0u32;
    loop {
        ticker.next().await;
        guard::tell(Input::Alive(Loop::Control));
        let seen = sense::latest();
        let command = {
            let mut rover = rover.borrow_mut();
            let talks = rover.talks();
            rover.step(guard::now(), &seen, &mut Watch, &mut |report| {
                if talks {
                    link::report(report);
                }
            })
        };
        drive::COMMAND.signal(command);
        link::tell_drops();
        periods = periods.wrapping_add(1);
        led.set(match Watch.view().state {
            State::Disarmed => false,
            State::Armed | State::Driving(_) => true,
            State::Faulted(_) => (periods / BLINK).is_multiple_of(2),
        });
    }
}
