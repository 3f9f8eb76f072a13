//! The MCAP container (<https://mcap.dev/spec>), as far as reading logs needs it: metadata,
//! attachments, and messages within chunks or without, compressed or not.
//!
//! A file is magic bytes, records, and magic bytes again; a record is its kind (1 byte), the length
//! of its content (8 bytes) and the content. Integers are little-endian; a string or list begins
//! with the length of its bytes (4). Lengths may lie: a field is a slice of the file, which is
//! there or not, and nothing is allocated for what a length promises.
//!
//! Checksums that are 0 were not calculated; all others are verified: those of chunks, of
//! attachments, and of all that comes before the end of the data.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use mcap::MAGIC;

use crate::error::ReadError;
use crate::format::{FORMAT, METADATA, OLDEST};

const FOOTER: u8 = 0x02;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const ATTACHMENT: u8 = 0x09;
const METADATA_RECORD: u8 = 0x0C;
const DATA_END: u8 = 0x0F;

/// Longest unpacked chunk: writers make chunks of some megabytes, and a few packed bytes may claim
/// to become anything.
const LONGEST_CHUNK: u64 = 64 << 20;

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Names and values of a metadata record.
pub(crate) type Metadata = BTreeMap<String, String>;

/// A message.
pub(crate) struct Message<'a> {
    /// The name of its channel.
    pub topic: &'a str,
    /// When it was logged, in nanoseconds.
    pub log_time_ns: u64,
    /// What it says.
    pub data: &'a [u8],
}

/// What a file holds besides messages, as far as it reaches.
#[derive(Default)]
pub(crate) struct Extras<'a> {
    metadata: Vec<(&'a str, Metadata)>,
    /// By their names; of several with one name the last.
    pub attachments: BTreeMap<&'a str, &'a [u8]>,
}

impl<'a> Extras<'a> {
    /// Reads metadata and attachments; chunks are passed over.
    pub fn read(file: &'a [u8]) -> Result<Self, ReadError> {
        let mut extras = Self::default();
        walk(file, |at, kind, content| {
            match kind {
                METADATA_RECORD => {
                    let record = read_metadata(content).ok_or(ReadError::Damaged(at))?;
                    extras.metadata.push(record);
                }
                ATTACHMENT => {
                    let (name, data) = read_attachment(content).ok_or(ReadError::Damaged(at))?;
                    extras.attachments.insert(name, data);
                }
                _ => {}
            }
            Ok(())
        })?;
        Ok(extras)
    }

    /// The first metadata record with this name.
    pub fn metadata(&self, name: &str) -> Option<&Metadata> {
        let mut records = self.metadata.iter();
        records.find(|(of, _)| *of == name).map(|(_, pairs)| pairs)
    }

    /// The metadata with which a log begins, if its format can be read.
    pub fn header(&self) -> Result<&Metadata, ReadError> {
        let missing = ReadError::Foreign("the metadata turing-rover");
        let header = self.metadata(METADATA).ok_or(missing)?;
        let format = header.get("format").map_or("", String::as_str);
        match format.parse() {
            Ok(OLDEST..=FORMAT) => Ok(header),
            _ => Err(ReadError::Format(format.into())),
        }
    }
}

