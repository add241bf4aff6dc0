//! Irradiance at known normals, with the sums over normals that are computed once for a fit.

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::probe_samples::Samples;
use crate::kernels::fit::ambient::Ambient;
use crate::kernels::fit::objective::{Given, distinct_channels};

/// Irradiance at known normals, with its products with the ambient term.
#[derive(Clone, Debug)]
pub struct Probe {
    pub(crate) samples: Samples,
    pub(super) given: Given,
    /// `w n n^T` of each normal.
    pub(super) outer: Vec<DMat3>,
    /// `w n y` of each normal and each side y, an ambient column or a channel of the irradiance.
    pub(super) by_side: Vec<DVec3>,
}

impl Probe {
    /// Prepare a fit of lights and an `ambient` term to `samples`.
    pub fn new(samples: Samples, ambient: Ambient) -> Self {
        let weighted = samples.normals.iter().zip(&samples.weights);
        let outer = weighted.map(|(&n, &w)| DMat3::from_cols(n * n.x, n * n.y, n * n.z) * w).collect();
        let irradiance = &samples.irradiance;
        let (channels, like) = distinct_channels(
            |channel| irradiance.iter().all(|e| e[channel] == 0.0),
            |a, b| irradiance.iter().all(|e| e[a].to_bits() == e[b].to_bits()),
        );
        let columns = ambient.coefficients();
        let ambient_products = DMatrix::zeros(columns, columns + channels.len());
        let energy = samples.energy;
        let given = Given { ambient, has_floor: false, channels, like, ambient_products, energy };
        let mut probe = Self { samples, given, outer, by_side: Vec::new() };
        probe.sum_sides();
        probe
    }

    /// The sides, a row for each normal.
    pub(super) fn side_columns(&self) -> DMatrix<f64> {
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
