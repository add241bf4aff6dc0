//! The best radiances of lights in fixed directions: no light is negative, and no normal has negative ambient irradiance.
//!
//! For one channel, with the Gram matrix G of the columns and their products b with the irradiance,
//!
//! ```text
//!   min  x^T G x - 2 b^T x      where  x_j >= 0 for the lights and  A(n).x >= 0 for every normal n
//! ```
//!
//! and A(n) holds the irradiance at n of each ambient coefficient. For a constant environment the second condition is
//! one of the first kind, and `nnls.rs` solves the problem. Harmonics have any sign, and cutting planes keep their
//! irradiance positive (Kelley 1960): solve, add the condition at the normal with the most negative irradiance, and
//! repeat until no normal is negative. The multipliers u of the conditions C solve another problem of non-negative
//! least squares:
//!
//! ```text
//!   x = G^-1 (b + C^T u)      min  u^T C G^-1 C^T u + 2 u^T C G^-1 b,  u >= 0
//! ```

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::ambient::{Ambient, darkest};
use super::factors::Factors;
use super::nnls::{self, Support};
use super::objective::Reference;

/// Fraction of the ambient irradiance that counts as 0.
const ZERO: f64 = 1e-7;

/// The values of each channel.
#[derive(Clone, Debug)]
pub struct Radiances {
    /// Coefficients of the ambient term, then irradiance of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    /// Columns that each channel uses.
    pub supports: Vec<Arc<Support>>,
    /// Normals at which the ambient irradiance of each channel is held at 0.
    pub dark: Vec<Vec<DVec3>>,
}

/// The best values; the search for those that are not 0 starts from those of `guess`, if any.
pub fn solve(
    reference: &Reference,
    gram: &DMatrix<f64>,
    right: &DMatrix<f64>,
    guess: &[Arc<Support>],
) -> Radiances {
    let (x, supports) = nnls::solve(gram, right, reference.free(), guess);
    let mut radiances = Radiances { x, supports, dark: vec![Vec::new(); right.ncols()] };
    if reference.ambient == Ambient::Sh2 {
        let is_negative = |&channel: &usize| negative(&radiances.x.column(channel).into_owned()).is_some();
        let channels: Vec<usize> = (0..right.ncols()).filter(is_negative).collect();
        let factors = if channels.is_empty() { None } else { Factors::new(with_ridge(gram)) };
        for channel in channels {
            radiances.constrain(gram, factors.as_ref(), right, channel);
        }
    }
    radiances
}

impl Radiances {
    /// Solve one channel again with conditions on the ambient irradiance; `factors` are those of `gram` with a ridge.
    fn constrain(
        &mut self,
        gram: &DMatrix<f64>,
        factors: Option<&Factors>,
        right: &DMatrix<f64>,
        channel: usize,
    ) {
        let right = right.column(channel).into_owned();
        let cost = |x: &DVector<f64>| (gram * x).dot(x) - 2.0 * right.dot(x);
        let (x, dark) = match factors.map(|factors| cutting_planes(factors, &right)) {
            Some((x, dark, lifted)) if lifted <= ZERO * x.rows(0, 9).amax() => (x, dark),
            // Normals that are nearly parallel do not determine the harmonics.
            unfinished => {
                let constant = constant(gram, &right);
                let better = unfinished.filter(|(x, ..)| cost(x) <= cost(&constant));
                better.map_or((constant, Vec::new()), |(x, dark, _)| (x, dark))
            }
        };
        let used = (0..x.len()).filter(|&i| i < 9 || x[i] > 0.0).collect();
        if let Some(support) = Support::new(gram, used) {
            self.supports[channel] = Arc::new(support);
            self.dark[channel] = dark;
        }
        self.x.set_column(channel, &x);
    }
}

/// The normal at which the ambient irradiance is most negative, if it is negative anywhere.
fn negative(x: &DVector<f64>) -> Option<DVec3> {
    let (normal, least) = darkest(&x.as_slice()[..9]);
    (least < -ZERO * x.rows(0, 9).amax()).then_some(normal)
}

/// A condition `row.x >= 0`.
struct Condition {
    row: DVector<f64>,
    /// `G^-1 row`, the change of x by the multiplier.
    push: DVector<f64>,
    /// Normal of a condition on the ambient irradiance.
    normal: Option<DVec3>,
}

/// The best values without the harmonics of order 1 and 2.
fn constant(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let used: Vec<usize> = (0..right.len()).filter(|&i| i == 0 || i >= 9).collect();
    let gram = DMatrix::from_fn(used.len(), used.len(), |i, j| gram[(used[i], used[j])]);
    let (values, _) = nnls::solve(&gram, &DMatrix::from_fn(used.len(), 1, |i, _| right[used[i]]), 0, &[]);
    let mut x = DVector::zeros(right.len());
    used.into_iter().zip(&values).for_each(|(i, &value)| x[i] = value);
    x
}

