//! A smooth even function on the sphere, quick to look up with its derivatives.
//!
//! Of degree 1 and even, it is known from three faces of the cube around the sphere:
//!
//! ```text
//!   F(x, y, z) = |x| f(y / x, z / x)        likewise around y and z
//! ```
//!
//! with f a bicubic B-spline over -1 .. 1: twice differentiable, without an angle. Its coefficients are linear in
//! those of the function in spherical harmonics; the matrix between them is made once.

#![allow(
    clippy::inline_always,
    reason = "functions that are not inlined are compiled for the oldest processors"
)]

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use nalgebra::DMatrix;

use crate::kernels::expansion::{AssociatedLegendre, Harmonics};
use crate::kernels::sphere::angles;

/// Highest degree of the table: the kernel falls off as `degree^-5`, so the cells of the working map limit the error.
pub const HIGHEST: usize = 32;

/// Kinds of harmonics of even degree by the axes along which they change sign when that axis is mirrored: cosines of even
/// and odd order, then sines of even and odd order.
const KINDS: [[bool; 3]; 4] =
    [[false, false, false], [false, true, true], [true, false, true], [true, true, false]];

/// Cells from the middle of a face to its edge. Twice as many lower the error sixteen times: at ten it is a
/// tenth of that of the working map's cells.
const HALF: usize = 10;
/// Coefficients from the middle of a face on: a spline reaches one cell beyond the edge.
const KNOTS: usize = HALF + 2;
/// Coefficients along a face.
const SIDE: usize = 2 * KNOTS - 1;
/// The axes of a face after its own.
const OTHERS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// The coefficients of the three faces; a fourth channel for the sake of wide vectors.
#[derive(Clone, Debug)]
pub struct Field {
    faces: Vec<[f64; 4]>,
    /// Cosine and sine of the azimuth towards which the cube is turned.
    turn: [f64; 2],
}

