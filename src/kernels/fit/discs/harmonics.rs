//! A map in spherical harmonics of all degrees, and sums of them at a place with their derivatives.
//!
//! Real harmonics around +y, orthonormal on the sphere, in the angles of [`crate::kernels::sphere`]:
//!
//! ```text
//!   P_lm(cos theta) cos(m phi)      P_lm(cos theta) sin(m phi)
//! ```
//!
//! A map is the sum of its cells, each a patch of one radiance between two parallels and two meridians. So its
//! coefficients come in two steps: integrals over azimuth row by row, then over the height of the rows.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use nalgebra::{Complex, DMatrix};
use ndarray::ArrayView3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::zonal::{DEGREE, DEGREES, Factors};
use crate::kernels::image::Grid;
use crate::kernels::sphere::{angle_derivatives, angles};

/// Harmonics of one sign of m: order by order, degree by degree from the order on.
const COUNT: usize = DEGREES * (DEGREES + 1) / 2;

/// Three channels of a cosine, a place left free, and three of the sine.
type Rgb2 = [f64; 8];

/// Coefficients of three channels.
#[derive(Clone, Debug)]
pub struct Harmonics {
    pub values: Vec<Rgb2>,
}

/// Degree of each coefficient.
fn degrees() -> impl Iterator<Item = usize> {
    (0..DEGREES).flat_map(|m| m..DEGREES)
}

impl Harmonics {
    /// None of all.
    pub fn zero() -> Self {
        Self { values: vec![[0.0; 8]; COUNT] }
    }

    /// Of a map in cells.
    pub fn of_cells(radiance: ArrayView3<'_, f32>, grid: &Grid) -> Self {
        /// Parts of the rows that are summed side by side; always the same, so that the sums are too.
        const PARTS: usize = 4;
        let azimuthal = azimuthal(radiance, &grid.phi_edges);
        let rows = Row::all(&grid.theta_edges);
        let part = |rows: &[Row]| {
            let mut out = Self::zero();
            for row in rows {
                row.add_to(&mut out, &azimuthal);
            }
            out
        };
        let parts: Vec<Self> = rows.par_chunks(rows.len().div_ceil(PARTS)).map(part).collect();
        parts.iter().fold(Self::zero(), |sum, part| sum.scaled_sum(&[1.0; DEGREES], part, &[1.0; DEGREES]))
    }

    /// Add a disc of these factors, and of that flux.
    pub fn add_disc(&mut self, towards: DVec3, factors: &Factors, flux: [f64; 3]) {
        let place = Place::new(towards);
        let mut harmonics = self.values.iter_mut();
        let mut legendre = Legendre::new(place.cosine, place.sine);
        for m in 0..DEGREES {
            let (sin, cos) = (m as f64 * place.azimuth).sin_cos();
            for (l, p) in legendre.column(m).iter().enumerate().skip(m) {
                let Some(value) = harmonics.next() else { return };
                for channel in 0..3 {
                    value[channel] += flux[channel] * factors[l][0] * p * cos;
                    value[4 + channel] += flux[channel] * factors[l][0] * p * sin;
                }
            }
        }
    }

    /// Add a vector to the integral of `L w dw` of a channel.
    pub fn add_first(&mut self, channel: usize, vector: DVec3) {
        let vector = vector * (3.0 / (4.0 * PI)).sqrt();
        self.values[1][channel] += vector.y;
        self.values[DEGREES][channel] -= vector.z;
        self.values[DEGREES][4 + channel] += vector.x;
    }

    /// Each degree times its factor, plus `others`, each degree times its own.
    pub fn scaled_sum(&self, factors: &[f64; DEGREES], others: &Self, of_others: &[f64; DEGREES]) -> Self {
        let pairs = self.values.iter().zip(&others.values).zip(degrees());
        let sum = |((a, b), l): ((&Rgb2, &Rgb2), usize)| {
            std::array::from_fn(|i| factors[l] * a[i] + of_others[l] * b[i])
        };
        Self { values: pairs.map(sum).collect() }
    }

