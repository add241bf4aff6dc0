//! Step 8 of Loghin (2021): the line between two samples, and the test that it is bright.

use super::image::Image;
use crate::error::{Error, Result};
use crate::kernels::sphere::{Pixel, check_memory};

/// Pixels of the shortest line that is refused: no image that fits into memory is that wide.
const LONGEST: u64 = 1 << 24;

/// Condition for a line that joins its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineRule {
    /// Samples farther apart are not joined.
    pub farthest: f64,
    /// The mean luminance so far may differ from the luminance of the start by this much.
    pub tolerance: f32,
    /// A brighter pixel counts as this bright.
    pub ceiling: f32,
    /// A mean of this or more is bright for any start.
    pub bright: f32,
    /// True for lines on the shorter way around the sphere.
    pub sphere: bool,
}

/// The pixels of Bresenham's line after its start, up to its end: one for each step along the longer side.
///
/// The error grows by the shorter side at each step. At a tie the line moves to the next row or column
/// only if it runs in the positive direction, so that a line and its reverse are the same pixels.
struct LineSteps {
    at: [i64; 2],
    along: [i64; 2],
    aside: [i64; 2],
    length: i64,
    breadth: i64,
    error: i64,
    left: i64,
}

impl LineSteps {
    fn new(start: [i64; 2], end: [i64; 2]) -> Self {
        // Step along the longer side.
        let [rows, columns] = [end[0] - start[0], end[1] - start[1]];
        let (down, right) = ([rows.signum(), 0], [0, columns.signum()]);
        let (along, aside, length, breadth) = if columns.abs() >= rows.abs() {
            (right, down, columns.abs(), rows.abs())
        } else {
            (down, right, rows.abs(), columns.abs())
        };
        // Add 1 where a tie moves aside, so that "above 0" alone decides.
        let tie = i64::from(along[0] + along[1] > 0);
        Self { at: start, along, aside, length, breadth, error: 2 * breadth - length + tie, left: length }
    }
}

impl Iterator for LineSteps {
    type Item = [i64; 2];

    #[inline]
    fn next(&mut self) -> Option<[i64; 2]> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        // Step aside where the error is large enough.
        if self.error > 0 {
            self.error -= 2 * self.length;
            self.at = [self.at[0] + self.aside[0], self.at[1] + self.aside[1]];
        }
        // Step along.
        self.error += 2 * self.breadth;
        self.at = [self.at[0] + self.along[0], self.at[1] + self.along[1]];
        Some(self.at)
    }
}

/// The pixels of Bresenham's line, (n, 2), both ends included.
///
/// # Errors
///
/// [`Error::LongLine`], [`Error::NoMemory`].
pub fn line(start: [i64; 2], end: [i64; 2]) -> Result<Vec<[i64; 2]>> {
    let length = start[0].abs_diff(end[0]).max(start[1].abs_diff(end[1]));
    if length >= LONGEST {
        return Err(Error::LongLine { start, end, limit: LONGEST });
    }
    // The pixels, as they grow, and as an array for the caller.
    check_memory(&[length as usize, 8])?;
    Ok(std::iter::once(start).chain(LineSteps::new(start, end)).collect())
}

/// True if the running mean along a line stays within `tolerance` of its start, or above `bright`.
///
/// The mean is over the pixels after the start, each cut at the rule's ceiling. With `rule.sphere` the
/// line goes the shorter way around.
pub(super) fn is_bright(image: &Image<'_>, start: Pixel, end: Pixel, rule: &LineRule) -> bool {
    // Unwrap the end so that the line goes the shorter way around.
    let width = image.width as i64;
    let signed = |[row, column]: Pixel| [row as i64, column as i64];
    let (from, mut to) = (signed(start), signed(end));
    if rule.sphere && (to[1] - from[1]).abs() > width / 2 {
        to[1] -= (to[1] - from[1]).signum() * width;
    }
    // Walk along the line while its mean is bright enough.
    let (first, mut sum, mut count) = (image.at(start), 0.0_f32, 0.0_f32);
    LineSteps::new(from, to).all(|[row, column]| {
        // Wrap the column: it is at most one width beyond the seam.
        let column = if column < 0 { column + width } else { column };
        let column = if column < width { column } else { column - width };
        sum += image.at([row as usize, column as usize]).min(rule.ceiling);
        count += 1.0;
        let mean = sum / count;
        (mean - first).abs() <= rule.tolerance || mean >= rule.bright
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_line_too_long_to_list_is_refused() {
        let far = [i64::MAX, i64::MIN];
        assert_eq!(line([0, 0], far), Err(Error::LongLine { start: [0, 0], end: far, limit: LONGEST }));
    }
}
