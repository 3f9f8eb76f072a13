//! `rover uf2`: the firmware as a file that is dropped onto the board's USB drive.
//!
//! UF2 (<https://github.com/microsoft/uf2>) is a row of blocks of 512 bytes, each of which can be
//! written by itself, in any order:
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 4 | magic `UF2\n` |
//! | 4 | 4 | magic 0x9E5D5157 |
//! | 8 | 4 | flags: 0x2000, a family stands at 28 |
//! | 12 | 4 | address in the flash |
//! | 16 | 4 | bytes of it: 256, a page |
//! | 20 | 4 | number of this block, from 0 |
//! | 24 | 4 | number of blocks |
//! | 28 | 4 | family: 0xE48BFF56, the RP2040 |
//! | 32 | 476 | the page, and zeros |
//! | 508 | 4 | magic 0x0AB16F30 |
//!
//! All little-endian. The RP2040's boot ROM erases each sector of 4 KB when a page of it comes for
//! the first time, and restarts the board after the last block. Sectors of which no page comes
//! keep what is in them, and so the rover keeps its knowledge.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::output::{Failure, print};
use emulated_rp2040::elf::Image;
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
    let blocks = blocks(&image).map_err(fail)?;
    let beside = || Path::new(elf).with_extension("uf2");
    let out = arguments.out.clone().unwrap_or_else(beside);
    write_whole(&out, &blocks)?;
    print(&format!(
        "{}: {} pages of flash\n",
        out.display(),
        blocks.len() / BLOCK
    ))
}

const BLOCK: usize = 512;
const PAGE: usize = 256;
const FAMILY: u32 = 0xE48B_FF56;
/// Where the flash is seen: 16 MB are the most that the chip can address.
const FLASH: std::ops::Range<u32> = 0x1000_0000..0x1100_0000;

/// All pages that the program touches, as blocks.
fn blocks(image: &Image) -> Result<Vec<u8>, String> {
    let pages = pages(image)?;
    let number = pages.len() as u32;
    let mut file = Vec::with_capacity(pages.len() * BLOCK);
    for (i, (address, page)) in (0..).zip(&pages) {
        let header: [u32; 8] = [
            u32::from_le_bytes(*b"UF2\n"),
            0x9E5D_5157,
            0x2000,
            *address,
            PAGE as u32,
            i,
            number,
            FAMILY,
        ];
        file.extend(header.map(u32::to_le_bytes).concat());
        file.extend(page);
        file.resize((i as usize + 1) * BLOCK - 4, 0);
        file.extend(0x0AB1_6F30_u32.to_le_bytes());
    }
    Ok(file)
}

fn pages(image: &Image) -> Result<BTreeMap<u32, [u8; PAGE]>, String> {
    let mut pages = BTreeMap::new();
    for segment in &image.segments {
        let end = u64::from(segment.address) + segment.bytes.len() as u64;
        if !FLASH.contains(&segment.address) || end > u64::from(FLASH.end) {
            return Err(format!(
                "has contents for {:#010x}, outside the flash: linked without memory.x?",
                segment.address
            ));
        }
        for (address, byte) in (segment.address..).zip(&segment.bytes) {
            let within = address as usize % PAGE;
            // Bytes that nobody gives stay erased.
            let page = pages.entry(address - within as u32).or_insert([0xFF; PAGE]);
            page[within] = *byte;
        }
    }
    if pages.is_empty() {
        return Err("has no contents".into());
    }
    Ok(pages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use emulated_rp2040::elf::Segment;

    fn image(segments: &[(u32, &[u8])]) -> Image {
        let segment = |(address, bytes): &(u32, &[u8])| Segment {
            address: *address,
            bytes: bytes.to_vec(),
        };
        let mut image = Image::default();
        image.segments = segments.iter().map(segment).collect();
        image
    }

    fn word(block: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(block[at..at + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn every_byte_stands_in_the_page_of_its_address() {
        let long: Vec<u8> = (0..=255).chain(0..44).collect();
        let file = blocks(&image(&[(0x1000_01FE, &long), (0x1000_0000, b"boot")])).unwrap();
        // boot, and 300 bytes that begin two bytes before the end of a page.
        assert_eq!(file.len(), 4 * BLOCK);
        let addresses = [0x1000_0000, 0x1000_0100, 0x1000_0200, 0x1000_0300];
        for ((i, block), address) in file.chunks(BLOCK).enumerate().zip(addresses) {
            assert_eq!(&block[..4], b"UF2\n");
            assert_eq!(
                (word(block, 4), word(block, 508)),
                (0x9E5D_5157, 0x0AB1_6F30)
            );
            assert_eq!((word(block, 8), word(block, 28)), (0x2000, FAMILY));
            assert_eq!((word(block, 12), word(block, 16)), (address, 256));
            assert_eq!((word(block, 20), word(block, 24)), (i as u32, 4));
            assert!(block[288..508].iter().all(|byte| *byte == 0));
        }
        let page = |i: usize| &file[i * BLOCK + 32..][..PAGE];
        assert_eq!(&page(0)[..5], b"boot\xFF");
        assert_eq!(page(1)[253..], [0xFF, 0, 1]);
        assert_eq!((page(2)[0], page(2)[255]), (2, 1));
        assert_eq!(page(3)[41..44], [43, 0xFF, 0xFF]);
    }

    #[test]
    fn what_is_not_for_the_flash_is_refused() {
        for address in [0x2000_0000, 0x0FFF_FFFF, 0x10FF_FFFE] {
            let error = blocks(&image(&[(address, b"four")])).unwrap_err();
            assert!(error.contains("outside the flash"), "{error}");
        }
        assert!(blocks(&image(&[])).is_err());
    }
}
