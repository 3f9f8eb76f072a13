//! What the core is connected to.

use super::registers::Registers;

/// The bus answered an access with an error: nothing is at that address, or it refuses the access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFault;

/// Memory and peripherals, as the core sees them: little-endian, every access aligned.
///
/// The core keeps the System Control Space (0xE000E000 to 0xE000EFFF) to itself; accesses to it
/// never reach the bus.
///
/// All accesses of an instruction are made within one [`Core::step`](super::Core::step). A bus with
/// wait states counts them here and adds them to the cycles that the step returns.
pub trait Bus {
    /// Reads `N` bytes, 1, 2 or 4; `address` is a multiple of `N`.
    ///
    /// # Errors
    /// The access ends in a HardFault.
    fn read<const N: usize>(&mut self, address: u32) -> Result<[u8; N], BusFault>;

    /// Writes `N` bytes, 1, 2 or 4; `address` is a multiple of `N`.
    ///
    /// # Errors
    /// The access ends in a HardFault.
    fn write<const N: usize>(&mut self, address: u32, bytes: [u8; N]) -> Result<(), BusFault>;

    /// Reads a byte, as [`read`](Self::read).
    #[inline(always)]
    fn read8(&mut self, address: u32) -> Result<u8, BusFault> {
        self.read(address).map(u8::from_le_bytes)
    }

    /// Reads a halfword, as [`read`](Self::read).
    #[inline(always)]
    fn read16(&mut self, address: u32) -> Result<u16, BusFault> {
        self.read(address).map(u16::from_le_bytes)
    }

    /// Reads a word, as [`read`](Self::read).
    #[inline(always)]
    fn read32(&mut self, address: u32) -> Result<u32, BusFault> {
        self.read(address).map(u32::from_le_bytes)
    }

    /// Writes a byte, as [`write`](Self::write).
    #[inline(always)]
    fn write8(&mut self, address: u32, value: u8) -> Result<(), BusFault> {
        self.write(address, value.to_le_bytes())
    }

    /// Writes a halfword, as [`write`](Self::write).
    #[inline(always)]
    fn write16(&mut self, address: u32, value: u16) -> Result<(), BusFault> {
        self.write(address, value.to_le_bytes())
    }

    /// Writes a word, as [`write`](Self::write).
    #[inline(always)]
    fn write32(&mut self, address: u32, value: u32) -> Result<(), BusFault> {
        self.write(address, value.to_le_bytes())
    }

    /// Fetches a halfword of code; `address` is even.
    ///
    /// # Errors
    /// The fetch ends in a HardFault.
    #[inline(always)]
    fn fetch(&mut self, address: u32) -> Result<u16, BusFault> {
        self.read16(address)
    }

    /// Cycles that a load or store of this address takes: 2 by way of AHB-Lite, 1 on the
    /// single-cycle I/O port.
    #[inline(always)]
    fn access_cycles(&self, _address: u32) -> u32 {
        2
    }

    /// SEV was executed: the other processors' event registers are to be set.
    fn send_event(&mut self) {}

    /// BKPT was executed. A debugger (semihosting, say) that knows what to do about it does so,
    /// and gives true: the core goes on behind the instruction. Without one, BKPT is a HardFault.
    fn breakpoint(&mut self, _comment: u8, _registers: &mut Registers) -> bool {
        false
    }
}
