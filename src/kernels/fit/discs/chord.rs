//! The mean distance between the points of two discs on the unit sphere.
//!
//! For discs (caps) of the angular radii a and b whose centres have the cosine c, with `A = sin^2(a/2)`,
//! `B = sin^2(b/2)` and p = A + B, the mean square of the distance |x - y| is closed:
//!
//! ```text
//!   Q^2 = 2 - 2 (1 - A) (1 - B) c
//! ```
//!
//! The mean itself is Q, but for what the spread of the distance takes away. Far apart that is the second term of
//! a Taylor series; near each other a number rho of the order of 1 stands in:
//!
//! ```text
//!   M = Q - p/2 (1 - Q^2/4 - rho) / Q
//! ```
//!
//! rho hardly depends on the scale. It is a table in
//!
//! ```text
//!   w = p (1 + c) / (1 - c + 2 p)    1 for one centre, 0 for opposite ones
//!   r = 4 A B / p^2                  0 for a disc and a point, 1 for two alike
//!   p                                the scale
//! ```
//!
//! and comes from the series of |x - y| = sqrt(2 - 2 c) in Legendre polynomials, whose factors are closed.

#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::sync::LazyLock;

use nalgebra::DMatrix;

use super::jet::Jet;
use super::zonal::{chord_factor, disc_factors, legendre_values};

/// Nodes along w, r and p.
const NODES: [usize; 3] = [17, 9, 16];
/// Coefficients of the splines along them: one more at either end.
const SPLINES: [usize; 3] = [NODES[0] + 2, NODES[1] + 2, NODES[2] + 2];
/// The greatest p: that of two half spheres.
const GREATEST_SCALE: f64 = 1.0;

/// The mean distance, from c, A and B; A + B must not be 0.
#[inline(always)]
pub fn mean_distance<const N: usize>(cosine: Jet<N>, share: Jet<N>, other: Jet<N>) -> Jet<N> {
    let (p, product) = (share + other, share * other);
    let square = (Jet::constant(1.0) - (Jet::constant(1.0) - p + product) * cosine) * 2.0;
    let distance = square.sqrt();
    let scale = p.recip();
    let w = p * (cosine + 1.0) * (p * 2.0 - cosine + 1.0).recip();
    let r = product * 4.0 * scale * scale;
    let rho = Jet::compose(&table([w.value, r.value, p.value]), &[w, r, p]);
    let taken = p * 0.5 * (Jet::constant(1.0) - square * 0.25 - rho);
    distance - taken * distance.recip()
}

/// rho, and its derivatives.
#[inline(always)]
fn table(at: [f64; 3]) -> Jet<3> {
    let table: &[f64] = &TABLE;
    let (mut first, mut along, mut scale) = ([0; 3], [[[0.0; 3]; 4]; 3], [0.0; 3]);
    for i in 0..3 {
        scale[i] = (NODES[i] - 1) as f64 / if i == 2 { GREATEST_SCALE } else { 1.0 };
        let knot = (at[i] * scale[i]).clamp(0.0, (NODES[i] - 1) as f64);
        first[i] = (knot as usize).min(NODES[i] - 2);
        along[i] = splines(knot - first[i] as f64);
    }
    // Along p four coefficients at once; by derivatives along w and r, up to two together.
    let mut rows = [[[0.0; 4]; 3]; 3];
    for i in 0..4 {
        let mut plane = [[0.0; 4]; 3];
        for k in 0..4 {
            let start = ((first[0] + i) * SPLINES[1] + first[1] + k) * SPLINES[2] + first[2];
            let row: &[f64; 4] = table[start..].first_chunk().unwrap_or(&[0.0; 4]); // the table reaches that far
            for n in 0..3 {
                for j in 0..4 {
                    plane[n][j] += row[j] * along[1][k][n];
                }
            }
        }
        for m in 0..3 {
            for n in 0..3 - m {
                for j in 0..4 {
                    rows[m][n][j] += plane[n][j] * along[0][i][m];
                }
            }
        }
    }
    let mut sums = [[[0.0; 3]; 3]; 3];
    for m in 0..3 {
        for n in 0..3 - m {
            for o in 0..3 - m - n {
                for j in 0..4 {
                    sums[m][n][o] += rows[m][n][j] * along[2][j][o];
                }
            }
        }
    }
    let mut out = Jet::constant(sums[0][0][0]);
    for i in 0..3 {
        let order = |axis: usize| usize::from(i == axis);
        out.first[i] = sums[order(0)][order(1)][order(2)] * scale[i];
        for k in 0..3 {
            let order = |axis: usize| usize::from(i == axis) + usize::from(k == axis);
            out.second[i][k] = sums[order(0)][order(1)][order(2)] * scale[i] * scale[k];
        }
    }
    out
}

