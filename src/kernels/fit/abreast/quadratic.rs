//! The cost around places side by side, to second order: Gauss and Newton's steps, as in `newton.rs`.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;
use std::rc::Rc;

use pulp::Simd;

use super::factors::Factors;
use super::radiances::Support;
use crate::kernels::fit::objective::{Given, MomentsAbreast};
use crate::kernels::fit::wide::{Matrix, Wide, add, dot, take};

/// `cost + 2 gradient.t + t^T hessian t`
pub struct Quadratic {
    /// In and above the diagonal.
    pub hessian: Matrix,
    pub gradient: Vec<Wide>,
}

impl Quadratic {
    /// For the lights that may turn, of which the first follows that many `still` columns; with radiances `x` and the
    /// support of each channel.
    #[inline(always)]
    pub fn around<S: Simd>(
        simd: S,
        given: &Given,
        moments: &MomentsAbreast,
        x: &Matrix,
        supports: &[Rc<Support>],
        still: usize,
    ) -> Self {
        let turns = moments.both.rows();
        let mut quadratic = Self { hessian: Matrix::zeros(turns, turns), gradient: vec![Wide::ZERO; turns] };
        let around = Around { given, moments, x, still };
        for channel in 0..supports.len() {
            around.add_slopes(simd, &mut quadratic.gradient, channel);
        }
        let mut from = 0;
        for alike in supports.chunk_by(Rc::ptr_eq) {
            around.add_bends(simd, &mut quadratic.hessian, &alike[0], from..from + alike.len());
            from += alike.len();
        }
        quadratic
    }

    /// The solution of `(H + damping diag H) step = -gradient`, as in `newton.rs`, and what the cost falls by with it:
    ///
    /// ```text
    ///   -(2 g.s + s^T H s) = -g.s + damping s^T (diag H) s
    /// ```
    #[inline(always)]
    pub fn step<S: Simd>(&self, simd: S, damping: Wide) -> (Vec<Wide>, Wide) {
        let Self { hessian, gradient } = self;
        let mut hessian = hessian.clone();
        let mut highest = Wide::splat(f64::MIN_POSITIVE);
        for i in 0..gradient.len() {
            highest = highest.max(simd, hessian[(i, i)]);
        }
        let (mut step, mut added) = (Vec::with_capacity(gradient.len()), Vec::with_capacity(gradient.len()));
        for (i, gradient) in gradient.iter().enumerate() {
            let scale = hessian[(i, i)].max(simd, Wide::ZERO);
            added.push(damping * scale + Wide::splat(1e-14) * highest);
            hessian[(i, i)] += added[i];
            step.push(gradient.negated());
        }
        Factors::new(simd, hessian).solve(simd, &mut step);
        let mut fall = dot(simd, gradient, &step).negated();
        for (added, step) in added.into_iter().zip(&step) {
            fall.add_product(simd, added * *step, *step);
        }
        (step, fall)
    }

    /// Those of `other` in the lanes where `chosen` is 1, not 0.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, other: &Self, chosen: Wide) {
        self.hessian.take(simd, &other.hessian, chosen);
        take(simd, &mut self.gradient, &other.gradient, chosen);
    }
}

/// What the model is made of.
struct Around<'a> {
    given: &'a Given,
    moments: &'a MomentsAbreast,
    x: &'a Matrix,
    still: usize,
}

impl Around<'_> {
    /// `g_i -= x_i <da_i, r>` of one channel.
    #[inline(always)]
    fn add_slopes<S: Simd>(&self, simd: S, gradient: &mut [Wide], channel: usize) {
        let (x, mut slopes) = (self.x.row(channel), self.moments.slopes.row(channel).to_vec());
        for (column, x) in x.iter().enumerate() {
            add(simd, &mut slopes, x.negated(), self.moments.model.row(column));
        }
        let copies = Wide::splat(-self.given.copies(channel));
        for (i, slope) in slopes.into_iter().enumerate() {
            gradient[i].add_product(simd, copies * x[self.still + i / 2], slope);
        }
    }

    /// `H_ik += x_i x_k (<da_i, da_k> - M_i G^-1 M_k^T)` of channels that share a support.
    #[inline(always)]
    fn add_bends<S: Simd>(&self, simd: S, hessian: &mut Matrix, support: &Support, channels: Range<usize>) {
        let along = orthonormal(simd, &self.moments.model, support);
        let turns = hessian.rows();
        // Both tangents of two lights at a time.
        for i in (0..turns).step_by(2) {
            for k in (i..turns).step_by(2) {
                let mut share = Wide::ZERO;
                for channel in channels.clone() {
                    let x = self.x.row(channel);
                    let own = Wide::splat(self.given.copies(channel)) * x[self.still + i / 2];
                    share.add_product(simd, own, x[self.still + k / 2]);
                }
                let inside = inside(simd, &self.moments.both, &along, i, k);
                for (a, inside) in inside.into_iter().enumerate() {
                    for (b, inside) in inside.into_iter().enumerate() {
                        hessian[(i + a, k + b)].add_product(simd, share, inside);
                    }
                }
            }
        }
    }
}

