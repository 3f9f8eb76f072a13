//! How a rover identifies itself on USB.

use heapless::String;

/// Vendor: pid.codes, whose products are open hardware.
pub const VENDOR: u16 = 0x1209;
/// Product: pid.codes' number for testing, which is shared; so a host also checks
/// [`PRODUCT_NAME`].
pub const PRODUCT: u16 = 0x0001;
/// Name of the maker.
pub const MANUFACTURER_NAME: &str = "Turing Rover";
/// Name of the product.
pub const PRODUCT_NAME: &str = "Turing Rover";

/// Digits of a [`serial_number`].
pub const SERIAL_DIGITS: usize = 16;

/// Formats the serial number of a board: its flash chip's unique 64-bit number, most significant
/// byte first, in hexadecimal digits, as the Pico SDK does.
#[must_use]
pub fn serial_number(flash: [u8; SERIAL_DIGITS / 2]) -> String<SERIAL_DIGITS> {
    let digits = flash.iter().flat_map(|byte| [byte >> 4, byte & 0xf]);
    digits
        .map(|digit| match digit {
            0..10 => char::from(b'0' + digit),
            _ => char::from(b'A' + (digit - 10)),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_serial_number_is_the_flashs_number_in_hexadecimal_digits() {
        let number = serial_number([0xe6, 0x60, 0x58, 0x38, 0x83, 0x00, 0x9a, 0xbf]);
        assert_eq!(number, "E660583883009ABF");
    }
}
