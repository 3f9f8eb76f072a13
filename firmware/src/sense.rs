//! Samples the range sensors and the compass, every 20 ms.

use core::cell::{Cell, RefCell};

use embassy_rp::adc::{self, Adc, Channel};
use embassy_rp::gpio::{Level, OutputOpenDrain};
use embassy_rp::i2c::{self, AbortReason, I2c};
use embassy_rp::peripherals::{DMA_CH0, I2C1};
use embassy_rp::{bind_interrupts, dma};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_time::{Duration, Ticker, block_for, with_timeout};
use heapless::Vec;
use rover_shared::contract::CompassHealth;
use rover_shared::rover::{Observation, Rover};
use rover_shared::sensing::compass::{self, Compass, Retry};
use rover_shared::sensing::ir::{AdcCount, CHANNELS, IrArray, medians};
use rover_shared::supervisor::{Input, Loop};

use crate::board::{self, BOARD, CONNECTED, CompassBus, Ranges};
use crate::{drive, guard};

bind_interrupts!(struct Irqs {
    ADC_IRQ_FIFO => adc::InterruptHandler;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
    I2C1_IRQ => i2c::InterruptHandler<I2C1>;
});

/// Sweeps over all channels of which the medians are taken.
const SWEEPS: usize = 5;
/// 48 MHz / 4,800: 10,000 conversions a second, so that five sweeps take 2 ms, longer than a burst of
/// a sensor's current.
const ADC_DIVIDER: u16 = 4_799;
/// How long the sweeps may take.
const ADC_TIMEOUT: Duration = Duration::from_millis(10);

static LATEST: Mutex<CriticalSectionRawMutex, Cell<Observation>> =
    Mutex::new(Cell::new(Observation::NOTHING));

/// Returns the latest observation.
pub fn latest() -> Observation {
    LATEST.lock(Cell::get)
}

/// Samples the sensors; never returns.
#[embassy_executor::task]
pub async fn sense(
    ranges: Ranges,
    mut bus: CompassBus,
    rover: &'static RefCell<Rover<'static>>,
) -> ! {
    let mut converter = Converter::new(ranges);
    let mut senses = Senses::new(rover);
    let mut retry = Retry::new();
    let mut ticker = Ticker::every(guard::duration(compass::PERIOD));
    loop {
        // Each turn of this loop makes a new I2C driver.
        let (i2c, scl, sda) = (bus.i2c.reborrow(), bus.scl.reborrow(), bus.sda.reborrow());
        let mut i2c = I2c::new_async(i2c, scl, sda, Irqs, i2c::Config::default());
        loop {
            ticker.next().await;
            guard::tell(Input::Alive(Loop::Sense));
            senses.calibrate();
            let counts = converter.sample().await;
            let answer = if retry.due(guard::now()) {
                read_compass(&mut i2c).await
            } else {
                Answer::Skipped
            };
            senses.take(counts, answer);
            match answer {
                Answer::Block(_) | Answer::NoAcknowledge => retry.answered(),
                Answer::Skipped => {}
                Answer::Hung => break,
            }
        }
        free_bus(&mut bus);
        retry.hung(guard::now());
        guard::tell(Input::BusRecovered);
        log!("compass: bus freed");
    }
}

/// The result of one read of the compass.
#[derive(Clone, Copy)]
enum Answer {
    Block([u8; compass::BLOCK]),
    /// No compass is connected, or it is not ready.
    NoAcknowledge,
    /// A device holds a line low, or the driver waits for an event that does not come.
    Hung,
    /// The compass was not read.
    Skipped,
}

async fn read_compass(i2c: &mut I2c<'_, I2C1, i2c::Async>) -> Answer {
    let mut block = [0; compass::BLOCK];
    let read = i2c.write_read_async(compass::ADDRESS, [compass::FIRST_REGISTER], &mut block);
    // Without a time-out this can wait for ever, as the driver's blocking calls can.
    match with_timeout(guard::duration(compass::READ_TIMEOUT), read).await {
        Ok(Ok(())) => Answer::Block(block),
        Ok(Err(i2c::Error::Abort(AbortReason::NoAcknowledge))) => Answer::NoAcknowledge,
        Ok(Err(_)) | Err(_) => Answer::Hung,
    }
}

