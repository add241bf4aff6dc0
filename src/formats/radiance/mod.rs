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

use ndarray::Array3;
use rayon::prelude::*;

pub use header::Header;

use self::lines::{Line, find_lines};
use self::rows::Planes;
use crate::error::{Error, Result};
use crate::formats::input::{Rows, check_size, damage, zeros};
use crate::interrupt;

/// A picture whose header was read and whose lines were found; any of its rows can be decoded.
#[derive(Debug)]
pub struct Radiance<Bytes> {
    bytes: Bytes,
    header: Header,
    lines: Vec<Line>,
}

impl<Bytes: AsRef<[u8]> + Sync> Radiance<Bytes> {
    /// Picture in `bytes` of at most `max_pixels`.
    ///
    /// # Errors
    ///
    /// If the header or a line is damage, or the picture has too many pixels.
    pub fn open(bytes: Bytes, max_pixels: usize) -> Result<Self> {
        let header = Header::read(bytes.as_ref())?;
        check_size(header.height, header.width, max_pixels)?;
        let lines = find_lines(bytes.as_ref(), &header)?;
        Ok(Self { bytes, header, lines })
    }

    /// Statements of the file.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Samples of some `rows`, (rows, width, 3), in the order of the file.
    ///
    /// # Errors
    ///
    /// If there is no memory.
    pub fn samples(&self, rows: Range<usize>) -> Result<Array3<f32>> {
        let shape = (rows.len(), self.header.width, 3);
        let no_memory = || Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
        let mut samples = zeros(shape, shape.0 * shape.1 * 3)?;
        self.read(rows, &mut samples)?;
        Array3::from_shape_vec(shape, samples).map_err(|_| no_memory())
    }
}

impl<Bytes: AsRef<[u8]> + Sync> Rows for Radiance<Bytes> {
    fn size(&self) -> (usize, usize) {
        (self.header.height, self.header.width)
    }

    fn read(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        /// Fewest lines of a task, which allocates memory for the bytes of a line.
        const LINES_AT_ONCE: usize = 8;
        let width = self.header.width;
        let lines = &self.lines[rows];
        out.par_chunks_mut(3 * width).zip(lines).with_min_len(LINES_AT_ONCE).try_for_each_init(
            || Planes::new(width),
            |planes, (out, line)| {
                interrupt::check();
                planes.decode(self.bytes.as_ref(), line, out).ok_or_else(|| damage("a line has wrong runs"))
            },
        )
    }
}
