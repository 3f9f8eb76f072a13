//! How a rover is told from other USB devices.

/// Vendor: pid.codes, whose products are open hardware.
pub const VENDOR: u16 = 0x1209;
/// Product: pid.codes' number for testing, which anybody may use and nobody owns; therefore a
/// host also looks at [`PRODUCT_NAME`].
pub const PRODUCT: u16 = 0x0001;
/// Name of the maker.
pub const MANUFACTURER_NAME: &str = "Turing Rover";
/// Name of the product.
pub const PRODUCT_NAME: &str = "Turing Rover";
