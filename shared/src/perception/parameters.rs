//! The parameters of the lattice (eq. 1), and why a set of them is refused (eq. 2).

use core::fmt;

use serde::{Deserialize, Serialize};

/// The five parameters of eq. 1. Dimensionless, like the lattice's states and its time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LatticeParameters {
    /// The mean self-excitation of the two layers, mu.
    pub mu: f64,
    /// Half the difference of the two layers' self-excitation, epsilon.
    pub epsilon: f64,
    /// The coupling between the layers, s: layer 1 excites layer 2, layer 2 inhibits layer 1.
    pub s: f64,
    /// The diffusion coefficient of layer 1, D1.
    pub d1: f64,
    /// The diffusion coefficient of layer 2, D2.
    pub d2: f64,
}

impl Default for LatticeParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

impl LatticeParameters {
    /// The paper's choice (II-B).
    pub const PAPER: Self = Self {
        mu: -0.7,
        epsilon: 1.1,
        s: 0.9,
        d1: 0.05,
        d2: 15.0,
    };
}

/// Why a set of parameters cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LatticeError {
    /// A parameter is infinite or not a number.
    NotFinite,
    /// epsilon, s, D1 and D2 must be above zero.
    NotPositive,
    /// Eq. 2, first condition: mu < 0, or the uniform state grows.
    UniformStateGrows,
    /// Eq. 2, second condition: mu^2 + s^2 > epsilon^2, or the uniform state is unstable.
    UniformStateUnstable,
    /// Eq. 2, third condition: epsilon > -mu (d + 1) / (d - 1), with d = D2 / D1 > 1.
    NoActivatorRange,
    /// Eq. 2, fourth condition: [d (mu + epsilon) + mu - epsilon]^2 / 4d > mu^2 - epsilon^2 + s^2,
    /// or no spatial mode is unstable.
    NoUnstableBand,
    /// s <= epsilon - mu keeps layer 2 within its linear range, which the engine relies on.
    LayerTwoSaturates,
    /// The fastest layer-2 mode decays within one integration step of the reference.
    TooStiff,
    /// A coefficient leaves the range of the fixed-point tables.
    CoefficientOutOfRange,
}

impl fmt::Display for LatticeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a lattice parameter is infinite or not a number",
            Self::NotPositive => "epsilon, s, d1 and d2 must be above zero",
            Self::UniformStateGrows => "no Turing patterns (eq. 2): mu must be below zero",
            Self::UniformStateUnstable => {
                "no Turing patterns (eq. 2): mu^2 + s^2 must be above epsilon^2"
            }
            Self::NoActivatorRange => {
                "no Turing patterns (eq. 2): epsilon must be above -mu (d + 1) / (d - 1), with d = d2 / d1 > 1"
            }
            Self::NoUnstableBand => {
                "no Turing patterns (eq. 2): [d (mu + epsilon) + mu - epsilon]^2 / 4d must be above \
                 mu^2 - epsilon^2 + s^2, with d = d2 / d1"
            }
            Self::LayerTwoSaturates => {
                "layer 2 could saturate: s must not be above epsilon - mu"
            }
            Self::TooStiff => {
                "too stiff: epsilon - mu + 6.83 d2 and 1 + 6.83 d1 must be below 1000"
            }
            Self::CoefficientOutOfRange => {
                "a coefficient leaves the range of the fixed-point tables"
            }
        })
    }
}

impl core::error::Error for LatticeError {}
