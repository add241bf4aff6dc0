//! Places of the search side by side: directions, their best radiances, and what that costs.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::DVec3;
use pulp::Simd;

use super::radiances::solve;
use crate::kernels::fit::lanes::LANES;
use crate::kernels::fit::objective::{Given, MomentsAbreast, Objective};
use crate::kernels::fit::wide::{Matrix, Wide, dot};

/// One place in each lane.
pub struct Places {
    /// Towards the lights; none in a lane that is left out.
    pub sets: [Vec<DVec3>; LANES],
    pub moments: MomentsAbreast,
    /// Radiances, a row for each channel, and the columns that are used: 1, or 0.
    pub x: Matrix,
    pub used: Matrix,
    /// Weighted sum of squares of what is left unexplained.
    pub cost: Wide,
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
        let moments = objective.abreast(&sets, fixed)?;
        let mut x = Matrix::zeros(moments.rhs.rows(), moments.rhs.columns());
        solve(simd, &moments.gram, &moments.rhs, &mut used, &mut x);
        let cost = cost(simd, objective.given(), &moments, &x);
        Some(Self { sets, moments, x, used, cost })
    }

    /// The places of `other` in the lanes that are `chosen`.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, other: Self, chosen: [bool; LANES]) {
        let is_chosen = Wide(chosen.map(|is_chosen| f64::from(u8::from(is_chosen))));
        let MomentsAbreast { frames, gram, rhs, model, both, slopes } = other.moments;
        let own = &mut self.moments;
        own.gram.take(simd, &gram, is_chosen);
        own.rhs.take(simd, &rhs, is_chosen);
        own.model.take(simd, &model, is_chosen);
        own.both.take(simd, &both, is_chosen);
        own.slopes.take(simd, &slopes, is_chosen);
        for (i, (frames, set)) in frames.into_iter().zip(other.sets).enumerate() {
            if chosen[i] {
                (own.frames[i], self.sets[i]) = (frames, set);
            }
        }
        self.x.take(simd, &other.x, is_chosen);
        self.used.take(simd, &other.used, is_chosen);
        self.cost.take(simd, other.cost, is_chosen);
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
