//! The map's pixels of a light, row by row, and the membrane at their places.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::mem::take;
use std::ops::Range;

use super::cells::{Cells, Column, Row};
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
    /// Luminance above which a place is bright.
    pub threshold: f32,
}

/// All pixels of a light in some rows.
pub struct Part {
    /// Those of the working image, row after row.
    runs: Vec<Run>,
    /// How many they are.
    pixels: usize,
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
    pub given: &'a [[f32; 3]],
    pub row: &'a Row,
    pub columns: &'a [Column],
}

/// Rows of an image that is written.
pub struct Slab<'a> {
    first: usize,
    width: usize,
    pixels: &'a mut [[f32; 3]],
}

impl Map<'_> {
    /// The map's pixels behind some of the working image, in parts of whole rows.
    pub fn parts(&self, region: &[u32]) -> Vec<Part> {
        let most = PIXELS_OF_A_PART.div_ceil(self.block.pow(2));
        let mut parts: Vec<Part> = Vec::new();
        for run in runs(region, self.membrane.level.size.1) {
            let is_full = |part: &Part| part.pixels >= most && part.last_row() < run.row;
            if parts.last().is_none_or(is_full) {
                parts.push(Part { runs: Vec::new(), pixels: 0 });
            }
            let part = parts.last_mut().expect("one was added");
            part.pixels += run.columns.len();
            part.runs.push(run);
        }
        parts
    }

    /// The rows of an image of the map's size that each of these parts lies in.
    pub fn slabs<'a>(&self, parts: &[Part], mut pixels: &'a mut [[f32; 3]]) -> Vec<Slab<'a>> {
        let (width, mut first) = (self.size.1, 0);
        let mut cut_off = |row: usize| {
            let (above, below) = take(&mut pixels).split_at_mut((row - first) * width);
            (first, pixels) = (row, below);
            above
        };
        let slab = |part: &Part| {
            let rows = self.rows_of(&part.runs[0]).start..self.rows_of(&part.runs[part.runs.len() - 1]).end;
            cut_off(rows.start);
            Slab { first: rows.start, width, pixels: cut_off(rows.end) }
        };
        parts.iter().map(slab).collect()
    }

    /// The rows of a part.
    pub fn rows<'a>(&self, part: &'a Part) -> impl Iterator<Item = Place<'a>> {
        interrupt::check();
        part.runs.iter().flat_map(|run| {
            let columns = self.columns_of(run);
            self.rows_of(run).map(move |row| Place { row, columns: columns.clone(), behind: &run.columns })
        })
    }

    /// The membrane at a place, and its bump, in place of other values.
    #[inline(always)]
    pub fn fill(&self, place: &Place<'_>, values: &mut Vec<Value>) {
        values.resize(place.columns.len(), Value::default());
        self.membrane.fill_row(place.row, place.behind, values);
    }

    /// The pixels at a place.
    #[inline(always)]
    pub fn row(&self, place: &Place<'_>) -> RowOfPixels<'_> {
        let Place { row, columns, .. } = place;
        let first = row * self.size.1 + columns.start;
        RowOfPixels {
            given: &self.pixels[first..first + columns.len()],
            row: &self.cells.rows[*row],
            columns: &self.cells.columns[columns.clone()],
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

impl Part {
    fn last_row(&self) -> usize {
        self.runs.last().map_or(0, |run| run.row)
    }
}

impl Slab<'_> {
    /// The pixels at a place.
    #[inline(always)]
    pub fn at(&mut self, place: &Place<'_>) -> &mut [[f32; 3]] {
        let start = (place.row - self.first) * self.width;
        &mut self.pixels[start + place.columns.start..start + place.columns.end]
    }
}
