//! A map in spherical harmonics of even degree.
//!
//! Real harmonics around +y, of degree l and order m, in the angles of [`crate::kernels::sphere`]:
//!
//! ```text
//!   P_lm(cos theta) cos(m phi)      P_lm(cos theta) sin(m phi)        orthonormal on the sphere
//! ```
//!
//! The coefficients of a map come in two steps: integrals over azimuth row by row (`azimuthal.rs`), then over the height
//! of the rows.

use std::f64::consts::{FRAC_PI_4, PI};
use std::ops::Range;

use glam::{DMat3, DVec3};

use super::points::Point;
use crate::kernels::fit::azimuthal::{self, Azimuthal, Rgb2};
use crate::kernels::image::Grid;
use crate::kernels::kept::Kept;
use crate::kernels::sphere::angles;

/// The highest degree. The clamped cosine weighs degree l by about `l^-5` in an inner product: beyond 32 the
/// cells of the working map, not the harmonics, set the error.
pub const DEGREE: usize = 32;
/// Orders from 0 on.
pub const ORDERS: usize = DEGREE + 1;
const _: () = assert!(ORDERS <= azimuthal::ORDERS, "rows are integrated for each order");

/// The four kinds of harmonics of even degree, by the axes along which they change sign when that axis is
/// mirrored: cosines of even order along none, the others along two.
pub const KINDS: [[bool; 3]; 4] =
    [[false, false, false], [false, true, true], [true, false, true], [true, true, false]];

/// Orders of a kind: cosines of even and of odd order, then sines of even and of odd order.
pub fn orders(kind: usize) -> impl Iterator<Item = usize> {
    let first = [0, 1, 2, 1][kind];
    (first..ORDERS).step_by(2)
}

/// Even degrees of an order.
pub fn degrees(order: usize) -> impl Iterator<Item = usize> {
    (order + order % 2..=DEGREE).step_by(2)
}

/// Coefficients of three channels, kind by kind, order by order, degree by degree.
pub type Coefficients = [Vec<[f64; 3]>; 4];

/// `P_lm` of the order m at many heights, for each even degree from m on.
///
/// From `x P_l = a_(l+1) P_(l+1) + a_l P_(l-1)`, `a_l^2 = (l^2 - m^2) / (4 l^2 - 1)`, taken twice.
pub struct Legendre {
    /// cos theta
    heights: Vec<f64>,
    sines: Vec<f64>,
    /// `P_mm`
    sectoral: Vec<f64>,
    order: usize,
}

impl Legendre {
    /// For the order 0.
    pub fn new(heights: Vec<f64>) -> Self {
        let sines = heights.iter().map(|x| ((1.0 - x) * (1.0 + x)).max(0.0).sqrt()).collect();
        let sectoral = vec![(0.25 / PI).sqrt(); heights.len()];
        Self { heights, sines, sectoral, order: 0 }
    }

    /// A row for each even degree from the order on.
    pub fn rows(&self) -> Vec<Vec<f64>> {
        let m = self.order as f64;
        let a = |l: f64| ((l * l - m * m) / (4.0 * l * l - 1.0)).sqrt();
        let first = if self.order.is_multiple_of(2) {
            self.sectoral.clone()
        } else {
            self.sectoral.iter().zip(&self.heights).map(|(p, x)| p * x / a(m + 1.0)).collect()
        };
        let mut rows = vec![first];
        for l in degrees(self.order).skip(1) {
            let l = l as f64 - 2.0;
            let (own, down, up) =
                (a(l + 1.0).powi(2) + a(l).powi(2), a(l) * a(l - 1.0), 1.0 / (a(l + 1.0) * a(l + 2.0)));
            let last = &rows[rows.len() - 1];
            let mut next: Vec<f64> =
                last.iter().zip(&self.heights).map(|(p, x)| up * (x * x - own) * p).collect();
            if down > 0.0
                && let Some(before) = rows.len().checked_sub(2)
            {
                next.iter_mut().zip(&rows[before]).for_each(|(p, before)| *p -= up * down * before);
            }
            rows.push(next);
        }
        rows
    }

    /// On to the next order.
    pub fn raise(&mut self) {
        self.order += 1;
        let m = self.order as f64;
        let factor = if self.order == 1 { 3.0_f64.sqrt() } else { ((2.0 * m + 1.0) / (2.0 * m)).sqrt() };
        self.sectoral.iter_mut().zip(&self.sines).for_each(|(p, sine)| *p *= factor * sine);
    }
}

/// A map in harmonics.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// Those of even degree.
    pub even: Coefficients,
    /// `integral of L w dw`, by channel: the first degree.
    pub first: [DVec3; 3],
}

