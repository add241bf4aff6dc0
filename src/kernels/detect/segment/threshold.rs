//! The threshold above which a pixel is bright: from the map's own histogram, never absolute.
//!
//! ```text
//!   T = 2 q90                      twice the luminance that 90 % of the sphere does not exceed
//! ```
//!
//! Only the seen part of a map counts.
//!
//! If q90 is more than 12 times the median (a bright sky over a dark ground, a wall of windows), the
//! brightest tenth of the sphere is itself light. Then the flux-weighted cut of Otsu (1979) in log
//! luminance divides light from background, and T is twice the 95 % quantile of the luminance below the cut.
//! For the cut, luminance above 8 q90 counts as 8 q90: a sun many octaves above all else would draw the
//! cut above the sky or the windows.
//!
//! The bins are the exponent and the leading bits of the mantissa of luminance over mean luminance:
//! 1/32 of an octave, without a logarithm and without a sort, and the same bins for any scale of the map.

use rayon::prelude::*;

use super::working_image::WorkingImage;
use crate::kernels::image::SeenPart;

/// Bits of an `f32`'s mantissa that a bin ignores.
const IGNORED_BITS: u32 = 18;
const BINS_OF_AN_OCTAVE: usize = 1 << (23 - IGNORED_BITS);
/// The bins cover luminance over the mean from `2^-24` to `2^24`.
const OCTAVES_BELOW: u32 = 24;
const BINS: usize = 2 * OCTAVES_BELOW as usize * BINS_OF_AN_OCTAVE;
/// Solid angles are integers, in this many parts of the sphere: any order of addition gives the same sum.
const PARTS_OF_THE_SPHERE: f64 = (1_u64 << 52) as f64;

/// Rows of one parallel task.
const ROWS_AT_ONCE: usize = 64;

/// Background fraction of the sphere.
const BACKGROUND: f64 = 0.9;
/// Background fraction of the sphere below the cut.
const BACKGROUND_BELOW_CUT: f64 = 0.95;
/// A bright pixel exceeds the background by this factor.
const FACTOR: f64 = 2.0;
/// A background more than this many times the median is itself light.
const MOST_OVER_MEDIAN: f64 = 12.0;
/// For the cut, luminance counts as at most this many times the background.
const MOST_OVER_BACKGROUND: f64 = 8.0;

/// Rule that set a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Twice the luminance that most of the sphere does not exceed.
    Background,
    /// Twice the luminance that most of the sphere below the cut does not exceed: the brightest part is itself light.
    BelowCut,
    /// Threshold that the caller has set.
    Fixed,
}

impl Rule {
    /// Threshold over background, background fraction of the sphere, and the fraction that is itself light.
    ///
    /// `None` for a threshold of the caller.
    pub fn numbers(self) -> Option<(f64, f64, Option<f64>)> {
        match self {
            Self::Background => Some((FACTOR, BACKGROUND, None)),
            Self::BelowCut => Some((FACTOR, BACKGROUND_BELOW_CUT, Some(1.0 - BACKGROUND))),
            Self::Fixed => None,
        }
    }
}

/// Luminance above which a pixel is bright, and the rule that set it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// In units of the map's luminance.
    pub luminance: f64,
    /// The rule that set it.
    pub rule: Rule,
}

impl Threshold {
    /// A threshold that the caller has set.
    pub fn fixed(luminance: f64) -> Self {
        Self { luminance, rule: Rule::Fixed }
    }

    /// Luminance at which a light of the peak `P` ends: at least the fraction `extent` of it.
    ///
    /// The edge of a light cuts pixels. A pixel with a covered fraction c has the luminance `B + c (P - B)` over
    /// the background B. Let the light include the pixels with c of at least `c_0`. They add their part of the background
    /// to its flux, and it loses the light in the other pixels. All c are equally frequent, so both errors cancel at
    ///
    /// ```text
    ///   B (1 - c_0)^2 / 2 = P c_0^2 / 2   <=>   c_0 = 1 / (1 + sqrt(P / B))   <=>   level sqrt(B P)
    /// ```
    ///
    /// This level is the geometric mean of background and peak.
    pub fn edge(&self, peak: f64, extent: f64) -> f64 {
        (self.luminance / FACTOR * peak).sqrt().max(extent * peak)
    }
}

