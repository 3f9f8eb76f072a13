//! Entry, return, priorities, tail-chaining.

use emulated_rp2040::bare::{FLASH_START, RAM_START};
use emulated_rp2040::cpu::exception::{HARD_FAULT, IRQ0, NMI, PENDSV, SVCALL, SYSTICK};
use emulated_rp2040::cpu::{FaultCause, Flags, LR, PC, SP};

use crate::fixture::{Board, STACK, THREAD, handler, op};

const ICSR: u32 = 0xe000_ed04;
const SHPR2: u32 = 0xe000_ed1c;
const SHPR3: u32 = 0xe000_ed20;
const TO_HANDLER: u32 = 0xffff_fff1;
const TO_THREAD_MAIN: u32 = 0xffff_fff9;
const TO_THREAD_PROCESS: u32 = 0xffff_fffd;

/// Registers, flags and stack pointer that a frame must bring back.
fn fill_registers(board: &mut Board, sp: u32) {
    for n in 0..13 {
        board.registers().set(n, 0x1000 + n as u32);
    }
    board.registers().set(LR, 0xabcd);
    board.registers().set(SP, sp);
    board.registers().set_flags(Flags {
        n: true,
        z: false,
        c: true,
        v: false,
    });
}

#[test]
fn an_entry_makes_a_frame_and_the_return_takes_it_back() {
    for misalignment in [0, 4] {
        let mut board = Board::with_interrupts(&[op::NOP, op::LOOP], &[(5, 0)]);
        let sp = STACK - misalignment;
        fill_registers(&mut board, sp);
        board.core().pend(IRQ0 + 5);
        assert_eq!(board.step(), 15);
        assert_eq!((board.pc(), board.ipsr()), (handler(IRQ0 + 5), IRQ0 + 5));
        let frame = STACK - 0x20 - 2 * misalignment;
        assert_eq!(board.registers().get(SP), frame, "aligned to 8 bytes");
        assert_eq!(board.registers().get(LR), TO_THREAD_MAIN);
        let stacked: Vec<u32> = (0..8).map(|i| board.peek(frame + 4 * i)).collect();
        let xpsr = 0xa100_0000 | misalignment << 7;
        assert_eq!(
            stacked,
            [0x1000, 0x1001, 0x1002, 0x1003, 0x100c, 0xabcd, THREAD, xpsr]
        );
        for n in [0, 1, 2, 3, 12] {
            board.registers().set(n, 0);
        }
        board.registers().set_flags(Flags::default());
        assert_eq!(board.step(), 13);
        let expected: Vec<u32> = (0x1000..0x100d).chain([sp, 0xabcd, THREAD]).collect();
        let restored: Vec<u32> = (0..16).map(|n| board.registers().get(n)).collect();
        assert_eq!(restored, expected);
        assert_eq!(board.registers().xpsr(), 0xa100_0000);
    }
}

#[test]
fn a_thread_on_the_process_stack_is_stacked_there() {
    // MSR CONTROL, R0; ISB
    let code = [0xf380, 0x8814, 0xf3bf, 0x8f6f, op::NOP, op::LOOP];
    let mut board = Board::with_interrupts(&code, &[(0, 64), (1, 0)]);
    let process = RAM_START + 0x1000;
    board.registers().set_psp(process);
    board.registers().set(0, 2);
    board.steps(2);
    assert_eq!(board.registers().get(SP), process);
    board.core().pend(IRQ0);
    board.step();
    assert_eq!(
        board.registers().get(SP),
        STACK,
        "handlers use the main stack"
    );
    assert_eq!(board.registers().get(LR), TO_THREAD_PROCESS);
    assert_eq!(board.registers().psp(), process - 0x20);
    assert_eq!(
        board.peek(process - 0x20 + 0x18),
        THREAD + 8,
        "the return address"
    );
    assert_eq!(board.registers().control(), 0, "SPSEL is clear in handlers");
    board.core().pend(IRQ0 + 1);
    board.step();
    assert_eq!(board.registers().get(LR), TO_HANDLER);
    assert_eq!(board.registers().get(SP), STACK - 0x20);
    board.steps(2);
    assert_eq!((board.pc(), board.ipsr()), (THREAD + 8, 0));
    assert_eq!(
        (board.registers().msp(), board.registers().psp()),
        (STACK, process)
    );
    assert_eq!(
        (board.registers().get(SP), board.registers().control()),
        (process, 2)
    );
}

