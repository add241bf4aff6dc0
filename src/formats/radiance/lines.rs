//! Start and end of each line of pixels, found by one pass over the packets.

use crate::error::{Error, Result};
use crate::formats::input::damage;

/// Bytes of one line of pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    /// First byte behind the four that announce planes.
    pub from: usize,
    /// First byte of the next line.
    pub to: usize,
    /// True for four planes of packets, false for pixels and old runs.
    pub is_planar: bool,
}

/// Widths of lines that may be stored as planes of packets.
pub(super) const PLANAR_WIDTHS: std::ops::Range<usize> = 8..32768;

/// All lines of a picture of this size, whose first line is at `start`.
///
/// # Errors
///
/// If the file ends early, or the runs of a line have another length than its pixels.
pub(super) fn find_lines(bytes: &[u8], start: usize, height: usize, width: usize) -> Result<Vec<Line>> {
    let available = bytes.len() - start;
    // The shortest line has one pixel of four bytes.
    if height > available / 4 {
        return Err(damage(format!(
            "the Radiance file is incomplete: {available} bytes cannot hold its {height} lines"
        )));
    }
    let mut lines = Vec::with_capacity(height);
    let mut at = start;
    for index in 0..height {
        let line = line(bytes, at, width).map_err(|reason| refusal(reason, index, width))?;
        at = line.to;
        lines.push(line);
    }
    Ok(lines)
}

/// Damage of a line.
enum Damage {
    Incomplete,
    Length(usize),
    Run,
    FirstRun,
}

/// Sentence about the `kind` of damage of a line.
fn refusal(kind: Damage, index: usize, width: usize) -> Error {
    let line = format!("line {index} of the Radiance file");
    damage(match kind {
        Damage::Incomplete => format!("{line} is incomplete; wanted {width} pixels"),
        Damage::Length(seen) => format!("{line} announces {seen} pixels; wanted {width}"),
        Damage::Run => {
            format!("{line} has an empty run or one that is too long; wanted {width} pixels in all")
        }
        Damage::FirstRun => format!("{line} starts with a run of a pixel before it; wanted a pixel"),
    })
}

/// The line that starts `at` a byte.
fn line(bytes: &[u8], at: usize, width: usize) -> std::result::Result<Line, Damage> {
    let start: [u8; 4] = *bytes[at..].first_chunk().ok_or(Damage::Incomplete)?;
    let is_planar = PLANAR_WIDTHS.contains(&width) && start[..2] == [2, 2] && start[2] < 128;
    if !is_planar {
        return Ok(Line { from: at, to: end_of_pixels(bytes, at, width)?, is_planar });
    }
    let length = usize::from(u16::from_be_bytes([start[2], start[3]]));
    if length != width {
        return Err(Damage::Length(length));
    }
    Ok(Line { from: at + 4, to: end_of_planes(bytes, at + 4, width)?, is_planar })
}

/// End of four planes of packets.
fn end_of_planes(bytes: &[u8], mut at: usize, width: usize) -> std::result::Result<usize, Damage> {
    for _ in 0..4 {
        let mut missing = width;
        while missing > 0 {
            let count = usize::from(*bytes.get(at).ok_or(Damage::Incomplete)?);
            let is_run = count > 128;
            let pixels = if is_run { count - 128 } else { count };
            at += if is_run { 2 } else { count + 1 };
            // One comparison refuses both no pixel and too many.
            if pixels.wrapping_sub(1) >= missing {
                return Err(Damage::Run);
            }
            missing -= pixels;
        }
    }
    if at > bytes.len() { Err(Damage::Incomplete) } else { Ok(at) }
}

/// End of pixels and old runs, whose lengths are shifted by 8 bits for each consecutive run.
fn end_of_pixels(bytes: &[u8], mut at: usize, width: usize) -> std::result::Result<usize, Damage> {
    let (mut pixels, mut shift) = (0_usize, 0_u32);
    while pixels < width {
        let pixel: [u8; 4] = *bytes[at..].first_chunk().ok_or(Damage::Incomplete)?;
        at += 4;
        if let Some(run) = old_run(pixel, &mut shift) {
            if pixels == 0 {
                return Err(Damage::FirstRun);
            }
            pixels = pixels.checked_add(run).ok_or(Damage::Run)?;
        } else {
            pixels += 1;
        }
    }
    if pixels > width { Err(Damage::Run) } else { Ok(at) }
}

/// Length of an old run, the largest number if no line is so long; `None` for a pixel.
#[inline]
pub(super) fn old_run(pixel: [u8; 4], shift: &mut u32) -> Option<usize> {
    let [1, 1, 1, count] = pixel else {
        *shift = 0;
        return None;
    };
    let run = (*shift < 32).then(|| u64::from(count) << *shift).and_then(|run| usize::try_from(run).ok());
    *shift = shift.saturating_add(8);
    Some(run.unwrap_or(usize::MAX))
}
