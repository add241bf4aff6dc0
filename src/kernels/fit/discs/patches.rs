//! The cone of a kernel between the bright parts of a map and the discs of lights.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::chord::mean_distance;
use crate::kernels::expansion::{Cap, DiscSum};
use crate::kernels::fit::jet::Jet;
use crate::kernels::fit::light_disc::on_tangents;
use crate::kernels::fit::picture::Patch;
use crate::kernels::lanes::{LANES, Lanes, Number};

/// Patches in SIMD blocks: a lane holds a direction, A and RGB flux; unused lanes at the end are black.
#[derive(Clone, Debug)]
pub struct Patches {
    blocks: Vec<[[f64; LANES]; 7]>,
}

impl Patches {
    pub fn new(patches: &[Patch]) -> Self {
        let block = |patches: &[Patch]| {
            let mut block = [[0.0; LANES]; 7];
            // The distance needs an A above 0, and is cheap if all patches are far and small.
            block[3] = [1e-3; LANES];
            for (lane, Patch { direction, share, flux }) in patches.iter().enumerate() {
                let numbers = [direction.x, direction.y, direction.z, *share, flux[0], flux[1], flux[2]];
                (0..7).for_each(|i| block[i][lane] = numbers[i]);
            }
            block
        };
        Self { blocks: patches.chunks(LANES).map(block).collect() }
    }

    /// The mean distance between the points of a disc and of patches, times the fluxes of the patches.
    ///
    /// If N is 2, it has derivatives: second ones of the sum of the channels by `weights`.
    pub fn distances_to<const N: usize>(&self, cap: &Cap, weights: [f64; 3]) -> DiscSum {
        Arch::new().dispatch(PatchDistances::<N> { cap, blocks: &self.blocks, weights })
    }
}

/// The mean distance between the points of patches, times their fluxes, over all pairs and by channel.
pub fn distances(patches: &[Patch]) -> [f64; 3] {
    let Patches { blocks } = Patches::new(patches);
    let mut out = [0.0; 3];
    for (i, own) in patches.chunks(LANES).enumerate() {
        // A pair of blocks counts twice.
        let (own_block, later) = blocks[i..].split_at(1);
        for (one, (blocks, times)) in
            own.iter().flat_map(|one| [(one, (own_block, 1.0)), (one, (later, 2.0))])
        {
            let cap = Cap::new(one.direction, one.share);
            let distances =
                Arch::new().dispatch(PatchDistances::<0> { cap: &cap, blocks, weights: [0.0; 3] }).value;
            (0..3).for_each(|c| out[c] += times * one.flux[c] * distances[c]);
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
    cap: &'a Cap,
    blocks: &'a [[[f64; LANES]; 7]],
    weights: [f64; 3],
}

impl<const N: usize> WithSimd for PatchDistances<'_, N> {
    type Output = DiscSum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DiscSum {
        let Self { cap, blocks, weights } = self;
        let [s, t] = cap.frame;
        let own = Lanes::splat(simd, cap.share);
        let mut sum = DiscSum::zero(own);
        for block in blocks {
            for vector in 0..Lanes::<S>::VECTORS {
                let mut numbers = [own; 7];
                for i in 0..7 {
                    numbers[i] = Lanes::at(simd, &block[i], vector);
                }
                let (towards, share) = ([numbers[0], numbers[1], numbers[2]], numbers[3]);
                let (flux, cosine) = ([numbers[4], numbers[5], numbers[6]], dot(cap.direction, towards));
                let [c, a] = [Jet::<N, _>::variable(cosine, 0), Jet::variable(own, 1)];
                let distance = mean_distance(c, a, Jet::constant(share));
                for k in 0..3 {
                    sum.value[k] = sum.value[k].add_product(distance.value, flux[k]);
                }
                if N == 2 {
                    let distance = on_tangents(&distance, cosine, [dot(s, towards), dot(t, towards)]);
                    let mut weight = flux[0] * own.like(weights[0]);
                    for k in 1..3 {
                        weight = weight.add_product(flux[k], own.like(weights[k]));
                    }
                    for i in 0..3 {
                        for k in 0..3 {
                            sum.first[i][k] = sum.first[i][k] + distance.first[i] * flux[k];
                            sum.second[i][k] = sum.second[i][k] + distance.second[i][k] * weight;
                        }
                    }
                }
            }
        }
        sum.map(Lanes::sum)
    }
}
