//! The System Control Space as memory.

use emulated_rp2040::bare::FLASH_START;
use emulated_rp2040::cpu::exception::IRQ0;

use crate::fixture::{Board, handler, op};

const ISER: u32 = 0xe000_e100;
const ICER: u32 = 0xe000_e180;
const ISPR: u32 = 0xe000_e200;
const ICPR: u32 = 0xe000_e280;
const IPR0: u32 = 0xe000_e400;
const ICSR: u32 = 0xe000_ed04;
const AIRCR: u32 = 0xe000_ed0c;

#[test]
fn reset_values() {
    let mut board = Board::new(&[op::LOOP]);
    for (address, value) in [
        (0xe000_e010, 0), // SYST_CSR
        (0xe000_e01c, 0), // SYST_CALIB: not known
        (ISER, 0),
        (ICER, 0),
        (ISPR, 0),
        (ICPR, 0),
        (0xe000_ed00, 0x410c_c601), // CPUID
        (ICSR, 0),
        (0xe000_ed08, FLASH_START), // VTOR, as the boot loader left it
        (AIRCR, 0xfa05_0000),
        (0xe000_ed10, 0),     // SCR
        (0xe000_ed14, 0x208), // CCR
        (0xe000_ed1c, 0),     // SHPR2
        (0xe000_ed20, 0),     // SHPR3
        (0xe000_ed24, 0),     // SHCSR
        (0xe000_ed90, 0),     // MPU_TYPE: none
    ] {
        assert_eq!(board.load(address), value, "{address:x}");
    }
    for register in 0..8 {
        assert_eq!(board.load(IPR0 + 4 * register), 0);
    }
    assert_eq!(board.registers().xpsr(), 1 << 24);
}

#[test]
fn read_only_registers_stay_as_they_are() {
    let mut board = Board::new(&[op::LOOP]);
    for address in [0xe000_ed00, 0xe000_ed14, 0xe000_ed90, 0xe000_e01c] {
        let before = board.load(address);
        board.store(address, !before);
        assert_eq!(board.load(address), before, "{address:x}");
    }
}

#[test]
fn priorities_have_two_bits() {
    let mut board = Board::new(&[op::LOOP]);
    for register in 0..8 {
        board.store(IPR0 + 4 * register, u32::MAX);
        assert_eq!(board.load(IPR0 + 4 * register), 0xc0c0_c0c0);
        board.store(IPR0 + 4 * register, 0x3f7f_bf00);
        assert_eq!(board.load(IPR0 + 4 * register), 0x0040_8000);
    }
    board.store(0xe000_ed1c, u32::MAX);
    assert_eq!(board.load(0xe000_ed1c), 0xc000_0000);
    board.store(0xe000_ed20, u32::MAX);
    assert_eq!(board.load(0xe000_ed20), 0xc0c0_0000);
    assert_eq!(board.load(IPR0), 0x0040_8000, "system priorities are apart");
}

#[test]
fn all_32_interrupts_are_enabled_pended_taken_and_cleared() {
    for n in 0..32 {
        let mut board = Board::new(&[op::LOOP]);
        board.store(ISPR, 1 << n);
        assert_eq!((board.load(ISPR), board.load(ICPR)), (1 << n, 1 << n));
        assert_eq!(board.load(ICSR), 1 << 22, "pending, but not enabled");
        assert_eq!(board.ipsr(), 0);
        board.store(ICPR, 1 << n);
        assert_eq!(board.load(ISPR), 0);
        board.store(ISER, 1 << n);
        assert_eq!((board.load(ISER), board.load(ICER)), (1 << n, 1 << n));
        board.step();
        assert_eq!(board.ipsr(), 0, "it was cleared");
        board.store(ISPR, 1 << n);
        board.step();
        assert_eq!((board.ipsr(), board.pc()), (IRQ0 + n, handler(IRQ0 + n)));
        assert_eq!(board.load(ISPR), 0, "being handled, it is not pending");
        board.step();
        assert_eq!(board.ipsr(), 0);
        board.store(ICER, 1 << n);
        assert_eq!(board.load(ISER), 0);
        board.store(ISPR, 1 << n);
        board.step();
        assert_eq!(board.ipsr(), 0, "it is disabled");
    }
}

#[test]
fn writing_zeros_to_set_and_clear_registers_does_nothing() {
    let mut board = Board::new(&[op::CPSID]);
    board.step();
    board.store(ISER, 0x8000_0001);
    board.store(ISPR, 0x4000_0002);
    for address in [ISER, ICER, ISPR, ICPR] {
        board.store(address, 0);
    }
    assert_eq!(
        (board.load(ISER), board.load(ISPR)),
        (0x8000_0001, 0x4000_0002)
    );
}

#[test]
fn a_line_that_stays_high_interrupts_again_and_again() {
    let mut board = Board::with_interrupts(&[op::NOP, op::LOOP], &[(6, 0)]);
    board.core().set_interrupt_lines(1 << 6);
    for _ in 0..3 {
        board.step();
        assert_eq!((board.ipsr(), board.pc()), (IRQ0 + 6, handler(IRQ0 + 6)));
    }
    board.core().set_interrupt_lines(0);
    board.steps(2);
    assert_eq!(board.ipsr(), 0);
}

#[test]
fn a_reset_request_needs_the_key() {
    let mut board = Board::new(&[op::LOOP]);
    board.store(AIRCR, 1 << 2);
    board.store(AIRCR, 0xfa05_0004);
    board.store(AIRCR, 0x05fa_0000);
    assert!(!board.core().take_reset_request());
    board.store(AIRCR, 0x05fa_0004);
    assert!(board.core().take_reset_request());
    assert!(!board.core().take_reset_request(), "it is taken once");
}
