//! Irradiance of a white probe under a map.
//!
//! ```text
//!   E(n) = integral over the sphere of L(w) max(0, n.w) dw
//! ```
//!
//! In front of the normal the integrand is *linear* in w, so only the vector flux of that half of the
//! sphere counts. In one row (theta fixed) the part in front is one interval of azimuths around the
//! normal's own azimuth `phi_n`:
//!
//! ```text
//!   n.w = n_y cos theta + n_e sin theta cos(phi - phi_n) > 0      n_e = length of (n_x, n_z)
//!     <=>  cos(phi - phi_n) > c,   c = -(n_y / n_e) cot theta
//! ```
//!
//! all of the row for c <= -1, nothing for c >= 1, else `phi_n -+ acos c`. Prefix sums over the
//! columns of `L (integral of cos phi, sin phi, 1)` give the flux of any interval from two look-ups:
//! O(pixels + normals x rows) instead of O(pixels x normals). Pixels are integrated
//! exactly, while a sum over their centres replaces each by one direction.
//!
//! | step                                    | file          |
//! |-----------------------------------------|---------------|
//! | normals that need a separate sum        | `opposite.rs` |
//! | sums over a few columns of a row or two | `rows.rs`     |
//! | limits of radiance for sums in f32      | `bright.rs`   |
//! | flux of a band of rows up to an azimuth | `band.rs`     |
//! | the part of a band before a normal      | `horizon.rs`  |
//! | the same for many normals, few cells    | `table.rs`    |
//! | lights that are points                  | `sources.rs`  |

mod band;
mod bright;
mod horizon;
mod opposite;
mod rows;
mod sources;
mod table;

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2, ArrayView3, Axis};
use rayon::prelude::*;

use super::image::{self, Grid, WorkingMap};
use super::sphere::{self, Registration, check_lengths, check_rows, unit_vectors};
use crate::error::{Error, Result};
use crate::interrupt;
use band::{BlockColumns, HorizonBand};
use bright::Limits;
use horizon::{Normal, ROWS_OF_A_RUN, Steps};
use opposite::VectorFlux;
use sources::under_sources;

/// Largest number of runs of rows. They do not depend on the number of threads, so the result has the same bits.
const MOST_RUNS: usize = 64;
/// Normals of one pass over the map; limits the memory of the runs' sums.
const NORMALS_AT_ONCE: usize = 4096;

/// Exact irradiance, (n, 3), of a map of radiance at `normals`, (n, 3).
///
/// The horizon is curved within a row: with the row's middle latitude alone, a constant map has an error of 2.4e-4 at 64
/// rows and of 8e-7 at 1024. A few Gauss nodes in theta remove it for maps of few rows; their numbers are the smallest
/// that pass the constant-map tests below. From 2048 rows on, bands
/// of several rows share a horizon: a constant map then has an error of 8e-7. Fewer than 64 rows are cut into strips: the
/// result is within 1e-4 of the exact integral over the cells, down to 2 rows.
///
/// Light behind the horizon adds only rounding, at most 1e-15 of its flux. So the irradiance on the dark side of a sun has
/// a relative error of 1e-6 at most, for suns of up to 1e9 times the radiance of the room.
///
/// # Inputs
///
/// - `radiance`: (height, width, 3), linear RGB, not negative.
/// - `normals`: (n, 3), unit vectors, in the frame of [`super::sphere`].
///
/// # Errors
///
/// [`Error::NotAMap`], [`Error::UnusableSamples`], [`Error::TooBright`]; for normals [`Error::WrongColumns`],
/// [`Error::NotFinite`], [`Error::NotUnit`].
pub fn irradiance(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    normals: ArrayView2<'_, f64>,
) -> Result<Array2<f64>> {
    image::check_rgb(radiance)?;
    let normals = unit_vectors("normal", normals)?;
    let (height, width, _) = radiance.dim();
    under_cells(radiance, &Grid::of_pixels(height, width, registration), Steps::of(height), &normals)
}