    /// Inner product with `others`, each degree times its factor, by channel.
    pub fn product(&self, others: &Self, factors: &[f64; DEGREES]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for ((a, b), l) in self.values.iter().zip(&others.values).zip(degrees()) {
            (0..3).for_each(|c| out[c] += factors[l] * (a[c] * b[c] + a[4 + c] * b[4 + c]));
        }
        out
    }

    /// `integral of L dw`, `L w dw`, `L w w^T dw` of a channel: the last has its trace from degree 0, the rest from
    /// degree 2, whose harmonics are `sqrt(15 / 4 pi)` times -y z, x y, (z^2 - x^2) / 2, -x z, and
    /// `sqrt(5 / 16 pi) (3 y^2 - 1)`.
    pub fn moments(&self, channel: usize) -> (f64, DVec3, DMat3) {
        let at = |l: usize, m: usize| &self.values[m * DEGREES - m * m.saturating_sub(1) / 2 + l - m];
        let (cosine, sine) = (|l, m| at(l, m)[channel], |l, m| at(l, m)[4 + channel]);
        let whole = cosine(0, 0) * (4.0 * PI).sqrt();
        let first = DVec3::new(sine(1, 1), cosine(1, 0), -cosine(1, 1)) * (4.0 * PI / 3.0).sqrt();
        let unit = (15.0 / (4.0 * PI)).sqrt();
        let [yz, xy, zz_xx, xz] =
            [-cosine(2, 1), sine(2, 1), 2.0 * cosine(2, 2), -sine(2, 2)].map(|value| value / unit);
        let yy = (cosine(2, 0) / (5.0 / (16.0 * PI)).sqrt() + whole) / 3.0;
        let (zz, xx) = (0.5 * (whole - yy + zz_xx), 0.5 * (whole - yy - zz_xx));
        (whole, first, DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]))
    }
}

/// A place on the sphere, and its frame: towards growing theta, and growing phi.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    pub frame: [DVec3; 2],
    azimuth: f64,
    cosine: f64,
    sine: f64,
}

impl Place {
    /// That of a direction, at least a little beside the poles.
    pub fn new(direction: DVec3) -> Self {
        /// Formulas divide by the sine.
        const LEAST_SINE: f64 = 1e-5;
        let (theta, azimuth) = angles(direction);
        let (sine, cosine) = theta.clamp(LEAST_SINE, PI - LEAST_SINE).sin_cos();
        let frame = [angle_derivatives(theta, azimuth)[0], angle_derivatives(0.5 * PI, azimuth)[1]];
        Self { frame, azimuth, cosine, sine }
    }
}

/// `P_lm` at one height, order by order.
///
/// From `x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)`, `a_l^2 = (l^2 - m^2) / (4 l^2 - 1)`.
struct Legendre {
    x: f64,
    sine: f64,
    sectoral: f64,
    column: [f64; DEGREES],
}

/// `a_l` for each order and degree, and its inverse.
static RECURRENCE: LazyLock<Vec<[[f64; 2]; DEGREES]>> = LazyLock::new(|| {
    let factor = |l: usize, m: usize| {
        let (l, m) = (l as f64, m as f64);
        let a = ((l * l - m * m) / (4.0 * l * l - 1.0)).max(0.0).sqrt();
        [a, 1.0 / a]
    };
    (0..DEGREES).map(|m| std::array::from_fn(|l| factor(l, m))).collect()
});

impl Legendre {
    fn new(x: f64, sine: f64) -> Self {
        Self { x, sine, sectoral: (0.25 / PI).sqrt(), column: [0.0; DEGREES] }
    }

    /// All degrees of the order m, 0 below it; call it for m = 0, 1, 2, ..
    #[inline(always)]
    fn column(&mut self, m: usize) -> &[f64; DEGREES] {
        if m > 0 {
            let odd = 2.0 * m as f64 + 1.0;
            self.sectoral *= self.sine * if m == 1 { 3.0_f64.sqrt() } else { (odd / (odd - 1.0)).sqrt() };
            self.column[m - 1] = 0.0;
        }
        self.column[m] = self.sectoral;
        let a = &RECURRENCE[m];
        let (mut before, mut last) = (0.0, self.sectoral);
        for l in m + 1..DEGREES {
            (before, last) = (last, (self.x * last - a[l - 1][0] * before) * a[l][1]);
            self.column[l] = last;
        }
        &self.column
    }
}

