//! Tops: connected bright pixels that no saddle divides.
//!
//! In a connected component of bright pixels of the largest luminance M, islands that meet above
//!
//! ```text
//!   M / prominence
//! ```
//!
//! are one light, for no peak of the component is that prominent. So all pixels above that level that are
//! connected, a *top*, belong to one peak, and the tree begins below them. Tops are joined run by run, not pixel
//! by pixel: where white has cut a picture off, most of its bright pixels are on one.

use std::ops::Range;

use super::adjacency::Adjacency;
use super::forest::{apart, join, root};
use super::run::Run;
use crate::kernels::detect::clipping;

/// Bright pixels side by side in one row.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    pub run: Run,
    /// Place of its first pixel among the bright pixels.
    pub first: usize,
}

impl Stretch {
    /// Places of its pixels among the bright pixels.
    pub fn places(&self) -> Range<usize> {
        self.first..self.first + self.run.columns.len()
    }
}

/// The bright pixels, divided into tops and the slopes below them.
pub struct Tops {
    /// What is on a top, each with the place of the top's first peak and its largest luminance.
    pub tops: Vec<(Stretch, u32, f32)>,
    /// What is on none.
    pub slopes: Vec<Stretch>,
}

impl Tops {
    /// Those of the bright pixels in `runs`, of the luminance `level`.
    pub fn of(
        adjacency: &Adjacency,
        luminance: &[f32],
        level: &[f32],
        runs: Vec<Run>,
        prominence: f32,
    ) -> Self {
        let mut first = 0;
        let stretch = |run: Run| {
            first += run.columns.len();
            Stretch { first: first - run.columns.len(), run }
        };
        let bright: Vec<Stretch> = runs.into_iter().map(stretch).collect();
        let component = connected(adjacency, luminance, &bright);
        let most = largest(level, &bright, &component);
        // Cut the runs where they rise to a top.
        let (mut tops, mut slopes) = (Vec::new(), Vec::new());
        for (Stretch { run, first }, component) in bright.iter().zip(component) {
            let is_top = |level: f32| level * prominence > most[component as usize];
            let mut place = *first;
            let levels = &level[place..place + run.columns.len()];
            for part in levels.chunk_by(|one, other| is_top(*one) == is_top(*other)) {
                let start = run.columns.start + place - first;
                let run = Run { row: run.row, columns: start..start + part.len() };
                let parts = if is_top(part[0]) { &mut tops } else { &mut slopes };
                parts.push(Stretch { run, first: place });
                place += part.len();
            }
        }
        Self { tops: with_peaks(adjacency, luminance, level, tops), slopes }
    }
}

/// Each part of a top with the place of the top's first peak and its largest luminance.
fn with_peaks(
    adjacency: &Adjacency,
    luminance: &[f32],
    level: &[f32],
    tops: Vec<Stretch>,
) -> Vec<(Stretch, u32, f32)> {
    let top = connected(adjacency, luminance, &tops);
    let most = largest(level, &tops, &top);
    let is_peak = |pixel: usize| {
        let own = height(luminance, pixel);
        adjacency.around(pixel).into_iter().all(|other| height(luminance, other) <= own)
    };
    // Find the first peak of each top.
    let mut peak: Vec<usize> = tops.iter().map(|part| part.first).collect();
    let mut is_found = vec![false; tops.len()];
    for (part, top) in tops.iter().zip(&top).map(|(part, &top)| (part, top as usize)) {
        let mut pixels = adjacency.pixels(&part.run);
        if !is_found[top]
            && let Some(place) = pixels.position(is_peak)
        {
            (peak[top], is_found[top]) = (part.first + place, true);
        }
    }
    let with_peak = |(part, top): (Stretch, u32)| (part, peak[top as usize] as u32, most[top as usize]);
    tops.into_iter().zip(top).map(with_peak).collect()
}

/// The largest luminance of what is connected, at its root.
fn largest(level: &[f32], parts: &[Stretch], root: &[u32]) -> Vec<f32> {
    let mut most = vec![0.0; parts.len()];
    for (part, &root) in parts.iter().zip(root) {
        let most: &mut f32 = &mut most[root as usize];
        *most = most.max(clipping::largest(&level[part.places()]));
    }
    most
}

/// For each of some stretches, in ascending order, the first of those that it is connected with.
fn connected(adjacency: &Adjacency, luminance: &[f32], parts: &[Stretch]) -> Vec<u32> {
    let mut parent = apart(parts.len());
    let (mut above, mut end) = (0..0, 0);
    for row in parts.chunk_by(|one, other| one.run.row == other.run.row) {
        let here = end..end + row.len();
        end = here.end;
        join_across_seam(adjacency, parts, here.clone(), here.clone(), &mut parent);
        join_at_pole(adjacency, luminance, row, here.start, &mut parent);
        if above.end > 0 && parts[above.start].run.row + 1 == row[0].run.row {
            join_rows(parts, above.clone(), here.clone(), &mut parent);
            join_across_seam(adjacency, parts, above.clone(), here.clone(), &mut parent);
            join_across_seam(adjacency, parts, here.clone(), above, &mut parent);
        }
        above = here;
    }
    (0..parts.len() as u32).map(|part| root(&mut parent, part)).collect()
}

