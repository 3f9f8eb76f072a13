//! What the storage needs of a flash.

use crate::time::Duration;

/// Bytes erased together.
pub const SECTOR: u32 = 4_096;
/// Bytes programmed together.
pub const PAGE: usize = 256;

/// How long the erasure of a sector takes at worst (W25Q16JV data sheet, 9.6, tSE).
pub const LONGEST_ERASURE: Duration = Duration::from_millis(400);

/// A NOR flash: erasing sets all bits of a sector, programming clears bits of a page.
pub trait Flash {
    /// Why an operation failed.
    type Error;

    /// Reads from `offset` bytes after the flash's start.
    ///
    /// # Errors
    /// The flash's.
    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), Self::Error>;

    /// Erases the sector that starts at `offset`.
    ///
    /// # Errors
    /// The flash's.
    fn erase(&mut self, offset: u32) -> Result<(), Self::Error>;

    /// Programs the erased page that starts at `offset`.
    ///
    /// # Errors
    /// The flash's.
    fn program(&mut self, offset: u32, page: &[u8; PAGE]) -> Result<(), Self::Error>;
}
