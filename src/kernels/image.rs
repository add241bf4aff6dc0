//! What the map holds before anything is made of it: unusable samples, and a smaller working map.

use std::ops::Range;

use ndarray::{Array3, ArrayView3, ArrayViewMut2, s};
use rayon::prelude::*;

use super::sphere::{Registration, band_heights, direction};
use crate::error::{Error, Result};

/// Samples that no light can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unusable {
    /// Not a number.
    pub nan: usize,
    /// Positive infinity.
    pub infinite: usize,
    /// Below zero, negative infinity among them.
    pub negative: usize,
}

/// How many samples of `radiance` are NaN, infinite or negative.
///
/// The bits of a finite `f32` that is not negative, read as `i32`, lie in `0 ..= 0x7f7f_ffff`:
/// one OR over a row tells whether it needs a closer look. (So does -0.0, which then counts as 0.)
///
/// # Errors
///
/// [`Error::NotAMap`] when the array is not (height, width, 3).
pub fn unusable(radiance: ArrayView3<'_, f32>) -> Result<Unusable> {
    check_rgb(radiance)?;
    let rows: Vec<Unusable> = radiance
        .outer_iter()
        .into_par_iter()
        .map(|row| match row.as_slice() {
            Some(samples) if all_usable(samples) => Unusable::default(),
            _ => row.iter().fold(Unusable::default(), |seen, &value| seen.and(value)),
        })
        .collect();
    Ok(rows.into_iter().fold(Unusable::default(), Unusable::plus))
}

fn all_usable(samples: &[f32]) -> bool {
    const LARGEST_FINITE: i32 = 0x7f7f_ffff;
    let sign = samples.iter().fold(0_i32, |seen, sample| {
        let bits = sample.to_bits().cast_signed();
        seen | bits | LARGEST_FINITE.wrapping_sub(bits)
    });
    sign >= 0
}

impl Unusable {
    fn and(mut self, value: f32) -> Self {
        self.nan += usize::from(value.is_nan());
        self.infinite += usize::from(value == f32::INFINITY);
        self.negative += usize::from(value < 0.0);
        self
    }

    fn plus(self, other: Self) -> Self {
        Self {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
            negative: self.negative + other.negative,
        }
    }
}

/// The lines that cut the sphere into the cells of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Polar angles between the rows, from 0 to pi.
    pub theta_edges: Vec<f64>,
    /// Azimuths between the columns, from 0 to 2 pi.
    pub phi_edges: Vec<f64>,
    /// Column of the azimuth phi: the whole part of `phi * columns_per_radian + first_column`.
    pub columns_per_radian: f64,
    /// 0, or half a column where the first column is cut by the seam.
    pub first_column: f64,
}

impl Grid {
    /// Every pixel a cell.
    pub fn of_pixels(height: usize, width: usize, registration: Registration) -> Self {
        let (columns, first_column) = match registration {
            Registration::CellCentred => (width as f64, 0.0),
            Registration::BorderSampled => ((width - 1) as f64, 0.5),
        };
        Self {
            theta_edges: registration.theta_edges(height),
            phi_edges: registration.phi_edges(width),
            columns_per_radian: columns / std::f64::consts::TAU,
            first_column,
        }
    }

    /// Every `block` x `block` pixels a cell; what is left over at the far edges makes smaller ones.
    pub(crate) fn in_blocks(&self, block: usize) -> Self {
        let every = |edges: &[f64]| {
            let mut kept: Vec<f64> = edges[..edges.len() - 1].iter().copied().step_by(block).collect();
            kept.extend(edges.last());
            kept
        };
        Self {
            theta_edges: every(&self.theta_edges),
            phi_edges: every(&self.phi_edges),
            columns_per_radian: self.columns_per_radian / block as f64,
            first_column: self.first_column / block as f64,
        }
    }
}

/// A map in fewer cells, for probes that need not be exact.
#[derive(Clone, Debug)]
pub struct WorkingMap {
    /// Mean radiance of each cell by solid angle, (rows, columns, 3); 0 where the cell became a source.
    pub radiance: Array3<f32>,
    /// Where the cells lie.
    pub grid: Grid,
    /// Vector irradiance of the cells that became sources, (n, 3 axes, 3 channels).
    pub sources: Array3<f64>,
}

