//! Direction tolerances under a map, and standard errors of a fit to measured values.
//!
//! A map has no noise. The tolerance of a light is the turn that makes the error a tenth larger, if all other unknowns
//! adapt. With half the second derivative H of the cost, a step t of one light costs at least `t^T ((H^-1)_own)^-1 t`, so
//!
//! ```text
//!   tolerance^2 = (1.1^2 - 1) cost * greatest eigenvalue of (H^-1)_own
//! ```
//!
//! Measured values have noise, which the channels of a normal may share. The unknowns are the radiances, channel by
//! channel, then the two tangent coordinates of every free direction. With their Jacobian J, and the covariance S of
//! the residuals r of n normals between channels,
//!
//! ```text
//!   covariance = (J^T W J)^-1  J^T W S J  (J^T W J)^-1        S_cd = 3 sum w r_c r_d / (3 n - unknowns)
//! ```
//!
//! A value that is held at 0 is not an unknown. A normal on the horizon of a free light is left out, because the
//! derivatives jump there.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};

use super::damped_newton::Descent;
use super::objective::{Objective, PointObjective, Reference};
use super::rig::Rig;
use super::samples::{Probe, Samples};
use super::state::State;
use super::variable_projection::{Quadratic, Subspace};

/// Direction tolerance of each light of `state`, in radians, where the error is that of `cost`.
///
/// It is 0 if the light is fixed, and pi if the cost does not depend on its direction.
pub fn tolerances(descent: &Descent<'_>, state: &State, cost: f64) -> Vec<f64> {
    let model = Quadratic::around(descent.objective, state, true);
    let space = Subspace::new(model.gradient.len(), model.each, &descent.constraints(state, &model));
    let Some(factor) = space.reduce(&model).0.cholesky() else {
        return (0..state.lights()).map(|light| if light < descent.fixed { 0.0 } else { PI }).collect();
    };
    let inverse = space.full_covariance(factor.inverse());
    let tolerance = |light: usize| {
        let own = inverse.view((model.each * light, model.each * light), (2, 2)).into_owned();
        let greatest = own.symmetric_eigenvalues().max();
        ((1.1 * 1.1 - 1.0) * cost.max(0.0) * greatest).sqrt().min(PI)
    };
    (0..state.lights()).map(tolerance).collect()
}

/// Condition number and standard errors of a rig.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// Ratio of the greatest to the least singular value of J with columns of unit length; infinite if the probe does not
    /// determine all unknowns.
    pub condition: f64,
    /// Standard error of each light's direction, in radians; 0 if it was fixed.
    pub direction: Vec<f64>,
    /// Standard error of each light's irradiance in each channel; 0 if the irradiance is held at 0.
    pub irradiance: Vec<[f64; 3]>,
}

impl Default for Uncertainty {
    /// No measured unknowns.
    fn default() -> Self {
        Self { condition: 1.0, direction: Vec::new(), irradiance: Vec::new() }
    }
}

/// Uncertainty of the lights of `rig`, whose first `fixed` lights keep their directions.
pub fn uncertainty(probe: &Probe, rig: &Rig, fixed: usize) -> Uncertainty {
    /// Cosine between a light and a normal up to which the normal is on its horizon. A fitted light often lies on the
    /// horizon of a normal, except for rounding.
    const HORIZON: f64 = 1e-9;
    let is_off_horizons =
        |normal: DVec3| rig.directions[fixed..].iter().all(|l| l.dot(normal).abs() > HORIZON);
    match probe.samples.only(is_off_horizons) {
        Some(samples) => errors_from(&Probe::new(samples, probe.reference().ambient), rig, fixed),
        None => errors_from(probe, rig, fixed),
    }
}

/// Uncertainty from a probe without normals on the horizon of a free light.
fn errors_from(probe: &Probe, rig: &Rig, fixed: usize) -> Uncertainty {
    let columns = ModelColumns::new(probe, rig);
    let unknowns = columns.unknowns(probe.reference(), rig, fixed);
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
        out.set(&columns, probe.reference(), *unknown, error[i] / length[i]);
    }
    out
}