/// Choose the threshold of a map.
pub fn from_histogram(working: &WorkingImage) -> Threshold {
    // Count solid angle by luminance over mean luminance.
    let mean = working.mean();
    let histogram = Histogram::of(working, mean);
    // Take twice the background, unless that is itself light.
    let (median, background) = (histogram.quantile(0.5), histogram.quantile(BACKGROUND));
    if background <= MOST_OVER_MEDIAN * median {
        return Threshold { luminance: FACTOR * background * mean, rule: Rule::Background };
    }
    // Else divide light from background and take twice the background below the cut.
    let cut = histogram.clamp(MOST_OVER_BACKGROUND * background).flux_weighted_cut();
    let below = histogram.up_to(cut).quantile(BACKGROUND_BELOW_CUT);
    Threshold { luminance: FACTOR * below * mean, rule: Rule::BelowCut }
}

/// Solid angle by luminance over mean luminance.
struct Histogram {
    parts: Vec<u64>,
}

impl Histogram {
    /// Histogram of a working image with this `mean` luminance.
    fn of(working: &WorkingImage, mean: f64) -> Self {
        let per_mean = if mean > 0.0 { (1.0 / mean) as f32 } else { 0.0 };
        if let Some(seen) = &working.seen {
            return Self::of_seen(working, seen, per_mean);
        }
        let width = working.size.1;
        let parts =
            working.luminance.par_chunks(ROWS_AT_ONCE * width).zip(working.bands.par_chunks(ROWS_AT_ONCE));
        let of_rows = parts.map(|(rows, bands)| parts_of_rows(rows, bands, width, per_mean));
        let plus = |one: Vec<u64>, other: Vec<u64>| one.iter().zip(&other).map(|(a, b)| a + b).collect();
        Self { parts: of_rows.reduce(|| vec![0; BINS], plus) }
    }

    /// Histogram of the part that is seen: mean luminance of the seen part of each pixel, by its solid angle.
    fn of_seen(working: &WorkingImage, seen: &SeenPart, per_mean: f32) -> Self {
        let width = working.size.1;
        let mut parts = vec![0; BINS];
        let rows = working.luminance.chunks_exact(width).zip(seen.shares().chunks_exact(width));
        for ((row, shares), &band) in rows.zip(&working.bands) {
            let whole = parts_of_pixel(band, width) as f64;
            for (&value, &share) in row.iter().zip(shares).filter(|(_, share)| **share > 0.0) {
                parts[bin(value / share * per_mean)] += (f64::from(share) * whole) as u64;
            }
        }
        Self { parts }
    }

    /// Value that `share` of the solid angle does not exceed; linear within a bin.
    fn quantile(&self, share: f64) -> f64 {
        let total: u64 = self.parts.iter().sum();
        let target = share * total as f64;
        let mut below = 0.0;
        for (bin, &parts) in self.parts.iter().enumerate() {
            let parts = parts as f64;
            if below + parts >= target && parts > 0.0 {
                let (low, high) = (lower_edge(bin), lower_edge(bin + 1));
                return low + (target - below) / parts * (high - low);
            }
            below += parts;
        }
        0.0
    }

    /// Bin that divides the flux best into two groups of log luminance (Otsu 1979).
    ///
    /// It maximises the between-class variance `(m w - s)^2 / (w (1 - w))`, with the fraction `w` of the flux below the
    /// bin, its first moment `s` and the mean `m`.
    fn flux_weighted_cut(&self) -> usize {
        // Weight each bin by its flux; its number is proportional to its log luminance.
        let flux: Vec<f64> =
            self.parts.iter().enumerate().map(|(bin, &parts)| parts as f64 * lower_edge(bin)).collect();
        let total: f64 = flux.iter().sum();
        let mean: f64 = flux.iter().enumerate().map(|(bin, flux)| bin as f64 * flux).sum::<f64>() / total;
        // Start below the first flux: if all flux is in one bin, darker pixels lie below the cut.
        let first = flux.iter().position(|&flux| flux > 0.0).unwrap_or(0);
        let (mut best, mut most) = (first, 0.0);
        // Try a cut after each bin and keep the one of the largest variance between the groups.
        let (mut share, mut moment) = (0.0, 0.0);
        for (bin, flux) in flux.iter().enumerate() {
            share += flux / total;
            moment += bin as f64 * flux / total;
            if share > 1.0 - 1e-9 {
                break;
            }
            let variance = (mean * share - moment).powi(2) / (share * (1.0 - share));
            if variance > most {
                (best, most) = (bin + 1, variance);
            }
        }
        best
    }

    /// Histogram with luminance above `most` counted as `most`.
    fn clamp(&self, most: f64) -> Self {
        let last = bin(most as f32);
        let mut parts = self.parts[..=last].to_vec();
        parts[last] += self.parts[last + 1..].iter().sum::<u64>();
        Self { parts }
    }