/// Join what touches in two rows, one below the other; corners touch.
fn join_rows(parts: &[Stretch], above: Range<usize>, here: Range<usize>, parent: &mut [u32]) {
    let (mut i, mut j) = (above.start, here.start);
    while i < above.end && j < here.end {
        let (one, other) = (&parts[i].run.columns, &parts[j].run.columns);
        if one.start <= other.end && other.start <= one.end {
            join(parent, i as u32, j as u32);
        }
        if one.end < other.end { i += 1 } else { j += 1 }
    }
}

/// Join the last of some parts with the first of others, where both touch the seam.
fn join_across_seam(
    adjacency: &Adjacency,
    parts: &[Stretch],
    some: Range<usize>,
    others: Range<usize>,
    parent: &mut [u32],
) {
    let (last, first) = (&parts[some.end - 1].run.columns, &parts[others.start].run.columns);
    if last.end == adjacency.width() && first.start == 0 {
        join(parent, some.end as u32 - 1, others.start as u32);
    }
}

/// Join what touches the hub of a pole's row: every pixel of the row that is not higher.
fn join_at_pole(adjacency: &Adjacency, luminance: &[f32], row: &[Stretch], first: usize, parent: &mut [u32]) {
    let Some(hub) = adjacency.hub_of_row(row[0].run.row) else { return };
    let Some(at_hub) = row.iter().position(|part| adjacency.pixels(&part.run).contains(&hub)) else { return };
    let highest = height(luminance, hub);
    for (place, part) in row.iter().enumerate() {
        if adjacency.pixels(&part.run).any(|pixel| height(luminance, pixel) <= highest) {
            join(parent, (first + place) as u32, (first + at_hub) as u32);
        }
    }
}

/// Luminance and index as one number, in the order of luminance: the bits of floats that are not
/// negative are in the order of the floats. Of two equal pixels the earlier one is higher.
pub fn height(luminance: &[f32], index: usize) -> u64 {
    (u64::from(luminance[index].to_bits()) << 32) | u64::from(!(index as u32))
}

#[cfg(test)]
mod tests {
    use super::super::components::bright_pixels;
    use super::super::run::runs;
    use super::super::test_maps::drawn_from;
    use super::*;

    /// For each part of a top, in order: its length, the index of its peak's pixel and its luminance; and the number
    /// of pixels on slopes.
    fn tops(top: usize, rows: &[&str]) -> (Vec<(usize, u32, f32)>, usize) {
        let working = drawn_from(top, rows);
        let bright = bright_pixels(&working, 0.5).indices;
        let level: Vec<f32> = bright.iter().map(|&pixel| working.luminance[pixel as usize]).collect();
        let adjacency = Adjacency::of(&working);
        let found = Tops::of(&adjacency, &working.luminance, &level, runs(&bright, 16), 4.0);
        let parts = found.tops.iter();
        let parts = parts.map(|(part, peak, most)| (part.run.columns.len(), bright[*peak as usize], *most));
        (parts.collect(), found.slopes.iter().map(|part| part.run.columns.len()).sum())
    }

    #[test]
    fn a_top_is_above_a_quarter_of_the_peak_of_its_own_component() {
        let wanted = (vec![(5, 66, 9.0), (2, 73, 2.0), (1, 75, 1.0)], 0);
        assert_eq!(tops(4, &["..83339.12.1...."]), wanted);
        let wanted = (vec![(2, 66, 8.0), (1, 69, 9.0), (1, 71, 9.0), (2, 75, 8.0)], 3);
        assert_eq!(tops(4, &["..8329.91238...."]), wanted);
    }

    #[test]
    fn tops_meet_at_corners_at_the_seam_and_at_the_poles() {
        let one = |top, rows: &[&str]| {
            let (parts, _) = tops(top, rows);
            parts.iter().all(|part| part.1 == parts[0].1)
        };
        assert!(one(3, &["..9.............", "...9............"]));
        assert!(one(3, &["...9............", "..9............."]));
        assert!(!one(3, &["..9.............", "....9..........."]));
        assert!(one(3, &["9..............9"]));
        assert!(one(3, &["9...............", "...............9"]));
        assert!(one(3, &["...............9", "9..............."]));
        assert!(one(0, &["..9....9..8....."]) && one(7, &["..9....9..8....."]));
        assert!(!one(1, &["..9....9..8....."]));
    }
}