/// Calls `take` with each message in the order of the file, as far as the file reaches. Returns
/// whether it is cut off.
pub(crate) fn for_each_message(
    file: &[u8],
    mut take: impl FnMut(&Message<'_>) -> Result<(), ReadError>,
) -> Result<bool, ReadError> {
    let mut topics = BTreeMap::new();
    let mut take_record = |at, kind, content: &[u8]| {
        let damaged = || ReadError::Damaged(at);
        match kind {
            CHANNEL => {
                let (channel, topic) = read_channel(content).ok_or_else(damaged)?;
                topics.insert(channel, topic.to_owned());
            }
            MESSAGE => {
                let (channel, log_time_ns, data) = read_message(content).ok_or_else(damaged)?;
                let topic = topics.get(&channel).map_or("", String::as_str);
                take(&Message {
                    topic,
                    log_time_ns,
                    data,
                })?;
            }
            _ => {}
        }
        Ok(())
    };
    walk(file, |at, kind, content| match kind {
        CHUNK => {
            let records = unpack(content, at)?;
            let mut rest = &*records;
            while let Some((kind, content, after)) = split_record(rest) {
                take_record(at, kind, content)?;
                rest = after;
            }
            rest.is_empty().then_some(()).ok_or(ReadError::Damaged(at))
        }
        DATA_END => {
            let saved = Fields(content).u32().ok_or(ReadError::Damaged(at))?;
            let right = saved == 0 || saved == CRC.checksum(file.get(..at).unwrap_or_default());
            right.then_some(()).ok_or(ReadError::Checksum)
        }
        _ => take_record(at, kind, content),
    })
}

/// Calls `take` with the place, kind and content of each record up to the footer. Returns whether
/// the file is cut off.
fn walk<'a>(
    file: &'a [u8],
    mut take: impl FnMut(usize, u8, &'a [u8]) -> Result<(), ReadError>,
) -> Result<bool, ReadError> {
    let mut rest = file.strip_prefix(MAGIC).ok_or(ReadError::NotMcap)?;
    loop {
        let at = file.len() - rest.len();
        match split_record(rest) {
            Some((FOOTER, _, end)) if MAGIC.starts_with(end) => return Ok(end != MAGIC),
            // What ends as files do was not cut off: a length is wrong.
            Some((FOOTER, ..)) => return Err(ReadError::Damaged(at)),
            None if rest.ends_with(MAGIC) => return Err(ReadError::Damaged(at)),
            None => return Ok(true),
            Some((kind, content, after)) => {
                take(at, kind, content)?;
                rest = after;
            }
        }
    }
}

/// The first record's kind and content, and what follows it; `None` if it is not whole.
fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (kind, rest) = bytes.split_first()?;
    let mut fields = Fields(rest);
    let content = fields.block_64()?;
    Some((*kind, content, fields.0))
}

/// The records in a chunk: times of the first and last message (8 bytes each), length and checksum
/// (8, 4) of the records when unpacked, name of the compression, records with their length (8).
fn unpack(content: &[u8], at: usize) -> Result<Cow<'_, [u8]>, ReadError> {
    let mut fields = Fields(content);
    let mut head = || {
        fields.bytes(16)?;
        Some((
            fields.u64()?,
            fields.u32()?,
            fields.text()?,
            fields.block_64()?,
        ))
    };
    let damaged = ReadError::Damaged(at);
    let Some((length, checksum, compression, packed)) = head() else {
        return Err(damaged);
    };
    let records = match compression {
        "" => Cow::Borrowed(packed),
        "lz4" => Cow::Owned(
            read_packed(lz4_flex::frame::FrameDecoder::new(packed), length).ok_or(damaged)?,
        ),
        "zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed).ok();
            let records = decoder.and_then(|decoder| read_packed(decoder, length));
            Cow::Owned(records.ok_or(damaged)?)
        }
        other => return Err(ReadError::Compression(other.into())),
    };
    if checksum != 0 && checksum != CRC.checksum(&records) {
        return Err(ReadError::Damaged(at));
    }
    Ok(records)
}

/// Unpacked records, if they have this length.
fn read_packed(decoder: impl Read, length: u64) -> Option<Vec<u8>> {
    if length > LONGEST_CHUNK {
        return None;
    }
    let mut records = Vec::new();
    decoder.take(length + 1).read_to_end(&mut records).ok()?;
    (records.len() as u64 == length).then_some(records)
}

/// Numbers of channel and schema (2 bytes each), topic; what follows is not needed.
fn read_channel(content: &[u8]) -> Option<(u16, &str)> {
    let mut fields = Fields(content);
    let channel = fields.u16()?;
    fields.u16()?;
    Some((channel, fields.text()?))
}

