//! The last words of a panic or hard fault: a text that survives the reset in uncleared memory,
//! guarded by a checksum.
//!
//! Composed without `core::fmt`, whose machinery would be the largest part of the handler.

use crate::checksum::CRC32;
use crate::contract::{ResetReason, TEXT_BYTES};

/// A text, cut off at [`TEXT_BYTES`].
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; TEXT_BYTES],
    length: usize,
}

impl Text {
    /// An empty text.
    pub const fn new() -> Self {
        Self {
            bytes: [0; TEXT_BYTES],
            length: 0,
        }
    }

    /// Appends the ASCII part of a text; other characters become question marks.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        for character in text.chars() {
            self.push(if character.is_ascii() {
                character as u8
            } else {
                b'?'
            });
        }
        self
    }

    /// Appends a whole number.
    #[must_use]
    pub fn number(self, number: u32) -> Self {
        self.digits(number, 10, 1)
    }

    /// Appends eight hexadecimal digits.
    #[must_use]
    pub fn address(self, address: u32) -> Self {
        self.digits(address, 16, 8)
    }

    fn digits(mut self, mut number: u32, base: u32, least: usize) -> Self {
        const DIGITS: [u8; 16] = *b"0123456789abcdef";
        let mut reversed = [b'0'; 10];
        let mut length = 0;
        for place in &mut reversed {
            if number == 0 && length >= least {
                break;
            }
            *place = DIGITS
                .get((number % base) as usize)
                .copied()
                .unwrap_or(b'?');
            number /= base;
            length += 1;
        }
        for digit in reversed.iter().take(length).rev() {
            self.push(*digit);
        }
        self
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        let bytes = self.bytes.get(..self.length).unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or_default()
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::new()
    }
}

/// The cause of a reset and its text, as they lie in memory. Any bits are allowed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct LastWords {
    cause: u32,
    length: u32,
    text: [u8; TEXT_BYTES],
    checksum: u32,
}

/// Why the program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A panic.
    Panic,
    /// A hard fault.
    HardFault,
}

impl From<Cause> for ResetReason {
    fn from(cause: Cause) -> Self {
        match cause {
            Cause::Panic => Self::Panic,
            Cause::HardFault => Self::HardFault,
        }
    }
}

impl LastWords {
    /// No text.
    pub const NONE: Self = Self {
        cause: 0,
        length: 0,
        text: [0; TEXT_BYTES],
        checksum: 0,
    };

    /// The words for this cause and text.
    pub fn new(cause: Cause, text: &Text) -> Self {
        let cause = match cause {
            Cause::Panic => 1,
            Cause::HardFault => 2,
        };
        let length = text.length as u32;
        let mut words = Self {
            cause,
            length,
            text: text.bytes,
            checksum: 0,
        };
        words.checksum = words.sum();
        words
    }

    /// Returns cause and text if the checksum is valid, `None` for arbitrary memory.
    pub fn read(&self) -> Option<(Cause, Text)> {
        let cause = match self.cause {
            1 => Cause::Panic,
            2 => Cause::HardFault,
            _ => return None,
        };
        let length = self.length as usize;
        (length <= TEXT_BYTES && self.checksum == self.sum()).then_some((
            cause,
            Text {
                bytes: self.text,
                length,
            },
        ))
    }

    fn sum(&self) -> u32 {
        let mut digest = CRC32.digest();
        digest.update(&self.cause.to_le_bytes());
        digest.update(&self.length.to_le_bytes());
        digest.update(&self.text);
        digest.finalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::format;
    use std::string::String;

    proptest! {
        #[test]
        fn numbers_read_as_the_formatter_writes_them(number: u32) {
            let text = Text::new().number(number).text(" 0x").address(number);
            prop_assert_eq!(text.as_str(), format!("{number} 0x{number:08x}"));
        }

        #[test]
        fn chance_says_nothing(cause in 0u32..4, length in 0u32..200, byte: u8, checksum: u32) {
            let words = LastWords { cause, length, text: [byte; TEXT_BYTES], checksum };
            prop_assert!(words.read().is_none());
        }

        #[test]
        fn any_text_fits_or_is_cut_off(said: String) {
            let words = LastWords::new(Cause::Panic, &Text::new().text(&said));
            let (cause, text) = words.read().expect("just written");
            prop_assert_eq!(cause, Cause::Panic);
            prop_assert_eq!(text.as_str().len(), said.chars().count().min(TEXT_BYTES));
        }
    }

    #[test]
    fn what_was_said_is_read_and_a_changed_bit_is_noticed() {
        let mut words = LastWords::new(Cause::HardFault, &Text::new().text("at 0x").address(7));
        let (cause, text) = words.read().expect("just written");
        assert_eq!((cause, text.as_str()), (Cause::HardFault, "at 0x00000007"));
        words.text[95] ^= 1;
        assert!(words.read().is_none());
        assert!(LastWords::NONE.read().is_none());
    }
}
