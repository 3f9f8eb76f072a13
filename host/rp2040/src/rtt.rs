//! Log lines by RTT, as a debug probe fetches them: a ring of bytes in the board's RAM, found by its
//! symbol, in which `defmt` has written frames that only make sense together with the ELF file.

use defmt_decoder::{DecodeError, Encoding, Table};

use super::elf::Image;
use super::machine::Machine;

/// The control block's symbol, and what it begins with.
const SYMBOL: &str = "_SEGGER_RTT";
const MAGIC: &[u8] = b"SEGGER RTT";
/// The first up channel, in words from the control block's start.
const BUFFER: u32 = 7;
const SIZE: u32 = 8;
const WRITE: u32 = 9;
const READ: u32 = 10;
/// What ends a frame.
const SEPARATOR: u8 = 0;
/// Bytes of a frame without an end, after which it is thrown away.
const LONGEST_FRAME: usize = 1 << 16;

/// A program whose log lines cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The ELF file's table of lines is damaged, or of a version that is not known.
    #[error("the log lines in this ELF file cannot be read: {0}")]
    Table(String),
    /// The frames are not in the encoding that is defmt's default.
    #[error("the program's log has defmt's encoding `raw`, build it with `rzcobs`, the default")]
    Encoding,
}

/// The log of a program.
#[derive(Debug)]
pub struct Log {
    control_block: u32,
    table: Table,
    /// The beginning of a frame.
    rest: Vec<u8>,
    malformed: u64,
}

impl Log {
    /// The log of the program in this ELF file; `None` if it keeps none.
    ///
    /// # Errors
    /// It has one that cannot be read.
    pub fn new(elf: &[u8], image: &Image) -> Result<Option<Self>, LogError> {
        let table = Table::parse(elf).map_err(|error| LogError::Table(error.to_string()))?;
        let (Some(table), Some(control_block)) = (table, image.symbol(SYMBOL)) else {
            return Ok(None);
        };
        if table.encoding() != Encoding::Rzcobs {
            return Err(LogError::Encoding);
        }
        Ok(Some(Self {
            control_block: control_block.address,
            table,
            rest: Vec::new(),
            malformed: 0,
        }))
    }

    /// Fetches what the program has written since the last time, and gives the lines.
    pub fn lines(&mut self, machine: &mut Machine) -> Vec<String> {
        let bytes = drain(machine, self.control_block).unwrap_or_default();
        self.rest.extend(bytes);
        let Some(end) = self.rest.iter().rposition(|byte| *byte == SEPARATOR) else {
            if self.rest.len() > LONGEST_FRAME {
                self.rest.clear();
                self.malformed += 1;
            }
            return Vec::new();
        };
        let complete: Vec<u8> = self.rest.drain(..=end).collect();
        let mut decoder = self.table.new_stream_decoder();
        decoder.received(&complete);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(frame.display(false).to_string()),
                Err(DecodeError::UnexpectedEof) => return lines,
                Err(DecodeError::Malformed) => self.malformed += 1,
            }
        }
    }

    /// Frames that could not be decoded: a reset cut them off, or the ring was full.
    pub const fn malformed(&self) -> u64 {
        self.malformed
    }
}

/// Takes the bytes out of the ring; `None` if it is not set up.
fn drain(machine: &mut Machine, control_block: u32) -> Option<Vec<u8>> {
    let magic = machine.read(control_block, MAGIC.len())?;
    if magic != MAGIC {
        return None;
    }
    let word = |machine: &Machine, index: u32| {
        let bytes = machine.read(control_block.checked_add(4 * index)?, 4)?;
        Some(u32::from_le_bytes(*bytes.first_chunk()?))
    };
    let [buffer, size, write, read] = [BUFFER, SIZE, WRITE, READ].map(|index| word(machine, index));
    let (buffer, size, write, read) = (buffer?, size?, write?, read?);
    if write >= size || read >= size {
        return None;
    }
    let ring = machine.read(buffer, size as usize)?;
    let (write_at, read_at) = (write as usize, read as usize);
    let bytes = if read_at <= write_at {
        ring[read_at..write_at].to_vec()
    } else {
        [&ring[read_at..], &ring[..write_at]].concat()
    };
    machine
        .write_ram(control_block + 4 * READ, &write.to_le_bytes())
        .ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::RAM;

    const BLOCK: u32 = RAM + 0x100;
    const RING: u32 = RAM + 0x200;

    fn machine(write: u32, read: u32) -> Machine {
        let mut machine = Machine::new(&Image::default(), 0).expect("nothing to fit");
        let words = [0, 0, 0, 0, 1, 0, 0, RING, 8, write, read].map(u32::to_le_bytes);
        machine.write_ram(BLOCK, &words.concat()).expect("in RAM");
        machine.write_ram(BLOCK, b"SEGGER RTT").expect("in RAM");
        machine.write_ram(RING, b"01234567").expect("in RAM");
        machine
    }

    #[test]
    fn the_ring_is_emptied() {
        let mut plain = machine(5, 2);
        assert_eq!(drain(&mut plain, BLOCK).as_deref(), Some(&b"234"[..]));
        assert_eq!(drain(&mut plain, BLOCK).as_deref(), Some(&b""[..]));
        let mut around = machine(2, 6);
        assert_eq!(drain(&mut around, BLOCK).as_deref(), Some(&b"6701"[..]));
        assert_eq!(drain(&mut around, BLOCK).as_deref(), Some(&b""[..]));
    }

    #[test]
    fn a_ring_that_makes_no_sense_is_left_alone() {
        assert_eq!(drain(&mut machine(8, 0), BLOCK), None);
        assert_eq!(drain(&mut machine(0, 9), BLOCK), None);
        assert_eq!(drain(&mut machine(0, 0), BLOCK + 4), None);
        let mut outside = machine(5, 2);
        outside
            .write_ram(BLOCK + 4 * BUFFER, &[0; 4])
            .expect("in RAM");
        assert_eq!(drain(&mut outside, BLOCK), None);
        assert_eq!(drain(&mut outside, u32::MAX), None);
    }

    #[test]
    fn programs_without_a_log_have_none() {
        let error = Log::new(b"no ELF file", &Image::default()).expect_err("no ELF file");
        assert!(matches!(error, LogError::Table(_)), "{error}");
    }
}
