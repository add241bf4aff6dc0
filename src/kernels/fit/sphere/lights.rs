//! Inner products of lights with each other and of their derivatives, in wide vectors.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

use super::kernel::{Angles, Block, mixed_derivatives, splat};
use crate::kernels::fit::objective::{Derivatives, PointPair};
use crate::kernels::lanes::{LANES, Lanes, Number};
use crate::kernels::sphere::tangents;

/// Inner products of lights, written into the last rows and columns of a Gram matrix.
pub struct LightProducts<'a> {
    pub directions: &'a [DVec3],
    pub gram: &'a mut DMatrix<f64>,
}

impl WithSimd for LightProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { directions, gram } = self;
        let first = gram.nrows() - directions.len();
        for (block, others) in directions.chunks(LANES).enumerate() {
            let others = Block::new(others.iter().copied());
            for (j, &l) in directions.iter().enumerate().skip(block * LANES) {
                let values = values(simd, l, &others);
                for (k, &value) in (block * LANES..=j).zip(&values) {
                    gram[(first + k, first + j)] = value;
                    gram[(first + j, first + k)] = value;
                }
            }
        }
    }
}

/// Inner products of the derivatives of lights with lights and with each other.
pub struct DerivativeProducts<'a> {
    pub directions: &'a [DVec3],
    pub ambient: usize,
    pub derivatives: &'a mut Derivatives,
}

impl WithSimd for DerivativeProducts<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { directions, ambient, derivatives } = self;
        let frames: Vec<[DVec3; 2]> = directions.iter().map(|&l| tangents(l)).collect();
        let block = |block: usize| {
            let lights = block * LANES..directions.len().min((block + 1) * LANES);
            let tangents = [0, 1].map(|side| Block::new(lights.clone().map(|light| frames[light][side])));
            [Block::new(lights.map(|light| directions[light])), tangents[0], tangents[1]]
        };
        let blocks: Vec<[Block; 3]> = (0..directions.len().div_ceil(LANES)).map(block).collect();
        for j in 0..directions.len() {
            let [s, t] = frames[j];
            let own = [splat(simd, directions[j]), splat(simd, s), splat(simd, t)];
            for (block, [others, s, t]) in blocks[..=j / LANES].iter().enumerate() {
                for vector in 0..Lanes::<S>::VECTORS {
                    let others = [others.at(simd, vector), s.at(simd, vector), t.at(simd, vector)];
                    let mixed = mixed_derivatives(&own, &others);
                    let first = block * LANES + vector * S::F64_LANES;
                    for (i, k) in (first..=j).take(S::F64_LANES).enumerate() {
                        let both = mixed.both;
                        let pair = PointPair {
                            own: [mixed.own[0].lane(i), mixed.own[1].lane(i)],
                            other: [mixed.other[0].lane(i), mixed.other[1].lane(i)],
                            both: [
                                [both[0][0].lane(i), both[0][1].lane(i)],
                                [both[1][0].lane(i), both[1][1].lane(i)],
                            ],
                        };
                        derivatives.set(ambient, [j, k], &pair);
                    }
                }
            }
        }
    }
}

/// The inner products of a light with others.
#[inline(always)]
pub fn values<S: Simd>(simd: S, l: DVec3, others: &Block) -> [f64; LANES] {
    let (own, mut values) = (splat(simd, l), [0.0; LANES]);
    for vector in 0..Lanes::<S>::VECTORS {
        Angles::between(&own, &others.at(simd, vector)).values().write(&mut values, vector);
    }
    values
}
