//! The mean distance between the points of two discs on the unit sphere.
//!
//! For discs (caps) of the angular radii a and b whose centres have the cosine c, with `A = sin^2(a/2)`,
//! `B = sin^2(b/2)` and p = A + B, the mean square of the distance |x - y| is closed:
//!
//! ```text
//!   Q^2 = 2 - 2 (1 - A) (1 - B) c
//! ```
//!
//! The mean itself is Q less a term for the spread of the distance. For discs far apart, this is the second term of a
//! Taylor series; for near ones, it has a correction rho of the order of 1:
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
//! and comes from the series of |x - y| = sqrt(2 - 2 c) in Legendre polynomials, whose factors are closed. For most
//! discs, which are far apart for their sizes, `far.rs` replaces the table.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]
#![allow(clippy::needless_range_loop, reason = "loops, not closures, are inlined")]

use std::f64::consts::PI;
use std::sync::LazyLock;

use nalgebra::DMatrix;

use super::far::{are_far, far, far_orders};
use super::zonal::chord_factor;
use crate::kernels::expansion::{disc_series, legendre_values};
use crate::kernels::fit::jet::Jet;
use crate::kernels::lanes::{LANES, Number};

/// Nodes along w, r and p.
const NODES: [usize; 3] = [17, 9, 16];
/// Coefficients of the splines along them: one more at either end.
const SPLINES: [usize; 3] = [NODES[0] + 2, NODES[1] + 2, NODES[2] + 2];
/// The greatest p: that of two half spheres.
const GREATEST_SCALE: f64 = 1.0;

/// The mean distance, from c, A and B; A + B must not be 0.
#[inline(always)]
pub fn mean_distance<const N: usize, T: Number>(
    cosine: Jet<N, T>,
    share: Jet<N, T>,
    other: Jet<N, T>,
) -> Jet<N, T> {
    let (p, product) = (share + other, share * other);
    let square = (cosine * (p - product) - cosine + 1.0) * 2.0;
    let distance = square.sqrt();
    let scale = p.recip();
    let w = p * (cosine + 1.0) * (p * 2.0 - cosine + 1.0).recip();
    let r = product * 4.0 * scale * scale;
    let at = [w.value, r.value, p.value];
    let rho = if (0..T::COUNT).all(|lane| are_far(at.map(|number| number.lane(lane)))) {
        far([w, r, p])
    } else {
        let outer = if N > 0 { table::<3, T>(at) } else { table::<1, T>(at) };
        Jet::compose(&outer, &[w, r, p])
    };
    let taken = p * (square * 0.25 + rho + -1.0) * 0.5;
    distance + taken * distance.recip()
}

/// rho; with three orders, its derivatives as well.
#[inline(always)]
fn table<const ORDERS: usize, T: Number>(at: [T; 3]) -> Jet<3, T> {
    let one = at[0].like(1.0);
    let mut sums = [[[[0.0; LANES]; ORDERS]; ORDERS]; ORDERS];
    for lane in 0..T::COUNT {
        let at = at.map(|number| number.lane(lane));
        // Each number is what it would be alone.
        let cell = if are_far(at) { far_orders(at) } else { cell::<ORDERS, T>(one, at) };
        for m in 0..ORDERS {
            for n in 0..ORDERS - m {
                for o in 0..ORDERS - m - n {
                    sums[m][n][o][lane] = cell[m][n][o];
                }
            }
        }
    }
    let mut out = Jet::constant(one.like_all(&sums[0][0][0]));
    if ORDERS < 3 {
        return out;
    }
    for i in 0..3 {
        let order = |axis: usize| usize::from(i == axis);
        out.first[i] = one.like_all(&sums[order(0)][order(1)][order(2)]);
        for k in 0..=i {
            let order = |axis: usize| usize::from(i == axis) + usize::from(k == axis);
            let second = one.like_all(&sums[order(0)][order(1)][order(2)]);
            (out.second[i][k], out.second[k][i]) = (second, second);
        }
    }
    out
}

/// Sums over a cell of the table by their derivatives along w, r and p, up to two together. Vectors are like `one`, and
/// hold coefficients along p.
#[inline(always)]
fn cell<const ORDERS: usize, T: Number>(one: T, at: [f64; 3]) -> [[[f64; ORDERS]; ORDERS]; ORDERS] {
    let (table, zero, parts): (&[f64], T, usize) = (&TABLE, one.like(0.0), 4_usize.div_ceil(T::COUNT));
    let (mut first, mut along) = ([0; 3], [[[zero; 4]; ORDERS]; 3]);
    for i in 0..3 {
        let scale = (NODES[i] - 1) as f64 / if i == 2 { GREATEST_SCALE } else { 1.0 };
        let knot = (at[i] * scale).clamp(0.0, (NODES[i] - 1) as f64);
        first[i] = (knot as usize).min(NODES[i] - 2);
        along[i] = splines(one.like(knot - first[i] as f64), scale);
    }
    let weight =
        |axis: usize, order: usize, k: usize| one.like(along[axis][order][k / T::COUNT].lane(k % T::COUNT));
    let mut rows = [[[zero; 4]; ORDERS]; ORDERS];
    for i in 0..4 {
        let mut plane = [[zero; 4]; ORDERS];
        for k in 0..4 {
            let start = ((first[0] + i) * SPLINES[1] + first[1] + k) * SPLINES[2] + first[2];
            let row = parts_of(one, &table[start..]);
            for n in 0..ORDERS {
                let weight = weight(1, n, k);
                for j in 0..parts {
                    plane[n][j] = plane[n][j].add_product(row[j], weight);
                }
            }
        }
        for m in 0..ORDERS {
            let weight = weight(0, m, i);
            for n in 0..ORDERS - m {
                for j in 0..parts {
                    rows[m][n][j] = rows[m][n][j].add_product(plane[n][j], weight);
                }
            }
        }
    }
    let mut sums = [[[0.0; ORDERS]; ORDERS]; ORDERS];
    for m in 0..ORDERS {
        for n in 0..ORDERS - m {
            for o in 0..ORDERS - m - n {
                let mut sum = zero;
                for j in 0..parts {
                    sum = sum.add_product(rows[m][n][j], along[2][o][j]);
                }
                sums[m][n][o] = sum.sum();
            }
        }
    }
    sums
}

