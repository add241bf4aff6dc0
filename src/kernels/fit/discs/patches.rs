//! The bright cells and sources of a map, each kept apart as a disc of the same spread, and the cone of a kernel between
//! them and the discs of lights.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;

use glam::DVec3;
use ndarray::{Array3, ArrayView1};
use pulp::{Arch, Simd, WithSimd};

use super::chord::mean_distance;
use super::disc::{Disc, on_tangents};
use super::harmonics::Harmonics;
use super::jet::Jet;
use super::synthesis::Sum;
use crate::kernels::image::{Grid, Part, WorkingMap};
use crate::kernels::sphere::direction;

/// A bright cell of the map, as a disc of the same spread.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub direction: DVec3,
    pub share: f64,
    pub flux: [f64; 3],
}

/// Cells that are too bright for harmonics to be sharp enough, taken out of the map: each with more than a share of the
/// flux, where its radiance stands out.
pub fn bright_cells(radiance: &mut Array3<f32>, grid: &Grid) -> Vec<Patch> {
    /// Of the flux of all channels.
    const SHARE: f64 = 1.5e-3;
    /// Times the mean radiance.
    const STANDS_OUT: f64 = 8.0;
    let bands: Vec<f64> = grid.theta_edges.windows(2).map(|edges| edges[0].cos() - edges[1].cos()).collect();
    let widths: Vec<f64> = grid.phi_edges.windows(2).map(|edges| edges[1] - edges[0]).collect();
    let sum = |cell: ArrayView1<'_, f32>| f64::from(cell[0] + cell[1] + cell[2]);
    let mut whole = 0.0;
    for (row, band) in radiance.outer_iter().zip(&bands) {
        whole += band * row.outer_iter().zip(&widths).map(|(cell, width)| width * sum(cell)).sum::<f64>();
    }
    let bright = STANDS_OUT * whole / (4.0 * PI);
    let mut patches = Vec::new();
    for (y, mut row) in radiance.outer_iter_mut().enumerate() {
        let (top, height) = (grid.theta_edges[y], grid.theta_edges[y + 1] - grid.theta_edges[y]);
        for (x, mut cell) in row.outer_iter_mut().enumerate() {
            let solid_angle = bands[y] * widths[x];
            let own = sum(cell.view());
            if own > bright && own * solid_angle > SHARE * whole {
                let theta = top + 0.5 * height;
                let direction = direction(theta, grid.phi_edges[x] + 0.5 * widths[x]);
                let share = (height.powi(2) + (widths[x] * theta.sin()).powi(2)) / 24.0;
                let flux = [0, 1, 2].map(|c| f64::from(cell[c]) * solid_angle);
                patches.push(Patch { direction, share, flux });
                cell.fill(0.0);
            }
        }
    }
    patches
}

/// The sources of the map as discs. Where their channels have their middles aside of each other, the first degree of
/// the `rest` takes the difference.
pub fn sources(map: &WorkingMap, rest: &mut Harmonics) -> Vec<Patch> {
    let mut patches = Vec::new();
    for &Part { irradiance: [x, y, z], spread: share } in &map.parts {
        let vectors = [0, 1, 2].map(|c| DVec3::new(x[c], y[c], z[c]));
        let Some(direction) = vectors.iter().sum::<DVec3>().try_normalize() else { continue };
        let along = vectors.map(|vector| vector.dot(direction).max(0.0));
        for c in 0..3 {
            rest.add_first(c, vectors[c] - along[c] * direction);
        }
        patches.push(Patch { direction, share, flux: along.map(|vector| vector / (1.0 - share)) });
    }
    patches
}

/// The mean distance between the points of patches, times their fluxes, over all pairs and by channel.
pub fn distances(patches: &[Patch]) -> [f64; 3] {
    Arch::new().dispatch(Distances { patches })
}

/// The mean distance between the points of a disc and of patches, times the fluxes of these, by channel.
pub fn distances_to(disc: &Disc, patches: &[Patch]) -> [f64; 3] {
    Arch::new().dispatch(To { disc, patches })
}

/// The same with first derivatives, and second ones of the channels with these `shares`.
pub fn distances_around(disc: &Disc, patches: &[Patch], shares: [f64; 3]) -> Sum {
    Arch::new().dispatch(Around { disc, patches, shares })
}

/// See [`distances`].
struct Distances<'a> {
    patches: &'a [Patch],
}

impl WithSimd for Distances<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let mut out = [0.0; 3];
        for (i, one) in self.patches.iter().enumerate() {
            for (k, other) in self.patches[..=i].iter().enumerate() {
                let cosine = if i == k { 1.0 } else { one.direction.dot(other.direction) };
                let [c, a, b] =
                    [Jet::<0>::constant(cosine), Jet::constant(one.share), Jet::constant(other.share)];
                let distance = mean_distance(c, a, b).value * if i == k { 1.0 } else { 2.0 };
                for c in 0..3 {
                    out[c] += distance * one.flux[c] * other.flux[c];
                }
            }
        }
        out
    }
}

/// See [`distances_to`].
struct To<'a> {
    disc: &'a Disc,
    patches: &'a [Patch],
}

impl WithSimd for To<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let Self { disc, patches } = self;
        let mut out = [0.0; 3];
        for patch in patches {
            let cosine = Jet::<0>::constant(disc.direction.dot(patch.direction));
            let distance = mean_distance(cosine, Jet::constant(disc.share), Jet::constant(patch.share)).value;
            for (out, flux) in out.iter_mut().zip(patch.flux) {
                *out += distance * flux;
            }
        }
        out
    }
}

/// See [`distances_around`].
struct Around<'a> {
    disc: &'a Disc,
    patches: &'a [Patch],
    shares: [f64; 3],
}

impl WithSimd for Around<'_> {
    type Output = Sum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sum {
        let Self { disc, patches, shares } = self;
        let mut out = Sum::default();
        for patch in patches {
            let cosine = disc.direction.dot(patch.direction);
            let distance = mean_distance(
                Jet::<2>::variable(cosine, 0),
                Jet::variable(disc.share, 1),
                Jet::constant(patch.share),
            );
            let distance = on_tangents(&distance, disc, patch.direction, cosine);
            let weight = shares[0] * patch.flux[0] + shares[1] * patch.flux[1] + shares[2] * patch.flux[2];
            for i in 0..3 {
                out.value[i] += distance.value * patch.flux[i];
                for k in 0..3 {
                    out.first[i][k] += distance.first[i] * patch.flux[k];
                    out.second[i][k] += distance.second[i][k] * weight;
                }
            }
        }
        out
    }
}
