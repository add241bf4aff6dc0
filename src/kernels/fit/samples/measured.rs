//! What was measured: irradiance at normals, and how far a rig is from it.

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
    /// The same, side by side.
    pub(super) blocks: Blocks,
    /// Weighted sum of squares of the irradiance: the cost of no light at all.
    pub(crate) energy: f64,
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
    /// [`crate::error::Error::Negative`], [`crate::error::Error::NoMemory`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<Self> {
        // Each value twice, and what a search keeps at each normal.
        check_memory(&[normals.nrows(), 64])?;
        let normals = check_weighted(normals, ("irradiance", irradiance), weights)?;
        Ok(Self::of(normals, weights.to_vec(), to_vectors(irradiance)))
    }

    pub(crate) fn of(normals: Vec<DVec3>, weights: Vec<f64>, irradiance: Vec<DVec3>) -> Self {
        let blocks = Blocks::new(&normals, &weights, &irradiance);
        let energy = blocks.left(&Rig::default()).squares.iter().sum();
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
        self.blocks.left(rig).squares.iter().sum()
    }

    /// How far `rig` is from them.
    pub fn judged(&self, rig: &Rig) -> Judged {
        let (left, whole) = (self.blocks.left(rig), self.blocks.left(&Rig::default()));
        let [difference, whole] = [left, whole].map(|left| DVec3::from_array(left.squares));
        Judged::of(difference, whole, left.largest, self.weights.iter().sum())
    }

    /// Relative RMS error of `rig`; absolute where all is black.
    pub fn error(&self, rig: &Rig) -> f64 {
        relative_error(self.cost(rig), self.energy)
    }
}

/// How far a rig is from a probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct Judged {
    /// Relative RMS error over all channels.
    pub error: f64,
    /// That of each channel, relative to its own irradiance.
    pub channels: [f64; 3],
    /// The greatest difference at any normal and in any channel, relative to the RMS irradiance.
    pub largest: f64,
}

impl Judged {
    /// From sums over normals of the squared difference and of the squared irradiance, each with a weight, the largest
    /// difference, and the sum of the weights.
    pub fn of(difference: DVec3, whole: DVec3, largest: f64, weights: f64) -> Self {
        let rms = (whole.element_sum() / weights / 3.0).sqrt();
        let relative =
            |difference: f64, whole: f64| (difference / if whole > 0.0 { whole } else { 1.0 }).sqrt();
        Self {
            error: relative(difference.element_sum(), whole.element_sum()),
            channels: [0, 1, 2].map(|c| relative(difference[c], whole[c])),
            largest: largest / if rms > 0.0 { rms } else { 1.0 },
        }
    }
}
