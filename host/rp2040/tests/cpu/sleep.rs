//! WFE, WFI, SEV, SysTick.

use emulated_rp2040::cpu::Activity;
use emulated_rp2040::cpu::exception::{IRQ0, SYSTICK};

use crate::fixture::{Board, THREAD, handler, op};

const SYST_CSR: u32 = 0xe000_e010;
const SYST_RVR: u32 = 0xe000_e014;
const SYST_CVR: u32 = 0xe000_e018;
const SCR: u32 = 0xe000_ed10;

#[test]
fn wfe_uses_up_an_event_or_sleeps() {
    let mut board = Board::new(&[op::SEV, op::WFE, op::WFE, op::NOP]);
    board.steps(2);
    assert_eq!(board.core().activity(), Activity::Running);
    assert_eq!(board.step(), 2);
    assert_eq!((board.step(), board.core().sleeping()), (0, true));
    board.core().set_event();
    assert!(!board.core().sleeping(), "there is a reason to look");
    assert_eq!((board.step(), board.pc()), (1, THREAD + 8));
}

#[test]
fn an_interrupt_wakes_wfe_only_if_it_is_taken() {
    let code = [op::CPSID, op::WFE, op::CPSIE, op::WFE, op::NOP];
    let mut board = Board::with_interrupts(&code, &[(0, 0)]);
    board.steps(2);
    board.core().pend(IRQ0);
    assert_eq!(board.step(), 0, "masked");
    board.core().set_event();
    board.steps(2);
    assert_eq!(
        (board.ipsr(), board.core().activity()),
        (IRQ0, Activity::Running)
    );
    board.steps(2);
    assert_eq!(
        board.core().activity(),
        Activity::Running,
        "the return was an event"
    );
    assert_eq!(board.pc(), THREAD + 8);
}

#[test]
fn a_return_is_an_event_of_its_own() {
    let mut board = Board::with_interrupts(&[op::WFE, op::WFE, op::LOOP], &[(0, 0)]);
    // The handler uses up the event of its entry.
    board.code(handler(IRQ0), &[op::WFE, op::BX_LR]);
    board.core().pend(IRQ0);
    board.steps(4);
    assert_eq!(
        (board.pc(), board.core().activity()),
        (THREAD + 2, Activity::Running)
    );
    board.step();
    assert_eq!(board.core().activity(), Activity::WaitingForEvent);
}

#[test]
fn with_sevonpend_a_disabled_interrupt_is_an_event_once() {
    let mut board = Board::new(&[op::WFE]);
    board.step();
    board.core().set_interrupt_lines(1 << 20);
    assert_eq!(board.step(), 0, "not without SEVONPEND");
    let mut board = Board::new(&[op::WFE, op::WFE, op::NOP]);
    board.store(SCR, 1 << 4);
    board.step();
    board.core().set_interrupt_lines(1 << 20);
    assert_eq!(
        (board.step(), board.pc()),
        (2, THREAD + 4),
        "woken into the second WFE"
    );
    board.core().set_interrupt_lines(1 << 20);
    assert_eq!(board.step(), 0, "it was pending already");
}

#[test]
fn wfi_wakes_for_what_only_primask_masks() {
    let code = [op::CPSID, op::WFI, op::NOP, op::CPSIE, op::LOOP];
    let mut board = Board::with_interrupts(&code, &[(0, 0)]);
    board.steps(2);
    board.core().set_event();
    assert_eq!(board.step(), 0, "an event does not wake WFI");
    board.core().pend(IRQ0 + 1);
    assert_eq!(board.step(), 0, "nor does a disabled interrupt");
    board.core().pend(IRQ0);
    assert_eq!((board.step(), board.pc(), board.ipsr()), (1, THREAD + 6, 0));
    board.steps(2);
    assert_eq!(board.ipsr(), IRQ0);
}

#[test]
fn wfi_in_a_handler_waits_for_something_more_urgent() {
    let mut board = Board::with_interrupts(&[op::LOOP], &[(0, 64), (1, 64), (2, 0)]);
    board.code(handler(IRQ0), &[op::WFI, op::BX_LR]);
    board.core().pend(IRQ0);
    board.steps(2);
    board.core().pend(IRQ0 + 1);
    assert_eq!(board.step(), 0);
    board.core().pend(IRQ0 + 2);
    board.step();
    assert_eq!(board.ipsr(), IRQ0 + 2);
}

