//! A board on the bench: four range sensors that see a wall at rest, a compass, a cable.

use std::sync::LazyLock;

use emulated_rp2040::Machine;
use emulated_rp2040::elf::Image;
use emulated_rp2040::peripheral::{CYCLES_PER_MICROSECOND, Cycles};
use emulated_rp2040::usb::State;
use rover_emulator::cmps03::Compass;
use rover_shared::contract::Refusal;
use rover_shared::wire::SCHEMA_HASH;
use rover_shared::wire::frame::{Decoder, Encoder, MAX_FRAME};
use rover_shared::wire::message::{Ack, Command, Hello, Report};

use crate::thumb;

/// A millisecond of the board's.
pub const MS: Cycles = 1_000 * CYCLES_PER_MICROSECOND;

/// Some 30 cm, by the curve of a GP2D12.
const COUNTS: u16 = 1_180;
/// Pins of the range sensors' channels, the motors' PWM and directions.
const CHANNELS: usize = 4;
const MOTOR_PINS: std::ops::RangeInclusive<usize> = 0..=5;

/// The firmware as it is flashed.
pub static FIRMWARE: LazyLock<Image> = LazyLock::new(|| {
    let file = std::fs::read(thumb::build("rover-firmware", "firmware", ""));
    let file = file.expect("the firmware was built");
    Image::parse(&file).expect("the firmware is an ELF file")
});

/// The bench.
#[derive(Clone)]
pub struct Bench {
    pub machine: Machine,
    /// Tenths of a degree.
    pub heading: u16,
    /// All reports so far.
    pub reports: Vec<Report>,
    encoder: Encoder,
    decoder: Decoder,
    heartbeats: bool,
    milliseconds: u64,
}

impl Bench {
    /// A board with the firmware, not plugged in.
    pub fn new(seed: u64) -> Self {
        Self::with(&FIRMWARE, seed)
    }

    pub fn with(image: &Image, seed: u64) -> Self {
        let mut machine = Machine::new(image, seed).expect("the firmware fits into the flash");
        machine
            .attach_i2c([6, 7], Compass::default())
            .expect("pins of I2C1");
        Self {
            machine,
            heading: 1_800,
            reports: Vec::new(),
            encoder: Encoder::new(),
            decoder: Decoder::new(),
            heartbeats: false,
            milliseconds: 0,
        }
    }

    /// The same, and a host that has opened the port and said hello.
    pub fn connected(seed: u64) -> Self {
        let mut bench = Self::new(seed);
        bench.connect();
        bench
    }

    /// Plugs the cable in, opens the port, and says hello.
    pub fn connect(&mut self) {
        self.heartbeats = false;
        self.decoder = Decoder::new();
        let now = self.machine.now();
        self.machine.usb_mut().plug(now);
        self.machine.usb_mut().set_dtr(true, now);
        let schema = SCHEMA_HASH;
        self.wait(2_000, |report| matches!(report, Report::Hello(_)))
            .expect("a hello when the port is opened");
        assert_eq!(self.command(&Command::Hello { schema }), Ok(()));
    }

    /// Runs for so many milliseconds.
    pub fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.step();
        }
    }

    fn step(&mut self) {
        self.milliseconds += 1;
        // A voltage that never changes is that of a frozen sensor.
        let noise = (self.milliseconds * 7 % 11) as u16;
        for channel in 0..CHANNELS {
            let counts = COUNTS + noise + 3 * channel as u16;
            self.machine.adc_mut().set_input(channel, counts);
        }
        let [high, low] = self.heading.to_be_bytes();
        let byte = (u32::from(self.heading) * 256 / 3_600) as u8;
        let compass = self.machine.i2c_mut(1).device_mut::<Compass>();
        let compass = compass.expect("it was attached");
        compass.set_registers(Some([15, byte, high, low]));
        let connected = matches!(self.machine.usb().state(), State::Configured { .. });
        if self.heartbeats && connected && self.milliseconds.is_multiple_of(200) {
            self.send(&Command::Heartbeat);
        }
        self.machine.run_until(self.machine.now() / MS * MS + MS);
        let now = self.machine.now();
        for byte in self.machine.usb_mut().receive(now) {
            if let Some(frame) = self.decoder.push(byte) {
                let frame = frame.expect("whole frames");
                self.reports.push(frame.message);
            }
        }
    }

    /// Sends heartbeats from now on, as a host does that drives.
    pub fn keep_alive(&mut self) {
        self.heartbeats = true;
    }

    /// Sends a command, and gives its number.
    pub fn send(&mut self, command: &Command) -> u16 {
        let sequence = self.encoder.next_sequence();
        let mut buffer = [0; MAX_FRAME];
        let frame = self.encoder.encode(command, &mut buffer);
        let frame = frame.expect("it fits");
        let now = self.machine.now();
        assert_eq!(self.machine.usb_mut().send(frame, now), frame.len());
        sequence
    }

    /// Sends a command and waits for the answer.
    pub fn command(&mut self, command: &Command) -> Result<(), Refusal> {
        let sequence = self.send(command);
        let answer = self.wait(
            1_000,
            |report| matches!(report, Report::Ack(ack) if ack.sequence == sequence),
        );
        let Some(Report::Ack(Ack { result, .. })) = answer else {
            panic!("no answer to {command:?}");
        };
        result
    }

    /// Runs until such a report comes, among those not waited for before.
    pub fn wait(&mut self, milliseconds: u64, is: impl Fn(&Report) -> bool) -> Option<Report> {
        let mut seen = self.reports.len();
        for _ in 0..milliseconds {
            self.step();
            for report in &self.reports[seen..] {
                if is(report) {
                    return Some(report.clone());
                }
            }
            seen = self.reports.len();
        }
        None
    }

    /// The last hello.
    pub fn hello(&self) -> &Hello {
        let mut hellos = self.reports.iter().rev().filter_map(|report| match report {
            Report::Hello(hello) => Some(hello),
            _ => None,
        });
        hellos.next().expect("a hello")
    }

    /// The last words that were told.
    pub fn last_words(&self) -> Option<&str> {
        let mut words = self.reports.iter().rev().filter_map(|report| match report {
            Report::LastWords(words) => Some(words.as_str()),
            _ => None,
        });
        words.next()
    }

    /// The shares of the time that the motors' pins are high.
    pub fn motors(&self) -> Vec<f64> {
        MOTOR_PINS
            .map(|pin| self.machine.output(pin).duty())
            .collect()
    }

    /// Whether neither side has current.
    pub fn motors_off(&self) -> bool {
        self.motors()[..2].iter().all(|duty| *duty == 0.0)
    }
}
