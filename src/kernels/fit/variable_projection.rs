//! The cost around a state, to second order in the coordinates `t` of its lights.
//!
//! For the best radiances `x` for every t (variable projection: Golub and Pereyra 1973), the columns `A_c` that
//! channel c uses, their Gram matrix `G_c`, the derivatives `da_i` of the columns of the lights and the residual
//! `r_c`, half the gradient and half the second derivative are
//!
//! ```text
//!   g_i  = -sum_c x_ic <da_i, r_c>
//!   H_ik = sum_c [ x_ic x_kc <da_i, da_k> - T_c G_c^-1 T_c^T - x_ic <d^2 a_ik, r_c> ]
//!   T_c  = X_c <da, A_c> - Lambda_c S                     Lambda_ic = <da_i, r_c>
//! ```
//!
//! where `x_ic` is the radiance of the light of the coordinate i, S picks its column, and `d^2 a_ik` is 0 for
//! coordinates of two lights. An objective without second derivatives gets the step of Gauss and Newton in Kaufman's
//! form (1975), which leaves out Lambda and the last term.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use super::ambient::Ambient;
use super::factors::{add, column_of};
use super::objective::{Constraint, Derivatives, Objective};
use super::state::State;

/// `cost + 2 gradient.t + t^T hessian t`.
#[derive(Clone, Debug)]
pub struct Quadratic {
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
    /// Number of coordinates of each light.
    pub each: usize,
    /// True if second derivatives are part of the Hessian, which may then have negative eigenvalues.
    pub is_exact: bool,
}

impl Quadratic {
    /// The cost around `state`.
    pub fn around(objective: &dyn Objective, state: &State, is_exact: bool) -> Self {
        let derivatives = objective.derivatives(&state.moments, &state.x, is_exact);
        Arch::new().dispatch(Projection { objective, state, derivatives: &derivatives })
    }

    /// The predicted decrease of the cost.
    pub fn fall(&self, step: &DVector<f64>) -> f64 {
        -(2.0 * self.gradient.dot(step) + step.dot(&(&self.hessian * step)))
    }
}

/// See [`Quadratic::around`].
struct Projection<'a> {
    objective: &'a dyn Objective,
    state: &'a State,
    derivatives: &'a Derivatives,
}

impl WithSimd for Projection<'_> {
    type Output = Quadratic;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Quadratic {
        let Self { objective, state, derivatives } = self;
        let (reference, size, each) =
            (objective.reference(), derivatives.gram.nrows(), objective.coordinates());
        let mut sum = Quadratic {
            gradient: DVector::zeros(size),
            hessian: DMatrix::zeros(size, size),
            each,
            is_exact: derivatives.second.is_some(),
        };
        for channel in 0..state.x.ncols() {
            let part = ChannelPart::new(derivatives, state, channel, reference.ambient.coefficients(), each);
            part.add_to(&mut sum, derivatives, reference.copies(channel));
        }
        if let Some(second) = &derivatives.second {
            add_blocks(&mut sum.hessian, second, each);
        }
        sum
    }
}

/// The sums of one channel.
struct ChannelPart {
    /// Radiance of the light of each coordinate.
    radiance: Vec<f64>,
    /// `Lambda`
    slope: Vec<f64>,
    /// `T_c` in columns that are orthonormal, so that `T_c G_c^-1 T_c^T` is their product with themselves.
    rows: DMatrix<f64>,
}

