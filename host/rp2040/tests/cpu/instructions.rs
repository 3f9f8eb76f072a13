//! What vectors do not say: cycles, which encodings there are, speed.

use emulated_rp2040::bare::{Bare, RAM_START};
use emulated_rp2040::cpu::{Bus, BusFault, Core, FaultCause, PC, SP};

use crate::fixture::{Board, STACK, THREAD, op};

#[test]
fn cycles_of_the_technical_reference_manual() {
    for (code, cycles, what) in [
        (&[0x0048][..], 1, "LSLS R0, R1, #1"),
        (&[0x4348], 1, "MULS R0, R1"),
        (&[0x4478], 1, "ADD R0, PC"),
        (&[0x4680], 1, "MOV R8, R0"),
        (&[0x468f], 2, "MOV PC, R1"),
        (&[0xd000], 1, "BEQ, not taken"),
        (&[0xd100], 2, "BNE, taken"),
        (&[0xe000], 2, "B"),
        (&[0xf000, 0xf800], 3, "BL"),
        (&[0x4708], 2, "BX R1"),
        (&[0x4788], 2, "BLX R1"),
        (&[0x6808], 2, "LDR R0, [R1]"),
        (&[0x7808], 2, "LDRB R0, [R1]"),
        (&[0x6008], 2, "STR R0, [R1]"),
        (&[0x9000], 2, "STR R0, [SP]"),
        (&[0x4800], 2, "LDR R0, [PC]"),
        (&[0xc901], 2, "LDM R1!, {R0}"),
        (&[0xc9fd], 8, "LDM R1!, 7 registers"),
        (&[0xc1fd], 8, "STM R1!, 7 registers"),
        (&[0xb5ff], 10, "PUSH, 9 registers"),
        (&[0xbcff], 9, "POP, 8 registers"),
        (&[0xbd01], 5, "POP {R0, PC}"),
        (&[0xf3ef, 0x8000], 3, "MRS R0, APSR"),
        (&[0xf380, 0x8800], 3, "MSR APSR, R0"),
        (&[0xf3bf, 0x8f4f], 3, "DSB"),
        (&[0xf3bf, 0x8f5f], 3, "DMB"),
        (&[0xf3bf, 0x8f6f], 3, "ISB"),
        (&[op::CPSID], 1, "CPSID"),
        (&[op::NOP], 1, "NOP"),
        (&[0xbf10], 1, "YIELD"),
        (&[op::SEV], 1, "SEV"),
        (&[op::WFE], 2, "WFE"),
        (&[op::WFI], 2, "WFI"),
    ] {
        let mut board = Board::new(code);
        board.registers().set(1, RAM_START | 0x100);
        board.registers().set(SP, STACK - 0x100);
        assert_eq!(board.step(), cycles, "{what}");
        assert_eq!(board.core().fault(), None, "{what}");
    }
}

/// A bus with a single-cycle port, and one instruction again and again.
struct PortBus([u16; 2]);

impl Bus for PortBus {
    fn read<const N: usize>(&mut self, _: u32) -> Result<[u8; N], BusFault> {
        Ok([0; N])
    }
    fn write<const N: usize>(&mut self, _: u32, _: [u8; N]) -> Result<(), BusFault> {
        Ok(())
    }
    fn fetch(&mut self, address: u32) -> Result<u16, BusFault> {
        Ok(self.0[address as usize / 2 % 2])
    }
    fn access_cycles(&self, address: u32) -> u32 {
        if address >> 28 == 0xd { 1 } else { 2 }
    }
}

#[test]
fn the_single_cycle_port_saves_a_cycle_an_access() {
    // LDR R0, [R1]; STRB R0, [R1]; LDM R1!, {R2 to R5}
    for (op, memory, port) in [(0x6808, 2, 1), (0x7008, 2, 1), (0xc93c, 5, 1)] {
        for (address, cycles) in [(0x2000_0000, memory), (0xd000_0000, port)] {
            let mut core = Core::new();
            core.registers_mut().set(1, address);
            assert_eq!(
                core.step(&mut PortBus([op; 2])),
                cycles,
                "{op:x} at {address:x}"
            );
        }
    }
}

