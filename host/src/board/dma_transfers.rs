//! The transfers that the DMA controller wants, made on the bus.

use super::bus::SystemBus;
use super::cpu::{Bus as _, BusFault};
use super::dma::{Outcome, Size, Transfer};
use super::peripheral::Cycles;

/// Transfers that are made before the core has its turn again, if nothing paces them. They are made
/// in no time, and the time they take is made up for before the next.
const AT_ONCE: Cycles = 64;

impl SystemBus {
    /// Makes the transfers that may be made now; gives when to look again if there are more.
    pub(super) fn run_dma(&mut self) -> Option<Cycles> {
        if self.now < self.dma_busy_until {
            return Some(self.dma_busy_until);
        }
        for made in 0.. {
            if self.peripherals.dma.is_idle() {
                return None;
            }
            if made == AT_ONCE {
                break;
            }
            let requests = self.peripherals.dma_requests();
            let transfer = self.peripherals.dma.next_transfer(requests, self.now)?;
            let outcome = self.make(&transfer);
            self.peripherals.dma.completed(transfer, outcome);
        }
        self.dma_busy_until = self.now + AT_ONCE;
        Some(self.dma_busy_until)
    }

    fn make(&mut self, transfer: &Transfer) -> Outcome {
        let Ok(data) = self.read_sized(transfer.from, transfer.size) else {
            return Outcome::ReadError;
        };
        match self.write_sized(transfer.to, transfer.size, transfer.swapped(data)) {
            Ok(()) => Outcome::Moved(data),
            Err(BusFault) => Outcome::WriteError,
        }
    }

    fn read_sized(&mut self, address: u32, size: Size) -> Result<u32, BusFault> {
        if !address.is_multiple_of(size.bytes()) {
            return Err(BusFault);
        }
        match size {
            Size::Byte => self.read8(address).map(u32::from),
            Size::Halfword => self.read16(address).map(u32::from),
            Size::Word => self.read32(address),
        }
    }

    fn write_sized(&mut self, address: u32, size: Size, data: u32) -> Result<(), BusFault> {
        if !address.is_multiple_of(size.bytes()) {
            return Err(BusFault);
        }
        match size {
            Size::Byte => self.write8(address, data as u8),
            Size::Halfword => self.write16(address, data as u16),
            Size::Word => self.write32(address, data),
        }
    }
}