/// Covariance of the residuals of `rig` between channels.
fn noise(samples: &Samples, rig: &Rig, unknowns: usize) -> DMat3 {
    let freedom = (3 * samples.normals.len()).saturating_sub(unknowns).max(1) as f64;
    let normals = samples.normals.iter().zip(&samples.weights).zip(&samples.irradiance);
    let sum = normals.fold(DMat3::ZERO, |sum, ((&n, &weight), &e)| {
        let r = e - rig.at(n);
        sum + DMat3::from_cols(r * r.x, r * r.y, r * r.z) * weight
    });
    sum * (3.0 / freedom)
}

impl Uncertainty {
    /// Store the standard error of one unknown.
    fn set(&mut self, columns: &ModelColumns, reference: &Reference, unknown: Unknown, error: f64) {
        let Unknown { column, channel } = unknown;
        match channel {
            None => {
                let direction = &mut self.direction[(column - columns.model) / 2];
                *direction = direction.hypot(error);
            }
            Some(channel) if column >= reference.ambient.coefficients() => {
                self.irradiance[column - reference.ambient.coefficients()][channel] = error;
            }
            Some(_) => (),
        }
    }
}

/// Ratio of the greatest to the least singular value of a matrix, from its Gram matrix.
fn condition(gram: &DMatrix<f64>) -> f64 {
    if gram.is_empty() {
        return 1.0;
    }
    let values = gram.symmetric_eigenvalues();
    let rounding = gram.nrows() as f64 * f64::EPSILON * values.max();
    if values.min() <= rounding { f64::INFINITY } else { (values.max() / values.min()).sqrt() }
}

/// A column of [`ModelColumns`] in one channel, or in all channels if it belongs to a direction.
#[derive(Clone, Copy)]
struct Unknown {
    column: usize,
    channel: Option<usize>,
}

/// Ambient and light columns, then the derivatives of the light columns by direction.
struct ModelColumns {
    /// Number of ambient and light columns.
    model: usize,
    /// Inner products of all columns.
    gram: DMatrix<f64>,
}

impl ModelColumns {
    fn new(probe: &Probe, rig: &Rig) -> Self {
        let moments = probe.moments(&rig.directions);
        let derivatives = probe.derivatives(&moments, &DMatrix::zeros(0, 0), false);
        let (model, turns) = (moments.gram.nrows(), derivatives.model.nrows());
        let mut gram = moments.gram.resize(model + turns, model + turns, 0.0);
        gram.view_mut((model, 0), (turns, model)).copy_from(&derivatives.model);
        gram.view_mut((model, model), (turns, turns)).copy_from(&derivatives.gram);
        gram.fill_upper_triangle_with_lower_triangle();
        Self { model, gram }
    }

    fn unknowns(&self, reference: &Reference, rig: &Rig, fixed: usize) -> Vec<Unknown> {
        let value = |channel: usize, column: usize| match column.checked_sub(reference.ambient.coefficients())
        {
            None => rig.ambient[column][channel],
            Some(light) => rig.irradiance[light][channel],
        };
        let is_free =
            |channel: usize, column: usize| column < reference.free() || value(channel, column) > 0.0;
        let radiances = (0..3).flat_map(|channel| {
            let free = (0..self.model).filter(move |&column| is_free(channel, column));
            free.map(move |column| Unknown { column, channel: Some(channel) })
        });
        let directions = self.model + 2 * fixed..self.gram.nrows();
        let directions = directions.map(|column| Unknown { column, channel: None });
        radiances.chain(directions).collect()
    }

    /// Inner product of two columns of the Jacobian, with a covariance `noise` between channels.
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
    use ndarray::{Array1, Array2};

    use super::*;
    use crate::kernels::fit::Ambient;
    use crate::kernels::fit::rig::irradiance;
    use crate::kernels::sampling;
    use crate::kernels::sphere::{from_vectors, tangents};

