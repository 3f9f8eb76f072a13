//! The USB device: a serial port (CDC-ACM) with the rover's name and serial number.

use embassy_futures::yield_now;
use embassy_rp::interrupt::typelevel::{Handler, USBCTRL_IRQ};
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts, pac};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_usb::class::cdc_acm::{CdcAcmClass, State};
use embassy_usb::{Builder, Config};
use heapless::String;
use rover_shared::wire::usb::{self, SERIAL_DIGITS};
use static_cell::StaticCell;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => ResetSeen, InterruptHandler<USB>;
});

/// Size of a bulk packet at full speed.
pub const PACKET: u16 = 64;

/// The driver.
pub type Usb = Driver<'static, USB>;
/// The serial port, for the rest of the program.
pub type Port = CdcAcmClass<'static, Usb>;
/// Answers the host's requests while it is polled.
pub type Device = embassy_usb::UsbDevice<'static, Usb>;

/// Makes the device. `flash`: the flash's unique number, if it was read; it becomes the serial number.
pub fn device(usb: Peri<'static, USB>, flash: Option<[u8; SERIAL_DIGITS / 2]>) -> (Device, Port) {
    static SERIAL_NUMBER: StaticCell<String<SERIAL_DIGITS>> = StaticCell::new();
    static CONFIGURATION: StaticCell<[u8; 128]> = StaticCell::new();
    static BOS: StaticCell<[u8; 16]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State> = StaticCell::new();
    let mut config = Config::new(usb::VENDOR, usb::PRODUCT);
    config.manufacturer = Some(usb::MANUFACTURER_NAME);
    config.product = Some(usb::PRODUCT_NAME);
    config.serial_number =
        flash.map(|number| SERIAL_NUMBER.init(usb::serial_number(number)).as_str());
    // The most a host may grant, in mA; the board takes some 40, the motors have their own supply.
    config.max_power = 500;
    let mut builder = Builder::new(
        Driver::new(usb, Irqs),
        config,
        CONFIGURATION.init([0; 128]),
        BOS.init([0; 16]),
        &mut [],
        CONTROL.init([0; 64]),
    );
    let port = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET);
    (builder.build(), port)
}

/// Signalled by every bus reset.
static RESET: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Detects bus resets before the driver handles them.
struct ResetSeen;

impl Handler<USBCTRL_IRQ> for ResetSeen {
    unsafe fn on_interrupt() {
        if pac::USB.sie_status().read().bus_reset() {
            RESET.signal(());
        }
    }
}

/// Frees the control endpoint when a bus reset has come in the middle of a request.
///
/// embassy-rp 0.10 waits for the host to fetch the request's packet, checks nothing else meanwhile, and
/// so misses the reset (or the pulled cable, which ends in one): the packet is never fetched, and the
/// board would not respond to USB until it is reset. Withdrawing the packets lets the driver continue
/// and see the reset; the suspension that it missed with a pulled cable is over then.
///
/// To be joined with, and polled after, [`Device::run`]: a reset that is still pending then is one that
/// the driver does not see.
pub async fn free_endpoint_zero() -> ! {
    loop {
        RESET.wait().await;
        // The driver's turn.
        yield_now().await;
        while pac::USB.sie_status().read().bus_reset() {
            let memory = pac::USB_DPRAM;
            for control in [
                memory.ep_in_buffer_control(0),
                memory.ep_out_buffer_control(0),
            ] {
                control.modify(|w| w.set_available(0, false));
            }
            pac::USB.sie_status().write(|w| w.set_suspended(true));
            log!("usb: endpoint 0 freed");
            yield_now().await;
        }
    }
}