impl Field {
    /// Tabulate the even degrees of a function in harmonics, on a cube that is turned towards an `azimuth`. If the azimuth
    /// turns with the function, so does the error of the table.
    pub fn new(harmonics: &Harmonics, azimuth: f64) -> Self {
        let harmonics = coefficients_by_kind(&harmonics.turned(azimuth));
        let mut faces = vec![[0.0; 4]; 3 * SIDE * SIDE];
        for (kind, (matrix, harmonics)) in SPLINES.iter().zip(&harmonics).enumerate() {
            let quarter = matrix * harmonics;
            for (i, value) in quarter.row_iter().enumerate() {
                let (face, u, v) = (i / (KNOTS * KNOTS), i / KNOTS % KNOTS, i % KNOTS);
                let [flips_u, flips_v] = OTHERS[face].map(|axis| KINDS[kind][axis]);
                for (u, sign_u) in both_sides(u, flips_u) {
                    for (v, sign_v) in both_sides(v, flips_v) {
                        let place = &mut faces[(face * SIDE + u) * SIDE + v];
                        (0..3).for_each(|c| place[c] += sign_u * sign_v * value[c]);
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

    /// Gradients at the unit vector `l`, by channel; the value is `l.gradient`, for the degree is 1.
    #[inline(always)]
    pub fn gradient(&self, l: DVec3) -> [DVec3; 3] {
        let place = FacePosition::of(self.inward(l));
        let (bu, bv) = (weights(place.u), weights(place.v));
        let (du, dv) = (slopes(place.u), slopes(place.v));
        let (mut value, mut by_u, mut by_v) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let row = self.row(&place, i);
            let (mut along, mut slope) = ([0.0; 4], [0.0; 4]);
            for j in 0..4 {
                for c in 0..4 {
                    along[c] += bv[j] * row[j][c];
                    slope[c] += dv[j] * row[j][c];
                }
            }
            for c in 0..4 {
                value[c] += bu[i] * along[c];
                by_u[c] += du[i] * along[c];
                by_v[c] += bu[i] * slope[c];
            }
        }
        let mut gradients = [DVec3::ZERO; 3];
        for (c, gradient) in gradients.iter_mut().enumerate() {
            *gradient = self.outward(place.gradient(value[c], by_u[c], by_v[c]));
        }
        gradients
    }

    /// The second derivative at the unit vector `l` of the sum of the channels with these `shares`.
    #[inline(always)]
    pub fn second_derivative(&self, l: DVec3, shares: [f64; 3]) -> DMat3 {
        let place = FacePosition::of(self.inward(l));
        let (bu, bv) = (weights(place.u), weights(place.v));
        let (du, dv) = (slopes(place.u), slopes(place.v));
        let (cu, cv) = (bends(place.u), bends(place.v));
        let (mut uu, mut uv, mut vv) = (0.0, 0.0, 0.0);
        for i in 0..4 {
            for (j, value) in self.row(&place, i).iter().enumerate() {
                let value = shares[0] * value[0] + shares[1] * value[1] + shares[2] * value[2];
                uu += cu[i] * bv[j] * value;
                uv += du[i] * dv[j] * value;
                vv += bu[i] * cv[j] * value;
            }
        }
        let second = place.second_derivative(uu, uv, vv);
        // R H R^T, a column at a time.
        let half = DMat3::from_cols_array_2d(
            &second.to_cols_array_2d().map(|column| self.outward(column.into()).into()),
        );
        DMat3::from_cols_array_2d(
            &half.transpose().to_cols_array_2d().map(|column| self.outward(column.into()).into()),
        )
    }

    #[inline(always)]
    fn row(&self, place: &FacePosition, i: usize) -> &[[f64; 4]; 4] {
        let start = (place.face * SIDE + place.first[0] + i) * SIDE + place.first[1];
        self.faces[start..].first_chunk().expect("a spline reaches one knot beyond the last cell")
    }
}

/// Even degrees of an order, with the kinds of its cosine and of its sine.
fn even_degrees(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (order + order % 2..=HIGHEST).step_by(2).flat_map(move |l| {
        let kinds = if order > 0 { 0..2 } else { 0..1 };
        kinds.map(move |side| (l, 2 * side + order % 2))
    })
}

/// Coefficients of even degree for each kind: a row for each order and degree, a column for each channel.
fn coefficients_by_kind(harmonics: &Harmonics) -> [DMatrix<f64>; 4] {
    let mut rows: [Vec<f64>; 4] = Default::default();
    for order in 0..=HIGHEST {
        for (degree, kind) in even_degrees(order) {
            rows[kind].extend_from_slice(&harmonics.at(degree, order)[4 * (kind / 2)..][..3]);
        }
    }
    rows.map(|rows| DMatrix::from_row_slice(rows.len() / 3, 3, &rows))
}

/// The knots of one sign and of the other, and the sign that a function has there.
fn both_sides(knot: usize, flips: bool) -> impl Iterator<Item = (usize, f64)> {
    let other = (knot > 0).then_some((KNOTS - 1 - knot, if flips { -1.0 } else { 1.0 }));
    std::iter::once((KNOTS - 1 + knot, 1.0)).chain(other)
}

/// Where a direction lies on the faces.
struct FacePosition {
    face: usize,
    /// |x|, and its sign
    height: f64,
    sign: f64,
    /// y / x and z / x
    ratios: [f64; 2],
    /// The first of four knots along each axis, and how far beyond the second, in cells.
    first: [usize; 2],
    u: f64,
    v: f64,
}

impl FacePosition {
    #[inline(always)]
    fn of(l: DVec3) -> Self {
        let size = l.abs();
        let face = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        // The other axes follow in order: y and z, z and x, x and y.
        let (own, one, other) = match face {
            0 => (l.x, l.y, l.z),
            1 => (l.y, l.z, l.x),
            _ => (l.z, l.x, l.y),
        };
        let inverse = 1.0 / own;
        let ratios = [one * inverse, other * inverse];
        let knots = [(ratios[0] + 1.0) * HALF as f64, (ratios[1] + 1.0) * HALF as f64];
        // The edge itself belongs to the last cell.
        let last = 2 * HALF - 1;
        let first = [(knots[0].max(0.0) as usize).min(last), (knots[1].max(0.0) as usize).min(last)];
        let (u, v) = (knots[0] - first[0] as f64, knots[1] - first[1] as f64);
        Self { face, height: own.abs(), sign: own.signum(), ratios, first, u, v }
    }

    /// From the value of f and its derivatives by knots.
    #[inline(always)]
    fn gradient(&self, value: f64, by_u: f64, by_v: f64) -> DVec3 {
        let (fu, fv) = (self.sign * by_u * HALF as f64, self.sign * by_v * HALF as f64);
        let own = self.sign * value - self.ratios[0] * fu - self.ratios[1] * fv;
        self.vector(own, fu, fv)
    }

    #[inline(always)]
    fn second_derivative(&self, uu: f64, uv: f64, vv: f64) -> DMat3 {
        let [uu, uv, vv] = [uu, uv, vv].map(|bend| bend * (HALF * HALF) as f64 / self.height);
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
fn slopes(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [-0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t]
}

/// Their second derivatives.
#[inline(always)]
fn bends(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s, t - 2.0 * s, s - 2.0 * t, t]
}

/// Coefficients of the quarters of the faces for each kind and harmonic: those of the spline that has its values at the
/// knots.
static SPLINES: LazyLock<[DMatrix<f64>; 4]> = LazyLock::new(|| {
    /// Knots beyond the edge at which the function is sampled too: each lowers the error of the end by 3.7.
    const MARGIN: usize = 8;
    const SAMPLED: usize = KNOTS + MARGIN;
    let knot = |i: usize| {
        let (face, u, v) = (i / (SAMPLED * SAMPLED), i / SAMPLED % SAMPLED, i % SAMPLED);
        let mut knot = DVec3::ZERO;
        knot[face] = 1.0;
        knot[OTHERS[face][0]] = u as f64 / HALF as f64;
        knot[OTHERS[face][1]] = v as f64 / HALF as f64;
        knot
    };
    let samples: Vec<[Vec<f64>; 4]> = (0..3 * SAMPLED * SAMPLED).map(|i| even_harmonics(knot(i))).collect();
    [0, 1, 2, 3].map(|kind| {
        let harmonics = 0..samples[0][kind].len();
        let spline = |harmonic: usize| {
            let values: Vec<f64> = samples.iter().map(|sample| sample[kind][harmonic]).collect();
            quarters(&values, kind, SAMPLED)
        };
        let columns: Vec<f64> = harmonics.clone().flat_map(spline).collect();
        DMatrix::from_vec(3 * KNOTS * KNOTS, harmonics.len(), columns)
    })
});

/// The harmonics of even degree of each kind, as functions of degree 1, at a place outside of the unit sphere.
fn even_harmonics(place: DVec3) -> [Vec<f64>; 4] {
    let (length, phi) = (place.length(), angles(place).1);
    let height = place.y / length;
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

/// The coefficients of the splines through `values` at the knots of the quarters of three faces.
fn quarters(values: &[f64], kind: usize, sampled: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(3 * KNOTS * KNOTS);
    for (face, values) in values.chunks_exact(sampled * sampled).enumerate() {
        let [flips_u, flips_v] = OTHERS[face].map(|axis| KINDS[kind][axis]);
        let rows: Vec<Vec<f64>> = values.chunks_exact(sampled).map(|row| through(row, flips_v)).collect();
        let column = |v: usize| rows.iter().map(|row| row[v]).collect::<Vec<f64>>();
        let columns: Vec<Vec<f64>> = (0..KNOTS).map(|v| through(&column(v), flips_u)).collect();
        out.extend((0..KNOTS * KNOTS).map(|i| columns[i % KNOTS][i / KNOTS]));
    }
    out
}

/// The coefficients c of the spline with `(c_(i-1) + 4 c_i + c_(i+1)) / 6 = values_i`, mirrored at the first
/// knot, and with values for coefficients beyond the last.
fn through(values: &[f64], flips: bool) -> Vec<f64> {
    let last = values.len() - 1;
    let (mut above, mut rhs) = (vec![0.0; last], vec![0.0; last]);
    for i in 0..last {
        // Eliminate the coefficient before this one.
        let up = match i {
            0 if flips => 0.0,
            0 => 2.0,
            _ => 1.0,
        };
        let (before, solved) = if i == 0 { (0.0, 0.0) } else { (above[i - 1], rhs[i - 1]) };
        let own = 4.0 - before;
        above[i] = up / own;
        rhs[i] = (6.0 * values[i] - if i == 0 { 0.0 } else { solved }) / own;
    }
    let mut next = values[last];
    for i in (0..last).rev() {
        rhs[i] -= above[i] * next;
        next = rhs[i];
    }
    rhs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::expansion::Cap;
    use crate::kernels::sphere::direction;

    /// The function `|l| Y(l)` with a harmonic of degree 4.
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
