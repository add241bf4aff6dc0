//! The environment beside the lights: none, one radiance, or nine spherical harmonics of it.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

use crate::error::{Error, Result};
use crate::kernels::harmonics::{self, LINEAR, SQUARE, ZONAL};

/// Ambient term beside the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ambient {
    /// Lights alone.
    None,
    /// One radiance from all directions.
    Constant,
    /// Real spherical harmonics of the radiance up to order 2.
    Sh2,
}

impl Ambient {
    /// Number of coefficients in each channel.
    pub fn coefficients(self) -> usize {
        match self {
            Self::None => 0,
            Self::Constant => 1,
            Self::Sh2 => 9,
        }
    }

    /// The ambient term with this number of coefficients in each channel, if there is one.
    pub fn with(coefficients: usize) -> Option<Self> {
        [Self::None, Self::Constant, Self::Sh2]
            .into_iter()
            .find(|ambient| ambient.coefficients() == coefficients)
    }

    /// The ambient term with this number of coefficients in each channel.
    ///
    /// # Errors
    ///
    /// [`Error::NotAmbient`] if there is none.
    pub fn of(coefficients: usize) -> Result<Self> {
        Self::with(coefficients).ok_or(Error::NotAmbient { seen: coefficients })
    }

    /// Irradiance at `normal` under each coefficient alone; the values beyond [`Self::coefficients`] are unused.
    pub fn irradiance(self, normal: DVec3) -> [f64; 9] {
        if self != Self::Sh2 {
            return [PI, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        }
        harmonics::irradiance(normal)
    }
}

/// The normal at which the nine `coefficients` give least irradiance, and that irradiance.
///
/// The irradiance is `k + 2 b.n + n^T Q n`. At its minimum on the sphere, with a multiplier m no greater than the
/// least eigenvalue of Q (Moré and Sorensen 1983),
///
/// ```text
///   (Q - m) n = -b        |n| = 1
/// ```
pub fn darkest(coefficients: &[f64]) -> (DVec3, f64) {
    let c = |i: usize, scale: f64| coefficients[i] * scale;
    let b = Vector3::new(c(3, LINEAR), c(1, LINEAR), c(2, LINEAR)) / 2.0;
    let (xy, yz, xz) = (c(4, SQUARE / 2.0), c(5, SQUARE / 2.0), c(7, SQUARE / 2.0));
    let (xx, zz) = (c(8, SQUARE / 2.0), c(6, 3.0 * ZONAL));
    let eigen = Matrix3::new(xx, xy, xz, xy, -xx, yz, xz, yz, zz).symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&b);
    let n = eigen.eigenvectors * Vector3::from(least_on_sphere(eigen.eigenvalues.into(), along.into()));
    let normal = DVec3::new(n.x, n.y, n.z).normalize();
    let columns = Ambient::Sh2.irradiance(normal);
    (normal, coefficients.iter().zip(columns).map(|(c, column)| c * column).sum())
}

/// The unit vector n at which `sum_i q_i n_i^2 + 2 b_i n_i` is least.
fn least_on_sphere(q: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    /// Steps of bisection that reach the last digit, if every Newton step fails.
    const STEPS: usize = 60;
    let first = (0..3).min_by(|&i, &j| q[i].total_cmp(&q[j])).unwrap_or(0);
    let length = |b: [f64; 3]| b.iter().map(|b| b * b).sum::<f64>().sqrt();
    // |n(m)| grows with m, from at most 1 at the low end to at least 1 at the high end. Apply Newton's method to
    // 1 / |n(m)|, which is almost a straight line.
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
    // Make n a unit vector by its part along the least eigenvector, which b does not determine if it has none there.
    let square = 1.0 - length(n).powi(2) + n[first] * n[first];
    n[first] = square.max(0.0).sqrt().copysign(-b[first]);
    n
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::kernels::sampling::icosphere;
    use crate::kernels::sphere::{exponential_map, tangents};

    proptest! {
        /// Some coefficients are 0, so that b may have no part along an eigenvector.
        #[test]
        fn nowhere_is_darker_than_the_darkest(
            coefficients in proptest::array::uniform9(-1.0..1.0_f64),
            is_used in proptest::array::uniform9(proptest::bool::ANY),
        ) {
            let used = coefficients.iter().zip(is_used).map(|(c, is_used)| if is_used { *c } else { 0.0 });
            let coefficients: Vec<f64> = used.collect();
            let value = |normal: DVec3| -> f64 {
                let columns = Ambient::Sh2.irradiance(normal);
                coefficients.iter().zip(columns).map(|(c, column)| c * column).sum()
            };
            let (normal, least) = darkest(&coefficients);
            prop_assert!((normal.length() - 1.0).abs() < 1e-12 && (value(normal) - least).abs() < 1e-12);
            let (normals, _) = icosphere(20480).expect("a number that exists");
            let sampled = normals.rows().into_iter().map(|n| value(DVec3::new(n[0], n[1], n[2])));
            let sampled = sampled.fold(f64::INFINITY, f64::min);
            prop_assert!(least <= sampled + 1e-9 && sampled < least + 0.01, "{least} {sampled}");
            let [s, t] = tangents(normal);
            for step in [s, -s, t, -t] {
                let near = value(exponential_map(normal, step * 1e-3));
                prop_assert!(least <= near + 1e-12, "{least} {near}");
            }
        }
    }
}
