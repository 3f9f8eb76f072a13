//! How a rover is told from other USB devices, and from other rovers.

use heapless::String;

/// Vendor: pid.codes, whose products are open hardware.
pub const VENDOR: u16 = 0x1209;
/// Product: pid.codes' number for testing, which anybody may use and nobody owns; therefore a
/// host also looks at [`PRODUCT_NAME`].
pub const PRODUCT: u16 = 0x0001;
/// Name of the maker.
pub const MANUFACTURER_NAME: &str = "Turing Rover";
/// Name of the product.
pub const PRODUCT_NAME: &str = "Turing Rover";

/// Digits of a [`serial_number`].
pub const SERIAL_DIGITS: usize = 16;

/// The serial number of the board whose flash has this number (its maker gives every chip one of its
/// own, of 64 bits, most significant first): hexadecimal digits, as the Pico SDK
/// writes it.
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
