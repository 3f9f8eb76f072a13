//! Range checks of parameters in `const fn`s, and the error that all blocks report.

use core::fmt;

use crate::perception::LatticeError;

/// Why a set of parameters cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// The lattice would not form Turing patterns, or not ones the engine can calculate.
    Lattice(LatticeError),
    /// A number lies outside its range.
    OutOfRange {
        /// The parameter's name in a file.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The smallest value allowed.
        least: f64,
        /// The largest value allowed.
        most: f64,
    },
    /// The far end of a sensor's range is not at least 1 cm beyond the near end.
    EmptyRange {
        /// The name in a file of the parameter that is too small.
        name: &'static str,
    },
    /// k_F + 2 k_L + h pi exceeds the bound beyond which a reward does not fit 32 bits.
    RewardTooLarge {
        /// The bound.
        most: f64,
    },
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lattice(error) => write!(f, "{error}"),
            Self::OutOfRange {
                name,
                value,
                least,
                most,
            } => write!(
                f,
                "parameter {name} is {value}, expected a number from {least} to {most}"
            ),
            Self::EmptyRange { name } => write!(
                f,
                "parameter {name} must be at least 1 cm beyond its near end"
            ),
            Self::RewardTooLarge { most } => write!(
                f,
                "the reward weights are too large: front_gain + 2 side_gain + pi target_gain must not exceed {most}"
            ),
        }
    }
}

impl core::error::Error for ParameterError {}

/// Fails unless `value` is a number from `least` to `most`.
pub(crate) const fn check(
    name: &'static str,
    value: f64,
    least: f64,
    most: f64,
) -> Result<(), ParameterError> {
    if value >= least && value <= most {
        Ok(())
    } else {
        Err(ParameterError::OutOfRange {
            name,
            value,
            least,
            most,
        })
    }
}

/// `?` for `const fn`s, where it is not available.
macro_rules! const_try {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}
pub(crate) use const_try;

/// Returns the first error of [`check`] on each row.
macro_rules! check_all {
    ($($name:literal: $value:expr, $least:expr, $most:expr;)*) => {
        $($crate::range_check::const_try!($crate::range_check::check($name, $value, $least, $most));)*
    };
}
pub(crate) use check_all;
