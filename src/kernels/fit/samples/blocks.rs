//! What runs over all normals, many of them side by side in wide vectors.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::PI;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::kernels::fit::rig::Rig;

/// Samples of one block: as many as a word has bits.
pub const SAMPLES: usize = u64::BITS as usize;
/// Vectors of samples whose residuals stay in registers from light to light.
const VECTORS: usize = 2;

/// A normal this close to a right angle with a light does not see it: where normals stand on a terminator,
/// as those of an icosphere do, rounding must not decide to which side of it they belong.
pub const TERMINATOR: f64 = 1e-12;

/// All samples, in blocks.
#[derive(Clone, Debug)]
pub struct Blocks {
    blocks: Vec<Block>,
    /// Vectors as wide as this processor has.
    widest: Arch,
}

/// The last block is filled up with normals that see nothing and weigh nothing.
#[derive(Clone, Debug)]
struct Block {
    normals: [[f64; SAMPLES]; 3],
    irradiance: [[f64; SAMPLES]; 3],
    weights: [f64; SAMPLES],
    /// 1 for those that are there, 0 for those that fill the block up.
    is_sample: [f64; SAMPLES],
}

impl Blocks {
    pub fn new(normals: &[DVec3], weights: &[f64], irradiance: &[DVec3]) -> Self {
        let parts = normals.chunks(SAMPLES).zip(weights.chunks(SAMPLES)).zip(irradiance.chunks(SAMPLES));
        let block = |((normals, weights), irradiance): ((&[DVec3], &[f64]), &[DVec3])| Block {
            normals: axes(normals),
            irradiance: axes(irradiance),
            weights: std::array::from_fn(|i| *weights.get(i).unwrap_or(&0.0)),
            is_sample: std::array::from_fn(|i| if i < weights.len() { 1.0 } else { 0.0 }),
        };
        Self { blocks: parts.map(block).collect(), widest: Arch::new() }
    }

    /// How many words hold a bit for each sample.
    pub fn words(&self) -> usize {
        self.blocks.len()
    }

    /// The normals that see lights in `directions`, as bits: so many words for each light.
    pub fn seen(&self, directions: &[DVec3]) -> Vec<u64> {
        let mut seen = Vec::with_capacity(directions.len() * self.words());
        self.widest.dispatch(Seen { blocks: &self.blocks, directions, words: &mut seen });
        seen
    }

    /// What `rig` leaves unexplained.
    pub fn left(&self, rig: &Rig) -> Left {
        self.widest.dispatch(Unexplained { blocks: &self.blocks, rig })
    }
}

/// What a rig leaves unexplained.
#[derive(Clone, Copy, Debug)]
pub struct Left {
    /// Weighted sum of its squares in each channel.
    pub squares: [f64; 3],
    /// The most at any normal and in any channel.
    pub largest: f64,
}

/// x, y and z side by side.
fn axes(vectors: &[DVec3]) -> [[f64; SAMPLES]; 3] {
    [0, 1, 2].map(|axis| std::array::from_fn(|i| vectors.get(i).map_or(0.0, |vector| vector[axis])))
}

/// One bit each: to take them from a table is faster than to shift by another number in each lane.
const BITS: [u64; SAMPLES] = {
    let mut bits = [1; SAMPLES];
    let mut i = 1;
    while i < SAMPLES {
        bits[i] = bits[i - 1] << 1;
        i += 1;
    }
    bits
};

struct Seen<'a> {
    blocks: &'a [Block],
    directions: &'a [DVec3],
    words: &'a mut Vec<u64>,
}

impl WithSimd for Seen<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for direction in self.directions {
            for Block { normals: [x, y, z], .. } in self.blocks {
                let mut bits = 0;
                for i in 0..SAMPLES {
                    let along = x[i] * direction.x + y[i] * direction.y + z[i] * direction.z;
                    bits |= if along > TERMINATOR { BITS[i] } else { 0 };
                }
                self.words.push(bits);
            }
        }
    }
}

struct Unexplained<'a> {
    blocks: &'a [Block],
    rig: &'a Rig,
}

impl WithSimd for Unexplained<'_> {
    type Output = Left;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Left {
        let zero = simd.splat_f64s(0.0);
        let (mut sums, mut largest) = ([zero; 3], zero);
        for block in self.blocks {
            let without = self.without_harmonics(block);
            let block = without.as_deref().unwrap_or(block);
            let (weights, is_sample) =
                (S::as_simd_f64s(&block.weights).0, S::as_simd_f64s(&block.is_sample).0);
            for first in (0..weights.len()).step_by(VECTORS) {
                let left = self.left(simd, block, first);
                for (sum, left) in sums.iter_mut().zip(&left) {
                    for i in 0..VECTORS {
                        let weighted = simd.mul_f64s(weights[first + i], left[i]);
                        *sum = simd.mul_add_f64s(weighted, left[i], *sum);
                        let size = simd.mul_f64s(is_sample[first + i], simd.abs_f64s(left[i]));
                        largest = simd.max_f64s(largest, size);
                    }
                }
            }
        }
        Left { squares: sums.map(|sum| simd.reduce_sum_f64s(sum)), largest: simd.reduce_max_f64s(largest) }
    }
}

