//! Encoder of TIFF: floats in strips, packed by deflate after the predictor of floats.

use std::io::{self, Write};

use flate2::{Compression, write::ZlibEncoder};
use ndarray::{ArrayView3, Axis, s};
use rayon::prelude::*;

use crate::interrupt;

/// Rows of a strip.
const STRIP_ROWS: usize = 32;
/// Packed bytes from which on the file is a `BigTIFF`: 4 GiB, less the tags.
const LARGE: usize = u32::MAX as usize - (1 << 24);

/// Bytes of a TIFF file of RGB `samples`, (rows, columns, 3), with a `description` if it is not empty.
///
/// Equal arguments give equal bytes: the time is not in the file.
pub fn encode(samples: ArrayView3<'_, f32>, description: &str) -> Vec<u8> {
    let rows = samples.dim().0;
    let tops: Vec<usize> = (0..rows).step_by(STRIP_ROWS).collect();
    let strips: Vec<Vec<u8>> = tops
        .into_par_iter()
        .map(|top| pack(samples.slice(s![top..rows.min(top + STRIP_ROWS), .., ..])))
        .collect();
    let lengths: Vec<usize> = strips.iter().map(Vec::len).collect();
    let is_big = lengths.iter().sum::<usize>() > LARGE;
    let mut file = tags(samples.dim(), description, &lengths, is_big);
    for strip in &strips {
        file.extend(strip);
    }
    file
}

/// A strip: the highest bytes of all samples of a row, then the second ones, as differences, packed.
fn pack(rows: ArrayView3<'_, f32>) -> Vec<u8> {
    let step = rows.dim().2;
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    for row in rows.axis_iter(Axis(0)) {
        interrupt::check();
        let samples: Vec<[u8; 4]> = row.iter().map(|sample| sample.to_be_bytes()).collect();
        let bytes: Vec<u8> = (0..4).flat_map(|byte| samples.iter().map(move |sample| sample[byte])).collect();
        let mut differences = bytes.clone();
        for (difference, before) in differences[step..].iter_mut().zip(&bytes) {
            *difference = difference.wrapping_sub(*before);
        }
        never_fails(packed.write_all(&differences));
    }
    never_fails(packed.finish())
}

/// Result of writing into memory.
fn never_fails<T>(written: io::Result<T>) -> T {
    written.expect("memory is written without an error")
}

/// A tag with the bytes of its values, the lowest first.
struct Tag {
    code: u16,
    kind: u16,
    count: usize,
    bytes: Vec<u8>,
}

/// Start of the file, up to its strips.
fn tags(
    (height, width, channels): (usize, usize, usize),
    description: &str,
    lengths: &[usize],
    is_big: bool,
) -> Vec<u8> {
    let long = |tag, values: &[usize]| integers(tag, values, is_big);
    let mut tags = vec![
        long(256, &[width]),
        long(257, &[height]),
        shorts(258, &vec![32; channels]),
        shorts(259, &[8]), // deflate
        shorts(262, &[2]), // RGB
        text(270, description),
        long(273, &vec![0; lengths.len()]),
        shorts(274, &[1]), // from the top left
        shorts(277, &[channels as u16]),
        long(278, &[STRIP_ROWS]),
        long(279, lengths),
        shorts(284, &[1]), // all channels of a pixel together
        shorts(317, &[3]), // predictor of floats
        shorts(339, &vec![3; channels]),
    ];
    tags.retain(|tag| tag.code != 270 || !description.is_empty());
    let mut start = directory(&tags, is_big).len();
    let offsets: Vec<usize> = lengths.iter().map(|length| (start, start += length).0).collect();
    tags.iter_mut().filter(|tag| tag.code == 273).for_each(|tag| *tag = long(273, &offsets));
    directory(&tags, is_big)
}

/// Header, entries of the tags, and the values that do not fit into the entries.
fn directory(tags: &[Tag], is_big: bool) -> Vec<u8> {
    let size = if is_big { 8 } else { 4 };
    let integer = |value: usize| value.to_le_bytes()[..size].to_vec();
    let (mut file, entry_size) =
        if is_big { (b"II+\0\x08\0\0\0".to_vec(), 20) } else { (b"II*\0".to_vec(), 12) };
    file.extend(integer(file.len() + size));
    file.extend(&tags.len().to_le_bytes()[..if is_big { 8 } else { 2 }]);
    let mut place = file.len() + tags.len() * entry_size + size;
    let mut values = Vec::new();
    for tag in tags {
        file.extend([tag.code.to_le_bytes(), tag.kind.to_le_bytes()].concat());
        file.extend(integer(tag.count));
        let mut field = tag.bytes.clone();
        if field.len() > size {
            values.extend(&tag.bytes);
            // Values begin at even places.
            values.extend(vec![0; tag.bytes.len() % 2]);
            field = integer(place);
            place += tag.bytes.len().next_multiple_of(2);
        }
        field.resize(size, 0);
        file.extend(field);
    }
    file.extend(integer(0));
    file.extend(values);
    file
}

fn shorts(code: u16, values: &[u16]) -> Tag {
    Tag {
        code,
        kind: 3,
        count: values.len(),
        bytes: values.iter().flat_map(|value| value.to_le_bytes()).collect(),
    }
}

/// Integers of 32 bits, or of 64 in a `BigTIFF`.
fn integers(code: u16, values: &[usize], is_big: bool) -> Tag {
    let (kind, size) = if is_big { (16, 8) } else { (4, 4) };
    let bytes = values.iter().flat_map(|value| value.to_le_bytes().into_iter().take(size)).collect();
    Tag { code, kind, count: values.len(), bytes }
}

fn text(code: u16, text: &str) -> Tag {
    let bytes = [text.as_bytes(), b"\0"].concat();
    Tag { code, kind: 2, count: bytes.len(), bytes }
}
