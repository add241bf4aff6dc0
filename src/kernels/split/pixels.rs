//! The map's pixels of a light, in strips of the rows behind one of the working image.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::mem::take;
use std::ops::Range;

use super::cells::Cells;
use super::level::Enlarged;
use crate::interrupt;
use crate::kernels::detect::tree::{Run, runs};

/// Pixels that one task works through, at least. Another number would add in another order.
const PIXELS_OF_A_PART: usize = 1 << 13;
/// Columns of a strip, at most: its sums stay in the first cache.
const PIXELS_OF_A_STRIP: usize = 128;

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

/// Some columns of the map in all rows behind one of the working image.
pub struct Strip {
    pub rows: Range<usize>,
    pub columns: Range<usize>,
    /// Their columns in the working image.
    pub behind: Range<usize>,
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

    /// The strips of a part.
    pub fn strips(&self, part: &Part) -> impl Iterator<Item = Strip> {
        interrupt::check();
        let most = (PIXELS_OF_A_STRIP / self.block).max(1);
        part.runs.iter().flat_map(move |run| {
            let starts = run.columns.clone().step_by(most);
            starts.map(move |start| {
                let behind = start..run.columns.end.min(start + most);
                let columns = behind.start * self.block..(behind.end * self.block).min(self.size.1);
                Strip { rows: self.rows_of(run), columns, behind }
            })
        })
    }

    /// The pixels of a strip in one of its rows.
    #[inline(always)]
    pub fn given(&self, row: usize, strip: &Strip) -> &[[f32; 3]] {
        let start = row * self.size.1;
        &self.pixels[start + strip.columns.start..start + strip.columns.end]
    }

    /// Rows of the map behind a run.
    fn rows_of(&self, run: &Run) -> Range<usize> {
        run.row * self.block..((run.row + 1) * self.block).min(self.size.0)
    }
}

impl Part {
    fn last_row(&self) -> usize {
        self.runs.last().map_or(0, |run| run.row)
    }
}

impl Slab<'_> {
    /// The pixels of a strip in one of its rows.
    #[inline(always)]
    pub fn at(&mut self, row: usize, strip: &Strip) -> &mut [[f32; 3]] {
        let start = (row - self.first) * self.width;
        &mut self.pixels[start + strip.columns.start..start + strip.columns.end]
    }
}