/// Whether A5.2 allocates a 16-bit encoding.
fn is_allocated(op: u16) -> bool {
    match op >> 12 {
        // Miscellaneous 16-bit instructions, by bits 11 to 5
        0b1011 => match op >> 5 & 0x7f {
            0b000_0000..=0b000_0111 => true,         // ADD and SUB (SP)
            0b001_0000..=0b001_0111 => true,         // SXTH, SXTB, UXTH, UXTB
            0b010_0000..=0b010_1111 => true,         // PUSH
            0b011_0011 => op & 15 == 2,              // CPS
            0b101_0000..=0b101_0011 => true,         // REV, REV16
            0b101_0110..=0b101_0111 => true,         // REVSH
            0b110_0000..=0b110_1111 => true,         // POP
            0b111_0000..=0b111_0111 => true,         // BKPT
            0b111_1000..=0b111_1111 => op & 15 == 0, // Hints
            _ => false,
        },
        0b1101 => op >> 8 != 0xde, // UDF
        _ => true,
    }
}

#[test]
fn every_16_bit_encoding_is_an_instruction_or_undefined() {
    for op in 0..0xe800 {
        let mut core = Core::new();
        core.registers_mut().set(PC, 0x100);
        core.step(&mut PortBus([op; 2]));
        let undefined = core
            .fault()
            .is_some_and(|fault| fault.cause == FaultCause::Undefined);
        assert_eq!(undefined, !is_allocated(op), "{op:04x}");
    }
}

#[test]
fn every_32_bit_encoding_is_an_instruction_or_undefined() {
    for first in 0xe800..=0xffff {
        for second in (0..=0xffff).step_by(0x1000).map(|high| high | 0xf4f) {
            let mut core = Core::new();
            core.step(&mut PortBus([first, second]));
            let undefined = core
                .fault()
                .is_some_and(|fault| fault.cause == FaultCause::Undefined);
            let bl = first >> 11 == 0b11110 && second & 0xd000 == 0xd000;
            let control = first >> 11 == 0b11110 && second & 0xd000 == 0x8000;
            let barrier = control && first >> 4 & 0x7f == 0b0111011;
            // SYSm 0x4f is none, so MRS and MSR are undefined here.
            let allocated = bl || barrier;
            assert_eq!(undefined, !allocated, "{first:04x} {second:04x}");
        }
    }
}

#[test]
fn a_program_can_change_itself() {
    // LDR R0, [R1]; STR R0, [R2]; BX R2, into RAM, where a NOP was executed before.
    let mut board = Board::new(&[0x6808, 0x6010, 0x4718]);
    board.poke(RAM_START, 0x4770_bf00); // NOP; BX LR
    board.registers().set(PC, RAM_START);
    board.registers().set(14, THREAD | 1);
    board.steps(2);
    board.poke(RAM_START + 0x10, 0x4770_2007); // MOVS R0, #7; BX LR
    for (n, value) in [(1, RAM_START + 0x10), (2, RAM_START), (3, RAM_START | 1)] {
        board.registers().set(n, value);
    }
    board.steps(4);
    assert_eq!(board.registers().get(0), 7);
}

/// Prints millions of instructions a second:
/// `cargo test --release -p emulated-rp2040 --test cpu -- --ignored --nocapture speed`
#[test]
#[ignore = "measures the machine it runs on"]
fn speed() {
    // loop: LDR R2, [R1]; ADDS R2, R0; STR R2, [R1]; LSRS R3, R2, #3; EORS R3, R0;
    //       ADDS R0, #1; CMP R0, R4; BNE loop
    let code = [
        0x680a, 0x1812, 0x600a, 0x08d3, 0x4043, 0x3001, 0x42a0, 0xd1f7,
    ];
    for (place, start) in [("flash", THREAD), ("RAM", RAM_START + 0x1000)] {
        let mut board = Board::new(&[]);
        board.code(start, &code);
        board.registers().set(PC, start);
        board.registers().set(1, RAM_START + 0x100);
        let instructions = 100_000_000u32;
        let Board(machine) = &mut board;
        let begin = std::time::Instant::now();
        run(machine, instructions);
        let seconds = begin.elapsed().as_secs_f64();
        println!(
            "{:.0} MIPS from {place}",
            f64::from(instructions) / seconds / 1e6
        );
        assert_eq!(machine.core.fault(), None);
    }
}

fn run(machine: &mut Bare, instructions: u32) {
    for _ in 0..instructions {
        machine.step();
    }
}
