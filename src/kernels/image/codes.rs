//! Decoding of images of integers and of half floats.

use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::{ArrayView2, ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::interrupt;

/// Write the value of each of the `codes`, (height, width, channels), into `values`, which is contiguous.
///
/// `tables` has one row for all channels, or one for each. A code beyond its table gets the last value.
///
/// # Errors
///
/// [`Error::WrongShape`] for another number of tables, or for empty ones.
pub fn decode<Code: Copy + Into<usize> + Sync>(
    codes: ArrayView3<'_, Code>,
    tables: ArrayView2<'_, f32>,
    mut values: ArrayViewMut3<'_, f32>,
) -> Result<()> {
    let (count, length) = tables.dim();
    if length == 0 || (count != 1 && count != codes.dim().2) {
        let shape = vec![count, length];
        return Err(Error::WrongShape { what: "tables", wanted: "(1 or channels, codes)", shape });
    }
    let (codes, tables) = (codes.as_standard_layout(), tables.as_standard_layout());
    let tables: Vec<&[f32]> = tables.outer_iter().filter_map(|table| table.to_slice()).collect();
    let rows = values.outer_iter_mut().into_par_iter().zip(codes.outer_iter());
    rows.for_each(|(mut values, codes)| {
        interrupt::check();
        if let (Some(values), Some(codes)) = (values.as_slice_mut(), codes.as_slice()) {
            decode_row(codes, &tables, values);
        }
    });
    Ok(())
}

/// Write the single precision of `halves`, (height, width, channels), into `values`, which is contiguous.
///
/// # Errors
///
/// [`Error::WrongShape`] for an array that is not contiguous.
pub fn widen(halves: ArrayView3<'_, f16>, mut values: ArrayViewMut3<'_, f32>) -> Result<()> {
    let shape = halves.shape().to_vec();
    let rows = values.outer_iter_mut().into_par_iter().zip(halves.outer_iter());
    rows.try_for_each(|(mut values, halves)| {
        interrupt::check();
        let (values, halves) = values.as_slice_mut().zip(halves.as_slice())?;
        halves.convert_to_f32_slice(values);
        Some(())
    })
    .ok_or(Error::WrongShape { what: "halves", wanted: "(height, width, channels), contiguous", shape })
}

fn decode_row<Code: Copy + Into<usize>>(codes: &[Code], tables: &[&[f32]], values: &mut [f32]) {
    let value = |table: &[f32], code: Code| table[code.into().min(table.len() - 1)];
    if let [table] = tables {
        for (out, &code) in values.iter_mut().zip(codes) {
            *out = value(table, code);
        }
        return;
    }
    for (values, codes) in values.chunks_exact_mut(tables.len()).zip(codes.chunks_exact(tables.len())) {
        for ((out, &code), table) in values.iter_mut().zip(codes).zip(tables) {
            *out = value(table, code);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::{Array2, Array3, array, s};

    use super::*;

    fn values_of(codes: ArrayView3<'_, u8>, tables: &Array2<f32>) -> Array3<f32> {
        let mut values = Array3::zeros(codes.dim());
        decode(codes, tables.view(), values.view_mut()).unwrap();
        values
    }

    #[test]
    fn each_channel_is_decoded_by_its_own_table_in_any_layout() {
        let scales = [1.0, 10.0, 100.0];
        let codes = Array3::from_shape_fn((4, 6, 3), |(y, x, c)| (y * 60 + x * 3 + c) as u8);
        for tables in [1, 3] {
            let of_channels = Array2::from_shape_fn((tables, 256), |(c, code)| code as f32 * scales[c]);
            let all = values_of(codes.view(), &of_channels);
            let scale = |channel: usize| scales[channel.min(tables - 1)];
            let expected = |(y, x, c): (usize, usize, usize)| f32::from(codes[[y, x, c]]) * scale(c);
            assert_eq!(all, Array3::from_shape_fn((4, 6, 3), expected));
            let flipped = values_of(codes.slice(s![..;-1, ..;-1, ..]), &of_channels);
            assert_eq!(flipped, all.slice(s![..;-1, ..;-1, ..]));
        }
    }

    #[test]
    fn a_code_beyond_the_table_of_its_channel_gets_the_last_value() {
        let codes = Array3::from_elem((1, 1, 3), 9_u8);
        let values = values_of(codes.view(), &array![[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
        assert_eq!(values.into_raw_vec_and_offset().0, [2.0, 4.0, 6.0]);
    }

    #[test]
    fn each_half_float_keeps_its_value() {
        let halves = Array3::from_shape_fn((256, 256, 1), |(y, x, _)| f16::from_bits((y * 256 + x) as u16));
        let mut values = Array3::zeros(halves.dim());
        widen(halves.view(), values.view_mut()).unwrap();
        for (half, value) in halves.iter().zip(&values) {
            assert!(half.to_f32().to_bits() == value.to_bits() || half.is_nan() && value.is_nan());
        }
    }

    #[test]
    fn two_tables_for_three_channels_and_empty_tables_are_refused() {
        let codes = Array3::from_elem((1, 1, 3), 9_u8);
        for shape in [(2, 4), (0, 4), (3, 0)] {
            let mut values = Array3::zeros(codes.dim());
            assert!(decode(codes.view(), Array2::zeros(shape).view(), values.view_mut()).is_err());
        }
    }
}