/// Numbers of channel and message (2 and 4 bytes), times of logging and publishing (8 each), data.
fn read_message(content: &[u8]) -> Option<(u16, u64, &[u8])> {
    let mut fields = Fields(content);
    let channel = fields.u16()?;
    fields.u32()?;
    let log_time_ns = fields.u64()?;
    fields.u64()?;
    Some((channel, log_time_ns, fields.0))
}

/// Times of logging and creation (8 bytes each), name, media type, data with their length (8),
/// checksum of all this (4).
fn read_attachment(content: &[u8]) -> Option<(&str, &[u8])> {
    let mut fields = Fields(content);
    fields.bytes(16)?;
    let name = fields.text()?;
    fields.text()?;
    let data = fields.block_64()?;
    let covered = content.get(..content.len() - fields.0.len())?;
    let checksum = fields.u32()?;
    (checksum == 0 || checksum == CRC.checksum(covered)).then_some((name, data))
}

/// Name; list of names and values.
fn read_metadata(content: &[u8]) -> Option<(&str, Metadata)> {
    let mut fields = Fields(content);
    let name = fields.text()?;
    let mut pairs = Fields(fields.block()?);
    let mut metadata = Metadata::new();
    while !pairs.0.is_empty() {
        metadata.insert(pairs.text()?.into(), pairs.text()?.into());
    }
    Some((name, metadata))
}