/// The best values of one channel, the normals at which conditions hold its ambient irradiance at 0, and its increase
/// after the last round.
fn cutting_planes(factors: &Factors, right: &DVector<f64>) -> (DVector<f64>, Vec<DVec3>, f64) {
    /// Greatest number of rounds.
    const ROUNDS: usize = 40;
    let solution = |mut right: DVector<f64>| {
        factors.solve(right.as_mut_slice());
        right
    };
    let plain = solution(right.clone());
    let mut x = plain.clone();
    let mut conditions: Vec<Condition> = Vec::new();
    for _ in 0..ROUNDS {
        let violations = violations(&x);
        if violations.is_empty() {
            break;
        }
        let condition =
            |(row, normal): (DVector<f64>, _)| Condition { push: solution(row.clone()), row, normal };
        conditions.extend(violations.into_iter().map(condition));
        let size = conditions.len();
        let dual = DMatrix::from_fn(size, size, |i, j| conditions[i].row.dot(&conditions[j].push));
        let fall = DMatrix::from_fn(size, 1, |i, _| -conditions[i].row.dot(&plain));
        let (multipliers, _) = nnls::solve(&dual, &fall, 0, &[]);
        x.copy_from(&plain);
        for (condition, &multiplier) in conditions.iter().zip(&multipliers) {
            x.axpy(multiplier, &condition.push, 1.0);
        }
        let mut holds = multipliers.iter().map(|&multiplier| multiplier > 0.0);
        conditions.retain(|_| holds.next() == Some(true));
    }
    let lifted = lift(&mut x);
    (x, conditions.into_iter().filter_map(|condition| condition.normal).collect(), lifted)
}

/// Conditions that `x` violates: each negative light, and the darkest normal of the ambient term.
fn violations(x: &DVector<f64>) -> Vec<(DVector<f64>, Option<DVec3>)> {
    let row = |columns: &[f64], first: usize| {
        let mut row = DVector::zeros(x.len());
        row.rows_mut(first, columns.len()).copy_from_slice(columns);
        row
    };
    let rounding = -1e-12 * x.amax();
    let lights = (9..x.len()).filter(|&i| x[i] < rounding).map(|i| (row(&[1.0], i), None));
    let ambient = negative(x).map(|normal| (row(&Ambient::Sh2.irradiance(normal), 0), Some(normal)));
    lights.chain(ambient).collect()
}

/// Raise negative lights to 0, and the ambient irradiance by the returned amount until it is negative nowhere.
fn lift(x: &mut DVector<f64>) -> f64 {
    x.rows_range_mut(9..).apply(|value| *value = value.max(0.0));
    let lifted = (-darkest(&x.as_slice()[..9]).1).max(0.0);
    x[0] += lifted / Ambient::Sh2.irradiance(DVec3::Z)[0];
    lifted
}

/// `gram` with a slightly larger diagonal, so that its columns may depend on each other.
fn with_ridge(gram: &DMatrix<f64>) -> DMatrix<f64> {
    let mut gram = gram.clone();
    (0..gram.nrows()).for_each(|i| gram[(i, i)] *= 1.0 + 1e-12);
    gram
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::objective::{Objective, PointObjective};
    use crate::kernels::fit::{Probe, Samples};
    use crate::kernels::sampling;
    use ndarray::Array2;
    use proptest::prelude::*;

    proptest! {
        /// Random steps that keep all conditions do not lower the cost.
        #[test]
        fn no_small_change_within_the_conditions_is_better(
            values in proptest::collection::vec(0.0..1.0_f64, 80),
            along in proptest::collection::vec(-1.0..1.0_f64, 11),
        ) {
            let (normals, weights) = sampling::icosphere(80).unwrap();
            // Powers make bright spots, around which harmonics overshoot below 0.
            let irradiance = Array2::from_shape_fn((80, 3), |(i, _)| values[i].powi(8));
            let probe = Probe::new(Samples::new(normals.view(), weights.view(), irradiance.view()).unwrap(), Ambient::Sh2);
            let moments = probe.moments(&[DVec3::Y, DVec3::X]);
            let (gram, right) = (&moments.gram, &moments.rhs);
            let x = solve(probe.reference(), gram, right, &[]).x.column(0).into_owned();
            let cost = |x: &DVector<f64>| (gram * x).dot(x) - 2.0 * right.column(0).dot(x);
            prop_assert!(x.rows_range(9..).min() >= 0.0);
            prop_assert!(darkest(&x.as_slice()[..9]).1 >= -1e-12);
            let mut other = &x + DVector::from_vec(along) * 0.01;
            lift(&mut other);
            prop_assert!(cost(&x) <= cost(&other) + 1e-6, "{} {}", cost(&x), cost(&other));
        }
    }
}
