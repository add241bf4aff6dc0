//! A table of a smooth even function on the sphere, with derivatives.
//!
//! Three faces of the cube around the sphere determine an even function of degree 1:
//!
//! ```text
//!   F(x, y, z) = |x| f(y / x, z / x)        likewise around y and z
//! ```
//!
//! Here f is a bicubic B-spline over -1 .. 1, which is twice differentiable and needs no angles. Its coefficients are
//! linear in the spherical harmonics of F, by a matrix that is computed once.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use crate::kernels::expansion::{AssociatedLegendre, Harmonics};
use crate::kernels::sphere::angles;

/// Highest degree of the table. The kernel falls off as `degree^-5`, so the cells of the working map limit the error.
pub const HIGHEST: usize = 32;

/// Axes whose mirroring changes the sign of each kind of harmonics of even degree.
///
/// The kinds are cosines of even and odd order, then sines of even and odd order.
const KINDS: [[bool; 3]; 4] =
    [[false, false, false], [false, true, true], [true, false, true], [true, true, false]];

/// Cells from the middle of a face to its edge. Ten keep the error at a tenth of that of the working map's cells; twice as
/// many lower it sixteen times.
const HALF: usize = 10;
/// Coefficients from the middle of a face to one cell beyond its edge.
const KNOTS: usize = HALF + 2;
/// Coefficients along a face.
const SIDE: usize = 2 * KNOTS - 1;
/// The axes of a face after its own.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// Coefficients of the three faces, with a fourth channel that fills wide vectors.
#[derive(Clone, Debug)]
pub struct Field {
    faces: Vec<[f64; 4]>,
    /// Cosine and sine of the azimuth of the cube.
    turn: [f64; 2],
}

impl Field {
    /// Tabulate the even degrees of a function in harmonics, on a cube at an `azimuth`.
    ///
    /// If the azimuth turns with the function, so does the error of the table.
    pub fn new(harmonics: &Harmonics, azimuth: f64) -> Self {
        let harmonics = coefficients_by_kind(&harmonics.rotate(azimuth));
        let mut faces = vec![[0.0; 4]; 3 * SIDE * SIDE];
        for (kind, (matrix, harmonics)) in SPLINES.iter().zip(&harmonics).enumerate() {
            let quarter = matrix * harmonics;
            for (i, value) in quarter.row_iter().enumerate() {
                let (face, u, v) = (i / (KNOTS * KNOTS), i / KNOTS % KNOTS, i % KNOTS);
                let [flips_u, flips_v] = OTHERS[face].map(|axis| KINDS[kind][axis]);
                for (u, sign_u) in both_sides(u, flips_u) {
                    for (v, sign_v) in both_sides(v, flips_v) {
                        let coefficients = &mut faces[(face * SIDE + u) * SIDE + v];
                        (0..3).for_each(|c| coefficients[c] += sign_u * sign_v * value[c]);
                    }
                }
            }
        }
        Self { faces, turn: [azimuth.cos(), azimuth.sin()] }
    }

    /// A direction in the frame of the cube.
    #[inline(always)]
    fn inward(&self, l: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(l.x * cos + l.z * sin, l.y, l.z * cos - l.x * sin)
    }

    /// A vector in the frame of the map.
    #[inline(always)]
    pub fn outward(&self, v: DVec3) -> DVec3 {
        let [cos, sin] = self.turn;
        DVec3::new(v.x * cos - v.z * sin, v.y, v.z * cos + v.x * sin)
    }

