//! Which bright pixels hang together: the component tree, from the brightest peak down.
//!
//! Flood the map with darkness from above: peaks appear, brightest first, as islands. Where two
//! islands meet, the level is their *saddle*: the darkest place on the brightest path between the two
//! peaks. The dimmer stays a light of its own only if
//!
//! ```text
//!   peak / saddle >= prominence
//! ```
//!
//! else the brighter absorbs it. The article's line check is one straight guess at that path.
//!
//! The tree needs no pixel in order of luminance. Each pixel flows uphill, to its brightest neighbour,
//! to one peak: its basin. Islands meet only between basins, so only those pairs of pixels are sorted.

use ndarray::ArrayView1;
use rayon::prelude::*;

use super::Options;
use super::run::{Run, runs};
use super::summary::{Summary, TILE};
use super::threshold::Threshold;
use super::touch::Sheet;

/// A light rises this far above the threshold; down to the threshold it extends (hysteresis).
const HYSTERESIS: f32 = 2.5;
/// A light that is clipped rises this far, at least.
const CLIPPED_HYSTERESIS: f32 = 1.2;
/// Runs that are looked at together.
const RUNS_AT_ONCE: usize = 64;
/// As many pixels as this, so much alike, at the map's maximum are a ceiling where a camera saturates.
const CEILING_PIXELS: usize = 3;
const CEILING: f32 = 1.0 - 1e-5;

/// Pixels above the threshold, as flat indices into the working image.
pub struct BrightPixels {
    /// In ascending order.
    pub indices: Vec<u32>,
    /// Tiles that were opened to find them.
    pub opened_tiles: usize,
}

/// Pixels brighter than `threshold`, from the tiles that hold any.
pub fn bright_pixels(summary: &Summary, threshold: f64) -> BrightPixels {
    let threshold = threshold as f32;
    let (height, width) = summary.size;
    let is_open = |&&maximum: &&f32| maximum > threshold;
    let bright_in = |(tile_row, maxima): (usize, ArrayView1<'_, f32>)| {
        let open = maxima.iter().enumerate().filter(|(_, maximum)| is_open(maximum));
        let open: Vec<_> = open.map(|(tile, _)| tile * TILE..((tile + 1) * TILE).min(width)).collect();
        let mut bright = Vec::new();
        for row in tile_row * TILE..((tile_row + 1) * TILE).min(height) {
            for columns in &open {
                let pixels = row * width + columns.start..row * width + columns.end;
                let pixels = pixels.filter(|&index| summary.luminance[index] > threshold);
                bright.extend(pixels.map(|index| index as u32));
            }
        }
        bright
    };
    let tile_rows = summary.tile_maxima.outer_iter().into_par_iter().enumerate();
    BrightPixels {
        indices: tile_rows.map(bright_in).collect::<Vec<_>>().concat(),
        opened_tiles: summary.tile_maxima.iter().filter(is_open).count(),
    }
}

/// The pixels of each light, before anything is measured.
pub struct Regions {
    /// Flat indices into the working image, one list for each light.
    pub pixels: Vec<Vec<u32>>,
    /// Luminance of each light's brightest pixel.
    pub peaks: Vec<f32>,
    /// Light of each pixel of the working image that is above the edge of its light, plus 1; else 0.
    pub label: Vec<u32>,
}

/// The lights among the bright pixels.
pub fn regions(
    summary: &Summary,
    sheet: &Sheet,
    bright: &BrightPixels,
    threshold: &Threshold,
    options: &Options,
) -> Regions {
    let luminance = &summary.luminance;
    let level: Vec<f32> = bright.indices.iter().map(|&index| luminance[index as usize]).collect();
    let runs = runs(&bright.indices, summary.size.1);
    let (basin, image) = basins(sheet, luminance, bright, &runs);
    let border = border(sheet, luminance, &runs, &image);
    let light = absorb(sheet, luminance, &border, &image, &level, options.prominence as f32);
    let (label_of_basin, peaks) = labels(light, &level, &basin, threshold);
    let edges: Vec<f32> =
        peaks.iter().map(|&peak| threshold.edge(f64::from(peak), options.extent) as f32).collect();
    let mut regions = Regions { pixels: vec![Vec::new(); peaks.len()], peaks, label: image };
    for ((&index, &basin), &level) in bright.indices.iter().zip(&basin).zip(&level) {
        let label = label_of_basin[basin as usize];
        let is_within = label > 0 && level >= edges[label as usize - 1];
        regions.label[index as usize] = if is_within { label } else { 0 };
        if label > 0 {
            regions.pixels[label as usize - 1].push(index);
        }
    }
    regions
}

