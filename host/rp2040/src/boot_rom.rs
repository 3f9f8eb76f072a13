//! A boot ROM of our own, in the place of the RP2040's (datasheet 2.8): the same header and tables,
//! so that programs find its functions, but what they do is done by the emulator.
//!
//! A function is a BKPT whose number says which, and a return. Behind the reset vector is another
//! that starts the program: it copies the second stage from the flash to the end of the RAM, checks
//! it, and goes there (2.8.1.2, 2.8.1.3). Without a valid second stage the real ROM shows itself as
//! a USB drive; this one sleeps.
//!
//! The functions for floating point are missing: looking them up returns 0.

/// Bytes of the ROM.
pub const SIZE: usize = 16 << 10;
/// Bytes of the second stage, and of its checksum at their end.
pub const BOOT2_SIZE: usize = 256;
/// Where the second stage is copied to: the last page but one of the RAM.
pub const BOOT2_ADDRESS: u32 = 0x2004_1f00;

/// Magic number, and version of the B2 revision's ROM.
const HEADER: [u8; 4] = [b'M', b'u', 1, 3];
const FUNCTION_TABLE: u32 = 0x100;
const DATA_TABLE: u32 = 0x180;
const START: u32 = 0x1c0;
/// WFI and a branch back to it.
const REST: u32 = 0x1d0;
const FUNCTIONS: u32 = 0x200;
/// BKPT and BX LR.
const FUNCTION_SIZE: u32 = 4;

const BKPT: u16 = 0xbe00;
const BX_LR: u16 = 0x4770;
const WFI: u16 = 0xbf30;
/// B to the halfword before it.
const BACK_TO_WFI: u16 = 0xe7fd;

/// What the ROM does, numbered as its BKPT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Starts the program.
    Boot,
    /// `rom_table_lookup(table, code)`.
    Lookup,
    /// `popcount32`.
    PopulationCount,
    /// `reverse32`.
    Reverse,
    /// `clz32`.
    LeadingZeros,
    /// `ctz32`.
    TrailingZeros,
    /// `memset` and `memset4`.
    Fill,
    /// `memcpy` and `memcpy44`.
    Copy,
    /// `connect_internal_flash`.
    ConnectFlash,
    /// `flash_exit_xip`.
    ExitXip,
    /// `flash_range_erase(offset, count, block_size, block_command)`.
    EraseRange,
    /// `flash_range_program(offset, data, count)`.
    ProgramRange,
    /// `flash_flush_cache`.
    FlushCache,
    /// `flash_enter_cmd_xip`.
    EnterXip,
    /// `reset_to_usb_boot`: what follows is no longer this program.
    UsbBoot,
}

impl Service {
    const ALL: [Self; 15] = [
        Self::Boot,
        Self::Lookup,
        Self::PopulationCount,
        Self::Reverse,
        Self::LeadingZeros,
        Self::TrailingZeros,
        Self::Fill,
        Self::Copy,
        Self::ConnectFlash,
        Self::ExitXip,
        Self::EraseRange,
        Self::ProgramRange,
        Self::FlushCache,
        Self::EnterXip,
        Self::UsbBoot,
    ];

    /// Where its code is.
    const fn address(self) -> u32 {
        match self {
            Self::Boot => START,
            _ => FUNCTIONS + FUNCTION_SIZE * self as u32,
        }
    }

    /// The service of a BKPT with this number at this address, if it is the ROM's.
    pub fn at(address: u32, number: u8) -> Option<Self> {
        let service = *Self::ALL.get(usize::from(number))?;
        (service.address() == address).then_some(service)
    }
}

/// The codes by which functions are looked up (2.8.3).
const CODES: [(&[u8; 2], Service); 16] = [
    (b"P3", Service::PopulationCount),
    (b"R3", Service::Reverse),
    (b"L3", Service::LeadingZeros),
    (b"T3", Service::TrailingZeros),
    (b"MS", Service::Fill),
    (b"S4", Service::Fill),
    (b"MC", Service::Copy),
    (b"C4", Service::Copy),
    (b"IF", Service::ConnectFlash),
    (b"EX", Service::ExitXip),
    (b"RE", Service::EraseRange),
    (b"RP", Service::ProgramRange),
    (b"FC", Service::FlushCache),
    (b"CX", Service::EnterXip),
    (b"UB", Service::UsbBoot),
    // An end, so that a table that grew would not run into the next one unseen.
    (b"\0\0", Service::Boot),
];

/// The address where the core sleeps, there being nothing to start.
pub const fn rest_address() -> u32 {
    REST
}