    /// Gradients at the unit vector `l`, by channel; the value is `l.gradient` because the degree is 1.
    #[inline(always)]
    pub fn gradient(&self, l: DVec3) -> [DVec3; 3] {
        let position = FacePosition::of(self.inward(l));
        let (bu, bv) = (weights(position.u), weights(position.v));
        let (du, dv) = (first_derivatives(position.u), first_derivatives(position.v));
        let (mut value, mut by_u, mut by_v) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let row = self.row(&position, i);
            let (mut along, mut across) = ([0.0; 4], [0.0; 4]);
            for j in 0..4 {
                for c in 0..4 {
                    along[c] += bv[j] * row[j][c];
                    across[c] += dv[j] * row[j][c];
                }
            }
            for c in 0..4 {
                value[c] += bu[i] * along[c];
                by_u[c] += du[i] * along[c];
                by_v[c] += bu[i] * across[c];
            }
        }
        let mut gradients = [DVec3::ZERO; 3];
        for (c, gradient) in gradients.iter_mut().enumerate() {
            *gradient = self.outward(position.gradient(value[c], by_u[c], by_v[c]));
        }
        gradients
    }

    /// Second derivative at the unit vector `l` of the weighted sum of the channels.
    #[inline(always)]
    pub fn second_derivative(&self, l: DVec3, channels: [f64; 3]) -> DMat3 {
        let position = FacePosition::of(self.inward(l));
        let (bu, bv) = (weights(position.u), weights(position.v));
        let (du, dv) = (first_derivatives(position.u), first_derivatives(position.v));
        let (cu, cv) = (second_derivatives(position.u), second_derivatives(position.v));
        let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
        for i in 0..4 {
            for (j, value) in self.row(&position, i).iter().enumerate() {
                let value = channels[0] * value[0] + channels[1] * value[1] + channels[2] * value[2];
                uu += cu[i] * bv[j] * value;
                uv += du[i] * dv[j] * value;
                vv += bu[i] * cv[j] * value;
            }
        }
        let second = position.second_derivative(uu, uv, vv);
        // Turn it by R H R^T, one column at a time.
        let half = DMat3::from_cols_array_2d(
            &second.to_cols_array_2d().map(|column| self.outward(column.into()).into()),
        );
        DMat3::from_cols_array_2d(
            &half.transpose().to_cols_array_2d().map(|column| self.outward(column.into()).into()),
        )
    }

    #[inline(always)]
    fn row(&self, position: &FacePosition, i: usize) -> &[[f64; 4]; 4] {
        let start = (position.face * SIDE + position.first[0] + i) * SIDE + position.first[1];
        self.faces[start..].first_chunk().expect("a spline reaches one knot beyond the last cell")
    }
}

/// Even degrees of an order, each with the kinds of the cosine and of the sine.
fn even_degrees(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (order + order % 2..=HIGHEST).step_by(2).flat_map(move |l| {
        let kinds = if order > 0 { 0..2 } else { 0..1 };
        kinds.map(move |side| (l, 2 * side + order % 2))
    })
}

/// Coefficients of even degree by kind, with a row for each order and degree and a column for each channel.
fn coefficients_by_kind(harmonics: &Harmonics) -> [DMatrix<f64>; 4] {
    let mut rows: [Vec<f64>; 4] = Default::default();
    for order in 0..=HIGHEST {
        for (degree, kind) in even_degrees(order) {
            rows[kind].extend_from_slice(&harmonics.at(degree, order)[4 * (kind / 2)..][..3]);
        }
    }
    rows.map(|rows| DMatrix::from_row_slice(rows.len() / 3, 3, &rows))
}

/// Indices of a knot and of its mirror image, with the signs of the function there.
fn both_sides(knot: usize, flips: bool) -> impl Iterator<Item = (usize, f64)> {
    let other = (knot > 0).then_some((KNOTS - 1 - knot, if flips { -1.0 } else { 1.0 }));
    std::iter::once((KNOTS - 1 + knot, 1.0)).chain(other)
}

/// Position of a direction on the three faces.
struct FacePosition {
    face: usize,
    /// |x|
    height: f64,
    /// Sign of x.
    sign: f64,
    /// y / x and z / x
    ratios: [f64; 2],
    /// First of the four knots along each axis.
    first: [usize; 2],
    /// Distances from the second of the four knots, in cells.
    u: f64,
    v: f64,
}

