//! How fast the emulated board is: emulated time over wall-clock time.
//!
//! `cargo bench --bench emulation`; on a machine that does other things as well, with
//! `taskset -c 0` in front. The best of several rounds counts: whatever else runs only slows it down.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use emulated_rp2040::elf::Image;
use rover_emulator::vehicle::Schedule;
use rover_emulator::{EmulatedPort, Emulation};
use rover_link::Client;
use rover_shared::contract::{Mode, Task};
use rover_shared::time::Duration;
use rover_shared::wire::message::{Command, Report};
use rover_simulator::arena::ArenaSource;
use rover_simulator::experiment::{Stream, generator};

#[path = "../../../tests/support/thumb.rs"]
mod thumb;

const ROUNDS: usize = 7;
const ROUND: Duration = Duration::from_millis(20_000);
/// What `rover emulate` does unless it is told otherwise.
const ACTIONS: u32 = 500;
const SEED: u64 = 1;

/// A rover that has just been switched on; what is wrong with it, if anything.
fn rover(image: &Image, faults: &[&str]) -> Rc<RefCell<Emulation>> {
    let arenas = ArenaSource::named("rover-5m").expect("an arena that is known");
    let scenario = arenas.scenario(&mut generator(SEED, Stream::Learning));
    let faults = faults.iter().map(|fault| fault.parse().expect(fault));
    let faults = Schedule::new(faults.collect::<Vec<_>>());
    let rover = Emulation::new(image, &scenario, faults, SEED);
    Rc::new(RefCell::new(
        rover.expect("the firmware fits into the flash"),
    ))
}

/// A host that has introduced itself.
fn host(rover: &Rc<RefCell<Emulation>>) -> Client {
    let port = EmulatedPort::open(Rc::clone(rover)).expect("the board appears");
    let mut client = Client::open(Box::new(port)).expect("the rover answers");
    client.wait(Duration::from_millis(1_000)).expect("it stays");
    client
}

fn learn(client: &mut Client) {
    for command in [
        Command::SetTask(Task::FollowChangingDirection),
        Command::SetSeed(SEED),
        Command::Arm,
        Command::SetMode(Mode::Learn),
    ] {
        client.ask(&command).expect("it is obeyed");
    }
}

/// Prints how many times faster than real time rounds of waiting are.
fn measure(what: &str, mut wait: impl FnMut(Duration)) {
    let emulated = ROUND.0 as f64 / 1e6;
    let mut speeds: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let began = Instant::now();
            wait(ROUND);
            emulated / began.elapsed().as_secs_f64()
        })
        .collect();
    speeds.sort_by(f64::total_cmp);
    println!(
        "{what:<44} {:>5.0} times real time at best, {:.0} in the middle",
        speeds[ROUNDS - 1],
        speeds[ROUNDS / 2]
    );
}

fn idle(image: &Image) {
    let unplugged = rover(image, &["0:usb-unplugged"]);
    unplugged.borrow_mut().run(Duration::from_millis(2_000));
    measure("idle, cable unplugged", |span| {
        unplugged.borrow_mut().run(span)
    });
    let plugged = rover(image, &[]);
    plugged.borrow_mut().run(Duration::from_millis(2_000));
    measure("idle, cable plugged in, port closed", |span| {
        plugged.borrow_mut().run(span)
    });
    let mut client = host(&rover(image, &[]));
    measure("idle, host listens", |span| {
        client.wait(span).expect("it stays")
    });
}

/// Hears what the rover says for a while, or until it has done so many actions; gives how many.
fn listen(client: &mut Client, span: Duration, most: u32) -> u32 {
    let until = client.now().after(span);
    let mut actions = 0;
    while client.now() < until && actions < most {
        let left = until.since(client.now());
        if let Some(received) = client.next(left).expect("it stays") {
            actions += u32::from(matches!(received.report, Report::Action(_)));
        }
    }
    actions
}

fn driving(image: &Image) {
    let mut client = host(&rover(image, &[]));
    learn(&mut client);
    measure("learning, host listens", |span| {
        listen(&mut client, span, u32::MAX);
    });
    let whole = (0..3).map(|_| {
        let began = Instant::now();
        let rover = rover(image, &[]);
        let mut client = host(&rover);
        learn(&mut client);
        let hour = Duration::from_millis(3_600_000);
        assert_eq!(listen(&mut client, hour, ACTIONS), ACTIONS);
        let emulated = rover.borrow().now().0 as f64 / 1e6;
        (began.elapsed().as_secs_f64(), emulated)
    });
    let (wall, emulated) = whole
        .min_by(|one, two| one.0.total_cmp(&two.0))
        .expect("rounds");
    println!("{ACTIONS} actions from power-up, {emulated:.0} s: {wall:.2} s at best");
}

fn main() {
    let file = std::fs::read(thumb::build("rover-firmware", "firmware", ""));
    let image = Image::parse(&file.expect("the firmware was built"));
    let image = image.expect("the firmware is an ELF file");
    idle(&image);
    driving(&image);
}
