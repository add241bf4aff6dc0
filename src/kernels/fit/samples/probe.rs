//! Irradiance at known normals, with the sums over normals that are computed once for a fit.

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use super::probe_samples::Samples;
use crate::kernels::fit::ambient::Ambient;
use crate::kernels::fit::objective::{Reference, distinct_channels};

/// Irradiance at known normals, with its products with the ambient term.
#[derive(Clone, Debug)]
pub struct Probe {
    pub(crate) samples: Samples,
    pub(super) reference: Reference,
    /// `w n n^T` of each normal.
    pub(super) outer: Vec<DMat3>,
    /// `w n y` of each normal and each side y, an ambient column or a channel of the irradiance.
    pub(super) by_side: Vec<DVec3>,
}

impl Probe {
    /// Prepare a fit of lights and an `ambient` term to `samples`.
    pub fn new(samples: Samples, ambient: Ambient) -> Self {
        let irradiance = &samples.irradiance;
        let (channels, like) = distinct_channels(
            |channel| irradiance.iter().all(|e| e[channel] == 0.0),
            |a, b| irradiance.iter().all(|e| e[a].to_bits() == e[b].to_bits()),
        );
        let energy = samples.energy;
        let reference = Reference { channels, like, energy, ..Reference::nothing(ambient, false) };
        let mut probe = Self { samples, reference, outer: Vec::new(), by_side: Vec::new() };
        let sides = probe.side_columns();
        let Samples { normals, weights, .. } = &probe.samples;
        let weighted =
            DMatrix::from_fn(sides.nrows(), sides.ncols(), |i, side| weights[i] * sides[(i, side)]);
        let outer = |(&n, &w): (&DVec3, &f64)| DMat3::from_cols(n * n.x, n * n.y, n * n.z) * w;
        probe.outer = normals.iter().zip(weights).map(outer).collect();
        let products = weighted.row_iter().zip(normals);
        probe.by_side =
            products.flat_map(|(row, &n)| row.iter().map(|y| n * *y).collect::<Vec<_>>()).collect();
        probe.reference.ambient_products = sides.columns(0, ambient.coefficients()).tr_mul(&weighted);
        probe
    }

    /// The sides, a row for each normal.
    pub(super) fn side_columns(&self) -> DMatrix<f64> {
        let ambient = self.reference.ambient.coefficients();
        DMatrix::from_fn(self.samples.normals.len(), self.reference.sides(), |i, side| {
            if side < ambient {
                self.reference.ambient.irradiance(self.samples.normals[i])[side]
            } else {
                self.samples.irradiance[i][self.reference.channels[side - ambient]]
            }
        })
    }
}
