//! The best radiances of lights in fixed directions, none of which takes light away.
//!
//! For one channel, with the Gram matrix G of the columns and their products b with the irradiance,
//!
//! ```text
//!   least  x^T G x - 2 b^T x      where  x_j >= 0 for the lights and  A(n).x >= 0 for every normal n
//! ```
//!
//! and A(n) is what the ambient coefficients give at n. With a constant environment the second
//! condition is one of the first kind, and `nnls.rs` answers. Harmonics have any sign; their condition
//! is met by cuts: the normal at which the ambient term is most negative is added to those where it may
//! not be, and the problem solved again (Kelley 1960), until none is left. The multipliers u of the
//! conditions C are themselves a problem of non-negative least squares:
//!
//! ```text
//!   x = G^-1 (b + C^T u)      least  u^T C G^-1 C^T u + 2 u^T C G^-1 b,  u >= 0
//! ```

use std::sync::Arc;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::ambient::{Ambient, darkest};
use super::factors::Factors;
use super::nnls::{self, Support};
use super::objective::Given;

/// Share of the brightest ambient irradiance that counts as none.
const DARK: f64 = 1e-7;
/// Cuts after which the rest is lifted away.
const CUTS: usize = 40;

/// The values of each channel.
#[derive(Clone, Debug)]
pub struct Radiances {
    /// Coefficients of the ambient term, then irradiance of the lights; a column for each channel.
    pub x: DMatrix<f64>,
    /// For each channel, the columns that it uses.
    pub supports: Vec<Arc<Support>>,
    /// For each channel, the normals at which the ambient term is kept from turning negative.
    pub dark: Vec<Vec<DVec3>>,
}

/// The best values; those that are not 0 are searched from those of `guess`, if any.
pub fn solve(given: &Given, gram: &DMatrix<f64>, right: &DMatrix<f64>, guess: &[Arc<Support>]) -> Radiances {
    let (x, supports) = nnls::solve(gram, right, given.free(), guess);
    let mut radiances = Radiances { x, supports, dark: vec![Vec::new(); right.ncols()] };
    if given.ambient == Ambient::Sh2 {
        let is_shaded = |&channel: &usize| shadow(&radiances.x.column(channel).into_owned()).is_some();
        let shaded: Vec<usize> = (0..right.ncols()).filter(is_shaded).collect();
        let factors = if shaded.is_empty() { None } else { Factors::new(with_ridge(gram)) };
        for channel in shaded {
            radiances.lighten(gram, factors.as_ref(), right, channel);
        }
    }
    radiances
}

impl Radiances {
    /// Keep the ambient term of a channel from turning negative; `gram` has these `factors`, but for a ridge.
    fn lighten(
        &mut self,
        gram: &DMatrix<f64>,
        factors: Option<&Factors>,
        right: &DMatrix<f64>,
        channel: usize,
    ) {
        let (x, dark) = lit_up(gram, factors, &right.column(channel).into_owned());
        let used = (0..x.len()).filter(|&i| i < 9 || x[i] > 0.0).collect();
        if let Some(support) = Support::new(gram, used) {
            self.supports[channel] = Arc::new(support);
        }
        self.x.set_column(channel, &x);
        self.dark[channel] = dark;
    }
}

/// The normal at which the ambient term of `x` is darkest, where it is below zero there.
fn shadow(x: &DVector<f64>) -> Option<DVec3> {
    let (normal, least) = darkest(&x.as_slice()[..9]);
    (least < -DARK * x.rows(0, 9).amax()).then_some(normal)
}

/// A condition `row.x >= 0`.
struct Condition {
    row: DVector<f64>,
    /// `G^-1 row`: where its multiplier pushes.
    push: DVector<f64>,
    /// Its normal, if it is one on the ambient term.
    normal: Option<DVec3>,
}

/// The best values of one channel with harmonics, and the normals of the conditions that hold it; those
/// with a constant environment alone where the conditions cannot be met as well.
fn lit_up(
    gram: &DMatrix<f64>,
    factors: Option<&Factors>,
    right: &DVector<f64>,
) -> (DVector<f64>, Vec<DVec3>) {
    let cost = |x: &DVector<f64>| (gram * x).dot(x) - 2.0 * right.dot(x);
    let Cut { x, dark, lifted } = cut(factors, right);
    if lifted <= DARK * x.rows(0, 9).amax() {
        return (x, dark);
    }
    let constant = constant(gram, right);
    if cost(&x) <= cost(&constant) { (x, dark) } else { (constant, Vec::new()) }
}