impl Spectrum {
    /// Of a map in cells, from the integrals over their rows.
    pub fn new(azimuthal: &Azimuthal, grid: &Grid) -> Self {
        static BANDS: Kept<Vec<f64>, Bands> = Kept::new();
        let bands = BANDS.of(&grid.theta_edges, || Bands::new(&grid.theta_edges));
        Self { even: even(&bands, azimuthal), first: bands.first_moments(azimuthal) }
    }

    /// With points of light.
    pub fn with_points(mut self, points: &[Point]) -> Self {
        let azimuths: Vec<f64> = points.iter().map(|point| angles(point.direction).1).collect();
        let mut legendre = Legendre::new(points.iter().map(|point| point.direction.y).collect());
        let mut filled = [0; 4];
        for order in 0..ORDERS {
            let turns: Vec<(f64, f64)> = azimuths.iter().map(|phi| (order as f64 * phi).sin_cos()).collect();
            for row in legendre.rows() {
                for kind in (0..4).filter(|&kind| kind % 2 == order % 2 && (kind < 2 || order > 0)) {
                    let sum = &mut self.even[kind][filled[kind]];
                    for ((p, (sin, cos)), point) in row.iter().zip(&turns).zip(points) {
                        let harmonic = p * if kind < 2 { cos } else { sin };
                        (0..3).for_each(|channel| sum[channel] += harmonic * point.irradiance[channel]);
                    }
                    filled[kind] += 1;
                }
            }
            legendre.raise();
        }
        for Point { direction, irradiance } in points {
            (0..3).for_each(|channel| self.first[channel] += *direction * irradiance[channel]);
        }
        self
    }

    /// `integral of L dw` of a channel.
    pub fn whole(&self, channel: usize) -> f64 {
        self.even[0][0][channel] * (4.0 * PI).sqrt()
    }

    /// `integral of L w w^T dw` of a channel: the trace from degree 0, the rest from degree 2, whose harmonics
    /// are `sqrt(15 / 4 pi)` times -y z, x y, (z^2 - x^2) / 2, -x z, and `sqrt(5 / 16 pi) (3 y^2 - 1)`.
    pub fn second(&self, channel: usize) -> DMat3 {
        let unit = (15.0 / (4.0 * PI)).sqrt();
        let first_of_order_2 = degrees(0).count();
        let [yz, xy, zz_xx, xz] = [
            -self.even[1][0][channel],
            self.even[3][0][channel],
            2.0 * self.even[0][first_of_order_2][channel],
            -self.even[2][0][channel],
        ]
        .map(|value| value / unit);
        let whole = self.whole(channel);
        let yy = (self.even[0][1][channel] / (5.0 / (16.0 * PI)).sqrt() + whole) / 3.0;
        let (zz, xx) = (0.5 * (whole - yy + zz_xx), 0.5 * (whole - yy - zz_xx));
        DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
    }

    /// Azimuth of the map's vector irradiance: it turns with the map. 0 where that is all but vertical.
    pub fn azimuth(&self) -> f64 {
        let whole: f64 = (0..3).map(|channel| self.whole(channel)).sum();
        let first: DVec3 = self.first.iter().sum();
        if first.with_y(0.0).length() > 1e-6 * whole { angles(first).1 } else { 0.0 }
    }

    /// Degree l times the l/2-th of these `factors`.
    pub fn scaled(&self, factors: &[f64]) -> Coefficients {
        let mut out = self.even.clone();
        for (kind, out) in out.iter_mut().enumerate() {
            let degrees = orders(kind).flat_map(degrees);
            for (value, degree) in out.iter_mut().zip(degrees) {
                *value = value.map(|value| value * factors[degree / 2]);
            }
        }
        out
    }
}

/// The coefficients of what stands at `azimuth`, once it is turned to 0.
pub fn turned(mut harmonics: Coefficients, azimuth: f64) -> Coefficients {
    let [even_cosines, odd_cosines, even_sines, odd_sines] = &mut harmonics;
    let cosines = even_cosines.iter_mut().skip(degrees(0).count()).chain(odd_cosines);
    let sines = even_sines.iter_mut().chain(odd_sines);
    let orders = [2, 3].into_iter().flat_map(orders).flat_map(|order| degrees(order).map(move |_| order));
    for ((cosine, sine), order) in cosines.zip(sines).zip(orders) {
        let (sin, cos) = (order as f64 * azimuth).sin_cos();
        for (a, b) in cosine.iter_mut().zip(sine) {
            (*a, *b) = (*a * cos + *b * sin, *b * cos - *a * sin);
        }
    }
    harmonics
}

