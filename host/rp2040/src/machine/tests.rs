//! Small programs, in the place of the second stage: the boot ROM copies them to RAM and starts them.

use super::*;
use crate::boot_rom::{BOOT2_ADDRESS, BOOT2_SIZE};
use crate::bus::{Boot, FLASH};
use crate::cpu::FaultCause;
use crate::elf::{Image, Segment};
use crate::incident::{Incident, Kind};
use crate::peripheral::Cycles;
use crate::pins::Output;

/// A machine with this program.
fn machine(code: &[u16]) -> Machine {
    let mut bytes: Vec<u8> = code.iter().flat_map(|op| op.to_le_bytes()).collect();
    bytes.resize(BOOT2_SIZE - 4, 0);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_MPEG_2).checksum(&bytes);
    bytes.extend(crc.to_le_bytes());
    let mut image = Image::default();
    image.segments.push(Segment {
        address: FLASH,
        bytes,
    });
    Machine::new(&image, 0).expect("it fits")
}

/// What the boot ROM takes before the program starts, and some more.
const STARTED: Cycles = 10_000;

fn kinds(machine: &Machine) -> Vec<Kind> {
    let incidents: &[Incident] = machine.incidents().first();
    incidents.iter().map(|incident| incident.kind).collect()
}

#[test]
fn without_a_program_it_sleeps() {
    let mut machine = Machine::new(&Image::default(), 0).expect("nothing to fit");
    machine.run_until(1_000_000_000);
    assert_eq!(machine.boot(), Boot::NoProgram);
    assert_eq!(machine.now(), 1_000_000_000);
    assert!(machine.load().busy < STARTED);
    assert_eq!(machine.stack_high_water(), None);
}

#[test]
fn programs_have_to_fit() {
    let mut image = Image::default();
    let segment = |address| Segment {
        address,
        bytes: vec![0; 8],
    };
    image.segments.push(segment(0x1020_0000 - 4));
    let error = Machine::new(&image, 0).expect_err("half outside");
    assert_eq!((error.address, error.size), (0x101f_fffc, 8));
    image.segments[0] = segment(0x2000_0000);
    assert!(Machine::new(&image, 0).is_err());
}

#[test]
fn a_program_runs_and_counts_as_busy() {
    // B .
    let mut machine = machine(&[0xe7fe]);
    machine.run_until(STARTED);
    assert_eq!(machine.boot(), Boot::Started);
    assert_eq!(machine.core().pc(), BOOT2_ADDRESS);
    let before = machine.load();
    machine.run_until(STARTED + 1_000);
    let load = machine.load().since(before);
    assert!(load.busy >= 998 && load.idle == 0, "{load:?}");
    assert_eq!(load.share(), 1.0);
}

#[test]
fn systick_wakes_a_core_that_sleeps() {
    // MOV R1, PC; ADDS R1, #20 (the table); LDM R1!, {R0, R2, R3}; STR R2, [R0, #4] (reload);
    // STR R3, [R0] (on); WFI; NOP; B to WFI; NOP
    let code = |control: u16| {
        [
            0x4679, 0x3110, 0xc90d, 0x6042, 0x6003, 0xbf30, 0xe7fd, 0xbf00, 0xbf00,
            0xbf00, // table at 20
            0xe010, 0xe000, 0x03e7, 0, control, 0,
        ]
    };
    for (control, period) in [(7, 1_000), (3, 125_000)] {
        let mut machine = machine(&code(control));
        // A tick each microsecond, for the reference clock.
        machine.run_until(STARTED);
        machine
            .peripherals_mut()
            .write(0x4005_802c, 0x200 | 12, STARTED);
        // The exception has no handler but the ROM's, which is at 0: it faults, and that is noted.
        machine.run_until(STARTED + 2 * period + 4_000);
        assert_eq!(kinds(&machine).len(), 1, "{control}");
        let at = machine.incidents().first()[0].at;
        assert!((period..=STARTED + period + 500).contains(&at), "{at}");
        assert!(machine.load().idle > period / 2);
    }
}

#[test]
fn a_reset_that_the_program_asks_for_starts_it_again() {
    // MOV R1, PC; LDR R0, [R1, #12]; LDR R2, [R1, #16]; STR R2, [R0]; B .
    let code = [
        0x4679, 0x68c8, 0x690a, 0x6002, 0xe7fe, 0xbf00, 0xbf00, 0xbf00, // table at 16
        0xed0c, 0xe000, 0x0004, 0x05fa,
    ];
    let mut machine = machine(&code);
    machine.run_until(4 * STARTED);
    let kinds = kinds(&machine);
    assert!(kinds.len() >= 3, "{kinds:?}");
    assert!(kinds.iter().all(|kind| *kind == Kind::Requested));
}

