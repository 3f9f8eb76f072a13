//! Lengths and angles as logs have them: whole micrometres and microdegrees. Shapes say with
//! `#[serde(rename = "x_um", with = "um")]` that their centimetres are written so.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A number, or several.
pub(super) trait Numbers {
    type Whole: Serialize + DeserializeOwned;

    /// Multiplied by `scale`, and rounded.
    fn to_whole(&self, scale: f64) -> Self::Whole;

    /// Divided by `scale`.
    fn from_whole(whole: Self::Whole, scale: f64) -> Self;
}

impl Numbers for f64 {
    type Whole = i64;

    fn to_whole(&self, scale: f64) -> i64 {
        (self * scale).round() as i64
    }

    fn from_whole(whole: i64, scale: f64) -> Self {
        whole as f64 / scale
    }
}

impl Numbers for [f64; 2] {
    type Whole = [i64; 2];

    fn to_whole(&self, scale: f64) -> [i64; 2] {
        self.map(|number| number.to_whole(scale))
    }

    fn from_whole(whole: [i64; 2], scale: f64) -> Self {
        whole.map(|number| f64::from_whole(number, scale))
    }
}

impl Numbers for Vec<[f64; 2]> {
    type Whole = Vec<[i64; 2]>;

    fn to_whole(&self, scale: f64) -> Vec<[i64; 2]> {
        self.iter().map(|pair| pair.to_whole(scale)).collect()
    }

    fn from_whole(whole: Vec<[i64; 2]>, scale: f64) -> Self {
        let pairs = whole.into_iter();
        pairs
            .map(|pair| <[f64; 2]>::from_whole(pair, scale))
            .collect()
    }
}

macro_rules! whole {
    ($(#[$doc:meta])* $name:ident, $scale:literal) => {
        $(#[$doc])*
        pub(super) mod $name {
            use serde::{Deserialize, Deserializer, Serialize, Serializer};

            use super::Numbers;

            pub(in super::super) fn serialize<N: Numbers, S: Serializer>(
                numbers: &N,
                to: S,
            ) -> Result<S::Ok, S::Error> {
                numbers.to_whole($scale).serialize(to)
            }

            pub(in super::super) fn deserialize<'de, N: Numbers, D: Deserializer<'de>>(
                from: D,
            ) -> Result<N, D::Error> {
                N::Whole::deserialize(from).map(|whole| N::from_whole(whole, $scale))
            }
        }
    };
}

whole! {
    /// Centimetres, written as micrometres.
    um, 1e4
}
whole! {
    /// Degrees, written as microdegrees.
    udeg, 1e6
}