/// The four cubic B-splines over a cell at t from 0 to 1, each with its first and second derivatives by t.
#[inline(always)]
fn splines(t: f64) -> [[f64; 3]; 4] {
    const SIXTH: f64 = 1.0 / 6.0;
    let s = 1.0 - t;
    [
        [s * s * s * SIXTH, -0.5 * s * s, s],
        [(4.0 - 3.0 * t * t * (1.0 + s)) * SIXTH, t * (1.5 * t - 2.0), t - 2.0 * s],
        [(4.0 - 3.0 * s * s * (1.0 + t)) * SIXTH, s * (2.0 - 1.5 * s), s - 2.0 * t],
        [t * t * t * SIXTH, 0.5 * t * t, t],
    ]
}

/// The coefficients of the splines through rho at the nodes.
static TABLE: LazyLock<Vec<f64>> = LazyLock::new(|| {
    /// In the limit of small discs: rho is linear there.
    const NEARLY_FLAT: f64 = 6e-3;
    let mut values = vec![0.0; NODES.iter().product()];
    let node = |i: usize, axis: usize| i as f64 / (NODES[axis] - 1) as f64;
    for k in 0..NODES[2] {
        let p = node(k, 2) * GREATEST_SCALE;
        let rho = |p: f64| -> Vec<f64> {
            let columns = (0..NODES[1]).map(|j| rho_at_nodes(node(j, 1), p)).collect::<Vec<_>>();
            (0..NODES[0] * NODES[1]).map(|i| columns[i % NODES[1]][i / NODES[1]]).collect()
        };
        let plane = if k > 0 {
            rho(p)
        } else {
            rho(NEARLY_FLAT).iter().zip(rho(2.0 * NEARLY_FLAT)).map(|(one, two)| 2.0 * one - two).collect()
        };
        plane.iter().enumerate().for_each(|(i, value)| values[i * NODES[2] + k] = *value);
    }
    let along_p = through(&values, NODES[2]);
    let along_r = through(&turned(&along_p, SPLINES[2]), NODES[1]);
    let along_w = through(&turned(&along_r, SPLINES[1]), NODES[0]);
    turned(&along_w, SPLINES[0])
});

/// rho for each node along w, from the series.
fn rho_at_nodes(r: f64, p: f64) -> Vec<f64> {
    /// Terms; the last fifth fades out, so that the sum does not ring.
    const TERMS: usize = 480;
    let half = (1.0 - r).sqrt();
    let shares = [0.5 * p * (1.0 + half), 0.5 * p * (1.0 - half)];
    let [ones, others] = shares.map(|share| disc_factors(share, TERMS));
    let terms: Vec<f64> = (0..TERMS)
        .map(|k| {
            let fade = (5.0 * (1.0 - k as f64 / TERMS as f64)).min(1.0);
            (2 * k + 1) as f64 / (4.0 * PI)
                * chord_factor(k)
                * ones[k]
                * others[k]
                * fade
                * fade
                * (3.0 - 2.0 * fade)
        })
        .collect();
    let at = |i: usize| {
        let w = i as f64 / (NODES[0] - 1) as f64;
        let c = ((w * (1.0 + 2.0 * p) - p) / (p + w)).clamp(-1.0, 1.0);
        let mean: f64 = terms.iter().zip(legendre_values(c, TERMS)).map(|(term, value)| term * value).sum();
        let square = 2.0 - 2.0 * (1.0 - shares[0]) * (1.0 - shares[1]) * c;
        let distance = square.sqrt();
        (mean - distance) * 2.0 / p * distance + 1.0 - 0.25 * square
    };
    (0..NODES[0]).map(at).collect()
}

