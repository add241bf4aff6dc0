//! What runs over all normals, many of them side by side in wide vectors.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::kernels::fit::rig::Rig;

/// Samples of one block: as many as a word has bits.
pub const SAMPLES: usize = u64::BITS as usize;
/// Samples whose residuals stay in registers from light to light.
const LANES: usize = 8;

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
}

impl Blocks {
    pub fn new(normals: &[DVec3], weights: &[f64], irradiance: &[DVec3]) -> Self {
        let parts = normals.chunks(SAMPLES).zip(weights.chunks(SAMPLES)).zip(irradiance.chunks(SAMPLES));
        let block = |((normals, weights), irradiance): ((&[DVec3], &[f64]), &[DVec3])| Block {
            normals: axes(normals),
            irradiance: axes(irradiance),
            weights: std::array::from_fn(|i| *weights.get(i).unwrap_or(&0.0)),
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

    /// Weighted sum of squares of what `rig` leaves unexplained.
    pub fn cost(&self, rig: &Rig) -> f64 {
        self.widest.dispatch(Unexplained { blocks: &self.blocks, rig })
    }
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
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut sums = [0.0; LANES];
        for block in self.blocks {
            for part in 0..SAMPLES / LANES {
                let left = self.left(block, part);
                let weights = lanes(&block.weights, part);
                for i in 0..LANES {
                    sums[i] += weights[i] * left.iter().map(|left| left[i] * left[i]).sum::<f64>();
                }
            }
        }
        sums.iter().sum()
    }
}

impl Unexplained<'_> {
    /// What is left of a part of `block`, in each channel.
    #[inline(always)]
    fn left(&self, block: &Block, part: usize) -> [[f64; LANES]; 3] {
        let Rig { ambient, directions, irradiance, .. } = self.rig;
        let [x, y, z] = [0, 1, 2].map(|axis| *lanes(&block.normals[axis], part));
        let mut left = [0, 1, 2].map(|channel| *lanes(&block.irradiance[channel], part));
        if !ambient.is_empty() {
            for i in 0..LANES {
                let columns = self.rig.ambient_columns(DVec3::new(x[i], y[i], z[i]));
                for (coefficient, column) in ambient.iter().zip(columns) {
                    (0..3).for_each(|channel| left[channel][i] -= coefficient[channel] * column);
                }
            }
        }
        for (l, e) in directions.iter().zip(irradiance) {
            for i in 0..LANES {
                let along = x[i] * l.x + y[i] * l.y + z[i] * l.z;
                let lit = if along > 0.0 { along } else { 0.0 };
                left[0][i] -= e.x * lit;
                left[1][i] -= e.y * lit;
                left[2][i] -= e.z * lit;
            }
        }
        left
    }
}

#[inline(always)]
fn lanes(values: &[f64; SAMPLES], part: usize) -> &[f64; LANES] {
    &values.as_chunks().0[part]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

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
        ) {
            let (normals, weights, irradiance) = samples(count);
            let directions: Vec<DVec3> = angles.iter().map(|&(theta, phi)| direction(theta, phi)).collect();
            let rig = Rig {
                ambient: (0..coefficients).map(|i| DVec3::new(0.1, 0.2, 0.3) / (i + 1) as f64).collect(),
                irradiance: directions.iter().map(|l| l.abs() + 0.5).collect(),
                directions,
                has_floor: false,
            };
            let blocks = Blocks::new(&normals, &weights, &irradiance);
            let squares = normals.iter().zip(&irradiance).map(|(&n, e)| (*e - rig.at(n)).length_squared());
            let wanted: f64 = squares.zip(&weights).map(|(square, weight)| square * weight).sum();
            prop_assert!((blocks.cost(&rig) - wanted).abs() <= 1e-12 * wanted, "{} {wanted}", blocks.cost(&rig));
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
