//! OpenEXR pictures: channels of half floats and floats in blocks, each of them packed by itself.
//!
//! | step                                            | file            |
//! |-------------------------------------------------|-----------------|
//! | headers to attributes                           | `attributes.rs` |
//! | attributes to statements and a layout of blocks | `part.rs`       |
//! | order of the channels                           | `channels.rs`   |
//! | blocks to samples                               | `blocks.rs`     |
//! | blocks of ZIP to bytes                          | `zip.rs`        |
//! | samples to a file                               | `write.rs`      |
//!
//! The crate `exr` decodes the values of attributes, and all blocks but those of ZIP.

mod attributes;
mod blocks;
mod channels;
mod part;
#[cfg(test)]
mod tests;
pub mod write;
mod zip;

use std::ops::Range;

use self::attributes::Preamble;
use self::blocks::Blocks;
use self::part::Part;
use crate::error::Result;
use crate::formats::header::Header;
use crate::formats::input::damage;
use crate::formats::picture::{PictureFile, SamplesMut, wrong_type};

/// Picture in `bytes`, of whose parts none has more than `max_pixels`.
///
/// # Errors
///
/// If a header is damaged or claims too much, or the first part is of a kind that is not converted.
pub fn open<Bytes>(bytes: Bytes, max_pixels: usize) -> Result<impl PictureFile>
where
    Bytes: AsRef<[u8]> + Send + Sync + 'static,
{
    let (headers, parts) = parts(bytes.as_ref(), max_pixels)?;
    parts[0].check_kind()?;
    Ok(OpenExr { bytes, parts, headers })
}

fn parts(bytes: &[u8], max_pixels: usize) -> Result<(Vec<Header>, Vec<Part>)> {
    let preamble = Preamble::read(bytes)?;
    let mut table = preamble.length;
    let (mut headers, mut parts) = (Vec::new(), Vec::new());
    for (number, attributes) in preamble.parts.iter().enumerate() {
        let number = preamble.is_multipart.then_some(number);
        let (header, part) = Part::read(attributes, number, preamble.is_tiled, table)?;
        part.check(max_pixels, bytes.len())?;
        table = table.saturating_add(part.table_length());
        headers.push(header);
        parts.push(part);
    }
    if table > bytes.len() {
        return Err(damage("the table of its blocks is incomplete"));
    }
    Ok((headers, parts))
}

/// File whose headers were read.
struct OpenExr<Bytes> {
    bytes: Bytes,
    parts: Vec<Part>,
    headers: Vec<Header>,
}

impl<Bytes: AsRef<[u8]> + Send + Sync> PictureFile for OpenExr<Bytes> {
    fn parts(&self) -> &[Header] {
        &self.headers
    }

    fn read(&self, part: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()> {
        let part = &self.parts[part];
        part.check_kind()?;
        part.check_samples(channels)?;
        let channels = channels.iter().map(|&channel| part.order[channel]).collect();
        let blocks = Blocks { bytes: self.bytes.as_ref(), part, channels };
        match out {
            SamplesMut::Halves(out) => blocks.read(rows, out),
            SamplesMut::Floats(out) => blocks.read(rows, out),
            _ => Err(wrong_type()),
        }
    }
}
