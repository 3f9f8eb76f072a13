//! `rover uf2`: the firmware as a file that is dropped onto the board's USB drive.
//!
//! It writes nothing into the sectors of the storage, and so the rover keeps its knowledge.

use std::path::{Path, PathBuf};

use super::output::{Failure, print};
use emulated_rp2040::elf::Image;
use emulated_rp2040::uf2::{BLOCK, blocks};
use rover_log::files::write_whole;

#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The linked firmware
    #[arg(
        long,
        value_name = "FILE",
        default_value = "target/thumbv6m-none-eabi/firmware/rover-firmware"
    )]
    elf: PathBuf,
    /// Where to write it [default: beside the firmware, with the ending .uf2]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let elf = &arguments.elf;
    let fail = |what: String| Failure::Failed(format!("{}: {what}", elf.display()));
    let bytes = std::fs::read(elf).map_err(|error| {
        fail(format!(
            "cannot be read: {error}; build the firmware with `cargo fw`"
        ))
    })?;
    let image = Image::parse(&bytes).map_err(|error| fail(error.to_string()))?;
    let blocks = blocks(&image).map_err(|error| fail(error.to_string()))?;
    let beside = || Path::new(elf).with_extension("uf2");
    let out = arguments.out.clone().unwrap_or_else(beside);
    write_whole(&out, &blocks)?;
    print(&format!(
        "{}: {} pages of flash\n",
        out.display(),
        blocks.len() / BLOCK
    ))
}