    /// The bins below `end`.
    fn up_to(&self, end: usize) -> Self {
        Self { parts: self.parts[..end].to_vec() }
    }
}

/// Parts of the sphere in each bin, over some rows of the heights `bands`.
fn parts_of_rows(rows: &[f32], bands: &[f64], width: usize, per_mean: f32) -> Vec<u64> {
    // Count in four lanes: neighbours are often equal, and separate counters do not wait for each other.
    let mut parts = vec![[0; 4]; BINS];
    for (row, band) in rows.chunks_exact(width).zip(bands) {
        let share = parts_of_pixel(*band, width);
        for values in row.chunks(64) {
            // Find the bins of 64 pixels.
            let mut bins = [0; 64];
            for (bin_of, &value) in bins.iter_mut().zip(values) {
                *bin_of = bin(value * per_mean) as u32;
            }
            // Count them.
            let (fours, rest) = bins[..values.len()].as_chunks::<4>();
            for four in fours {
                for (lane, &bin) in four.iter().enumerate() {
                    parts[bin as usize][lane] += share;
                }
            }
            for &bin in rest {
                parts[bin as usize][0] += share;
            }
        }
    }
    // Add the lanes.
    parts.iter().map(|lanes| lanes.iter().sum()).collect()
}

/// Parts of the sphere in one of `width` pixels of a row of the height `band`.
fn parts_of_pixel(band: f64, width: usize) -> u64 {
    (band / 2.0 / width as f64 * PARTS_OF_THE_SPHERE) as u64
}

const FIRST_BITS: u32 = (127 - OCTAVES_BELOW) << (23 - IGNORED_BITS);

/// The bin of a value that is not negative. It is clamped as a float: one instruction instead of four.
fn bin(value: f32) -> usize {
    let lowest = f32::from_bits(FIRST_BITS << IGNORED_BITS);
    let highest = f32::from_bits(((FIRST_BITS + BINS as u32) << IGNORED_BITS) - 1);
    let value = if value > lowest { value } else { lowest };
    let value = if value < highest { value } else { highest };
    ((value.to_bits() >> IGNORED_BITS) - FIRST_BITS) as usize
}

