//! Whether the lengths that an MCAP file claims can be true, before anybody takes room for them.
//!
//! Strings and lists in MCAP records begin with their length (<https://mcap.dev/spec>). The `mcap`
//! crate takes that much memory before it looks whether so much is there: four bytes of damage are
//! four gigabytes. It also adds to the length of a record in a chunk without a check. So records
//! are looked through first; nothing is copied.

use mcap::MAGIC;

/// What a record is made of, from its beginning; what follows needs no room.
enum Part {
    /// So many bytes.
    Fixed(usize),
    /// A length of 32 bits, and so many bytes.
    Counted,
    /// A length of 32 bits, and so many bytes of counted strings, two and two.
    Pairs,
    /// A length of 32 bits, and so many bytes of items that have this many each.
    Items(usize),
    /// A length of 64 bits, and so many bytes of records.
    Records,
}

use Part::{Counted, Fixed, Items, Pairs, Records};

const CHUNK: u8 = 0x06;

/// The parts of a kind of record; none for kinds that have no lengths within.
const fn parts(kind: u8) -> &'static [Part] {
    match kind {
        // Header: profile, library.
        0x01 => &[Counted, Counted],
        // Schema: number; name, encoding, data.
        0x03 => &[Fixed(2), Counted, Counted, Counted],
        // Channel: numbers; topic, encoding, metadata.
        0x04 => &[Fixed(4), Counted, Counted, Pairs],
        // Chunk: times, size, checksum; compression, records.
        CHUNK => &[Fixed(28), Counted, Records],
        // Message index: channel; times and places.
        0x07 => &[Fixed(2), Items(8 + 8)],
        // Chunk index: times, place, length; channels and places of indexes; their length; compression.
        0x08 => &[Fixed(32), Items(2 + 8), Fixed(8), Counted],
        // Attachment: times; name, type; the data's length, and a checksum, which may not be missing.
        // (The data is not copied before it is there.)
        0x09 => &[Fixed(16), Counted, Counted, Fixed(8 + 4)],
        // Attachment index: place, length, times, size; name, type.
        0x0A => &[Fixed(40), Counted, Counted],
        // Statistics: counts and two times; channels and how many messages they have.
        0x0B => &[Fixed(42), Items(2 + 8)],
        // Metadata: name, pairs.
        0x0C => &[Counted, Pairs],
        // Metadata index: place, length; name.
        0x0D => &[Fixed(16), Counted],
        _ => &[],
    }
}

/// Where the first record begins that claims more than it has, if there is one. A file that is cut
/// off is looked through up to the cut.
pub(super) fn first_impossible(file: &[u8]) -> Option<usize> {
    let records = file.get(MAGIC.len()..).unwrap_or_default();
    let mut rest = records;
    while let Some((kind, content, after)) = split_record(rest) {
        if !fits(parts(kind), content) {
            return Some(MAGIC.len() + records.len() - rest.len());
        }
        rest = after;
    }
    None
}

/// Whether these are whole records, as they stand in a chunk: no chunks again.
fn are_whole(mut records: &[u8]) -> bool {
    while !records.is_empty() {
        match split_record(records) {
            Some((kind, content, after)) if kind != CHUNK && fits(parts(kind), content) => {
                records = after;
            }
            _ => return false,
        }
    }
    true
}

/// The first record's kind and content, and what follows it; `None` if it is not whole.
fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let (content, after) = split_counted_64(rest)?;
    Some((*kind, content, after))
}

fn fits(parts: &[Part], mut content: &[u8]) -> bool {
    parts.iter().all(|part| {
        let rest = match part {
            Fixed(length) => content.get(*length..),
            Counted => split_counted(content).map(|(_, rest)| rest),
            Pairs => split_counted(content)
                .filter(|(strings, _)| are_pairs(strings))
                .map(|(_, rest)| rest),
            // An item cut short would be completed from what follows, which then is misread.
            Items(size) => split_counted(content)
                .filter(|(items, _)| items.len().is_multiple_of(*size))
                .map(|(_, rest)| rest),
            Records => split_counted_64(content)
                .filter(|(records, _)| are_whole(records))
                .map(|(_, rest)| rest),
        };
        content = rest.unwrap_or_default();
        rest.is_some()
    })
}

