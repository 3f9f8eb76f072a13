//! The linear spectrum of eq. 1: how fast each spatial mode decays or grows, and whether that makes
//! Turing patterns (eq. 2).

use super::parameters::{LatticeError, LatticeParameters};
use super::transform::mode_indices;
use crate::series::sqrt;

/// The integration constant of the paper (II-B).
pub(super) const REFERENCE_STEP: f64 = 0.001;

/// Checks that the lattice forms Turing patterns (eq. 2) and that the fixed-point engine can follow
/// it, but for the range of its coefficients.
pub(super) const fn check(parameters: &LatticeParameters) -> Result<(), LatticeError> {
    let LatticeParameters {
        mu,
        epsilon,
        s,
        d1,
        d2,
    } = *parameters;
    if !(mu.is_finite() && epsilon.is_finite() && s.is_finite() && d1.is_finite() && d2.is_finite())
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
    if REFERENCE_STEP * fastest_decay(parameters) >= 1.0 {
        return Err(LatticeError::TooStiff);
    }
    Ok(())
}

/// The rates of one mode in continuous time.
#[derive(Clone, Copy)]
pub(super) struct Rates {
    /// Decay of layer 1, p.
    pub p: f64,
    /// Decay of layer 2, r.
    pub r: f64,
    /// The larger eigenvalue of the unsaturated mode, if the two are real.
    pub growth: Option<f64>,
}

/// tan(pi / 8).
const TANGENT: f64 = 0.414_213_562_373_095_05;

/// The eigenvalue of a one-dimensional cosine, 2 - 2 cos(pi i / 4).
const fn eigenvalue(i: usize) -> f64 {
    const ROOT_2: f64 = TANGENT + 1.0;
    match i {
        0 => 0.0,
        1 => 2.0 - ROOT_2,
        2 => 2.0,
        _ => 2.0 + ROOT_2,
    }
}

/// The value of a one-dimensional cosine at its first cell.
pub(super) const fn end(i: usize) -> f64 {
    if i == 3 { TANGENT } else { 1.0 }
}

/// The squared length of the eigenvector stored at `place`, as `transform` scales it.
pub(super) const fn squared_length(place: usize) -> f64 {
    const ODD: f64 = 2.0 * (1.0 + TANGENT * TANGENT);
    let (i, j) = mode_indices(place);
    (if i % 2 == 0 { 4.0 } else { ODD }) * (if j % 2 == 0 { 4.0 } else { ODD })
}

pub(super) const fn rates(parameters: &LatticeParameters, place: usize) -> Rates {
    let LatticeParameters { mu, epsilon, s, .. } = *parameters;
    let (i, j) = mode_indices(place);
    let lambda = eigenvalue(i) + eigenvalue(j);
    let p = 1.0 + parameters.d1 * lambda;
    let r = epsilon - mu + parameters.d2 * lambda;
    let excitation = 1.0 + mu + epsilon - p;
    let discriminant = (excitation + r) * (excitation + r) - 4.0 * s * s;
    let growth = if discriminant >= 0.0 {
        Some(0.5 * (excitation - r + sqrt(discriminant)))
    } else {
        None
    };
    Rates { p, r, growth }
}

/// The fastest rate at which any mode decays: one of (3, 3), whose eigenvalue is the largest.
pub(super) const fn fastest_decay(parameters: &LatticeParameters) -> f64 {
    let lambda = 2.0 * eigenvalue(3);
    let p = 1.0 + parameters.d1 * lambda;
    let r = parameters.epsilon - parameters.mu + parameters.d2 * lambda;
    if p > r { p } else { r }
}