/// What is left of a record.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, length: usize) -> Option<&'a [u8]> {
        let (bytes, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(bytes)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes that follow their length of 32 bits.
    fn block(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()?;
        self.bytes(length.try_into().ok()?)
    }

    /// Bytes that follow their length of 64 bits.
    fn block_64(&mut self) -> Option<&'a [u8]> {
        let length = self.u64()?;
        self.bytes(length.try_into().ok()?)
    }

    fn text(&mut self) -> Option<&'a str> {
        str::from_utf8(self.block()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: u8, content: &[u8]) -> Vec<u8> {
        let length = (content.len() as u64).to_le_bytes();
        [&[kind][..], &length, content].concat()
    }

    /// A whole file of these records.
    fn file(records: &[Vec<u8>]) -> Vec<u8> {
        let footer = record(FOOTER, &[0; 20]);
        [MAGIC, &records.concat(), &footer, MAGIC].concat()
    }

    fn counted(bytes: &[u8]) -> Vec<u8> {
        [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
    }

    const HUGE: &[u8] = &[0xFF, 0xFF, 0xFF, 0x7F, b'a', b'b'];

    fn chunk(compression: &str, length: usize, checksum: u32, records: &[u8]) -> Vec<u8> {
        let content = [
            &[0; 16][..],
            &(length as u64).to_le_bytes(),
            &checksum.to_le_bytes(),
            &counted(compression.as_bytes()),
            &(records.len() as u64).to_le_bytes(),
            records,
        ];
        record(CHUNK, &content.concat())
    }

    /// A channel "/a" and a message "hello" in it.
    fn records() -> Vec<u8> {
        let channel = [&[7, 0, 1, 0][..], &counted(b"/a"), &counted(b"json")].concat();
        let message = [
            &[7, 0][..],
            &[0; 4],
            &[9, 0, 0, 0, 0, 0, 0, 0],
            &[0; 8],
            b"hello",
        ];
        [
            record(CHANNEL, &channel),
            record(MESSAGE, &message.concat()),
        ]
        .concat()
    }

    /// The messages of a file as text, and whether it is cut off.
    fn read(file: &[u8]) -> Result<(String, bool), String> {
        let mut text = String::new();
        let cut = for_each_message(file, |message| {
            let data = String::from_utf8_lossy(message.data);
            text += &format!("{} at {}: {data};", message.topic, message.log_time_ns);
            Ok(())
        });
        cut.map(|cut| (text, cut))
            .map_err(|error| error.to_string())
    }

    const HELLO: &str = "/a at 9: hello;";

    #[test]
    fn messages_are_read_from_chunks_and_without() {
        let records = records();
        let whole = Ok((HELLO.to_owned(), false));
        assert_eq!(read(&file(std::slice::from_ref(&records))), whole);
        for checksum in [0, CRC.checksum(&records)] {
            let chunk = chunk("", records.len(), checksum, &records);
            assert_eq!(read(&file(&[chunk])), whole);
        }
        let wrong = file(&[chunk("", records.len(), 1, &records)]);
        assert!(read(&wrong).unwrap_err().contains("damaged at byte 8"));
        let cut = file(&[chunk("", records.len(), 0, &records[..records.len() - 1])]);
        assert!(read(&cut).unwrap_err().contains("damaged"));
    }

    #[test]
    fn packed_chunks_become_what_they_claim_or_nothing() {
        let records = records();
        let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
        std::io::Write::write_all(&mut packed, &records).unwrap();
        let lz4 = packed.finish().unwrap();
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        let zstd = ruzstd::encoding::compress_to_vec(&records[..], level);
        let checksum = CRC.checksum(&records);
        for (name, packed) in [("lz4", &lz4), ("zstd", &zstd)] {
            let of = |length| file(&[chunk(name, length, checksum, packed)]);
            assert_eq!(read(&of(records.len())), Ok((HELLO.to_owned(), false)));
            for wrong in [0, records.len() - 1, records.len() + 1, usize::MAX] {
                assert!(read(&of(wrong)).unwrap_err().contains("damaged"));
            }
        }
        let other = file(&[chunk("brotli", 5, 0, b"hello")]);
        assert!(read(&other).unwrap_err().contains("brotli"));
    }

    #[test]
    fn what_claims_to_hold_more_than_it_does_is_damaged() {
        let longest = [&[MESSAGE][..], &[0xFF; 8]].concat();
        let list =
            |pairs: &[u8]| record(METADATA_RECORD, &[counted(b"a"), counted(pairs)].concat());
        let pair = [counted(b"k"), counted(b"v")].concat();
        let whole = file(&[list(&pair)]);
        let extras = Extras::read(&whole).unwrap();
        assert_eq!(extras.metadata("a").unwrap()["k"], "v");
        // A key without its value among them.
        for records in [
            list(HUGE),
            list(&counted(b"k")),
            record(METADATA_RECORD, HUGE),
        ] {
            assert!(matches!(
                Extras::read(&file(&[records])),
                Err(ReadError::Damaged(8))
            ));
        }
        assert!(read(&file(&[longest])).unwrap_err().contains("damaged"));
        let nested = file(&[chunk("", 0, 0, &chunk("", 0, 0, &records()))]);
        assert_eq!(read(&nested), Ok((String::new(), false)));
    }

    #[test]
    fn an_attachment_has_a_checksum_that_is_right_or_none() {
        let attached = |checksum: Option<u32>| {
            let mut content = [
                &[0; 16][..],
                &counted(b"a"),
                &counted(b""),
                &[1, 0, 0, 0, 0, 0, 0, 0, 7],
            ]
            .concat();
            let right = CRC.checksum(&content);
            content.extend(checksum.unwrap_or(right).to_le_bytes());
            file(&[record(ATTACHMENT, &content)])
        };
        for file in [attached(None), attached(Some(0))] {
            assert_eq!(Extras::read(&file).unwrap().attachments["a"], [7]);
        }
        assert!(Extras::read(&attached(Some(1))).is_err());
    }

    #[test]
    fn the_checksum_of_all_data_is_verified() {
        let end = |checksum: u32| {
            let end = record(DATA_END, &checksum.to_le_bytes());
            file(&[records(), end])
        };
        let right = CRC.checksum(&[MAGIC, &records()].concat());
        assert!(read(&end(0)).is_ok() && read(&end(right)).is_ok());
        assert!(read(&end(1)).unwrap_err().contains("checksum"));
    }

    #[test]
    fn a_cut_is_no_damage() {
        let whole = file(&[records()]);
        for length in MAGIC.len()..whole.len() {
            let (text, cut) = read(&whole[..length]).unwrap();
            assert!(cut && HELLO.starts_with(&text), "{length}: {text}");
        }
    }
}