/// The coefficients of the splines through each row of that many values. At either end the first two cells have
/// one polynomial.
fn through(values: &[f64], count: usize) -> Vec<f64> {
    let size = count + 2;
    let mut matrix = DMatrix::zeros(size, size);
    for i in 0..count {
        [1.0, 4.0, 1.0].iter().enumerate().for_each(|(k, weight)| matrix[(i, i + k)] = weight / 6.0);
    }
    for (k, weight) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
        matrix[(count, k)] = weight;
        matrix[(count + 1, size - 1 - k)] = weight;
    }
    let rows = values.len() / count;
    let rhs = DMatrix::from_fn(size, rows, |i, row| if i < count { values[row * count + i] } else { 0.0 });
    matrix.lu().solve(&rhs).map_or_else(Vec::new, |solved| solved.as_slice().to_vec())
}

/// With the last axis, of that many values, in front.
fn turned(values: &[f64], count: usize) -> Vec<f64> {
    let rows = values.len() / count;
    (0..values.len()).map(|i| values[i % rows * count + i / rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::sphere::direction;
    use glam::DVec3;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    fn share(radius: f64) -> f64 {
        (0.5 * radius).sin().powi(2)
    }

    /// Points on rings of equal area around the pole, and the same around a place at the angle `tilt` from it.
    fn points(radius: f64, rings: usize, tilt: f64, turn: f64) -> Vec<DVec3> {
        let count = 2 * rings;
        let point = |i: usize| {
            let ring = (i / count) as f64 + 0.5;
            let theta = 2.0 * (share(radius) * ring / rings as f64).sqrt().asin();
            let point = direction(theta, TAU * (i % count) as f64 / count as f64 + turn);
            let (sin, cos) = tilt.sin_cos();
            DVec3::new(point.x, point.y * cos - point.z * sin, point.y * sin + point.z * cos)
        };
        (0..rings * count).map(point).collect()
    }

    #[test]
    fn the_mean_distance_is_the_mean_of_all_distances() {
        for (a, b, angle) in [
            (0.01, 0.004, 0.008),
            (0.3, 0.3, 0.0),
            (0.5, 0.05, 0.5),
            (1.2, 0.7, 1.0),
            (0.2, 0.1, 3.0),
            (1.3, 1.2, 3.1),
            (0.7, 1e-4, 0.2),
        ] {
            let (ones, others) = (points(a, 24, 0.0, 0.0), points(b, 23, angle, 0.3));
            let sum: f64 = ones.iter().map(|x| others.iter().map(|y| (*x - *y).length()).sum::<f64>()).sum();
            let wanted = sum / (ones.len() * others.len()) as f64;
            let [c, a, b] = [angle.cos(), share(a), share(b)].map(Jet::<0>::constant);
            let seen = mean_distance(c, a, b).value;
            assert!((seen / wanted - 1.0).abs() < 2e-3, "{angle}: {seen} {wanted}");
        }
    }

    proptest! {
        /// Of the table and all that is around it, first and second ones.
        #[test]
        fn derivatives_are_the_slopes_that_are_measured(
            c in -0.99..0.999_f64,
            a in 1e-3..0.37_f64,
            b in 1e-3..0.37_f64,
        ) {
            let at = |x: [f64; 3]| {
                let [c, a, b] = [0, 1, 2].map(|i| Jet::<3>::variable(x[i], i));
                mean_distance(c, a, b)
            };
            let x = [c, a, b];
            let here = at(x);
            for i in 0..3 {
                let step = 1e-5 * if i == 0 { 1.0 - c } else { x[i] };
                let [ahead, behind] = [step, -step].map(|step| {
                    let mut x = x;
                    x[i] += step;
                    at(x)
                });
                let slope = (ahead.value - behind.value) / (2.0 * step);
                prop_assert!((slope - here.first[i]).abs() < 1e-5 * (1.0 + slope.abs()), "{i}: {slope} {here:?}");
                for k in 0..3 {
                    let bend = (ahead.first[k] - behind.first[k]) / (2.0 * step);
                    let scale = here.second[i][i].abs().max(here.second[k][k].abs()).max(1.0);
                    // The third derivative of a spline jumps.
                    prop_assert!((bend - here.second[i][k]).abs() < 1e-3 * scale, "{i} {k}: {bend} {here:?}");
                }
            }
        }
    }
}