#[test]
fn faults_are_noted() {
    // UDF
    let mut machine = machine(&[0xde00]);
    machine.run_until(STARTED);
    let [Kind::HardFault(fault)] = kinds(&machine)[..] else {
        panic!("{:?}", machine.incidents());
    };
    assert_eq!(fault.cause, FaultCause::Undefined);
    assert_eq!(fault.instruction, BOOT2_ADDRESS);
}

#[test]
fn without_power_only_the_time_goes_on() {
    // MOVS R0, #0; ADDS R0, #1; B to ADDS
    let mut machine = machine(&[0x2000, 0x3001, 0xe7fd]);
    machine.run_until(STARTED);
    machine.write_ram(0x2000_0000, &[1, 2, 3, 4]).expect("RAM");
    machine.power_off();
    let (load, count) = (machine.load(), machine.core().registers().get(0));
    assert!(count > 100);
    machine.run_until(1_000_000);
    assert_eq!((machine.now(), machine.load()), (1_000_000, load));
    assert!(!machine.powered());
    machine.power_on();
    machine.power_on();
    assert_ne!(machine.read(0x2000_0000, 4), Some(&[1, 2, 3, 4][..]));
    machine.run_until(1_000_000 + STARTED);
    let anew = machine.core().registers().get(0);
    assert!((1..=count).contains(&anew), "{anew}");
    assert_eq!(kinds(&machine), [Kind::PowerLost]);
}

#[test]
fn a_stalled_core_does_nothing() {
    let mut machine = machine(&[0x2000, 0x3001, 0xe7fd]);
    machine.run_until(STARTED);
    let count = machine.core().registers().get(0);
    machine.stall(1_000_000);
    machine.run_until(STARTED + 1_000_000);
    assert_eq!(machine.core().registers().get(0), count);
    machine.run_until(STARTED + 1_001_000);
    assert!(machine.core().registers().get(0) > count);
}

#[test]
fn a_program_that_hangs_hangs() {
    let mut machine = machine(&[0x2000, 0x3001, 0xe7fd]);
    machine.run_until(STARTED);
    assert!(machine.hang());
    let count = machine.core().registers().get(0);
    machine.run_until(2 * STARTED);
    assert_eq!(machine.core().registers().get(0), count);
    machine.power_off();
    assert!(!machine.hang());
}

#[test]
fn probes_measure_calls() {
    // BL +4; B back to it; NOP (skipped); function at 8: MOVS R0, #3; SUBS R0, #1; BNE; BX LR
    let code = [
        0xf000, 0xf802, 0xe7fc, 0xbf00, 0x2003, 0x3801, 0xd1fd, 0x4770,
    ];
    let mut machine = machine(&code);
    let probe = machine.add_probe((BOOT2_ADDRESS + 8) | 1);
    machine.run_until(2 * STARTED);
    let calls = machine.probe(probe).calls();
    assert!(calls.len() > 100);
    // 1 + 3 SUBS + 2 BNE taken + 1 not taken + BX
    assert!(
        calls
            .iter()
            .all(|call| call.cycles() == 1 + 3 + 2 * 2 + 1 + 2)
    );
    assert_eq!(calls.len() as u64, machine.probe(probe).count());
    machine.remove_probes();
    machine.run_until(3 * STARTED);
}

#[test]
fn pins_can_be_held_from_outside() {
    // MOV R1, PC; LDR R0, [R1, #4] (SIO); LDR R2, [R0, #4] (GPIO_IN); B to LDR
    let code = [0x4679, 0x6848, 0x6842, 0xe7fd, 0x0000, 0xd000];
    let mut machine = machine(&code);
    machine.run_until(STARTED);
    // Pads come out of reset.
    machine.peripherals_mut().write(0x4000_c000, 0, STARTED);
    for (level, bit) in [(Some(true), 1 << 9), (Some(false), 0), (None, 0)] {
        machine.set_input(9, level);
        machine.run_until(machine.now() + 100);
        assert_eq!(machine.core().registers().get(2) & 1 << 9, bit, "{level:?}");
    }
    assert_eq!(machine.output(9), Output::Floating);
}
