//! Given normals: irradiance that was measured, or rendered elsewhere, and how far a rig is from it.
//!
//! | step                                       | file         |
//! |--------------------------------------------|--------------|
//! | what runs over all normals                 | `blocks.rs`  |
//! | sums over the normals that see two lights  | `visible.rs` |

mod blocks;
mod visible;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;
use ndarray::{ArrayView1, ArrayView2};

use self::blocks::Blocks;
use super::Rig;
use super::ambient::Ambient;
use super::objective::{Directions, Given, Moments, Objective, distinct_channels};
use crate::error::Result;
use crate::kernels::sphere::{check_weighted, to_vectors};

/// Irradiance at normals, each with a weight.
#[derive(Clone, Debug)]
pub struct Samples {
    pub(super) normals: Vec<DVec3>,
    pub(super) weights: Vec<f64>,
    pub(super) irradiance: Vec<DVec3>,
    /// The same, side by side.
    blocks: Blocks,
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

    pub(super) fn of(normals: Vec<DVec3>, weights: Vec<f64>, irradiance: Vec<DVec3>) -> Self {
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

    /// How far `rig` is from them.
    pub fn judged(&self, rig: &Rig) -> Judged {
        let (mut difference, mut whole, mut largest) = (DVec3::ZERO, DVec3::ZERO, 0.0_f64);
        for ((&n, &weight), &e) in self.normals.iter().zip(&self.weights).zip(&self.irradiance) {
            let off = (rig.at(n) - e).abs();
            difference += weight * off * off;
            whole += weight * e * e;
            largest = largest.max(off.max_element());
        }
        let weights: f64 = self.weights.iter().sum();
        let rms = (whole.element_sum() / weights / 3.0).sqrt();
        let relative = |c: usize| (difference[c] / if whole[c] > 0.0 { whole[c] } else { 1.0 }).sqrt();
        Judged {
            error: self.error(rig),
            channels: [0, 1, 2].map(relative),
            largest: largest / if rms > 0.0 { rms } else { 1.0 },
        }
    }

    /// Relative RMS error of `rig`; absolute where all is black.
    pub fn error(&self, rig: &Rig) -> f64 {
        let cost = self.cost(rig);
        if self.energy > 0.0 { (cost / self.energy).sqrt() } else { cost.sqrt() }
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

/// Samples to be reproduced, and all that a fit needs to know of them beforehand.
#[derive(Clone, Debug)]
pub struct Probe {
    pub(super) samples: Samples,
    given: Given,
    /// `w n n^T` of each normal.
    outer: Vec<DMat3>,
    /// `w n y` of each normal, for each side y.
    by_side: Vec<DVec3>,
}

impl Probe {
    /// `samples` that lights and an `ambient` term may explain.
    pub fn new(samples: Samples, ambient: Ambient) -> Self {
        let weighted = samples.normals.iter().zip(&samples.weights);
        let outer = weighted.map(|(&n, &w)| DMat3::from_cols(n * n.x, n * n.y, n * n.z) * w).collect();
        let seen = &samples.irradiance;
        let (channels, like) = distinct_channels(
            |channel| seen.iter().all(|e| e[channel] == 0.0),
            |a, b| seen.iter().all(|e| e[a].to_bits() == e[b].to_bits()),
        );
        let columns = ambient.coefficients();
        let ambient_products = DMatrix::zeros(columns, columns + channels.len());
        let energy = samples.energy;
        let given = Given { ambient, has_floor: false, channels, like, ambient_products, energy };
        let mut probe = Self { samples, given, outer, by_side: Vec::new() };
        probe.sum_sides();
        probe
    }

    /// The sides themselves: a row for each normal.
    fn side_columns(&self) -> DMatrix<f64> {
        let ambient = self.given.ambient.coefficients();
        DMatrix::from_fn(self.samples.normals.len(), self.given.sides(), |i, side| {
            if side < ambient {
                self.given.ambient.irradiance(self.samples.normals[i])[side]
            } else {
                self.samples.irradiance[i][self.given.channels[side - ambient]]
            }
        })
    }

    fn sum_sides(&mut self) {
        let ambient = self.given.ambient.coefficients();
        for (i, &normal) in self.samples.normals.iter().enumerate() {
            let columns = self.given.ambient.irradiance(normal);
            let channels = self.given.channels.iter().map(|&channel| self.samples.irradiance[i][channel]);
            let sides: Vec<f64> = columns[..ambient].iter().copied().chain(channels).collect();
            let weight = self.samples.weights[i];
            self.by_side.extend(sides.iter().map(|y| normal * (weight * y)));
            for (a, column) in columns[..ambient].iter().enumerate() {
                for (b, y) in sides.iter().enumerate() {
                    self.given.ambient_products[(a, b)] += weight * column * y;
                }
            }
        }
    }
}

impl Objective for Probe {
    fn given(&self) -> &Given {
        &self.given
    }

    fn moments(&self, directions: Vec<DVec3>) -> Moments {
        let nothing = Moments::new(&self.given, Vec::new(), Vec::new(), Vec::new());
        self.exchanged(&nothing, &[], &directions)
    }

    fn exchanged(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments {
        visible::exchanged(self, before, kept, new)
    }

    fn turned(&self, before: &Moments, directions: Vec<DVec3>) -> Moments {
        visible::turned(self, before, directions)
    }

    fn kinks(&self, from: &Moments, to: &Moments) -> Vec<(usize, DVec3)> {
        visible::crossed(self, from, to)
    }

    fn second_derivative(&self, _: DVec3, _: &[(f64, DVec3)], _: &[f64]) -> Option<DMat3> {
        None
    }

    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64> {
        let mut products = DMatrix::zeros(at.directions.len(), lights.len());
        for (light, mut products) in lights.iter().zip(products.column_iter_mut()) {
            // Half of the normals do not see the light.
            for (weighted, normal) in at.weighted.column_iter().zip(&self.samples.normals) {
                let along = normal.dot(*light);
                if along > 0.0 {
                    products.axpy(along, &weighted, 1.0);
                }
            }
        }
        products
    }

    fn side_products(&self, at: &Directions) -> DMatrix<f64> {
        &at.weighted * self.side_columns()
    }

    fn squares(&self, at: &Directions) -> Vec<f64> {
        let square = |d: &DVec3| {
            let normals = self.samples.normals.iter().zip(&self.samples.weights);
            normals.map(|(n, w)| w * n.dot(*d).max(0.0).powi(2)).sum()
        };
        at.directions.iter().map(square).collect()
    }

    fn directions(&self, directions: Vec<DVec3>) -> Directions {
        let Samples { normals, weights, .. } = &self.samples;
        let weighted = DMatrix::from_fn(directions.len(), normals.len(), |i, n| {
            weights[n] * normals[n].dot(directions[i]).max(0.0)
        });
        Directions { directions, weighted }
    }

    fn has_kinks(&self) -> bool {
        /// Normals so close together that the kinks between them no longer make valleys of their own.
        const SMOOTH: usize = 1280;
        self.samples.normals.len() < SMOOTH
    }

    fn exact_cost(&self, rig: &Rig) -> Option<f64> {
        Some(self.samples.cost(rig))
    }
}