/// `radiance` reduced to at most `columns` columns, its bright cells kept as point sources.
///
/// A cell that the horizon of a normal cuts is smeared by its width, which matters only where one
/// cell holds much light. So each cell with more than `source_share` of the flux of any channel
/// is taken out and kept as the vector `F = integral of L w dw` over its pixels: `max(0, n.F)` is
/// exact for a sun of one pixel wherever it stands in its cell.
///
/// # Errors
///
/// [`Error::NotAMap`] when the array is not (height, width, 3) or smaller than 2 x 2;
/// [`Error::NotFinite`] and [`Error::Negative`] for samples that no light can have: this pass sees them all;
/// [`Error::OutOfRange`] for a share below zero.
pub fn reduce(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    columns: usize,
    source_share: f64,
) -> Result<WorkingMap> {
    check_rgb(radiance)?;
    if source_share.is_nan() || source_share < 0.0 {
        let (what, value) = ("source_share", source_share);
        return Err(Error::OutOfRange { what, value, least: 0.0, most: f64::INFINITY });
    }
    let (height, width, _) = radiance.dim();
    let pixels = Grid::of_pixels(height, width, registration);
    let block = width.div_ceil(columns.max(1)).max(1);
    let grid = pixels.in_blocks(block);
    let mut flux = block_flux(radiance, &pixels, block)?;
    let cells = bright_cells(&flux, source_share);
    let sources: Vec<[[f64; 3]; 3]> =
        cells.iter().map(|&(row, column)| vector_irradiance(radiance, &pixels, block, row, column)).collect();
    for &(row, column) in &cells {
        flux.slice_mut(s![row, column, ..]).fill(0.0);
    }
    Ok(WorkingMap {
        radiance: mean_radiance(&flux, &grid),
        grid,
        sources: Array3::from_shape_fn((cells.len(), 3, 3), |(i, axis, channel)| sources[i][axis][channel]),
    })
}

/// Pixels of a row that are summed at once: few enough to stay near, many enough to be read in a stream.
const PIXELS_AT_ONCE: usize = 512;

/// Integral of the radiance over each block, (rows, columns, 3).
fn block_flux(radiance: ArrayView3<'_, f32>, pixels: &Grid, block: usize) -> Result<Array3<f64>> {
    let (height, width, _) = radiance.dim();
    let widths: Vec<f64> = pixels.phi_edges.windows(2).map(|edge| edge[1] - edge[0]).collect();
    let mut flux = Array3::zeros((height.div_ceil(block), width.div_ceil(block), 3));
    let signs: Vec<bool> = flux
        .outer_iter_mut()
        .into_par_iter()
        .enumerate()
        .map(|(cell_row, cells)| {
            let rows = cell_row * block..((cell_row + 1) * block).min(height);
            let bands = band_heights(&pixels.theta_edges[rows.start..=rows.end]);
            let samples = radiance.slice(s![rows, .., ..]);
            let samples = samples.as_standard_layout();
            let samples = samples.as_slice().unwrap_or(&[]); // the standard layout is a slice
            add_rows(cells, &samples.chunks_exact(3 * width).collect::<Vec<_>>(), &bands, &widths, block)
        })
        .collect();
    if signs.contains(&true) || !flux.iter().all(|value| value.is_finite()) {
        check_samples(radiance)?;
    }
    Ok(flux)
}

/// Sum rows of pixels of these `bands` and `widths` into the cells that they make. Whether a sample
/// has a minus sign is seen on the way.
fn add_rows(
    mut cells: ArrayViewMut2<'_, f64>,
    rows: &[&[f32]],
    bands: &[f64],
    widths: &[f64],
    block: usize,
) -> bool {
    let whole: f64 = bands.iter().sum();
    let weights: Vec<f32> = bands.iter().map(|band| (band / whole) as f32).collect();
    let at_once = (PIXELS_AT_ONCE / block).max(1) * block;
    let mut mean = vec![0.0; 3 * at_once];
    let mut signs = false;
    let mut cells = cells.outer_iter_mut();
    for (i, widths) in widths.chunks(at_once).enumerate() {
        let mean = &mut mean[..3 * widths.len()];
        signs |= weighted_mean(rows, &weights, 3 * i * at_once..3 * (i * at_once + widths.len()), mean);
        let pixels = mean.as_chunks::<3>().0;
        for ((pixels, widths), mut cell) in pixels.chunks(block).zip(widths.chunks(block)).zip(&mut cells) {
            for (pixel, width) in pixels.iter().zip(widths) {
                for (cell, value) in cell.iter_mut().zip(pixel) {
                    *cell += f64::from(*value) * width * whole;
                }
            }
        }
    }
    signs
}

/// Mean of the `columns` of some rows, four rows at a time: fewer passes over what is summed. Whether
/// a sample has a minus sign is seen on the way.
pub(crate) fn weighted_mean(
    rows: &[&[f32]],
    weights: &[f32],
    columns: Range<usize>,
    mean: &mut [f32],
) -> bool {
    let mut bits = 0;
    let (fours, rest) = rows.as_chunks::<4>();
    for (i, (rows, weights)) in fours.iter().zip(weights.as_chunks::<4>().0).enumerate() {
        let rows = rows.map(|row| &row[columns.clone()]);
        bits |= if i == 0 {
            add_four::<true>(rows, weights, mean)
        } else {
            add_four::<false>(rows, weights, mean)
        };
    }
    if fours.is_empty() {
        mean.fill(0.0);
    }
    for (row, weight) in rest.iter().zip(&weights[4 * fours.len()..]) {
        for (mean, sample) in mean.iter_mut().zip(&row[columns.clone()]) {
            *mean += weight * sample;
            bits |= sample.to_bits();
        }
    }
    bits >> 31 == 1
}

