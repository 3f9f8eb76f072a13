//! The controller's memory (RP2040 datasheet 4.1.2.5): setup packet, endpoint and buffer control,
//! data buffers. Processor and controller share it.

use std::fmt;

/// Its size in bytes.
pub(super) const SIZE: usize = 4096;

/// Where the data buffers of endpoint 0 are, for both directions.
const EP0_BUFFER: u32 = 0x100;
/// Distance of the second buffer of an endpoint from its first.
const SECOND_BUFFER: u32 = 64;
/// Behind the last of the control words.
const CONTROL_END: u32 = 0x100;

/// Which way data goes, as the host sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the host.
    In,
    /// To the device.
    Out,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::In => "IN",
            Self::Out => "OUT",
        })
    }
}

/// One of the 32 endpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Endpoint {
    /// Its number, 0 to 15.
    number: u8,
    /// Its direction.
    pub(super) direction: Direction,
}

impl Endpoint {
    /// The endpoint that takes data of control transfers.
    pub(super) const CONTROL_OUT: Self = Self::new(0, Direction::Out);
    /// The endpoint that gives data of control transfers.
    pub(super) const CONTROL_IN: Self = Self::new(0, Direction::In);

    /// Endpoint `number`, modulo 16.
    pub(super) const fn new(number: u8, direction: Direction) -> Self {
        let number = number & 15;
        Self { number, direction }
    }

    /// The endpoint of an [`address`](Self::address).
    pub(super) const fn at(address: u8) -> Self {
        let input = address & 0x80 != 0;
        Self::new(address, if input { Direction::In } else { Direction::Out })
    }

    /// Whether it belongs to the control pipe.
    pub(super) const fn is_control(self) -> bool {
        self.number == 0
    }

    /// Its place in the registers that have a bit for each endpoint, and in both tables.
    const fn index(self) -> u32 {
        self.number as u32 * 2 + matches!(self.direction, Direction::Out) as u32
    }

    /// Its bit in these registers.
    pub(super) const fn mask(self) -> u32 {
        1 << self.index()
    }

    /// As descriptors and requests name it: bit 7 is set for IN.
    pub(super) const fn address(self) -> u8 {
        self.number
            | if matches!(self.direction, Direction::In) {
                0x80
            } else {
                0
            }
    }
}

/// An endpoint's control word (table 388 of the datasheet).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct EndpointControl {
    /// Answers at all.
    pub(super) enabled: bool,
    /// Two buffers take turns.
    pub(super) double_buffered: bool,
    /// Tells of every buffer done.
    pub(super) each_buffer: bool,
    /// Tells of every second buffer done.
    pub(super) each_pair: bool,
    /// Tells of every STALL.
    pub(super) on_stall: bool,
    /// Tells of every NAK.
    pub(super) on_nak: bool,
    /// Where its first buffer is.
    pub(super) buffer: u32,
}

impl EndpointControl {
    const fn of(word: u32) -> Self {
        Self {
            enabled: word & 1 << 31 != 0,
            double_buffered: word & 1 << 30 != 0,
            each_buffer: word & 1 << 29 != 0,
            each_pair: word & 1 << 28 != 0,
            on_stall: word & 1 << 17 != 0,
            on_nak: word & 1 << 16 != 0,
            // Bits 0 to 5 are ignored: buffers are aligned to 64 bytes.
            buffer: word & 0xffc0,
        }
    }

    /// What SIE_CTRL says for endpoint 0, which is always enabled and has fixed buffers.
    pub(super) const fn of_endpoint_0(sie_ctrl: u32) -> Self {
        use super::registers as r;
        Self {
            enabled: true,
            double_buffered: sie_ctrl & r::EP0_DOUBLE_BUF != 0,
            each_buffer: sie_ctrl & r::EP0_INT_1BUF != 0,
            each_pair: sie_ctrl & r::EP0_INT_2BUF != 0,
            on_stall: sie_ctrl & r::EP0_INT_STALL != 0,
            on_nak: sie_ctrl & r::EP0_INT_NAK != 0,
            buffer: EP0_BUFFER,
        }
    }

    /// Where the first or second buffer is.
    pub(super) const fn buffer(&self, second: bool) -> u32 {
        self.buffer + if second { SECOND_BUFFER } else { 0 }
    }
}

