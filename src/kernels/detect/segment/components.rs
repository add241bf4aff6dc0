//! The component tree: which bright pixels form one segment, from the brightest peak down.
//!
//! Lower a water level from above: peaks appear as islands, brightest first. Where two islands meet, the
//! level is their *saddle*: the darkest pixel on the brightest path between the two peaks. The dimmer peak
//! remains a separate light only if
//!
//! ```text
//!   peak / saddle >= prominence
//! ```
//!
//! else the brighter absorbs it. The line check of Loghin (2021) tries one straight path instead.
//!
//! The tree needs no pixel in order of luminance. Each pixel flows uphill, to its brightest neighbour,
//! to one peak: its basin. Islands meet only between basins, so only those pairs of pixels are sorted.

use rayon::prelude::*;

use super::adjacency::Adjacency;
use super::forest::{root, singletons};
use super::run::{RUNS_OF_A_TASK, Run, runs};
use super::threshold::Threshold;
use super::working_image::WorkingImage;
use crate::kernels::detect::clipping::largest;

/// Settings of the ceiling of a picture that a camera has clipped.
struct CeilingSettings {
    /// Least ratio of a clipped light's peak to the threshold.
    least_rise: f32,
    /// This many pixels at the map's maximum form a ceiling.
    pixels: usize,
    /// Pixels of this fraction of the maximum and more are at the ceiling.
    level: f32,
}

const CEILING: CeilingSettings = CeilingSettings { least_rise: 1.2, pixels: 3, level: 1.0 - 1e-5 };

/// The pixels of each light, before it is measured.
pub struct Segments {
    /// Flat indices into the working image, one list for each light.
    pub pixels: Vec<Vec<u32>>,
    /// Luminance of each light's brightest pixel.
    pub peaks: Vec<f32>,
    /// For each pixel of the working image its light plus 1, 0 where the pixel is below the light's edge.
    pub label: Vec<u32>,
}

impl Segments {
    /// Segments without any light yet, over pixels with these labels.
    pub fn empty(label: Vec<u32>) -> Self {
        Self { pixels: Vec::new(), peaks: Vec::new(), label }
    }

    /// Add a segment; its labelled pixels get its number, counted from 1, as their label.
    pub fn push(&mut self, pixels: Vec<u32>, peak: f32) {
        self.peaks.push(peak);
        self.relabel(&pixels, self.peaks.len() as u32);
        self.pixels.push(pixels);
    }

    /// Replace the labels of some pixels by a `new` one; pixels without a label stay without.
    pub fn relabel(&mut self, pixels: &[u32], new: u32) {
        for &pixel in pixels {
            let label = &mut self.label[pixel as usize];
            *label = if *label == 0 { 0 } else { new };
        }
    }
}

/// Rules for the peaks that are separate lights, and for the edges of lights.
#[derive(Clone, Copy, Debug)]
pub struct TreeRule {
    /// Least ratio of a peak to the threshold.
    pub rise: f64,
    /// Least ratio of a peak to its saddle.
    pub prominence: f64,
    /// A light ends where its luminance has fallen to this fraction of its peak.
    pub extent: f64,
}