impl FacePosition {
    #[inline(always)]
    fn of(l: DVec3) -> Self {
        let size = l.abs();
        let face = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        // Take the other axes in the order of [`OTHERS`].
        let (own, one, other) = match face {
            0 => (l.x, l.y, l.z),
            1 => (l.y, l.z, l.x),
            _ => (l.z, l.x, l.y),
        };
        let inverse = 1.0 / own;
        let ratios = [one * inverse, other * inverse];
        let knots = [(ratios[0] + 1.0) * HALF as f64, (ratios[1] + 1.0) * HALF as f64];
        // Count the edge itself to the last cell.
        let last = 2 * HALF - 1;
        let first = [(knots[0].max(0.0) as usize).min(last), (knots[1].max(0.0) as usize).min(last)];
        let (u, v) = (knots[0] - first[0] as f64, knots[1] - first[1] as f64);
        Self { face, height: own.abs(), sign: own.signum(), ratios, first, u, v }
    }

    /// Gradient of F from f and its derivatives by knots.
    #[inline(always)]
    fn gradient(&self, value: f64, by_u: f64, by_v: f64) -> DVec3 {
        let (fu, fv) = (self.sign * by_u * HALF as f64, self.sign * by_v * HALF as f64);
        let own = self.sign * value - self.ratios[0] * fu - self.ratios[1] * fv;
        self.vector(own, fu, fv)
    }

    #[inline(always)]
    fn second_derivative(&self, uu: f64, uv: f64, vv: f64) -> DMat3 {
        let [uu, uv, vv] = [uu, uv, vv].map(|derivative| derivative * (HALF * HALF) as f64 / self.height);
        let [u, v] = self.ratios;
        let own =
            self.vector(u * u * uu + 2.0 * u * v * uv + v * v * vv, -(u * uu + v * uv), -(u * uv + v * vv));
        let by_u = self.vector(-(u * uu + v * uv), uu, uv);
        let by_v = self.vector(-(u * uv + v * vv), uv, vv);
        let mut columns = [DVec3::ZERO; 3];
        columns[self.face] = own;
        columns[OTHERS[self.face][0]] = by_u;
        columns[OTHERS[self.face][1]] = by_v;
        DMat3::from_cols(columns[0], columns[1], columns[2])
    }

    #[inline(always)]
    fn vector(&self, own: f64, u: f64, v: f64) -> DVec3 {
        match self.face {
            0 => DVec3::new(own, u, v),
            1 => DVec3::new(v, own, u),
            _ => DVec3::new(u, v, own),
        }
    }
}

/// The four cubic B-splines over a cell, at t from 0 to 1.
#[inline(always)]
fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let (one, other) = (4.0 - 3.0 * t * t * (1.0 + s), 4.0 - 3.0 * s * s * (1.0 + t));
    [s * s * s / 6.0, one / 6.0, other / 6.0, t * t * t / 6.0]
}

/// Their first derivatives.
#[inline(always)]
fn first_derivatives(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t]
}

/// Their second derivatives.
#[inline(always)]
fn second_derivatives(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s, t - 2.0 * s, s - 2.0 * t, t]
}

/// Spline coefficients of the quarters of the faces, for each kind and harmonic.
static SPLINES: LazyLock<[DMatrix<f64>; 4]> = LazyLock::new(|| {
    // Sample 8 knots beyond the last coefficient. Each divides the error of the spline's end by 3.7.
    let sampled = KNOTS + 8;
    let knot = |i: usize| {
        let (face, u, v) = (i / (sampled * sampled), i / sampled % sampled, i % sampled);
        let mut knot = DVec3::ZERO;
        knot[face] = 1.0;
        knot[OTHERS[face][0]] = u as f64 / HALF as f64;
        knot[OTHERS[face][1]] = v as f64 / HALF as f64;
        knot
    };
    let samples: Vec<[Vec<f64>; 4]> = (0..3 * sampled * sampled).map(|i| even_harmonics(knot(i))).collect();
    [0, 1, 2, 3].map(|kind| {
        let harmonics = 0..samples[0][kind].len();
        let of_harmonic = |harmonic: usize| {
            let values: Vec<f64> = samples.iter().map(|sample| sample[kind][harmonic]).collect();
            quarters(&values, kind, sampled)
        };
        let columns: Vec<f64> = harmonics.clone().flat_map(of_harmonic).collect();
        DMatrix::from_vec(3 * KNOTS * KNOTS, harmonics.len(), columns)
    })
});

