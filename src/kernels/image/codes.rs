//! Decoding of integer images.

use ndarray::{Array3, ArrayView3};
use rayon::prelude::*;

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

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::s;

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
