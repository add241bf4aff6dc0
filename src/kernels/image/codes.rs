//! Decoding of integer images.

use ndarray::{Array3, ArrayView3};
use rayon::prelude::*;

use super::samples::check_channels;
use crate::error::Result;
use crate::interrupt;

/// Samples of a chunk, a whole number of pixels. Most maps are a whole number of chunks.
const SAMPLES_AT_ONCE: usize = 24;

/// For each of `codes`, its value in `table`; a code beyond the table gets the last value.
pub fn decode<Code: Copy + Into<usize> + Sync>(codes: ArrayView3<'_, Code>, table: &[f32]) -> Array3<f32> {
    let last = table.last().copied().unwrap_or(0.0);
    let value = |code: Code| table.get(code.into()).copied().unwrap_or(last);
    let Some(samples) = codes.as_slice() else { return codes.map(|&code| value(code)) };
    let (chunks, rest) = samples.as_chunks::<SAMPLES_AT_ONCE>();
    let chunk = |codes: &[Code; SAMPLES_AT_ONCE]| {
        interrupt::check();
        codes.map(value)
    };
    let values: Vec<_> = chunks.par_iter().with_min_len(1 << 10).map(chunk).collect();
    let mut values = values.into_flattened();
    values.extend(rest.iter().map(|&code| value(code)));
    Array3::from_shape_vec(codes.dim(), values).unwrap_or_else(|_| codes.map(|&code| value(code)))
}

/// For each of the `codes` of an image of three channels, its value in the table of its channel.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`] when the array is not (height, width, 3).
pub fn decode_channels<Code: Copy + Into<usize> + Sync>(
    codes: ArrayView3<'_, Code>,
    tables: [&[f32]; 3],
) -> Result<Array3<f32>> {
    check_channels(codes)?;
    let codes = codes.as_standard_layout();
    let last = tables.map(|table| table.last().copied().unwrap_or(0.0));
    let value =
        |channel: usize, code: Code| tables[channel].get(code.into()).copied().unwrap_or(last[channel]);
    let mut values = Array3::zeros(codes.dim());
    let rows = values.outer_iter_mut().into_par_iter().zip(codes.outer_iter());
    rows.for_each(|(mut row, codes)| {
        interrupt::check();
        let (Some(values), Some(codes)) = (row.as_slice_mut(), codes.as_slice()) else { return };
        for (values, &[red, green, blue]) in values.as_chunks_mut().0.iter_mut().zip(codes.as_chunks().0) {
            *values = [value(0, red), value(1, green), value(2, blue)];
        }
    });
    Ok(values)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use ndarray::s;

    #[test]
    fn each_channel_is_decoded_by_its_own_table_in_any_layout() {
        let tables =
            [1.0, 10.0, 100.0].map(|scale| (0..256).map(|code| code as f32 * scale).collect::<Vec<_>>());
        let tables = [&tables[0][..], &tables[1], &tables[2]];
        let codes = Array3::from_shape_fn((4, 6, 3), |(y, x, c)| (y * 60 + x * 3 + c) as u8);
        let all = decode_channels(codes.view(), tables).unwrap();
        let expected = |(y, x, c): (usize, usize, usize)| f32::from(codes[[y, x, c]]) * [1.0, 10.0, 100.0][c];
        assert_eq!(all, Array3::from_shape_fn((4, 6, 3), expected));
        let flipped = decode_channels(codes.slice(s![..;-1, ..;-1, ..]), tables).unwrap();
        assert_eq!(flipped, all.slice(s![..;-1, ..;-1, ..]));
        assert!(decode_channels(codes.slice(s![.., .., ..2]), tables).is_err());
    }

    #[test]
    fn a_code_beyond_the_table_of_its_channel_gets_the_last_value() {
        let codes = Array3::from_elem((1, 1, 3), 9_u16);
        let values = decode_channels(codes.view(), [&[1.0, 2.0], &[], &[0.0; 10]]).unwrap();
        assert_eq!(values.into_raw_vec_and_offset().0, [2.0, 0.0, 0.0]);
    }

    #[test]
    fn each_code_becomes_its_value_in_any_layout() {
        let table: Vec<f32> = (0..256).map(|code| code as f32 * 0.5).collect();
        let codes = Array3::from_shape_fn((4, 6, 3), |(y, x, c)| (y * 60 + x * 3 + c) as u8);
        let all = decode(codes.view(), &table);
        assert_eq!(all, codes.map(|&code| f32::from(code) * 0.5));
        let flipped = decode(codes.slice(s![..;-1, .., ..]), &table);
        assert_eq!(flipped, all.slice(s![..;-1, .., ..]));
    }
}
