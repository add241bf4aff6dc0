//! Rows of a page: its strips or tiles, decoded on all threads.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::page::{Compression, Page, Predictor};
use super::predictor::undo;
use super::samples::Sample;
use super::unpack::unpack;
use crate::error::Result;
use crate::formats::directory::File;
use crate::interrupt;

/// Strips or tiles by their plane, row and column.
pub type Cache = Mutex<BTreeMap<(usize, usize, usize), Arc<[u8]>>>;

/// Rows of one page that are to be read.
pub struct Request<'a> {
    /// Bytes of the file.
    pub file: File<'a>,
    /// Form of the page.
    pub page: &'a Page,
    /// Numbers of the channels.
    pub channels: &'a [usize],
    /// Decoded strips or tiles, for pages that have one row of them and are read in pieces.
    pub cache: Option<&'a Cache>,
}

/// Most rows of a task.
const ROWS_AT_ONCE: usize = 16;

impl<'a> Request<'a> {
    /// Write the samples of the `rows` into `out`, (rows, width, channels).
    ///
    /// # Errors
    ///
    /// If a strip or tile is damaged, or there is no memory.
    pub fn write<T: Sample>(&self, rows: Range<usize>, out: &mut [T]) -> Result<()> {
        let tasks = tasks(self.page, rows, out, self.page.width * self.channels.len());
        tasks.into_par_iter().try_for_each(|(rows, out)| self.read(rows, out))
    }

    /// Samples of some rows of the strips or tiles of one height.
    fn read<T: Sample>(&self, rows: Range<usize>, out: &mut [T]) -> Result<()> {
        let planes = if self.page.is_planar { self.page.samples } else { 1 };
        for plane in 0..planes {
            let places = self.places(plane);
            for across in (0..self.page.across()).filter(|_| !places.is_empty()) {
                interrupt::check();
                self.read_chunk((plane, across), &places, rows.clone(), out)?;
            }
        }
        Ok(())
    }

    /// Sample in the strips or tiles of a plane and channel of the result, for each channel of the plane.
    fn places(&self, plane: usize) -> Vec<(usize, usize)> {
        let all = self.channels.iter().copied().enumerate();
        if self.page.is_planar {
            return all.filter(|&(_, channel)| channel == plane).map(|(place, _)| (0, place)).collect();
        }
        all.map(|(place, channel)| (channel, place)).collect()
    }

    /// Write the samples of one strip or tile to their places in `out`.
    fn read_chunk<T: Sample>(
        &self,
        (plane, across): (usize, usize),
        places: &[(usize, usize)],
        rows: Range<usize>,
        out: &mut [T],
    ) -> Result<()> {
        let page = self.page;
        let down = rows.start / page.chunk_height;
        let (new, old);
        let bytes: &[u8] = if let Some(cache) = self.cache {
            old = self.cached_bytes(cache, (plane, down, across))?;
            &old
        } else {
            new = self.decode((plane, down, across))?;
            &new
        };
        let (top, left) = (down * page.chunk_height, across * page.chunk_width);
        let columns = page.chunk_width.min(page.width - left);
        let mut samples = Vec::new();
        for (row, out) in rows.zip(out.chunks_exact_mut(page.width * self.channels.len())) {
            let start = (row - top) * page.row_bytes();
            samples.clear();
            T::append(
                page,
                self.file.is_little_endian,
                &bytes[start..start + page.row_bytes()],
                &mut samples,
            );
            let out = &mut out[left * self.channels.len()..(left + columns) * self.channels.len()];
            self.place(plane, &samples, places, out);
        }
        Ok(())
    }

    /// Copy the samples of a row of a strip or tile to their places in the result.
    fn place<T: Sample>(&self, plane: usize, samples: &[T], places: &[(usize, usize)], out: &mut [T]) {
        let step = if self.page.is_planar { 1 } else { self.page.channels() };
        if places.len() == step
            && places.iter().all(|&(sample, place)| sample == place)
            && !self.page.is_planar
        {
            out.copy_from_slice(&samples[..out.len()]);
        } else {
            for (pixel, out) in samples.chunks_exact(step).zip(out.chunks_exact_mut(self.channels.len())) {
                for &(sample, place) in places {
                    out[place] = pixel[sample];
                }
            }
        }
        if self.page.photometric == 0 {
            let grey = places.iter().filter(|&&(sample, _)| plane + sample == 0);
            for &(_, place) in grey {
                out.chunks_exact_mut(self.channels.len())
                    .for_each(|pixel| pixel[place] = pixel[place].complement());
            }
        }
    }

    /// Bytes of the samples of a strip or tile from the cache; it is decoded if it is new.
    fn cached_bytes(&self, cache: &Cache, place: (usize, usize, usize)) -> Result<Arc<[u8]>> {
        let lock = || cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = lock().get(&place) {
            return Ok(bytes.clone());
        }
        let bytes: Arc<[u8]> = self.decode(place)?.into();
        lock().insert(place, bytes.clone());
        Ok(bytes)
    }

    /// Bytes of the samples of a strip or tile, in the byte order of the file.
    fn decode(&self, place: (usize, usize, usize)) -> Result<Cow<'a, [u8]>> {
        let page = self.page;
        let mut bytes = unpack(page, page.chunk(self.file, place)?, page.chunk_rows(place.1))?;
        if page.predictor != Predictor::None {
            undo(page, self.file.is_little_endian, bytes.to_mut());
        }
        Ok(bytes)
    }
}

/// Rows of each task and their part of `out`: rows of the same strips or tiles, which are decoded once.
fn tasks<'o, T>(
    page: &Page,
    rows: Range<usize>,
    mut out: &'o mut [T],
    row_length: usize,
) -> Vec<(Range<usize>, &'o mut [T])> {
    let (mut tasks, mut top) = (Vec::new(), rows.start);
    while top < rows.end {
        let mut bottom = ((top / page.chunk_height + 1) * page.chunk_height).min(rows.end);
        if page.compression == Compression::None {
            bottom = bottom.min(top + ROWS_AT_ONCE);
        }
        let (first, others) = out.split_at_mut((bottom - top) * row_length);
        tasks.push((top..bottom, first));
        (top, out) = (bottom, others);
    }
    tasks
}
