//! Reduction of a map whose rows arrive in order, so that the whole map is never in memory.
//!
//! The rows add up to the cells of the working map, as those of an array do. Sources and bright cells need their pixels
//! afterwards. Radiance is not negative, so the flux of the first rows is a lower bound of the flux of the map. A cell that
//! is neither a source nor bright by this bound will be neither; pixels of the others are retained.

mod odd_rows;

use std::collections::BTreeMap;
use std::ops::Range;

use ndarray::Array3;
use rayon::prelude::*;

use self::odd_rows::{OddRows, is_odd};
use super::block_layout::BlockLayout;
use super::block_rows::BlockRow;
use super::buffers::Buffers;
use super::cell_flux::{CellFlux, add_across, is_bright, is_source, least_source, visible_above};
use super::clean::Cleaning;
use super::luminance::{luminance, luminance_f32};
use super::reduce::{ReducedFlux, WorkingMap};
use super::sample_types::Sample;
use super::samples::{Unusable, largest_usable};
use super::top_codes::TopCodes;
use super::white::LEAST_WHITE;
use crate::error::{Error, Result};
use crate::kernels::sphere::{Registration, band_heights};

/// Safety margin of the bounds, for sums in another order.
const ROUNDING: f64 = 1e-9;

/// Layout of a map and options of its reduction; see [`super::reduce()`].
#[derive(Clone, Copy, Debug)]
pub struct ReductionOptions {
    /// Rows of the map.
    pub height: usize,
    /// Columns of the map.
    pub width: usize,
    /// Layout of the pixels.
    pub registration: Registration,
    /// Largest number of columns of the working map.
    pub columns: usize,
    /// Fraction of the flux of a channel from which a cell becomes a source.
    pub source_fraction: f64,
    /// True if a floor hides all light from below the horizon.
    pub has_floor: bool,
}

/// Sum of the rows so far, and the pixels of cells that may become sources or bright.
pub struct RowReducer<T: Sample> {
    options: ReductionOptions,
    layout: BlockLayout,
    table: Box<T::Table>,
    /// Integrals of the rows so far; the others are black.
    flux: CellFlux,
    /// Rows of blocks so far.
    rows: usize,
    /// Flux of these rows in each channel, above the horizon if there is a floor.
    so_far: [f64; 3],
    retained: BTreeMap<(usize, usize), Vec<T>>,
    top: TopCodes,
    /// Samples so far.
    samples: Unusable,
    odd: OddRows,
    bounds: CellBounds,
    buffers: Buffers,
}

/// Numbers of each cell for a comparison with the bounds.
struct CellBounds {
    /// Fraction of each row above the horizon, or 1 without a floor.
    visible: Vec<f64>,
    bands: Vec<f64>,
    widths: Vec<f64>,
}

/// Integrals over some rows of blocks.
pub struct ReducedRows {
    rows: Vec<BlockSums>,
}

/// Integrals over one row of blocks.
struct BlockSums {
    /// Integral over each cell.
    cells: Vec<[f64; 3]>,
    /// Integral over the row.
    sum: [f64; 3],
    /// Pixels of the largest codes.
    top: TopCodes,
    /// Samples of the row.
    samples: Unusable,
}

