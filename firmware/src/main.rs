//! Turing Rover's firmware: moves samples in and commands out.
//!
//! What to do with them is decided in `rover_shared`, which runs on the host just as well. Here is
//! one file a task, all on one executor, and one interrupt that watches them:
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
mod link;
mod sense;
mod store;
mod usb;

use core::cell::RefCell;

#[cfg(feature = "defmt")]
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_rp::clocks::RoscRng;
use embassy_rp::watchdog::Watchdog;
use embassy_time::Duration;
use rover_shared::knowledge::Knowledge;
use rover_shared::learning::paper_rule::MotorWeights;
use rover_shared::motion::Motion;
use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::random::condensed;
use rover_shared::rover::{Rover, Staging};
use static_cell::{ConstStaticCell, StaticCell};

use board::Board;
use store::Store;

/// The tables that the compiler made of the paper's parameters.
static COEFFICIENTS: Coefficients = match Coefficients::new(&Parameters::ROVER) {
    Ok(coefficients) => coefficients,
    Err(_) => panic!("the rover's parameters are wrong: the build fails"),
};

/// The chassis at rest.
const MOTION: Motion = match Motion::new(board::CHASSIS) {
    Ok(motion) => motion,
    Err(_) => panic!("the chassis's parameters are wrong: the build fails"),
};

/// How long reading the flash and checking a full pattern vector may take, before the guard feeds
/// the watchdog: some 0.2 s.
const START_UP: Duration = Duration::from_secs(2);

/// Bytes of the oscillator's noise that make a seed.
const NOISE: usize = 512;

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let board = Board::new(embassy_rp::init(Default::default()));
    let mut watchdog = Watchdog::new(board.watchdog);
    let (reset, last_words) = fault::reset_reason(&watchdog);
    log!("started, reason {}", reset as u8);
    watchdog.pause_on_debug(true);
    watchdog.start(START_UP);

    let mut store = Store::new(board.flash);
    let flash = store.unique_id();
    let rover = rover();
    store.load(&mut rover.borrow_mut());
    guard::start(reset, watchdog);
    rover.borrow().announce(&mut guard::Watch);

    // A task cannot be spawned only if it runs already.
    if let Ok(task) = sense::sense(board.ranges, board.compass, rover) {
        spawner.spawn(task);
    }
    if let Ok(task) = control::control(rover, board.led) {
        spawner.spawn(task);
    }
    if let Ok(task) = drive::drive(board.motors) {
        spawner.spawn(task);
    }
    if let Ok(task) = link::link(usb::device(board.usb, flash), rover, last_words) {
        spawner.spawn(task);
    }
    if let Ok(task) = store::store(store, rover) {
        spawner.spawn(task);
    }
}

/// The rover, with untrained knowledge and a seed from the oscillator's noise.
fn rover() -> &'static RefCell<Rover<'static>> {
    // Zeros, which take no room in the flash.
    static KNOWLEDGE: ConstStaticCell<Knowledge<MotorWeights>> =
        ConstStaticCell::new(Knowledge::EMPTY);
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
