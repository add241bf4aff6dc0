//! The plateau: the clipped pixels of a map, with the bars across them filled.

use std::f64::consts::{PI, TAU};

use super::super::segment::run::{Run, runs};
use super::super::segment::working_image::WorkingImage;
use super::expansion::expand;
use crate::kernels::image::LEAST_WHITE;

/// The plateau of an `expanded` image, as runs in ascending order; `bright` are the pixels that may lie on it.
///
/// Gaps of up to `gap` radians between two of its pixels, along a row or a column, are filled: else a window
/// falls into panes.
pub fn plateau(expanded: &WorkingImage, bright: &[u32], gap: f64) -> Vec<Run> {
    // The centres of the pixels on both sides of a bar are its width and one pixel apart.
    let reach = gap + expanded.row_height();
    let rows = fill_rows(expanded, &clipped_runs(expanded, bright), reach);
    fill_columns(expanded, rows, reach)
}

/// The runs of `bright` pixels that are clipped.
fn clipped_runs(expanded: &WorkingImage, bright: &[u32]) -> Vec<Run> {
    let least = expand(LEAST_WHITE as f32);
    let width = expanded.size.1;
    let mut clipped = Vec::new();
    for run in runs(bright, width) {
        push_runs(&mut clipped, &run, &expanded.luminance[run.pixels(width)], |&level| level >= least);
    }
    clipped
}

/// Add the parts of a `run` in which the condition holds for the values of its pixels.
fn push_runs<T>(parts: &mut Vec<Run>, run: &Run, values: &[T], holds: impl Fn(&T) -> bool) {
    let mut start = run.columns.start;
    for part in values.chunk_by(|one, other| holds(one) == holds(other)) {
        if holds(&part[0]) {
            parts.push(Run { row: run.row, columns: start..start + part.len() });
        }
        start += part.len();
    }
}

/// Fill the gaps between runs of a row, across the seam too.
fn fill_rows(working: &WorkingImage, clipped: &[Run], reach: f64) -> Vec<Run> {
    let width = working.size.1;
    let theta = &working.grid.theta_edges;
    let mut filled: Vec<Run> = Vec::new();
    for row in clipped.chunk_by(|one, other| one.row == other.row) {
        let sine = (0.5 * (theta[row[0].row] + theta[row[0].row + 1])).sin();
        let most = ((reach / (TAU * sine) * width as f64) as usize).min(width / 2);
        let first = filled.len();
        for run in row {
            match filled[first..].last_mut() {
                Some(last) if run.columns.start <= last.columns.end - 1 + most => {
                    last.columns.end = run.columns.end;
                }
                _ => filled.push(run.clone()),
            }
        }
        let last = filled.len() - 1;
        if filled[first].columns.start + width <= filled[last].columns.end - 1 + most {
            filled[first].columns.start = 0;
            filled[last].columns.end = width;
        }
    }
    filled
}

/// Fill the gaps between pixels of a column.
fn fill_columns(working: &WorkingImage, rows: Vec<Run>, reach: f64) -> Vec<Run> {
    let (height, width) = working.size;
    let most = (reach / PI * height as f64) as usize;
    let mut is_clipped = vec![false; height * width];
    for run in &rows {
        is_clipped[run.pixels(width)].fill(true);
    }
    let mut is_any_filled = false;
    for pixel in rows.iter().filter(|run| run.row + 2 < height).flat_map(|run| run.pixels(width)) {
        if is_clipped[pixel + width] {
            continue; // no gap below
        }
        let below = (2..=most).map(|rows| pixel + rows * width).take_while(|&other| other < height * width);
        let Some(other) = below.into_iter().find(|&other| is_clipped[other]) else { continue };
        (pixel + width..other).step_by(width).for_each(|between| is_clipped[between] = true);
        is_any_filled = true;
    }
    if !is_any_filled {
        return rows;
    }
    let mut filled = Vec::new();
    for (row, is_clipped) in is_clipped.chunks_exact(width).enumerate() {
        push_runs(&mut filled, &Run { row, columns: 0..width }, is_clipped, |&is_clipped| is_clipped);
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::super::super::segment::test_maps::working_image_of;
    use super::*;

    /// Pixels of the plateau of a drawing in which 9 is clipped; `gap` in pixel heights.
    fn plateau_pixels(rows: &[&str], gap: f64) -> Vec<usize> {
        let working = working_image_of(rows);
        let luminance = working.luminance.iter().map(|&y| if y > 8.0 { 50.0 } else { y }).collect();
        let working = working.with_luminance(luminance);
        let all: Vec<u32> = (0..working.luminance.len() as u32).collect();
        let width = working.size.1;
        plateau(&working, &all, gap * working.row_height()).iter().flat_map(|run| run.pixels(width)).collect()
    }

    #[test]
    fn bars_along_rows_and_columns_are_filled_up_to_their_gap() {
        let dark = "................";
        let window = [dark, dark, dark, "...99.99........", dark, "...99.99........", dark, dark];
        assert_eq!(plateau_pixels(&window, 0.5).len(), 8);
        // The cross between the panes is filled too: its upright first, then its bar.
        assert_eq!(plateau_pixels(&window, 1.2).len(), 15);
    }

    #[test]
    fn a_bar_on_the_seam_is_filled() {
        let dark = "................";
        let rows = [dark, dark, dark, ".9............99", "9..............9", dark, dark, dark];
        let result = plateau_pixels(&rows, 1.2);
        assert_eq!(result, [48, 49, 62, 63, 64, 79]);
    }
}
