//! Encoder of PNG: sRGB codes of 8 or 16 bits.

use std::io::Write;

use ndarray::{ArrayView3, Axis};
use png::{BitDepth, ColorType, Encoder, EncodingError, SrgbRenderingIntent};

use crate::interrupt;

/// Keyword of a description.
pub const DESCRIPTION: &str = "Description";

/// Bytes of a PNG file of sRGB codes, (rows, columns, 3) or with straight alpha as a fourth channel.
pub fn encode_8(codes: ArrayView3<'_, u8>, description: &str) -> Vec<u8> {
    let rows = codes.axis_iter(Axis(0)).map(|row| row.iter().copied().collect());
    encode(codes.dim(), BitDepth::Eight, description, rows)
}

/// Bytes of a PNG file of sRGB codes of 16 bits, (rows, columns, 3), with a `description` if it is not empty.
pub fn encode_16(codes: ArrayView3<'_, u16>, description: &str) -> Vec<u8> {
    let rows = codes.axis_iter(Axis(0)).map(|row| row.iter().flat_map(|code| code.to_be_bytes()).collect());
    encode(codes.dim(), BitDepth::Sixteen, description, rows)
}

fn encode(
    size: (usize, usize, usize),
    depth: BitDepth,
    description: &str,
    rows: impl Iterator<Item = Vec<u8>>,
) -> Vec<u8> {
    let mut file = Vec::new();
    try_encode(&mut file, size, depth, description, rows).expect("memory is written without an error");
    file
}

fn try_encode(
    file: &mut Vec<u8>,
    (height, width, channels): (usize, usize, usize),
    depth: BitDepth,
    description: &str,
    rows: impl Iterator<Item = Vec<u8>>,
) -> Result<(), EncodingError> {
    let mut encoder = Encoder::new(file, width as u32, height as u32);
    encoder.set_color(if channels == 4 { ColorType::Rgba } else { ColorType::Rgb });
    encoder.set_depth(depth);
    encoder.set_source_srgb(SrgbRenderingIntent::AbsoluteColorimetric);
    if description.is_ascii() && !description.is_empty() {
        encoder.add_text_chunk(DESCRIPTION.to_string(), description.to_string())?;
    } else if !description.is_empty() {
        // Other texts of PNG are Latin-1.
        encoder.add_itxt_chunk(DESCRIPTION.to_string(), description.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    let mut samples = writer.stream_writer()?;
    for row in rows {
        interrupt::check();
        samples.write_all(&row)?;
    }
    samples.finish()?;
    writer.finish()
}
