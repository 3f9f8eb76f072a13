//! The firmware's tasks, from outside: where they are, to hang one or to slow it down.
//!
//! The executor calls a task through the address that the task's header holds in RAM (`poll_fn`).
//! A fault puts another address there: that of a few instructions in unused flash, which wait before
//! they go on to the task, or for ever. The program itself stays as it is.

use emulated_rp2040::elf::Image;
use emulated_rp2040::machine::Machine;
use rover_shared::supervisor::Loop;

/// Offset of the instructions in the flash: right below what `memory.x` sets aside for storage, far
/// above any program.
const DETOURS: usize = 0x1d_0000;
/// Bytes for each task's instructions.
const DETOUR: usize = 0x100;
/// Where the flash is.
const FLASH: u32 = 0x1000_0000;
/// Words at the beginning of a task's storage among which `poll_fn` is (the tenth, in embassy-executor
/// 0.10 on a Cortex-M0+).
const HEADER_WORDS: usize = 16;

/// How long each turn of an overrunning control loop takes, beside what it takes anyway: more than
/// its period of 20 ms.
const OVERRUN_CYCLES: u32 = 30_000 * 125;
/// Cycles of one round of the waiting loop: SUBS, and BNE taken.
const ROUND_CYCLES: u32 = 3;

/// A task, as the program's symbols have it.
#[derive(Clone, Debug)]
struct Task {
    of: Loop,
    /// Where its storage begins.
    storage: u32,
    fault: Option<Wait>,
    /// Where `poll_fn` is and what it held, while the fault stands.
    replaced: Option<(u32, u32)>,
}

/// What a fault makes of a task's turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wait {
    ForEver,
    Overrun,
}

/// All tasks of a program.
#[derive(Clone, Debug, Default)]
pub struct Tasks {
    tasks: Vec<Task>,
    /// Addresses that `poll_fn` can hold.
    polls: Vec<u32>,
}

const NAMES: [(Loop, &str); 5] = [
    (Loop::Sense, "5sense5sense4POOL"),
    (Loop::Control, "7control7control4POOL"),
    (Loop::Drive, "5drive5drive4POOL"),
    (Loop::Link, "4link4link4POOL"),
    (Loop::Store, "5store5store4POOL"),
];

impl Tasks {
    /// The tasks of a program, by its symbols; none if it has none.
    pub fn of(image: &Image) -> Self {
        let tasks = NAMES.iter().filter_map(|&(of, name)| {
            let storage = image.symbols_with(&[name]).next()?.address;
            Some(Task {
                of,
                storage,
                fault: None,
                replaced: None,
            })
        });
        Self {
            tasks: tasks.collect(),
            polls: image
                .symbols_with(&["TaskStorage", "4poll"])
                .map(|symbol| symbol.address)
                .collect(),
        }
    }

    /// A task does not come back from its next turn, or does again.
    pub fn hang(&mut self, machine: &mut Machine, of: Loop, on: bool) {
        self.set(machine, of, on.then_some(Wait::ForEver));
    }

    /// Each turn of the control loop takes longer than its period, or does no more.
    pub fn overrun(&mut self, machine: &mut Machine, on: bool) {
        self.set(machine, Loop::Control, on.then_some(Wait::Overrun));
    }

    fn set(&mut self, machine: &mut Machine, of: Loop, fault: Option<Wait>) {
        if let Some(task) = self.tasks.iter_mut().find(|task| task.of == of) {
            task.fault = fault;
            if fault.is_none() {
                task.release(machine);
            }
        }
        self.keep(machine);
    }

    /// Makes faults hold that stand: a reset of the board writes the headers anew.
    pub fn keep(&mut self, machine: &mut Machine) {
        for task in &mut self.tasks {
            if task.fault.is_some() {
                task.detour(machine, &self.polls);
            }
        }
    }
}

impl Task {
    fn detour_offset(&self) -> usize {
        DETOURS + self.of as usize * DETOUR
    }

    fn detour(&mut self, machine: &mut Machine, polls: &[u32]) {
        let Some(fault) = self.fault else { return };
        let found = (0..HEADER_WORDS).find_map(|i| {
            let place = self.storage + 4 * i as u32;
            let bytes = machine.read(place, 4)?.try_into().ok()?;
            let poll = u32::from_le_bytes(bytes);
            polls.contains(&poll).then_some((place, poll))
        });
        // Nothing is there before the task is spawned, and the detour already once it is made.
        let Some((place, poll)) = found else { return };
        let offset = self.detour_offset();
        let code = instructions(fault, poll);
        machine.flash_mut()[offset..offset + code.len()].copy_from_slice(&code);
        let detour = FLASH + offset as u32 + 1;
        if machine.write_ram(place, &detour.to_le_bytes()).is_ok() {
            self.replaced = Some((place, poll));
        }
    }

    /// Lets the task go on, from within the detour too.
    fn release(&mut self, machine: &mut Machine) {
        let Some((place, poll)) = self.replaced.take() else {
            return;
        };
        // After a reset of the program the original address is there again.
        let detour = FLASH + self.detour_offset() as u32 + 1;
        if machine.read(place, 4) == Some(&detour.to_le_bytes()) {
            // It lies where it was read.
            let _ = machine.write_ram(place, &poll.to_le_bytes());
        }
        let loops = self.detour_offset() + LOOP;
        machine.flash_mut()[loops..loops + 2].copy_from_slice(&NOP.to_le_bytes());
    }
}

/// Offset of the branch that makes a detour wait.
const LOOP: usize = 6;
const NOP: u16 = 0xbf00;

/// The detour: waits, and goes on to the task with all registers but R12 as they were.
fn instructions(wait: Wait, poll: u32) -> Vec<u8> {
    let (branch, rounds) = match wait {
        Wait::ForEver => (0xe7fe, 1),                             // B .
        Wait::Overrun => (0xd1fd, OVERRUN_CYCLES / ROUND_CYCLES), // BNE to the SUBS
    };
    let code: [u16; 10] = [
        0xb403, // PUSH {R0, R1}
        0x4904, // LDR R1, [PC, #16]: the rounds
        0x3901, // SUBS R1, #1
        branch, 0x4903, // LDR R1, [PC, #12]: the task
        0x468c, // MOV R12, R1
        0xbc03, // POP {R0, R1}
        0x4760, // BX R12
        NOP, NOP,
    ];
    let mut bytes: Vec<u8> = code.iter().flat_map(|op| op.to_le_bytes()).collect();
    bytes.extend(rounds.to_le_bytes());
    bytes.extend(poll.to_le_bytes());
    bytes
}