/// A sum of harmonics at a place.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    /// By channel.
    pub value: [f64; 3],
    /// By theta, by phi over the sine of theta, and by A, by channel.
    pub first: [[f64; 3]; 3],
    /// Second derivatives on the sphere and by A, of the channels with given shares.
    pub second: [[f64; 3]; 3],
}

impl Harmonics {
    /// Values at a place, each degree times its factor.
    pub fn value(&self, place: &Place, factors: &Factors) -> [f64; 3] {
        Arch::new().dispatch(Value { harmonics: self, place, factors })
    }

    /// The same with derivatives by the place and by the A of the factors; the second ones of the channels with these
    /// `shares`.
    pub fn sum(&self, place: &Place, factors: &Factors, shares: [f64; 3]) -> Sum {
        Arch::new().dispatch(Around { harmonics: self, place, factors, shares })
    }
}

/// See [`Harmonics::value`].
struct Value<'a> {
    harmonics: &'a Harmonics,
    place: &'a Place,
    factors: &'a Factors,
}

impl WithSimd for Value<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f64; 3] {
        let Self { harmonics, place, factors } = self;
        let mut legendre = Legendre::new(place.cosine, place.sine);
        let mut out = [0.0; 3];
        let mut rest = &harmonics.values[..];
        for m in 0..DEGREES {
            let column = &legendre.column(m)[m..];
            let (values, others) = rest.split_at(DEGREES - m);
            rest = others;
            let mut sum = [0.0; 8];
            for ((value, p), factor) in values.iter().zip(column).zip(&factors[m..]) {
                let weight = p * factor[0];
                (0..8).for_each(|i| sum[i] += weight * value[i]);
            }
            let (sin, cos) = (m as f64 * place.azimuth).sin_cos();
            (0..3).for_each(|c| out[c] += cos * sum[c] + sin * sum[4 + c]);
        }
        out
    }
}

/// See [`Harmonics::sum`].
///
/// With `P' = (l cos P_l - b_l P_(l-1)) / sin` by theta, where `b_l = (2l + 1) a_l`, `P'' = -cot P' + (m^2 / sin^2 -
/// l (l + 1)) P`, and `R = m P / sin`; along phi the second derivative is what Laplace's equation leaves.
struct Around<'a> {
    harmonics: &'a Harmonics,
    place: &'a Place,
    factors: &'a Factors,
    shares: [f64; 3],
}