/// Irradiance, (n, 3), under a reduced map and its sources.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`],
/// [`Error::TooBright`].
pub fn working_irradiance(map: &WorkingMap, normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    // Leave out normals whose opposite is present; the axes determine the flux of the table.
    let pairs = opposite::pairs(&unit_vectors("normal", normals)?);
    let evaluated = [pairs.distinct.as_slice(), &opposite::AXES].concat();
    // Add up cells and sources.
    let cells = table::under_cells(map, &evaluated)?;
    let sources = under_sources(&map.source_vectors(), &evaluated);
    let irradiance: Vec<DVec3> = cells.iter().zip(sources).map(|(cells, sources)| cells + sources).collect();
    // Restore the opposites.
    let (distinct, axes) = irradiance.split_at(pairs.distinct.len());
    let flux = opposite::flux_of_axes(axes);
    Ok(sphere::from_vectors(pairs.restore(distinct, &flux).into_iter()))
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
    let lengths = [("radiance", radiance.nrows()), ("solid_angles", solid_angles.len())];
    check_lengths("directions", directions.len(), lengths)?;
    let mut out = Array2::zeros((normals.len(), 3));
    let min_len = interrupt::min_task_len(normals.len());
    let rows = out.outer_iter_mut().into_par_iter().zip(&normals).with_min_len(min_len);
    rows.for_each(|(mut row, normal)| {
        interrupt::check();
        for ((direction, source), solid_angle) in directions.iter().zip(radiance.rows()).zip(solid_angles) {
            let cosine = normal.dot(*direction).max(0.0) * solid_angle * k_d;
            for channel in 0..3 {
                row[channel] += colour[channel] * source[channel] * cosine;
            }
        }
    });
    Ok(out)
}

/// Sum of the cells of `radiance`, batch of normals by batch.
fn under_cells(
    radiance: ArrayView3<'_, f32>,
    grid: &Grid,
    steps: Steps,
    normals: &[DVec3],
) -> Result<Array2<f64>> {
    // Read the map as rows of pixels.
    let samples = radiance.as_standard_layout();
    let pixels = samples.as_slice().expect("standard layout").as_chunks::<3>().0;
    let rows: Vec<&[[f32; 3]]> = pixels.chunks(radiance.dim().1).collect();
    let columns = BlockColumns::new(grid, Limits::of(&rows));
    let sum = |normals: &[DVec3]| sum_batches(&rows, grid, &columns, steps, normals);
    // Leave out normals whose opposite is present.
    let pairs = opposite::pairs(normals);
    let sums = sum(&pairs.distinct);
    // Report the sample that made a sum infinite or NaN, if there is one.
    if !sums.irradiance.iter().chain(&sums.flux).all(|sum| sum.is_finite()) {
        image::check_samples(radiance)?;
        return Err(Error::TooBright);
    }
    // Restore the opposites; repeat the sum if a difference is mostly rounding.
    let mut irradiance = pairs.restore(&sums.irradiance, &sums.flux);
    let repeated = opposite::rounding_only(&irradiance, &sums.flux);
    let normals: Vec<DVec3> = repeated.iter().map(|&i| normals[i]).collect();
    for (i, sum) in repeated.into_iter().zip(sum(&normals).irradiance) {
        irradiance[i] = sum.max(DVec3::ZERO);
    }
    Ok(sphere::from_vectors(irradiance.into_iter()))
}

/// Irradiance at some normals, and the vector flux of the summed rows.
struct PartialIrradiance {
    irradiance: Vec<DVec3>,
    flux: VectorFlux,
}

impl PartialIrradiance {
    fn new(normals: usize) -> Self {
        Self { irradiance: vec![DVec3::ZERO; normals], flux: [DVec3::ZERO; 3] }
    }

    fn plus(mut self, other: Self) -> Self {
        let theirs = other.irradiance.into_iter().chain(other.flux);
        for (sum, term) in self.irradiance.iter_mut().chain(&mut self.flux).zip(theirs) {
            *sum += term;
        }
        self
    }
}