/// For each peak the label of its light, 0 where that does not rise high enough; and the peaks of the
/// lights.
fn labels(mut light: Vec<u32>, level: &[f32], basin: &[u32], threshold: &Threshold) -> (Vec<u32>, Vec<f32>) {
    let lowest_peak = lowest_peak(level, threshold.luminance as f32);
    let (mut labels, mut peaks) = (vec![0; level.len()], Vec::new());
    for peak in (0..level.len()).filter(|&place| basin[place] as usize == place) {
        let highest = root(&mut light, peak as u32) as usize;
        if labels[highest] == 0 && level[highest] >= lowest_peak {
            peaks.push(level[highest]);
            labels[highest] = peaks.len() as u32;
        }
        labels[peak] = labels[highest];
    }
    (labels, peaks)
}

/// The luminance that a light must reach, among the levels of the bright pixels.
///
/// At the ceiling of a clipped picture nobody knows how bright a light is: it need not rise as far.
fn lowest_peak(level: &[f32], threshold: f32) -> f32 {
    let ceiling = CEILING * level.iter().copied().fold(0.0, f32::max);
    let is_clipped = level.iter().filter(|&&level| level >= ceiling).count() >= CEILING_PIXELS;
    let enough = HYSTERESIS * threshold;
    if is_clipped { enough.min(ceiling.max(CLIPPED_HYSTERESIS * threshold)) } else { enough }
}

/// Luminance and place as one number, in the order of luminance: the bits of floats that are not
/// negative are in the order of the floats. Of two pixels alike the earlier one is higher.
fn height(luminance: &[f32], index: usize) -> u64 {
    (u64::from(luminance[index].to_bits()) << 32) | u64::from(!(index as u32))
}

/// The peak that each bright pixel flows to, as a place among the bright pixels; and the same plus 1 as
/// an image, 0 where it is dark.
fn basins(sheet: &Sheet, luminance: &[f32], bright: &BrightPixels, runs: &[Run]) -> (Vec<u32>, Vec<u32>) {
    let mut image = vec![0; luminance.len()];
    for (place, &index) in (0..).zip(&bright.indices) {
        image[index as usize] = place;
    }
    let uphill = |runs: &[Run]| {
        let (mut uphill, mut columns) = (Vec::new(), Vec::new());
        for run in runs {
            let highest = sheet.around_each(run, &mut columns, |index| height(luminance, index), u64::max);
            uphill.extend(highest.map(|highest| image[!(highest as u32) as usize]));
        }
        uphill
    };
    let mut basin = runs.par_chunks(RUNS_AT_ONCE).map(uphill).collect::<Vec<_>>().concat();
    for place in 0..basin.len() {
        basin[place] = root(&mut basin, place as u32);
        image[bright.indices[place] as usize] = basin[place] + 1;
    }
    (basin, image)
}

/// Heights of the pixels that touch another basin than their own, highest first.
fn border(sheet: &Sheet, luminance: &[f32], runs: &[Run], basin: &[u32]) -> Vec<u64> {
    // The first and the last of the basins around: of the dark, 0, the last is below all others, and the
    // first wraps to above them.
    let ends = |index: usize| (basin[index].wrapping_sub(1), basin[index]);
    let wider = |a: (u32, u32), b: (u32, u32)| (a.0.min(b.0), a.1.max(b.1));
    let on_border = |runs: &[Run]| {
        let (mut border, mut columns) = (Vec::new(), Vec::new());
        for run in runs {
            let around = sheet.around_each(run, &mut columns, ends, wider);
            let touching = sheet.pixels(run).zip(around).filter(|(_, (first, last))| first + 1 != *last);
            border.extend(touching.map(|(index, _)| !height(luminance, index)));
        }
        border
    };
    let mut border = runs.par_chunks(RUNS_AT_ONCE).map(on_border).collect::<Vec<_>>().concat();
    border.par_sort_unstable();
    border
}