/// `M L^-T D^-1/2`, transposed: the products of the derivatives with orthonormal columns in place of those of a support.
#[inline(always)]
fn orthonormal<S: Simd>(simd: S, model: &Matrix, support: &Support) -> Matrix {
    let mut along = model.clone();
    for (column, used) in support.used.iter().enumerate() {
        for value in along.row_mut(column) {
            *value = *value * *used;
        }
    }
    support.factors.forward(simd, &mut along);
    for (column, inverse) in support.factors.inverse_pivots().iter().enumerate() {
        let scale = inverse.sqrt(simd);
        for value in along.row_mut(column) {
            *value = *value * scale;
        }
    }
    along
}

/// `<da_i, da_k> - M_i G^-1 M_k^T` for two coordinates from i, and two from k on.
#[inline(always)]
fn inside<S: Simd>(simd: S, both: &Matrix, along: &Matrix, i: usize, k: usize) -> [[Wide; 2]; 2] {
    let mut inside = [[both[(i, k)], both[(i, k + 1)]], [both[(i + 1, k)], both[(i + 1, k + 1)]]];
    for column in 0..along.rows() {
        let (one, other) = (&along.row(column)[i..][..2], &along.row(column)[k..][..2]);
        for a in 0..2 {
            for b in 0..2 {
                inside[a][b].subtract_product(simd, one[a], other[b]);
            }
        }
    }
    inside
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::place::Places;
    use super::*;
    use crate::kernels::fit::lanes::LANES;
    use crate::kernels::fit::newton;
    use crate::kernels::fit::problem::Problem;
    use crate::kernels::fit::state::State;
    use crate::kernels::fit::{Ambient, Objective, Sphere};
    use crate::kernels::image;
    use crate::kernels::sphere::Registration;
    use glam::DVec3;
    use ndarray::Array3;
    use pulp::Scalar;
    use std::array;

    /// Of four lights, of which the first stays; the last lane is empty.
    #[test]
    fn steps_are_those_of_a_place_alone() {
        const FULL: usize = LANES - 1;
        let map =
            Array3::from_shape_fn((16, 32, 3), |(y, x, c)| if (y, x % 9) == (3 + c, 4) { 50.0 } else { 1.0 });
        let working = image::reduce(map.view(), Registration::CellCentred, 256, 3e-3, false).unwrap();
        let direction =
            |i: usize| DVec3::new((1.3 * i as f64).sin(), (2.1 * i as f64).sin(), (0.7 * i as f64).cos());
        let set = |lane: usize| (0..4).map(|light| direction(4 * lane + light + 1).normalize()).collect();
        let sets: [Vec<DVec3>; LANES] =
            array::from_fn(|lane| if lane < FULL { set(lane) } else { Vec::new() });
        for ambient in [Ambient::None, Ambient::Constant] {
            let sphere = Sphere::new(&working, ambient, false);
            let columns = ambient.coefficients() + 4;
            let mut used = Matrix::zeros(sphere.given().channels.len(), columns);
            (0..FULL).for_each(|lane| used.fill_lane(lane, 1.0));
            let places = Places::at(Scalar::new(), &sphere, sets.clone(), 1, used).unwrap();
            let (step, fall) = places.model.step(Scalar::new(), Wide::splat(0.01));
            for (lane, set) in sets.iter().enumerate().take(FULL) {
                let problem = Problem {
                    objective: &sphere,
                    start: set,
                    fixed: 1,
                    lights: 4,
                    error: None,
                    max_steps: 1,
                };
                let state = State::new(&sphere, set);
                assert!((state.cost - places.cost.0[lane]).abs() < 1e-12 * sphere.given().energy);
                let alone = newton::Quadratic::around(&problem, &state, false);
                let wanted = alone.step(0.01, &[]).unwrap();
                for (i, wanted) in wanted.iter().enumerate() {
                    assert!((step[i].0[lane] - wanted).abs() < 1e-7, "{} {wanted}", step[i].0[lane]);
                }
                let wanted = alone.fall(&wanted);
                assert!((fall.0[lane] - wanted).abs() < 1e-7 * wanted, "{} {wanted}", fall.0[lane]);
            }
        }
    }
}