/// The ROM's bytes.
pub fn contents() -> Box<[u8; SIZE]> {
    let mut rom = Box::new([0; SIZE]);
    let mut halfword = |address: u32, value: u32| {
        let at = address as usize;
        rom[at..at + 2].copy_from_slice(&(value as u16).to_le_bytes());
    };
    // Vectors: stack, reset; NMI and HardFault rest.
    for (address, value) in [
        (0x00, BOOT2_ADDRESS),
        (0x04, START | 1),
        (0x08, REST | 1),
        (0x0c, REST | 1),
    ] {
        halfword(address, value);
        halfword(address + 2, value >> 16);
    }
    halfword(0x10, u32::from(u16::from_le_bytes([HEADER[0], HEADER[1]])));
    halfword(0x12, u32::from(u16::from_le_bytes([HEADER[2], HEADER[3]])));
    halfword(0x14, FUNCTION_TABLE);
    halfword(0x16, DATA_TABLE);
    halfword(0x18, Service::Lookup.address() | 1);
    for service in Service::ALL {
        halfword(service.address(), u32::from(BKPT) | service as u32);
        halfword(service.address() + 2, u32::from(BX_LR));
    }
    halfword(REST, u32::from(WFI));
    halfword(REST + 2, u32::from(BACK_TO_WFI));
    for (entry, (code, service)) in (FUNCTION_TABLE..).step_by(4).zip(CODES) {
        let code = u16::from_le_bytes(*code);
        halfword(entry, code.into());
        halfword(entry + 2, if code == 0 { 0 } else { service.address() | 1 });
    }
    rom
}

/// `rom_table_lookup`: the address of a function or datum, 0 if it is not there.
pub fn look_up(rom: &[u8; SIZE], table: u32, code: u32) -> u32 {
    let entries = rom.get(table as usize..).unwrap_or_default();
    let halfwords = entries
        .chunks_exact(4)
        .map(|entry| ([entry[0], entry[1]], [entry[2], entry[3]]))
        .map(|(code, value)| (u16::from_le_bytes(code), u16::from_le_bytes(value)));
    halfwords
        .take_while(|(entry, _)| *entry != 0)
        .find(|(entry, _)| u32::from(*entry) == code)
        .map_or(0, |(_, value)| value.into())
}

/// Whether these bytes are a second stage that the ROM starts: their last word is the CRC-32 of the
/// others, not reflected and not inverted (2.8.1.3.1).
pub fn is_second_stage(boot2: &[u8; BOOT2_SIZE]) -> bool {
    const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_MPEG_2);
    let Some((code, checksum)) = boot2.split_last_chunk() else {
        return false;
    };
    CRC.checksum(code) == u32::from_le_bytes(*checksum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_found_by_their_codes() {
        let rom = contents();
        let halfword = |at: usize| u32::from(u16::from_le_bytes([rom[at], rom[at + 1]]));
        let table = halfword(0x14);
        for (code, service) in &CODES[..15] {
            let found = look_up(&rom, table, u16::from_le_bytes(**code).into());
            assert_eq!(found, service.address() | 1);
            let op = halfword(found as usize & !1);
            assert_eq!(op & 0xff00, u32::from(BKPT));
            assert_eq!(Service::at(found & !1, op as u8), Some(*service));
        }
        assert_eq!(look_up(&rom, table, u16::from_le_bytes(*b"XX").into()), 0);
        assert_eq!(look_up(&rom, halfword(0x16), 0x4653), 0, "no data");
        assert_eq!(look_up(&rom, 0x8000, 0x4653), 0);
    }

    #[test]
    fn only_the_roms_breakpoints_are_services() {
        let address = Service::Copy.address();
        assert_eq!(
            Service::at(address, Service::Copy as u8),
            Some(Service::Copy)
        );
        assert_eq!(Service::at(address, Service::Fill as u8), None);
        assert_eq!(Service::at(0x1000_0200, Service::Copy as u8), None);
        assert_eq!(Service::at(address, 0xab), None);
    }

    #[test]
    fn it_has_the_header_of_the_real_one() {
        let rom = contents();
        assert_eq!(rom[0x10..0x14], [b'M', b'u', 1, 3]);
        assert_eq!(rom[0..4], BOOT2_ADDRESS.to_le_bytes());
    }

    #[test]
    fn a_second_stage_has_its_checksum() {
        let mut boot2 = [0; BOOT2_SIZE];
        assert!(!is_second_stage(&boot2));
        assert!(!is_second_stage(&[0xff; BOOT2_SIZE]));
        // Not reflected: the CRC of 252 zero bytes, computed by hand from the definition.
        let mut crc = u32::MAX;
        for _ in 0..252 * 8 {
            crc = crc << 1 ^ if crc >> 31 != 0 { 0x04c1_1db7 } else { 0 };
        }
        boot2[252..].copy_from_slice(&crc.to_le_bytes());
        assert!(is_second_stage(&boot2));
    }
}
