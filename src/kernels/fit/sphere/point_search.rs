//! Products of a search: lights at many directions, beside those of a state.

#![allow(
    clippy::inline_always,
    reason = "functions that are not inlined are compiled for the oldest processors"
)]

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

use super::kernel::{Block, SQUARE};
use super::lights::values;
use super::{Sides, Sphere};
use crate::kernels::fit::lanes::LANES;
use crate::kernels::fit::objective::{Directions, Moments, Objective, PointObjective};

impl PointObjective for Sphere {
    fn base(&self) -> &dyn Objective {
        self
    }

    fn exchanged(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments {
        self.moments_of(kept.iter().map(|&j| before.directions[j]).chain(new.iter().copied()).collect())
    }

    fn turned(&self, _: &Moments, directions: Vec<DVec3>) -> Moments {
        self.moments_of(directions)
    }

    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(at.directions.len(), lights.len());
        for (&light, mut column) in lights.iter().zip(out.column_iter_mut()) {
            self.widest.dispatch(Values { light, at, out: column.as_mut_slice() });
        }
        out
    }

    fn side_products(&self, at: &Directions) -> DMatrix<f64> {
        let sides = self.widest.dispatch(Sides { sphere: self, directions: &at.directions });
        let count = self.given.sides();
        let value = |i: usize, side: usize| sides[i * count + side].dot(at.directions[i]);
        DMatrix::from_fn(at.directions.len(), count, value)
    }

    fn squares(&self, at: &Directions) -> Vec<f64> {
        vec![SQUARE; at.directions.len()]
    }

    fn placed(&self, direction: DVec3) -> DVec3 {
        let turned = self.field.outward(direction);
        if self.allows(turned) { turned } else { turned.with_y(-turned.y) }
    }

    fn likely(&self) -> &[DVec3] {
        &self.likely
    }

    fn noise(&self) -> f64 {
        /// Error of the table in `field.rs`, which lights would follow: 1e-8 of the energy.
        const TABLE: f64 = 1e-9;
        TABLE
    }
}

/// The inner products of a light with those of a list.
struct Values<'a> {
    light: DVec3,
    at: &'a Directions,
    out: &'a mut [f64],
}

impl WithSimd for Values<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (directions, out) in self.at.directions.chunks(LANES).zip(self.out.chunks_mut(LANES)) {
            let values = values(simd, self.light, &Block::new(directions.iter().copied()));
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}
