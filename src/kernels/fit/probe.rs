//! What is to be reproduced: irradiance at normals, and all that a fit needs to know of it beforehand.

use glam::DVec3;
use nalgebra::DMatrix;

use super::Samples;
use super::ambient::Ambient;

/// Samples to be reproduced, and what may explain them.
#[derive(Clone, Debug)]
pub struct Probe {
    pub(super) samples: Samples,
    pub(super) ambient: Ambient,
    /// The channels that are fitted: neither black nor the same as one before.
    pub(super) channels: Vec<usize>,
    /// For each of red, green, blue its place in `channels`; none where it is black.
    pub(super) like: [Option<usize>; 3],
    /// `w n n^T` of each normal: its diagonal, and its entries xy, yz, zx.
    pub(super) outer: Vec<[f64; 6]>,
    /// `w n y` of each normal, x, y, z for each [`Self::sides`] y: a row for each normal, of
    /// [`Self::lit_length`].
    pub(super) lit: Vec<[f64; 4]>,
    /// Weighted inner products of the ambient columns with each of [`Self::sides`].
    pub(super) ambient_gram: DMatrix<f64>,
}

impl Probe {
    /// `samples` that lights and an `ambient` term may explain.
    pub fn new(samples: Samples, ambient: Ambient) -> Self {
        let weighted = samples.normals.iter().zip(&samples.weights);
        let outer = weighted.map(|(&n, &w)| outer(n, w)).collect();
        let (channels, like) = distinct(&samples.irradiance);
        let columns = ambient.coefficients();
        let ambient_gram = DMatrix::zeros(columns, columns + channels.len());
        let lit = Vec::new();
        let mut probe = Self { samples, ambient, channels, like, outer, lit, ambient_gram };
        probe.sum_sides();
        probe
    }

    /// Columns that every light is multiplied with: those of the ambient term, then the irradiance in
    /// each channel.
    pub(super) fn sides(&self) -> usize {
        self.ambient.coefficients() + self.channels.len()
    }

    /// Length of a row of [`Self::lit`], of which the last vector is filled up with zeros.
    pub(super) fn lit_length(&self) -> usize {
        (3 * self.sides()).div_ceil(4).max(1)
    }

    /// The sides themselves: a row for each normal.
    pub(super) fn side_columns(&self) -> DMatrix<f64> {
        let ambient = self.ambient.coefficients();
        DMatrix::from_fn(self.samples.normals.len(), self.sides(), |i, side| {
            if side < ambient {
                self.ambient.irradiance(self.samples.normals[i])[side]
            } else {
                self.samples.irradiance[i][self.channels[side - ambient]]
            }
        })
    }

    /// Ambient coefficients that may have any sign: harmonics do, a radiance does not.
    pub(super) fn free(&self) -> usize {
        if self.ambient == Ambient::Sh2 { self.ambient.coefficients() } else { 0 }
    }

    /// How many of red, green, blue a fitted channel stands for.
    pub(super) fn copies(&self, channel: usize) -> f64 {
        self.like.iter().filter(|like| **like == Some(channel)).count() as f64
    }

    fn sum_sides(&mut self) {
        let ambient = self.ambient.coefficients();
        for (i, &normal) in self.samples.normals.iter().enumerate() {
            let columns = self.ambient.irradiance(normal);
            let channels = self.channels.iter().map(|&channel| self.samples.irradiance[i][channel]);
            let sides: Vec<f64> = columns[..ambient].iter().copied().chain(channels).collect();
            let weight = self.samples.weights[i];
            let mut row: Vec<f64> = sides.iter().flat_map(|y| (normal * (weight * y)).to_array()).collect();
            row.resize(4 * self.lit_length(), 0.0);
            self.lit.extend_from_slice(row.as_chunks().0);
            for (a, column) in columns[..ambient].iter().enumerate() {
                for (b, y) in sides.iter().enumerate() {
                    self.ambient_gram[(a, b)] += weight * column * y;
                }
            }
        }
    }
}

fn outer(n: DVec3, weight: f64) -> [f64; 6] {
    [n.x * n.x, n.y * n.y, n.z * n.z, n.x * n.y, n.y * n.z, n.z * n.x].map(|product| weight * product)
}

/// The channels that have to be fitted, and for each of the three the one that it is like.
fn distinct(irradiance: &[DVec3]) -> (Vec<usize>, [Option<usize>; 3]) {
    let mut channels: Vec<usize> = Vec::new();
    let mut like = [None; 3];
    for (channel, like) in like.iter_mut().enumerate() {
        if irradiance.iter().all(|e| e[channel] == 0.0) {
            continue;
        }
        let same = |other: usize| irradiance.iter().all(|e| e[other].to_bits() == e[channel].to_bits());
        let place = channels.iter().position(|&other| same(other));
        *like = place.or_else(|| {
            channels.push(channel);
            Some(channels.len() - 1)
        });
    }
    (channels, like)
}
