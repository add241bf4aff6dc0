//! The environment beside the lights: none, one radiance, or nine spherical harmonics of it.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

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

    /// The ambient term with this number of coefficients in each channel.
    ///
    /// # Errors
    ///
    /// [`Error::NotAmbient`] if there is none.
    pub fn of(coefficients: usize) -> Result<Self> {
        let mut all = [Self::None, Self::Constant, Self::Sh2].into_iter();
        let ambient = all.find(|ambient| ambient.coefficients() == coefficients);
        ambient.ok_or(Error::NotAmbient { seen: coefficients })
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
    let (xy, yz, xz) = (c(4, SQUARE / 2.0), c(5, SQUARE / 2.0), c(7, SQUARE / 2.0));
    let (xx, zz) = (c(8, SQUARE / 2.0), c(6, 3.0 * ZONAL));
    let q = DMat3::from_cols_array(&[xx, xy, xz, xy, -xx, yz, xz, yz, zz]);
    let b = DVec3::new(c(3, LINEAR), c(1, LINEAR), c(2, LINEAR)) / 2.0;
    let normal = least_on_sphere(q, b).normalize_or(DVec3::Z);
    let columns = Ambient::Sh2.irradiance(normal);
    (normal, coefficients.iter().zip(columns).map(|(c, column)| c * column).sum())
}

/// The vector n of about unit length at which `n^T Q n + 2 b.n` is least.
///
/// |n(m)| grows with m, up to infinity at the least eigenvalue of Q, and 1 / |n(m)| is almost a straight line.
fn least_on_sphere(q: DMat3, b: DVec3) -> DVec3 {
    const STEPS: usize = 60;
    /// Difference of |n| from 1; the normalized n is wrong by no more, and its irradiance by the square.
    const TOLERANCE: f64 = 1e-9;
    let size =
        |b: DVec3| q.to_cols_array().into_iter().fold(0.0, |sum, entry| sum + entry.abs()) + b.length();
    // Give b a part along every eigenvector, without which |n(m)| does not reach 1.
    let b = b + DVec3::new(0.6, 0.5, -0.62) * (1e-8 * size(b));
    let (mut low, mut high, mut n) = (-size(b), size(b), DVec3::ZERO);
    let mut m = low;
    for _ in 0..STEPS {
        let mut next = high;
        if let Some(factors) = Factors3::new(q, m) {
            n = factors.solve(-b);
            let length = n.length();
            if (1.0 - length).abs() < TOLERANCE {
                break;
            }
            *(if length < 1.0 { &mut low } else { &mut high }) = m;
            next = m + length * length * (1.0 - length) / factors.inverse_square(n);
        } else {
            high = m;
        }
        // Bisect if Newton's method leaves the interval.
        m = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    n
}

/// Factors `L D L^T` of a symmetric positive definite matrix of 3 rows.
struct Factors3 {
    /// L below its diagonal: rows 1 and 2 of column 0, and row 2 of column 1.
    lower: [f64; 3],
    pivots: DVec3,
}

impl Factors3 {
    /// Factor Q - m; `None` if it is not positive definite.
    fn new(q: DMat3, m: f64) -> Option<Self> {
        let (first, second) = (q.x_axis, q.y_axis);
        let own = first.x - m;
        let (by_one, by_two) = (first.y / own, first.z / own);
        let next = second.y - m - by_one * first.y;
        let below = second.z - by_two * first.y;
        let pivots = DVec3::new(own, next, q.z_axis.z - m - by_two * first.z - below * below / next);
        (pivots.min_element() > 0.0).then_some(Self { lower: [by_one, by_two, below / next], pivots })
    }

    /// `L^-1 v`
    fn forward(&self, v: DVec3) -> DVec3 {
        let y = v.y - self.lower[0] * v.x;
        DVec3::new(v.x, y, v.z - self.lower[1] * v.x - self.lower[2] * y)
    }

    /// `(L D L^T)^-1 v`
    fn solve(&self, v: DVec3) -> DVec3 {
        let v = self.forward(v) / self.pivots;
        let y = v.y - self.lower[2] * v.z;
        DVec3::new(v.x - self.lower[0] * y - self.lower[1] * v.z, y, v.z)
    }

    /// `v^T (L D L^T)^-1 v`
    fn inverse_square(&self, v: DVec3) -> f64 {
        let v = self.forward(v);
        v.dot(v / self.pivots)
    }
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
