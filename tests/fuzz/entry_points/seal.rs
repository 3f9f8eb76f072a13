//! Bytes with their checksums put right, so that what is behind a checksum meets them too.

use crc::{CRC_32_ISO_HDLC, Crc};
use rover_shared::wire::PROTOCOL_VERSION;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A whole frame with these bytes as its message; see [`rover_shared::wire`].
pub fn frame(message: &[u8]) -> Vec<u8> {
    let mut plain = vec![PROTOCOL_VERSION, 0, 0];
    plain.extend_from_slice(message);
    plain.extend(CRC.checksum(&plain).to_le_bytes());
    stuffed(&plain)
}

/// COBS: blocks of up to 254 bytes other than 0, each after its length and 1; 0 at the end.
fn stuffed(plain: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let parts = plain.split(|byte| *byte == 0);
    for part in parts {
        let mut blocks = part.chunks(254).peekable();
        if blocks.peek().is_none() {
            out.push(1);
        }
        while let Some(block) = blocks.next() {
            out.push(block.len() as u8 + 1);
            out.extend_from_slice(block);
            // A full block has no 0 after it; one that a part ends with needs another.
            if block.len() == 254 && blocks.peek().is_none() {
                out.push(1);
            }
        }
    }
    out.push(0);
    out
}

/// Knowledge with the length and the checksum that it should have; see
/// [`rover_shared::knowledge`].
pub fn knowledge(bytes: &[u8]) -> Vec<u8> {
    let mut sealed = bytes.to_vec();
    let length = bytes.len() as u32;
    if let Some(place) = sealed.get_mut(8..12) {
        place.copy_from_slice(&length.to_le_bytes());
    }
    if let Some((content, checksum)) = sealed.split_last_chunk_mut::<4>() {
        *checksum = CRC.checksum(content).to_le_bytes();
    }
    sealed
}

/// MCAP with the checksums of its chunks, its attachments and all its data put right, as far as its records follow
/// each other. (<https://mcap.dev/spec>: a record is its kind, its length and its content.)
pub fn log(bytes: &[u8]) -> Vec<u8> {
    const MAGIC: usize = 8;
    const HEAD: usize = 9;
    const ATTACHMENT: u8 = 0x09;
    const CHUNK: u8 = 0x06;
    const DATA_END: u8 = 0x0F;
    let mut sealed = bytes.to_vec();
    let mut at = MAGIC;
    while let Some(head) = sealed.get(at..at.saturating_add(HEAD)) {
        let kind = head[0];
        let length = u64::from_le_bytes([
            head[1], head[2], head[3], head[4], head[5], head[6], head[7], head[8],
        ]);
        let start = at + HEAD;
        let Some(end) = usize::try_from(length)
            .ok()
            .and_then(|length| start.checked_add(length))
        else {
            break;
        };
        let Some((before, record)) = sealed
            .get_mut(..end)
            .and_then(|all| all.split_at_mut_checked(at))
        else {
            break;
        };
        let content = &mut record[HEAD..];
        match kind {
            CHUNK => chunk(content),
            ATTACHMENT => attachment(content),
            DATA_END if content.len() == 4 => {
                content.copy_from_slice(&CRC.checksum(before).to_le_bytes());
            }
            _ => {}
        }
        at = end;
    }
    sealed
}

/// Two times of 8 bytes, size (8), checksum (4), compression (4 and text), length (8), records.
fn chunk(content: &mut [u8]) {
    let Some(length) = content.get(28..32) else {
        return;
    };
    let compression = u32::from_le_bytes([length[0], length[1], length[2], length[3]]);
    let records = (compression as usize).saturating_add(32 + 8);
    let Some(data) = content.get(records..) else {
        return;
    };
    let checksum = CRC.checksum(data).to_le_bytes();
    content[24..28].copy_from_slice(&checksum);
}

/// Ends with the checksum of all before it.
fn attachment(content: &mut [u8]) {
    if let Some((content, checksum)) = content.split_last_chunk_mut::<4>() {
        *checksum = CRC.checksum(content).to_le_bytes();
    }
}
