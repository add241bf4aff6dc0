//! The map's pixels of a light, row by row, each with the membrane at its place.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

use super::cells::{Cells, Columns, Row};
use super::level::{Enlarged, Value};
use crate::interrupt;
use crate::kernels::detect::tree::{Run, runs};

/// Pixels that one task works through, at least. Another number would add in another order.
const PIXELS_OF_A_PART: usize = 1 << 13;

/// A map, its cells, and the membrane in its pixels.
pub struct Map<'a> {
    /// Its pixels, row after row, and its height and width.
    pub pixels: &'a [[f32; 3]],
    pub size: (usize, usize),
    pub cells: Cells,
    pub membrane: Enlarged<'a>,
    /// Pixels of the map along each side of a pixel of the working image.
    pub block: usize,
}

/// A part of a light's pixels.
pub struct Part {
    /// Those of the working image.
    runs: Vec<Run>,
    /// How many pixels of the map lie behind them.
    pub pixels: usize,
}

/// Where pixels side by side in a row of the map lie.
pub struct Place<'a> {
    row: usize,
    columns: Range<usize>,
    /// Their columns in the working image.
    behind: &'a Range<usize>,
}

/// Pixels side by side in a row of the map.
pub struct RowOfPixels<'a> {
    /// Flat index of the first.
    pub first: usize,
    pub given: &'a [[f32; 3]],
    pub row: &'a Row,
    pub columns: Columns<&'a [f64]>,
}

impl Map<'_> {
    /// The map's pixels behind some of the working image, in parts.
    pub fn parts(&self, region: &[u32]) -> Vec<Part> {
        let part = |part: &[u32]| {
            let runs = runs(part, self.membrane.level.size.1);
            let pixels = runs.iter().map(|run| self.rows_of(run).len() * self.columns_of(run).len()).sum();
            Part { runs, pixels }
        };
        region.chunks(PIXELS_OF_A_PART.div_ceil(self.block.pow(2))).map(part).collect()
    }

    /// The rows of a part.
    pub fn rows<'a>(&self, part: &'a Part) -> impl Iterator<Item = Place<'a>> {
        interrupt::check();
        part.runs.iter().flat_map(|run| {
            let columns = self.columns_of(run);
            self.rows_of(run).map(move |row| Place { row, columns: columns.clone(), behind: &run.columns })
        })
    }

    /// The pixels at a place; the membrane there, and its bump, are written into `fill`.
    #[inline(always)]
    pub fn row(&self, place: &Place<'_>, fill: &mut Vec<Value>) -> RowOfPixels<'_> {
        let Place { row, columns, behind } = place;
        fill.resize(columns.len(), Value::default());
        self.membrane.fill_row(*row, behind, fill);
        let first = row * self.size.1 + columns.start;
        RowOfPixels {
            first,
            given: &self.pixels[first..first + columns.len()],
            row: &self.cells.rows[*row],
            columns: self.cells.columns.at(columns.clone()),
        }
    }

    /// Rows of the map behind a run.
    fn rows_of(&self, run: &Run) -> Range<usize> {
        run.row * self.block..((run.row + 1) * self.block).min(self.size.0)
    }

    fn columns_of(&self, run: &Run) -> Range<usize> {
        run.columns.start * self.block..(run.columns.end * self.block).min(self.size.1)
    }
}