impl ChannelPart {
    #[inline(always)]
    fn new(derivatives: &Derivatives, state: &State, channel: usize, ambient: usize, each: usize) -> Self {
        let (size, x) = (derivatives.gram.nrows(), column_of(&state.x, channel));
        let support = &state.supports[channel];
        let mut slope = column_of(&derivatives.rhs, channel).to_vec();
        for (column, &x) in x.iter().enumerate() {
            add(&mut slope, -x, column_of(&derivatives.model, column));
        }
        let mut radiance = vec![0.0; size];
        for (i, radiance) in radiance.iter_mut().enumerate() {
            *radiance = x[ambient + i / each];
        }
        let dark = &state.dark[channel];
        let mut rows = DMatrix::zeros(size + dark.len(), support.columns.len());
        for (k, &column) in support.columns.iter().enumerate() {
            let out = &mut rows.as_mut_slice()[k * (size + dark.len())..][..size];
            for (i, product) in column_of(&derivatives.model, column).iter().enumerate() {
                out[i] = radiance[i] * product;
            }
            if derivatives.second.is_some() && column >= ambient {
                let own = (column - ambient) * each;
                (own..own + each).for_each(|i| out[i] -= slope[i]);
            }
        }
        for (i, &normal) in dark.iter().enumerate() {
            // All harmonics are in the support: they may have any sign.
            let condition = Ambient::Sh2.irradiance(normal);
            (0..ambient).for_each(|k| rows[(size + i, k)] = condition[k]);
        }
        support.factors.orthonormalize(&mut rows);
        project_out(&mut rows, size);
        Self { radiance, slope, rows }
    }

    #[inline(always)]
    fn add_to(&self, sum: &mut Quadratic, derivatives: &Derivatives, copies: f64) {
        let size = self.radiance.len();
        for i in 0..size {
            sum.gradient[i] -= copies * self.radiance[i] * self.slope[i];
        }
        for k in 0..size {
            let column = &mut sum.hessian.as_mut_slice()[k * size..(k + 1) * size];
            let (gram, own) = (column_of(&derivatives.gram, k), copies * self.radiance[k]);
            for i in 0..size {
                column[i] += own * self.radiance[i] * gram[i];
            }
            for row in 0..self.rows.ncols() {
                let along = &column_of(&self.rows, row)[..size];
                add(column, -copies * along[k], along);
            }
        }
    }
}

/// Remove from the first `size` rows their part along the others: conditions that hold them.
#[inline(always)]
fn project_out(rows: &mut DMatrix<f64>, size: usize) {
    /// Two conditions may be nearly the same: their difference is rounding.
    const DEPENDENT: f64 = 1e-12;
    for condition in size..rows.nrows() {
        let along = rows.row(condition).into_owned();
        let square = along.norm_squared();
        if square <= DEPENDENT {
            continue;
        }
        for i in (0..size).chain(condition + 1..rows.nrows()) {
            let share = rows.row(i).dot(&along) / square;
            rows.row_mut(i).zip_apply(&along, |value, part| *value -= share * part);
        }
    }
}

/// Add a block to the diagonal for each light of `each` coordinates.
fn add_blocks(hessian: &mut DMatrix<f64>, blocks: &[DMat3], each: usize) {
    for (light, block) in blocks.iter().enumerate() {
        for k in 0..each {
            (0..each).for_each(|i| hessian[(each * light + i, each * light + k)] += block.col(k)[i]);
        }
    }
}

/// The steps that constraints allow: one of them, and an orthonormal basis of their differences.
#[derive(Debug)]
pub struct Subspace {
    origin: DVector<f64>,
    /// A column for each free coordinate; absent if all are free.
    basis: Option<DMatrix<f64>>,
}

impl Subspace {
    /// For lights of `each` coordinates. A constraint that contradicts those before it is left out.
    pub fn new(size: usize, each: usize, constraints: &[Constraint]) -> Self {
        let mut origin = DVector::zeros(size);
        if constraints.is_empty() {
            return Self { origin, basis: None };
        }
        let mut columns: Vec<DVector<f64>> = Vec::with_capacity(size);
        for light in 0..size / each.max(1) {
            let own = constraints.iter().filter(|constraint| constraint.light == light);
            let (start, free) = free_axes(each, own);
            for i in 0..each {
                origin[each * light + i] = start[i];
            }
            columns.extend(free.iter().map(|axis| {
                let mut column = DVector::zeros(size);
                (0..each).for_each(|i| column[each * light + i] = axis[i]);
                column
            }));
        }
        let basis = DMatrix::from_fn(size, columns.len(), |i, k| columns[k][i]);
        Self { origin, basis: Some(basis) }
    }