/// The coefficients of even degree.
fn even(bands: &Bands, azimuthal: &Azimuthal) -> Coefficients {
    let mut out: Coefficients = Default::default();
    let mut integrals = bands.integrals.chunks_exact(bands.rows.len());
    for order in 0..ORDERS {
        let sums = bands.sums(azimuthal, order);
        for (_, integrals) in degrees(order).zip(&mut integrals) {
            let mut sum = [0.0; 8];
            for (integral, values) in integrals.iter().zip(&sums) {
                (0..8).for_each(|i| sum[i] += integral * values[i]);
            }
            let [cosine, sine] = [0, 4].map(|i| [sum[i], sum[i + 1], sum[i + 2]]);
            out[order % 2].push(cosine);
            if order > 0 {
                out[2 + order % 2].push(sine);
            }
        }
    }
    out
}

/// Heights at which the rows are integrated.
struct Bands {
    nodes: Vec<Node>,
    rows: Vec<Row>,
    /// Integrals of `P_lm` over theta, order by order, degree by degree: one for each row.
    integrals: Vec<f64>,
}

/// A node of an integral over theta.
struct Node {
    /// cos theta
    height: f64,
    weight: f64,
}

/// A row, and the one at the same angle from the other pole where there is one.
struct Row {
    index: usize,
    mirrored: Option<usize>,
    nodes: Range<usize>,
}

impl Bands {
    /// Two Gauss nodes in theta for each row, more where rows are high.
    fn new(edges: &[f64]) -> Self {
        const HIGHEST: f64 = FRAC_PI_4 / 16.0;
        let rows = edges.len() - 1;
        let is_symmetric = (0..=rows).all(|i| (edges[i] + edges[rows - i] - PI).abs() < 1e-12);
        let mut bands = Self { nodes: Vec::new(), rows: Vec::new(), integrals: Vec::new() };
        for row in 0..if is_symmetric { rows.div_ceil(2) } else { rows } {
            let (low, high, first) = (edges[row], edges[row + 1], bands.nodes.len());
            let parts = ((high - low) / HIGHEST).ceil().max(1.0);
            let half = 0.5 * (high - low) / parts;
            for part in 0..parts as usize {
                let middle = low + half * (2 * part + 1) as f64;
                for side in [-1.0, 1.0] {
                    let (sine, height) = (middle + side * half / 3.0_f64.sqrt()).sin_cos();
                    bands.nodes.push(Node { height, weight: half * sine });
                }
            }
            let mirrored = (is_symmetric && rows - 1 - row != row).then(|| rows - 1 - row);
            bands.rows.push(Row { index: row, mirrored, nodes: first..bands.nodes.len() });
        }
        bands.integrals = bands.integrals();
        bands
    }

    fn integrals(&self) -> Vec<f64> {
        let mut out = Vec::new();
        let mut legendre = Legendre::new(self.nodes.iter().map(|node| node.height).collect());
        for _ in 0..ORDERS {
            for values in legendre.rows() {
                let integral = |row: &Row| {
                    let weighted = values[row.nodes.clone()].iter().zip(&self.nodes[row.nodes.clone()]);
                    weighted.map(|(p, node)| p * node.weight).sum::<f64>()
                };
                out.extend(self.rows.iter().map(integral));
            }
            legendre.raise();
        }
        out
    }

    /// `integral of L w dw`, by channel.
    fn first_moments(&self, azimuthal: &Azimuthal) -> [DVec3; 3] {
        let mut out = [DVec3::ZERO; 3];
        for Row { index, mirrored, nodes } in &self.rows {
            for Node { height, weight } in &self.nodes[nodes.clone()] {
                let sine = (1.0 - height * height).sqrt();
                for (row, height) in [(Some(*index), *height), (*mirrored, -height)] {
                    let Some(row) = row else { continue };
                    let (zeroth, first) = (azimuthal.at(row, 0), azimuthal.at(row, 1));
                    for (channel, out) in out.iter_mut().enumerate() {
                        let (x, z) = (sine * first[channel + 4], -sine * first[channel]);
                        *out += DVec3::new(x, height * zeroth[channel], z) * *weight;
                    }
                }
            }
        }
        out
    }

    /// The integrals over azimuth of one order for each row and the mirrored one together.
    fn sums(&self, azimuthal: &Azimuthal, order: usize) -> Vec<Rgb2> {
        // Mirrored at the equator, harmonics of even degree and odd order change sign.
        let sign = if order.is_multiple_of(2) { 1.0 } else { -1.0 };
        let of = |row: usize| *azimuthal.at(row, order);
        let sum = |row: &Row| {
            let (own, other) = (of(row.index), row.mirrored.map_or([0.0; 8], of));
            std::array::from_fn(|i| own[i] + sign * other[i])
        };
        self.rows.iter().map(sum).collect()
    }
}
