//! The bright cells and sources of a map, each kept apart as a disc of the same spread, and the cone of a kernel between
//! them and the discs of lights.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::iter::repeat;

use glam::DVec3;
use ndarray::{Array3, ArrayView1};
use pulp::{Arch, Simd, WithSimd};

use super::chord::mean_distance;
use super::disc::{Disc, on_tangents};
use super::harmonics::Harmonics;
use super::jet::Jet;
use super::lanes::{Lanes, MOST, Number};
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

/// Patches, number by number, so that vectors hold several of them.
#[derive(Clone, Debug)]
pub struct Patches {
    count: usize,
    direction: [Vec<f64>; 3],
    share: Vec<f64>,
    flux: [Vec<f64>; 3],
}

impl Patches {
    pub fn new(patches: &[Patch]) -> Self {
        // Fill the last vector with black ones.
        let black = Patch { direction: DVec3::Y, share: 1.0, flux: [0.0; 3] };
        let padded = patches.iter().copied().chain(repeat(black));
        let padded: Vec<Patch> = padded.take(patches.len().next_multiple_of(MOST)).collect();
        let of = |number: &dyn Fn(&Patch) -> f64| padded.iter().map(number).collect::<Vec<_>>();
        Self {
            count: patches.len(),
            direction: [0, 1, 2].map(|i| of(&|patch| patch.direction[i])),
            share: of(&|patch| patch.share),
            flux: [0, 1, 2].map(|c| of(&|patch| patch.flux[c])),
        }
    }

    /// The mean distance between the points of a disc and of patches, times the fluxes of these, by channel.
    pub fn distances_to(&self, direction: DVec3, share: f64) -> [f64; 3] {
        Arch::new().dispatch(To { direction, share, patches: self })
    }

    /// The derivatives of the same, second ones of the channels with these `shares`.
    pub fn distances_around(&self, disc: &Disc, shares: [f64; 3]) -> Sum {
        Arch::new().dispatch(Around { disc, patches: self, shares })
    }

    /// Direction, A and flux of patch after patch.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S) -> impl Iterator<Item = ([Lanes<S>; 3], Lanes<S>, [Lanes<S>; 3])> {
        let patches =
            triples(simd, &self.direction).zip(Lanes::of(simd, &self.share)).zip(triples(simd, &self.flux));
        patches.map(|((d, share), flux)| (d, share, flux)).take(self.count.div_ceil(S::F64_LANES))
    }
}

/// Three numbers of each patch.
#[inline(always)]
fn triples<S: Simd>(simd: S, numbers: &[Vec<f64>; 3]) -> impl Iterator<Item = [Lanes<S>; 3]> {
    let [x, y, z] = [&numbers[0], &numbers[1], &numbers[2]].map(|numbers| Lanes::of(simd, numbers));
    x.zip(y).zip(z).map(|((x, y), z)| [x, y, z])
}

/// The mean distance between the points of patches, times their fluxes, over all pairs and by channel.
pub fn distances(patches: &[Patch]) -> [f64; 3] {
    let all = Patches::new(patches);
    let mut out = [0.0; 3];
    for one in patches {
        let distances = all.distances_to(one.direction, one.share);
        (0..3).for_each(|c| out[c] += one.flux[c] * distances[c]);
    }
    out
}

#[inline(always)]
fn dot<S: Simd>(one: DVec3, other: [Lanes<S>; 3]) -> Lanes<S> {
    let [x, y, z] = other;
    x * x.like(one.x) + y * y.like(one.y) + z * z.like(one.z)
}

/// See [`Patches::distances_to`].
struct To<'a> {
    direction: DVec3,
    share: f64,
    patches: &'a Patches,
}

impl WithSimd for To<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let own = Lanes::splat(simd, self.share);
        let mut out = [Lanes::splat(simd, 0.0); 3];
        for (towards, share, flux) in self.patches.lanes(simd) {
            let [c, a, b] = [dot(self.direction, towards), own, share].map(Jet::<0, _>::constant);
            let distance = mean_distance(c, a, b).value;
            for c in 0..3 {
                out[c] = out[c] + distance * flux[c];
            }
        }
        out.map(Lanes::sum)
    }
}

/// See [`Patches::distances_around`].
struct Around<'a> {
    disc: &'a Disc,
    patches: &'a Patches,
    shares: [f64; 3],
}

impl WithSimd for Around<'_> {
    type Output = Sum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sum {
        let Self { disc, patches, shares } = self;
        let [s, t] = disc.frame();
        let shares = shares.map(|share| Lanes::splat(simd, share));
        let own = Lanes::splat(simd, disc.share);
        let zero = own.like(0.0);
        let (mut first, mut second) = ([[zero; 3]; 3], [[zero; 3]; 3]);
        for (towards, share, flux) in patches.lanes(simd) {
            let cosine = dot(disc.direction, towards);
            let [c, a] = [Jet::<2, _>::variable(cosine, 0), Jet::variable(own, 1)];
            let distance = mean_distance(c, a, Jet::constant(share));
            let distance = on_tangents(&distance, cosine, [dot(s, towards), dot(t, towards)]);
            let weight = shares[0] * flux[0] + shares[1] * flux[1] + shares[2] * flux[2];
            for i in 0..3 {
                for k in 0..3 {
                    first[i][k] = first[i][k] + distance.first[i] * flux[k];
                    second[i][k] = second[i][k] + distance.second[i][k] * weight;
                }
            }
        }
        Sum { first: first.map(|row| row.map(Lanes::sum)), second: second.map(|row| row.map(Lanes::sum)) }
    }
}
