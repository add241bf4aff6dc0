//! Reduction of a map whose rows arrive in order, so that the whole map is never in memory.
//!
//! The rows add up to the cells of the working map, as those of an array do. Sources and bright cells need their pixels
//! afterwards. Radiance is not negative, so the flux of the first rows is a lower bound of the flux of the map. A cell that
//! is neither a source nor bright by this bound will be neither; pixels of the others are retained.

use std::collections::BTreeMap;

use ndarray::Array3;
use rayon::prelude::*;

use super::block_layout::BlockLayout;
use super::block_rows::BlockRow;
use super::buffers::Buffers;
use super::cell_flux::{CellFlux, add_across, is_bright, is_source, least_source, visible_above};
use super::luminance::luminance;
use super::reduce::{ReducedFlux, WorkingMap};
use super::sample_types::Sample;
use super::top_codes::TopCodes;
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
    /// True if codes are counted, because the picture may be clipped.
    counts_codes: bool,
    /// Integrals of the rows so far; the others are black.
    flux: CellFlux,
    /// Rows of blocks so far.
    rows: usize,
    /// Flux of these rows in each channel, above the horizon if there is a floor.
    so_far: [f64; 3],
    retained: BTreeMap<(usize, usize), Vec<T>>,
    top: TopCodes,
    /// Number of negative samples so far.
    negative: usize,
    is_usable: bool,
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
    /// Number of negative samples, which count as 0.
    negative: usize,
    /// True if a sample is infinite or NaN.
    is_unusable: bool,
}

impl<T: Sample> RowReducer<T> {
    /// No rows yet.
    ///
    /// `table` holds the linear value of each code; `counts_codes` prepares [`Self::clipped`].
    ///
    /// # Errors
    ///
    /// [`Error::NotAMap`] for fewer than two rows or columns; [`Error::WrongShape`] for a table without a value of each
    /// code.
    pub fn new(options: ReductionOptions, table: Vec<f32>, counts_codes: bool) -> Result<Self> {
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
            counts_codes,
            flux,
            rows: 0,
            so_far: [0.0; 3],
            retained: BTreeMap::new(),
            top: TopCodes::default(),
            negative: 0,
            is_usable: true,
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
                let mut sums = self.sums(values, edges, &widths);
                // A minus sign is rare, so the usual row is read once.
                if sums.is_unusable {
                    let negative = values.iter().filter(|&&value| value < 0.0).count();
                    sums = BlockSums { negative, ..self.sums(&without_signs(values), edges, &widths) };
                }
                if self.counts_codes {
                    sums.top = TopCodes::of(samples, values, edges, &widths);
                }
                sums
            })
        };
        let rows = samples.par_chunks(3 * self.options.width * self.layout.block).enumerate();
        Ok(ReducedRows { rows: rows.map(of_row).collect() })
    }

    /// Integrals over a row of blocks with these linear `values`.
    fn sums(&self, values: &[f32], theta_edges: &[f64], widths: &[f64]) -> BlockSums {
        let mut cells = vec![[0.0; 3]; self.bounds.widths.len()];
        let pixels = BlockRow::of_samples(values, theta_edges, self.layout.block);
        let (is_unusable, sum) = add_across(&mut cells, &pixels, widths, self.layout.block);
        BlockSums { cells, sum, top: TopCodes::default(), negative: 0, is_unusable }
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
        let shape = vec![rows, self.options.width, 3];
        Err(Error::WrongShape { what: "rows", wanted: "(whole rows of blocks, width, 3)", shape })
    }

    /// Add the integrals of the next rows; retain those pixels of `samples` that may be needed again.
    pub fn add(&mut self, integrals: ReducedRows, samples: &[T]) {
        let first = self.rows;
        for BlockSums { cells, sum, top, negative, is_unusable } in integrals.rows {
            self.is_usable &= !is_unusable;
            self.negative += negative;
            let visible = self.bounds.visible[self.rows];
            (0..3).for_each(|c| self.so_far[c] += visible * sum[c]);
            for (mut at, cell) in
                self.flux.cells.index_axis_mut(ndarray::Axis(0), self.rows).outer_iter_mut().zip(cells)
            {
                (0..3).for_each(|c| at[c] = cell[c]);
            }
            self.flux.rows[self.rows] = sum;
            self.top.add(&top);
            self.rows += 1;
        }
        self.retain(first, samples);
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

    /// Number of negative samples so far, which count as 0.
    pub fn negative(&self) -> usize {
        self.negative
    }

    /// True if all samples so far are finite or negative.
    pub fn is_usable(&self) -> bool {
        self.is_usable
    }

    /// Bytes of the retained pixels.
    pub fn retained_bytes(&self) -> usize {
        self.retained.values().map(|pixels| size_of_val(&pixels[..])).sum()
    }

    /// Fractions of the sphere and of the luminance flux in pixels with a sample of at least this linear `value`.
    ///
    /// There is no answer if the reducer counts no codes, or values do not grow with codes.
    pub fn clipped(&self, value: f32) -> Option<[f64; 2]> {
        let least = T::first_at_least(&self.table, value).filter(|_| self.counts_codes)?;
        let is_counted = T::TOP.is_some_and(|first| least >= first);
        is_counted.then(|| self.top.shares(least, luminance(self.flux.whole())))
    }

    /// Solid angle of the pixels by the code of their largest channel, as 8 bits; small codes are in the first bin.
    pub fn histogram(&self) -> [f64; 256] {
        self.top.histogram::<T>()
    }

    /// The working map; none if rows are missing, or a sample is no radiance.
    pub fn finish(&self) -> Option<WorkingMap> {
        if self.rows < self.flux.rows.len() || !self.is_usable {
            return None;
        }
        let flux = CellFlux { cells: self.flux.cells.clone(), rows: self.flux.rows.clone() };
        let ReductionOptions { source_fraction, has_floor, .. } = self.options;
        let reduced = ReducedFlux::new(flux, &self.layout, source_fraction, has_floor);
        let linear = |cell: &(usize, usize)| {
            let pixels = self.retained.get(cell)?;
            Some(without_signs(T::linear(pixels, &self.table, &mut Vec::new())))
        };
        let samples = reduced.cells().iter().map(linear).collect::<Option<Vec<_>>>()?;
        Some(reduced.with_parts(&self.layout, has_floor, samples))
    }
}

/// Values with 0 in place of those with a minus sign; NaN stays.
fn without_signs(values: &[f32]) -> Vec<f32> {
    values.iter().map(|&value| if value <= 0.0 { 0.0 } else { value }).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
