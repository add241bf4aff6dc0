//! Predictors undone: samples from differences, row by row (TIFF 6.0, section 14; Adobe's technical note 3).

use std::array::from_fn;

use super::page::{Page, Predictor};

/// Replace differences in the rows of a strip or tile by samples, in the byte order of the file.
pub fn undo(page: &Page, is_little_endian: bool, samples: &mut [u8]) {
    let step = page.chunk_samples();
    for row in samples.chunks_exact_mut(page.row_bytes()) {
        match (page.predictor, page.bits) {
            (Predictor::None, _) => {}
            (Predictor::Horizontal, 8) => add_bytes(row, step),
            (Predictor::Horizontal, bits) => add_integers(row, step, bits, is_little_endian),
            (Predictor::Floats, bits) => {
                add_bytes(row, step);
                match bits {
                    16 => gather::<2>(row, is_little_endian),
                    32 => gather::<4>(row, is_little_endian),
                    _ => gather::<8>(row, is_little_endian),
                }
            }
        }
    }
}

/// Sums of bytes that are `step` apart.
fn add_bytes(row: &mut [u8], step: usize) {
    match step {
        1 => add_pixels::<1>(row),
        3 => add_pixels::<3>(row),
        4 => add_pixels::<4>(row),
        _ => add::<1>(row, step, |one, other| [one[0].wrapping_add(other[0])]),
    }
}

/// Sums of bytes that are `STEP` apart, with the last ones in registers.
fn add_pixels<const STEP: usize>(row: &mut [u8]) {
    let mut sums = [0_u8; STEP];
    let (pixels, last) = row.as_chunks_mut::<STEP>();
    for pixel in pixels {
        sums = from_fn(|channel| sums[channel].wrapping_add(pixel[channel]));
        *pixel = sums;
    }
    last.iter_mut().zip(sums).for_each(|(byte, sum)| *byte = byte.wrapping_add(sum));
}

/// Sums of integers of 16, 32 or 64 bits that are `step` integers apart.
fn add_integers(row: &mut [u8], step: usize, bits: usize, is_little_endian: bool) {
    macro_rules! sum {
        ($integer:ty, $from:ident, $to:ident) => {
            add(row, step, |one, other| <$integer>::$from(one).wrapping_add(<$integer>::$from(other)).$to())
        };
    }
    match (bits, is_little_endian) {
        (16, true) => sum!(u16, from_le_bytes, to_le_bytes),
        (16, false) => sum!(u16, from_be_bytes, to_be_bytes),
        (32, true) => sum!(u32, from_le_bytes, to_le_bytes),
        (32, false) => sum!(u32, from_be_bytes, to_be_bytes),
        (_, true) => sum!(u64, from_le_bytes, to_le_bytes),
        (_, false) => sum!(u64, from_be_bytes, to_be_bytes),
    }
}

fn add<const SIZE: usize>(row: &mut [u8], step: usize, sum: impl Fn([u8; SIZE], [u8; SIZE]) -> [u8; SIZE]) {
    let (numbers, _) = row.as_chunks_mut::<SIZE>();
    for place in step..numbers.len() {
        numbers[place] = sum(numbers[place], numbers[place - step]);
    }
}

/// Numbers of `SIZE` bytes, from all highest bytes, then all second ones, and so on.
fn gather<const SIZE: usize>(row: &mut [u8], is_little_endian: bool) {
    let sorted = row.to_vec();
    let count = row.len() / SIZE;
    let planes: [&[u8]; SIZE] = from_fn(|byte| {
        let significance = if is_little_endian { SIZE - 1 - byte } else { byte };
        &sorted[significance * count..][..count]
    });
    for (place, number) in row.as_chunks_mut::<SIZE>().0.iter_mut().enumerate() {
        *number = from_fn(|byte| planes[byte][place]);
    }
}
