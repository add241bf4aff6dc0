//! How far the lights are determined: by a map, and by measured probe values.
//!
//! A map has no noise, so no standard errors: what counts is how far a light may stand elsewhere, the others
//! refitted, before the error grows by a tenth. With half the second derivative H of the cost, the step t of one
//! light costs `t^T ((H^-1)_own)^-1 t` at least, so
//!
//! ```text
//!   farthest^2 = (1.1^2 - 1) cost * greatest eigenvalue of (H^-1)_own
//! ```
//!
//! Measured values have noise, the same in all channels of a normal or not. With the Jacobian J of all free
//! unknowns - radiances channel by channel, then the two tangent coordinates of every direction that moved - and
//! the residuals r of n normals, their covariance S between channels gives
//!
//! ```text
//!   covariance = (J^T W J)^-1  J^T W S J  (J^T W J)^-1        S_cd = 3 sum w r_c r_d / (3 n - unknowns)
//! ```
//!
//! A value held at zero is no unknown. A normal on the horizon of a light that may turn is no evidence: its
//! derivatives differ from side to side, and what is left of J is the same from both.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};

use super::damped_newton::Descent;
use super::objective::{Given, Objective, PointObjective};
use super::rig::Rig;
use super::samples::{Probe, Samples};
use super::state::State;
use super::variable_projection::{Quadratic, Subspace};

/// Growth of the error at which a light has gone too far.
const GROWTH: f64 = 1.1;

/// Direction tolerance of each light of `state`, in radians: the turn that makes the relative RMS error, now that of
/// `cost`, a tenth larger; 0 if the light is fixed, pi if the cost does not depend on it.
pub fn tolerances(descent: &Descent<'_>, state: &State, cost: f64) -> Vec<f64> {
    let model = Quadratic::around(descent.objective, state, true);
    let space = Subspace::new(model.gradient.len(), model.each, &descent.constraints(state, &model));
    let Some(factor) = space.reduced(&model).0.cholesky() else {
        return (0..state.lights()).map(|light| if light < descent.fixed { 0.0 } else { PI }).collect();
    };
    let inverse = space.full_covariance(factor.inverse());
    let tolerance = |light: usize| {
        let own = inverse.view((model.each * light, model.each * light), (2, 2)).into_owned();
        let greatest = own.symmetric_eigenvalues().max();
        ((GROWTH * GROWTH - 1.0) * cost.max(0.0) * greatest).sqrt().min(PI)
    };
    (0..state.lights()).map(tolerance).collect()
}

/// What the covariance says of a rig.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// Ratio of the greatest to the least singular value of J, its columns brought to length 1:
    /// infinite where the probe does not tell two unknowns apart.
    pub condition: f64,
    /// Standard error of each light's direction, in radians: 0 where it was fixed.
    pub direction: Vec<f64>,
    /// Standard error of each light's irradiance in each channel: 0 where it is held at zero.
    pub irradiance: Vec<[f64; 3]>,
}

impl Default for Uncertainty {
    /// Of what was not measured.
    fn default() -> Self {
        Self { condition: 1.0, direction: Vec::new(), irradiance: Vec::new() }
    }
}

/// Of the lights of `rig`, of which the first `fixed` keep their directions.
pub fn uncertainty(probe: &Probe, rig: &Rig, fixed: usize) -> Uncertainty {
    /// Cosine of the angle between a light and a normal on its horizon, at most: a light that follows a
    /// kink stands within rounding of it.
    const HORIZON: f64 = 1e-9;
    let is_evidence = |normal: DVec3| rig.directions[fixed..].iter().all(|l| l.dot(normal).abs() > HORIZON);
    match probe.samples.only(is_evidence) {
        Some(clear) => of_evidence(&Probe::new(clear, probe.given().ambient), rig, fixed),
        None => of_evidence(probe, rig, fixed),
    }
}

