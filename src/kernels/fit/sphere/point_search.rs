//! Inner products of lights in many directions, for the search.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::DVec3;
use nalgebra::DMatrix;
use pulp::{Simd, WithSimd};

use super::closed_form::{Sides, Sphere};
use super::kernel::{Block, SQUARE};
use super::lights::values;
use crate::kernels::fit::objective::{Directions, Moments, PointObjective};
use crate::kernels::lanes::LANES;

impl PointObjective for Sphere {
    fn exchange(&self, before: &Moments, kept: &[usize], new: &[DVec3]) -> Moments {
        self.moments_of(kept.iter().map(|&j| before.directions[j]).chain(new.iter().copied()).collect())
    }

    fn turn_to(&self, _: &Moments, directions: Vec<DVec3>) -> Moments {
        self.moments_of(directions)
    }

    fn light_products(&self, at: &Directions, lights: &[DVec3]) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(at.directions.len(), lights.len());
        for (&light, mut column) in lights.iter().zip(out.column_iter_mut()) {
            self.widest.dispatch(LightValues { light, at, out: column.as_mut_slice() });
        }
        out
    }

    fn side_products(&self, at: &Directions) -> DMatrix<f64> {
        let sides = self.widest.dispatch(Sides { sphere: self, directions: &at.directions });
        let count = self.reference.sides();
        let value = |i: usize, side: usize| sides[i * count + side].dot(at.directions[i]);
        DMatrix::from_fn(at.directions.len(), count, value)
    }

    fn squares(&self, at: &Directions) -> Vec<f64> {
        vec![SQUARE; at.directions.len()]
    }

    fn place(&self, direction: DVec3) -> DVec3 {
        let in_map = self.field.outward(direction);
        if self.allows(in_map) { in_map } else { in_map.with_y(-in_map.y) }
    }

    fn likely(&self) -> &[DVec3] {
        &self.likely
    }

    fn noise(&self) -> f64 {
        /// Error of the table in `field.rs`, as a fraction of the energy. Without it, lights follow that error.
        const TABLE: f64 = 1e-9;
        TABLE
    }
}

/// Inner products of one light with lights in many directions.
struct LightValues<'a> {
    light: DVec3,
    at: &'a Directions,
    out: &'a mut [f64],
}

impl WithSimd for LightValues<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (directions, out) in self.at.directions.chunks(LANES).zip(self.out.chunks_mut(LANES)) {
            let values = values(simd, self.light, &Block::new(directions.iter().copied()));
            out.copy_from_slice(&values[..out.len()]);
        }
    }
}
