//! Small programs, in the place of the second stage: the boot ROM copies them to RAM and starts them.

use super::*;
use crate::boot_rom::{BOOT2_ADDRESS, BOOT2_SIZE};
use crate::bus::{Boot, FLASH};
use crate::cpu::FaultCause;
use crate::elf::{Image, Segment};
use crate::i2c::I2cDevice;
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

/// Writes words to registers at these addresses.
fn write_registers(machine: &mut Machine, words: &[(u32, u32)]) {
    let now = machine.now();
    for &(address, word) in words {
        let written = machine.peripherals_mut().write(address, word, now);
        written.expect("a register");
    }
}

/// Everything comes out of reset.
fn release_resets(machine: &mut Machine) {
    write_registers(machine, &[(0x4000_c000, 0)]);
}

const I2C: [u32; 2] = [0x4004_4000, 0x4004_8000];

/// Acknowledges its address and gives it back, or its complement after a byte was written.
#[derive(Clone, Debug)]
struct Echo {
    address: u16,
    written: Option<u8>,
}

impl Echo {
    const fn at(address: u16) -> Self {
        let written = None;
        Self { address, written }
    }
}

impl I2cDevice for Echo {
    fn start(&mut self, address: u16, _read: bool) -> bool {
        address == self.address
    }

    fn write(&mut self, byte: u8) -> bool {
        self.written = Some(byte);
        true
    }

    fn read(&mut self) -> u8 {
        self.written.map_or(self.address as u8, |byte| !byte)
    }
}

/// Gives pins the function I2C.
fn select_i2c(machine: &mut Machine, pins: [u32; 2]) {
    let registers = pins.map(|pin| (0x4001_4004 + 8 * pin, 3));
    write_registers(machine, &registers);
}

/// Reads a byte from a device as a program does; `None` if nothing acknowledges.
fn read_i2c(machine: &mut Machine, controller: usize, address: u32) -> Option<u32> {
    let base = I2C[controller];
    let read_and_stop = 1 << 9 | 1 << 8;
    let words = [
        (base + 0x6c, 0),
        (base + 0x04, address),
        (base + 0x6c, 1),
        (base + 0x10, read_and_stop),
    ];
    write_registers(machine, &words);
    machine.run_until(machine.now() + 1_000_000);
    let now = machine.now();
    let mut read = |offset| {
        let value = machine.peripherals_mut().read(base + offset, now);
        value.expect("a register")
    };
    let received = read(0x78);
    // IC_CLR_TX_ABRT
    read(0x54);
    (received > 0).then(|| read(0x10) & 0xff)
}

#[test]
fn both_i2c_controllers_reach_the_devices_on_their_pins() {
    let mut machine = machine(&[0xe7fe]);
    for (pins, address) in [([4, 5], 0x10), ([4, 5], 0x11), ([26, 27], 0x12)] {
        let attached = machine.attach_i2c(pins, Echo::at(address));
        assert_eq!(attached, Ok(()));
    }
    release_resets(&mut machine);
    select_i2c(&mut machine, [4, 5]);
    select_i2c(&mut machine, [26, 27]);
    let mut read = |controller, address| read_i2c(&mut machine, controller, address);
    assert_eq!((read(0, 0x10), read(0, 0x11)), (Some(0x10), Some(0x11)));
    assert_eq!((read(0, 0x12), read(1, 0x12)), (None, Some(0x12)));
    assert_eq!(read(1, 0x10), None);
    // A copy of the machine has devices of its own.
    let mut copy = machine.clone();
    let device = copy.i2c_mut(1).device_mut::<Echo>().expect("attached");
    assert!(device.write(0));
    assert_eq!(read_i2c(&mut copy, 1, 0x12), Some(0xff));
    assert_eq!(read_i2c(&mut machine, 1, 0x12), Some(0x12));
}

#[test]
fn a_device_on_other_pins_than_the_program_uses_is_not_reached() {
    let mut machine = machine(&[0xe7fe]);
    let attached = machine.attach_i2c([4, 5], Echo::at(0x10));
    assert_eq!(attached, Ok(()));
    release_resets(&mut machine);
    select_i2c(&mut machine, [0, 1]);
    assert_eq!(read_i2c(&mut machine, 0, 0x10), None);
    select_i2c(&mut machine, [4, 5]);
    assert_eq!(read_i2c(&mut machine, 0, 0x10), Some(0x10));
    // SIO takes SCL back.
    write_registers(&mut machine, &[(0x4001_4004 + 8 * 5, 5)]);
    assert_eq!(read_i2c(&mut machine, 0, 0x10), None);
}

