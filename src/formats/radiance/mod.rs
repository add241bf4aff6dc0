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

use rayon::prelude::*;

use self::header::Reader;
use self::lines::{Line, find_lines};
use self::rows::Planes;
use crate::error::Result;
use crate::formats::header::Header;
use crate::formats::input::{check_size, damage};
use crate::formats::picture::{PictureFile, SamplesMut, array, copy_channels, wrong_type};
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
    /// If the header or a line is damaged, or the picture has too many pixels.
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

    fn read(&self, _: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()> {
        let SamplesMut::Floats(out) = out else { return Err(wrong_type()) };
        if channels == [0, 1, 2] {
            return self.decode(rows, out);
        }
        let mut samples = array((rows.len(), self.header.width, 3))?;
        self.decode(rows, samples.as_slice_mut().unwrap_or_default())?;
        copy_channels(samples.view(), channels, out);
        Ok(())
    }
}

impl<Bytes: AsRef<[u8]> + Sync> Radiance<Bytes> {
    /// Write the samples of some rows, three for each pixel.
    fn decode(&self, rows: Range<usize>, out: &mut [f32]) -> Result<()> {
        /// Fewest lines of a task, which allocates memory for the bytes of a line.
        const LINES_AT_ONCE: usize = 8;
        let width = self.header.width;
        let lines = out.par_chunks_mut(3 * width).zip(&self.lines[rows]);
        lines.with_min_len(LINES_AT_ONCE).try_for_each_init(
            || Planes::new(width),
            |planes, (out, line)| {
                interrupt::check();
                planes.decode(self.bytes.as_ref(), line, out).ok_or_else(|| damage("a line has wrong runs"))
            },
        )
    }
}