/// The best values without the harmonics of order 1 and 2.
fn constant(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let kept: Vec<usize> = (0..right.len()).filter(|&i| i == 0 || i >= 9).collect();
    let gram = DMatrix::from_fn(kept.len(), kept.len(), |i, j| gram[(kept[i], kept[j])]);
    let right_of = DMatrix::from_fn(kept.len(), 1, |i, _| right[kept[i]]);
    let (values, _) = nnls::solve(&gram, &right_of, 0, &[]);
    let mut x = DVector::zeros(right.len());
    kept.into_iter().zip(&values).for_each(|(i, &value)| x[i] = value);
    x
}

/// The values that cuts lead to.
struct Cut {
    x: DVector<f64>,
    /// Normals of the conditions that hold them.
    dark: Vec<DVec3>,
    /// By how much the ambient irradiance had to be raised where the cuts ended too soon.
    lifted: f64,
}

/// The best values with harmonics.
fn cut(factors: Option<&Factors>, right: &DVector<f64>) -> Cut {
    let Some(factors) = factors else {
        return Cut { x: right * 0.0, dark: Vec::new(), lifted: f64::INFINITY };
    };
    let solved = |mut right: DVector<f64>| {
        factors.solve(right.as_mut_slice());
        right
    };
    let plain = solved(right.clone());
    let mut x = plain.clone();
    let mut conditions: Vec<Condition> = Vec::new();
    for _ in 0..CUTS {
        let violated = violated(&x);
        if violated.is_empty() {
            break;
        }
        let condition =
            |(row, normal): (DVector<f64>, _)| Condition { push: solved(row.clone()), row, normal };
        conditions.extend(violated.into_iter().map(condition));
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
    Cut { x, dark: conditions.into_iter().filter_map(|condition| condition.normal).collect(), lifted }
}

/// The conditions that `x` breaks, each with its normal: each light, and the ambient term where it is
/// darkest.
fn violated(x: &DVector<f64>) -> Vec<(DVector<f64>, Option<DVec3>)> {
    let row = |columns: &[f64], first: usize| {
        let mut row = DVector::zeros(x.len());
        row.rows_mut(first, columns.len()).copy_from_slice(columns);
        row
    };
    let rounding = -1e-12 * x.amax();
    let lights = (9..x.len()).filter(|&i| x[i] < rounding).map(|i| (row(&[1.0], i), None));
    let ambient = shadow(x).map(|normal| (row(&Ambient::Sh2.irradiance(normal), 0), Some(normal)));
    lights.chain(ambient).collect()
}

/// What rounding has left below zero, raised to it; the ambient irradiance by how much.
fn lift(x: &mut DVector<f64>) -> f64 {
    x.rows_range_mut(9..).apply(|value| *value = value.max(0.0));
    let (_, least) = darkest(&x.as_slice()[..9]);
    let lifted = (-least).max(0.0);
    x[0] += lifted / Ambient::Sh2.irradiance(DVec3::Z)[0];
    lifted
}

/// `gram`, with a little more on its diagonal, so that columns may depend on each other.
fn with_ridge(gram: &DMatrix<f64>) -> DMatrix<f64> {
    let mut gram = gram.clone();
    for i in 0..gram.nrows() {
        gram[(i, i)] *= 1.0 + 1e-12;
    }
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
        /// Karush-Kuhn-Tucker: what falls does so only along conditions that hold.
        #[test]
        fn no_small_change_within_the_conditions_is_better(
            values in proptest::collection::vec(0.0..1.0_f64, 80),
            along in proptest::collection::vec(-1.0..1.0_f64, 11),
        ) {
            let (normals, weights) = sampling::icosphere(80).unwrap();
            // Powers make bright spots, which harmonics ring around.
            let seen = Array2::from_shape_fn((80, 3), |(i, _)| values[i].powi(8));
            let probe = Probe::new(Samples::new(normals.view(), weights.view(), seen.view()).unwrap(), Ambient::Sh2);
            let moments = probe.moments(&[DVec3::Y, DVec3::X]);
            let (gram, right) = (&moments.gram, &moments.rhs);
            let x = solve(probe.given(), gram, right, &[]).x.column(0).into_owned();
            let cost = |x: &DVector<f64>| (gram * x).dot(x) - 2.0 * right.column(0).dot(x);
            prop_assert!(x.rows_range(9..).min() >= 0.0);
            prop_assert!(darkest(&x.as_slice()[..9]).1 >= -1e-12);
            let mut other = &x + DVector::from_vec(along) * 0.01;
            lift(&mut other);
            prop_assert!(cost(&x) <= cost(&other) + 1e-6, "{} {}", cost(&x), cost(&other));
        }
    }
}
