//! What was measured: irradiance at normals, and how far a rig is from it.

use glam::DVec3;
use ndarray::{ArrayView1, ArrayView2};

use super::Rig;
use super::blocks::Blocks;
use crate::error::Result;
use crate::kernels::sphere::{check_weighted, to_vectors};

/// Irradiance at normals, each with a weight.
#[derive(Clone, Debug)]
pub struct Samples {
    pub(super) normals: Vec<DVec3>,
    pub(super) weights: Vec<f64>,
    pub(super) irradiance: Vec<DVec3>,
    /// The same, side by side.
    pub(super) blocks: Blocks,
    /// Weighted sum of squares of the irradiance: the cost of no light at all.
    pub(super) energy: f64,
}

impl Samples {
    /// Check and pair up what was measured.
    ///
    /// # Inputs
    ///
    /// - `normals`: (n, 3) unit vectors; `weights`: (n,), not negative.
    /// - `irradiance`: (n, 3) RGB, finite.
    ///
    /// # Errors
    ///
    /// [`crate::error::Error::WrongColumns`], [`crate::error::Error::LengthMismatch`],
    /// [`crate::error::Error::NotFinite`], [`crate::error::Error::NotUnit`],
    /// [`crate::error::Error::Negative`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<Self> {
        let normals = check_weighted(normals, ("irradiance", irradiance), weights)?;
        Ok(Self::of(normals, weights.to_vec(), to_vectors(irradiance)))
    }

    fn of(normals: Vec<DVec3>, weights: Vec<f64>, irradiance: Vec<DVec3>) -> Self {
        let blocks = Blocks::new(&normals, &weights, &irradiance);
        let energy = blocks.cost(&Rig::default());
        Self { normals, weights, irradiance, blocks, energy }
    }

    /// Those at the normals that `are_kept`; none where all are.
    pub fn only(&self, are_kept: impl Fn(DVec3) -> bool) -> Option<Self> {
        let kept: Vec<usize> = (0..self.normals.len()).filter(|&i| are_kept(self.normals[i])).collect();
        (kept.len() < self.normals.len()).then(|| {
            let normals = kept.iter().map(|&i| self.normals[i]).collect();
            let weights = kept.iter().map(|&i| self.weights[i]).collect();
            Self::of(normals, weights, kept.iter().map(|&i| self.irradiance[i]).collect())
        })
    }

    /// Weighted sum of squares of what `rig` leaves unexplained.
    pub fn cost(&self, rig: &Rig) -> f64 {
        self.blocks.cost(rig)
    }

    /// Relative RMS error of `rig`; absolute where all is black.
    pub fn error(&self, rig: &Rig) -> f64 {
        let cost = self.cost(rig);
        if self.energy > 0.0 { (cost / self.energy).sqrt() } else { cost.sqrt() }
    }
}
