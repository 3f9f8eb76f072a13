//! The "binary info" of an image (Pico SDK, `pico/binary_info`): what `picotool info` shows. Here only
//! the board that the program was built for.
//!
//! ```text
//! header   marker 0x7188ebf2 | first entry's address | end | address of a table | marker 0xe71aa390
//! entries  one address of an entry each
//! entry    type u16 | tag u16 | ... | for strings: id u32 | address of zero-terminated bytes
//! ```
//!
//! (All little-endian; each item of the header is a u32.) The header lies within the first 256 bytes
//! after the second stage boot loader. The table says where initialised variables lie in the flash; it
//! is not read, so entries in RAM are not found.

use crate::elf::Image;

/// Where the second stage boot loader ends.
const PROGRAM: u32 = 0x1000_0100;
/// Words of the program at which the header, of five words, can begin.
const HEADER_WORDS: u32 = 60;
const MARKERS: [u32; 2] = [0x7188_ebf2, 0xe71a_a390];
/// Type 6, a string with an ID, of tag "RP".
const STRING: u32 = 6 | (u16::from_le_bytes(*b"RP") as u32) << 16;
/// The ID of the board's name (`BINARY_INFO_ID_RP_PICO_BOARD`).
const PICO_BOARD: u32 = 0xb63c_ffbb;

/// Returns the name of the board that an image was built for (`pico_board`), if it says so.
pub fn pico_board(image: &Image) -> Option<&str> {
    let [first, end] = (0..HEADER_WORDS).find_map(|place| {
        let [marker, first, end, _, last] = words(image, PROGRAM + 4 * place)?;
        ([marker, last] == MARKERS).then_some([first, end])
    })?;
    let entries = (first..end)
        .step_by(4)
        .map_while(|address| words(image, address));
    let mut strings = entries.filter_map(|[entry]| words(image, entry));
    let [.., text] = strings.find(|[kind, id, _]| [*kind, *id] == [STRING, PICO_BOARD])?;
    let text = bytes(image, text)?.split(|byte| *byte == 0).next()?;
    std::str::from_utf8(text).ok()
}

/// What is in memory from an address to the end of its segment.
fn bytes(image: &Image, address: u32) -> Option<&[u8]> {
    image.segments.iter().find_map(|segment| {
        let start = address.checked_sub(segment.address)?;
        let bytes = segment.bytes.get(start as usize..)?;
        // Another segment may begin where this one ends.
        (!bytes.is_empty()).then_some(bytes)
    })
}

/// The words from an address on.
fn words<const N: usize>(image: &Image, address: u32) -> Option<[u32; N]> {
    let (words, _) = bytes(image, address)?.as_chunks();
    let words = words.first_chunk::<N>()?;
    Some(words.map(u32::from_le_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf::Segment;

    /// Where the entries and what they point to lie.
    const ENTRIES: u32 = 0x1000_4000;

    /// An image with the header after so many bytes, and two entries right behind another segment: the
    /// program's name, and a string with this ID.
    fn image(header: usize, id: u32) -> Image {
        let mut program = vec![0xaa; header];
        let table = 0x1000_8000;
        let words = [MARKERS[0], ENTRIES, ENTRIES + 8, table, MARKERS[1]];
        program.extend(words.map(u32::to_le_bytes).as_flattened());
        let text = ENTRIES + 32;
        let entries = [
            [ENTRIES + 8, ENTRIES + 20].as_slice(),
            &[STRING, 0x0203_1c86, text],
            &[STRING, id, text + 5],
        ];
        let entries = entries.concat().into_iter();
        let mut entries: Vec<u8> = entries.flat_map(u32::to_le_bytes).collect();
        entries.extend(*b"name\0a-board\0more");
        let segment = |address, bytes| Segment { address, bytes };
        Image {
            segments: vec![
                segment(PROGRAM, program),
                segment(ENTRIES - 8, vec![0xbb; 8]),
                segment(ENTRIES, entries),
            ],
            ..Image::default()
        }
    }

    #[test]
    fn the_board_is_found_among_other_entries() {
        assert_eq!(pico_board(&image(192, PICO_BOARD)), Some("a-board"));
        assert_eq!(pico_board(&image(236, PICO_BOARD)), Some("a-board"));
    }

    #[test]
    fn images_that_do_not_tell_have_no_board() {
        assert_eq!(pico_board(&Image::default()), None);
        assert_eq!(
            pico_board(&image(192, 0x5360_b3ab)),
            None,
            "the SDK's version"
        );
        assert_eq!(pico_board(&image(240, PICO_BOARD)), None, "too far behind");
        let mut without = image(192, PICO_BOARD);
        without.segments.pop();
        assert_eq!(pico_board(&without), None, "no entries");
    }

    #[test]
    fn a_damaged_image_never_panics() {
        let whole = image(192, PICO_BOARD);
        for number in 0..whole.segments.len() {
            for place in 0..8 * whole.segments[number].bytes.len() {
                let mut damaged = whole.clone();
                damaged.segments[number].bytes[place / 8] ^= 1 << (place % 8);
                let _ = pico_board(&damaged);
                damaged.segments[number].bytes.truncate(place / 8);
                let _ = pico_board(&damaged);
            }
        }
    }
}
