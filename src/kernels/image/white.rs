//! Clip level of a picture of codes, found in its own histogram.
//!
//! Tone-mapped pictures end at 250, 240 or 235 of 255 codes. Clipping piles up solid angle at one code, above which there
//! is nearly nothing; JPEG compression spreads it by a few codes.

use ndarray::{ArrayView1, ArrayView3, Axis};
use rayon::prelude::*;

use super::sample_types::{Sample, larger};
use crate::interrupt;

/// Samples of this fraction of the clip level are clipped: code 254 of 255, because JPEG compression blurs them.
pub const LEAST_WHITE: f64 = 0.985;

/// Number of codes; codes of 16 bits are counted by their nearest code of 8 bits.
pub const CODES: usize = 256;

/// Settings of the spike at the clip level.
struct SpikeSettings {
    /// Smallest code that can be the clip level; bright walls end at smaller ones.
    least_code: usize,
    /// Number of codes by which JPEG compression spreads the spike.
    spread: usize,
    /// Number of codes below the spike that are compared with it.
    compared: usize,
    /// Least ratio of the spike's highest code to the mean of the compared codes.
    least_ratio: f64,
    /// Largest solid angle above the spike, as a fraction of the spike: ringing at the edges of a clipped region.
    most_above: f64,
    /// Least ratio of the two largest codes to the two below them in a picture that uses the full range. Ringing
    /// at a lower clip level is smooth there.
    full_ratio: f64,
    /// Least solid angle of the two largest codes in such a picture, as a fraction of the largest spike.
    least_full: f64,
    /// Range of the fraction of the sphere: a disc of 0.8 degrees in radius, and an even background. At 2e-5 smooth
    /// pictures are called clipped more often (`benchmarks/white.py`: 10.9 instead of 9.7 %), and no more are found.
    fractions: (f64, f64),
}

const SPIKE: SpikeSettings = SpikeSettings {
    least_code: 225,
    spread: 3,
    compared: 8,
    least_ratio: 2.5,
    most_above: 0.7,
    full_ratio: 8.0,
    least_full: 0.1,
    fractions: (5e-5, 0.5),
};

/// Clip level as a code, from the solid angle of each code of the largest channel; `None` if nothing is clipped.
pub fn white_of(histogram: &[f64; CODES]) -> Option<usize> {
    let total: f64 = histogram.iter().sum();
    let spikes = (SPIKE.least_code..CODES).filter_map(|code| Some((code, spike(histogram, total, code)?)));
    let largest = spikes.reduce(|a, b| if b.1 > a.1 { b } else { a });
    let (below, full) = (&histogram[CODES - 4..CODES - 2], &histogram[CODES - 2..]);
    let (below, full): (f64, f64) = (below.iter().sum(), full.iter().sum());
    let least = largest.map_or(SPIKE.fractions.0 * total, |(_, solid_angle)| SPIKE.least_full * solid_angle);
    if full > least && full >= SPIKE.full_ratio * below {
        return Some(CODES - 1);
    }
    largest.map(|(code, _)| code)
}

/// Solid angle of the spike at `code`; `None` if there is no spike.
fn spike(histogram: &[f64; CODES], total: f64, code: usize) -> Option<f64> {
    let end = (code + SPIKE.spread + 1).min(CODES);
    let start = code - SPIKE.spread;
    let near = &histogram[start..end];
    let (solid_angle, highest) = (near.iter().sum::<f64>(), near.iter().copied().fold(0.0, f64::max));
    let above: f64 = histogram[end..].iter().sum();
    let below = histogram[start - SPIKE.compared..start].iter().sum::<f64>() / SPIKE.compared as f64;
    let (least, most) = SPIKE.fractions;
    let is_spike = histogram[code] >= highest
        && solid_angle > least * total
        && solid_angle <= most * total
        && above <= SPIKE.most_above * solid_angle
        && histogram[code] >= SPIKE.least_ratio * below;
    is_spike.then_some(solid_angle)
}

/// Sums of the weights of rows over pixels, by the code of the largest channel.
pub fn code_histogram<Code: Sample>(
    codes: ArrayView3<'_, Code>,
    weights: ArrayView1<'_, f64>,
) -> [f64; CODES] {
    let channels = codes.dim().2.max(1);
    let codes = codes.as_standard_layout();
    let rows: Vec<[u32; CODES]> = codes
        .axis_iter(Axis(0))
        .into_par_iter()
        .map(|row| {
            interrupt::check();
            let mut counts = [0; CODES];
            for pixel in row.as_slice().unwrap_or(&[]).chunks_exact(channels) {
                let largest = pixel.iter().fold(pixel[0], |largest, &code| larger(largest, code));
                counts[Code::as_8_bits(largest.code())] += 1;
            }
            counts
        })
        .collect();
    let mut histogram = [0.0; CODES];
    for (counts, weight) in rows.iter().zip(weights) {
        histogram.iter_mut().zip(counts).for_each(|(sum, &count)| *sum += f64::from(count) * weight);
    }
    histogram
}

#[cfg(test)]
mod tests {
    use ndarray::{Array3, array};

    use super::*;

    /// A background whose density falls towards the top, and a spike.
    fn picture(code: usize, fraction: f64) -> [f64; CODES] {
        let mut histogram = std::array::from_fn(|code| 1e-2 * (-(code as f64) / 60.0).exp());
        histogram[code + 1..].fill(0.0);
        histogram[code] += fraction;
        histogram
    }

    #[test]
    fn a_spike_at_any_end_is_the_clip_level() {
        for code in [225, 235, 240, 250, 255] {
            assert_eq!(white_of(&picture(code, 0.01)), Some(code));
        }
    }

    #[test]
    fn a_spike_that_compression_spreads_is_found() {
        let mut histogram = picture(240, 0.01);
        for (code, fraction) in [(239, 4e-3), (241, 3e-3), (243, 1e-3), (247, 5e-4), (255, 2e-4)] {
            histogram[code] += fraction;
        }
        assert_eq!(white_of(&histogram), Some(240));
    }

    #[test]
    fn a_lamp_at_the_largest_code_is_above_an_even_wall() {
        let mut histogram = picture(250, 0.017);
        histogram[255] = 0.004;
        assert_eq!(white_of(&histogram), Some(255));
    }

    #[test]
    fn a_smooth_end_a_broad_wall_and_an_even_sky_are_not_clipped() {
        assert_eq!(white_of(&picture(240, 0.0)), None);
        let wall: [f64; CODES] = std::array::from_fn(|code| (-((code as f64 - 236.0) / 7.0).powi(2)).exp());
        assert_eq!(white_of(&wall), None);
        assert_eq!(white_of(&picture(240, 9.0)), None, "most of the sphere is even");
        assert_eq!(white_of(&[0.0; CODES]), None);
    }

    #[test]
    fn pixels_are_counted_by_their_largest_channel_and_the_weight_of_their_row() {
        let mut codes = Array3::<u8>::zeros((2, 3, 3));
        codes[[0, 0, 2]] = 240;
        codes[[1, 2, 0]] = 240;
        let histogram = code_histogram(codes.view(), array![0.5, 2.0].view());
        assert!((histogram[240] - 2.5).abs() < 1e-12 && (histogram[0] - 5.0).abs() < 1e-12);
        let codes = codes.map(|&code| u16::from(code) * 257);
        let of_16_bits = code_histogram(codes.view(), array![0.5, 2.0].view());
        assert!(of_16_bits.iter().zip(histogram).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
