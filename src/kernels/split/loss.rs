//! What pixels have lost: sums over them, from which a light is made.

use std::ops::AddAssign;

use glam::{DMat3, DVec3};

use crate::kernels::image::LUMINANCE;

/// Integrals over some pixels, of which `T` was taken, with the luminance `Y`, and `M` is left; `b` is the bump.
#[derive(Clone, Copy)]
pub struct Loss {
    /// Of `T w` for each channel: its vector irradiance.
    pub vectors: [DVec3; 3],
    /// Of `M b w w^T` for each channel: what a tilt would change.
    pub tensors: [DMat3; 3],
    /// Of `Y`.
    pub flux: f64,
    /// Of `Y^2`.
    pub squares: f64,
}

impl Loss {
    pub const NONE: Self =
        Self { vectors: [DVec3::ZERO; 3], tensors: [DMat3::ZERO; 3], flux: 0.0, squares: 0.0 };

    /// What two sets of pixels have lost.
    pub fn and(mut self, other: Self) -> Self {
        add(&mut self.vectors, other.vectors);
        add(&mut self.tensors, other.tensors);
        Self { flux: self.flux + other.flux, squares: self.squares + other.squares, ..self }
    }

    /// The vector of the luminance.
    pub fn toward(&self) -> DVec3 {
        self.vectors.iter().zip(LUMINANCE).map(|(vector, weight)| weight * *vector).sum()
    }
}

fn add<T: AddAssign>(sums: &mut [T; 3], others: [T; 3]) {
    sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
}