impl WithSimd for Around<'_> {
    type Output = Sum;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sum {
        let Self { harmonics, place, factors, shares } = self;
        let Place { cosine, sine, azimuth, .. } = *place;
        let (cot, over) = (cosine / sine, 1.0 / sine);
        let mut legendre = Legendre::new(cosine, sine);
        let mut out = Sum::default();
        let mut rest = &harmonics.values[..];
        let [mut tt, mut tp, mut laplace, mut ta, mut pa, mut aa] = [0.0; 6];
        for m in 0..DEGREES {
            let column = legendre.column(m);
            let (values, others) = rest.split_at(DEGREES - m);
            rest = others;
            let order = m as f64;
            let mut sums = [[0.0; 8]; 4];
            let mut bends = [[0.0; 2]; 6];
            for (l, value) in (m..DEGREES).zip(values) {
                let p = column[l];
                let below = if l > m { column[l - 1] } else { 0.0 };
                let degree = l as f64;
                let b = (2.0 * degree + 1.0) * RECURRENCE[m][l][0];
                let slope = (degree * cosine * p - b * below) * over;
                let eigenvalue = degree * (degree + 1.0);
                let bend = -cot * slope + (order * order * over * over - eigenvalue) * p;
                let round = order * p * over;
                let round_slope = (order * slope - round * cosine) * over;
                let [d, by_a, by_aa] = factors[l];
                let weights = [d * p, d * slope, d * round, by_a * p];
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    (0..8).for_each(|i| sum[i] += weight * value[i]);
                }
                let both = [0, 4]
                    .map(|i| shares[0] * value[i] + shares[1] * value[i + 1] + shares[2] * value[i + 2]);
                let weights =
                    [d * bend, d * round_slope, -eigenvalue * d * p, by_a * slope, by_a * round, by_aa * p];
                for (sum, weight) in bends.iter_mut().zip(weights) {
                    (0..2).for_each(|i| sum[i] += weight * both[i]);
                }
            }
            let (sin, cos) = (order * azimuth).sin_cos();
            for c in 0..3 {
                let along = |sum: &Rgb2| cos * sum[c] + sin * sum[4 + c];
                out.value[c] += along(&sums[0]);
                out.first[0][c] += along(&sums[1]);
                out.first[1][c] += cos * sums[2][4 + c] - sin * sums[2][c];
                out.first[2][c] += along(&sums[3]);
            }
            let along = |sum: [f64; 2]| cos * sum[0] + sin * sum[1];
            let across = |sum: [f64; 2]| cos * sum[1] - sin * sum[0];
            tt += along(bends[0]);
            tp += across(bends[1]);
            laplace += along(bends[2]);
            ta += along(bends[3]);
            pa += across(bends[4]);
            aa += along(bends[5]);
        }
        out.second = [[tt, tp, ta], [tp, laplace - tt, pa], [ta, pa, aa]];
        out
    }
}

/// Integrals over azimuth of each row, by `cos m phi` and `sin m phi`: for each row, each order.
fn azimuthal(radiance: ArrayView3<'_, f32>, edges: &[f64]) -> Vec<Rgb2> {
    let (rows, columns, _) = radiance.dim();
    let samples = radiance.as_standard_layout();
    let samples = samples.as_slice().unwrap_or(&[]).as_chunks::<3>().0; // the standard layout is a slice
    let whole = edges[columns];
    let is_symmetric = columns.is_multiple_of(2)
        && (0..=columns).all(|x| (edges[x] + edges[columns - x] - whole).abs() < 1e-12 * whole);
    // Cosines are even, sines are odd: of symmetric columns one half is enough.
    let used = if is_symmetric { columns / 2 } else { columns };
    let mut cells = [(); 2].map(|()| DMatrix::zeros(used, 3 * rows));
    let [even, odd] = &mut cells;
    for (row, samples) in samples.chunks_exact(columns).enumerate() {
        for x in 0..used {
            for (channel, &one) in samples[x].iter().enumerate() {
                let (place, one) = ((x, 3 * row + channel), f64::from(one));
                let other = f64::from(samples[columns - 1 - x][channel]);
                even[place] = if is_symmetric { one + other } else { one };
                odd[place] = if is_symmetric { one - other } else { one };
            }
        }
    }
    let mut out = vec![[0.0; 8]; rows * DEGREES];
    for ((first, cells), integrals) in [0, 4].into_iter().zip(&cells).zip(integrals(&edges[..=used])) {
        let sums = integrals * cells;
        for row in 0..rows {
            for m in 0..DEGREES {
                (0..3).for_each(|c| out[row * DEGREES + m][first + c] = sums[(m, 3 * row + c)]);
            }
        }
    }
    out
}

/// `integral of cos m phi` and of `sin m phi` over each column, for each order.
fn integrals(edges: &[f64]) -> [DMatrix<f64>; 2] {
    let mut out = [(); 2].map(|()| DMatrix::zeros(DEGREES, edges.len() - 1));
    let mut low = turns(edges[0]);
    for (x, edge) in edges.windows(2).enumerate() {
        let high = turns(edge[1]);
        out[0][(0, x)] = edge[1] - edge[0];
        for m in 1..DEGREES {
            out[0][(m, x)] = (high[m].im - low[m].im) / m as f64;
            out[1][(m, x)] = (low[m].re - high[m].re) / m as f64;
        }
        low = high;
    }
    out
}

