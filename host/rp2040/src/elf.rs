//! Reads a linked ARM ELF: what goes where in memory, where it starts, where its symbols are.

use std::collections::BTreeMap;

use object::elf::{EM_ARM, ET_EXEC, FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile, FileHeader as _, ProgramHeader as _};
use object::{LittleEndian, Object as _, ObjectSymbol as _};

/// Why a file cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ElfError {
    /// It is no 32-bit little-endian ELF file, or a damaged one.
    #[error("not a readable 32-bit little-endian ELF file: {0}")]
    Malformed(#[from] object::read::Error),
    /// It ends before its last segment does.
    #[error("an ELF file that is cut off")]
    Truncated,
    /// Its segments hold the same bytes more than once.
    #[error("a damaged ELF file: its segments overlap; build it again")]
    Overlap,
    /// It is for another processor.
    #[error("an ELF file for machine {0}, not for ARM (40)")]
    Machine(u16),
    /// It is an object file or library.
    #[error("an ELF file that is not linked into a program")]
    NotExecutable,
}

/// Bytes that have to be in memory before the program starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The load address (p_paddr): of initialised variables that in flash, from where the
    /// program's start-up code copies them.
    pub address: u32,
    /// Its contents, as far as the file gives them.
    pub bytes: Vec<u8>,
}

/// Highest four bits of addresses in RAM (ARMv6-M, B3.1).
const RAM: u32 = 0x2;

/// What a symbol stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// Its value; bit 0 is set for Thumb functions.
    pub address: u32,
    /// Its size in bytes; 0 if unknown.
    pub size: u32,
}

/// A program.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Address of the first instruction; bit 0 is set for Thumb code.
    pub entry: u32,
    /// What is to be loaded, without empty segments.
    pub segments: Vec<Segment>,
    /// Bytes of RAM that its segments take, without the stack.
    pub ram_bytes: u32,
    pub(crate) symbols: BTreeMap<String, Symbol>,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// [`ElfError`] says what is wrong with it.
    pub fn parse(bytes: &[u8]) -> Result<Self, ElfError> {
        let file = ElfFile::<FileHeader32<LittleEndian>>::parse(bytes)?;
        let endian = LittleEndian;
        let header = file.elf_header();
        let machine = header.e_machine(endian);
        if machine != EM_ARM {
            return Err(ElfError::Machine(machine.0));
        }
        if header.e_type(endian) != ET_EXEC {
            return Err(ElfError::NotExecutable);
        }
        let mut segments = Vec::new();
        let (mut ram_bytes, mut loaded) = (0u32, 0);
        for segment in file.elf_program_headers() {
            let data = segment
                .data(endian, bytes)
                .map_err(|()| ElfError::Truncated)?;
            if segment.p_type(endian) == PT_LOAD && segment.p_vaddr(endian) >> 28 == RAM {
                ram_bytes = ram_bytes.saturating_add(segment.p_memsz(endian));
            }
            if segment.p_type(endian) == PT_LOAD && !data.is_empty() {
                let address = segment.p_paddr(endian);
                // Segments of a damaged file may all claim the whole of it.
                loaded += data.len();
                if loaded > bytes.len() {
                    return Err(ElfError::Overlap);
                }
                segments.push(Segment {
                    address,
                    bytes: data.to_vec(),
                });
            }
        }
        let mut symbols = BTreeMap::new();
        for symbol in file.symbols().filter(|symbol| !symbol.is_undefined()) {
            let (address, size) = (symbol.address() as u32, symbol.size() as u32);
            symbols.insert(symbol.name()?.to_owned(), Symbol { address, size });
        }
        Ok(Self {
            entry: header.e_entry(endian),
            segments,
            ram_bytes,
            symbols,
        })
    }

    /// All symbols, by name.
    pub fn symbols(&self) -> impl Iterator<Item = (&str, Symbol)> {
        let symbols = self.symbols.iter();
        symbols.map(|(name, symbol)| (name.as_str(), *symbol))
    }

    /// The symbol of this name, if the file has one (`_SEGGER_RTT`, say).
    pub fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).copied()
    }

    /// The symbols whose names contain all these parts: mangled names differ from build to build,
    /// but hold the path of what they name.
    pub fn symbols_with<'a>(&'a self, parts: &'a [&str]) -> impl Iterator<Item = Symbol> + 'a {
        let named = |name: &str| parts.iter().all(|part| name.contains(part));
        self.symbols
            .iter()
            .filter(move |(name, _)| named(name))
            .map(|(_, symbol)| *symbol)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file with one segment of eight bytes, and all of them.
    fn file() -> Vec<u8> {
        let mut file = b"\x7fELF\x01\x01\x01".to_vec();
        file.resize(16, 0);
        file.extend([2u16, 40].map(u16::to_le_bytes).concat()); // executable, ARM
        // version, entry, program headers at 52, no section headers, flags
        file.extend(
            [1u32, 0x1000_0101, 52, 0, 0x0500_0000]
                .map(u32::to_le_bytes)
                .concat(),
        );
        // sizes of the headers, and one program header
        file.extend([52u16, 32, 1, 40, 0, 0].map(u16::to_le_bytes).concat());
        // load: offset, virtual and physical address, size in file and memory, flags, alignment
        let load = [1u32, 84, 0x2000_0000, 0x1000_0100, 8, 16, 5, 4];
        file.extend(load.map(u32::to_le_bytes).concat());
        file.extend(*b"contents");
        file
    }

    #[test]
    fn segments_that_all_claim_the_whole_file_are_refused() {
        let mut file = file();
        let headers = file.len() as u32;
        file[28..32].copy_from_slice(&headers.to_le_bytes());
        file[44] = 3;
        let length = headers + 3 * 32;
        for _ in 0..3 {
            let load = [1, 0, 0x1000_0000, 0x1000_0000, length, length, 5, 4];
            file.extend(load.map(u32::to_le_bytes).concat());
        }
        let refused = Image::parse(&file);
        assert!(matches!(refused, Err(ElfError::Overlap)), "{refused:?}");
    }

    #[test]
    fn segments_are_taken_at_their_load_addresses() {
        let image = Image::parse(&file()).expect("a whole file");
        assert_eq!(image.entry, 0x1000_0101);
        let segment = Segment {
            address: 0x1000_0100,
            bytes: b"contents".to_vec(),
        };
        assert_eq!(image.segments, [segment]);
        assert_eq!(image.symbol("_SEGGER_RTT"), None);
    }

    #[test]
    fn other_files_are_refused() {
        let error = |bytes: &[u8]| Image::parse(bytes).expect_err("not a program");
        assert!(matches!(
            error(b"no ELF file at all, but long enough"),
            ElfError::Malformed(_)
        ));
        assert!(matches!(error(&[]), ElfError::Malformed(_)));
        assert!(matches!(error(&file()[..90]), ElfError::Truncated));
        let mut x86 = file();
        x86[18] = 62;
        assert!(matches!(error(&x86), ElfError::Machine(62)));
        let mut object_file = file();
        object_file[16] = 1;
        assert!(matches!(error(&object_file), ElfError::NotExecutable));
        let mut big_endian = file();
        big_endian[5] = 2;
        assert!(matches!(error(&big_endian), ElfError::Malformed(_)));
    }

    #[test]
    fn a_damaged_file_never_panics() {
        let whole = file();
        for place in 0..whole.len() {
            for bit in 0..8 {
                let mut damaged = whole.clone();
                damaged[place] ^= 1 << bit;
                let _ = Image::parse(&damaged);
            }
            let _ = Image::parse(&whole[..place]);
        }
    }
}
