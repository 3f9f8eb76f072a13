//! The emulated rovers of all commands that can have one instead of a real one.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use emulated_rp2040::elf::Image;
use rover_emulator::Emulation;
use rover_emulator::vehicle::{Schedule, ScheduledFault};
use rover_log::arena_file;
use rover_log::recorder::Truth;
use rover_shared::time::{Duration, Instant};
use rover_simulator::arena::{Pose, Scenario};
use rover_simulator::experiment::{Stream, generator};

use super::output::Failure;

/// Where `cargo fw` puts the firmware.
pub const FIRMWARE: &str = "target/thumbv6m-none-eabi/firmware/rover-firmware";

/// How long an emulated rover's sensors take to pass their checks; until then arming is refused.
pub const SETTLING: Duration = Duration::from_millis(1_000);

/// The firmware, read.
pub fn read_firmware(path: &Path) -> Result<Image, Failure> {
    let fail = |what: &dyn std::fmt::Display| {
        let hint = "`cargo fw` builds the firmware, --elf FILE names another";
        Failure::of(path.display(), format_args!("{what}; {hint}"))
    };
    let bytes = std::fs::read(path).map_err(|error| fail(&format!("cannot be read: {error}")))?;
    Image::parse(&bytes).map_err(|error| fail(&error))
}

/// An emulated rover with this firmware in an arena.
pub fn rover_in(
    image: &Image,
    arena: &str,
    faults: &[ScheduledFault],
    seed: u64,
) -> Result<Emulation, Failure> {
    let arenas = arena_file::load(arena)?;
    let scenario = arenas.scenario(&mut generator(seed, Stream::Learning));
    let faults = Schedule::new(faults.to_vec());
    Ok(Emulation::new(image, &scenario, faults, seed)?)
}

/// What an emulation knows of its rover, for a recorder.
pub fn truth(rover: &Rc<RefCell<Emulation>>) -> Box<dyn Truth> {
    Box::new(Shared(Rc::clone(rover)))
}

struct Shared(Rc<RefCell<Emulation>>);

impl Truth for Shared {
    fn scenario(&self) -> Scenario {
        self.0.borrow().scenario().clone()
    }

    fn pose_at(&self, rover_time: Instant) -> Option<Pose> {
        self.0.borrow().pose_at(rover_time)
    }
}
