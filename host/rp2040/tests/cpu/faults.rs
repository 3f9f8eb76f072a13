//! HardFault, what it finds, and lockup.

use emulated_rp2040::bare::{FLASH_START, RAM_START};
use emulated_rp2040::cpu::exception::{HARD_FAULT, IRQ0, NMI};
use emulated_rp2040::cpu::{Activity, FaultCause, LR, PC, SP};

use crate::fixture::{Board, NOWHERE, STACK, THREAD, handler, op};

/// Executes `code` once with R1 as given; returns the registers R0 to R7 and SP before and after, the
/// cause and the address.
fn fault_of(code: &[u16], r1: u32) -> (FaultCause, Option<u32>) {
    let mut board = Board::new(code);
    for n in 0..8 {
        board.registers().set(n, 0x100 + n as u32);
    }
    board.registers().set(1, r1);
    let before: Vec<u32> = (0..13).map(|n| board.registers().get(n)).collect();
    board.step();
    assert_eq!(handling(&mut board), Some(HARD_FAULT), "{code:x?}");
    let after: Vec<u32> = (0..13).map(|n| board.registers().get(n)).collect();
    assert_eq!(after, before, "{code:x?} leaves the registers alone");
    assert_eq!(
        board.registers().get(SP),
        STACK - 0x20,
        "{code:x?} leaves SP alone"
    );
    assert_eq!(
        board.peek(STACK - 8),
        THREAD,
        "{code:x?} is where the frame points"
    );
    let fault = board.core().fault().expect("a fault");
    assert_eq!(fault.instruction, THREAD);
    (fault.cause, fault.address)
}

/// The exception in whose handler the core locked up.
fn locked_up_in(board: &mut Board) -> Option<u32> {
    (board.core().activity() == Activity::Lockup).then(|| board.ipsr())
}

/// The exception whose handler begins.
fn handling(board: &mut Board) -> Option<u32> {
    let exception = board.ipsr();
    (board.pc() == handler(exception)).then_some(exception)
}

#[test]
fn loads_and_stores_where_nothing_is() {
    // LDR, LDRH, LDRB, LDRSB (R1 + R2), STR, STRH, STRB of R0 at R1; LDM R1!, STM R1!
    for op in [
        0x6808, 0x8808, 0x7808, 0x6008, 0x8008, 0x7008, 0xc90d, 0xc10d,
    ] {
        assert_eq!(
            fault_of(&[op], NOWHERE),
            (FaultCause::Bus, Some(NOWHERE)),
            "{op:x}"
        );
    }
    assert_eq!(
        fault_of(&[0x5688], NOWHERE),
        (FaultCause::Bus, Some(NOWHERE + 0x102))
    );
}

#[test]
fn stores_to_flash() {
    assert_eq!(
        fault_of(&[op::STR_R0_R1], THREAD),
        (FaultCause::Bus, Some(THREAD))
    );
}

#[test]
fn unaligned_accesses() {
    for (op, misaligned) in [
        (0x6808, 1),
        (0x6808, 2),
        (0x8808, 1),
        (0x6008, 2),
        (0x8008, 1),
    ] {
        let address = RAM_START + misaligned;
        assert_eq!(
            fault_of(&[op], address),
            (FaultCause::Unaligned, Some(address))
        );
    }
    // LDM R1!, {R0}; STM R1!, {R0}
    for op in [0xc901, 0xc101] {
        assert_eq!(
            fault_of(&[op], RAM_START + 2),
            (FaultCause::Unaligned, Some(RAM_START + 2))
        );
    }
}

#[test]
fn a_multiple_load_that_faults_half_way_changes_nothing() {
    let last_word = RAM_START + (264 << 10) - 4;
    // LDM R1!, {R0, R2, R3}
    let expected = (FaultCause::Bus, Some(last_word + 4));
    assert_eq!(fault_of(&[0xc90d], last_word), expected);
    // POP {R0, R2, PC} with the stack at the end of the RAM
    let mut board = Board::new(&[0xbd05]);
    board.registers().set(SP, last_word);
    board.registers().set(0, 7);
    board.step();
    assert_eq!((board.ipsr(), board.registers().get(0)), (HARD_FAULT, 7));
    assert_eq!(
        board.registers().get(SP),
        last_word - 0x24,
        "aligned down by 4 for the frame"
    );
}

