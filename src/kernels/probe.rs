//! Irradiance of a white probe under a map.
//!
//! ```text
//!   E(n) = integral over the sphere of L(w) max(0, n.w) dw
//! ```
//!
//! Where the probe sees a cell, the integrand is *linear* in w, so only the vector flux of what is
//! seen counts. In one row (theta fixed) the seen part is one interval of azimuths around the
//! normal's own azimuth `phi_n`:
//!
//! ```text
//!   n.w = n_y cos theta + n_e sin theta cos(phi - phi_n) > 0      n_e = length of (n_x, n_z)
//!     <=>  cos(phi - phi_n) > c,   c = -(n_y / n_e) cot theta
//! ```
//!
//! all of the row for c <= -1, nothing for c >= 1, else `phi_n -+ acos c`. Prefix sums over the
//! columns of `L (integral of cos phi, sin phi, 1)` give the flux of any interval from two look-ups:
//! O(pixels + normals x rows) instead of O(pixels x normals). Pixels are integrated whole, where a
//! sum over their centres stands for them by one direction.

use std::f64::consts::TAU;

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2, ArrayView3, Axis, s};
use rayon::prelude::*;

use super::image::{self, Grid, WorkingMap};
use super::sphere::{Registration, angles, check_rows, unit_vectors};
use crate::error::{Error, Result};

/// Rows are summed in runs of their own, whatever the number of threads: the same bits everywhere.
const MOST_RUNS: usize = 64;
/// Rows that are worth sums of their own.
const ROWS_OF_A_RUN: usize = 8;
/// Normals that share one pass over the map; bounds the memory of the runs' sums.
const NORMALS_AT_ONCE: usize = 4096;

/// Gauss-Legendre nodes and weights on -1 .. 1.
type Nodes = &'static [(f64, f64)];
const ONE_NODE: Nodes = &[(0.0, 2.0)];
const TWO_NODES: Nodes = &[(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
const FOUR_NODES: Nodes = &[
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Exact irradiance, (n, 3), of a map of radiance at `normals`, (n, 3).
///
/// The horizon bends within a row: with the row's middle latitude alone a constant map is off by
/// 2.4e-4 at 64 rows and by 8e-7 at 1024. A few Gauss nodes in theta for maps of few rows take that
/// away; the counts are the fewest that pass the constant-map tests below.
///
/// # Inputs
///
/// - `radiance`: (height, width, 3), linear RGB, finite and not negative.
/// - `normals`: (n, 3), unit vectors, in the frame of [`super::sphere`].
///
/// # Errors
///
/// [`Error::NotAMap`], [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn irradiance(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    normals: ArrayView2<'_, f64>,
) -> Result<Array2<f64>> {
    image::check_rgb(radiance)?;
    let normals = unit_vectors("normal", normals)?;
    let (height, width, _) = radiance.dim();
    let nodes = match height {
        2048.. => ONE_NODE,
        256.. => TWO_NODES,
        _ => FOUR_NODES,
    };
    Ok(under_cells(radiance, &Grid::of_pixels(height, width, registration), nodes, &normals))
}

/// Irradiance, (n, 3), under a reduced map and the sources taken out of it.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn working_irradiance(map: &WorkingMap, normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    let cells = under_cells(map.radiance.view(), &map.grid, ONE_NODE, &normals);
    Ok(cells + image::irradiance_of_sources(&map.sources, &normals))
}

/// Equations 1 to 3 of Madsen et al. 2003: `R_i = sum_j k_d C L_j (n_i . l_j)` over K sources.
///
/// The sum runs over the sources in front of the probe's surface. `L_j` is the radiance of the
/// source times its solid angle, which the paper leaves to a uniform scale.
///
/// # Inputs
///
/// - `normals`: (n, 3); `directions`: (K, 3), unit vectors.
/// - `radiance`: (K, 3); `solid_angles`: (K,) in steradians.
/// - `k_d`, `colour`: diffuse coefficient and RGB of the probe; both 1 give irradiance.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn sum_over_sources(
    normals: ArrayView2<'_, f64>,
    directions: ArrayView2<'_, f64>,
    radiance: ArrayView2<'_, f64>,
    solid_angles: ArrayView1<'_, f64>,
    k_d: f64,
    colour: [f64; 3],
) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    let directions = unit_vectors("direction", directions)?;
    check_rows("radiance", radiance, 3)?;
    check_rows("solid_angles", solid_angles.insert_axis(Axis(1)), 1)?;
    for (what, seen) in [("radiance", radiance.nrows()), ("solid_angles", solid_angles.len())] {
        let wanted = directions.len();
        if seen != wanted {
            return Err(Error::LengthMismatch { what, other: "directions", wanted, seen });
        }
    }
    let mut out = Array2::zeros((normals.len(), 3));
    out.outer_iter_mut().into_par_iter().zip(&normals).for_each(|(mut row, normal)| {
        for ((direction, source), solid_angle) in directions.iter().zip(radiance.rows()).zip(solid_angles) {
            let cosine = normal.dot(*direction).max(0.0) * solid_angle * k_d;
            for channel in 0..3 {
                row[channel] += colour[channel] * source[channel] * cosine;
            }
        }
    });
    Ok(out)
}

