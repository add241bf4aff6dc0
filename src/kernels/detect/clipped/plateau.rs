//! The plateau: clipped pixels, with the bars across them filled.

use std::f64::consts::{PI, TAU};

use super::super::clipping::LEAST_WHITE;
use super::super::segment::run::{Run, runs};
use super::super::segment::working_image::WorkingImage;
use super::expansion::expand;

/// The plateau of an `expanded` image, as runs in ascending order. `bright` are the pixels that may lie on it.
///
/// Bars of up to `gap` radians between two of its pixels, along a row or a column, are closed: else a window
/// falls into panes.
pub fn closed(expanded: &WorkingImage, bright: &[u32], gap: f64) -> Vec<Run> {
    // The centres of the pixels on both sides of a bar are its width and one pixel apart.
    let reach = gap + expanded.row_height();
    let rows = close_rows(expanded, &white(expanded, bright), reach);
    close_columns(expanded, rows, reach)
}

/// The runs of `bright` pixels that are at white.
fn white(expanded: &WorkingImage, bright: &[u32]) -> Vec<Run> {
    let least = expand(LEAST_WHITE as f32);
    let width = expanded.size.1;
    let mut white = Vec::new();
    for run in runs(bright, width) {
        push_runs(&mut white, &run, &expanded.luminance[run.pixels(width)], |&level| level >= least);
    }
    white
}

/// Add the parts of a `run` in which the values of its pixels are `wanted`.
fn push_runs<T>(found: &mut Vec<Run>, run: &Run, values: &[T], wanted: impl Fn(&T) -> bool) {
    let mut start = run.columns.start;
    for part in values.chunk_by(|one, other| wanted(one) == wanted(other)) {
        if wanted(&part[0]) {
            found.push(Run { row: run.row, columns: start..start + part.len() });
        }
        start += part.len();
    }
}

/// Close the gaps between runs of a row, across the seam too.
fn close_rows(working: &WorkingImage, white: &[Run], reach: f64) -> Vec<Run> {
    let width = working.size.1;
    let theta = &working.grid.theta_edges;
    let mut closed: Vec<Run> = Vec::new();
    for row in white.chunk_by(|one, other| one.row == other.row) {
        let sine = (0.5 * (theta[row[0].row] + theta[row[0].row + 1])).sin();
        let most = ((reach / (TAU * sine) * width as f64) as usize).min(width / 2);
        let first = closed.len();
        for run in row {
            match closed[first..].last_mut() {
                Some(last) if run.columns.start <= last.columns.end - 1 + most => {
                    last.columns.end = run.columns.end;
                }
                _ => closed.push(run.clone()),
            }
        }
        let last = closed.len() - 1;
        if closed[first].columns.start + width <= closed[last].columns.end - 1 + most {
            closed[first].columns.start = 0;
            closed[last].columns.end = width;
        }
    }
    closed
}

/// Close the gaps between pixels of a column.
fn close_columns(working: &WorkingImage, rows: Vec<Run>, reach: f64) -> Vec<Run> {
    let (height, width) = working.size;
    let most = (reach / PI * height as f64) as usize;
    let mut is_white = vec![false; height * width];
    for run in &rows {
        is_white[run.pixels(width)].fill(true);
    }
    let mut is_closed = false;
    for pixel in rows.iter().filter(|run| run.row + 2 < height).flat_map(|run| run.pixels(width)) {
        if is_white[pixel + width] {
            continue; // no gap below
        }
        let below = (2..=most).map(|rows| pixel + rows * width).take_while(|&other| other < height * width);
        let Some(other) = below.into_iter().find(|&other| is_white[other]) else { continue };
        (pixel + width..other).step_by(width).for_each(|between| is_white[between] = true);
        is_closed = true;
    }
    if !is_closed {
        return rows;
    }
    let mut closed = Vec::new();
    for (row, is_white) in is_white.chunks_exact(width).enumerate() {
        push_runs(&mut closed, &Run { row, columns: 0..width }, is_white, |&is_white| is_white);
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::super::super::segment::test_maps::drawn;
    use super::*;

    /// The plateau of a drawing, of which 9 is expanded luminance above white; `gap` in pixel heights.
    fn closed_pixels(rows: &[&str], gap: f64) -> Vec<usize> {
        let working = drawn(rows);
        let luminance = working.luminance.iter().map(|&y| if y > 8.0 { 50.0 } else { y }).collect();
        let working = working.with_luminance(luminance);
        let all: Vec<u32> = (0..working.luminance.len() as u32).collect();
        let width = working.size.1;
        closed(&working, &all, gap * working.row_height()).iter().flat_map(|run| run.pixels(width)).collect()
    }

    #[test]
    fn bars_along_rows_and_columns_are_closed_up_to_their_gap() {
        let dark = "................";
        let window = [dark, dark, dark, "...99.99........", dark, "...99.99........", dark, dark];
        assert_eq!(closed_pixels(&window, 0.5).len(), 8);
        // The cross between the panes is closed too: its upright first, then its bar.
        assert_eq!(closed_pixels(&window, 1.2).len(), 15);
    }

    #[test]
    fn a_bar_on_the_seam_is_closed() {
        let dark = "................";
        let rows = [dark, dark, dark, ".9............99", "9..............9", dark, dark, dark];
        let found = closed_pixels(&rows, 1.2);
        assert_eq!(found, [48, 49, 62, 63, 64, 79]);
    }
}
