//! Places of the search side by side: directions, their best radiances, and what that costs.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use pulp::Simd;

use super::quadratic::Quadratic;
use super::radiances::solve;
use crate::kernels::fit::lanes::LANES;
use crate::kernels::fit::objective::{Given, MomentsAbreast, Objective};
use crate::kernels::fit::wide::{Matrix, Wide, dot};

/// One place in each lane.
pub struct Places {
    /// Towards the lights, none in a lane that is left out, and the tangents of each.
    pub sets: [Vec<DVec3>; LANES],
    pub frames: [Vec<[DVec3; 2]>; LANES],
    /// Inner products of the columns; radiances, a row for each channel, and the columns that are used: 1, or 0.
    pub gram: Matrix,
    pub x: Matrix,
    pub used: Matrix,
    /// Weighted sum of squares of what is left unexplained, and how it changes with small turns.
    pub cost: Wide,
    pub model: Quadratic,
}

impl Places {
    /// The best radiances of the lights of each set, searched from those of the columns that are `used`.
    #[inline(always)]
    pub fn at<S: Simd>(
        simd: S,
        objective: &dyn Objective,
        sets: [Vec<DVec3>; LANES],
        fixed: usize,
        mut used: Matrix,
    ) -> Option<Self> {
        let given = objective.given();
        let moments = objective.abreast(&sets, fixed)?;
        let mut x = Matrix::zeros(moments.rhs.rows(), moments.rhs.columns());
        let supports = solve(simd, &moments.gram, &moments.rhs, &mut used, &mut x);
        let cost = cost(simd, given, &moments, &x);
        let still = given.ambient.coefficients() + fixed;
        let model = Quadratic::around(simd, given, &moments, &x, &supports, still);
        let MomentsAbreast { frames, gram, .. } = moments;
        Some(Self { sets, frames, gram, x, used, cost, model })
    }

    /// The places of `other` in the lanes that are `chosen`.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, other: Self, chosen: [bool; LANES]) {
        if chosen == [true; LANES] {
            *self = other;
            return;
        }
        let is_chosen = Wide(chosen.map(|is_chosen| f64::from(u8::from(is_chosen))));
        for (i, (set, frames)) in other.sets.into_iter().zip(other.frames).enumerate() {
            if chosen[i] {
                (self.sets[i], self.frames[i]) = (set, frames);
            }
        }
        self.gram.take(simd, &other.gram, is_chosen);
        self.x.take(simd, &other.x, is_chosen);
        self.used.take(simd, &other.used, is_chosen);
        self.cost.take(simd, other.cost, is_chosen);
        self.model.take(simd, &other.model, is_chosen);
    }
}

/// What the values `x` leave unexplained.
#[inline(always)]
fn cost<S: Simd>(
    simd: S,
    given: &Given,
    MomentsAbreast { gram, rhs, .. }: &MomentsAbreast,
    x: &Matrix,
) -> Wide {
    let mut cost = Wide::splat(given.energy);
    for channel in 0..x.rows() {
        let (x, right, copies) = (x.row(channel), rhs.row(channel), Wide::splat(given.copies(channel)));
        for i in 0..x.len() {
            cost -= copies * x[i] * (right[i] + right[i] - dot(simd, gram.row(i), x));
        }
    }
    cost.max(simd, Wide::ZERO)
}