/// Sum of the cells of `radiance`, run by run and batch of normals by batch.
fn under_cells(radiance: ArrayView3<'_, f32>, grid: &Grid, nodes: Nodes, normals: &[DVec3]) -> Array2<f64> {
    let columns = Columns::new(grid);
    let height = radiance.dim().0;
    let runs = (height / ROWS_OF_A_RUN).clamp(1, MOST_RUNS);
    let mut out = Array2::zeros((normals.len(), 3));
    for (mut out, normals) in
        out.axis_chunks_iter_mut(Axis(0), NORMALS_AT_ONCE).zip(normals.chunks(NORMALS_AT_ONCE))
    {
        let normals: Vec<Normal> = normals.iter().map(|&n| Normal::new(n)).collect();
        let sums: Vec<Vec<[f64; 3]>> = (0..runs)
            .into_par_iter()
            .map(|run| {
                let rows = run * height / runs..(run + 1) * height / runs;
                sum_rows(radiance, grid, &columns, nodes, rows, &normals)
            })
            .collect();
        for sums in sums {
            for (mut row, sum) in out.outer_iter_mut().zip(sums) {
                row += &ndarray::aview1(&sum);
            }
        }
    }
    out
}

/// What every look-up in a row needs to know of its columns.
struct Columns<'a> {
    grid: &'a Grid,
    /// cos and sin of the azimuth of each edge.
    edges: Vec<[f64; 2]>,
    /// Integrals of cos phi, sin phi and 1 over each column.
    integrals: Vec<[f64; 3]>,
}

impl<'a> Columns<'a> {
    fn new(grid: &'a Grid) -> Self {
        let edges: Vec<[f64; 2]> = grid.phi_edges.iter().map(|phi| [phi.cos(), phi.sin()]).collect();
        let integrals = grid.phi_edges.windows(2).zip(edges.windows(2));
        let integrals = integrals.map(|(phi, edge)| {
            let ([cos_left, sin_left], [cos_right, sin_right]) = (edge[0], edge[1]);
            [sin_right - sin_left, cos_left - cos_right, phi[1] - phi[0]]
        });
        Self { grid, integrals: integrals.collect(), edges }
    }

    fn of_azimuth(&self, phi: f64) -> usize {
        ((phi * self.grid.columns_per_radian + self.grid.first_column) as usize).min(self.integrals.len() - 1)
    }
}

/// A normal, and where its horizon cuts a row.
struct Normal {
    vector: DVec3,
    azimuth: f64,
    cos_azimuth: f64,
    sin_azimuth: f64,
    /// `-n_y / n_e`: times cot theta it is the cosine of the half-width of the visible interval.
    slope: f64,
}

impl Normal {
    fn new(vector: DVec3) -> Self {
        let equatorial = vector.x.hypot(vector.z).max(f64::MIN_POSITIVE);
        let (_, azimuth) = angles(vector);
        let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
        Self { vector, azimuth, cos_azimuth, sin_azimuth, slope: -vector.y / equatorial }
    }
}

/// Integrals over the azimuths of one row, for three channels: of L cos phi, L sin phi, L.
type Flux = [f64; 9];