/// The harmonics of even degree by kind, as functions of degree 1, at a point of the cube.
fn even_harmonics(point: DVec3) -> [Vec<f64>; 4] {
    let (length, phi) = (point.length(), angles(point).1);
    let height = point.y / length;
    let mut legendre = AssociatedLegendre::new(height, ((1.0 - height) * (1.0 + height)).max(0.0).sqrt());
    let mut out: [Vec<f64>; 4] = Default::default();
    for order in 0..=HIGHEST {
        let (sin, cos) = (order as f64 * phi).sin_cos();
        let column = legendre.column(order);
        for (degree, kind) in even_degrees(order) {
            out[kind].push(column[degree] * if kind < 2 { cos } else { sin } * length);
        }
    }
    out
}

/// Coefficients of the bicubic splines through `values` at the knots of the quarters of three faces.
fn quarters(values: &[f64], kind: usize, sampled: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(3 * KNOTS * KNOTS);
    for (face, values) in values.chunks_exact(sampled * sampled).enumerate() {
        let [flips_u, flips_v] = OTHERS[face].map(|axis| KINDS[kind][axis]);
        let rows: Vec<Vec<f64>> = values.chunks_exact(sampled).map(|row| spline(row, flips_v)).collect();
        let column = |v: usize| rows.iter().map(|row| row[v]).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..KNOTS).map(|v| spline(&column(v), flips_u)).collect();
        out.extend((0..KNOTS * KNOTS).map(|i| columns[i % KNOTS][i / KNOTS]));
    }
    out
}

/// Coefficients c of the spline with `(c_(i-1) + 4 c_i + c_(i+1)) / 6 = values_i`.
///
/// The spline is mirrored at the first knot, and its coefficients beyond the last knot are the values there.
fn spline(values: &[f64], flips: bool) -> Vec<f64> {
    let last = values.len() - 1;
    let mut above = vec![0.0; last];
    let mut out = values.to_vec();
    // Eliminate the coefficient before each one.
    for i in 0..last {
        let (upper, lower, solved) = match i {
            0 => (if flips { 0.0 } else { 2.0 }, 0.0, 0.0),
            _ => (1.0, above[i - 1], out[i - 1]),
        };
        above[i] = upper / (4.0 - lower);
        out[i] = (6.0 * values[i] - solved) / (4.0 - lower);
    }
    for i in (0..last).rev() {
        out[i] -= above[i] * out[i + 1];
    }
    out.truncate(last);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::Cap;
    use crate::kernels::sphere::direction;

    /// Checks a function of the degrees 0, 2 and 4.
    #[test]
    fn a_field_is_its_harmonics() {
        let mut harmonics = Harmonics::zero();
        harmonics.add_discs([(direction(0.7, 1.0), 0.0, [1.0, 0.5, 2.0])].into_iter());
        let mut factors = [0.0; crate::kernels::expansion::DEGREES];
        (factors[0], factors[2], factors[4]) = (1.0, 0.4, 0.1);
        let even = harmonics.scaled_sum(&factors, &Harmonics::zero(), &factors.map(|_| 0.0));
        let field = Field::new(&even, 0.3);
        for l in [DVec3::Y, direction(0.7, 1.0), direction(2.2, 4.0), DVec3::new(1.0, -1.0, 1.0).normalize()]
        {
            let expected = even.values(&[Cap::new(l, 0.0)])[0];
            for (gradient, expected) in field.gradient(l).into_iter().zip(expected) {
                assert!((gradient.dot(l) - expected).abs() < 1e-5, "{l}: {} {expected}", gradient.dot(l));
            }
        }
    }
}
