//! Rows of a map as one: what a reduction reads the whole map for.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::ops::Range;

/// Mean of the `columns` of some rows, four rows at a time: fewer passes over what is summed. Whether
/// a sample has a minus sign is seen on the way.
#[inline(always)]
pub(crate) fn weighted_mean(
    rows: &[&[f32]],
    weights: &[f32],
    columns: Range<usize>,
    mean: &mut [f32],
) -> bool {
    let mut bits = 0;
    let (fours, rest) = rows.as_chunks::<4>();
    for (i, (rows, weights)) in fours.iter().zip(weights.as_chunks::<4>().0).enumerate() {
        let rows = rows.map(|row| &row[columns.clone()]);
        bits |= if i == 0 {
            add_four::<true>(rows, weights, mean)
        } else {
            add_four::<false>(rows, weights, mean)
        };
    }
    if fours.is_empty() {
        mean.fill(0.0);
    }
    for (row, weight) in rest.iter().zip(&weights[4 * fours.len()..]) {
        for (mean, sample) in mean.iter_mut().zip(&row[columns.clone()]) {
            *mean += weight * sample;
            bits |= sample.to_bits();
        }
    }
    bits >> 31 == 1
}

/// Add four weighted rows to `mean`, or set it to their sum if they are the `FIRST`; the bits of all samples.
#[inline(always)]
fn add_four<const FIRST: bool>([a, b, c, d]: [&[f32]; 4], weights: &[f32; 4], mean: &mut [f32]) -> u32 {
    let mut bits = 0;
    for ((((mean, a), b), c), d) in mean.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let before = if FIRST { 0.0 } else { *mean };
        *mean = before + ((weights[0] * a + weights[1] * b) + (weights[2] * c + weights[3] * d));
        bits |= (a.to_bits() | b.to_bits()) | (c.to_bits() | d.to_bits());
    }
    bits
}