#[test]
fn instructions_that_are_none() {
    assert_eq!(fault_of(&[op::UDF], 0), (FaultCause::Undefined, None));
    // UDF.W #0, and an encoding of ARMv7-M: MOV.W R0, #0
    assert_eq!(
        fault_of(&[0xf7f0, 0xa000], 0),
        (FaultCause::Undefined, None)
    );
    assert_eq!(
        fault_of(&[0xf04f, 0x0000], 0),
        (FaultCause::Undefined, None)
    );
    assert_eq!(fault_of(&[0xbe00], 0), (FaultCause::Breakpoint, None));
}

#[test]
fn code_that_is_not_there_or_not_thumb() {
    // BX R1
    let mut board = Board::new(&[0x4708]);
    board.registers().set(1, NOWHERE | 1);
    board.steps(2);
    let fault = board.core().fault().expect("a fault");
    assert_eq!(
        (fault.cause, fault.instruction),
        (FaultCause::Fetch, NOWHERE)
    );
    let mut board = Board::new(&[0x4708]);
    board.registers().set(1, handler(5));
    board.steps(2);
    let fault = board.core().fault().expect("a fault");
    assert_eq!(
        (fault.cause, fault.instruction),
        (FaultCause::NotThumb, handler(5))
    );
    assert_eq!(
        board.peek(STACK - 4) >> 24 & 1,
        0,
        "EPSR.T is stacked as it was"
    );
}

#[test]
fn a_vector_without_thumb_bit() {
    let mut board = Board::new(&[op::SVC]);
    board.poke(FLASH_START + 4 * 11, handler(11));
    board.steps(2);
    assert_eq!(board.ipsr(), HARD_FAULT);
    assert_eq!(
        board.core().fault().expect("a fault").cause,
        FaultCause::NotThumb
    );
}

#[test]
fn a_hard_fault_handler_can_return_behind_the_instruction() {
    let mut board = Board::new(&[op::UDF, op::LOOP]);
    board.step();
    board.poke(STACK - 8, THREAD + 2);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (0, THREAD + 2));
}

#[test]
fn the_second_fault_locks_up() {
    let mut in_hard_fault = Board::new(&[op::UDF]);
    in_hard_fault.code(handler(HARD_FAULT), &[op::UDF]);
    let mut by_supervisor_call = Board::new(&[op::UDF]);
    by_supervisor_call.code(handler(HARD_FAULT), &[op::SVC]);
    let mut in_nmi = Board::new(&[op::LOOP]);
    in_nmi.core().pend(NMI);
    in_nmi.code(handler(NMI), &[op::LDR_R0_R1]);
    in_nmi.registers().set(1, NOWHERE);
    for board in [&mut in_hard_fault, &mut by_supervisor_call, &mut in_nmi] {
        board.steps(2);
        assert_eq!(board.core().activity(), Activity::Lockup);
        assert_eq!(board.pc(), 0xffff_fffe);
        board.core().pend(IRQ0);
        assert_eq!(board.step(), 0, "time stands still");
        assert_eq!(board.core().activity(), Activity::Lockup);
    }
    // An NMI gets through to a core locked up at HardFault's priority, which stays locked up.
    in_hard_fault.core().pend(NMI);
    in_hard_fault.step();
    assert_eq!(
        (in_hard_fault.ipsr(), in_hard_fault.pc()),
        (NMI, handler(NMI))
    );
    in_hard_fault.steps(2);
    assert_eq!(in_hard_fault.core().activity(), Activity::Lockup);
    in_nmi.core().pend(NMI);
    assert_eq!(in_nmi.step(), 0);
}

#[test]
fn a_frame_that_cannot_be_written_is_a_hard_fault() {
    // The vector table is of use even if the stack is not: the HardFault takes the frame's place.
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 0)]);
    board.registers().set(SP, NOWHERE);
    board.core().pend(IRQ0);
    board.step();
    assert_eq!(handling(&mut board), Some(HARD_FAULT));
    assert_eq!(
        board.core().fault().expect("a fault").cause,
        FaultCause::Stacking
    );
    assert_ne!(board.load(0xe000_e200) & 1, 0, "the interrupt still waits");
    // A fault whose own frame fails is the end.
    let mut board = Board::new(&[op::UDF]);
    board.registers().set(SP, NOWHERE);
    board.step();
    assert_eq!(locked_up_in(&mut board), Some(HARD_FAULT));
}

