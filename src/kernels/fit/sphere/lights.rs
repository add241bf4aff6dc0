//! Inner products of lights with each other, and of their derivatives, many side by side.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

use super::kernel::{Angles, LANES, Lanes, mixed_derivatives};
use crate::kernels::fit::objective::{Derivatives, Pair};

/// Inner products of lights, into the last rows and columns of a Gram matrix.
pub struct Products<'a> {
    pub directions: &'a [DVec3],
    pub gram: &'a mut DMatrix<f64>,
}

impl WithSimd for Products<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { directions, gram } = self;
        let first = gram.nrows() - directions.len();
        for (block, others) in directions.chunks(LANES).enumerate() {
            let lanes = Lanes::new(others.iter().copied());
            for (j, &l) in directions.iter().enumerate().skip(block * LANES) {
                let values = Angles::new(l, &lanes).values();
                for (k, &value) in (block * LANES..=j).zip(&values) {
                    gram[(first + k, first + j)] = value;
                    gram[(first + j, first + k)] = value;
                }
            }
        }
    }
}

/// Inner products of the derivatives of lights with lights and each other.
pub struct Turned<'a> {
    pub directions: &'a [DVec3],
    pub ambient: usize,
    /// Lights that do not turn.
    pub fixed: usize,
    pub derivatives: &'a mut Derivatives,
}

impl WithSimd for Turned<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { directions, ambient, fixed, derivatives } = self;
        let tangent = |light: usize, side: usize| {
            light.checked_sub(fixed).map_or(DVec3::ZERO, |free| derivatives.frames[free][side])
        };
        let block = |block: usize| {
            let lights = block * LANES..directions.len().min((block + 1) * LANES);
            let tangents = [0, 1].map(|side| Lanes::new(lights.clone().map(|light| tangent(light, side))));
            [Lanes::new(lights.map(|light| directions[light])), tangents[0], tangents[1]]
        };
        let blocks: Vec<[Lanes; 3]> = (0..directions.len().div_ceil(LANES)).map(block).collect();
        for j in fixed..directions.len() {
            let [s, t] = derivatives.frames[j - fixed];
            for (block, others) in blocks[..=j / LANES].iter().enumerate() {
                let mixed = mixed_derivatives([directions[j], s, t], others);
                for (i, k) in (block * LANES..=j).take(LANES).enumerate() {
                    let own = [0, 1].map(|a| mixed.own[a][i]);
                    let other = [0, 1].map(|b| mixed.other[b][i]);
                    let both = [0, 1].map(|a| [0, 1].map(|b| mixed.both[a][b][i]));
                    derivatives.set(ambient, fixed, [j, k], &Pair { own, other, both });
                }
            }
        }
    }
}