#[test]
fn devices_fit_only_to_a_controllers_pins() {
    let mut machine = machine(&[0xe7fe]);
    for pins in [
        [5, 4],
        [4, 7],
        [2, 5],
        [4, 6],
        [30, 31],
        [usize::MAX - 1, 1],
    ] {
        let [data, clock] = pins;
        let error = machine.attach_i2c(pins, Echo::at(1));
        assert_eq!(error, Err(WiringError::NotABus { data, clock }));
    }
    assert_eq!(machine.attach_i2c([0, 5], Echo::at(1)), Ok(()));
    let error = machine.attach_i2c([4, 5], Echo::at(2)).expect_err("wired");
    assert_eq!(
        error.to_string(),
        "the devices of I2C0 are wired to GPIO 0 and 5"
    );
    assert_eq!(machine.attach_i2c([2, 3], Echo::at(2)), Ok(()));
}

#[test]
fn the_program_reads_the_voltages_on_the_converters_inputs() {
    // MOV R1, PC; LDR R0, [R1, #4] (ADC); LDR R2, [R0, #4] (RESULT); B to LDR
    let code = [0x4679, 0x6848, 0x6842, 0xe7fd, 0xc000, 0x4004];
    let mut machine = machine(&code);
    machine.run_until(STARTED);
    release_resets(&mut machine);
    for (channel, counts) in [(0, 100), (3, 4_095), (3, 5)] {
        machine.adc_mut().set_input(channel, counts);
        // EN, START_ONCE and AINSEL
        let start = 0b101 | (channel as u32) << 12;
        write_registers(&mut machine, &[(0x4004_c000, start)]);
        machine.run_until(machine.now() + 300);
        let result = machine.core().registers().get(2);
        assert_eq!(result, u32::from(counts));
    }
}

#[test]
fn a_program_uses_an_interpolator() {
    // MOV R1, PC; LDR R0, [R1, #20] (INTERP0); LDR R3, [R1, #24] (MASK_MSB 31); MOVS R2, #5;
    // STR R2, [R0, #8] (BASE0); STR R3, [R0, #0x2c] (CTRL_LANE0); LDR R4 to R6, [R0, #0x14]
    // (POP_LANE0); B .; NOP; NOP
    let code = [
        0x4679, 0x6948, 0x698b, 0x2205, 0x6082, 0x62c3, 0x6944, 0x6945, 0x6946, 0xe7fe, 0xbf00,
        0xbf00, // table at 24
        0x0080, 0xd000, 0x7c00, 0x0000,
    ];
    let mut machine = machine(&code);
    machine.run_until(STARTED);
    let popped = [4, 5, 6].map(|register| machine.core().registers().get(register));
    assert_eq!(popped, [5, 10, 15]);
}

#[test]
fn outputs_are_seen_when_they_change() {
    // MOV R1, PC; LDR R0, [R1, #16] (SIO); MOVS R2, #8; STR R2, [R0, #0x24] (GPIO_OE_SET);
    // STR R2, [R0, #0x1c] (GPIO_OUT_XOR); MOVS R3, #0; SUBS R3, #1; B to STR; (nop)
    let code = [
        0x4679, 0x6908, 0x2208, 0x6242, 0x61c2, 0x2300, 0x3b01, 0xe7fb, 0xbf00, 0xbf00, 0x0000,
        0xd000,
    ];
    let mut machine = machine(&code);
    machine.run_until(STARTED);
    assert_eq!(machine.output(3), Output::Floating, "without a function");
    release_resets(&mut machine);
    write_registers(&mut machine, &[(0x4001_4004 + 8 * 3, 5)]);
    let mut changes = Vec::new();
    let mut before = machine.output(3);
    while changes.len() < 10 {
        machine.run_to_event(Cycles::MAX);
        let now = machine.output(3);
        if now != before {
            changes.push((machine.now(), now));
            before = now;
        }
    }
    // STR to SIO, MOVS, SUBS, B taken
    for pair in changes.windows(2) {
        assert_eq!(pair[1].0 - pair[0].0, 1 + 1 + 1 + 2);
        assert_ne!(pair[1].1, pair[0].1);
    }
}

#[test]
fn pins_can_be_held_from_outside() {
    // MOV R1, PC; LDR R0, [R1, #4] (SIO); LDR R2, [R0, #4] (GPIO_IN); B to LDR
    let code = [0x4679, 0x6848, 0x6842, 0xe7fd, 0x0000, 0xd000];
    let mut machine = machine(&code);
    machine.run_until(STARTED);
    release_resets(&mut machine);
    for (level, bit) in [(Some(true), 1 << 9), (Some(false), 0), (None, 0)] {
        machine.set_input(9, level);
        machine.run_until(machine.now() + 100);
        assert_eq!(machine.core().registers().get(2) & 1 << 9, bit, "{level:?}");
    }
    assert_eq!(machine.output(9), Output::Floating);
}