#[test]
fn wfi_does_not_sleep_if_an_interrupt_waits() {
    let mut board = Board::with_interrupts(&[op::CPSID, op::WFI, op::NOP], &[(0, 0)]);
    board.core().pend(IRQ0 + 3);
    board.step();
    board.core().set_interrupt_lines(1);
    board.steps(2);
    assert_eq!(
        (board.pc(), board.core().activity()),
        (THREAD + 6, Activity::Running)
    );
}

#[test]
fn with_sleeponexit_thread_mode_does_not_go_on() {
    let mut board = Board::with_interrupts(&[op::NOP, op::NOP], &[(0, 0)]);
    board.store(SCR, 1 << 1 | 1 << 2);
    assert!(board.core().sleep_deep());
    board.core().pend(IRQ0);
    board.steps(2);
    assert_eq!(
        (board.core().activity(), board.ipsr()),
        (Activity::WaitingForInterrupt, 0)
    );
    assert_eq!((board.step(), board.pc()), (0, THREAD));
    board.core().pend(IRQ0);
    board.step();
    assert_eq!(board.ipsr(), IRQ0);
    board.store(SCR, 0);
    board.steps(2);
    assert_eq!(
        (board.pc(), board.core().activity()),
        (THREAD + 2, Activity::Running)
    );
}

/// Starts SysTick on the processor clock, with interrupt.
fn start_systick(board: &mut Board, reload: u32) {
    board.store(SYST_RVR, reload);
    board.store(SYST_CVR, 0);
    board.store(SYST_CSR, 0b111);
}

#[test]
fn systick_comes_every_reload_plus_one_cycles_without_drift() {
    let mut board = Board::new(&[op::LOOP]);
    start_systick(&mut board, 999);
    // The store that started it is counted from its beginning.
    let start = board.0.cycles() - 2;
    for n in 1..=50 {
        while board.ipsr() == 0 {
            board.step();
        }
        let taken = board.0.cycles() - 15 - start;
        assert!((1000 * n..1000 * n + 2).contains(&taken), "{n}: {taken}");
        board.step();
    }
}

#[test]
fn sleep_can_be_skipped_to_the_cycle() {
    // WFI; B to it
    let mut board = Board::new(&[op::WFI, 0xe7fd]);
    start_systick(&mut board, 12_499);
    for _ in 0..20 {
        while !board.core().sleeping() {
            board.step();
        }
        let nap = board.core().cycles_to_systick().expect("SysTick runs");
        board.core().idle(nap - 1);
        assert_eq!(board.step(), 0);
        board.core().idle(1);
        assert_eq!((board.step(), board.ipsr()), (15, SYSTICK));
        assert_eq!(board.load(SYST_CVR), 12_500 - 15);
    }
}

#[test]
fn systick_counts_the_reference_clock_if_told_to() {
    let mut board = Board::new(&[op::LOOP]);
    board.store(SYST_RVR, 99);
    board.store(SYST_CSR, 0b011);
    board.steps(1_000);
    assert_eq!((board.ipsr(), board.core().cycles_to_systick()), (0, None));
    assert_eq!(board.core().reference_ticks_to_systick(), Some(100));
    board.core().tick_reference(99);
    board.step();
    assert_eq!(board.ipsr(), 0);
    board.core().tick_reference(1);
    board.step();
    assert_eq!(board.ipsr(), SYSTICK);
}

#[test]
fn countflag_is_cleared_by_reading_and_by_writing_the_counter() {
    let mut board = Board::new(&[op::LOOP]);
    board.store(SYST_RVR, 9);
    board.store(SYST_CSR, 0b101);
    board.steps(10);
    assert_eq!(board.load(SYST_CSR), 0x0001_0005);
    assert_eq!(board.load(SYST_CSR) >> 16, 0);
    board.steps(10);
    board.store(SYST_CVR, 55);
    assert_eq!(board.load(SYST_CSR) >> 16, 0);
    assert_eq!(board.ipsr(), 0, "no interrupt without TICKINT");
}