impl<T: Sample> RowReducer<T> {
    /// No rows yet.
    ///
    /// `table` holds the linear value of each code.
    ///
    /// # Errors
    ///
    /// [`Error::NotAMap`] for fewer than two rows or columns; [`Error::WrongShape`] for a table without a value of each
    /// code.
    pub fn new(options: ReductionOptions, table: Vec<f32>) -> Result<Self> {
        let ReductionOptions { height, width, registration, columns, has_floor, .. } = options;
        if height < 2 || width < 2 {
            return Err(Error::NotAMap { shape: vec![height, width, 3] });
        }
        let shape = vec![table.len()];
        let wrong_table = Error::WrongShape { what: "table", wanted: "(codes,)", shape };
        let table = T::table(table).ok_or(wrong_table)?;
        let layout = BlockLayout::new(height, width, registration, columns);
        let (rows, columns) = layout.blocks();
        let bounds = CellBounds {
            visible: visible_above(&layout.grid).map(|part| if has_floor { part } else { 1.0 }).collect(),
            bands: band_heights(&layout.grid.theta_edges),
            widths: layout.grid.widths(),
        };
        let flux = CellFlux { cells: Array3::zeros((rows, columns, 3)), rows: vec![[0.0; 3]; rows] };
        Ok(Self {
            options,
            layout,
            table,
            flux,
            rows: 0,
            so_far: [0.0; 3],
            retained: BTreeMap::new(),
            top: TopCodes::default(),
            samples: Unusable::default(),
            odd: OddRows::default(),
            bounds,
            buffers: Buffers::default(),
        })
    }

    /// Pixels along each side of a block: rows are added in multiples of it.
    pub fn block(&self) -> usize {
        self.layout.block
    }

    /// Integrals over the next rows, whose RGB `samples` are whole rows of blocks.
    ///
    /// # Errors
    ///
    /// [`Error::WrongShape`] when they are not.
    pub fn integrals(&self, samples: &[T]) -> Result<ReducedRows> {
        self.check_rows(samples)?;
        let widths = self.layout.pixels.widths();
        let of_row = |(row, samples): (usize, &[T])| {
            let rows = self.layout.pixel_rows(self.rows + row);
            let edges = &self.layout.pixels.theta_edges[rows.start..=rows.end];
            self.buffers.lend(|buffer| {
                let values = T::linear(samples, &self.table, buffer);
                let mut sums = self.checked_sums(values, edges, &widths);
                sums.top = TopCodes::of(samples, values, edges, &widths);
                sums
            })
        };
        let rows = samples.par_chunks(3 * self.options.width * self.layout.block).enumerate();
        Ok(ReducedRows { rows: rows.map(of_row).collect() })
    }

    /// Integrals over a row of blocks with these linear `values`; none of an odd row.
    fn checked_sums(&self, values: &[f32], theta_edges: &[f64], widths: &[f64]) -> BlockSums {
        if let Some(largest) = largest_usable(values) {
            let samples = Unusable { largest: Some(largest), ..Unusable::default() };
            if !is_odd(samples) {
                return BlockSums { samples, ..self.sums(values, theta_edges, widths) };
            }
        }
        let samples = Unusable::of(values);
        if is_odd(samples) {
            let cells = vec![[0.0; 3]; self.bounds.widths.len()];
            return BlockSums { cells, sum: [0.0; 3], top: TopCodes::default(), samples };
        }
        BlockSums { samples, ..self.sums(&without_signs(values), theta_edges, widths) }
    }

    /// Integrals over a row of blocks with these usable `values`.
    fn sums(&self, values: &[f32], theta_edges: &[f64], widths: &[f64]) -> BlockSums {
        let mut cells = vec![[0.0; 3]; self.bounds.widths.len()];
        let pixels = BlockRow::of_samples(values, theta_edges, self.layout.block);
        let (_, sum) = add_across(&mut cells, &pixels, widths, self.layout.block);
        BlockSums { cells, sum, top: TopCodes::default(), samples: Unusable::default() }
    }

    fn check_rows(&self, samples: &[T]) -> Result<()> {
        let line = 3 * self.options.width;
        let (rows, left) =
            (samples.len() / line, self.options.height.saturating_sub(self.rows * self.layout.block));
        let is_whole =
            samples.len().is_multiple_of(line) && (rows.is_multiple_of(self.layout.block) || rows == left);
        if is_whole && rows <= left {
            return Ok(());
        }
        Err(self.wrong_rows(rows))
    }

    fn wrong_rows(&self, rows: usize) -> Error {
        let shape = vec![rows, self.options.width, 3];
        Error::WrongShape { what: "rows", wanted: "(whole rows of blocks, width, 3)", shape }
    }

