//! The fill: all connected pixels above a level, from one of them on, run by run.

use std::f64::consts::TAU;
use std::ops::Range;

use super::run::Run;
use super::working_image::WorkingImage;

/// A place has one run in each row, two on the seam or around a post. A fill with this many more is one of clutter, as of
/// leaves, and ends.
const SPARE_RUNS: usize = 64;
const RUNS_OF_A_ROW: usize = 2;

/// Pixels of a row that are looked at together.
const AT_ONCE: usize = 16;

/// Connected pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Filled {
    /// In ascending order.
    pub runs: Vec<Run>,
    /// In steradians.
    pub solid_angle: f64,
}

/// Take the pixels above `level` that are connected with the pixel `seed`, which is above it; none where they cover more
/// than the solid angle `largest`, are clutter, or reach a pixel that has a `label`.
pub fn fill(working: &WorkingImage, label: &[u32], seed: usize, level: f32, largest: f64) -> Option<Filled> {
    let width = working.size.1;
    let mut fill = Fill::new(working, label, level);
    fill.take_run(seed / width, seed % width);
    while let Some(run) = fill.open.pop() {
        fill.take_around(&run);
        if fill.meets_label || fill.solid_angle > largest || fill.is_clutter() {
            return None;
        }
    }
    Some(fill.done())
}

struct Fill<'a> {
    working: &'a WorkingImage,
    label: &'a [u32],
    level: f32,
    /// Columns of the runs of each row.
    rows: Vec<Vec<Range<usize>>>,
    /// Runs whose neighbours were not looked at yet.
    open: Vec<Run>,
    solid_angle: f64,
    count: usize,
    /// Rows that have a run.
    height: usize,
    meets_label: bool,
}

impl<'a> Fill<'a> {
    fn new(working: &'a WorkingImage, label: &'a [u32], level: f32) -> Self {
        let rows = vec![Vec::new(); working.size.0];
        Self {
            working,
            label,
            level,
            rows,
            open: Vec::new(),
            solid_angle: 0.0,
            count: 0,
            height: 0,
            meets_label: false,
        }
    }

    /// Take all runs around a run: across the seam too, and at a pole all of the row.
    fn take_around(&mut self, Run { row, columns }: &Run) {
        let (height, width) = self.working.size;
        if *row == 0 || row + 1 == height {
            self.take(*row, 0..width);
        }
        for near in row.saturating_sub(1)..(row + 2).min(height) {
            self.take(near, columns.start.saturating_sub(1)..(columns.end + 1).min(width));
            if columns.start == 0 {
                self.take(near, width - 1..width);
            }
            if columns.end == width {
                self.take(near, 0..1);
            }
        }
    }

    /// Take all runs that have a pixel in these columns.
    fn take(&mut self, row: usize, columns: Range<usize>) {
        let width = self.working.size.1;
        let mut column = columns.start;
        while column < columns.end {
            if let Some(known) = self.rows[row].iter().find(|run| run.contains(&column)) {
                column = known.end;
            } else if self.working.luminance[row * width + column] > self.level {
                column = self.take_run(row, column);
            } else {
                column += 1;
            }
        }
    }

    /// Take the run of a pixel; its end.
    fn take_run(&mut self, row: usize, column: usize) -> usize {
        let width = self.working.size.1;
        let pixels = &self.working.luminance[row * width..(row + 1) * width];
        let level = self.level;
        let start = column
            - bright(pixels[..column].rchunks(AT_ONCE), level, |part| {
                part.iter().rev().take_while(|&&value| value > level).count()
            });
        let end = column
            + bright(pixels[column..].chunks(AT_ONCE), level, |part| {
                part.iter().take_while(|&&value| value > level).count()
            });
        let across = TAU / width as f64 * (end - start) as f64;
        self.solid_angle += across * self.working.bands[row];
        self.meets_label |=
            self.label[row * width + start..row * width + end].iter().any(|&label| label != 0);
        self.count += 1;
        self.height += usize::from(self.rows[row].is_empty());
        self.rows[row].push(start..end);
        self.open.push(Run { row, columns: start..end });
        end
    }

    fn is_clutter(&self) -> bool {
        self.count > RUNS_OF_A_ROW * self.height + SPARE_RUNS
    }