    fn probe(
        rig: &Rig,
        normals: &Array2<f64>,
        error: impl Fn(usize, usize) -> f64,
        ambient: Ambient,
    ) -> Probe {
        let mut irradiance = irradiance(rig, normals.view()).unwrap();
        irradiance.indexed_iter_mut().for_each(|((i, c), value)| *value += error(i, c));
        let weights = Array1::ones(normals.nrows());
        Probe::new(Samples::new(normals.view(), weights.view(), irradiance.view()).unwrap(), ambient)
    }

    /// Checks against the inverse of the square of an explicit Jacobian, with noise that channels share.
    #[test]
    fn the_errors_are_those_of_the_jacobian() {
        let (normals, _) = sampling::icosphere(80).unwrap();
        let rig = Rig {
            ambient: vec![DVec3::splat(0.2)],
            directions: vec![DVec3::new(1.0, 2.0, 2.0) / 3.0],
            irradiance: vec![DVec3::new(3.0, 2.0, 0.0)],
            has_floor: false,
        };
        let probe = probe(&rig, &normals, |i, c| 0.01 * ((i * 7 + c) % 5) as f64, Ambient::Constant);
        let result = uncertainty(&probe, &rig, 0);
        let [s, t] = tangents(rig.directions[0]);
        let lit = |n: DVec3, axis: DVec3| if n.dot(rig.directions[0]) > 0.0 { n.dot(axis) } else { 0.0 };
        let one_if = |is_own: bool| if is_own { 1.0 } else { 0.0 };
        // Order the unknowns: ambient RGB, red and green of the light, two tangents. Blue is held at 0.
        let entry = |n: DVec3, c: usize, column: usize| match column {
            0..3 => one_if(c == column) * PI,
            3 | 4 => one_if(c == column - 3) * lit(n, rig.directions[0]),
            _ => rig.irradiance[0][c] * lit(n, if column == 5 { s } else { t }),
        };
        let jacobian =
            DMatrix::from_fn(240, 7, |row, column| entry(probe.samples.normals[row / 3], row % 3, column));
        let residual = |i: usize| probe.samples.irradiance[i] - rig.at(probe.samples.normals[i]);
        let noise = DMatrix::from_fn(240, 240, |row, other| {
            let products = (0..80).map(|n| residual(n)[row % 3] * residual(n)[other % 3]);
            one_if(row / 3 == other / 3) * products.sum::<f64>() * 3.0 / 233.0
        });
        let inverse = jacobian.tr_mul(&jacobian).try_inverse().unwrap();
        let covariance = &inverse * jacobian.transpose() * noise * &jacobian * &inverse;
        let direction = (covariance[(5, 5)] + covariance[(6, 6)]).sqrt();
        approx::assert_relative_eq!(result.direction[0], direction, max_relative = 1e-9);
        approx::assert_relative_eq!(result.irradiance[0][1], covariance[(4, 4)].sqrt(), max_relative = 1e-9);
        assert!(result.irradiance[0][2].abs() < f64::MIN_POSITIVE);
    }

    /// Three lights along the axes, and normals that are each on the horizon of one.
    #[test]
    fn horizons_determine_the_brightness_of_a_light_but_not_its_direction() {
        let planes = |i: usize| {
            let (sin, cos) = (i as f64).sin_cos();
            [DVec3::new(0.0, sin, cos), DVec3::new(sin, 0.0, cos), DVec3::new(sin, cos, 0.0)]
        };
        let normals = from_vectors((0..12).flat_map(planes));
        let rig = Rig {
            ambient: vec![DVec3::splat(0.1); 9],
            directions: DVec3::AXES.to_vec(),
            irradiance: vec![DVec3::ONE; 3],
            has_floor: false,
        };
        let probe = probe(&rig, &normals, |_, _| 0.01, Ambient::Sh2);
        let free = uncertainty(&probe, &rig, 0);
        assert!(free.condition.is_infinite() && free.direction.iter().all(|error| error.is_infinite()));
        let held = uncertainty(&probe, &rig, 3);
        assert!(held.condition.is_finite() && held.direction == [0.0; 3], "{held:?}");
        assert!(held.irradiance.as_flattened().iter().all(|error| (0.0..1.0).contains(error)), "{held:?}");
    }
}