#[test]
fn higher_priorities_preempt_and_equal_ones_wait() {
    let priorities = [(0, 192), (1, 128), (2, 64), (3, 64), (4, 0)];
    let mut board = Board::with_interrupts(&[op::LOOP], &priorities);
    let mut seen = Vec::new();
    for n in [0, 1, 3, 2, 4] {
        board.core().pend(IRQ0 + n);
        board.step();
        seen.push(board.ipsr());
    }
    // 2 has the priority of 3, which is being handled: 3 returns at once, and 2 is chained.
    assert_eq!(seen, [IRQ0, IRQ0 + 1, IRQ0 + 3, IRQ0 + 2, IRQ0 + 4]);
    assert_eq!(
        board.registers().get(SP),
        STACK - 4 * 0x20,
        "four are nested"
    );
    let unwound = [(); 4].map(|()| {
        board.step();
        board.ipsr()
    });
    assert_eq!(unwound, [IRQ0 + 2, IRQ0 + 1, IRQ0, 0]);
    assert_eq!((board.pc(), board.registers().get(SP)), (THREAD, STACK));
}

#[test]
fn a_lower_priority_waits_for_the_return() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 64), (1, 128)]);
    board.code(handler(IRQ0), &[op::NOP, op::NOP, op::BX_LR]);
    board.core().pend(IRQ0);
    board.step();
    board.core().pend(IRQ0 + 1);
    board.steps(2);
    assert_eq!((board.ipsr(), board.pc()), (IRQ0, handler(IRQ0) + 4));
    assert_eq!(board.step(), 12, "chained: nothing is stacked or unstacked");
    assert_eq!((board.ipsr(), board.pc()), (IRQ0 + 1, handler(IRQ0 + 1)));
    assert_eq!(board.registers().get(SP), STACK - 0x20);
    assert_eq!(board.registers().get(LR), TO_THREAD_MAIN);
    board.step();
    assert_eq!(
        (board.ipsr(), board.pc(), board.registers().get(SP)),
        (0, THREAD, STACK)
    );
}

#[test]
fn a_more_urgent_late_comer_runs_before_the_first_instruction_of_the_other() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 64), (1, 0)]);
    board.core().pend(IRQ0);
    board.step();
    board.core().pend(IRQ0 + 1);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (IRQ0 + 1, handler(IRQ0 + 1)));
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (IRQ0, handler(IRQ0)));
}

#[test]
fn among_equals_the_lowest_number_is_first() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(7, 64), (30, 64), (31, 0)]);
    board.store(SHPR3, 64 << 16);
    for number in [IRQ0 + 30, IRQ0 + 7, PENDSV, IRQ0 + 31] {
        board.core().pend(number);
    }
    let order = [(); 5].map(|()| {
        board.step();
        board.ipsr()
    });
    assert_eq!(order, [IRQ0 + 31, PENDSV, IRQ0 + 7, IRQ0 + 30, 0]);
}

#[test]
fn primask_masks_what_can_be_masked() {
    let code = [op::CPSID, op::NOP, op::NOP, op::NOP, op::CPSIE, op::LOOP];
    let mut board = Board::with_interrupts(&code, &[(0, 0)]);
    board.step();
    board.core().pend(IRQ0);
    board.core().pend(SYSTICK);
    board.steps(2);
    assert_eq!((board.pc(), board.ipsr()), (THREAD + 6, 0));
    board.core().pend(NMI);
    board.step();
    assert_eq!(board.ipsr(), NMI, "not NMI");
    board.steps(3);
    assert_eq!((board.pc(), board.ipsr()), (THREAD + 10, 0));
    board.step();
    assert_eq!((board.pc(), board.ipsr()), (handler(SYSTICK), SYSTICK));
    board.step();
    assert_eq!(board.ipsr(), IRQ0);
}

#[test]
fn a_supervisor_call_returns_behind_it() {
    let mut board = Board::new(&[op::SVC, op::LOOP]);
    assert_eq!(board.step(), 16);
    assert_eq!((board.ipsr(), board.pc()), (SVCALL, handler(SVCALL)));
    assert_eq!(board.peek(STACK - 8), THREAD + 2);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (0, THREAD + 2));
    assert_eq!(board.core().fault(), None);
}

#[test]
fn a_supervisor_call_within_a_less_urgent_handler_nests() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 64)]);
    board.code(handler(IRQ0), &[op::SVC, op::BX_LR]);
    board.core().pend(IRQ0);
    board.steps(2);
    assert_eq!(board.ipsr(), SVCALL);
    assert_eq!(board.registers().get(LR), TO_HANDLER);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (IRQ0, handler(IRQ0) + 2));
}