impl Unexplained<'_> {
    /// What is left of some vectors of `block` from the `first` on, in each channel.
    #[inline(always)]
    fn left<S: Simd>(&self, simd: S, block: &Block, first: usize) -> [[S::f64s; VECTORS]; 3] {
        let Rig { directions, irradiance, .. } = self.rig;
        let (normals, seen) = (&block.normals, &block.irradiance);
        let normals = [0, 1, 2].map(|axis| vectors(simd, &normals[axis], first));
        let mut left = [0, 1, 2].map(|channel| vectors(simd, &seen[channel], first));
        if let [constant] = self.rig.ambient[..] {
            // The same at all normals, but over a floor.
            let tilt = if self.rig.has_floor { 0.5 } else { 0.0 };
            for (left, constant) in left.iter_mut().zip(constant.to_array()) {
                let [level, slope] = [1.0 - tilt, tilt].map(|share| simd.splat_f64s(PI * constant * share));
                for i in 0..VECTORS {
                    left[i] = simd.sub_f64s(left[i], simd.mul_add_f64s(normals[1][i], slope, level));
                }
            }
        }
        let zero = simd.splat_f64s(0.0);
        for (l, e) in directions.iter().zip(irradiance) {
            let [l, e] = [l, e].map(|v| [simd.splat_f64s(v.x), simd.splat_f64s(v.y), simd.splat_f64s(v.z)]);
            for i in 0..VECTORS {
                let along = simd.mul_f64s(normals[0][i], l[0]);
                let along = simd.mul_add_f64s(normals[1][i], l[1], along);
                let lit = simd.max_f64s(simd.mul_add_f64s(normals[2][i], l[2], along), zero);
                left[0][i] = simd.negate_mul_add_f64s(e[0], lit, left[0][i]);
                left[1][i] = simd.negate_mul_add_f64s(e[1], lit, left[1][i]);
                left[2][i] = simd.negate_mul_add_f64s(e[2], lit, left[2][i]);
            }
        }
        left
    }

    /// What is left of `block` beside the harmonics of the ambient term, if it has any.
    fn without_harmonics(&self, block: &Block) -> Option<Box<Block>> {
        if self.rig.ambient.len() <= 1 {
            return None;
        }
        let mut block = Box::new(block.clone());
        let [x, y, z] = &block.normals;
        for i in 0..SAMPLES {
            let columns = self.rig.ambient_columns(DVec3::new(x[i], y[i], z[i]));
            for (coefficient, column) in self.rig.ambient.iter().zip(columns) {
                for channel in 0..3 {
                    block.irradiance[channel][i] -= coefficient[channel] * column;
                }
            }
        }
        Some(block)
    }
}

/// Some vectors of `values`, from the `first` on.
#[inline(always)]
fn vectors<S: Simd>(simd: S, values: &[f64; SAMPLES], first: usize) -> [S::f64s; VECTORS] {
    let mut vectors = [simd.splat_f64s(0.0); VECTORS];
    vectors.copy_from_slice(&S::as_simd_f64s(values).0[first..][..VECTORS]);
    vectors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// As many samples as fill no block, or just one.
    fn samples(count: usize) -> (Vec<DVec3>, Vec<f64>, Vec<DVec3>) {
        let normal = |i: usize| direction(0.1 + 2.9 * i as f64 / count as f64, 2.4 * i as f64);
        let wave = |i: usize, scale: f64| 1.0 + (scale * i as f64).sin();
        let irradiance = |i: usize| DVec3::new(wave(i, 0.3), wave(i, 0.7), wave(i, 1.1));
        (
            (0..count).map(normal).collect(),
            (0..count).map(|i| wave(i, 0.2)).collect(),
            (0..count).map(irradiance).collect(),
        )
    }

    proptest! {
        #[test]
        fn sums_in_lanes_are_the_plain_sums(
            count in prop::sample::select(vec![1_usize, 63, 64, 65, 200]),
            coefficients in prop::sample::select(vec![0_usize, 1, 9]),
            angles in proptest::collection::vec((0.0..PI, 0.0..TAU), 0..4),
            has_floor in proptest::bool::ANY,
        ) {
            let (normals, weights, irradiance) = samples(count);
            let directions: Vec<DVec3> = angles.iter().map(|&(theta, phi)| direction(theta, phi)).collect();
            let rig = Rig {
                ambient: (0..coefficients).map(|i| DVec3::new(0.1, 0.2, 0.3) / (i + 1) as f64).collect(),
                irradiance: directions.iter().map(|l| l.abs() + 0.5).collect(),
                directions,
                has_floor,
            };
            let blocks = Blocks::new(&normals, &weights, &irradiance);
            let squares = normals.iter().zip(&irradiance).map(|(&n, e)| (*e - rig.at(n)).length_squared());
            let wanted: f64 = squares.zip(&weights).map(|(square, weight)| square * weight).sum();
            let left = blocks.left(&rig);
            let seen: f64 = left.squares.iter().sum();
            prop_assert!((seen - wanted).abs() <= 1e-12 * wanted, "{seen} {wanted}");
            let largest = normals.iter().zip(&irradiance).map(|(&n, e)| (*e - rig.at(n)).abs().max_element());
            prop_assert!((left.largest - largest.fold(0.0, f64::max)).abs() < 1e-12, "{left:?}");
            let seen = blocks.seen(&rig.directions);
            prop_assert_eq!(seen.len(), rig.directions.len() * blocks.words());
            for (light, bits) in rig.directions.iter().zip(seen.chunks(blocks.words())) {
                for i in 0..SAMPLES * blocks.words() {
                    let wanted = normals.get(i).is_some_and(|n| n.dot(*light) > TERMINATOR);
                    prop_assert_eq!(bits[i / SAMPLES] >> (i % SAMPLES) & 1 == 1, wanted);
                }
            }
        }
    }
}
