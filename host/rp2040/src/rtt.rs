//! RTT (SEGGER's Real-Time Transfer), as a debug probe reads it: a ring of bytes in the RAM, which
//! the program fills and the probe empties.
//!
//! The control block begins with `SEGGER RTT`; from its word 6 on follow the up channels, six words
//! each: name, buffer, size, write offset, read offset, flags. The first one is read here.

use super::elf::Image;
use super::machine::Machine;
use super::memory::{RAM, RAM_SIZE};

/// The control block's symbol, and what it begins with.
const SYMBOL: &str = "_SEGGER_RTT";
const MAGIC: &[u8] = b"SEGGER RTT";
/// The first up channel, in words from the control block's start.
const BUFFER: u32 = 7;
const SIZE: u32 = 8;
const WRITE: u32 = 9;
const READ: u32 = 10;

/// Reads up channel 0 of a program.
///
/// ```
/// # use emulated_rp2040::{Machine, elf::Image, peripheral::CYCLES_PER_MICROSECOND, rtt::Reader};
/// let image = Image::parse(&std::fs::read("tests/data/blink.elf")?)?;
/// let mut machine = Machine::new(&image, 0)?;
/// let mut rtt = Reader::new(&image);
/// machine.run_until(700_000 * CYCLES_PER_MICROSECOND);
/// assert_eq!(rtt.lines(&mut machine), ["LED on", "LED off"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Reader {
    /// Where the control block is; `None` until it was found.
    control_block: Option<u32>,
    /// The beginning of a line.
    line: Vec<u8>,
}

impl Reader {
    /// For this program. Its control block is found by the symbol `_SEGGER_RTT`, or in a program
    /// without symbols by searching the RAM.
    pub fn new(image: &Image) -> Self {
        Self {
            control_block: image.symbol(SYMBOL).map(|symbol| symbol.address),
            line: Vec::new(),
        }
    }

    /// Takes all bytes that the program has written since the last call; none as long as it has not
    /// set the channel up.
    pub fn read(&mut self, machine: &mut Machine) -> Vec<u8> {
        if self.control_block.is_none() {
            self.control_block = search(machine);
        }
        let drained = self.control_block.and_then(|at| drain(machine, at));
        drained.unwrap_or_default()
    }

    /// [`read`](Self::read) as text: the lines that have ended. Bytes that are no UTF-8 are replaced.
    pub fn lines(&mut self, machine: &mut Machine) -> Vec<String> {
        let bytes = self.read(machine);
        self.line.extend(bytes);
        let end = self.line.iter().rposition(|byte| *byte == b'\n');
        let ended: Vec<u8> = self.line.drain(..end.map_or(0, |end| end + 1)).collect();
        let text = String::from_utf8_lossy(&ended);
        text.lines().map(str::to_owned).collect()
    }
}

/// The address of a control block in the RAM.
fn search(machine: &Machine) -> Option<u32> {
    let words = machine.read(RAM, RAM_SIZE)?.chunks(4).enumerate();
    let starts = words.filter(|(_, word)| MAGIC.starts_with(word));
    let mut addresses = starts.map(|(i, _)| RAM + 4 * i as u32);
    addresses.find(|at| machine.read(*at, MAGIC.len()) == Some(MAGIC))
}

/// Takes the bytes out of the ring; `None` if it is not set up.
fn drain(machine: &mut Machine, control_block: u32) -> Option<Vec<u8>> {
    let magic = machine.read(control_block, MAGIC.len())?;
    if magic != MAGIC {
        return None;
    }
    let word = |index: u32| {
        let bytes = machine.read(control_block.checked_add(4 * index)?, 4)?;
        Some(u32::from_le_bytes(*bytes.first_chunk()?))
    };
    let (buffer, size, write, read) = (word(BUFFER)?, word(SIZE)?, word(WRITE)?, word(READ)?);
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

    const BLOCK: u32 = RAM + 0x100;
    const RING: u32 = RAM + 0x200;

    fn machine(write: u32, read: u32) -> Machine {
        let mut machine = Machine::new(&Image::default(), 0).expect("nothing to fit");
        let words = [0, 0, 0, 0, 1, 0, 0, RING, 8, write, read].map(u32::to_le_bytes);
        machine.write_ram(BLOCK, &words.concat()).expect("in RAM");
        machine.write_ram(BLOCK, MAGIC).expect("in RAM");
        machine.write_ram(RING, b"01\n34567").expect("in RAM");
        machine
    }

    fn write_to(machine: &mut Machine, write: u32) {
        let at = BLOCK + 4 * WRITE;
        machine.write_ram(at, &write.to_le_bytes()).expect("in RAM");
    }

    #[test]
    fn the_ring_is_emptied() {
        let mut plain = machine(5, 2);
        assert_eq!(drain(&mut plain, BLOCK).as_deref(), Some(&b"\n34"[..]));
        assert_eq!(drain(&mut plain, BLOCK).as_deref(), Some(&b""[..]));
        let mut around = machine(2, 6);
        assert_eq!(drain(&mut around, BLOCK).as_deref(), Some(&b"6701"[..]));
        assert_eq!(drain(&mut around, BLOCK).as_deref(), Some(&b""[..]));
    }

    #[test]
    fn without_a_symbol_the_block_is_searched_for() {
        let mut machine = machine(2, 6);
        let mut reader = Reader::new(&Image::default());
        assert_eq!(reader.read(&mut machine), b"6701");
        machine.write_ram(BLOCK, &[0; 4]).expect("in RAM");
        let mut reader = Reader::new(&Image::default());
        assert_eq!(reader.read(&mut machine), b"");
        machine.write_ram(BLOCK, MAGIC).expect("in RAM");
        write_to(&mut machine, 4);
        assert_eq!(reader.read(&mut machine), b"\n3", "it was set up meanwhile");
    }

    #[test]
    fn lines_come_when_they_have_ended() {
        let mut machine = machine(2, 6);
        let mut reader = Reader::new(&Image::default());
        assert_eq!(reader.lines(&mut machine), [""; 0]);
        write_to(&mut machine, 4);
        assert_eq!(reader.lines(&mut machine), ["6701"]);
        machine.write_ram(RING, b"\xff\n\n").expect("in RAM");
        write_to(&mut machine, 3);
        assert_eq!(reader.lines(&mut machine), ["34567\u{fffd}", ""]);
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
}
