//! The two checksums: of frames and stored headers, and of whole contents.

use crc::{CRC_32_ISCSI, CRC_32_ISO_HDLC, Crc, Digest, NoTable};

/// CRC-32/ISO-HDLC: the checksum of frames, headers and last words.
pub(crate) static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// CRC-32/ISCSI (Castagnoli's polynomial), for [`fingerprint`].
///
/// Knowledge ends with its own CRC-32/ISO-HDLC, and the same checksum over data that ends with it
/// is the same number for all data. Another polynomial tells one knowledge from another. Without a
/// table, which would take 1 KB: one fingerprint is computed at a time.
static CRC32C: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// CRC-32/ISCSI of a whole content, such as knowledge: guards its transfer and storage, and
/// identifies it.
///
/// ```
/// use rover_shared::checksum::fingerprint;
/// assert_eq!(fingerprint(b"123456789"), 0xe306_9283); // the algorithm's check value
/// ```
pub fn fingerprint(content: &[u8]) -> u32 {
    CRC32C.checksum(content)
}

/// [`fingerprint`] piece by piece.
pub(crate) fn digest() -> Digest<'static, u32, NoTable> {
    CRC32C.digest()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fingerprint_tells_contents_apart_that_end_with_their_crc() {
        let sealed = |content: &[u8]| {
            let mut sealed = content.to_vec();
            sealed.extend(CRC32.checksum(content).to_le_bytes());
            fingerprint(&sealed)
        };
        assert_ne!(sealed(b"one"), sealed(b"two"));
    }
}