/// Buffer control: reply STALL, whichever buffer it is.
pub(super) const STALL: u32 = 1 << 11;
/// Buffer control: begin again with the first buffer.
pub(super) const RESET_SELECT: u32 = 1 << 12;
/// Half of a buffer control word: length of the data.
pub(super) const LENGTH: u32 = 0x3ff;
/// Half of a buffer control word: the controller may use the buffer.
pub(super) const AVAILABLE: u32 = 1 << 10;
/// Half of a buffer control word: DATA1, not DATA0.
pub(super) const PID: u32 = 1 << 13;
/// Half of a buffer control word: the last of a transfer.
pub(super) const LAST: u32 = 1 << 14;
/// Half of a buffer control word: holds data.
pub(super) const FULL: u32 = 1 << 15;

/// The memory. Accesses beyond its end go round.
#[derive(Clone, Debug)]
pub(super) struct Dpram {
    bytes: Box<[u8; SIZE]>,
}

impl Dpram {
    /// Zeroed; on the chip it holds anything after power-up.
    pub(super) fn new() -> Self {
        let bytes = Box::new([0; SIZE]);
        Self { bytes }
    }

    /// Reads N bytes.
    pub(super) fn read<const N: usize>(&self, offset: u32) -> [u8; N] {
        std::array::from_fn(|i| self.bytes[(offset as usize + i) % SIZE])
    }

    /// Writes N bytes. Returns true if what the controller does may depend on them.
    pub(super) fn write<const N: usize>(&mut self, offset: u32, bytes: [u8; N]) -> bool {
        self.store(offset, &bytes);
        (8..CONTROL_END).contains(&(offset % SIZE as u32))
    }

    /// Copies data out of a buffer.
    pub(super) fn load(&self, offset: u32, length: usize) -> Vec<u8> {
        (0..length)
            .map(|i| self.bytes[(offset as usize + i) % SIZE])
            .collect()
    }

    /// Copies data into a buffer.
    pub(super) fn store(&mut self, offset: u32, bytes: &[u8]) {
        for (i, byte) in bytes.iter().enumerate() {
            self.bytes[(offset as usize + i) % SIZE] = *byte;
        }
    }

    /// The control word of an endpoint from 1 on.
    pub(super) fn endpoint_control(&self, endpoint: Endpoint) -> EndpointControl {
        let offset = endpoint.index() * 4;
        EndpointControl::of(u32::from_le_bytes(self.read(offset)))
    }

    /// The buffer control word of an endpoint.
    pub(super) fn buffer_control(&self, endpoint: Endpoint) -> u32 {
        u32::from_le_bytes(self.read(0x80 + endpoint.index() * 4))
    }

    /// Writes it as the controller does.
    pub(super) fn set_buffer_control(&mut self, endpoint: Endpoint, word: u32) {
        self.store(0x80 + endpoint.index() * 4, &word.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_lie_where_the_datasheet_has_them() {
        let mut dpram = Dpram::new();
        assert!(dpram.write(0x8, 0xa000_0180u32.to_le_bytes()));
        assert!(dpram.write(0xc, 0x6003_01ffu32.to_le_bytes()));
        assert!(dpram.write(0x84, 0x0400u16.to_le_bytes()));
        let input = dpram.endpoint_control(Endpoint::new(1, Direction::In));
        assert!(input.enabled && input.each_buffer && !input.double_buffered);
        assert_eq!((input.buffer(false), input.buffer(true)), (0x180, 0x1c0));
        let output = dpram.endpoint_control(Endpoint::new(1, Direction::Out));
        assert!(!output.enabled && output.double_buffered && output.on_nak && output.on_stall);
        assert_eq!(output.buffer(false), 0x1c0, "aligned to 64 bytes");
        assert_eq!(dpram.buffer_control(Endpoint::CONTROL_OUT), AVAILABLE);
        assert_eq!(Endpoint::new(15, Direction::Out).mask(), 1 << 31);
        assert_eq!(Endpoint::new(3, Direction::In).address(), 0x83);
    }

    #[test]
    fn only_control_words_concern_the_controller() {
        let mut dpram = Dpram::new();
        assert!(!dpram.write(0, [0; 8]));
        assert!(!dpram.write(0x100, [1]));
        assert!(dpram.write(0xff, [1]));
    }

    #[test]
    fn memory_goes_round() {
        let mut dpram = Dpram::new();
        dpram.store(0xffe, &[1, 2, 3]);
        assert_eq!(dpram.read(0xffe), [1, 2, 3]);
        assert_eq!(dpram.load(0x1000, 1), [3]);
    }
}
