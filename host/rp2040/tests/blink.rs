//! A program that was not written for the emulator (`blink/`): an Embassy executor, a timer, a pin
//! out, a pin in with its interrupt, and text over RTT.

use emulated_rp2040::Machine;
use emulated_rp2040::elf::Image;
use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use emulated_rp2040::pins::Output;
use emulated_rp2040::rtt::Reader;

#[path = "../../../tests/support/thumb.rs"]
mod thumb;

const LED: usize = 25;
const BUTTON: usize = 15;
const MS: Cycles = 1_000 * CYCLES_PER_MICROSECOND;
/// Between the alarm of the timer and the pin: interrupt, executor, task.
const REACTION: Cycles = 100 * CYCLES_PER_MICROSECOND;

fn built() -> Image {
    let path = thumb::build("rp2040-blink", "firmware", "");
    let file = std::fs::read(path).expect("the program was built");
    Image::parse(&file).expect("it is an ELF file")
}

/// A Pico with this program, and what was seen of it.
struct Pico {
    machine: Machine,
    rtt: Reader,
    led: Output,
    /// When the LED changed, and to what.
    changes: Vec<(Cycles, Output)>,
}

impl Pico {
    fn new(image: &Image) -> Self {
        Self {
            machine: Machine::new(image, 1).expect("it fits"),
            rtt: Reader::new(image),
            led: Output::Floating,
            changes: Vec::new(),
        }
    }

    fn run_until(&mut self, until: Cycles) {
        while self.machine.now() < until {
            self.machine.run_to_event(until);
            let led = self.machine.output(LED);
            if led != self.led {
                self.led = led;
                self.changes.push((self.machine.now(), led));
            }
        }
    }

    fn lines(&mut self) -> Vec<String> {
        self.rtt.lines(&mut self.machine)
    }
}

/// What is seen in two seconds, the button pressed after one.
fn two_seconds(image: &Image) -> (Vec<(Cycles, Output)>, Vec<String>) {
    let mut pico = Pico::new(image);
    pico.run_until(1_000 * MS);
    pico.machine.set_input(BUTTON, Some(false));
    pico.run_until(1_090 * MS);
    pico.machine.set_input(BUTTON, None);
    pico.run_until(2_000 * MS);
    assert_eq!(pico.machine.unmodelled(), None);
    assert_eq!(pico.machine.incidents().count(), 0);
    let lines = pico.lines();
    (pico.changes, lines)
}

#[test]
fn the_led_blinks_and_the_button_changes_how_fast() {
    let (changes, lines) = two_seconds(&built());
    let Some(((set_up, Output::Level(false)), blinks)) = changes.split_first() else {
        panic!("it begins low: {changes:?}");
    };
    // Start-up is the crystal's, then the ticker begins; the button begins it anew.
    assert!((1..250 * MS).contains(set_up), "{set_up}");
    let slow = (1..).map(|n| set_up + n * 250 * MS);
    let fast = (1..).map(|n| (1_000 + n * 50) * MS);
    let due = slow.take_while(|at| *at < 1_000 * MS).chain(fast);
    let mut expected = Vec::new();
    let mut on = false;
    for (due, (at, led)) in due.zip(blinks) {
        on = !on;
        assert_eq!(*led, Output::Level(on));
        assert!((due..due + REACTION).contains(at), "{at}, due at {due}");
        if due >= 1_000 * MS && !expected.iter().any(|line| line == "every 50 ms") {
            expected.push("every 50 ms".to_owned());
        }
        expected.push(format!("LED {}", if on { "on" } else { "off" }));
    }
    let slow_blinks = blinks.iter().filter(|(at, _)| *at < 1_000 * MS).count();
    assert!((3..=4).contains(&slow_blinks), "{blinks:?}");
    assert!((18..=19).contains(&(blinks.len() - slow_blinks)));
    assert_eq!(lines, expected);
}

#[test]
fn the_button_is_read_as_it_is_held() {
    let mut pico = Pico::new(&built());
    pico.run_until(400 * MS);
    assert_eq!(pico.lines(), ["LED on"]);
    for (level, lines) in [
        (Some(true), &[][..]),
        (Some(false), &["every 50 ms"]),
        (Some(false), &[]),
        (None, &[]),
        (Some(false), &["every 250 ms"]),
    ] {
        pico.machine.set_input(BUTTON, level);
        pico.run_until(pico.machine.now() + MS);
        assert_eq!(pico.lines(), lines, "{level:?}");
    }
}

/// `data/blink.elf` is the same program without symbols, for the examples in the documentation. To
/// make it:
///
/// ```text
/// cargo rustc -p rp2040-blink --profile firmware --target thumbv6m-none-eabi -- -C strip=symbols
/// cp target/thumbv6m-none-eabi/firmware/rp2040-blink host/rp2040/tests/data/blink.elf
/// ```
#[test]
fn the_program_in_the_examples_does_the_same() {
    let stripped = Image::parse(include_bytes!("data/blink.elf")).expect("an ELF file");
    assert_eq!(stripped.symbols().count(), 0);
    let ((changes, lines), (expected, expected_lines)) =
        (two_seconds(&stripped), two_seconds(&built()));
    assert_eq!(lines, expected_lines);
    assert_eq!(changes.len(), expected.len());
    for ((at, led), (due, expected)) in changes.into_iter().zip(expected) {
        assert_eq!(led, expected);
        assert!(at.abs_diff(due) < REACTION, "{at}, {due}");
    }
}