/// Sum of all rows at each normal, a batch of normals at a time; each batch has the same flux.
fn sum_batches(
    rows: &[&[[f32; 3]]],
    grid: &Grid,
    columns: &BlockColumns<'_>,
    steps: Steps,
    normals: &[DVec3],
) -> PartialIrradiance {
    let mut sums = PartialIrradiance::new(0);
    for normals in normals.chunks(NORMALS_AT_ONCE) {
        let normals: Vec<Normal> = normals.iter().map(|&n| Normal::new(n)).collect();
        let batch = sum_rows(rows, grid, columns, steps, &normals);
        sums.irradiance.extend(batch.irradiance);
        sums.flux = batch.flux;
    }
    sums
}

/// Sum of all rows at each normal, run by run.
fn sum_rows(
    rows: &[&[[f32; 3]]],
    grid: &Grid,
    columns: &BlockColumns<'_>,
    steps: Steps,
    normals: &[Normal],
) -> PartialIrradiance {
    let runs = (rows.len() / ROWS_OF_A_RUN).clamp(1, MOST_RUNS);
    let sums: Vec<PartialIrradiance> = (0..runs)
        .into_par_iter()
        .map_init(
            || HorizonBand::new(columns),
            |band, run| {
                let (first, last) = (run * rows.len() / runs, (run + 1) * rows.len() / runs);
                sum_run(band, &rows[first..last], &grid.theta_edges[first..=last], steps, normals)
            },
        )
        .collect();
    sums.into_iter().fold(PartialIrradiance::new(normals.len()), PartialIrradiance::plus)
}

/// Sum of a run of rows at each normal, band by band.
fn sum_run<'a>(
    band: &mut HorizonBand<'a>,
    rows: &[&'a [[f32; 3]]],
    theta_edges: &[f64],
    steps: Steps,
    normals: &[Normal],
) -> PartialIrradiance {
    let mut sums = PartialIrradiance::new(normals.len());
    let mut half_widths = Vec::with_capacity(normals.len());
    for (i, rows) in rows.chunks(steps.rows).enumerate() {
        interrupt::check();
        // Skip black bands.
        if rows.iter().all(|row| row.as_flattened().iter().all(|&sample| sample == 0.0)) {
            continue;
        }
        // Compute the prefix sums of the band over its columns.
        let (weights, slices) = horizon::cut(&theta_edges[i * steps.rows..][..=rows.len()], steps);
        band.set(rows, &weights);
        for slice in slices {
            // Add the flux of the whole band.
            slice.add_whole(band, &mut sums.flux);
            // Compute all half-widths before the first look-up, so that it does not wait for them.
            half_widths.clear();
            half_widths.extend(normals.iter().map(|normal| normal.half_width(&slice)));
            // Add the visible part of the band for each normal.
            for ((sum, normal), &half_width) in sums.irradiance.iter_mut().zip(normals).zip(&half_widths) {
                *sum += slice.irradiance(normal, half_width, band);
            }
        }
    }
    sums
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sampling;
    use ndarray::Array3;

    /// A single normal has its own sum; one of two opposite normals has none.
    #[test]
    fn opposite_normals_have_the_irradiance_of_single_ones() {
        let map = Array3::from_shape_fn((64, 128, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        let (normals, _) = sampling::icosphere(80).unwrap();
        let together = irradiance(map.view(), Registration::CellCentred, normals.view()).unwrap();
        for (normal, together) in normals.axis_chunks_iter(Axis(0), 1).zip(together.rows()) {
            let alone = irradiance(map.view(), Registration::CellCentred, normal).unwrap();
            for (together, alone) in together.iter().zip(&alone) {
                assert!(
                    (together / alone - 1.0).abs() < 1e-12,
                    "{normal}: {together} with the others, {alone} alone"
                );
            }
        }
    }
}
