//! A bare machine with a vector table, whose handlers return at once unless told otherwise.

use emulated_rp2040::bare::{Bare, FLASH_START, RAM_START};
use emulated_rp2040::cpu::{Core, PC, Registers};

/// Instructions by name.
pub mod op {
    pub const NOP: u16 = 0xbf00;
    pub const WFE: u16 = 0xbf20;
    pub const WFI: u16 = 0xbf30;
    pub const SEV: u16 = 0xbf40;
    /// BX LR
    pub const BX_LR: u16 = 0x4770;
    /// B . (to itself)
    pub const LOOP: u16 = 0xe7fe;
    /// SVC #0
    pub const SVC: u16 = 0xdf00;
    /// UDF #0
    pub const UDF: u16 = 0xde00;
    /// CPSID i
    pub const CPSID: u16 = 0xb672;
    /// CPSIE i
    pub const CPSIE: u16 = 0xb662;
    /// LDR R0, [R1]
    pub const LDR_R0_R1: u16 = 0x6808;
    /// STR R0, [R1]
    pub const STR_R0_R1: u16 = 0x6008;
}

/// Where Thread mode begins.
pub const THREAD: u32 = FLASH_START + 0x100;
/// The main stack at the start.
pub const STACK: u32 = RAM_START + 0x4000;
/// Nothing is here.
pub const NOWHERE: u32 = 0x6000_0000;
/// An instruction kept free for [`Board::load`] and [`Board::store`].
const SPARE: u32 = FLASH_START + 0x200;

/// Where the handler of an exception begins.
pub const fn handler(number: u32) -> u32 {
    FLASH_START + 0x1000 + 0x20 * number
}

pub struct Board(pub Bare);

impl Board {
    /// Thread mode executes `code`.
    pub fn new(code: &[u16]) -> Self {
        let mut board = Self(Bare::new());
        board.poke(FLASH_START, STACK);
        board.poke(FLASH_START + 4, THREAD | 1);
        for number in 2..48 {
            board.poke(FLASH_START + 4 * number, handler(number) | 1);
            board.code(handler(number), &[op::BX_LR]);
        }
        board.code(THREAD, code);
        board.0.reset(FLASH_START);
        board
    }

    /// As [`new`](Self::new), with these interrupts enabled at these priorities.
    pub fn with_interrupts(code: &[u16], interrupts: &[(u32, u32)]) -> Self {
        let mut board = Self::new(code);
        for &(n, priority) in interrupts {
            board.store(0xe000_e100, 1 << n);
            let register = 0xe000_e400 + n / 4 * 4;
            let shift = 8 * (n % 4);
            let others = board.load(register) & !(0xff << shift);
            board.store(register, others | priority << shift);
        }
        board
    }

    pub fn code(&mut self, address: u32, code: &[u16]) {
        let bytes: Vec<u8> = code.iter().flat_map(|op| op.to_le_bytes()).collect();
        self.0.write(address, &bytes).expect("code fits");
    }

    pub fn poke(&mut self, address: u32, word: u32) {
        self.0
            .write(address, &word.to_le_bytes())
            .expect("address in memory");
    }

    pub fn peek(&self, address: u32) -> u32 {
        let bytes = self
            .0
            .read(address, 4)
            .and_then(|bytes| bytes.first_chunk());
        u32::from_le_bytes(*bytes.expect("address in memory"))
    }

    pub fn core(&mut self) -> &mut Core {
        &mut self.0.core
    }

    pub fn registers(&mut self) -> &mut Registers {
        self.0.core.registers_mut()
    }

    pub fn pc(&self) -> u32 {
        self.0.core.pc()
    }

    pub fn ipsr(&self) -> u32 {
        self.0.core.registers().ipsr()
    }

    pub fn step(&mut self) -> u32 {
        self.0.step()
    }

    pub fn steps(&mut self, n: u32) {
        for _ in 0..n {
            self.step();
        }
    }

    /// Executes one instruction out of order, with R0 and R1 as given; returns R0. Nothing else
    /// changes, unless the instruction faults.
    fn execute(&mut self, op: u16, r0: u32, r1: u32) -> u32 {
        self.code(SPARE, &[op]);
        let before = self.registers().clone();
        for (n, value) in [(0, r0), (1, r1), (PC, SPARE)] {
            self.registers().set(n, value);
        }
        self.step();
        let result = self.registers().get(0);
        for n in [0, 1, PC] {
            self.registers().set(n, before.get(n));
        }
        result
    }

    /// LDR from this address.
    pub fn load(&mut self, address: u32) -> u32 {
        self.execute(op::LDR_R0_R1, 0, address)
    }

    /// STR to this address.
    pub fn store(&mut self, address: u32, value: u32) {
        self.execute(op::STR_R0_R1, value, address);
    }
}
