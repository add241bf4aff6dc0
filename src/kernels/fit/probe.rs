//! What is to be reproduced: irradiance at normals, and all that a fit needs to know of it beforehand.

use glam::DVec3;
use nalgebra::DMatrix;
use ndarray::{ArrayView1, ArrayView2, Axis};

use super::ambient::Ambient;
use super::{Rig, model};
use crate::error::{Error, Result};
use crate::kernels::sphere::{check_rows, unit_vectors};

/// Probe values to be reproduced: normals with weights, and the irradiance at each.
#[derive(Clone, Debug)]
pub struct Probe {
    pub(super) normals: Vec<DVec3>,
    pub(super) weights: Vec<f64>,
    pub(super) irradiance: Vec<DVec3>,
    pub(super) ambient: Ambient,
    /// The channels that are fitted: neither black nor the same as one before.
    pub(super) channels: Vec<usize>,
    /// For each of red, green, blue its place in `channels`; none where it is black.
    pub(super) like: [Option<usize>; 3],
    /// Weighted sum of squares of the irradiance: the cost of no light at all.
    pub(super) energy: f64,
    /// `w n n^T` of each normal: its diagonal, and its entries xy, yz, zx.
    pub(super) outer: Vec<[DVec3; 2]>,
    /// `w n y` of each normal, for each [`Self::sides`] y.
    pub(super) lit: Vec<DVec3>,
    /// Weighted inner products of the ambient columns with each of [`Self::sides`].
    pub(super) ambient_gram: DMatrix<f64>,
}

impl Probe {
    /// Check and pair up what was measured.
    ///
    /// # Inputs
    ///
    /// - `normals`: (n, 3) unit vectors; `weights`: (n,), not negative.
    /// - `irradiance`: (n, 3) RGB, finite.
    /// - `ambient`: what may explain it beside lights.
    ///
    /// # Errors
    ///
    /// [`Error::WrongColumns`], [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::NotUnit`],
    /// [`Error::Negative`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
        ambient: Ambient,
    ) -> Result<Self> {
        let (normals, weights, irradiance) = checked(normals, weights, irradiance)?;
        Ok(Self::of(normals, weights, irradiance, ambient))
    }

    fn of(normals: Vec<DVec3>, weights: Vec<f64>, irradiance: Vec<DVec3>, ambient: Ambient) -> Self {
        let energy = irradiance.iter().zip(&weights).map(|(e, w)| w * e.length_squared()).sum();
        let outer =
            normals.iter().zip(&weights).map(|(&n, &w)| [n * n * w, n * DVec3::new(n.y, n.z, n.x) * w]);
        let (channels, like) = distinct(&irradiance);
        let mut probe = Self {
            outer: outer.collect(),
            lit: Vec::new(),
            ambient_gram: DMatrix::zeros(ambient.coefficients(), ambient.coefficients() + channels.len()),
            normals,
            weights,
            irradiance,
            ambient,
            channels,
            like,
            energy,
        };
        probe.sum_sides();
        probe
    }

    /// Columns that every light is multiplied with: those of the ambient term, then the irradiance in
    /// each channel.
    pub(super) fn sides(&self) -> usize {
        self.ambient.coefficients() + self.channels.len()
    }

    /// The sides themselves: a row for each normal.
    pub(super) fn side_columns(&self) -> DMatrix<f64> {
        let ambient = self.ambient.coefficients();
        DMatrix::from_fn(self.normals.len(), self.sides(), |i, side| {
            if side < ambient {
                self.ambient.irradiance(self.normals[i])[side]
            } else {
                self.irradiance[i][self.channels[side - ambient]]
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
        for (i, &normal) in self.normals.iter().enumerate() {
            let columns = self.ambient.irradiance(normal);
            let channels = self.channels.iter().map(|&channel| self.irradiance[i][channel]);
            let sides: Vec<f64> = columns[..ambient].iter().copied().chain(channels).collect();
            let weight = self.weights[i];
            self.lit.extend(sides.iter().map(|y| normal * (weight * y)));
            for (a, column) in columns[..ambient].iter().enumerate() {
                for (b, y) in sides.iter().enumerate() {
                    self.ambient_gram[(a, b)] += weight * column * y;
                }
            }
        }
    }
}

/// Probe values that judge a rig, and are not fitted.
#[derive(Clone, Debug)]
pub struct Judge {
    normals: Vec<DVec3>,
    weights: Vec<f64>,
    irradiance: Vec<DVec3>,
}

impl Judge {
    /// Check and pair up what was measured, as [`Probe::new`].
    ///
    /// # Errors
    ///
    /// As [`Probe::new`].
    pub fn new(
        normals: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<Self> {
        let (normals, weights, irradiance) = checked(normals, weights, irradiance)?;
        Ok(Self { normals, weights, irradiance })
    }

    /// Relative RMS error of `rig`; absolute where all is black.
    pub fn error(&self, rig: &Rig) -> f64 {
        let (mut left, mut whole) = (0.0, 0.0);
        for ((&normal, weight), &wanted) in self.normals.iter().zip(&self.weights).zip(&self.irradiance) {
            left += weight * (wanted - model::irradiance(rig, normal)).length_squared();
            whole += weight * wanted.length_squared();
        }
        if whole > 0.0 { (left / whole).sqrt() } else { left.sqrt() }
    }
}

type Values = (Vec<DVec3>, Vec<f64>, Vec<DVec3>);

fn checked(
    normals: ArrayView2<'_, f64>,
    weights: ArrayView1<'_, f64>,
    irradiance: ArrayView2<'_, f64>,
) -> Result<Values> {
    let normals = unit_vectors("normal", normals)?;
    check_rows("irradiance", irradiance, 3)?;
    check_rows("weights", weights.insert_axis(Axis(1)), 1)?;
    for (what, seen) in [("irradiance", irradiance.nrows()), ("weights", weights.len())] {
        let wanted = normals.len();
        if seen != wanted {
            return Err(Error::LengthMismatch { what, other: "normals", wanted, seen });
        }
    }
    if let Some((index, &value)) = weights.iter().enumerate().find(|(_, value)| **value < 0.0) {
        return Err(Error::Negative { what: "weights", index, value });
    }
    let irradiance = irradiance.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2]));
    Ok((normals, weights.to_vec(), irradiance.collect()))
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
