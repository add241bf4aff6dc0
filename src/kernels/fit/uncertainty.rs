//! How well the probe determines the lights: standard errors, and the condition number.
//!
//! With the Jacobian J of all free unknowns - radiances channel by channel, then the two tangent
//! coordinates of every direction that moved - and the residuals r of n values,
//!
//! ```text
//!   covariance = (J^T W J)^-1 r^T W r / (n - unknowns)
//! ```
//!
//! A value held at zero is no unknown. A normal on the horizon of a light that may turn is no evidence: its
//! derivatives differ from side to side, and what is left of J is the same from both.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::Rig;
use super::moments::Moments;
use super::probe::Probe;

/// What the covariance says of a rig.
#[derive(Clone, Debug, Default)]
pub struct Uncertainty {
    /// Ratio of the greatest to the least singular value of J, its columns brought to length 1:
    /// infinite where the probe does not tell two unknowns apart.
    pub condition: f64,
    /// Standard error of each light's direction, in radians: 0 where it was held.
    pub direction: Vec<f64>,
    /// Standard error of each light's irradiance in each channel: 0 where it is held at zero.
    pub irradiance: Vec<[f64; 3]>,
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
    fn new(probe: &Probe, directions: &[DVec3]) -> Self {
        let moments = Moments::new(probe, directions);
        let derivatives = moments.derivatives(probe, 0);
        let (model, turned) = (moments.gram.nrows(), derivatives.model.nrows());
        let mut gram = moments.gram.resize(model + turned, model + turned, 0.0);
        gram.view_mut((model, 0), (turned, model)).copy_from(&derivatives.model);
        gram.view_mut((model, model), (turned, turned)).copy_from(&derivatives.gram);
        gram.fill_upper_triangle_with_lower_triangle();
        Self { model, gram }
    }
}

/// Of the lights of `rig`, of which the first `held` keep their directions.
pub fn uncertainty(probe: &Probe, rig: &Rig, held: usize) -> Uncertainty {
    /// Cosine of the angle between a light and a normal on its horizon, at most: a light that follows a
    /// crease stands within rounding of it.
    const HORIZON: f64 = 1e-9;
    let is_evidence = |normal: DVec3| rig.directions[held..].iter().all(|l| l.dot(normal).abs() > HORIZON);
    match probe.samples.only(is_evidence) {
        Some(clear) => of_evidence(&Probe::new(clear, probe.ambient), rig, held),
        None => of_evidence(probe, rig, held),
    }
}

fn of_evidence(probe: &Probe, rig: &Rig, held: usize) -> Uncertainty {
    let columns = Columns::new(probe, &rig.directions);
    let unknowns = unknowns(probe, &columns, rig, held);
    let normal = DMatrix::from_fn(unknowns.len(), unknowns.len(), |i, j| {
        inner(&columns, rig, unknowns[i], unknowns[j])
    });
    let length = normal.diagonal().map(|square| square.sqrt().max(f64::MIN_POSITIVE));
    let scaled =
        DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| normal[(i, j)] / length[i] / length[j]);
    let condition = condition(&scaled);
    let freedom = (3 * probe.samples.normals.len()).saturating_sub(unknowns.len()).max(1) as f64;
    let variance = probe.samples.cost(rig) / freedom;
    let error = match scaled.cholesky() {
        Some(factor) => factor.inverse().diagonal().map(|value| (value * variance).sqrt()),
        None => DVector::repeat(unknowns.len(), f64::INFINITY),
    };
    let mut out = Uncertainty {
        condition,
        direction: vec![0.0; rig.directions.len()],
        irradiance: vec![[0.0; 3]; rig.directions.len()],
    };
    for (i, unknown) in unknowns.iter().enumerate() {
        out.set(&columns, probe, *unknown, error[i] / length[i]);
    }
    out
}

impl Uncertainty {
    fn set(&mut self, columns: &Columns, probe: &Probe, unknown: Unknown, error: f64) {
        let Unknown { column, channel } = unknown;
        match channel {
            None => {
                let direction = &mut self.direction[(column - columns.model) / 2];
                *direction = direction.hypot(error);
            }
            Some(channel) if column >= probe.ambient.coefficients() => {
                self.irradiance[column - probe.ambient.coefficients()][channel] = error;
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

fn unknowns(probe: &Probe, columns: &Columns, rig: &Rig, held: usize) -> Vec<Unknown> {
    let is_free = move |channel: usize, column: usize| {
        column < probe.free() || value(probe, rig, channel, column) > 0.0
    };
    let radiances = (0..3).flat_map(|channel| {
        let free = (0..columns.model).filter(move |&column| is_free(channel, column));
        free.map(move |column| Unknown { column, channel: Some(channel) })
    });
    let directions = columns.model + 2 * held..columns.gram.nrows();
    let directions = directions.map(|column| Unknown { column, channel: None });
    radiances.chain(directions).collect()
}

/// The coefficient of a column of the model in one channel.
fn value(probe: &Probe, rig: &Rig, channel: usize, column: usize) -> f64 {
    match column.checked_sub(probe.ambient.coefficients()) {
        None => rig.ambient[column][channel],
        Some(light) => rig.irradiance[light][channel],
    }
}

/// Inner product of two columns of the Jacobian.
fn inner(columns: &Columns, rig: &Rig, a: Unknown, b: Unknown) -> f64 {
    let scale = |unknown: Unknown, channel: usize| match unknown.channel {
        Some(own) => f64::from(u8::from(own == channel)),
        None => rig.irradiance[(unknown.column - columns.model) / 2][channel],
    };
    let channels: f64 = (0..3).map(|channel| scale(a, channel) * scale(b, channel)).sum();
    channels * columns.gram[(a.column, b.column)]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Samples, irradiance};
    use crate::kernels::sampling;
    use glam::DVec3;

    /// Against the Jacobian itself, by differences, and the inverse of its square.
    #[test]
    fn the_errors_are_those_of_the_jacobian() {
        let (normals, _) = sampling::icosphere(80).unwrap();
        let rig = Rig {
            ambient: vec![DVec3::splat(0.2)],
            directions: vec![DVec3::new(1.0, 2.0, 2.0) / 3.0],
            irradiance: vec![DVec3::new(3.0, 2.0, 0.0)],
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
        let variance = probe.samples.cost(&rig) / 233.0;
        let covariance = jacobian.tr_mul(&jacobian).try_inverse().unwrap() * variance;
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
