//! Start-up, output and time on the bare machine.

use core::arch::asm;
use core::fmt::{self, Write};
use core::panic::PanicInfo;
use core::ptr;

use crate::groups::{self, Report};

/// SysTick's registers: SYST_CSR, SYST_RVR, SYST_CVR.
const SYST: *mut u32 = 0xe000_e010 as *mut u32;
/// SYST_CSR: count the processor's cycles, without interrupts.
const COUNT_CYCLES: u32 = 0b101;
/// The counter's width, 24 bits: 16.7 million cycles until it comes round.
const COUNTER_MASK: u32 = 0x00ff_ffff;

/// Semihosting: print the character that the argument points to.
const SYS_WRITEC: u32 = 0x03;
/// Semihosting: end the program, with this reason.
const SYS_EXIT: u32 = 0x18;
/// The program is done.
const APPLICATION_EXIT: u32 = 0x20026;
/// Something went wrong.
const RUN_TIME_ERROR: u32 = 0x20023;

fn semihosting(operation: u32, argument: u32) {
    // SAFETY: the debugger only reads the memory that the argument points to.
    unsafe {
        asm!("bkpt #0xab", inout("r0") operation => _, in("r1") argument, options(nostack));
    }
}

fn exit(reason: u32) -> ! {
    loop {
        semihosting(SYS_EXIT, reason);
    }
}

struct Console;

impl Write for Console {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            semihosting(SYS_WRITEC, ptr::from_ref(&byte) as u32);
        }
        Ok(())
    }
}

/// Prints, and counts the cycles of what is timed.
#[derive(Default)]
struct Output {
    timed: u32,
    least: Option<u32>,
    most: u32,
    sum: u64,
}

impl Output {
    fn cycle_counter() -> u32 {
        // SAFETY: a register of the processor, used by nothing else.
        unsafe { SYST.add(2).read_volatile() }
    }

    fn start_counter() {
        // SAFETY: as above.
        unsafe {
            SYST.add(1).write_volatile(COUNTER_MASK);
            SYST.add(2).write_volatile(0);
            SYST.write_volatile(COUNT_CYCLES);
        }
    }
}

impl Report for Output {
    fn group(&mut self, name: &str, checksum: u32) {
        let _ = writeln!(Console, "{name} {checksum:08x}");
    }

    fn timed<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let before = Self::cycle_counter();
        let result = work();
        let cycles = before.wrapping_sub(Self::cycle_counter()) & COUNTER_MASK;
        self.timed += 1;
        self.least = Some(self.least.map_or(cycles, |least| least.min(cycles)));
        self.most = self.most.max(cycles);
        self.sum += u64::from(cycles);
        result
    }
}

#[unsafe(no_mangle)]
extern "C" fn reset() -> ! {
    let mut output = Output::default();
    Output::start_counter();
    groups::run(&mut output);
    let Output {
        timed,
        least,
        most,
        sum,
    } = output;
    let mean = sum / u64::from(timed.max(1));
    let least = least.unwrap_or(0);
    let _ = writeln!(
        Console,
        "cycles of {timed} perceptions: {least} to {most}, mean {mean}"
    );
    exit(APPLICATION_EXIT)
}

#[unsafe(no_mangle)]
extern "C" fn hard_fault() -> ! {
    let _ = writeln!(Console, "hard fault");
    exit(RUN_TIME_ERROR)
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let _ = writeln!(Console, "{info}");
    exit(RUN_TIME_ERROR)
}
