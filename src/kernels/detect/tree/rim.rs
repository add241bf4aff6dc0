//! The rim of a place: how far the luminance falls across it, within a few pixels.

use super::adjacency::Adjacency;
use super::fill::all_above;
use super::run::Run;
use super::working_image::WorkingImage;

/// From a pixel of the outline, the fall is measured between pixels this many heights of a row farther in and out: the rim
/// cuts the ones between.
const DISTANCE: usize = 2;

/// Luminance on both sides of a pixel of the outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fall {
    pub inside: f32,
    pub outside: f32,
}

impl Fall {
    fn ratio(self) -> f32 {
        self.inside / self.outside
    }
}

/// Pixels of a run that are looked at together.
const AT_ONCE: usize = 16;

/// The falls at all pixels of the outline of what a fill above `level` took, each where it is steepest.
pub fn falls(working: &WorkingImage, adjacency: &Adjacency, runs: &[Run], level: f32) -> Vec<Fall> {
    let (height, width) = working.size;
    let luminance = &working.luminance;
    let mut falls = Vec::new();
    for run in runs {
        let near = |row: usize| &luminance[row * width..][run.columns.clone()];
        let (above, below) = (near(run.row.saturating_sub(1)), near((run.row + 1).min(height - 1)));
        let distance = working.columns_across(run.row, DISTANCE);
        let mut look = |place: usize| {
            let is_end = place == 0 || place + 1 == run.columns.len();
            if is_end || above[place] <= level || below[place] <= level {
                let index = run.row * width + run.columns.start + place;
                falls.extend(steepest(luminance, adjacency, index, distance, level));
            }
        };
        // Most pixels are inside.
        let places = above.chunks(AT_ONCE).zip(below.chunks(AT_ONCE)).enumerate();
        for (chunk, (above, below)) in places {
            let start = chunk * AT_ONCE;
            let end = start + above.len();
            if start == 0 || end == run.columns.len() || !(all_above(above, level) && all_above(below, level))
            {
                (start..end).for_each(&mut look);
            }
        }
    }
    falls
}

/// The steepest fall from a pixel to those beside it that are not above `level`, if it has any.
fn steepest(
    luminance: &[f32],
    adjacency: &Adjacency,
    index: usize,
    distance: usize,
    level: f32,
) -> Option<Fall> {
    let [left, right, up, down] = adjacency.beyond(index, DISTANCE, distance).map(|pixel| luminance[pixel]);
    let falls = [(right, left), (left, right), (down, up), (up, down)];
    let sides = adjacency.sides(index).into_iter().zip(falls);
    let falls = sides.filter(|(side, _)| luminance[*side] <= level);
    let falls = falls.map(|(_, (inside, outside))| Fall { inside, outside });
    falls.max_by(|one, other| one.ratio().total_cmp(&other.ratio()))
}

/// Whether the luminance falls by the factor `least` where the row and the column of `seed` leave what is above `level`: at
/// one of the ends that they have, and at three in four of them. Few gradients get as far as a fill.
pub fn ends_sharply(working: &WorkingImage, seed: usize, level: f32, least: f32) -> bool {
    let width = working.size.1;
    let across = working.columns_across(seed / width, DISTANCE);
    let steps = [(0, -1, across), (0, 1, across), (-1, 0, DISTANCE), (1, 0, DISTANCE)];
    let falls = steps.map(|(down, right, distance)| {
        let ray = |pixels: usize| along(working, seed, down * pixels as i64, right * pixels as i64);
        let last = (1..width / 2).map_while(ray).position(|value| value <= level)?;
        Some(Fall { inside: ray(last.saturating_sub(distance))?, outside: ray(last + distance)? })
    });
    let ends = falls.iter().flatten().count();
    let sharp = falls.iter().flatten().filter(|fall| fall.ratio() >= least).count();
    sharp > 0 && 4 * sharp >= 3 * ends
}

/// Luminance some rows below a pixel and some columns to the right of it; none beyond the poles.
fn along(working: &WorkingImage, pixel: usize, down: i64, right: i64) -> Option<f32> {
    let (height, width) = working.size;
    let row = usize::try_from((pixel / width) as i64 + down).ok().filter(|&row| row < height)?;
    let column = ((pixel % width) as i64 + right).rem_euclid(width as i64) as usize;
    Some(working.luminance[row * width + column])
}

#[cfg(test)]
mod tests {
    use super::super::run::runs;
    use super::super::test_maps::drawn;
    use super::*;

    /// A square of 12 x 12 pixels on the seam, of the luminance 8 before 2; with `ramp`, 4 and 3 around it.
    fn square(ramp: bool) -> WorkingImage {
        let pixel = |y: usize, x: usize| match (2 * y).abs_diff(31).max((2 * ((x + 32) % 64)).abs_diff(63)) {
            ..12 => '8',
            12..15 if ramp => '6',
            15..18 if ramp => '4',
            18..21 if ramp => '3',
            _ => '2',
        };
        let rows: Vec<String> = (0..32).map(|y| (0..64).map(|x| pixel(y, x)).collect()).collect();
        drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>())
    }

    fn falls_of(working: &WorkingImage) -> Vec<Fall> {
        let bright: Vec<u32> = (0..2048).filter(|&pixel| working.luminance[pixel as usize] > 4.5).collect();
        falls(working, &Adjacency::of(working), &runs(&bright, 64), 4.5)
    }

    #[test]
    fn the_whole_outline_of_a_square_falls_from_one_side_to_the_other() {
        let falls = falls_of(&square(false));
        assert_eq!(falls.len(), 4 * 11);
        for fall in falls {
            assert!((fall.inside - 8.0).abs() < 1e-5 && (fall.outside - 2.0).abs() < 1e-5, "{fall:?}");
        }
        let ramp = falls_of(&square(true));
        assert!(ramp.iter().all(|fall| fall.ratio() < 3.0), "{ramp:?}");
    }

    #[test]
    fn rays_end_sharply_at_a_rim_and_not_on_a_ramp() {
        let seed = 16 * 64 + 1;
        assert!(ends_sharply(&square(false), seed, 4.5, 3.0));
        assert!(!ends_sharply(&square(true), seed, 4.5, 3.0));
        assert!(!ends_sharply(&square(false), seed, 1.0, 3.0), "no end");
    }
}