    /// The Hessian and the gradient of a quadratic by the free coordinates.
    pub fn reduce(&self, quadratic: &Quadratic) -> (DMatrix<f64>, DVector<f64>) {
        let Quadratic { gradient, hessian, .. } = quadratic;
        let Some(basis) = &self.basis else { return (hessian.clone(), gradient.clone()) };
        (basis.tr_mul(&(hessian * basis)), basis.tr_mul(&(gradient + hessian * &self.origin)))
    }

    /// The step with these free coordinates.
    pub fn full(&self, free: DVector<f64>) -> DVector<f64> {
        match &self.basis {
            None => free,
            Some(basis) => basis * free + &self.origin,
        }
    }

    /// The covariance of all coordinates from that of the free ones.
    pub fn full_covariance(&self, free: DMatrix<f64>) -> DMatrix<f64> {
        match &self.basis {
            None => free,
            Some(basis) => basis * free * basis.transpose(),
        }
    }
}

/// The step of one light that meets its constraints, and the axes along which it may change.
fn free_axes<'a>(each: usize, constraints: impl Iterator<Item = &'a Constraint>) -> (DVec3, Vec<DVec3>) {
    /// Squared length, beside those before it, of a constraint that adds nothing, and of an axis that does.
    const DEPENDENT: f64 = 1e-12;
    const INDEPENDENT: f64 = 0.1;
    let mut known: Vec<DVec3> = Vec::with_capacity(each);
    let beside = |known: &[DVec3], axis: DVec3| known.iter().fold(axis, |rest, q| rest - *q * q.dot(axis));
    let mut origin = DVec3::ZERO;
    for &Constraint { across, ahead, .. } in constraints {
        let rest = beside(&known, across);
        if rest.length_squared() > DEPENDENT * across.length_squared() {
            origin += rest * ((ahead - across.dot(origin)) / rest.length_squared());
            known.push(rest.normalize());
        }
    }
    let held = known.len();
    for axis in &DVec3::AXES[..each] {
        let rest = beside(&known, *axis);
        if rest.length_squared() > INDEPENDENT {
            known.push(rest.normalize());
        }
    }
    (origin, known.split_off(held))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub mod tests {
    use super::*;
    use crate::kernels::fit::Sphere;
    use crate::kernels::fit::comparison::Comparison;
    use crate::kernels::fit::discs::Shadows;
    use crate::kernels::fit::discs::target::Target;
    use crate::kernels::fit::picture::Picture;
    use crate::kernels::image::{self, WorkingMap};
    use crate::kernels::sphere::{Registration, direction};
    use ndarray::Array3;

    /// A map of two broad lights and a hot pixel in a coloured sky.
    pub fn world(scale: f32) -> WorkingMap {
        let map = Array3::from_shape_fn((64, 128, 3), |(y, x, c)| {
            let near = |row: f64, column: f64, width: f64| {
                (-((y as f64 - row).powi(2) + (x as f64 - column).powi(2)) / (width * width)).exp()
            };
            let hot = if (y, x) == (20, 37) { 900.0 } else { 0.0 };
            let sky = 0.3 + 0.1 * c as f64;
            (sky + 5.0 * near(18.0, 90.0, 9.0) + 3.0 * near(40.0, 30.0, 14.0) + hot) as f32 * scale
        });
        image::reduce(map.view(), Registration::CellCentred, 256, 2e-3, false).unwrap()
    }

    /// The products of discs with a map.
    pub fn target(map: &WorkingMap, comparison: Comparison, ambient: Ambient, has_floor: bool) -> Target {
        Target::new(&Picture::new(map), comparison, ambient, has_floor)
    }

    const CONDITIONS: [(Ambient, bool); 4] = [
        (Ambient::None, false),
        (Ambient::Constant, false),
        (Ambient::Constant, true),
        (Ambient::Sh2, false),
    ];

    /// Differences of the reduced cost, whose radiances are the best at every step, along each pair of coordinates.
    fn assert_derivatives_are_measured(objective: &dyn Objective, state: &State, step: f64) {
        let model = Quadratic::around(objective, state, true);
        let size = model.gradient.len();
        let cost = |moves: [(usize, f64); 2]| {
            let mut along = vec![0.0; size];
            for (i, by) in moves {
                along[i] += by * step;
            }
            State::at(objective, objective.after_step(&state.moments, &along), 0, &state.supports).cost
        };
        let scale = model.hessian.amax();
        for i in 0..size {
            let slope = (cost([(i, 1.0), (i, 0.0)]) - cost([(i, -1.0), (i, 0.0)])) / (2.0 * step);
            assert!(
                (slope - 2.0 * model.gradient[i]).abs() < 1e-4 * scale,
                "{i}: {slope} {}",
                model.gradient[i]
            );
            for k in 0..size {
                let corner = |a: f64, b: f64| cost([(i, a), (k, b)]);
                let corners = corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
                let second = corners / (4.0 * step * step);
                let error = (second - 2.0 * model.hessian[(i, k)]).abs();
                assert!(error < 3e-3 * scale, "{i} {k}: {second} {}", 2.0 * model.hessian[(i, k)]);
            }
        }
    }

    #[test]
    fn the_quadratic_of_points_is_that_of_the_cost() {
        let map = world(1.0);
        let lights = [(1.0, 1.8), (0.8, 4.4), (1.1, 2.5)].map(|(theta, phi)| direction(theta, phi));
        for (ambient, has_floor) in CONDITIONS {
            let sphere = Sphere::new(&map, ambient, has_floor);
            assert_derivatives_are_measured(&sphere, &State::new(&sphere, &lights), 1e-3);
        }
    }

    #[test]
    fn the_quadratic_of_discs_is_that_of_the_cost() {
        let map = world(1.0);
        assert!(!map.parts.is_empty());
        for (ambient, has_floor) in CONDITIONS {
            let sphere = Sphere::new(&map, ambient, has_floor);
            for comparison in [Comparison::Probe, Comparison::Shadows, Comparison::Mixed] {
                let target = target(&map, comparison, ambient, has_floor);
                let shadows = Shadows::new(&target, sphere.reference());
                let discs = [(1.0, 1.8, 0.05), (0.8, 4.4, 0.3), (1.1, 2.5, 0.4)];
                let discs = discs.map(|(theta, phi, radius)| shadows.disc(direction(theta, phi), radius));
                assert_derivatives_are_measured(&shadows, &shadows.state(discs.to_vec()), 1e-3);
            }
        }
    }

    #[test]
    fn free_axes_are_orthogonal_to_the_constraints_that_the_origin_meets() {
        let constraint = |across: DVec3, ahead| Constraint { light: 0, across, ahead };
        let one = constraint(DVec3::new(0.99, 0.1, -0.1), 0.3);
        let other = constraint(DVec3::new(0.2, 0.5, 0.9), -0.2);
        for constraints in [vec![one], vec![one, other], vec![one, constraint(2.0 * one.across, 9.0), other]]
        {
            let (origin, axes) = free_axes(3, constraints.iter());
            assert_eq!(axes.len(), if constraints.len() == 1 { 2 } else { 1 });
            for Constraint { across, ahead, .. } in [constraints[0], constraints[constraints.len() - 1]] {
                assert!((across.dot(origin) - ahead).abs() < 1e-12);
                assert!(axes.iter().all(|axis| axis.dot(across).abs() < 1e-12));
            }
        }
    }
}
