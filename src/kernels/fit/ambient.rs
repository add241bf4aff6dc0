//! The environment beside the lights: none, one radiance, or nine spherical harmonics of it.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Vector3};

use crate::error::{Error, Result};
use crate::kernels::harmonics::{self, LINEAR, SQUARE, ZONAL};

/// What a fit may use beside the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ambient {
    /// Lights alone.
    None,
    /// The same radiance from everywhere.
    Constant,
    /// Real spherical harmonics of the radiance up to order 2.
    Sh2,
}

impl Ambient {
    /// Number of its coefficients in each channel.
    pub fn coefficients(self) -> usize {
        match self {
            Self::None => 0,
            Self::Constant => 1,
            Self::Sh2 => 9,
        }
    }

    /// The one with so many coefficients in each channel, if there is one.
    pub fn with(coefficients: usize) -> Option<Self> {
        [Self::None, Self::Constant, Self::Sh2]
            .into_iter()
            .find(|ambient| ambient.coefficients() == coefficients)
    }

    /// The one with that many coefficients in each channel.
    ///
    /// # Errors
    ///
    /// [`Error::NotAmbient`] where there is none.
    pub fn of(coefficients: usize) -> Result<Self> {
        Self::with(coefficients).ok_or(Error::NotAmbient { seen: coefficients })
    }

    /// Irradiance at `normal` of each coefficient alone; the first [`Self::coefficients`] count.
    pub fn irradiance(self, normal: DVec3) -> [f64; 9] {
        if self != Self::Sh2 {
            return [PI, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        harmonics::irradiance(normal)
    }
}

/// The normal at which the nine `coefficients` give least irradiance, and that irradiance.
///
/// The irradiance is `k + 2 b.n + n^T Q n`. Where it is least on the sphere, with a multiplier m no
/// greater than the least eigenvalue of Q (Moré and Sorensen 1983),
///
/// ```text
///   (Q - m) n = -b        |n| = 1
/// ```
pub fn darkest(coefficients: &[f64]) -> (DVec3, f64) {
    let (q, b) = quadratic(coefficients);
    let normal = least_by_inverses(q, b).unwrap_or_else(|| least_by_eigenvectors(q, b));
    let columns = Ambient::Sh2.irradiance(normal);
    (normal, coefficients.iter().zip(columns).map(|(c, column)| c * column).sum())
}

/// Q and b.
fn quadratic(coefficients: &[f64]) -> (DMat3, DVec3) {
    let c = |i: usize, scale: f64| coefficients[i] * scale;
    let b = DVec3::new(c(3, LINEAR), c(1, LINEAR), c(2, LINEAR)) / 2.0;
    let (xy, yz, xz) = (c(4, SQUARE / 2.0), c(5, SQUARE / 2.0), c(7, SQUARE / 2.0));
    let (xx, zz) = (c(8, SQUARE / 2.0), c(6, 3.0 * ZONAL));
    (DMat3::from_cols_array(&[xx, xy, xz, xy, -xx, yz, xz, yz, zz]), b)
}

/// The unit vector n at which `n^T Q n + 2 b.n` is least; none where Newton's steps from below do not lead to it, as
/// where b has next to no part along the least eigenvector.
///
/// With m, as above, 1 / |n(m)| is almost a straight line in m, so that a few steps arrive.
fn least_by_inverses(q: DMat3, b: DVec3) -> Option<DVec3> {
    const STEPS: usize = 12;
    /// Determinant, as a share of the cube of the size, below which an inverse has lost digits.
    const SINGULAR: f64 = 1e-6;
    let size = [q.x_axis, q.y_axis, q.z_axis].map(|axis| axis.abs().element_sum());
    let size = size.into_iter().fold(0.0, f64::max) + b.length();
    let (mut low, mut m) = (-size, -size);
    for _ in 0..STEPS {
        let shifted = q - DMat3::from_diagonal(DVec3::splat(m));
        let (adjugate, determinant) = adjugate(shifted);
        let has_positive_minors = shifted.x_axis.x > 0.0 && adjugate.z_axis.z > 0.0;
        let is_definite = has_positive_minors && determinant > SINGULAR * size.powi(3);
        if !is_definite {
            m = 0.5 * (low + m);
            continue;
        }
        low = m;
        let n = adjugate * -b / determinant;
        let length = n.length();
        if (1.0 - length).abs() < 1e-14 {
            return Some(n / length);
        }
        let slope = n.dot(adjugate * n) / determinant;
        m += length * length * (1.0 - length) / slope;
    }
    None
}

/// The inverse of a symmetric matrix times its determinant, and that.
fn adjugate(DMat3 { x_axis, y_axis, z_axis }: DMat3) -> (DMat3, f64) {
    let adjugate = DMat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis));
    (adjugate, x_axis.dot(adjugate.x_axis))
}