/// Frees a bus on which a device waits for the rest of a byte: nine clock pulses complete that
/// (I2C specification 3.1.16), then a stop condition.
fn free_bus(bus: &mut CompassBus) {
    /// Half a clock period at 100 kHz.
    const HALF: Duration = Duration::from_micros(5);
    let mut scl = OutputOpenDrain::new(bus.scl.reborrow(), Level::High);
    let mut sda = OutputOpenDrain::new(bus.sda.reborrow(), Level::High);
    scl.set_pullup(true);
    sda.set_pullup(true);
    for _ in 0..9 {
        scl.set_low();
        block_for(HALF);
        scl.set_high();
        block_for(HALF);
    }
    scl.set_low();
    block_for(HALF);
    sda.set_low();
    block_for(HALF);
    scl.set_high();
    block_for(HALF);
    sda.set_high();
    block_for(HALF);
}

/// The converter and its channels.
struct Converter {
    adc: Adc<'static, adc::Async>,
    dma: dma::Channel<'static>,
    channels: Vec<Channel<'static>, CHANNELS>,
}

impl Converter {
    fn new(ranges: Ranges) -> Self {
        Self {
            adc: Adc::new(ranges.adc, Irqs, adc::Config::default()),
            dma: dma::Channel::new(ranges.dma, Irqs),
            channels: ranges.channels,
        }
    }

    /// Returns the median of each channel; `None` if a conversion failed. Medians because of the
    /// spikes in the converter's linearity (erratum RP2040-E11).
    async fn sample(&mut self) -> Option<[AdcCount; CHANNELS]> {
        let mut samples = [[0u16; CONNECTED]; SWEEPS];
        // The converter samples the channels by number, which is the order of the pins.
        let (channels, into) = (&mut self.channels, samples.as_flattened_mut());
        let read = self
            .adc
            .read_many_multichannel(channels, into, ADC_DIVIDER, &mut self.dma);
        let Ok(Ok(())) = with_timeout(ADC_TIMEOUT, read).await else {
            return None;
        };
        medians(&samples.map(places))
    }
}

/// Puts the counts of the sensors that are fitted where arrays of four have them.
fn places(sweep: [u16; CONNECTED]) -> [u16; CHANNELS] {
    let mut counts = sweep.into_iter();
    BOARD
        .ranges
        .map(|pin| pin.and_then(|_| counts.next()).unwrap_or(0))
}

/// Turns counts and bearings into an observation.
struct Senses {
    rover: &'static RefCell<Rover<'static>>,
    ir: IrArray,
    compass: Compass,
}

impl Senses {
    fn new(rover: &'static RefCell<Rover<'static>>) -> Self {
        Self {
            rover,
            ir: IrArray::new(board::FITTED, board::CURVE),
            compass: Compass::new(rover.borrow().calibrations().compass_offset),
        }
    }

    /// Applies the calibrations, which may have changed.
    fn calibrate(&mut self) {
        let rover = self.rover.borrow();
        let calibrations = rover.calibrations();
        self.compass.set_offset(calibrations.compass_offset);
        self.ir.set_curves(calibrations.curves);
    }

    /// Evaluates one period's results, informs the supervisor and publishes the observation.
    fn take(&mut self, counts: Option<[AdcCount; CHANNELS]>, answer: Answer) {
        let now = guard::now();
        let mut observation = latest();
        match counts {
            Some(counts) => {
                observation.ir = self.ir.push(now, counts, drive::driven());
                observation.time = now;
            }
            None => {
                observation.ir.health = self.ir.health(now);
                guard::tell(Input::AdcError);
            }
        }
        if let Answer::Block(block) = answer {
            self.compass.push(now, block);
        }
        observation.heading = self.compass.heading(now);
        observation.compass = match answer {
            // No answer from the start: there is none to wait for.
            Answer::NoAcknowledge if self.compass.health(now) == CompassHealth::Unknown => {
                CompassHealth::Silent
            }
            _ => self.compass.health(now),
        };
        guard::tell(Input::Ranges(observation.ir.health));
        guard::tell(Input::Compass(observation.compass));
        LATEST.lock(|latest| latest.set(observation));
    }
}