/// Divide the bright pixels into the segments of lights.
pub fn segments(
    working: &WorkingImage,
    adjacency: &Adjacency,
    bright: &[u32],
    threshold: &Threshold,
    rule: &TreeRule,
) -> Segments {
    let &TreeRule { rise, prominence, extent } = rule;
    // Divide the bright pixels into basins, one for each peak.
    let luminance = &working.luminance;
    let level: Vec<f32> = bright.iter().map(|&index| luminance[index as usize]).collect();
    let runs = runs(bright, working.size.1);
    let (basin, image) = basins(adjacency, luminance, bright, &runs);
    // Join basins over their saddles, and number the lights.
    let border = border(adjacency, luminance, &runs, &image);
    let light = absorb(adjacency, luminance, &border, &image, &level, prominence as f32);
    let lowest_peak = lowest_peak(&level, threshold, rise as f32);
    let (label_of_basin, peaks) = labels(light, &level, &basin, lowest_peak);
    // Collect the pixels of each light, and label those within its edge.
    let edges: Vec<f32> = peaks.iter().map(|&peak| threshold.edge(f64::from(peak), extent) as f32).collect();
    let mut segments = Segments { pixels: vec![Vec::new(); peaks.len()], peaks, label: image };
    let mut end = 0;
    for basin in basin.chunk_by(|one, other| one == other) {
        let own = end..end + basin.len();
        end = own.end;
        let label = label_of_basin[basin[0] as usize];
        let edge = if label == 0 { f32::INFINITY } else { edges[label as usize - 1] };
        for (&index, &level) in bright[own.clone()].iter().zip(&level[own.clone()]) {
            segments.label[index as usize] = if level >= edge { label } else { 0 };
        }
        if label > 0 {
            segments.pixels[label as usize - 1].extend_from_slice(&bright[own]);
        }
    }
    segments
}

/// For each peak, the label of its light, 0 below the `lowest_peak`; and the peaks of the lights.
fn labels(mut light: Vec<u32>, level: &[f32], basin: &[u32], lowest_peak: f32) -> (Vec<u32>, Vec<f32>) {
    let (mut labels, mut peaks) = (vec![0; level.len()], Vec::new());
    for peak in (0..level.len()).filter(|&pixel| basin[pixel] as usize == pixel) {
        let highest = root(&mut light, peak as u32) as usize;
        if labels[highest] == 0 && level[highest] >= lowest_peak {
            peaks.push(level[highest]);
            labels[highest] = peaks.len() as u32;
        }
        labels[peak] = labels[highest];
    }
    (labels, peaks)
}

/// The luminance that a light must reach, from the levels of the bright pixels.
///
/// A light rises by a factor above the threshold, and extends down to it (hysteresis). At the ceiling of a clipped
/// picture the true luminance is unknown, so a light need not rise as far.
fn lowest_peak(level: &[f32], threshold: &Threshold, rise: f32) -> f32 {
    let ceiling = CEILING.level * largest(level);
    let threshold = threshold.luminance as f32;
    let is_clipped = level.iter().filter(|&&level| level >= ceiling).count() >= CEILING.pixels;
    let enough = rise * threshold;
    if is_clipped { enough.min(ceiling.max(CEILING.least_rise * threshold)) } else { enough }
}

/// The peak that each bright pixel flows to, as an index into the bright pixels and as an image.
///
/// The image holds the index plus 1, and 0 for dark pixels.
fn basins(adjacency: &Adjacency, luminance: &[f32], bright: &[u32], runs: &[Run]) -> (Vec<u32>, Vec<u32>) {
    // Write the index of each bright pixel into an image.
    let mut image = vec![0; luminance.len()];
    for (number, &pixel) in (0..).zip(bright) {
        image[pixel as usize] = number;
    }
    // Point each pixel to the highest pixel around it, itself included.
    let uphill = |runs: &[Run]| {
        let (mut uphill, mut columns) = (Vec::new(), Vec::new());
        for run in runs {
            let highest =
                adjacency.around_each(run, &mut columns, |index| height(luminance, index), u64::max);
            uphill.extend(highest.map(|highest| image[!(highest as u32) as usize]));
        }
        uphill
    };
    let mut basin: Vec<u32> = runs.par_chunks(RUNS_OF_A_TASK).map(uphill).collect::<Vec<_>>().concat();
    // Follow the pointers up to the peaks.
    for (number, &pixel) in (0..).zip(bright) {
        basin[number as usize] = root(&mut basin, number);
        image[pixel as usize] = basin[number as usize] + 1;
    }
    (basin, image)
}