/// The least n as in [`least_by_inverses`], for any b: along the eigenvectors of Q.
fn least_by_eigenvectors(q: DMat3, b: DVec3) -> DVec3 {
    let eigen = Matrix3::from(q.to_cols_array_2d()).symmetric_eigen();
    let (vectors, values) = (eigen.eigenvectors, eigen.eigenvalues.into());
    let along: [f64; 3] = (vectors.transpose() * Vector3::new(b.x, b.y, b.z)).into();
    let normal = vectors * Vector3::from(least_on_sphere(values, along));
    DVec3::new(normal.x, normal.y, normal.z).normalize()
}

/// The unit vector n at which `sum_i q_i n_i^2 + 2 b_i n_i` is least.
fn least_on_sphere(q: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    /// Where Newton's steps lead astray, halving alone is done with as many.
    const STEPS: usize = 60;
    let first = (0..3).min_by(|&i, &j| q[i].total_cmp(&q[j])).unwrap_or(0);
    let length = |b: [f64; 3]| b.iter().map(|b| b * b).sum::<f64>().sqrt();
    // |n(m)| grows with m, from at most 1 at the low end to at least 1 at the high end; 1 / |n(m)| is almost
    // a straight line, on which Newton's steps arrive soon.
    let (mut low, mut high) = (q[first] - length(b), q[first] - b[first].abs());
    let at = |m: f64| [0, 1, 2].map(|i| if b[i] == 0.0 { 0.0 } else { -b[i] / (q[i] - m) });
    let (mut m, mut n) = (low, at(low));
    for _ in 0..STEPS {
        n = at(m);
        let size = length(n);
        if size < 1.0 {
            low = m;
        } else {
            high = m;
        }
        let slope: f64 = (0..3).filter(|&i| b[i] != 0.0).map(|i| n[i] * n[i] / (q[i] - m)).sum();
        let newton = m + size * size * (1.0 - size) / slope;
        m = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if m <= low || m >= high || (1.0 - size).abs() < 1e-15 {
            break;
        }
    }
    // Where b has no part along the least eigenvector, that part of n closes the gap.
    let rest = 1.0 - length(n).powi(2) + n[first] * n[first];
    n[first] = rest.max(0.0).sqrt().copysign(-b[first]);
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn nowhere_is_darker_than_the_darkest(
            coefficients in proptest::array::uniform9(-1.0..1.0_f64),
            kept in proptest::array::uniform9(proptest::bool::ANY),
        ) {
            let coefficients: Vec<f64> = coefficients.iter().zip(kept).map(|(c, k)| if k { *c } else { 0.0 }).collect();
            let (normal, least) = darkest(&coefficients);
            prop_assert!((normal.length() - 1.0).abs() < 1e-12);
            let (normals, _) = crate::kernels::sampling::icosphere(20480).expect("a number that exists");
            let seen = normals.rows().into_iter().map(|n| {
                let columns = Ambient::Sh2.irradiance(DVec3::new(n[0], n[1], n[2]));
                coefficients.iter().zip(columns).map(|(c, column)| c * column).sum::<f64>()
            }).fold(f64::INFINITY, f64::min);
            prop_assert!(least <= seen + 1e-9 && seen < least + 0.01, "{least} {seen}");
            // Both ways lead there.
            let (q, b) = quadratic(&coefficients);
            let value = |n: DVec3| n.dot(q * n) + 2.0 * b.dot(n);
            let ways = [least_by_inverses(q, b), Some(least_by_eigenvectors(q, b))].into_iter().flatten();
            for other in ways {
                prop_assert!((value(other) - value(normal)).abs() < 1e-12, "{other} {normal}");
            }
            // Nor is it close by, in any direction.
            let [s, t] = crate::kernels::sphere::tangents(normal);
            for step in [s, -s, t, -t] {
                let columns = Ambient::Sh2.irradiance(crate::kernels::sphere::exponential_map(normal, step * 1e-3));
                let near = coefficients.iter().zip(columns).map(|(c, column)| c * column).sum::<f64>();
                prop_assert!(least <= near + 1e-12, "{least} {near}");
            }
        }
    }
}
