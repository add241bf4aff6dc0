//! Loops over all normals of a probe, in blocks that the compiler turns into wide vectors.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, become wide vectors")]

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::kernels::fit::rig::Rig;

/// Samples of one block, one for each bit of a word.
pub const SAMPLES: usize = u64::BITS as usize;

/// Greatest cosine at which a light is below the horizon of a normal. Normals of an icosphere lie on terminators, where
/// rounding must not decide.
pub const TERMINATOR: f64 = 1e-12;

/// All samples, in blocks.
#[derive(Clone, Debug)]
pub struct Blocks {
    blocks: Vec<SampleBlock>,
    /// Widest vectors of this processor.
    widest: Arch,
}

/// Coordinates of the samples of a block; the last block ends with zeros.
#[derive(Clone, Debug)]
struct SampleBlock {
    /// Number of samples.
    count: usize,
    normals: [[f64; SAMPLES]; 3],
    irradiance: [[f64; SAMPLES]; 3],
    weights: [f64; SAMPLES],
}

impl Blocks {
    /// Group samples into blocks.
    pub fn new(normals: &[DVec3], weights: &[f64], irradiance: &[DVec3]) -> Self {
        let parts = normals.chunks(SAMPLES).zip(weights.chunks(SAMPLES)).zip(irradiance.chunks(SAMPLES));
        let block = |((normals, weights), irradiance): ((&[DVec3], &[f64]), &[DVec3])| SampleBlock {
            count: weights.len(),
            normals: axes(normals),
            irradiance: axes(irradiance),
            weights: std::array::from_fn(|i| *weights.get(i).unwrap_or(&0.0)),
        };
        Self { blocks: parts.map(block).collect(), widest: Arch::new() }
    }

    /// Number of words that hold a bit for each sample.
    pub fn words(&self) -> usize {
        self.blocks.len()
    }

    /// A bit for each sample that a light reaches, in as many words for each light as there are blocks.
    pub fn visible(&self, directions: &[DVec3]) -> Vec<u64> {
        self.widest.dispatch(VisibleSamples { blocks: &self.blocks, directions })
    }

    /// Weighted sum of squares of the difference to a rig, in each channel.
    pub fn squares(&self, rig: &Rig) -> [f64; 3] {
        self.widest.dispatch(Squares { blocks: &self.blocks, rig })
    }
}

/// The coordinates of vectors by axis, and zeros.
fn axes(vectors: &[DVec3]) -> [[f64; SAMPLES]; 3] {
    [0, 1, 2].map(|axis| std::array::from_fn(|i| vectors.get(i).map_or(0.0, |vector| vector[axis])))
}

/// See [`Blocks::visible`]. A closure would not use the vectors of the processor.
struct VisibleSamples<'a> {
    blocks: &'a [SampleBlock],
    directions: &'a [DVec3],
}

impl WithSimd for VisibleSamples<'_> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<u64> {
        visible(self.blocks, self.directions)
    }
}

#[inline(always)]
fn visible(blocks: &[SampleBlock], directions: &[DVec3]) -> Vec<u64> {
    let mut words = Vec::with_capacity(directions.len() * blocks.len());
    for direction in directions {
        for SampleBlock { normals: [x, y, z], .. } in blocks {
            let mut bits = 0;
            for i in 0..SAMPLES {
                let along = x[i] * direction.x + y[i] * direction.y + z[i] * direction.z;
                bits |= u64::from(along > TERMINATOR) << i;
            }
            words.push(bits);
        }
    }
    words
}

/// See [`Blocks::squares`].
struct Squares<'a> {
    blocks: &'a [SampleBlock],
    rig: &'a Rig,
}

impl WithSimd for Squares<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        squares(self.blocks, self.rig)
    }
}

#[inline(always)]
fn squares(blocks: &[SampleBlock], rig: &Rig) -> [f64; 3] {
    let mut out = [0.0; 3];
    for block in blocks {
        let mut residual = block.irradiance;
        subtract_ambient(block, rig, &mut residual);
        for (l, e) in rig.directions.iter().zip(&rig.irradiance) {
            subtract_light(block, *l, *e, &mut residual);
        }
        for c in 0..3 {
            for i in 0..SAMPLES {
                out[c] += block.weights[i] * residual[c][i] * residual[c][i];
            }
        }
    }
    out
}

/// Subtract the ambient term of a rig at each sample.
#[inline(always)]
fn subtract_ambient(block: &SampleBlock, rig: &Rig, residual: &mut [[f64; SAMPLES]; 3]) {
    let [x, y, z] = &block.normals;
    for i in 0..block.count {
        let columns = rig.ambient_columns(DVec3::new(x[i], y[i], z[i]));
        for (coefficient, column) in rig.ambient.iter().zip(columns) {
            for channel in 0..3 {
                residual[channel][i] -= coefficient[channel] * column;
            }
        }
    }
}

/// Subtract a light from the direction `l`.
#[inline(always)]
fn subtract_light(block: &SampleBlock, l: DVec3, irradiance: DVec3, residual: &mut [[f64; SAMPLES]; 3]) {
    let [x, y, z] = &block.normals;
    let [red, green, blue] = residual;
    for i in 0..SAMPLES {
        let cosine = (x[i] * l.x + y[i] * l.y + z[i] * l.z).max(0.0);
        red[i] -= irradiance.x * cosine;
        green[i] -= irradiance.y * cosine;
        blue[i] -= irradiance.z * cosine;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use proptest::prelude::*;

    use super::*;
    use crate::kernels::sphere::direction;

    /// Normals, weights and irradiance.
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
        /// Checks full blocks, one sample, and blocks that end with zeros.
        #[test]
        fn sums_over_blocks_are_the_plain_sums(
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
            let expected: f64 = squares.zip(&weights).map(|(square, weight)| square * weight).sum();
            let sum: f64 = blocks.squares(&rig).iter().sum();
            prop_assert!((sum - expected).abs() <= 1e-12 * expected, "{sum} {expected}");
            let visible = blocks.visible(&rig.directions);
            prop_assert_eq!(visible.len(), rig.directions.len() * blocks.words());
            for (light, bits) in rig.directions.iter().zip(visible.chunks(blocks.words())) {
                for i in 0..SAMPLES * blocks.words() {
                    let expected = normals.get(i).is_some_and(|n| n.dot(*light) > TERMINATOR);
                    prop_assert_eq!(bits[i / SAMPLES] >> (i % SAMPLES) & 1 == 1, expected);
                }
            }
        }
    }
}