#[test]
fn a_supervisor_call_that_cannot_be_taken_is_a_hard_fault() {
    // By a handler of the same priority, and under PRIMASK.
    let mut same = Board::with_interrupts(&[op::LOOP], &[(0, 64)]);
    same.store(SHPR2, 64 << 24);
    same.code(handler(IRQ0), &[op::SVC]);
    same.core().pend(IRQ0);
    let mut masked = Board::new(&[op::CPSID, op::SVC]);
    for (board, at) in [(&mut same, handler(IRQ0)), (&mut masked, THREAD + 2)] {
        board.steps(2);
        assert_eq!(board.ipsr(), HARD_FAULT);
        let frame = board.registers().get(SP);
        assert_eq!(
            board.peek(frame + 0x18),
            at,
            "the frame points at the SVC itself"
        );
        let fault = board.core().fault().expect("a fault");
        assert_eq!(
            (fault.cause, fault.instruction),
            (FaultCause::SupervisorCall, at)
        );
    }
}

#[test]
fn pendsv_and_systick_are_set_and_cleared_by_icsr() {
    for (number, set, clear) in [(PENDSV, 1 << 28, 1 << 27), (SYSTICK, 1 << 26, 1 << 25)] {
        let mut board = Board::new(&[op::CPSID, op::CPSIE, op::LOOP]);
        board.step();
        board.store(ICSR, set);
        assert_eq!(board.load(ICSR), set | number << 12);
        board.store(ICSR, clear);
        assert_eq!(board.load(ICSR), 0);
        board.store(ICSR, set);
        board.steps(2);
        assert_eq!(board.ipsr(), number);
        assert_eq!(board.load(ICSR), number, "VECTACTIVE");
        board.step();
        assert_eq!((board.ipsr(), board.pc()), (0, THREAD + 4));
    }
}

#[test]
fn a_set_of_nmipendset_is_taken_at_once() {
    let mut board = Board::new(&[op::LOOP]);
    board.store(ICSR, 1 << 31);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (NMI, handler(NMI)));
}

#[test]
fn vectors_are_read_where_vtor_points() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(9, 0)]);
    let table = RAM_START + 0x300;
    board.store(0xe000_ed08, table | 0x7f);
    assert_eq!(board.load(0xe000_ed08), table, "256-byte aligned");
    board.poke(table + 4 * (IRQ0 + 9), handler(3) | 1);
    board.core().pend(IRQ0 + 9);
    board.step();
    assert_eq!((board.ipsr(), board.pc()), (IRQ0 + 9, handler(3)));
}

#[test]
fn pop_returns_from_an_exception_too() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 0)]);
    // PUSH {R4, LR}; POP {R4, PC}
    board.code(handler(IRQ0), &[0xb510, 0xbd10]);
    board.core().pend(IRQ0);
    board.step();
    assert_eq!(board.step(), 3);
    assert_eq!(board.step(), 1 + 2 + 13);
    assert_eq!(
        (board.ipsr(), board.pc(), board.registers().get(SP)),
        (0, THREAD, STACK)
    );
}

#[test]
fn a_return_that_fits_no_active_exception_faults() {
    for wrong in [TO_HANDLER, 0xffff_fff5, 0xf000_0001, 0xffff_ffff] {
        let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 0)]);
        board.core().pend(IRQ0);
        board.step();
        board.registers().set(LR, wrong);
        board.step();
        assert_eq!(board.ipsr(), HARD_FAULT, "{wrong:x}");
        let fault = board.core().fault().expect("a fault");
        assert_eq!(fault.cause, FaultCause::ExceptionReturn);
    }
    let mut nested = Board::with_interrupts(&[op::LOOP], &[(0, 64), (1, 0)]);
    nested.core().pend(IRQ0);
    nested.step();
    nested.core().pend(IRQ0 + 1);
    nested.step();
    nested.registers().set(LR, TO_THREAD_MAIN);
    nested.step();
    assert_eq!(
        nested.ipsr(),
        HARD_FAULT,
        "Thread mode cannot be reached from a nested handler"
    );
}

#[test]
fn in_thread_mode_a_return_value_is_an_address() {
    let mut board = Board::new(&[op::BX_LR]);
    board.registers().set(LR, TO_THREAD_MAIN);
    board.step();
    assert_eq!(board.pc(), TO_THREAD_MAIN & !1);
    board.step();
    assert_eq!(
        board.core().fault().expect("a fault").cause,
        FaultCause::Fetch
    );
}

#[test]
fn a_reset_starts_from_the_vector_table() {
    let mut board = Board::with_interrupts(&[op::CPSID, op::LOOP], &[(0, 0)]);
    board.step();
    board.core().pend(IRQ0);
    board.registers().set(PC, handler(2));
    board.0.reset(FLASH_START);
    assert_eq!((board.pc(), board.ipsr()), (THREAD, 0));
    assert_eq!(board.registers().get(SP), STACK);
    assert_eq!(
        (board.registers().primask(), board.registers().control()),
        (false, 0)
    );
    board.step();
    assert_eq!(board.pc(), THREAD + 2, "nothing is pending any more");
}
