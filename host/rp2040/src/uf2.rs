//! UF2 (<https://github.com/microsoft/uf2>): a program as the file that is dropped onto the boot
//! ROM's USB drive.
//!
//! It is a row of blocks of 512 bytes, each of which can be written by itself, in any order:
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
//! the first time, and restarts the chip after the last block. Sectors of which no page comes keep
//! what is in them.

use std::collections::BTreeMap;

use super::elf::Image;

/// Bytes of a block.
pub const BLOCK: usize = 512;
const PAGE: usize = 256;
const FAMILY: u32 = 0xE48B_FF56;
/// Where the flash is mapped: 16 MB are the most that the chip can address.
const FLASH: std::ops::Range<u32> = 0x1000_0000..0x1100_0000;

/// Why a program cannot be put into a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Uf2Error {
    /// Something in it does not go into the flash.
    #[error("has contents for {address:#010x}, outside the flash: linked without memory.x?")]
    OutsideFlash {
        /// Where it should go.
        address: u32,
    },
    /// There is nothing in it.
    #[error("has no contents")]
    Empty,
}

/// All pages that the program touches, as blocks.
///
/// # Errors
/// [`Uf2Error`]: the program does not lie in the flash, or is empty.
pub fn blocks(image: &Image) -> Result<Vec<u8>, Uf2Error> {
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

fn pages(image: &Image) -> Result<BTreeMap<u32, [u8; PAGE]>, Uf2Error> {
    let mut pages = BTreeMap::new();
    for segment in &image.segments {
        let end = u64::from(segment.address) + segment.bytes.len() as u64;
        if !FLASH.contains(&segment.address) || end > u64::from(FLASH.end) {
            let address = segment.address;
            return Err(Uf2Error::OutsideFlash { address });
        }
        for (address, byte) in (segment.address..).zip(&segment.bytes) {
            let within = address as usize % PAGE;
            // Bytes that the program does not have stay erased.
            let page = pages.entry(address - within as u32).or_insert([0xFF; PAGE]);
            page[within] = *byte;
        }
    }
    if pages.is_empty() {
        return Err(Uf2Error::Empty);
    }
    Ok(pages)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::Segment;

    fn image(segments: &[(u32, &[u8])]) -> Image {
        let segment = |(address, bytes): &(u32, &[u8])| Segment {
            address: *address,
            bytes: bytes.to_vec(),
        };
        Image {
            segments: segments.iter().map(segment).collect(),
            ..Image::default()
        }
    }

    fn word(block: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(block[at..at + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn every_byte_stands_in_the_page_of_its_address() {
        let long: Vec<u8> = (0..=255).chain(0..44).collect();
        let file =
            blocks(&image(&[(0x1000_01FE, &long), (0x1000_0000, b"boot")])).expect("in the flash");
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
            let outside = Err(Uf2Error::OutsideFlash { address });
            assert_eq!(blocks(&image(&[(address, b"four")])), outside);
        }
        assert_eq!(blocks(&image(&[])), Err(Uf2Error::Empty));
    }
}
