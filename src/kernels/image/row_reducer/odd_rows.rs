//! Rows of blocks that are cleaned at the end: the level of an infinite sample depends on the largest one of the map.
//!
//! Their lines of pixels are kept with the line above and below, which are the neighbours of their samples, so that they
//! are cleaned as in the whole map.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use ndarray::Array3;

use super::super::clean::{Cleaning, LARGEST_HALF};
use super::super::samples::Unusable;
use super::super::white::LEAST_WHITE;
use crate::error::{Error, Result};

/// True for rows with samples to be replaced, or with one that may be clipped beside infinite ones.
pub(super) fn is_odd(samples: Unusable) -> bool {
    let may_be_clipped = LEAST_WHITE * LARGEST_HALF..LARGEST_HALF;
    samples.nan + samples.infinite > 0 || may_be_clipped.contains(&f64::from(samples.largest.unwrap_or(0.0)))
}

/// Lines of pixels that wait for the end of the map.
#[derive(Default)]
pub(super) struct OddRows {
    /// Rows of blocks with samples to be replaced, or that may be clipped.
    pub rows: BTreeSet<usize>,
    /// Linear samples by their line of pixels.
    lines: BTreeMap<usize, Vec<f32>>,
    /// Last line so far, which is the one above the next row.
    last: Vec<f32>,
}

impl OddRows {
    /// Take the `odd` rows of blocks, each with its lines, of the next `lines`; `linear` gives the samples of a line.
    pub fn add(
        &mut self,
        lines: Range<usize>,
        odd: Vec<(usize, Range<usize>)>,
        linear: impl Fn(usize) -> Vec<f32>,
    ) {
        let above = lines.start.checked_sub(1);
        if above.is_some_and(|above| self.lines.contains_key(&above)) {
            self.lines.insert(lines.start, linear(lines.start));
        }
        for (row, within) in odd {
            self.rows.insert(row);
            if let Some(above) = above.filter(|_| within.start == lines.start) {
                self.lines.entry(above).or_insert_with(|| self.last.clone());
            }
            let from = within.start.saturating_sub(1).max(lines.start);
            for line in from..(within.end + 1).min(lines.end) {
                self.lines.entry(line).or_insert_with(|| linear(line));
            }
        }
        self.last = linear(lines.end - 1);
    }

    /// Cleaned lines, as those of a map of this `width` with these `unusable` samples.
    ///
    /// # Errors
    ///
    /// [`Error::NoFiniteSample`].
    pub fn clean(&self, unusable: Unusable, width: usize) -> Result<(Cleaning, BTreeMap<usize, Vec<f32>>)> {
        let mut cleaning = Cleaning::of(unusable)?;
        let mut cleaned = BTreeMap::new();
        let lines: Vec<usize> = self.lines.keys().copied().collect();
        for strip in lines.chunk_by(|above, below| above + 1 == *below) {
            let samples: Vec<f32> = strip.iter().flat_map(|line| &self.lines[line]).copied().collect();
            let shape = (strip.len(), width, 3);
            let wrong = |_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
            let samples = Array3::from_shape_vec(shape, samples).map_err(wrong)?;
            let mut out = Array3::zeros(shape);
            cleaning.apply(samples.view(), true, out.view_mut())?;
            let samples = out.outer_iter().map(|line| line.iter().copied().collect());
            cleaned.extend(strip.iter().copied().zip(samples));
        }
        Ok((cleaning, cleaned))
    }
}