/// The first four of `values` in vectors like `one`, and whatever comes with them.
#[inline(always)]
fn parts_of<T: Number>(one: T, values: &[f64]) -> [T; 4] {
    let mut parts = [one; 4];
    for j in 0..4_usize.div_ceil(T::COUNT) {
        parts[j] = one.like_all(&values[j * T::COUNT..]);
    }
    parts
}

/// The four cubic B-splines over a cell at t from 0 to 1; each order is a derivative by `scale` t.
#[inline(always)]
fn splines<const ORDERS: usize, T: Number>(t: T, scale: f64) -> [[T; 4]; ORDERS] {
    /// By powers of t. No vector is longer.
    const COEFFICIENTS: [[f64; LANES]; 4] = [
        [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0],
        [-0.5, 0.0, 0.5, 0.0],
        [0.5, -1.0, 0.5, 0.0],
        [-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0],
    ];
    let mut out = [[t; 4]; ORDERS];
    for order in 0..ORDERS {
        // Horner's scheme.
        let mut sum = [t.like(0.0); 4];
        for power in (order..4).rev() {
            let factor =
                [1.0, power as f64 * scale, (power * power.saturating_sub(1)) as f64 * scale * scale][order];
            let coefficients = parts_of(t, &COEFFICIENTS[power]);
            for j in 0..4_usize.div_ceil(T::COUNT) {
                sum[j] = (coefficients[j] * t.like(factor)).add_product(sum[j], t);
            }
        }
        out[order] = sum;
    }
    out
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
    let along_r = through(&last_axis_first(&along_p, SPLINES[2]), NODES[1]);
    let along_w = through(&last_axis_first(&along_r, SPLINES[1]), NODES[0]);
    let mut table = last_axis_first(&along_w, SPLINES[0]);
    // A vector may be longer than what is taken from the end.
    table.extend([0.0; LANES]);
    table
});

/// rho for each node along w, from the series.
fn rho_at_nodes(r: f64, p: f64) -> Vec<f64> {
    /// Terms; the last fifth fades out, so that the sum does not ring.
    const TERMS: usize = 480;
    let half = (1.0 - r).sqrt();
    let shares = [0.5 * p * (1.0 + half), 0.5 * p * (1.0 - half)];
    let [ones, others] = shares.map(|share| disc_series(share, TERMS));
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

/// The values with their last axis, of length `count`, in front.
fn last_axis_first(values: &[f64], count: usize) -> Vec<f64> {
    let rows = values.len() / count;
    (0..values.len()).map(|i| values[i % rows * count + i / rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::lanes::Lanes;
    use crate::kernels::sphere::direction;
    use glam::DVec3;
    use proptest::prelude::*;
    use pulp::{Arch, Simd, WithSimd};
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

    /// Value, alone, and a sum of derivatives.
    struct SideBySide {
        c: [f64; LANES],
        a: [f64; LANES],
        b: [f64; LANES],
    }

    impl WithSimd for SideBySide {
        type Output = Vec<[f64; 2]>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut out = Vec::new();
            for vector in 0..Lanes::<S>::VECTORS {
                let [c, a, b] = [&self.c, &self.a, &self.b].map(|values| Lanes::at(simd, values, vector));
                let value = mean_distance::<0, _>(Jet::constant(c), Jet::constant(a), Jet::constant(b)).value;
                let [c, a, b] = [(c, 0), (a, 1), (b, 2)].map(|(x, k)| Jet::<3, _>::variable(x, k));
                let Jet { first, second, .. } = mean_distance(c, a, b);
                let sum = first[0] + first[1] + first[2] + second[1][2];
                out.extend((0..S::F64_LANES).map(|lane| [value.lane(lane), sum.lane(lane)]));
            }
            out
        }
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
        /// Vectors hold what single numbers do.
        #[test]
        fn side_by_side_is_one_by_one(
            c in prop::array::uniform4(-1.0..1.0_f64),
            a in prop::array::uniform4(1e-9..0.37_f64),
            b in prop::array::uniform4(1e-9..0.37_f64),
        ) {
            let side_by_side = Arch::new().dispatch(SideBySide { c, a, b });
            for i in 0..LANES {
                let [c, a, b] = [(c[i], 0), (a[i], 1), (b[i], 2)].map(|(x, k)| Jet::<3>::variable(x, k));
                let one = mean_distance(c, a, b);
                let scale = one.second.as_flattened().iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                let [value, numbers] = side_by_side[i];
                prop_assert!((value - one.value).abs() < 1e-12);
                prop_assert!((numbers - one.first.iter().sum::<f64>() - one.second[1][2]).abs() < 1e-9 * scale);
            }
        }

        /// First and second derivatives of the table and its terms, against differences.
        #[test]
        fn derivatives_are_the_slopes_that_are_measured(
            c in -0.99..0.999_f64,
            a in prop_oneof![1e-3..0.37_f64, 1e-4..5e-3_f64],
            b in prop_oneof![1e-3..0.37_f64, 1e-4..5e-3_f64],
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