/// Add four weighted rows to `mean`, or set it to their sum if they are the `FIRST`; the bits of all samples.
#[inline]
fn add_four<const FIRST: bool>([a, b, c, d]: [&[f32]; 4], weights: &[f32; 4], mean: &mut [f32]) -> u32 {
    let mut bits = 0;
    for ((((mean, a), b), c), d) in mean.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let before = if FIRST { 0.0 } else { *mean };
        *mean = before + ((weights[0] * a + weights[1] * b) + (weights[2] * c + weights[3] * d));
        bits |= (a.to_bits() | b.to_bits()) | (c.to_bits() | d.to_bits());
    }
    bits
}

/// Refuse the first sample that no light can have: a slow look, where a sum or a sign has shown that there
/// may be one. A minus sign may be that of -0, which is as good as 0.
pub(crate) fn check_samples(radiance: ArrayView3<'_, f32>) -> Result<()> {
    let what = "radiance";
    for (index, row) in radiance.outer_iter().enumerate() {
        match row.iter().find(|value| !value.is_finite() || **value < 0.0).map(|&value| f64::from(value)) {
            Some(value) if value.is_finite() => return Err(Error::Negative { what, index, value }),
            Some(value) => return Err(Error::NotFinite { what, index, value }),
            None => {}
        }
    }
    Ok(())
}

/// Cells that hold more than `share` of all flux of a channel.
fn bright_cells(flux: &Array3<f64>, share: f64) -> Vec<(usize, usize)> {
    let total: Vec<f64> = (0..3).map(|channel| flux.slice(s![.., .., channel]).sum()).collect();
    let (rows, columns, _) = flux.dim();
    let is_bright = |&(row, column): &(usize, usize)| {
        (0..3).any(|channel| flux[[row, column, channel]] > share * total[channel])
    };
    (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).filter(is_bright).collect()
}

/// `F = sum over the block's pixels of L w dw`: for each axis, for each channel.
fn vector_irradiance(
    radiance: ArrayView3<'_, f32>,
    pixels: &Grid,
    block: usize,
    cell_row: usize,
    cell_column: usize,
) -> [[f64; 3]; 3] {
    let (height, width, _) = radiance.dim();
    let middle = |edges: &[f64], i: usize| 0.5 * (edges[i] + edges[i + 1]);
    let mut sum = [[0.0; 3]; 3];
    for row in cell_row * block..((cell_row + 1) * block).min(height) {
        let theta = &pixels.theta_edges;
        let band = band_heights(&theta[row..row + 2])[0];
        for column in cell_column * block..((cell_column + 1) * block).min(width) {
            let phi = &pixels.phi_edges;
            let solid_angle = band * (phi[column + 1] - phi[column]);
            let towards = direction(middle(theta, row), middle(phi, column)) * solid_angle;
            for (axis, sum) in sum.iter_mut().enumerate() {
                for (channel, sum) in sum.iter_mut().enumerate() {
                    *sum += f64::from(radiance[[row, column, channel]]) * towards[axis];
                }
            }
        }
    }
    sum
}

fn mean_radiance(flux: &Array3<f64>, grid: &Grid) -> Array3<f32> {
    let bands = band_heights(&grid.theta_edges);
    Array3::from_shape_fn(flux.dim(), |(row, column, channel)| {
        let width = grid.phi_edges[column + 1] - grid.phi_edges[column];
        (flux[[row, column, channel]] / (bands[row] * width)) as f32
    })
}

/// Weights of linear Rec.709 red, green and blue in luminance.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance of linear Rec.709 RGB.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2]
}

pub(crate) fn check_rgb(radiance: ArrayView3<'_, f32>) -> Result<()> {
    let (height, width, channels) = radiance.dim();
    if height < 2 || width < 2 || channels != 3 {
        return Err(Error::NotAMap { shape: radiance.shape().to_vec() });
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn each_kind_of_unusable_sample_is_counted() {
        let mut map = Array3::from_elem((4, 8, 3), 0.5_f32);
        map[[0, 0, 0]] = f32::NAN;
        map[[1, 2, 1]] = f32::INFINITY;
        map[[3, 7, 2]] = -1.0;
        map[[3, 6, 2]] = f32::NEG_INFINITY;
        map[[2, 0, 0]] = -0.0;
        let seen = unusable(map.view()).unwrap();
        assert_eq!(seen, Unusable { nan: 1, infinite: 1, negative: 2 });
    }

    #[test]
    fn reduction_keeps_the_flux() {
        let map = Array3::from_shape_fn((30, 60, 3), |(y, x, c)| ((y * 7 + x * 3 + c) % 11) as f32);
        for registration in [Registration::CellCentred, Registration::BorderSampled] {
            let pixels = Grid::of_pixels(30, 60, registration);
            let before = block_flux(map.view(), &pixels, 1).unwrap().sum();
            let small = reduce(map.view(), registration, 16, 2.0).unwrap();
            let bands = band_heights(&small.grid.theta_edges);
            let after: f64 = small
                .radiance
                .indexed_iter()
                .map(|((row, column, _), &value)| {
                    let edges = &small.grid.phi_edges;
                    f64::from(value) * bands[row] * (edges[column + 1] - edges[column])
                })
                .sum();
            assert_relative_eq!(before, after, max_relative = 1e-6);
        }
    }
}
