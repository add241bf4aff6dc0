//! Irradiance at known normals, and the error of a rig there.

use glam::DVec3;
use ndarray::{ArrayView1, ArrayView2};

use super::blocks::Blocks;
use crate::error::Result;
use crate::kernels::fit::relative_rms::relative_error;
use crate::kernels::fit::rig::Rig;
use crate::kernels::sphere::{check_memory, check_weighted, to_vectors};

/// Irradiance at normals, each with a weight.
#[derive(Clone, Debug)]
pub struct Samples {
    pub(crate) normals: Vec<DVec3>,
    pub(crate) weights: Vec<f64>,
    pub(crate) irradiance: Vec<DVec3>,
    /// The samples in blocks.
    pub(super) blocks: Blocks,
    /// Weighted sum of squares of the irradiance, which is the cost without any light.
    pub(crate) energy: f64,
}

impl Samples {
    /// Check and pair normals, weights and irradiance.
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
    /// [`crate::error::Error::Negative`], [`crate::error::Error::NoMemory`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<Self> {
        // Count each value twice, and the sums of a search at each normal.
        check_memory(&[normals.nrows(), 64])?;
        let normals = check_weighted(normals, ("irradiance", irradiance), weights)?;
        Ok(Self::of(normals, weights.to_vec(), to_vectors(irradiance)))
    }

    pub(crate) fn of(normals: Vec<DVec3>, weights: Vec<f64>, irradiance: Vec<DVec3>) -> Self {
        let blocks = Blocks::new(&normals, &weights, &irradiance);
        let energy = blocks.residual(&Rig::default()).squares.iter().sum();
        Self { normals, weights, irradiance, blocks, energy }
    }

    /// The samples at the normals that pass a test; `None` if all do.
    pub fn only(&self, is_used: impl Fn(DVec3) -> bool) -> Option<Self> {
        let used: Vec<usize> = (0..self.normals.len()).filter(|&i| is_used(self.normals[i])).collect();
        (used.len() < self.normals.len()).then(|| {
            let normals = used.iter().map(|&i| self.normals[i]).collect();
            let weights = used.iter().map(|&i| self.weights[i]).collect();
            Self::of(normals, weights, used.iter().map(|&i| self.irradiance[i]).collect())
        })
    }

    /// Weighted sum of squares of the difference to `rig`.
    pub fn cost(&self, rig: &Rig) -> f64 {
        self.blocks.residual(rig).squares.iter().sum()
    }

    /// Errors of `rig`.
    pub fn evaluate(&self, rig: &Rig) -> ProbeError {
        let (residual, all) = (self.blocks.residual(rig), self.blocks.residual(&Rig::default()));
        let largest = residual.largest;
        let [difference, whole] = [residual, all].map(|residual| DVec3::from_array(residual.squares));
        ProbeError::of(difference, whole).with_largest(largest, whole, self.weights.iter().sum())
    }

    /// Relative RMS error of `rig`; absolute if all irradiance is 0.
    pub fn error(&self, rig: &Rig) -> f64 {
        relative_error(self.cost(rig), self.energy)
    }
}

/// Errors of a rig at the normals of a probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeError {
    /// Relative RMS error over all channels.
    pub error: f64,
    /// Relative RMS error of each channel.
    pub channels: [f64; 3],
    /// Greatest difference at any normal and in any channel, relative to the RMS irradiance; unknown in closed form.
    pub largest: Option<f64>,
}

impl ProbeError {
    /// Errors from sums of the squared difference and of the squared irradiance by channel.
    pub fn of(difference: DVec3, whole: DVec3) -> Self {
        Self {
            error: relative_error(difference.element_sum(), whole.element_sum()),
            channels: [0, 1, 2].map(|c| relative_error(difference[c], whole[c])),
            largest: None,
        }
    }

    /// Errors with the largest difference, from the squared irradiance and the sum of the weights of normals.
    #[must_use]
    pub fn with_largest(self, largest: f64, whole: DVec3, weights: f64) -> Self {
        let rms = (whole.element_sum() / weights / 3.0).sqrt();
        Self { largest: Some(largest / if rms > 0.0 { rms } else { 1.0 }), ..self }
    }
}
