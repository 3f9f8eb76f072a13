//! Log lines of [defmt](https://defmt.ferrous-systems.com): frames in RTT's channel 0 that only make
//! sense together with the ELF file. Behind the feature `defmt`.

use defmt_decoder::{DecodeError, Encoding, Table};

use super::elf::Image;
use super::machine::Machine;
use super::rtt::Reader;

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
    reader: Reader,
    table: Table,
    /// The beginning of a frame.
    rest: Vec<u8>,
    malformed: u64,
}

impl Log {
    /// The log of the program in this ELF file; `None` if it has no lines of defmt.
    ///
    /// # Errors
    /// It has lines that cannot be read.
    pub fn new(elf: &[u8], image: &Image) -> Result<Option<Self>, LogError> {
        let table = Table::parse(elf).map_err(|error| LogError::Table(error.to_string()))?;
        let Some(table) = table else {
            return Ok(None);
        };
        if table.encoding() != Encoding::Rzcobs {
            return Err(LogError::Encoding);
        }
        Ok(Some(Self {
            reader: Reader::new(image),
            table,
            rest: Vec::new(),
            malformed: 0,
        }))
    }

    /// Takes what the program has written since the last call, and returns its lines.
    pub fn lines(&mut self, machine: &mut Machine) -> Vec<String> {
        let bytes = self.reader.read(machine);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_elf_file_has_no_log() {
        let error = Log::new(b"no ELF file", &Image::default()).expect_err("no ELF file");
        assert!(matches!(error, LogError::Table(_)), "{error}");
    }
}
