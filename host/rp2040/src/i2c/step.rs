//! What the master is told to do, and what it is doing.

/// An entry of the transmit FIFO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    pub data: u8,
    pub read: bool,
    pub stop: bool,
    pub restart: bool,
}

impl Command {
    /// As written to IC_DATA_CMD.
    pub const fn new(entry: u32) -> Self {
        Self {
            data: entry as u8,
            read: entry & 1 << 8 != 0,
            stop: entry & 1 << 9 != 0,
            restart: entry & 1 << 10 != 0,
        }
    }
}

/// What the master is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing: the bus is free.
    Idle,
    /// It sends START or a repeated START, and the address.
    Address { read: bool },
    /// Its first bits are not what is on SDA.
    LosingArbitration { pulses: u8 },
    /// It sends or receives a byte.
    Byte { command: Command, first: bool },
    /// It holds SCL low until there is another command.
    Waiting { read: bool },
    /// It sends STOP.
    Stop,
}

impl Step {
    /// Whether it ends by itself.
    pub const fn takes_time(self) -> bool {
        !matches!(self, Self::Idle | Self::Waiting { .. })
    }

    /// Whether an address or a byte is on the way.
    pub const fn sends(self) -> bool {
        matches!(self, Self::Address { .. } | Self::Byte { .. })
    }
}