/// Heights of the bright pixels that touch another basin than their own, highest first.
fn border(adjacency: &Adjacency, luminance: &[f32], runs: &[Run], basin: &[u32]) -> Vec<u64> {
    // Take the first and the last of the basins around a pixel. For a dark pixel, 0, the last is below all
    // others and the first wraps around to above them.
    let ends = |index: usize| (basin[index].wrapping_sub(1), basin[index]);
    let wider = |a: (u32, u32), b: (u32, u32)| (a.0.min(b.0), a.1.max(b.1));
    // Keep the pixels that have more than one basin around them.
    let on_border = |runs: &[Run]| {
        let (mut border, mut columns) = (Vec::new(), Vec::new());
        for run in runs {
            let around = adjacency.around_each(run, &mut columns, ends, wider);
            let touching = adjacency.pixels(run).zip(around).filter(|(_, (first, last))| first + 1 != *last);
            border.extend(touching.map(|(index, _)| !height(luminance, index)));
        }
        border
    };
    // Sort them, highest first: their heights are inverted.
    let mut border = runs.par_chunks(RUNS_OF_A_TASK).map(on_border).collect::<Vec<_>>().concat();
    border.par_sort_unstable();
    border
}

/// Luminance and index as one number, in the order of luminance; the earlier of two equal pixels is higher.
///
/// The bits of non-negative floats are in the order of the floats.
fn height(luminance: &[f32], index: usize) -> u64 {
    (u64::from(luminance[index].to_bits()) << 32) | u64::from(!(index as u32))
}