    /// Add the integrals of the next rows; retain those pixels of `samples` that may be needed again.
    pub fn add(&mut self, integrals: ReducedRows, samples: &[T]) {
        let first = self.rows;
        let mut odd = Vec::new();
        for sums in integrals.rows {
            if is_odd(sums.samples) {
                odd.push((self.rows, self.layout.pixel_rows(self.rows)));
            }
            self.samples = self.samples.plus(sums.samples);
            self.top.add(&sums.top);
            let visible = self.bounds.visible[self.rows];
            (0..3).for_each(|c| self.so_far[c] += visible * sums.sum[c]);
            self.flux.set_row(self.rows, &sums.cells, sums.sum);
            self.rows += 1;
        }
        self.retain(first, samples);
        self.keep(first, odd, samples);
    }

    /// Keep the `odd` rows of blocks among those from `first` on.
    fn keep(&mut self, first: usize, odd: Vec<(usize, Range<usize>)>, samples: &[T]) {
        let line = 3 * self.options.width;
        let start = first * self.layout.block;
        let lines = start..start + samples.len() / line;
        if lines.is_empty() {
            return;
        }
        let linear = |at: usize| {
            let of_line = &samples[(at - start) * line..][..line];
            T::linear(of_line, &self.table, &mut Vec::new()).to_vec()
        };
        self.odd.add(lines, odd, linear);
    }

