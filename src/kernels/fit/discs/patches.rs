//! The bright cells of a map in parts, each kept apart as a disc of the same spread, and the cone of a kernel between
//! them and the discs of lights.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::iter::repeat;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::chord::mean_distance;
use super::disc::{Disc, on_tangents};
use super::jet::Jet;
use crate::kernels::expansion::{DiscSum, Harmonics};
use crate::kernels::image::{Part, WorkingMap};
use crate::kernels::lanes::{LANES, Lanes, Number};

/// A part of a bright cell of the map, as a disc of the same spread.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub direction: DVec3,
    pub share: f64,
    pub flux: [f64; 3],
}

impl Patch {
    /// Its direction, A and flux.
    pub fn disc(&self) -> (DVec3, f64, [f64; 3]) {
        (self.direction, self.share, self.flux)
    }

    /// Its radiance, summed over the channels.
    pub fn radiance(&self) -> f64 {
        self.flux.iter().sum::<f64>() / (4.0 * PI * self.share)
    }
}

/// The parts of the map's sources and bright cells as discs. Where their channels have their middles aside of each other, the first degree of
/// the `rest` takes the difference.
pub fn patches(map: &WorkingMap, rest: &mut Harmonics) -> Vec<Patch> {
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
        let padded: Vec<Patch> = padded.take(patches.len().next_multiple_of(LANES)).collect();
        let of = |number: &dyn Fn(&Patch) -> f64| padded.iter().map(number).collect::<Vec<_>>();
        Self {
            count: patches.len(),
            direction: [0, 1, 2].map(|i| of(&|patch| patch.direction[i])),
            share: of(&|patch| patch.share),
            flux: [0, 1, 2].map(|c| of(&|patch| patch.flux[c])),
        }
    }

    /// The mean distance between the points of a disc and of patches, times the fluxes of these; if N is 2, with derivatives,
    /// second ones of the channels with these `shares`.
    pub fn distances_to<const N: usize>(&self, disc: &Disc, shares: [f64; 3]) -> DiscSum {
        Arch::new().dispatch(PatchDistances::<N> { disc, patches: self, shares })
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
///
/// The distance is symmetric: pairs of two blocks are summed once, and count twice.
pub fn distances(patches: &[Patch]) -> [f64; 3] {
    let mut out = [0.0; 3];
    for (block, own) in patches.chunks(LANES).enumerate() {
        let later = Patches::new(&patches[block * LANES + own.len()..]);
        let within = Patches::new(own);
        for one in own {
            let disc = Disc::new(one.direction, 2.0 * one.share.sqrt().asin());
            let [own, others] = [&within, &later].map(|all| all.distances_to::<0>(&disc, [0.0; 3]).value);
            (0..3).for_each(|c| out[c] += one.flux[c] * (own[c] + 2.0 * others[c]));
        }
    }
    out
}

#[inline(always)]
fn dot<S: Simd>(one: DVec3, other: [Lanes<S>; 3]) -> Lanes<S> {
    let [x, y, z] = other;
    x * x.like(one.x) + y * y.like(one.y) + z * z.like(one.z)
}

/// See [`Patches::distances_to`].
struct PatchDistances<'a, const N: usize> {
    disc: &'a Disc,
    patches: &'a Patches,
    shares: [f64; 3],
}

impl<const N: usize> WithSimd for PatchDistances<'_, N> {
    type Output = DiscSum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DiscSum {
        let Self { disc, patches, shares } = self;
        let [s, t] = disc.frame();
        let shares = shares.map(|share| Lanes::splat(simd, share));
        let own = Lanes::splat(simd, disc.share);
        let mut sum = DiscSum::zero(own);
        for (towards, share, flux) in patches.lanes(simd) {
            let cosine = dot(disc.direction, towards);
            let [c, a] = [Jet::<N, _>::variable(cosine, 0), Jet::variable(own, 1)];
            let distance = mean_distance(c, a, Jet::constant(share));
            for k in 0..3 {
                sum.value[k] = sum.value[k].add_product(distance.value, flux[k]);
            }
            if N == 2 {
                let distance = on_tangents(&distance, cosine, [dot(s, towards), dot(t, towards)]);
                let weight = shares[0] * flux[0] + shares[1] * flux[1] + shares[2] * flux[2];
                for i in 0..3 {
                    for k in 0..3 {
                        sum.first[i][k] = sum.first[i][k] + distance.first[i] * flux[k];
                        sum.second[i][k] = sum.second[i][k] + distance.second[i][k] * weight;
                    }
                }
            }
        }
        sum.map(Lanes::sum)
    }
}