/// Sum of the rows `rows` at each normal.
fn sum_rows(
    radiance: ArrayView3<'_, f32>,
    grid: &Grid,
    columns: &Columns<'_>,
    nodes: Nodes,
    rows: std::ops::Range<usize>,
    normals: &[Normal],
) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; normals.len()];
    let mut prefix: Vec<Flux> = vec![[0.0; 9]; columns.integrals.len() + 1];
    for row in rows {
        let samples = radiance.slice(s![row, .., ..]);
        let samples = samples.as_standard_layout();
        let pixels = samples.as_slice().expect("standard layout").as_chunks::<3>().0;
        if pixels.iter().flatten().all(|&value| value == 0.0) {
            continue;
        }
        fill_prefix(&mut prefix, pixels, &columns.integrals);
        let table = RowTable { pixels, prefix: &prefix, columns };
        for slice in slices(grid.theta_edges[row], grid.theta_edges[row + 1], nodes) {
            for (sum, normal) in sums.iter_mut().zip(normals) {
                slice.add_visible(&table, normal, sum);
            }
        }
    }
    sums
}

fn fill_prefix(prefix: &mut [Flux], pixels: &[[f32; 3]], integrals: &[[f64; 3]]) {
    let mut sum = [0.0; 9];
    for ((entry, pixel), integral) in prefix[1..].iter_mut().zip(pixels).zip(integrals) {
        for channel in 0..3 {
            for moment in 0..3 {
                sum[3 * channel + moment] += f64::from(pixel[channel]) * integral[moment];
            }
        }
        *entry = sum;
    }
}

/// One row's pixels and the prefix sums over them.
struct RowTable<'a> {
    pixels: &'a [[f32; 3]],
    prefix: &'a [Flux],
    columns: &'a Columns<'a>,
}

impl RowTable<'_> {
    fn total(&self) -> &Flux {
        &self.prefix[self.prefix.len() - 1]
    }

    /// Flux between the seam and the azimuth `phi`; the pixel that it cuts counts in part.
    #[inline]
    fn up_to(&self, phi: f64, cos_phi: f64, sin_phi: f64) -> Flux {
        let column = self.columns.of_azimuth(phi);
        let [cos_edge, sin_edge] = self.columns.edges[column];
        let part = [sin_phi - sin_edge, cos_edge - cos_phi, phi - self.columns.grid.phi_edges[column]];
        let mut flux = self.prefix[column];
        for channel in 0..3 {
            for moment in 0..3 {
                flux[3 * channel + moment] += f64::from(self.pixels[column][channel]) * part[moment];
            }
        }
        flux
    }

    /// Flux of the interval of half-width `acos(c)` around the normal's azimuth.
    #[inline]
    fn between(&self, normal: &Normal, c: f64) -> Flux {
        let (half_width, s) = (c.acos(), (1.0 - c * c).sqrt());
        let (cos_n, sin_n) = (normal.cos_azimuth, normal.sin_azimuth);
        let (start, end) = (normal.azimuth - half_width, normal.azimuth + half_width);
        let over_the_seam = start < 0.0 || end >= TAU;
        let wrap = |phi: f64| {
            if phi < 0.0 {
                phi + TAU
            } else if phi >= TAU {
                phi - TAU
            } else {
                phi
            }
        };
        let first = self.up_to(wrap(start), cos_n * c + sin_n * s, sin_n * c - cos_n * s);
        let mut flux = self.up_to(wrap(end), cos_n * c - sin_n * s, sin_n * c + cos_n * s);
        let around = if over_the_seam { self.total() } else { &[0.0; 9] };
        for ((flux, first), around) in flux.iter_mut().zip(first).zip(around) {
            *flux += around - first;
        }
        flux
    }
}

/// A node of a row: the latitude at which its horizon is taken, and its share of the row.
struct Slice {
    cot_theta: f64,
    /// Share of the integral of sin^2 theta over the row.
    equatorial: f64,
    /// Share of the integral of sin theta cos theta over the row.
    polar: f64,
}