fn of_evidence(probe: &Probe, rig: &Rig, fixed: usize) -> Uncertainty {
    let columns = Columns::new(probe, rig);
    let unknowns = columns.unknowns(probe.given(), rig, fixed);
    let count = unknowns.len();
    let products = |noise: DMat3| {
        DMatrix::from_fn(count, count, |i, k| columns.inner(rig, unknowns[i], unknowns[k], noise))
    };
    let normal = products(DMat3::IDENTITY);
    let length = normal.diagonal().map(|square| square.sqrt().max(f64::MIN_POSITIVE));
    let scaled =
        |matrix: DMatrix<f64>| DMatrix::from_fn(count, count, |i, k| matrix[(i, k)] / length[i] / length[k]);
    let normal = scaled(normal);
    let condition = condition(&normal);
    let error = match normal.cholesky() {
        Some(factor) if condition.is_finite() => {
            let inverse = factor.inverse();
            let spread = scaled(products(noise(&probe.samples, rig, count)));
            (&inverse * spread * &inverse).diagonal().map(|square| square.max(0.0).sqrt())
        }
        _ => DVector::repeat(count, f64::INFINITY),
    };
    let lights = rig.directions.len();
    let mut out = Uncertainty { condition, direction: vec![0.0; lights], irradiance: vec![[0.0; 3]; lights] };
    for (i, unknown) in unknowns.iter().enumerate() {
        out.set(&columns, probe.given(), *unknown, error[i] / length[i]);
    }
    out
}

/// The covariance of the residuals of `rig` between channels.
fn noise(samples: &Samples, rig: &Rig, unknowns: usize) -> DMat3 {
    let freedom = (3 * samples.normals.len()).saturating_sub(unknowns).max(1) as f64;
    let normals = samples.normals.iter().zip(&samples.weights).zip(&samples.irradiance);
    let sum = normals.fold(DMat3::ZERO, |sum, ((&n, &weight), &e)| {
        let off = e - rig.at(n);
        sum + DMat3::from_cols(off * off.x, off * off.y, off * off.z) * weight
    });
    sum * (3.0 / freedom)
}

impl Uncertainty {
    fn set(&mut self, columns: &Columns, given: &Given, unknown: Unknown, error: f64) {
        let Unknown { column, channel } = unknown;
        match channel {
            None => {
                let direction = &mut self.direction[(column - columns.model) / 2];
                *direction = direction.hypot(error);
            }
            Some(channel) if column >= given.ambient.coefficients() => {
                self.irradiance[column - given.ambient.coefficients()][channel] = error;
            }
            Some(_) => (),
        }
    }
}

/// Ratio of the greatest to the least singular value of the matrix whose Gram matrix this is.
fn condition(gram: &DMatrix<f64>) -> f64 {
    if gram.is_empty() {
        return 1.0;
    }
    let values = gram.symmetric_eigenvalues();
    let rounding = gram.nrows() as f64 * f64::EPSILON * values.max();
    if values.min() <= rounding { f64::INFINITY } else { (values.max() / values.min()).sqrt() }
}

/// One unknown: a column of [`Columns`], in one channel or, for a direction, in all.
#[derive(Clone, Copy)]
struct Unknown {
    column: usize,
    channel: Option<usize>,
}

/// The columns of the model, then their derivatives when a light turns.
struct Columns {
    /// How many belong to the model.
    model: usize,
    /// Inner products of all.
    gram: DMatrix<f64>,
}

impl Columns {
    fn new(probe: &Probe, rig: &Rig) -> Self {
        let moments = probe.moments(&rig.directions);
        let derivatives = probe.derivatives(&moments, &DMatrix::zeros(0, 0), false);
        let (model, turned) = (moments.gram.nrows(), derivatives.model.nrows());
        let mut gram = moments.gram.resize(model + turned, model + turned, 0.0);
        gram.view_mut((model, 0), (turned, model)).copy_from(&derivatives.model);
        gram.view_mut((model, model), (turned, turned)).copy_from(&derivatives.gram);
        gram.fill_upper_triangle_with_lower_triangle();
        Self { model, gram }
    }

    fn unknowns(&self, given: &Given, rig: &Rig, fixed: usize) -> Vec<Unknown> {
        let value = |channel: usize, column: usize| match column.checked_sub(given.ambient.coefficients()) {
            None => rig.ambient[column][channel],
            Some(light) => rig.irradiance[light][channel],
        };
        let is_free = |channel: usize, column: usize| column < given.free() || value(channel, column) > 0.0;
        let radiances = (0..3).flat_map(|channel| {
            let free = (0..self.model).filter(move |&column| is_free(channel, column));
            free.map(move |column| Unknown { column, channel: Some(channel) })
        });
        let directions = self.model + 2 * fixed..self.gram.nrows();
        let directions = directions.map(|column| Unknown { column, channel: None });
        radiances.chain(directions).collect()
    }

