//! What the functions of the boot ROM do.
//!
//! They take some cycles of the core's, estimated from their loops, and those of the flash as long
//! as the flash takes. Meanwhile the core stands still, and interrupts, which the caller has masked,
//! wait.

use super::boot_rom::{self, BOOT2_ADDRESS, BOOT2_SIZE, Service};
use super::bus::{Boot, SystemBus};
use super::cpu::{Bus as _, BusFault, LR, PC, Registers};
use super::flash::{Operation, PAGE, SECTOR, SIZE};
use super::peripheral::Cycles;

/// A call, and what little the function does.
const SHORT: Cycles = 20;
/// Cycles for a byte that is copied or set.
const PER_BYTE: Cycles = 2;
/// Cycles for a byte by which the flash's interface is read or set up.
const PER_FLASH_BYTE: Cycles = 32;
/// Cycles for an entry of a table that is looked at.
const PER_ENTRY: Cycles = 8;

impl SystemBus {
    /// Does what a function of the boot ROM does.
    ///
    /// # Errors
    /// An address it was given is not memory.
    pub(super) fn serve(
        &mut self,
        service: Service,
        registers: &mut Registers,
    ) -> Result<(), BusFault> {
        let [first, second, third] = [0, 1, 2].map(|number| registers.get(number));
        let time = match service {
            Service::Boot => self.start_second_stage(registers),
            Service::Lookup => {
                registers.set(0, boot_rom::look_up(&self.memory.rom, first, second));
                SHORT + 16 * PER_ENTRY
            }
            Service::PopulationCount => {
                registers.set(0, first.count_ones());
                SHORT
            }
            Service::Reverse => {
                registers.set(0, first.reverse_bits());
                SHORT
            }
            Service::LeadingZeros => {
                registers.set(0, first.leading_zeros());
                SHORT
            }
            Service::TrailingZeros => {
                registers.set(0, first.trailing_zeros());
                SHORT
            }
            Service::Fill => {
                for offset in 0..third {
                    self.write8(first.wrapping_add(offset), second as u8)?;
                }
                SHORT + Cycles::from(third) * PER_BYTE
            }
            Service::Copy => {
                for offset in 0..third {
                    let byte = self.read8(second.wrapping_add(offset))?;
                    self.write8(first.wrapping_add(offset), byte)?;
                }
                SHORT + Cycles::from(third) * PER_BYTE
            }
            Service::ConnectFlash | Service::FlushCache => SHORT,
            Service::ExitXip => {
                self.ssi.exit_continuous_read();
                self.flash.set_mapped(false);
                4 * PER_FLASH_BYTE
            }
            Service::EnterXip => {
                self.flash.set_mapped(true);
                4 * PER_FLASH_BYTE
            }
            Service::EraseRange => self.erase(first, second),
            Service::ProgramRange => self.program(first, second, third)?,
            Service::UsbBoot => {
                self.boot = Boot::UsbDrive;
                registers.set(PC, boot_rom::rest_address());
                0
            }
        };
        self.stalled_until = self.now + time;
        Ok(())
    }

    /// Copies the second stage to RAM and starts it; the core rests if there is none.
    fn start_second_stage(&mut self, registers: &mut Registers) -> Cycles {
        let boot2: Option<[u8; BOOT2_SIZE]> = self.flash.bytes().first_chunk().copied();
        let valid = boot2.filter(boot_rom::is_second_stage);
        let copied = valid.and_then(|boot2| self.memory.write_ram(BOOT2_ADDRESS, boot2));
        if copied.is_some() {
            self.boot = Boot::Started;
            registers.set(LR, 0);
            registers.set(PC, BOOT2_ADDRESS);
        } else {
            self.boot = Boot::NoProgram;
            registers.set(PC, boot_rom::rest_address());
        }
        BOOT2_SIZE as Cycles * PER_FLASH_BYTE
    }

    /// Erases sectors, one at a time: larger blocks, which take less time a byte, are not used.
    fn erase(&mut self, offset: u32, count: u32) -> Cycles {
        // A chip that serves reads takes no commands.
        if self.flash.is_mapped() {
            return SHORT;
        }
        let sectors = count.div_ceil(SECTOR).min(SIZE as u32 / SECTOR);
        for sector in 0..sectors {
            let offset = (offset & !(SECTOR - 1)).wrapping_add(sector * SECTOR);
            self.flash.enqueue(Operation::Erase { offset }, self.now);
        }
        Cycles::from(sectors) * 8 * PER_FLASH_BYTE
    }

    /// Programs pages.
    fn program(&mut self, offset: u32, data: u32, count: u32) -> Result<Cycles, BusFault> {
        if self.flash.is_mapped() {
            return Ok(SHORT);
        }
        let pages = count.div_ceil(PAGE).min(SIZE as u32 / PAGE);
        for page in 0..pages {
            let at = page * PAGE;
            let bytes: Result<Vec<u8>, BusFault> = (at..at + PAGE)
                .map(|i| self.read8(data.wrapping_add(i)))
                .collect();
            let offset = (offset & !(PAGE - 1)).wrapping_add(at);
            let operation = Operation::Program {
                offset,
                bytes: bytes?,
            };
            self.flash.enqueue(operation, self.now);
        }
        Ok(Cycles::from(pages) * Cycles::from(PAGE) * PER_FLASH_BYTE)
    }
}
