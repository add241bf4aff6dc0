//! Irradiance under a working map: few cells, many normals.
//!
//! Prefix sums as in `band.rs`, but for every column, in single precision. Between two columns, `d` radians apart, the
//! flux is linear. The irradiance from it is quadratic: at the horizon of the normal the cosine falls to 0, with the
//! derivative `k = |weights| sin(half-width)`. If the horizon cuts a cell at the fraction s of its width, it gets
//!
//! ```text
//!   L k (s d)^2 / 2  =  s L k d^2 (s - 1/2)  +  L k d^2 s (1 - s) / 2
//!   irradiance          linear part             quadratic part
//! ```
//!
//! A look-up costs less than two thirds of one in `band.rs`, which matters if there are more look-ups than cells.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use std::f64::consts::TAU;

use glam::{DVec3, Vec4};
use ndarray::Axis;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use wide::f32x8;

use super::horizon::{Normal, ROWS_OF_A_RUN, Slice, Steps, cut};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::image::{Grid, WorkingMap};

/// Integrals of L cos phi, L sin phi and L from the seam, for three channels.
type Flux = [Vec4; 3];

/// The flux of a row up to each edge of its columns.
struct Table<'a> {
    map: &'a WorkingMap,
    columns: &'a ColumnEdges,
    prefix: Vec<Flux>,
    /// Half the width of the part of the row in front of each normal.
    half_widths: Vec<f32>,
}

/// Columns of a map of few cells; all rows share them.
struct ColumnEdges {
    /// cos and sin of each edge.
    edges: Vec<[f64; 2]>,
    /// Left edge of each column, and one over its width.
    left_edges: Vec<[f32; 2]>,
    /// Columns per radian, and the column of the azimuth 0.
    per_radian: f32,
    first: f32,
}

impl ColumnEdges {
    fn new(grid: &Grid) -> Self {
        let phi = &grid.phi_edges;
        let left_edge = |edge: &[f64]| [edge[0] as f32, (1.0 / (edge[1] - edge[0])) as f32];
        Self {
            edges: phi.iter().map(|phi| [phi.cos(), phi.sin()]).collect(),
            left_edges: phi.windows(2).map(left_edge).collect(),
            per_radian: grid.columns_per_radian as f32,
            first: grid.first_column as f32,
        }
    }
}

/// Irradiance at `normals` of the cells of `map`, without its sources.
pub fn under_cells(map: &WorkingMap, normals: &[DVec3]) -> Result<Vec<DVec3>> {
    // Prepare the columns, which all rows share.
    let normals: Vec<Normal> = normals.iter().map(|&n| Normal::new(n)).collect();
    let columns = ColumnEdges::new(&map.grid);
    let rows: Vec<usize> = (0..map.radiance.dim().0).collect();
    // Sum some rows in each task.
    let sums: Vec<Vec<DVec3>> = rows
        .par_chunks(ROWS_OF_A_RUN)
        .map(|rows| {
            let mut table = Table { map, columns: &columns, prefix: Vec::new(), half_widths: Vec::new() };
            let mut sums = vec![DVec3::ZERO; normals.len()];
            for &row in rows {
                table.add_row(row, &normals, &mut sums);
            }
            sums
        })
        .collect();
    // Add up the tasks in their order.
    let sum = |i: usize| sums.iter().fold(DVec3::ZERO, |sum, part| sum + part[i]);
    let irradiance: Vec<DVec3> = (0..normals.len()).map(sum).collect();
    if !irradiance.iter().all(|sum| sum.is_finite()) {
        return Err(Error::TooBright);
    }
    Ok(irradiance.into_iter().map(|sum| sum.max(DVec3::ZERO)).collect())
}