/// Let brighter peaks absorb dimmer ones; return a forest whose roots are the peaks of the lights.
///
/// Two islands meet at the first pixel that touches both: the lower one of a pair.
fn absorb(
    adjacency: &Adjacency,
    luminance: &[f32],
    border: &[u64],
    basin: &[u32],
    level: &[f32],
    prominence: f32,
) -> Vec<u32> {
    let mut island = singletons(level.len());
    let mut light = island.clone();
    // Lower the level from one border pixel to the next.
    for own in border.iter().map(|inverted| !inverted) {
        let (saddle, index) = (f32::from_bits((own >> 32) as u32), !(own as u32) as usize);
        for other in adjacency.around(index) {
            if basin[other] == 0 || basin[other] == basin[index] || height(luminance, other) < own {
                continue;
            }
            // Find the two islands that meet here, at their saddle.
            let (one, other) = (root(&mut island, basin[index] - 1), root(&mut island, basin[other] - 1));
            if one != other {
                // Join them, and let the higher peak absorb the lower one if that is not prominent.
                let one_is_higher = level[one as usize] >= level[other as usize];
                let (higher, lower) = if one_is_higher { (one, other) } else { (other, one) };
                island[lower as usize] = higher;
                if level[lower as usize] < prominence * saddle {
                    light[lower as usize] = higher;
                }
            }
        }
    }
    light
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::super::bright_pixels::bright_pixels;
    use super::super::test_maps::{rows_from, segments, sizes, working_image_of};
    use super::*;

    /// Pixels of each light in one row between dark ones, the smallest light first.
    fn in_a_row(row: &str) -> Vec<usize> {
        sizes(&segments(&rows_from(4, &[row]), 0.0))
    }

    #[test]
    fn two_lamps_are_two_where_the_path_falls_to_a_quarter_of_the_dimmer() {
        assert_eq!(in_a_row("....93338......."), [5]);
        // 8 / 2 is 4: just enough. Of equal pixels the left one counts as higher.
        assert_eq!(in_a_row("....92228......."), [2, 3]);
        assert_eq!(in_a_row("....91118......."), [2, 3]);
        assert_eq!(in_a_row("....92227......."), [5]);
    }

    #[test]
    fn a_light_rises_above_the_threshold_and_extends_down_to_it() {
        assert_eq!(in_a_row("....1..........."), [0; 0]); // 1 is bright, 1.25 would be a light
        assert_eq!(in_a_row("...121.....1...."), [3]);
    }

    #[test]
    fn at_the_ceiling_of_a_clipped_picture_a_light_need_not_rise_as_far() {
        assert_eq!(in_a_row("....11.........."), [0; 0]);
        assert_eq!(in_a_row("....111........."), [3]);
        assert_eq!(in_a_row("....111....9...."), [1]); // here the ceiling is higher
    }

    #[test]
    fn labelled_pixels_are_within_the_edge() {
        let working = rows_from(4, &["....1295......1."]);
        let segments = segments(&working, 0.5);
        assert_eq!(segments.pixels[0].len(), 4);
        let labelled: Vec<usize> = (0..128).filter(|&i| segments.label[i] == 1).collect();
        assert_eq!(labelled, [4 * 16 + 6, 4 * 16 + 7]); // 9 and 5, not 2 and 1
        assert_eq!(segments.label.iter().filter(|&&label| label != 0).count(), 2);
        assert!((segments.peaks[0] - 9.0).abs() < 1e-5);
    }

    /// For each pixel, the first one of its light plus 1, by the tree of all pixels from the brightest down.
    fn plain_lights(working: &WorkingImage, prominence: f32) -> Vec<usize> {
        let (luminance, adjacency) = (&working.luminance, Adjacency::of(working));
        let mut falling: Vec<usize> = (0..luminance.len()).filter(|&pixel| luminance[pixel] > 0.5).collect();
        falling.sort_by_key(|&pixel| !height(luminance, pixel));
        let mut island = singletons(luminance.len());
        let mut light = island.clone();
        for &pixel in &falling {
            // Let the pixel flow to its highest neighbour, if one is higher.
            let is_higher = |&other: &usize| height(luminance, other) > height(luminance, pixel);
            let higher: Vec<usize> = adjacency.around(pixel).into_iter().filter(is_higher).collect();
            let Some(&highest) = higher.iter().max_by_key(|&&other| height(luminance, other)) else {
                continue;
            };
            island[pixel] = root(&mut island, highest as u32);
            light[pixel] = highest as u32;
            // Join the islands that it touches, at its level.
            for other in higher {
                let (one, other) = (root(&mut island, pixel as u32), root(&mut island, other as u32));
                let level = |island: u32| luminance[island as usize];
                let (above, below) = if level(one) >= level(other) { (one, other) } else { (other, one) };
                island[below as usize] = above;
                if level(below) < prominence * luminance[pixel] {
                    light[below as usize] = above;
                }
            }
        }
        let lights: Vec<u32> = (0..luminance.len() as u32).map(|pixel| root(&mut light, pixel)).collect();
        let first = |pixel: usize| lights.iter().position(|&light| light == lights[pixel]);
        (0..lights.len())
            .map(|pixel| if luminance[pixel] > 0.5 { first(pixel).map_or(0, |i| i + 1) } else { 0 })
            .collect()
    }

    proptest! {
        #[test]
        fn basins_are_the_tree_of_all_pixels(
            levels in prop::collection::vec(prop_oneof![Just(0.1_f32), Just(1.0), Just(8.0), 0.6..9.0_f32], 8 * 16),
            prominence in 1.5..5.0,
        ) {
            let working = working_image_of(&["................"; 8]).with_luminance(levels);
            let bright = bright_pixels(&working, 0.5);
            let none = Threshold { luminance: 0.0, ..super::super::test_maps::THRESHOLD };
            let adjacency = Adjacency::of(&working);
            let result = super::segments(&working, &adjacency, &bright.indices, &none, &TreeRule { rise: 1.0, prominence, extent: 0.0 });
            let mut first = vec![0; 8 * 16];
            for pixels in &result.pixels {
                for &pixel in pixels {
                    first[pixel as usize] = pixels[0] as usize + 1;
                }
            }
            prop_assert_eq!(first, plain_lights(&working, prominence as f32));
        }
    }
}