/// The smallest value of a bin; the lowest bin starts at 0.
fn lower_edge(bin: usize) -> f64 {
    if bin == 0 { 0.0 } else { f64::from(f32::from_bits((bin as u32 + FIRST_BITS) << IGNORED_BITS)) }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::working_image::WorkingImage;
    use super::*;
    use crate::kernels::sphere::Registration;
    use approx::assert_relative_eq;
    use ndarray::{Array2, Array3};
    use std::f64::consts::PI;

    /// Threshold of a map with a cap of a luminance `above`, which covers a `share` of the sphere: (1 - cos theta) / 2.
    fn bright_cap(share: f64, above: f32) -> Threshold {
        let map = Array3::from_shape_fn((1000, 2000, 3), |(y, _, _)| {
            let theta = (y as f64 + 0.5) / 1000.0 * PI;
            if (1.0 - theta.cos()) / 2.0 < share { above } else { 1.0 }
        });
        from_histogram(&WorkingImage::of(map.view(), Registration::CellCentred, 2000).unwrap())
    }

    #[test]
    fn the_threshold_is_twice_the_background_up_to_a_tenth_of_light() {
        for share in [0.0, 0.05, 0.095] {
            let threshold = bright_cap(share, 100.0);
            assert_eq!(threshold.rule, Rule::Background);
            assert_relative_eq!(threshold.luminance, 2.0, max_relative = 0.04); // a bin's width
        }
    }

    #[test]
    fn beyond_a_tenth_of_light_it_is_twice_the_background_below_the_cut() {
        for share in [0.11, 0.3, 0.45] {
            let threshold = bright_cap(share, 100.0);
            assert_eq!(threshold.rule, Rule::BelowCut);
            assert_relative_eq!(threshold.luminance, 2.0, max_relative = 0.04);
        }
    }

    #[test]
    fn a_bright_half_below_twelve_medians_is_background() {
        let threshold = bright_cap(0.4, 8.0);
        assert_eq!(threshold.rule, Rule::Background);
        assert_relative_eq!(threshold.luminance, 16.0, max_relative = 0.04);
    }

    /// Luminance that a `share` of the sphere does not exceed, by a sort of all pixels.
    fn sorted_quantile(working: &WorkingImage, share: f64) -> f64 {
        let columns = working.size.1;
        let pixels = working.luminance.iter().enumerate();
        let mut pixels: Vec<(f32, f64)> = pixels.map(|(i, &y)| (y, working.bands[i / columns])).collect();
        pixels.sort_by(|one, other| one.0.total_cmp(&other.0));
        let expected = share * pixels.iter().map(|(_, band)| band).sum::<f64>();
        let mut below = 0.0;
        let reached = pixels.iter().find(|(_, band)| {
            below += band;
            below >= expected
        });
        f64::from(reached.unwrap().0)
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_pixels() {
        // Seven octaves, dark at the poles: without solid angles the median would be another.
        let map = Array3::from_shape_fn((64, 128, 3), |(y, x, _)| {
            let chance = ((y * 7919 + x * 104_729) % 1000) as f32 / 1000.0;
            (7.0 * chance * (y as f32 / 20.0).sin().abs()).exp2()
        });
        let working = WorkingImage::of(map.view(), Registration::CellCentred, 128).unwrap();
        let mean = working.mean();
        let histogram = Histogram::of(&working, mean);
        for share in [0.01, 0.1, 0.5, 0.9, 0.95, 0.999] {
            let (result, expected) = (histogram.quantile(share) * mean, sorted_quantile(&working, share));
            assert_relative_eq!(result, expected, max_relative = 1.0 / 32.0); // the width of a bin
        }
    }

    #[test]
    fn a_sun_does_not_draw_the_cut_above_the_windows() {
        // A fifth of the sphere at 100 against 1, and one row's cap at 1e6.
        let map = Array3::from_shape_fn((200, 400, 3), |(y, _, _)| match y {
            0 => 1e6_f32,
            1..60 => 100.0,
            _ => 1.0,
        });
        let threshold =
            from_histogram(&WorkingImage::of(map.view(), Registration::CellCentred, 400).unwrap());
        assert_eq!(threshold.rule, Rule::BelowCut);
        assert_relative_eq!(threshold.luminance, 2.0, max_relative = 0.04);
    }

    #[test]
    fn bins_are_in_the_order_of_luminance() {
        let values = [0.0, 1e-30, 1e-6, 0.5, 1.0, 1.02, 1.1, 3.0, 1e5, f32::MAX];
        let bins: Vec<usize> = values.iter().map(|&value| bin(value)).collect();
        assert!(bins.is_sorted(), "{bins:?}");
        assert!(bins.iter().all(|&bin| bin < BINS));
        for &value in &values[2..9] {
            let (low, high) = (lower_edge(bin(value)), lower_edge(bin(value) + 1));
            assert!(low <= f64::from(value) && f64::from(value) < high, "{low} {value} {high}");
        }
    }

    /// A map of seven octaves, whose upper half repeats in the lower one.
    fn mirrored_map() -> Array3<f32> {
        Array3::from_shape_fn((64, 128, 3), |(y, x, _)| {
            let row = y.min(63 - y);
            (7.0 * ((row * 7919 + x * 104_729) % 1000) as f32 / 1000.0).exp2()
        })
    }

    #[test]
    fn the_threshold_of_half_a_map_is_that_of_the_whole_one() {
        let mut map = mirrored_map();
        let image = |map: &Array3<f32>| WorkingImage::of(map.view(), Registration::CellCentred, 64).unwrap();
        let whole = from_histogram(&image(&map));
        // Hide the lower half, and half of each pixel of the upper one.
        let seen = Array2::from_shape_fn((64, 128), |(y, _)| if y < 32 { 0.5 } else { 0.0 });
        map.indexed_iter_mut().for_each(|((y, x, _), value)| *value *= seen[[y, x]]);
        let half = from_histogram(&image(&map).with_seen(Some(seen.view()), Registration::CellCentred));
        assert_relative_eq!(half.luminance, whole.luminance, max_relative = 1e-3);
        assert_eq!(half.rule, whole.rule);
        assert!(from_histogram(&image(&map)).luminance < 0.5 * whole.luminance);
    }

    #[test]
    fn a_share_of_one_everywhere_changes_nothing() {
        let map = mirrored_map();
        for columns in [128, 50, 16] {
            let working = WorkingImage::of(map.view(), Registration::CellCentred, columns).unwrap();
            let whole = from_histogram(&working);
            let ones = Array2::ones((64, 128));
            let seen = from_histogram(&working.with_seen(Some(ones.view()), Registration::CellCentred));
            assert_eq!(seen.rule, whole.rule);
            assert_relative_eq!(seen.luminance, whole.luminance, max_relative = 1e-12);
        }
    }
}