/// `exp(i m phi)` for each order m, each from the one before.
fn turns(phi: f64) -> [Complex<f64>; DEGREES] {
    let turn = Complex::from_polar(1.0, phi);
    let mut turns = [Complex::ONE; DEGREES];
    (1..DEGREES).for_each(|m| turns[m] = turns[m - 1] * turn);
    turns
}

/// A row of cells between two polar angles, and the one at the same angles from the other pole where there is one.
struct Row {
    edges: [f64; 2],
    index: usize,
    mirrored: Option<usize>,
}

impl Row {
    fn all(edges: &[f64]) -> Vec<Self> {
        let rows = edges.len() - 1;
        let is_symmetric = (0..=rows).all(|i| (edges[i] + edges[rows - i] - PI).abs() < 1e-12);
        let row = |index: usize| {
            let mirrored = (is_symmetric && rows - 1 - index != index).then(|| rows - 1 - index);
            Self { edges: [edges[index], edges[index + 1]], index, mirrored }
        };
        (0..if is_symmetric { rows.div_ceil(2) } else { rows }).map(row).collect()
    }

    /// Add it to harmonics, by two Gauss nodes in theta, more where it is high.
    fn add_to(&self, out: &mut Harmonics, azimuthal: &[Rgb2]) {
        const HIGHEST: f64 = FRAC_PI_4 / 16.0;
        let height = self.edges[1] - self.edges[0];
        let parts = (height / HIGHEST).ceil().max(1.0);
        let half = 0.5 * height / parts;
        let mut integrals = vec![[0.0; DEGREES]; DEGREES];
        for node in 0..2 * parts as usize {
            let middle = self.edges[0] + half * (2 * (node / 2) + 1) as f64;
            let side = if node % 2 == 0 { -half } else { half };
            let (sine, cosine) = (middle + side / 3.0_f64.sqrt()).sin_cos();
            let mut legendre = Legendre::new(cosine, sine);
            for (m, integrals) in integrals.iter_mut().enumerate() {
                let column = legendre.column(m);
                (m..DEGREES).for_each(|l| integrals[l] += half * sine * column[l]);
            }
        }
        let mut values = out.values.iter_mut();
        for (m, integrals) in integrals.iter().enumerate() {
            // On the other side of the horizon, every second degree has the other sign.
            let one = azimuthal[self.index * DEGREES + m];
            let other = self.mirrored.map_or([0.0; 8], |row| azimuthal[row * DEGREES + m]);
            let sums: [Rgb2; 2] =
                [std::array::from_fn(|i| one[i] + other[i]), std::array::from_fn(|i| one[i] - other[i])];
            for (l, value) in (m..DEGREES).zip(&mut values) {
                let sum = &sums[(l - m) % 2];
                (0..8).for_each(|i| value[i] += integrals[l] * sum[i]);
            }
        }
    }
}