    /// Retain the pixels of cells of the rows from `first` on that may be needed, and drop others.
    fn retain(&mut self, first: usize, samples: &[T]) {
        let columns = self.bounds.widths.len();
        let new = (first..self.rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let cells: Vec<(usize, usize)> = self.retained.keys().copied().chain(new).collect();
        let least = least_source(
            self.so_far,
            self.options.source_fraction * (1.0 - ROUNDING),
            self.bounds.bands.len() * columns,
        );
        let is_source = |at: &(usize, usize)| is_source(&self.cell(*at), least);
        let of_sources: f64 =
            cells.iter().filter(|at| is_source(at)).map(|&at| self.cell(at).iter().sum::<f64>()).sum();
        let others = self.so_far.iter().sum::<f64>() * (1.0 - ROUNDING) - of_sources;
        let over_others = if others > 0.0 { 1.0 / others } else { f64::INFINITY };
        let may_be_needed = |at: &(usize, usize)| {
            is_source(at)
                || is_bright(&self.cell(*at), over_others, self.bounds.bands[at.0] * self.bounds.widths[at.1])
        };
        let line = 3 * self.options.width * self.layout.block;
        let needed: Vec<(usize, usize)> = cells.into_iter().filter(may_be_needed).collect();
        let mut before = std::mem::take(&mut self.retained);
        for at in needed {
            let pixels = before.remove(&at).unwrap_or_else(|| {
                let row = samples.chunks(line).nth(at.0 - first).unwrap_or(&[]);
                self.layout.copy(row, at)
            });
            self.retained.insert(at, pixels);
        }
    }

    /// Flux of a cell, above the horizon if there is a floor.
    fn cell(&self, (row, column): (usize, usize)) -> [f64; 3] {
        let visible = self.bounds.visible[row];
        [0, 1, 2].map(|c| visible * self.flux.cells[[row, column, c]])
    }

    /// Bytes of the retained pixels.
    pub fn retained_bytes(&self) -> usize {
        self.retained.values().map(|pixels| size_of_val(&pixels[..])).sum()
    }

    /// Fractions of the sphere and of the luminance flux in pixels with a sample of at least this linear `value`.
    ///
    /// There is no answer if the samples are no codes, or values do not grow with codes.
    pub fn clipped(&self, value: f32) -> Option<[f64; 2]> {
        let least = T::first_at_least(&self.table, value)?;
        let is_counted = T::TOP.is_some_and(|first| least >= first);
        is_counted.then(|| self.top.shares(least, luminance(self.flux.whole())))
    }

    /// Solid angle of the pixels by the code of their largest channel, as 8 bits; small codes are in the first bin.
    pub fn histogram(&self) -> [f64; 256] {
        self.top.histogram::<T>()
    }

    /// The reduction.
    ///
    /// # Errors
    ///
    /// [`Error::WrongShape`] if rows are missing; [`Error::NoFiniteSample`].
    pub fn finish(&self) -> Result<RowReduction> {
        if self.rows < self.flux.rows.len() {
            return Err(self.wrong_rows(0));
        }
        let (cleaning, lines) = self.odd.clean(self.samples, self.options.width)?;
        let mut flux = CellFlux { cells: self.flux.cells.clone(), rows: self.flux.rows.clone() };
        let mut rows = BTreeMap::new();
        for &row in &self.odd.rows {
            let values: Vec<f32> =
                self.layout.pixel_rows(row).flat_map(|line| lines[&line].iter().copied()).collect();
            let sums = self.sums(&values, &self.edges(row), &self.layout.pixels.widths());
            flux.set_row(row, &sums.cells, sums.sum);
            rows.insert(row, values);
        }
        let whole = luminance(flux.whole());
        let clipped_flux = cleaning.level.map_or(0.0, |level| self.clipped_flux(&rows, level) / whole);
        Ok(RowReduction { map: self.working_map(flux, &rows), cleaning, clipped_flux })
    }

    /// Edges of the lines of a row of blocks.
    fn edges(&self, row: usize) -> Vec<f64> {
        let lines = self.layout.pixel_rows(row);
        self.layout.pixels.theta_edges[lines.start..=lines.end].to_vec()
    }

    /// Luminance flux of pixels that are clipped at `level`, which are all in these cleaned `rows`.
    fn clipped_flux(&self, rows: &BTreeMap<usize, Vec<f32>>, level: f64) -> f64 {
        let least = (LEAST_WHITE * level) as f32;
        let widths = self.layout.pixels.widths();
        let of_line = |line: &[f32]| -> f64 {
            let pixels = line.as_chunks::<3>().0.iter().zip(&widths);
            let clipped = pixels.filter(|(pixel, _)| pixel.iter().any(|&sample| sample >= least));
            clipped.map(|(&pixel, width)| f64::from(luminance_f32(pixel)) * width).sum()
        };
        let of_row = |(&row, values): (&usize, &Vec<f32>)| -> f64 {
            let lines = values.chunks_exact(3 * widths.len()).zip(band_heights(&self.edges(row)));
            lines.map(|(line, band)| band * of_line(line)).sum()
        };
        rows.iter().map(of_row).sum()
    }

    /// The working map of this `flux`, with the cleaned values of odd `rows`.
    fn working_map(&self, flux: CellFlux, rows: &BTreeMap<usize, Vec<f32>>) -> WorkingMap {
        let ReductionOptions { source_fraction, has_floor, .. } = self.options;
        let reduced = ReducedFlux::new(flux, &self.layout, source_fraction, has_floor);
        let linear = |cell: &(usize, usize)| {
            if let Some(values) = rows.get(&cell.0) {
                return self.layout.copy(values, *cell);
            }
            without_signs(T::linear(&self.retained[cell], &self.table, &mut Vec::new()))
        };
        let samples = reduced.cells().iter().map(linear).collect();
        reduced.with_parts(&self.layout, has_floor, samples)
    }
}

/// A reduced map, and the samples that were replaced in it.
pub struct RowReduction {
    /// The working map.
    pub map: WorkingMap,
    /// Samples that were replaced.
    pub cleaning: Cleaning,
    /// Fraction of the luminance flux in pixels at the level of infinite samples; 0 without such samples.
    pub clipped_flux: f64,
}

/// Values with 0 in place of those with a minus sign; NaN stays.
fn without_signs(values: &[f32]) -> Vec<f32> {
    values.iter().map(|&value| if value <= 0.0 { 0.0 } else { value }).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