/// For each peak the one whose light it is part of, as a forest.
///
/// Two islands meet where the first pixel appears that touches both: the lower one of a pair.
fn absorb(
    sheet: &Sheet,
    luminance: &[f32],
    border: &[u64],
    basin: &[u32],
    level: &[f32],
    prominence: f32,
) -> Vec<u32> {
    let mut island: Vec<u32> = (0..level.len() as u32).collect();
    let mut light = island.clone();
    for own in border.iter().map(|turned| !turned) {
        let (saddle, index) = (f32::from_bits((own >> 32) as u32), !(own as u32) as usize);
        for other in sheet.around(index) {
            if basin[other] == 0 || basin[other] == basin[index] || height(luminance, other) < own {
                continue;
            }
            let (one, other) = (root(&mut island, basin[index] - 1), root(&mut island, basin[other] - 1));
            if one != other {
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

/// Root of a union-find forest, halving the path on the way.
pub fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        let up = parent[parent[i as usize] as usize];
        parent[i as usize] = up;
        i = up;
    }
    i
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::drawn::{drawn, drawn_from, regions, sizes};
    use super::*;

    /// Pixels of each light in one row between dark ones, the smallest light first.
    fn in_a_row(row: &str) -> Vec<usize> {
        sizes(&regions(&drawn_from(4, &[row]), 0.0))
    }

    #[test]
    fn ends_of_a_tube_are_one_light() {
        assert_eq!(in_a_row("...865555568...."), [9]);
    }

    #[test]
    fn two_lamps_are_two_where_the_way_falls_to_a_quarter_of_the_dimmer() {
        assert_eq!(in_a_row("....93338......."), [5]);
        // 8 / 2 is 4: just enough. Of pixels alike the left one counts as higher.
        assert_eq!(in_a_row("....92228......."), [2, 3]);
        assert_eq!(in_a_row("....91118......."), [2, 3]);
        assert_eq!(in_a_row("....92227......."), [5]);
    }

    #[test]
    fn the_way_between_two_lamps_is_the_brightest_not_the_straight_one() {
        let summary = drawn_from(3, &["....4444444.....", "....9.....8....."]);
        assert_eq!(sizes(&regions(&summary, 0.0)), [9]);
    }

    #[test]
    fn a_lamp_that_absorbed_another_is_as_prominent_as_its_own_peak() {
        // 5 goes to 6 over 4, then 6 to 9 over 2; 8 stays, for all ways to it fall to 1.
        assert_eq!(in_a_row("..54629.1.8....."), [1, 5]);
        assert_eq!(in_a_row("..54629118......"), [2, 6]);
    }

    #[test]
    fn corners_touch() {
        let summary = drawn_from(2, &["....9...........", ".....9..........", "....9..........."]);
        assert_eq!(sizes(&regions(&summary, 0.0)), [3]);
    }

    #[test]
    fn a_light_across_the_seam_is_one() {
        assert_eq!(in_a_row("98............79"), [4]);
        for rows in [["9...............", "...............8"], ["...............9", "8..............."]] {
            assert_eq!(sizes(&regions(&drawn_from(3, &rows), 0.0)), [2]);
        }
    }

    #[test]
    fn a_light_over_a_pole_is_one_and_beside_it_two() {
        let row = "..9.......8.....";
        for (top, wanted) in [(0, vec![2]), (7, vec![2]), (1, vec![1, 1]), (6, vec![1, 1])] {
            assert_eq!(sizes(&regions(&drawn_from(top, &[row]), 0.0)), wanted, "row {top}");
        }
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
        assert_eq!(in_a_row("....111....9...."), [1]); // the ceiling is higher
    }

    #[test]
    fn what_is_labelled_is_within_the_edge() {
        let summary = drawn_from(4, &["....1295......1."]);
        let regions = regions(&summary, 0.5);
        assert_eq!(regions.pixels[0].len(), 4);
        let labelled: Vec<usize> = (0..128).filter(|&i| regions.label[i] == 1).collect();
        assert_eq!(labelled, [4 * 16 + 6, 4 * 16 + 7]); // 9 and 5, not 2 and 1
        assert_eq!(regions.label.iter().filter(|&&label| label != 0).count(), 2);
        assert!((regions.peaks[0] - 9.0).abs() < 1e-5);
    }

    #[test]
    fn bright_pixels_are_all_above_the_threshold_and_dark_tiles_stay_shut() {
        let rows: Vec<String> = (0..40)
            .map(|y| (0..80).map(|x| if y % 39 == 15 && x % 31 == 15 { '1' } else { '.' }).collect())
            .collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let bright = bright_pixels(&drawn(&rows), 0.9); // 1 is only just bright
        let mut indices = bright.indices;
        indices.sort_unstable();
        assert_eq!(indices, [15 * 80 + 15, 15 * 80 + 46, 15 * 80 + 77]);
        assert_eq!(bright.opened_tiles, 3);
    }
}
