//! The plateau: pixels at white, with the bars across them closed.

use std::f64::consts::{PI, TAU};

use super::super::clipping::LEAST_WHITE;
use super::super::tree::working_image::WorkingImage;
use super::expansion::expand;

/// Flat indices of the pixels on the plateau of an `expanded` image, in ascending order. `bright` are those that
/// may lie on it.
///
/// Bars of up to `gap` radians between two of its pixels, along a row or a column, are closed: else a window
/// falls into panes.
pub fn closed(expanded: &WorkingImage, bright: &[u32], gap: f64) -> Vec<u32> {
    let least = expand(LEAST_WHITE as f32);
    let (height, width) = expanded.size;
    let mut is_white = vec![false; height * width];
    let white = bright.iter().copied().filter(|&pixel| expanded.luminance[pixel as usize] >= least);
    let white: Vec<u32> = white.collect();
    for &pixel in &white {
        is_white[pixel as usize] = true;
    }
    // The centres of the pixels on both sides of a bar are its width and one pixel apart.
    let reach = gap + expanded.row_height();
    let mut all = white.clone();
    close_rows(expanded, &white, reach, &mut is_white, &mut all);
    let by_rows = all.clone();
    close_columns(expanded, &by_rows, reach, &mut is_white, &mut all);
    let is_closed = all.len() > white.len();
    if is_closed {
        (0..is_white.len() as u32).filter(|&pixel| is_white[pixel as usize]).collect()
    } else {
        white
    }
}

/// Close the gaps between pixels of a row, across the seam too.
fn close_rows(working: &WorkingImage, white: &[u32], reach: f64, is_white: &mut [bool], all: &mut Vec<u32>) {
    let width = working.size.1;
    for row in white.chunk_by(|one, other| *one as usize / width == *other as usize / width) {
        let first = row[0] as usize / width * width;
        let theta = &working.grid.theta_edges;
        let sine = (0.5 * (theta[first / width] + theta[first / width + 1])).sin();
        let most = ((reach / (TAU * sine) * width as f64) as usize).min(width / 2);
        let next = row[1..].iter().copied().chain([row[0] + width as u32]);
        for (&one, other) in row.iter().zip(next) {
            if ((other - one) as usize) <= most {
                for pixel in one + 1..other {
                    let pixel = first + (pixel as usize - first) % width;
                    if !is_white[pixel] {
                        is_white[pixel] = true;
                        all.push(pixel as u32);
                    }
                }
            }
        }
    }
}

/// Close the gaps between pixels of a column.
fn close_columns(
    working: &WorkingImage,
    white: &[u32],
    reach: f64,
    is_white: &mut [bool],
    all: &mut Vec<u32>,
) {
    let (height, width) = working.size;
    let most = (reach / PI * height as f64) as usize;
    for pixel in white.iter().map(|&pixel| pixel as usize) {
        if is_white.get(pixel + width) != Some(&false) {
            continue; // the last row, or no gap below
        }
        let below = (2..=most).map(|rows| pixel + rows * width).take_while(|&other| other < height * width);
        let Some(other) = below.into_iter().find(|&other| is_white[other]) else { continue };
        for between in (pixel + width..other).step_by(width) {
            is_white[between] = true;
            all.push(between as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tree::test_maps::drawn;
    use super::*;

    /// The plateau of a drawing, of which 9 is expanded luminance above white; `gap` in pixel heights.
    fn closed_pixels(rows: &[&str], gap: f64) -> Vec<u32> {
        let working = drawn(rows);
        let luminance = working.luminance.iter().map(|&y| if y > 8.0 { 50.0 } else { y }).collect();
        let working = working.with_luminance(luminance);
        let all: Vec<u32> = (0..working.luminance.len() as u32).collect();
        closed(&working, &all, gap * working.row_height())
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