    /// Inner product of two columns of the Jacobian, with this `noise` between channels.
    fn inner(&self, rig: &Rig, a: Unknown, b: Unknown, noise: DMat3) -> f64 {
        let scale = |unknown: Unknown| match unknown.channel {
            Some(own) => DVec3::AXES[own],
            None => rig.irradiance[(unknown.column - self.model) / 2],
        };
        scale(a).dot(noise * scale(b)) * self.gram[(a.column, b.column)]
    }
}
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::Ambient;
    use crate::kernels::fit::rig::irradiance;
    use crate::kernels::sampling;
    use glam::DVec3;

    /// Against the Jacobian itself, by differences, the inverse of its square, and the noise that channels share.
    #[test]
    fn the_errors_are_those_of_the_jacobian() {
        let (normals, _) = sampling::icosphere(80).unwrap();
        let rig = Rig {
            ambient: vec![DVec3::splat(0.2)],
            directions: vec![DVec3::new(1.0, 2.0, 2.0) / 3.0],
            irradiance: vec![DVec3::new(3.0, 2.0, 0.0)],
            has_floor: false,
        };
        let mut seen = irradiance(&rig, normals.view()).unwrap();
        seen.indexed_iter_mut().for_each(|((i, c), value)| *value += 0.01 * ((i * 7 + c) % 5) as f64);
        let weights = ndarray::Array1::ones(80);
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        let probe = Probe::new(samples, Ambient::Constant);
        let found = uncertainty(&probe, &rig, 0);
        let [s, t] = crate::kernels::sphere::tangents(rig.directions[0]);
        let lit = |n: DVec3, axis: DVec3| if n.dot(rig.directions[0]) > 0.0 { n.dot(axis) } else { 0.0 };
        // Ambient RGB, red and green of the light, two tangents: blue is held at zero.
        let entry = |n: DVec3, c: usize, column: usize| match column {
            0..3 => f64::from(u8::from(c == column)) * std::f64::consts::PI,
            3 | 4 => f64::from(u8::from(c == column - 3)) * lit(n, rig.directions[0]),
            _ => rig.irradiance[0][c] * lit(n, if column == 5 { s } else { t }),
        };
        let jacobian =
            DMatrix::from_fn(240, 7, |row, column| entry(probe.samples.normals[row / 3], row % 3, column));
        let off = |row: usize| probe.samples.irradiance[row / 3] - rig.at(probe.samples.normals[row / 3]);
        let shared = |row: usize, other: usize| {
            let products = (0..80).map(|n| off(3 * n)[row % 3] * off(3 * n)[other % 3]);
            if row / 3 == other / 3 { products.sum::<f64>() * 3.0 / 233.0 } else { 0.0 }
        };
        let noise = DMatrix::from_fn(240, 240, shared);
        let inverse = jacobian.tr_mul(&jacobian).try_inverse().unwrap();
        let covariance = &inverse * jacobian.transpose() * noise * &jacobian * &inverse;
        let direction = (covariance[(5, 5)] + covariance[(6, 6)]).sqrt();
        approx::assert_relative_eq!(found.direction[0], direction, max_relative = 1e-9);
        approx::assert_relative_eq!(found.irradiance[0][1], covariance[(4, 4)].sqrt(), max_relative = 1e-9);
        assert!(found.irradiance[0][2].abs() < f64::MIN_POSITIVE);
    }

    /// Three lights along the axes, and normals each of which is on the horizon of one.
    #[test]
    fn horizons_are_no_evidence_of_where_a_light_is_but_of_how_bright() {
        let planes = |i: usize| {
            let (sin, cos) = (i as f64).sin_cos();
            [DVec3::new(0.0, sin, cos), DVec3::new(sin, 0.0, cos), DVec3::new(sin, cos, 0.0)]
        };
        let normals = crate::kernels::sphere::from_vectors((0..12).flat_map(planes));
        let rig = Rig {
            ambient: vec![DVec3::splat(0.1); 9],
            directions: DVec3::AXES.to_vec(),
            irradiance: vec![DVec3::ONE; 3],
            has_floor: false,
        };
        let seen = irradiance(&rig, normals.view()).unwrap() + 0.01;
        let weights = ndarray::Array1::ones(36);
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        let probe = Probe::new(samples, Ambient::Sh2);
        let free = uncertainty(&probe, &rig, 0);
        assert!(free.condition.is_infinite() && free.direction.iter().all(|error| error.is_infinite()));
        let held = uncertainty(&probe, &rig, 3);
        assert!(held.condition.is_finite() && held.direction == [0.0; 3], "{held:?}");
        assert!(held.irradiance.as_flattened().iter().all(|error| (0.0..1.0).contains(error)), "{held:?}");
    }
}