impl Table<'_> {
    fn add_row(&mut self, row: usize, normals: &[Normal], sums: &mut [DVec3]) {
        if self.map.radiance.index_axis(Axis(0), row).iter().all(|&sample| sample == 0.0) {
            return;
        }
        self.fill(row);
        let (_, slices) = cut(&self.map.grid.theta_edges[row..=row + 1], Steps::ONE_NODE);
        for slice in slices {
            interrupt::check();
            Arch::new().dispatch(LookUps { table: self, slice, normals, sums });
        }
    }

    /// Fill the prefix sums of a row: f64 while they grow, stored as f32.
    fn fill(&mut self, row: usize) {
        let phi = &self.map.grid.phi_edges;
        let mut sum = [DVec3::ZERO; 3];
        self.prefix.clear();
        self.prefix.push(sum.map(single));
        for (column, pixel) in self.map.radiance.index_axis(Axis(0), row).outer_iter().enumerate() {
            let pixel = DVec3::new(f64::from(pixel[0]), f64::from(pixel[1]), f64::from(pixel[2]));
            let ([cos_left, sin_left], [cos_right, sin_right]) =
                (self.columns.edges[column], self.columns.edges[column + 1]);
            sum[0] += pixel * (sin_right - sin_left);
            sum[1] += pixel * (cos_left - cos_right);
            sum[2] += pixel * (phi[column + 1] - phi[column]);
            self.prefix.push(sum.map(single));
        }
    }

    /// Irradiance at `normal` from the visible interval of the row, `half_width` to both sides.
    #[inline(always)]
    fn irradiance(&self, normal: &Normal, half_width: f32, slice: &Slice) -> DVec3 {
        // Find the flux in front of the normal, and the quadratic part at its horizon.
        let c = normal.cosine(slice);
        let (flux, quadratic) = if c >= 1.0 {
            return DVec3::ZERO;
        } else if c <= -1.0 {
            (self.prefix[self.prefix.len() - 1], Vec4::ZERO)
        } else {
            self.around(normal.azimuth as f32, half_width)
        };
        // Weight both for the normal.
        let [x, y, one] = normal.weights(slice).as_vec3().to_array();
        let derivative = ((x * x + y * y) * (1.0 - c * c).max(0.0) as f32).sqrt();
        (flux[0] * x + flux[1] * y + flux[2] * one + quadratic * derivative).truncate().as_dvec3()
    }

    /// Flux of the interval of `half_width` around `azimuth`, and the quadratic parts at its ends.
    #[inline(always)]
    fn around(&self, azimuth: f32, half_width: f32) -> (Flux, Vec4) {
        let turn = TAU as f32;
        let (start, end) = (azimuth - half_width, azimuth + half_width);
        let (first, first_quadratic) = self.up_to(if start < 0.0 { start + turn } else { start });
        let (last, last_quadratic) = self.up_to(if end >= turn { end - turn } else { end });
        let between = [last[0] - first[0], last[1] - first[1], last[2] - first[2]];
        let quadratic = first_quadratic + last_quadratic;
        if start >= 0.0 && end < turn {
            return (between, quadratic);
        }
        let [cos, sin, one] = self.prefix[self.prefix.len() - 1];
        ([between[0] + cos, between[1] + sin, between[2] + one], quadratic)
    }

    /// Flux between the seam and the azimuth `phi`, and the quadratic part there for a derivative of 1.
    #[inline(always)]
    fn up_to(&self, phi: f32) -> (Flux, Vec4) {
        let ColumnEdges { left_edges, per_radian, first, .. } = self.columns;
        let column = ((phi * per_radian + first) as u32 as usize).min(left_edges.len() - 1);
        let [left, per_width] = left_edges[column];
        let fraction = ((phi - left) * per_width).clamp(0.0, 1.0);
        let (before, after) = (&self.prefix[column], &self.prefix[column + 1]);
        let linear = [0, 1, 2].map(|i| before[i] + (after[i] - before[i]) * fraction);
        (linear, (after[2] - before[2]) * (0.5 * fraction * (1.0 - fraction) / per_width))
    }
}

/// Addition of the irradiance from a slice of a row to the sum of each normal.
struct LookUps<'a, 'b> {
    table: &'a mut Table<'b>,
    slice: Slice,
    normals: &'a [Normal],
    sums: &'a mut [DVec3],
}

impl WithSimd for LookUps<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { table, slice, normals, sums } = self;
        // Find all half-widths before the first look-up, which then need not wait.
        table.half_widths.resize(normals.len(), 0.0);
        let mut cosines = [0.0; 8];
        for (half_widths, normals) in table.half_widths.chunks_mut(8).zip(normals.chunks(8)) {
            for (cosine, normal) in cosines.iter_mut().zip(normals) {
                *cosine = (normal.cosine(&slice) as f32).clamp(-1.0, 1.0);
            }
            half_widths.copy_from_slice(&f32x8::from(cosines).acos().as_array()[..normals.len()]);
        }
        // Look up and add.
        for ((sum, normal), &half_width) in sums.iter_mut().zip(normals).zip(&table.half_widths) {
            *sum += table.irradiance(normal, half_width, &slice);
        }
    }
}

fn single(flux: DVec3) -> Vec4 {
    flux.as_vec3().extend(0.0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::{self, Registration};
    use crate::kernels::{fit, image};
    use ndarray::Array3;

    /// The exact look-ups on the same cells are the reference.
    #[test]
    fn linear_flux_between_columns_is_near_the_exact_sum() {
        let wave = |y: usize, x: usize| ((0.1 * x as f64).sin() + (0.2 * y as f64).cos() + 2.0) as f32;
        let map = Array3::from_shape_fn((64, 128, 3), |(y, x, c)| wave(y, x) * (c + 1) as f32);
        let (normals, weights) = sampling::icosphere(1280).unwrap();
        let directions = sphere::to_vectors(normals.view());
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let working = image::reduce(map.view(), registration, 128, 1.0, false).unwrap();
            let near = sphere::from_vectors(under_cells(&working, &directions).unwrap().into_iter());
            let cells = working.radiance.view();
            let exact =
                super::super::under_cells(cells, &working.grid, Steps::ONE_NODE, &directions).unwrap();
            let error = fit::relative_rms(near.view(), exact.view(), weights.view()).unwrap();
            assert!(error < 2e-6, "{registration:?}: {error:e}");
        }
    }
}
