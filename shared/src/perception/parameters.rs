//! The parameters of the lattice (eq. 1) and what makes them admissible (eq. 2).

use core::fmt;

use serde::{Deserialize, Serialize};

use super::tables::{Lattice, REFERENCE_STEP, fastest_decay};

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

    /// Checks that the lattice forms Turing patterns (eq. 2) and that the fixed-point engine can
    /// follow it.
    ///
    /// # Errors
    ///
    /// The first condition that fails, in the order of [`LatticeError`]'s variants.
    pub const fn validate(&self) -> Result<(), LatticeError> {
        match Lattice::new(self) {
            Ok(_) => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// Everything but whether the coefficients fit their tables, which only the tables know.
    pub(super) const fn check(&self) -> Result<(), LatticeError> {
        let Self {
            mu,
            epsilon,
            s,
            d1,
            d2,
        } = *self;
        if !(mu.is_finite()
            && epsilon.is_finite()
            && s.is_finite()
            && d1.is_finite()
            && d2.is_finite())
        {
            return Err(LatticeError::NotFinite);
        }
        if epsilon <= 0.0 || s <= 0.0 || d1 <= 0.0 || d2 <= 0.0 {
            return Err(LatticeError::NotPositive);
        }
        if mu >= 0.0 {
            return Err(LatticeError::UniformStateGrows);
        }
        if mu * mu + s * s <= epsilon * epsilon {
            return Err(LatticeError::UniformStateUnstable);
        }
        // Written with products, the third condition also refuses d <= 1, where the quotient of
        // the paper changes its sign and would let pass what cannot form patterns.
        let d = d2 / d1;
        if epsilon * (d - 1.0) <= -mu * (d + 1.0) {
            return Err(LatticeError::NoActivatorRange);
        }
        let activation = d * (mu + epsilon) + (mu - epsilon);
        if activation * activation / (4.0 * d) <= mu * mu - epsilon * epsilon + s * s {
            return Err(LatticeError::NoUnstableBand);
        }
        if s > epsilon - mu {
            return Err(LatticeError::LayerTwoSaturates);
        }
        if REFERENCE_STEP * fastest_decay(self) >= 1.0 {
            return Err(LatticeError::TooStiff);
        }
        Ok(())
    }
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
