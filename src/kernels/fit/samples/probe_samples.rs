//! Irradiance at known normals, and the error of a rig there.

use glam::DVec3;
use ndarray::{ArrayView1, ArrayView2};

use super::blocks::Blocks;
use crate::error::Result;
use crate::kernels::disc::irradiance_share;
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
        let energy = blocks.squares(&Rig::default()).iter().sum();
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
        self.blocks.squares(rig).iter().sum()
    }

    /// Errors of a rig whose lights have these radii.
    pub fn evaluate(&self, rig: &Rig, radii: &[f64]) -> ProbeError {
        let ambient = Rig { directions: Vec::new(), irradiance: Vec::new(), ..rig.clone() };
        let (mut difference, mut whole, mut largest) = (DVec3::ZERO, DVec3::ZERO, 0.0_f64);
        for ((&n, &weight), &e) in self.normals.iter().zip(&self.weights).zip(&self.irradiance) {
            let lights = rig.directions.iter().zip(&rig.irradiance).zip(radii);
            let lit = lights.fold(ambient.at(n), |sum, ((l, irradiance), radius)| {
                sum + *irradiance * irradiance_share(n.dot(*l), *radius)
            });
            let off = (lit - e).abs();
            (difference, whole) = (difference + weight * off * off, whole + weight * e * e);
            largest = largest.max(off.max_element());
        }
        let rms = (whole.element_sum() / self.weights.iter().sum::<f64>() / 3.0).sqrt();
        ProbeError {
            largest: largest / if rms > 0.0 { rms } else { 1.0 },
            ..ProbeError::of(difference, whole)
        }
    }
}

/// Errors of a rig at the normals of a probe.
#[derive(Clone, Copy, Debug, Default)]
pub struct ProbeError {
    /// Relative RMS error over all channels.
    pub error: f64,
    /// Relative RMS error of each channel.
    pub channels: [f64; 3],
    /// Greatest difference at any normal and in any channel, relative to the RMS irradiance; 0 in closed form.
    pub largest: f64,
}

impl ProbeError {
    /// Errors from sums of the squared difference and of the squared irradiance by channel.
    pub fn of(difference: DVec3, whole: DVec3) -> Self {
        Self {
            error: relative_error(difference.element_sum(), whole.element_sum()),
            channels: [0, 1, 2].map(|c| relative_error(difference[c], whole[c])),
            largest: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;

    /// The cost is a sum of its own, over vectors of the processor.
    #[test]
    fn discs_of_radius_0_have_the_error_of_points() {
        let normals: Vec<DVec3> =
            (0..3000).map(|i| direction(3.1 * f64::from(i) / 3000.0, 2.4 * f64::from(i))).collect();
        let irradiance = normals.iter().map(|n| DVec3::new(2.0, 1.0 + n.x, 1.5 + n.y * n.z)).collect();
        let weights = (0..normals.len()).map(|i| 1.0 + (i % 7) as f64).collect();
        let samples = Samples::of(normals, weights, irradiance);
        let rig = Rig {
            ambient: vec![DVec3::new(0.3, 0.2, 0.1)],
            directions: vec![DVec3::Y, DVec3::new(2.0, 3.0, -6.0) / 7.0],
            irradiance: vec![DVec3::ONE, DVec3::new(0.1, 2.0, 0.3)],
            ..Rig::default()
        };
        let (error, cost) = (samples.evaluate(&rig, &[0.0; 2]).error, samples.cost(&rig));
        assert!((error.powi(2) * samples.energy / cost - 1.0).abs() < 1e-12, "{error} {cost}");
    }
}