    fn done(self) -> Filled {
        let mut runs = Vec::with_capacity(self.count);
        for (row, mut columns) in self.rows.into_iter().enumerate() {
            columns.sort_unstable_by_key(|columns| columns.start);
            runs.extend(columns.into_iter().map(|columns| Run { row, columns }));
        }
        Filled { runs, solid_angle: self.solid_angle }
    }
}

/// Whether all values are above a level: without a branch for each, for most parts lie inside.
#[expect(clippy::needless_bitwise_bool, reason = "a lazy operator would branch")]
pub fn all_above(values: &[f32], level: f32) -> bool {
    values.iter().fold(true, |all, &value| all & (value > level))
}

/// How many values above `level` there are before the first that is not, over parts of which `count` tells it one by one.
fn bright<'a>(parts: impl Iterator<Item = &'a [f32]>, level: f32, count: impl Fn(&[f32]) -> usize) -> usize {
    let mut before = 0;
    for part in parts {
        if all_above(part, level) {
            before += part.len();
        } else {
            return before + count(part);
        }
    }
    before
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use proptest::prelude::*;

    use super::super::test_maps::{drawn, drawn_from};
    use super::*;

    fn pixels(filled: &Filled, width: usize) -> Vec<usize> {
        filled.runs.iter().flat_map(|run| run.pixels(width)).collect()
    }

    /// Fill all that is above 0.5 and connected with a pixel.
    fn filled(working: &WorkingImage, seed: usize) -> Option<Filled> {
        fill(working, &vec![0; working.luminance.len()], seed, 0.5, 100.0)
    }

    #[test]
    fn a_fill_goes_over_corners_the_seam_and_the_poles() {
        let working = drawn_from(3, &["9..............9", ".9.......9......"]);
        assert_eq!(pixels(&filled(&working, 48).unwrap(), 16), [48, 63, 65]);
        let working = drawn_from(0, &["...9.......9...."]);
        assert_eq!(pixels(&filled(&working, 3).unwrap(), 16), [3, 11]);
    }

    #[test]
    fn a_fill_that_meets_a_label_or_takes_too_much_is_none() {
        let working = drawn_from(3, &["...99999........"]);
        let mut label = vec![0; 128];
        let solid_angle = fill(&working, &label, 51, 0.5, 100.0).unwrap().solid_angle;
        assert!((solid_angle - 5.0 * working.bands[3] * TAU / 16.0).abs() < 1e-12);
        assert!(fill(&working, &label, 51, 0.5, 0.99 * solid_angle).is_none());
        label[55] = 1;
        assert!(fill(&working, &label, 51, 0.5, 100.0).is_none());
    }

    #[test]
    fn clutter_is_none() {
        let comb = |gap: &str| -> Vec<String> {
            (0..32).map(|y| if y == 16 { "9".repeat(64) } else { gap.repeat(64 / gap.len()) }).collect()
        };
        for (gap, is_filled) in [("9.......", false), ("9...............................", true)] {
            let rows = comb(gap);
            let working = drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>());
            assert_eq!(filled(&working, 16 * 64).is_some(), is_filled, "{gap}");
        }
    }

    proptest! {
        #[test]
        fn a_fill_takes_what_a_plain_one_takes(bits in prop::collection::vec(0.0..1.0_f32, 8 * 16), seed in 0_usize..128) {
            let rows = ["................"; 8];
            let mut bits = bits;
            bits[seed] = 1.0;
            let working = drawn(&rows).with_luminance(bits.clone());
            // Grow from the seed until nothing is added.
            let mut is_taken = [false; 128];
            is_taken[seed] = true;
            loop {
                let touches = |pixel: usize| {
                    (0..128).any(|other| {
                        let rows = (pixel / 16).abs_diff(other / 16);
                        let columns = (pixel % 16).abs_diff(other % 16);
                        let is_pole = rows == 0 && [0, 7].contains(&(pixel / 16));
                        is_taken[other] && rows <= 1 && (columns.min(16 - columns) <= 1 || is_pole)
                    })
                };
                let new: Vec<usize> =
                    (0..128).filter(|&pixel| bits[pixel] > 0.5 && !is_taken[pixel] && touches(pixel)).collect();
                if new.is_empty() {
                    break;
                }
                for pixel in new {
                    is_taken[pixel] = true;
                }
            }
            let wanted: Vec<usize> = (0..128).filter(|&pixel| is_taken[pixel]).collect();
            prop_assert_eq!(pixels(&filled(&working, seed).unwrap(), 16), wanted);
        }
    }
}