#[test]
fn a_frame_of_an_nmi_that_cannot_be_written() {
    let mut board = Board::new(&[op::LOOP]);
    board.registers().set(SP, NOWHERE);
    board.core().pend(NMI);
    board.step();
    assert_eq!(handling(&mut board), Some(NMI), "NMI is the more urgent");
    board.step();
    assert_eq!(handling(&mut board), Some(HARD_FAULT), "it waited");
    // On the way from HardFault to NMI it is the end, at NMI's priority.
    board.registers().set(SP, NOWHERE);
    board.core().pend(NMI);
    board.step();
    assert_eq!(locked_up_in(&mut board), Some(NMI));
}

#[test]
fn a_frame_that_cannot_be_read_is_a_hard_fault() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 0)]);
    board.core().pend(IRQ0);
    board.step();
    board.registers().set(SP, NOWHERE);
    board.step();
    assert_eq!(handling(&mut board), Some(HARD_FAULT));
    assert_eq!(
        board.registers().get(LR),
        0xffff_fff9,
        "the return is what failed"
    );
    assert_eq!(
        board.core().fault().expect("a fault").cause,
        FaultCause::Unstacking
    );
}

#[test]
fn a_frame_that_cannot_be_read_on_the_way_from_nmi_to_hard_fault_is_the_end() {
    let mut board = Board::new(&[op::UDF]);
    board.step();
    board.core().pend(NMI);
    board.step();
    board.registers().set(SP, NOWHERE);
    board.step();
    assert_eq!(locked_up_in(&mut board), Some(HARD_FAULT));
}

#[test]
fn a_vector_table_that_is_not_there() {
    let mut board = Board::new(&[op::SVC]);
    board.store(0xe000_ed08, NOWHERE);
    board.step();
    assert_eq!(
        board.core().activity(),
        Activity::Lockup,
        "HardFault has no vector either"
    );
    board.0.reset(NOWHERE);
    assert_eq!(board.core().activity(), Activity::Lockup);
    board.0.reset(FLASH_START);
    assert_eq!(board.core().activity(), Activity::Running);
}

#[test]
fn unprivileged_code_has_no_access_to_the_system() {
    // MSR CONTROL, R0; CPSID i; MSR PRIMASK, R0; MRS R2, PRIMASK; MRS R3, MSP; MRS R4, CONTROL;
    // LDR R0, [R1]
    let code = [
        0xf380,
        0x8814,
        op::CPSID,
        0xf380,
        0x8810,
        0xf3ef,
        0x8210,
        0xf3ef,
        0x8308,
        0xf3ef,
        0x8414,
        op::LDR_R0_R1,
    ];
    let mut board = Board::new(&code);
    board.registers().set(0, 1);
    board.registers().set(1, 0xe000_ed00);
    board.registers().set(3, 0x123);
    board.steps(3);
    assert!(!board.registers().primask());
    board.registers().set_primask(true);
    board.steps(3);
    board.registers().set_primask(false);
    let seen: Vec<u32> = (2..5).map(|n| board.registers().get(n)).collect();
    assert_eq!(seen, [0, 0, 1]);
    board.step();
    assert_eq!(board.ipsr(), HARD_FAULT);
    let fault = board.core().fault().expect("a fault");
    assert_eq!(
        (fault.cause, fault.address),
        (FaultCause::Bus, Some(0xe000_ed00))
    );
    assert!(board.registers().privileged(), "handlers are privileged");
    board.registers().set(PC, THREAD + 4);
    board.step();
    assert!(board.registers().primask());
}

#[test]
fn the_system_control_space_takes_words_only() {
    for op in [0x7808, 0x8808, 0x7008, 0x8008] {
        let csr = 0xe000_e010;
        assert_eq!(fault_of(&[op], csr), (FaultCause::Bus, Some(csr)));
    }
}
