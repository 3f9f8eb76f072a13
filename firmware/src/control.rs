//! Steps the rover by one control period every 20 ms, and drives the status light.

use core::cell::RefCell;

use embassy_rp::gpio::Output;
use embassy_time::Ticker;
use rover_shared::contract::State;
use rover_shared::rover::{PERIOD, Rover, Supervision};
use rover_shared::supervisor::{Input, Loop};

use crate::guard::Watch;
use crate::{drive, guard, reports, sense};

/// Periods that the light is on, and off, while a fault is active: it blinks at 5 Hz.
const BLINK: u32 = 5;

/// Runs the control loop; never returns.
#[embassy_executor::task]
pub async fn control(
    rover: &'static RefCell<Rover<'static>>,
    mut led: Option<Output<'static>>,
) -> ! {
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
                    reports::report(report);
                }
            })
        };
        drive::COMMAND.signal(command);
        reports::tell_drops();
        periods = periods.wrapping_add(1);
        let lit = match Watch.view().state {
            State::Disarmed => false,
            State::Armed | State::Driving(_) => true,
            State::Faulted(_) => (periods / BLINK).is_multiple_of(2),
        };
        if let Some(led) = &mut led {
            led.set_level(lit.into());
        }
    }
}
