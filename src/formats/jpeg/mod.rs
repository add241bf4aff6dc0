//! JPEG pictures (ITU-T T.81): sequential and progressive, 8 bits, Huffman codes.
//!
//! Samples are to the bit those of libjpeg-turbo, whose integer arithmetic this reader follows. The crates `zune-jpeg`
//! and `jpeg-decoder` differ by up to 5 codes, and read a file that ends too early if a marker of the end follows;
//! the first also reads files that have lost restart markers.
//!
//! | step                                      | file          |
//! |-------------------------------------------|---------------|
//! | bytes to segments                         | `segments.rs` |
//! | size and components                       | `frame.rs`    |
//! | profile, XMP, EXIF, other pictures        | `metadata.rs` |
//! | codes to numbers                          | `huffman.rs`  |
//! | gain map in the second picture            | `second.rs`   |
//! | scans to coefficients                     | `scan.rs`     |
//! | coefficients to samples                   | `inverse.rs`  |
//! | samples of components to rows of colours  | `planes.rs`   |
//! | all steps for one picture                 | `picture.rs`  |

mod frame;
mod huffman;
mod inverse;
mod metadata;
mod picture;
mod planes;
mod scan;
mod second;
mod segments;
#[cfg(test)]
mod tests;

use std::ops::Range;

use self::metadata::Metadata;
use self::picture::Picture;
use self::planes::Model;
use crate::error::Result;
use crate::formats::exif;
use crate::formats::header::{Header, SampleType, channels};
use crate::formats::input::check_size;
use crate::formats::picture::{PictureFile, SamplesMut, copy_channels, wrong_type};

/// A JPEG file whose segments were read; its samples are decoded when they are first read, and kept.
#[derive(Debug)]
pub struct Jpeg<Bytes> {
    bytes: Bytes,
    header: Header,
    picture: Picture,
}

/// Picture in `bytes` of at most `max_pixels`.
///
/// # Errors
///
/// If the segments before the pixels are damaged, the picture has too many pixels or is of a process that is not read.
pub fn open<Bytes: AsRef<[u8]> + Send + Sync + 'static>(
    bytes: Bytes,
    max_pixels: usize,
) -> Result<Jpeg<Bytes>> {
    let (metadata, frame) = Metadata::read(bytes.as_ref(), 0)?;
    check_size(frame.height, frame.width, max_pixels)?;
    frame.check_length(bytes.as_ref().len())?;
    let picture = Picture::new(0, frame, &metadata);
    let mut header = header(&metadata, &picture);
    let (gain_map, note) = second::gain_map(bytes.as_ref(), &metadata, max_pixels);
    header.gain_map = gain_map;
    header.notes.extend(note);
    Ok(Jpeg { bytes, header, picture })
}

fn header(metadata: &Metadata<'_>, picture: &Picture) -> Header {
    let (frame, names) = (&picture.frame, if picture.model == Model::Grey { "Y" } else { "RGB" });
    let mut header = Header::plain("jpeg", frame.height, frame.width, channels(names, SampleType::U8));
    header.exif = exif::numbers(metadata.exif);
    header.orientation = exif::orientation(&header.exif);
    header.colour.is_srgb = header.exif.get("ColorSpace") == Some(&1.0);
    header.colour.icc = metadata.profile().unwrap_or_else(|| {
        header.notes.push("parts of the file's ICC profile are missing, so it was left out".into());
        Vec::new()
    });
    header.description = String::from_utf8_lossy(metadata.comment).trim_end_matches('\0').into();
    header.xmp = metadata.packets();
    header
}

impl<Bytes: AsRef<[u8]> + Send + Sync> PictureFile for Jpeg<Bytes> {
    fn parts(&self) -> &[Header] {
        std::slice::from_ref(&self.header)
    }

    fn read(&self, _: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()> {
        let SamplesMut::Bytes(out) = out else { return Err(wrong_type()) };
        if channels.iter().copied().eq(0..self.header.channels.len()) {
            return self.picture.write(self.bytes.as_ref(), rows.start, out);
        }
        let samples = self.picture.samples(self.bytes.as_ref(), rows)?;
        copy_channels(samples.view(), channels, out);
        Ok(())
    }
}
