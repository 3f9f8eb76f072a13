//! Turing Rover's firmware: passes samples in and commands out.
//!
//! What to do with them is decided in `rover_shared`, which also runs on the host. Here is one file for
//! each task, all on one executor, and one interrupt that supervises them:
//!
//! ```text
//!  sense ──observation──► control ──wheel command──► drive ──► PWM, if the supervisor's gate allows
//!    ADC, compass            │ Rover::step                       ▲
//!                            ▼                                   │ 0
//!  store ◄────────────── the rover ◄──commands── link          guard, every 10 ms
//!    flash                    └───────reports──► USB             └─► watchdog
//! ```
#![no_std]
#![no_main]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::undocumented_unsafe_blocks,
    clippy::unreachable,
    clippy::todo
)]

/// A line over RTT, for a probe; nothing without feature `defmt`.
macro_rules! log {
    ($($line:tt)*) => {
        #[cfg(feature = "defmt")]
        defmt::info!($($line)*);
    };
}

mod board;
mod control;
mod drive;
mod fault;
mod guard;
mod info;
mod link;
mod motors;
mod reports;
mod sense;
mod store;
mod usb;

use core::cell::RefCell;

#[cfg(feature = "defmt")]
use defmt_rtt as _;
use embassy_executor::{SpawnError, SpawnToken, Spawner};
use embassy_rp::clocks::RoscRng;
use embassy_rp::watchdog::Watchdog;
use embassy_time::Duration;
use rover_shared::motion::Motion;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::random::condensed;
use rover_shared::rover::{Rover, RoverKnowledge, Staging};
use static_cell::{ConstStaticCell, StaticCell};

use board::Parts;
use motors::Motors;
use store::Store;

/// The tables, which the compiler computes from the rover's parameters.
static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are wrong: the build fails"),
};

/// The chassis at rest.
const MOTION: Motion = match Motion::new(board::CHASSIS) {
    Ok(motion) => motion,
    Err(_) => panic!("the chassis's parameters are wrong: the build fails"),
};

/// The watchdog's time until the guard feeds it: reading the flash and checking a full pattern vector
/// takes some 0.2 s.
const START_UP: Duration = Duration::from_secs(2);

/// Bytes of the oscillator's noise that are condensed into a seed.
const NOISE: usize = 512;

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let parts = Parts::new(embassy_rp::init(Default::default()));
    let motors = Motors::new(parts.motors);
    let mut watchdog = Watchdog::new(parts.watchdog);
    let (reset, last_words) = fault::reset_reason(&watchdog);
    log!("started, reason {}", reset as u8);
    watchdog.pause_on_debug(true);
    watchdog.start(START_UP);

    let mut store = Store::new(parts.flash);
    let flash = store.unique_id();
    let rover = rover();
    store.load(&mut rover.borrow_mut());
    guard::start(reset, watchdog);
    rover.borrow().announce(&mut guard::Watch);

    let usb = usb::device(parts.usb, flash);
    spawn(
        spawner,
        "sense",
        sense::sense(parts.ranges, parts.compass, rover),
    );
    spawn(spawner, "control", control::control(rover, parts.led));
    spawn(spawner, "drive", drive::drive(motors));
    spawn(spawner, "link", link::link(usb, rover, last_words));
    spawn(spawner, "store", store::store(store, rover));
}

/// Spawns a task. One that cannot be spawned, because it runs already, ends the run.
fn spawn<S>(spawner: Spawner, name: &str, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(task) => spawner.spawn(task),
        Err(_) => fault::not_spawned(name),
    }
}

/// The rover, with untrained knowledge and a seed from the oscillator's noise.
fn rover() -> &'static RefCell<Rover<'static>> {
    // All zeros, so they take no room in the flash.
    static KNOWLEDGE: ConstStaticCell<RoverKnowledge> = ConstStaticCell::new(RoverKnowledge::EMPTY);
    static STAGING: ConstStaticCell<Staging> = ConstStaticCell::new(Staging::EMPTY);
    static ROVER: StaticCell<RefCell<Rover<'static>>> = StaticCell::new();
    let seed = condensed((0..NOISE).map(|_| RoscRng::next_u8()));
    ROVER.init(RefCell::new(Rover::new(
        &COEFFICIENTS,
        KNOWLEDGE.take(),
        STAGING.take(),
        (board::CURVE, MOTION),
        board::IDENTITY,
        seed,
    )))
}
