//! Versions of the layout of logs.

/// The version that is written. Messages of format 1 have one more field, `chain`: a checksum of
/// themselves and all messages before, which is not looked at any more.
pub const FORMAT: u32 = 2;
/// The oldest version that is read.
pub(crate) const OLDEST: u32 = 1;
/// The name of the metadata with which every log begins.
pub(crate) const METADATA: &str = "turing-rover";
