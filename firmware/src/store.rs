//! Keeps knowledge and calibrations in the flash.
//!
//! While the flash is erased or programmed no instruction can be fetched from it: the whole program
//! is paused, for 0.4 ms a page and 45 ms (400 at worst) a sector, with interrupts masked. So this is
//! done only when disarmed, which the supervisor enforces, and one operation at a time: all loops run
//! between two.

use core::cell::RefCell;

use embassy_rp::Peri;
use embassy_rp::flash::{Blocking, ERASE_SIZE, Error};
use embassy_rp::peripherals::FLASH;
use embassy_time::{Duration, Timer};
use rover_shared::calibration;
use rover_shared::rover::{MOST_BYTES, Rover, Save};
use rover_shared::storage::{Content, Flash, PAGE, Progress, SECTOR, Slots, WriteError};
use rover_shared::supervisor::{Input, Loop};
use rover_shared::wire::usb::SERIAL_DIGITS;

use crate::board::BOARD;
use crate::guard::Watch;
use crate::{guard, reports};

const _: () = assert!(SECTOR as usize == ERASE_SIZE, "both know the same flash");

/// Sectors of a slot of calibrations.
const CALIBRATION_SECTORS: u32 = 1;
/// Sectors of a slot of knowledge: a full pattern vector, its header's page, and some room to grow.
const KNOWLEDGE_SECTORS: u32 = 12;
const _: () = assert!(
    MOST_BYTES + PAGE <= (KNOWLEDGE_SECTORS * SECTOR) as usize
        && calibration::MOST_BYTES + PAGE <= (CALIBRATION_SECTORS * SECTOR) as usize,
    "slots have room for the longest content"
);

/// How often to check whether something is to be saved.
const PERIOD: Duration = Duration::from_millis(100);
/// Time for the loops between two operations.
const TURN: Duration = Duration::from_millis(3);

// SAFETY: both are defined in `memory.x`, and taking their addresses reads nothing.
unsafe extern "C" {
    /// Symbols of `memory.x`; only their addresses have a meaning.
    safe static __storage_start: u8;
    safe static __storage_end: u8;
}

/// The flash and its contents.
pub struct Store {
    nor: Nor,
    calibrations: Slots,
    knowledge: Slots,
}

impl Store {
    /// The region that `memory.x` sets aside.
    pub fn new(flash: Peri<'static, FLASH>) -> Self {
        let start = &raw const __storage_start as u32;
        let second = start + 2 * CALIBRATION_SECTORS * SECTOR;
        let end = &raw const __storage_end as u32;
        debug_assert!(second + 2 * KNOWLEDGE_SECTORS * SECTOR <= end);
        Self {
            nor: Nor(embassy_rp::flash::Flash::new_blocking(flash)),
            calibrations: Slots::new(start, CALIBRATION_SECTORS),
            knowledge: Slots::new(second, KNOWLEDGE_SECTORS),
        }
    }

    /// Returns the flash's unique number. To be called before anything runs: the flash cannot be read
    /// meanwhile, so the program is paused as for a write.
    pub fn unique_id(&mut self) -> Option<[u8; SERIAL_DIGITS / 2]> {
        let mut number = [0; SERIAL_DIGITS / 2];
        self.nor.0.blocking_unique_id(&mut number).ok()?;
        Some(number)
    }

    /// Restores the rover's calibrations and knowledge.
    pub fn load(&mut self, rover: &mut Rover) {
        let Self {
            nor,
            calibrations,
            knowledge,
        } = self;
        let mut buffer = [0; calibration::MOST_BYTES];
        if calibrations.open(nor).is_ok()
            && let Ok(Some(bytes)) = calibrations.read(nor, &mut buffer)
        {
            rover.restore_calibrations(bytes);
        }
        if knowledge.open(nor) == Ok(Content::Blank) {
            // A new board.
            rover.begin();
        } else {
            // Unusable knowledge is refused, and so is arming, until there is other knowledge.
            let _ = rover.load(|room| {
                let read = knowledge.read(nor, room).ok().flatten();
                read.map(<[u8]>::len)
            });
        }
    }

    /// Writes what is to be saved, one operation at a time; returns its fingerprint.
    async fn write(
        &mut self,
        save: Save,
        rover: &RefCell<Rover<'static>>,
    ) -> Result<u32, WriteError<Error>> {
        let mut buffer = [0; calibration::MOST_BYTES];
        let calibrations = match save {
            Save::Calibrations => rover.borrow().calibrations().encode(&mut buffer),
            Save::Knowledge => &[],
        };
        let slots = match save {
            Save::Calibrations => &mut self.calibrations,
            Save::Knowledge => &mut self.knowledge,
        };
        let mut write = None;
        loop {
            let progress = {
                let rover = rover.borrow();
                let content = match save {
                    Save::Calibrations => calibrations,
                    Save::Knowledge => rover.knowledge_bytes(),
                };
                match &mut write {
                    None => {
                        write = Some(slots.write(content)?);
                        Progress::UnderWay
                    }
                    Some(write) => write.step(&mut self.nor, content)?,
                }
            };
            guard::tell(Input::Alive(Loop::Store));
            if let Progress::Done(record) = progress {
                slots.written(record);
                return Ok(record.fingerprint());
            }
            Timer::after(TURN).await;
        }
    }
}

/// Saves what is to be saved; never returns.
#[embassy_executor::task]
pub async fn store(mut store: Store, rover: &'static RefCell<Rover<'static>>) -> ! {
    loop {
        Timer::after(PERIOD).await;
        guard::tell(Input::Alive(Loop::Store));
        let Some(save) = rover.borrow_mut().take_save(&mut Watch) else {
            continue;
        };
        let written = store.write(save, rover).await.ok();
        log!("stored: {}", written);
        let report = rover.borrow_mut().saved(guard::now(), written, &mut Watch);
        if let Some(report) = report
            && rover.borrow().talks()
        {
            reports::report(report);
        }
    }
}

/// The board's flash.
struct Nor(embassy_rp::flash::Flash<'static, FLASH, Blocking, { BOARD.flash_bytes }>);

impl Flash for Nor {
    type Error = Error;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), Error> {
        self.0.blocking_read(offset, into)
    }

    fn erase(&mut self, offset: u32) -> Result<(), Error> {
        self.0.blocking_erase(offset, offset + SECTOR)
    }

    fn program(&mut self, offset: u32, page: &[u8; PAGE]) -> Result<(), Error> {
        self.0.blocking_write(offset, page)
    }
}
