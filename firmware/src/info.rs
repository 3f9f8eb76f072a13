//! The image's "binary info" (Pico SDK, `pico/binary_info`): what `picotool info` shows of a file or
//! a board, and where the emulator reads which board an image is for. `memory.x` places the sections.
#![expect(
    clippy::indexing_slicing,
    reason = "all of it is evaluated by the compiler: a wrong index does not compile"
)]

use core::ffi::c_char;

use embassy_rp::binary_info::consts::TAG_RASPBERRY_PI;
use embassy_rp::binary_info::{self, DataType, EntryAddr};

use crate::board::BOARD;

// SAFETY: `memory.x` gathers this section into the table of entries, which holds addresses of entries
// and nothing else.
#[unsafe(link_section = ".bi_entries")]
#[used]
static ENTRIES: [EntryAddr; 3] = [
    binary_info::rp_program_name!(c"rover-firmware"),
    binary_info::rp_cargo_version!(),
    binary_info::rp_pico_board!(BOARD.name),
];

/// The name of a pin's signal (`binary_info_pins_with_name_t`).
#[derive(Clone, Copy)]
#[repr(C)]
struct PinName {
    /// `BINARY_INFO_TYPE_PINS_WITH_NAME`.
    kind: u16,
    tag: u16,
    /// A bit for each pin; none for a signal that the board does not have.
    pins: u32,
    name: *const c_char,
}

const SIGNALS: usize = BOARD.signals().len();

#[repr(transparent)]
struct PinNames([PinName; SIGNALS]);

#[repr(transparent)]
struct PinEntries([*const PinName; SIGNALS]);

// SAFETY: it points to constants only.
unsafe impl Sync for PinNames {}
// SAFETY: as above.
unsafe impl Sync for PinEntries {}

static PIN_NAMES: PinNames = {
    let mut names = [PinName {
        kind: DataType::PinsWithName as u16,
        tag: TAG_RASPBERRY_PI,
        pins: 0,
        name: c"".as_ptr(),
    }; SIGNALS];
    let mut i = 0;
    while i < SIGNALS {
        let (name, pin) = BOARD.signals()[i];
        names[i].name = name.as_ptr();
        if let Some(pin) = pin {
            names[i].pins = 1 << pin;
        }
        i += 1;
    }
    PinNames(names)
};

// SAFETY: as for `ENTRIES`.
#[unsafe(link_section = ".bi_entries")]
#[used]
static PIN_ENTRIES: PinEntries = {
    let mut entries = [&raw const PIN_NAMES.0[0]; SIGNALS];
    let mut i = 1;
    while i < SIGNALS {
        entries[i] = &raw const PIN_NAMES.0[i];
        i += 1;
    }
    PinEntries(entries)
};
