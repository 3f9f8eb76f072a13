//! The transfers that the DMA controller wants, made on the bus.

use super::bus::SystemBus;
use super::cpu::{Bus as _, BusFault};
use super::dma::{Outcome, Size, Transfer};
use super::peripheral::Cycles;

/// Transfers that are made before the core has its turn again, if nothing paces them. They are made
/// in no time, and the time they take is made up for before the next.
const AT_ONCE: Cycles = 64;

impl SystemBus {
    /// Makes the transfers that may be made now; returns when to look again if there are more.
    pub(super) fn run_dma(&mut self) -> Option<Cycles> {
        if self.now < self.dma_busy_until {
            return Some(self.dma_busy_until);
        }
        for made in 0.. {
            self.peripherals.pass_on_wraps();
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

#[cfg(test)]
mod tests {
    use super::*;

    const DMA: u32 = 0x5000_0000;
    const PWM: u32 = 0x4005_0000;
    const RAM: u32 = 0x2000_0000;
    const RESETS: u32 = 0x4000_c000;

    fn write(bus: &mut SystemBus, address: u32, value: u32) {
        bus.write32(address, value).expect("a register, or RAM");
    }

    /// Lets the peripherals and the controller do what is due by this time; when to look again.
    fn look(bus: &mut SystemBus, now: Cycles) -> Option<Cycles> {
        bus.now = now;
        bus.peripherals.advance(now);
        let more = bus.run_dma();
        [more, bus.peripherals.next_event()]
            .into_iter()
            .flatten()
            .min()
    }

    /// A bus whose channel 0 is to move two words from one place in RAM to the next.
    fn copying(treq: u32, from: u32) -> SystemBus {
        let mut bus = SystemBus::new(0);
        write(&mut bus, RESETS, 0);
        write(&mut bus, RAM, 0x1111_2222);
        write(&mut bus, RAM + 4, 0x3333_4444);
        write(&mut bus, DMA, from);
        write(&mut bus, DMA + 4, RAM + 0x100);
        write(&mut bus, DMA + 8, 2);
        // Enabled, words, both addresses move on, chained to itself.
        write(&mut bus, DMA + 0xc, treq << 15 | 0b11_1001);
        bus
    }

    #[test]
    fn words_are_copied_when_nothing_paces_them() {
        let mut bus = copying(63, RAM);
        look(&mut bus, 1);
        assert_eq!(bus.read32(RAM + 0x100), Ok(0x1111_2222));
        assert_eq!(bus.read32(RAM + 0x104), Ok(0x3333_4444));
        assert!(bus.peripherals.dma.is_idle());
    }

    #[test]
    fn one_word_is_moved_at_each_wrap_of_a_pwm_counter() {
        let mut bus = copying(24 + 2, RAM);
        let slice = PWM + 2 * 0x14;
        write(&mut bus, slice + 0x10, 999);
        write(&mut bus, slice, 1);
        assert_eq!(look(&mut bus, 1), Some(1_000));
        assert_eq!(look(&mut bus, 1_000), Some(2_000));
        assert_eq!(bus.read32(RAM + 0x100), Ok(0x1111_2222));
        assert_ne!(bus.read32(RAM + 0x104), Ok(0x3333_4444));
        assert_eq!(look(&mut bus, 2_000), None, "nothing waits any more");
        assert_eq!(bus.read32(RAM + 0x104), Ok(0x3333_4444));
    }

    #[test]
    fn the_sniffer_calculates_the_checksum_of_what_is_copied() {
        let mut bus = copying(63, RAM);
        // Enabled, of channel 0, CRC-32 reversed; the result reversed and inverted.
        write(&mut bus, DMA + 0x434, 1 | 1 << 5 | 1 << 10 | 1 << 11);
        write(&mut bus, DMA + 0x438, !0);
        let control = bus.read32(DMA + 0xc).expect("a register");
        write(&mut bus, DMA + 8, 2);
        write(&mut bus, DMA + 0xc, control | 1 << 23);
        look(&mut bus, 1);
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let expected = crc.checksum(&[0x22, 0x22, 0x11, 0x11, 0x44, 0x44, 0x33, 0x33]);
        assert_eq!(bus.read32(DMA + 0x438), Ok(expected));
    }

    #[test]
    fn what_the_bus_refuses_halts_the_channel() {
        for from in [0x3000_0000, RAM + 2] {
            let mut bus = copying(63, from);
            look(&mut bus, 1);
            assert!(bus.peripherals.dma.is_idle());
            let errors = bus.read32(DMA + 0xc).map(|ctrl| ctrl >> 29);
            assert_eq!(errors, Ok(0b110), "read error");
        }
    }
}