/// Whether every key has its value: one that is missing would be looked for beyond the list.
fn are_pairs(mut strings: &[u8]) -> bool {
    while !strings.is_empty() {
        match split_counted(strings).and_then(|(_, value)| split_counted(value)) {
            Some((_, rest)) => strings = rest,
            None => return false,
        }
    }
    true
}

fn split_counted(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
    rest.split_at_checked(length)
}

fn split_counted_64(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    rest.split_at_checked(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: u8, content: &[u8]) -> Vec<u8> {
        let length = (content.len() as u64).to_le_bytes();
        [&[kind][..], &length, content].concat()
    }

    fn file(records: &[Vec<u8>]) -> Vec<u8> {
        [MAGIC, &records.concat()].concat()
    }

    const TEXT: &[u8] = &[2, 0, 0, 0, b'a', b'b'];
    const HUGE: &[u8] = &[0xFF, 0xFF, 0xFF, 0x7F, b'a', b'b'];

    #[test]
    fn a_string_that_claims_too_much_is_found_where_its_record_begins() {
        let good = record(0x01, &[TEXT, TEXT].concat());
        let bad = record(0x01, &[TEXT, HUGE].concat());
        assert_eq!(first_impossible(&file(&[good.clone(), good.clone()])), None);
        let at = Some(MAGIC.len() + good.len());
        assert_eq!(first_impossible(&file(&[good, bad])), at);
    }

    #[test]
    fn strings_within_lists_and_records_within_chunks_are_looked_at() {
        let list = |strings: &[u8]| {
            let length = (strings.len() as u32).to_le_bytes();
            record(0x0C, &[TEXT, &length, strings].concat())
        };
        let (pair, huge) = ([TEXT, TEXT].concat(), [TEXT, HUGE].concat());
        assert_eq!(first_impossible(&file(&[list(&pair)])), None);
        assert_eq!(first_impossible(&file(&[list(&huge)])), Some(MAGIC.len()));
        // A key without its value.
        assert_eq!(first_impossible(&file(&[list(TEXT)])), Some(MAGIC.len()));
        let chunk = |records: &[u8]| {
            let length = (records.len() as u64).to_le_bytes();
            record(0x06, &[&[0; 28][..], &[0; 4], &length, records].concat())
        };
        assert_eq!(first_impossible(&file(&[chunk(&list(&pair))])), None);
        let bad = file(&[chunk(&list(&huge))]);
        assert_eq!(first_impossible(&bad), Some(MAGIC.len()));
    }

    #[test]
    fn chunks_hold_whole_records_and_no_chunks() {
        let chunk = |records: &[u8]| {
            let length = (records.len() as u64).to_le_bytes();
            record(CHUNK, &[&[0; 28][..], &[0; 4], &length, records].concat())
        };
        let whole = record(0x05, b"message");
        assert_eq!(first_impossible(&file(&[chunk(&whole)])), None);
        let cut = file(&[chunk(&whole[..whole.len() - 1])]);
        assert_eq!(first_impossible(&cut), Some(MAGIC.len()));
        let longest = file(&[chunk(&[&[0x05][..], &[0xFF; 8]].concat())]);
        assert_eq!(first_impossible(&longest), Some(MAGIC.len()));
        let nested = (0..10_000).fold(whole, |records, _| chunk(&records));
        assert_eq!(first_impossible(&file(&[nested])), Some(MAGIC.len()));
    }

    #[test]
    fn an_attachment_has_a_checksum() {
        let attachment = |end: &[u8]| record(0x09, &[&[0; 16][..], TEXT, TEXT, end].concat());
        assert_eq!(first_impossible(&file(&[attachment(&[0; 12])])), None);
        let short = file(&[attachment(&[0; 11])]);
        assert_eq!(first_impossible(&short), Some(MAGIC.len()));
    }

    #[test]
    fn lists_of_items_hold_whole_items() {
        let index = |bytes: u32| {
            let items = vec![0; bytes as usize];
            let parts = [&[0; 32][..], &bytes.to_le_bytes(), &items, &[0; 8], TEXT];
            record(0x08, &parts.concat())
        };
        assert_eq!(first_impossible(&file(&[index(0), index(20)])), None);
        assert_eq!(first_impossible(&file(&[index(6)])), Some(MAGIC.len()));
    }

    #[test]
    fn a_cut_is_nothing_impossible() {
        let whole = file(&[record(0x01, &[TEXT, TEXT].concat())]);
        for length in 0..whole.len() {
            assert_eq!(first_impossible(&whole[..length]), None);
        }
    }
}
