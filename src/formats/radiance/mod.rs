//! Radiance pictures (.hdr): pixels of three mantissas with a common exponent, in runs.
//!
//! | step                                    | file        |
//! |-----------------------------------------|-------------|
//! | header and resolution                   | `header.rs` |
//! | start and end of each line, by one scan | `lines.rs`  |
//! | a line to samples                       | `rows.rs`   |
//! | samples to lines                        | `write.rs`  |

mod header;
mod lines;
mod rows;
#[cfg(test)]
mod tests;
pub mod write;

use std::ops::Range;
use std::slice::from_ref;

use ndarray::Array3;
use rayon::prelude::*;

use self::header::Reader;
use self::lines::{Line, find_lines};
use self::rows::Planes;
use crate::error::{Error, Result};
use crate::formats::header::Header;
use crate::formats::input::{check_size, damage, zeros};
use crate::formats::picture::{PictureFile, Samples, select_channels};
use crate::interrupt;

/// A picture whose header was read and whose lines were found; any of its rows can be decoded.
#[derive(Debug)]
pub struct Radiance<Bytes> {
    bytes: Bytes,
    header: Header,
    lines: Vec<Line>,
}

impl<Bytes: AsRef<[u8]>> Radiance<Bytes> {
    /// Picture in `bytes` of at most `max_pixels`.
    ///
    /// # Errors
    ///
    /// If the header or a line is damage, or the picture has too many pixels.
    pub fn open(bytes: Bytes, max_pixels: usize) -> Result<Self> {
        let Reader { header, place, .. } = Reader::read(bytes.as_ref())?;
        check_size(header.height, header.width, max_pixels)?;
        let lines = find_lines(bytes.as_ref(), place, header.height, header.width)?;
        Ok(Self { bytes, header, lines })
    }
}

impl<Bytes: AsRef<[u8]> + Send + Sync> PictureFile for Radiance<Bytes> {
    fn parts(&self) -> &[Header] {
        from_ref(&self.header)
    }

    fn read(&self, _: usize, channels: &[usize], rows: Range<usize>) -> Result<Samples> {
        /// Fewest lines of a task, which allocates memory for the bytes of a line.
        const LINES_AT_ONCE: usize = 8;
        let shape = (rows.len(), self.header.width, 3);
        let mut samples = zeros(shape, shape.0 * shape.1 * 3)?;
        let lines = samples.par_chunks_mut(3 * shape.1).zip(&self.lines[rows]);
        lines.with_min_len(LINES_AT_ONCE).try_for_each_init(
            || Planes::new(shape.1),
            |planes, (out, line)| {
                interrupt::check();
                planes.decode(self.bytes.as_ref(), line, out).ok_or_else(|| damage("a line has wrong runs"))
            },
        )?;
        let no_memory = |_| Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
        let samples = Array3::from_shape_vec(shape, samples).map_err(no_memory)?;
        Ok(Samples::Floats(if channels == [0, 1, 2] {
            samples
        } else {
            select_channels(samples.view(), channels)
        }))
    }
}
