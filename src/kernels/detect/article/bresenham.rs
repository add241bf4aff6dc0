//! Step 8 of Loghin (2021): which samples a bright line joins.

use ndarray::ArrayView2;

use super::image::check_size;
use super::suppress::squared_distance;
use super::{Pixel, pixels_inside};
use crate::error::{Error, Result};
use crate::kernels::sphere::check_rows;

/// When a line is bright enough to join its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineRule {
    /// The mean luminance so far may differ from that of the start by this much.
    pub tolerance: f32,
    /// A pixel counts as no brighter than this.
    pub ceiling: f32,
    /// A mean from here on is bright whatever the start.
    pub bright: f32,
}

/// The pixels of Bresenham's line from `start` to `end`, both included: one for each step along the
/// longer side. `columns` lie on a plane; who counts on a sphere takes them modulo the width.
///
/// The error term grows by the shorter side at each step. At a tie the line goes over to the next
/// row or column only if it walks in the positive direction, so that a line and its reverse are
/// the same pixels.
pub fn line(start: [i64; 2], end: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    let [rows, columns] = [end[0] - start[0], end[1] - start[1]];
    let long = usize::from(columns.abs() >= rows.abs());
    let short = 1 - long;
    let steps = [rows, columns].map(i64::signum);
    let lengths = [rows.abs(), columns.abs()];
    let mut at = start;
    let mut error = 2 * lengths[short] - lengths[long];
    std::iter::once(start).chain((0..lengths[long]).map(move |_| {
        if error > 0 || (error == 0 && steps[long] > 0) {
            error -= 2 * lengths[long];
            at[short] += steps[short];
        }
        error += 2 * lengths[short];
        at[long] += steps[long];
        at
    }))
}

/// For each of `pixels`, (n, 2), brightest first, the one that it is merged into: itself, or the
/// brightest one that a bright line joins to it.
///
/// Only those are merged whose `points`, (n, 2) or (n, 3), are at most `farthest` apart. On a `sphere`
/// a line takes the shorter way around.
///
/// # Errors
///
/// [`Error::EmptyImage`], [`Error::WrongColumns`], [`Error::OutsideImage`], [`Error::LengthMismatch`],
/// [`Error::NotFinite`].
pub fn merge(
    luminance: ArrayView2<'_, f32>,
    pixels: ArrayView2<'_, i64>,
    points: ArrayView2<'_, f64>,
    farthest: f64,
    rule: &LineRule,
    sphere: bool,
) -> Result<Vec<usize>> {
    check_size(luminance.dim())?;
    let pixels = pixels_inside(pixels, luminance.dim())?;
    check_rows("points", points, if points.ncols() == 3 { 3 } else { 2 })?;
    if points.nrows() != pixels.len() {
        let (wanted, seen) = (pixels.len(), points.nrows());
        return Err(Error::LengthMismatch { what: "points", other: "pixels", wanted, seen });
    }
    let is_near = |i: usize, j: usize| squared_distance(points.row(i), points.row(j)) <= farthest * farthest;
    let mut light: Vec<Option<usize>> = vec![None; pixels.len()];
    for i in 0..pixels.len() {
        if light[i].is_some() {
            continue;
        }
        light[i] = Some(i);
        for j in i + 1..pixels.len() {
            if light[j].is_none() && is_near(i, j) && is_bright(luminance, pixels[i], pixels[j], rule, sphere)
            {
                light[j] = Some(i);
            }
        }
    }
    Ok(light.into_iter().enumerate().map(|(i, light)| light.unwrap_or(i)).collect())
}

/// Whether the line between two pixels stays as bright as its start.
///
/// The mean is that of the pixels after the start, each cut at the rule's ceiling.
pub fn is_bright(
    luminance: ArrayView2<'_, f32>,
    start: Pixel,
    end: Pixel,
    rule: &LineRule,
    sphere: bool,
) -> bool {
    let width = luminance.dim().1 as i64;
    let signed = |[row, column]: Pixel| [row as i64, column as i64];
    let (from, mut to) = (signed(start), signed(end));
    if sphere && (to[1] - from[1]).abs() > width / 2 {
        to[1] -= (to[1] - from[1]).signum() * width;
    }
    let (first, mut sum) = (luminance[start], 0.0_f32);
    line(from, to).skip(1).zip(1_usize..).all(|([row, column], count)| {
        sum += luminance[[row as usize, column.rem_euclid(width) as usize]].min(rule.ceiling);
        let mean = sum / count as f32;
        (mean - first).abs() <= rule.tolerance || mean >= rule.bright
    })
}