/// The row between two polar angles at the given nodes, scaled so that their sum is exact:
///
/// ```text
///   integral of sin^2 theta         = (dtheta - cos(t0 + t1) sin(dtheta)) / 2
///   integral of sin theta cos theta = sin(t0 + t1) sin(dtheta) / 2
/// ```
fn slices(top: f64, bottom: f64, nodes: Nodes) -> Vec<Slice> {
    let (sum, difference) = (top + bottom, bottom - top);
    let equatorial = 0.5 * (difference - sum.cos() * difference.sin());
    let polar = 0.5 * sum.sin() * difference.sin();
    let angles: Vec<f64> = nodes.iter().map(|(node, _)| 0.5 * (sum + node * difference)).collect();
    let weigh = |f: fn(f64) -> f64| -> f64 { angles.iter().zip(nodes).map(|(&t, (_, w))| w * f(t)).sum() };
    let sin_squared = weigh(|theta| theta.sin().powi(2));
    angles
        .iter()
        .zip(nodes)
        .map(|(theta, (_, weight))| Slice {
            cot_theta: theta.cos() / theta.sin(),
            equatorial: equatorial * weight * theta.sin().powi(2) / sin_squared,
            // sin theta cos theta changes its sign at the equator, where a quotient of sums would
            // divide by 0; the ratio of the two exact integrals to their node values is the same to O(h^2).
            polar: if nodes.len() == 1 {
                polar
            } else {
                0.5 * difference * weight * theta.sin() * theta.cos()
            },
        })
        .collect()
}

impl Slice {
    /// Add what `normal` sees of this slice to `sum`.
    #[inline]
    fn add_visible(&self, row: &RowTable<'_>, normal: &Normal, sum: &mut [f64; 3]) {
        let c = normal.slope * self.cot_theta;
        if c >= 1.0 {
            return;
        }
        let flux = if c <= -1.0 { *row.total() } else { row.between(normal, c) };
        let n = normal.vector;
        for channel in 0..3 {
            let [cos, sin, one] = [flux[3 * channel], flux[3 * channel + 1], flux[3 * channel + 2]];
            sum[channel] += self.equatorial * (n.x * sin - n.z * cos) + self.polar * n.y * one;
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::{sampling, sphere};
    use ndarray::Array3;
    use std::f64::consts::PI;

    fn largest_difference_from_pi(height: usize, registration: Registration) -> f64 {
        let sky = Array3::from_elem((height, 2 * height, 3), 1.0_f32);
        let (normals, _) = sampling::icosphere(320).unwrap();
        let seen = irradiance(sky.view(), registration, normals.view()).unwrap();
        seen.iter().map(|value| (value / PI - 1.0).abs()).fold(0.0, f64::max)
    }

    /// White furnace: under a constant sky of radiance L, every surface receives exactly pi L.
    #[test]
    fn constant_sky_gives_pi() {
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            for (height, bound) in [(64, 1e-5), (256, 1e-6), (512, 3e-7), (1024, 1e-7)] {
                let difference = largest_difference_from_pi(height, registration);
                assert!(difference < bound, "{height} rows, {registration:?}: {difference:e} from pi");
            }
        }
    }

    /// Two ways to one number: whole pixels by intervals, pixel centres one by one.
    #[test]
    fn intervals_agree_with_the_sum_over_pixels() {
        let map = Array3::from_shape_fn((256, 512, 3), |(y, x, c)| {
            1.0 + ((y / 16 * 5 + x / 16 * 3 + c) % 7) as f32
        });
        let (normals, _) = sampling::icosphere(80).unwrap();
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let intervals = irradiance(map.view(), registration, normals.view()).unwrap();
            let directions = sphere::pixel_directions(256, 512, registration).unwrap();
            let solid_angles = sphere::pixel_solid_angles(256, 512, registration).unwrap();
            let sum = sum_over_sources(
                normals.view(),
                directions.to_shape((256 * 512, 3)).unwrap().view(),
                map.mapv(f64::from).to_shape((256 * 512, 3)).unwrap().view(),
                solid_angles.flatten().view(),
                1.0,
                [1.0; 3],
            )
            .unwrap();
            let difference =
                (&intervals - &sum).mapv(|x| x * x).sum().sqrt() / sum.mapv(|x| x * x).sum().sqrt();
            assert!(difference < 5e-5, "{registration:?}: {difference:e}");
        }
    }
}