const _: () = assert!(DEGREE > 2, "moments take degree 2");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::fit::discs::zonal::factors;
    use crate::kernels::sphere::{Registration, direction, exponential_map};
    use ndarray::Array3;

    /// A map of waves, which few degrees hold.
    fn waves(registration: Registration, columns: usize) -> (Array3<f32>, Grid) {
        let rows = columns / 2;
        let (thetas, phis) = (registration.thetas(rows), registration.phis(columns));
        let map = Array3::from_shape_fn((rows, columns, 3), |(y, x, c)| {
            wave(direction(thetas[y], phis[x]), c) as f32
        });
        (map, Grid::of_pixels(rows, columns, registration))
    }

    fn wave(d: DVec3, channel: usize) -> f64 {
        2.0 + d.x + 0.5 * d.y * d.z - 0.7 * d.x * d.z + (channel as f64) * d.y.powi(3) + 0.3 * d.z.powi(4)
    }

    /// A disc of radius 0: the map itself.
    #[test]
    fn harmonics_of_a_map_are_the_map() {
        for (registration, columns) in [
            (Registration::CellCentred, 256),
            (Registration::BorderSampled, 257),
            (Registration::CellCentred, 250),
        ] {
            let (map, grid) = waves(registration, columns);
            let harmonics = Harmonics::of_cells(map.view(), &grid);
            for place in [direction(0.0, 0.0), direction(1.0, 2.0), direction(2.9, 5.0)] {
                let values = harmonics.value(&Place::new(place), &factors(0.0));
                for (channel, value) in values.into_iter().enumerate() {
                    assert!(
                        (value - wave(place, channel)).abs() < 2e-3,
                        "{place} {value} {}",
                        wave(place, channel)
                    );
                }
            }
        }
    }

    #[test]
    fn moments_are_those_of_the_harmonics() {
        let mut harmonics = Harmonics::zero();
        let towards = DVec3::new(2.0, 3.0, -6.0) / 7.0;
        harmonics.add_disc(towards, &factors(0.0), [5.0, 0.0, 1.0]);
        let (whole, first, second) = harmonics.moments(0);
        assert!((whole - 5.0).abs() < 1e-12);
        assert!((first - 5.0 * towards).length() < 1e-12);
        let wanted = DMat3::from_cols(towards * towards.x, towards * towards.y, towards * towards.z) * 5.0;
        assert!((second - wanted).to_cols_array().iter().all(|value| value.abs() < 1e-12), "{second}");
        harmonics.add_first(2, DVec3::new(0.1, 0.2, 0.3));
        assert!((harmonics.moments(2).1 - towards - DVec3::new(0.1, 0.2, 0.3)).length() < 1e-12);
    }

    #[test]
    fn derivatives_are_the_slopes_that_are_measured() {
        /// A changes more quickly.
        const STEPS: [f64; 3] = [1e-4, 1e-4, 1e-5];
        let (map, grid) = waves(Registration::CellCentred, 64);
        let mut harmonics = Harmonics::of_cells(map.view(), &grid);
        harmonics.add_disc(direction(1.1, 2.0), &factors(1e-3), [3.0, 2.0, 1.0]);
        let shares = [0.5, 0.3, -0.2];
        for l in [direction(0.7, 1.0), direction(1.2, 2.2), direction(3.0, 4.0)] {
            let share = 0.02;
            let place = Place::new(l);
            let sum = harmonics.sum(&place, &factors(share), shares);
            let at = |step: [f64; 3]| {
                let l = exponential_map(l, place.frame[0] * step[0] + place.frame[1] * step[1]);
                harmonics.value(&Place::new(l), &factors(share + step[2]))
            };
            let weighted = |step: [f64; 3]| -> f64 { at(step).iter().zip(shares).map(|(v, s)| v * s).sum() };
            let here = weighted([0.0; 3]);
            for i in 0..3 {
                let along = |a: f64, k: usize, b: f64| {
                    let mut step = [0.0; 3];
                    step[i] += a * STEPS[i];
                    step[k] += b * STEPS[k];
                    step
                };
                let (ahead, behind) = (at(along(1.0, i, 0.0)), at(along(-1.0, i, 0.0)));
                for c in 0..3 {
                    let slope = (ahead[c] - behind[c]) / (2.0 * STEPS[i]);
                    assert!(
                        (slope - sum.first[i][c]).abs() < 1e-4 * (1.0 + slope.abs()),
                        "{l} {i} {c} {slope} {sum:?}"
                    );
                }
                for (k, other_step) in STEPS.into_iter().enumerate() {
                    let corner = |a: f64, b: f64| weighted(along(a, k, b));
                    let bend = if i == k {
                        (weighted(along(1.0, i, 0.0)) + weighted(along(-1.0, i, 0.0)) - 2.0 * here)
                            / (STEPS[i] * other_step)
                    } else {
                        (corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0))
                            / (4.0 * STEPS[i] * other_step)
                    };
                    let error = (bend - sum.second[i][k]).abs();
                    assert!(error < 1e-3 * (1.0 + bend.abs()), "{l} {i} {k} {bend} {sum:?}");
                }
            }
        }
    }
}
