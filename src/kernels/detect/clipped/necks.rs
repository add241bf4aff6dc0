//! Necks: narrow parts of a clipped region, which divide lights that have run into one another.
//!
//! The glow of a sun runs into a clipped horizon, a window into a clipped wall. The component tree of depth finds the
//! deepest points, and the narrowest neck on the widest path between two of them. They belong to two parts if the
//! depths of the shallower one and of the neck fulfil
//!
//! ```text
//!   (depth + 1 degree) / (neck + 1 degree) >= 2
//! ```

use std::collections::VecDeque;

use super::super::segment::adjacency::Adjacency;
use super::super::segment::components::{self, Segments, TreeRule};
use super::super::segment::run::{Run, runs};
use super::super::segment::threshold::Threshold;
use super::super::segment::working_image::WorkingImage;

/// Least ratio of a depth to its neck, after one degree is added to both.
const PROMINENCE: f64 = 2.0;
/// Angle added to depths, in radians. Without it, a plateau of a few pixels has necks.
const MORE_DEPTH: f32 = std::f32::consts::PI / 180.0;

/// For each pixel, the part of the `plateau` that holds it, counted from 1; 0 outside.
pub fn parts(working: &WorkingImage, plateau: &[Run], depth: &[f32]) -> Vec<u32> {
    let mut level = vec![0.0; depth.len()];
    let mut indices = Vec::new();
    for run in plateau {
        let pixels = run.pixels(working.size.1);
        indices.extend(pixels.clone().map(|pixel| pixel as u32));
        level[pixels.clone()].copy_from_slice(&depth[pixels.clone()]);
        level[pixels].iter_mut().for_each(|level| *level += MORE_DEPTH);
    }
    let level = working.with_luminance(level);
    let none = Threshold::fixed(0.0);
    let rule = TreeRule { rise: 1.0, prominence: PROMINENCE, extent: 0.0 };
    components::segments(&level, &Adjacency::of(&level), &indices, &none, &rule).label
}

/// Divide each segment among the parts of the plateau that it holds.
///
/// A pixel outside of them joins the part with the shortest path through the segment. New peaks are those of
/// `luminance`.
pub fn divide(adjacency: &Adjacency, segments: Segments, parts: &[u32], luminance: &[f32]) -> Segments {
    let mut divided = Segments::empty(segments.label);
    let peak = |pixels: &[u32]| pixels.iter().map(|&pixel| luminance[pixel as usize]).fold(0.0, f32::max);
    let mut owner = vec![0; parts.len()];
    let mut numbers = vec![0; parts.iter().copied().max().unwrap_or(0) as usize + 1];
    for pixels in segments.pixels {
        // Number the parts of the segment, in the order of their first pixels.
        let mut parts_inside: Vec<u32> = Vec::new();
        for &pixel in pixels.iter().filter(|&&pixel| divided.label[pixel as usize] != 0) {
            let part = parts[pixel as usize];
            if part != 0 && numbers[part as usize] == 0 {
                parts_inside.push(part);
                numbers[part as usize] = parts_inside.len() as u32;
            }
        }
        if parts_inside.len() < 2 {
            let peak = peak(&pixels);
            divided.push(pixels, peak);
        } else {
            grow(adjacency, &pixels, &divided.label, parts, &numbers, &mut owner);
            let mut own = vec![Vec::new(); parts_inside.len()];
            for pixel in pixels {
                own[owner[pixel as usize] as usize - 1].push(pixel);
                owner[pixel as usize] = 0;
            }
            for pixels in own {
                let peak = peak(&pixels);
                divided.push(pixels, peak);
            }
        }
        for part in parts_inside {
            numbers[part as usize] = 0;
        }
    }
    divided
}

/// Write into `owner` the number of the part that each pixel joins.
///
/// `numbers` are those of all parts, 0 for a part outside of the segment.
fn grow(
    adjacency: &Adjacency,
    pixels: &[u32],
    label: &[u32],
    parts: &[u32],
    numbers: &[u32],
    owner: &mut [u32],
) {
    // Mark the pixels that are free.
    const FREE: u32 = u32::MAX;
    for &pixel in pixels {
        let part = if label[pixel as usize] == 0 { 0 } else { parts[pixel as usize] };
        owner[pixel as usize] = if part == 0 { FREE } else { numbers[part as usize] };
    }
    // Start from the rim of the plateau: from its pixels with a free neighbour.
    let (mut front, mut columns) = (VecDeque::new(), Vec::new());
    for run in runs(pixels, adjacency.width()) {
        let is_near = adjacency.around_each(&run, &mut columns, |pixel| owner[pixel] == FREE, |a, b| a | b);
        let own = adjacency.pixels(&run).zip(is_near);
        front.extend(own.filter(|&(pixel, is_near)| is_near && owner[pixel] != FREE).map(|(pixel, _)| pixel));
    }
    // Grow over the free pixels, all parts at the same pace.
    while let Some(pixel) = front.pop_front() {
        for other in adjacency.around(pixel) {
            if owner[other] == FREE {
                owner[other] = owner[pixel];
                front.push_back(other);
            }
        }
    }
    // Give pixels behind a gap to the first part.
    for &pixel in pixels {
        if owner[pixel as usize] == FREE {
            owner[pixel as usize] = 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::segment::test_maps::{segments, working_image_of};
    use super::*;

    /// Sizes of the parts of the one segment of `row`; digits are parts of the plateau.
    fn sizes(row: &str) -> Vec<usize> {
        let dark = ".".repeat(row.len());
        let mut rows = vec![dark.as_str(); row.len() / 2];
        let glow: String = row.chars().map(|c| if c == '.' { '.' } else { '3' }).collect();
        rows[row.len() / 4] = &glow;
        let working = working_image_of(&rows);
        let mut parts = vec![0; working.luminance.len()];
        for (place, c) in row.char_indices() {
            parts[row.len() / 4 * row.len() + place] = c.to_digit(10).unwrap_or(0);
        }
        let result = segments(&working, 0.0);
        let adjacency = Adjacency::of(&working);
        divide(&adjacency, result, &parts, &working.luminance).pixels.iter().map(Vec::len).collect()
    }

    #[test]
    fn each_part_gets_the_nearest_glow() {
        assert_eq!(sizes("....g11gggg2g..."), [5, 4]);
        assert_eq!(sizes("....g11gggg1g..."), [9]);
        assert_eq!(sizes("....ggggggggg..."), [9]);
    }

    /// A disc of 6 pixels' radius and one of 3, joined by a bridge of the half-width `bridge`.
    fn parts_of_two_discs(bridge: f64) -> usize {
        let dark = ".".repeat(128);
        let rows = vec![dark.as_str(); 64];
        let working = working_image_of(&rows);
        let inside = |&pixel: &u32| {
            let (y, x) = (f64::from(pixel / 128) - 31.5, f64::from(pixel % 128) - 64.0);
            (x + 8.0).hypot(y) < 6.0 || (x - 8.0).hypot(y) < 3.0 || (x.abs() < 8.0 && y.abs() < bridge)
        };
        let plateau = runs(&(0..64 * 128).filter(inside).collect::<Vec<u32>>(), 128);
        let depth = super::super::depth::depths(&working, &plateau);
        let mut labels = parts(&working, &plateau, &depth);
        labels.retain(|&label| label != 0);
        labels.sort_unstable();
        labels.dedup();
        labels.len()
    }

    #[test]
    fn a_narrow_neck_divides_and_a_wide_one_does_not() {
        assert_eq!(parts_of_two_discs(1.0), 2);
        assert_eq!(parts_of_two_discs(2.6), 1);
    }
}
