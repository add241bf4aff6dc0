//! Places of low contrast: large, with a sharp rim, and below the threshold or above it by too little.
//!
//! The threshold is one for the whole map. A window or a lit panel that is three times as bright as the wall around it
//! may lie below it and yet give hundredths of the light. Such a place is told from a cloud or a glow by its rim.
//!
//! From the brightest cell of each candidate a fill takes the connected pixels above the level
//!
//! ```text
//!   sqrt(A B)
//! ```
//!
//! with A for the mean luminance of what is taken, and B for the median of what is just outside. Both follow from the fill, so
//! it is repeated until it takes the same pixels again: they do not depend on where it began. The place is added to the
//! lights where it touches none of them and
//!
//! ```text
//!   A / B >= 2.3                            it stands out of what is around it
//!   flux >= 0.01 of the map's
//!   solid angle <= 0.5                      what is larger is a wall, a bed or the sky
//!   the luminance falls by sqrt(A / B)      within five pixels,
//!   and more at 0.9 of the outline          unlike that of a gradient
//! ```

use std::f64::consts::TAU;

use super::adjacency::Adjacency;
use super::background::median;
use super::candidates::{Candidate, candidates};
use super::components::Segments;
use super::dot_product::dot;
use super::fill::{Filled, fill};
use super::rim::{self, Fall};
use super::run::{Run, runs};
use super::working_image::WorkingImage;

/// Mean luminance over the background, at least: that of generated places is 2.48 and more.
const LEAST_CONTRAST: f64 = 2.3;
/// Share of the map's flux, at least.
const LEAST_FLUX: f64 = 0.01;
/// Solid angle, at most: a little more than a window of 40 degrees.
pub const LARGEST_PLACE: f64 = 0.5;
/// Solid angle in pixels of the equator, at least: fewer have hardly an inside.
const LEAST_PIXELS: f64 = 50.0;
/// Share of the outline that is sharp, at least: of generated places 0.99 is, of patches of sun on a floor 0.8.
const LEAST_SHARP: f64 = 0.9;
/// What a fill has that is repeated, as a part of all that.
const NEARLY: f64 = 0.7;
/// Fills that are tried until two take the same.
const MOST_FILLS: usize = 6;

/// Add the places of low contrast to the segments, in a map of the flux `whole`.
pub fn add(working: &WorkingImage, adjacency: &Adjacency, segments: &mut Segments, whole: f64) {
    for candidate in candidates(working, &segments.label, LEAST_FLUX * whole, LARGEST_PLACE) {
        let Some(start) = Start::of(working, &candidate).filter(|start| start.is_promising(working)) else {
            continue;
        };
        if let Some(place) = place(working, adjacency, &segments.label, &start, whole) {
            push(working, segments, &place);
        }
    }
}

/// The place around a pixel, if it is one.
fn place(
    working: &WorkingImage,
    adjacency: &Adjacency,
    label: &[u32],
    start: &Start,
    whole: f64,
) -> Option<Filled> {
    let Start { seed, mut level, largest, .. } = *start;
    let mut last: Option<(Filled, Measured)> = None;
    for _ in 0..MOST_FILLS {
        let filled = fill(working, label, seed, level, largest)?;
        if last.as_ref().is_some_and(|(last, _)| *last == filled) {
            break;
        }
        let measured = Measured::of(working, adjacency, &filled, level, whole);
        if !measured.is_place(NEARLY) {
            return None;
        }
        level = (measured.inside * measured.background).sqrt() as f32;
        last = Some((filled, measured));
    }
    last.filter(|(_, measured)| measured.is_place(1.0)).map(|(filled, _)| filled)
}

/// What makes a place.
struct Measured {
    /// Mean luminance.
    inside: f64,
    /// Median luminance just outside.
    background: f64,
    /// Share of the map's flux.
    flux: f64,
    /// Solid angle in pixels of the equator.
    pixels: f64,
    /// Share of the outline that is sharp.
    sharp: f64,
}

impl Measured {
    fn of(working: &WorkingImage, adjacency: &Adjacency, filled: &Filled, level: f32, whole: f64) -> Self {
        let falls = rim::falls(working, adjacency, &filled.runs, level);
        let flux = flux(working, &filled.runs);
        let (inside, background) = (flux / filled.solid_angle, background(&falls));
        Self {
            inside,
            background,
            flux: flux / whole,
            pixels: filled.solid_angle / working.row_height().powi(2),
            sharp: sharp(&falls, inside / background),
        }
    }

    /// Whether all is enough, or this part of it.
    fn is_place(&self, part: f64) -> bool {
        self.inside >= part * LEAST_CONTRAST * self.background
            && self.flux >= part * LEAST_FLUX
            && self.pixels >= part * LEAST_PIXELS
            && self.sharp >= part * LEAST_SHARP
    }
}

/// Where the first fill begins.
struct Start {
    seed: usize,
    level: f32,
    /// The luminance of what is bright over the level: the root of the contrast.
    step: f32,
    /// Largest solid angle.
    largest: f64,
}

impl Start {
    /// The brightest pixel of the longest run in the candidate's cell, which its place may cover in part.
    fn of(working: &WorkingImage, Candidate { cell, peak, background, largest }: &Candidate) -> Option<Self> {
        let width = working.size.1;
        let between = |inside: f32| (f64::from(inside) * f64::from(*background)).sqrt() as f32;
        // Find the luminance of what is bright in the cell.
        let level = between(*peak);
        let (mut sum, mut count) = (0.0, 0.0);
        for &value in cell.rows(&working.luminance, width).flatten() {
            let (value, one) = if value > level { (value, 1.0) } else { (0.0, 0.0) };
            sum += value;
            count += one;
        }
        let (inside, level) = (sum / count, between(sum / count));
        // Find its longest run.
        let pixels =
            cell.rows.clone().flat_map(|row| cell.columns.clone().map(move |column| row * width + column));
        let bright = pixels.filter(|&pixel| working.luminance[pixel] > level);
        let bright: Vec<u32> = bright.map(|pixel| pixel as u32).collect();
        let longest = runs(&bright, width).into_iter().max_by_key(|run| run.columns.len())?;
        let luminance = |&pixel: &usize| working.luminance[pixel];
        let brightest =
            longest.pixels(width).max_by(|one, other| luminance(one).total_cmp(&luminance(other)));
        brightest.map(|seed| Self { seed, level, step: inside / level, largest: *largest })
    }

    /// Whether the contrast is nearly enough, and the seed's row and column end at a rim.
    fn is_promising(&self, working: &WorkingImage) -> bool {
        f64::from(self.step).powi(2) >= NEARLY * LEAST_CONTRAST
            && rim::ends_sharply(working, self.seed, self.level, self.step)
    }
}

/// Integral of the luminance.
fn flux(working: &WorkingImage, runs: &[Run]) -> f64 {
    let width = working.size.1;
    let widths = vec![TAU / width as f64; width];
    let sum = |run: &Run| dot(&working.luminance[run.pixels(width)], &widths[run.columns.clone()]);
    runs.iter().map(|run| sum(run) * working.bands[run.row]).sum()
}

/// Median luminance just outside of the rim.
fn background(falls: &[Fall]) -> f64 {
    median(&mut falls.iter().map(|fall| fall.outside).collect::<Vec<f32>>())
}

/// Share of the rim where the luminance falls by the root of the `contrast`.
fn sharp(falls: &[Fall], contrast: f64) -> f64 {
    let least = contrast.sqrt() as f32;
    let sharp = falls.iter().filter(|fall| fall.inside >= least * fall.outside).count();
    sharp as f64 / falls.len() as f64
}

/// The backgrounds against which lights are measured, where those from `first` on are faint: none, for the geometric mean of
/// both sides takes as much of a background as it leaves of a place, see `threshold.rs`. Noise would look like a rim.
pub fn behind(backgrounds: &[f64], first: usize) -> Vec<f64> {
    let tree = backgrounds[..first].iter().copied();
    tree.chain(backgrounds[first..].iter().map(|_| 0.0)).collect()
}

/// Add a place to the segments.
fn push(working: &WorkingImage, segments: &mut Segments, place: &Filled) {
    let width = working.size.1;
    let label = segments.pixels.len() as u32 + 1;
    let (mut pixels, mut peak) = (Vec::new(), 0.0_f32);
    for run in &place.runs {
        segments.label[run.pixels(width)].fill(label);
        pixels.extend(run.pixels(width).map(|pixel| pixel as u32));
        peak = working.luminance[run.pixels(width)].iter().copied().fold(peak, f32::max);
    }
    segments.pixels.push(pixels);
    segments.peaks.push(peak);
}

#[cfg(test)]
mod tests {
    use super::super::test_maps::drawn;
    use super::*;

    /// The places in a map of 128 x 256 pixels, of the luminance 1 but for a square on the seam.
    fn places(luminance: char, label: u32) -> Segments {
        places_of(luminance, label, 1.0)
    }

    /// Those in what is left of a map of this many times the flux.
    fn places_of(luminance: char, label: u32, before: f64) -> Segments {
        let is_inside =
            |y: usize, x: usize| y.abs_diff(60) < 10 && (x + 128) % 256 > 118 && (x + 128) % 256 < 138;
        let pixel = |y: usize, x: usize| if is_inside(y, x) { luminance } else { '1' };
        let rows: Vec<String> = (0..128).map(|y| (0..256).map(|x| pixel(y, x)).collect()).collect();
        let working = drawn(&rows.iter().map(String::as_str).collect::<Vec<_>>());
        let mut segments = Segments { pixels: Vec::new(), peaks: Vec::new(), label: vec![0; 128 * 256] };
        segments.label[60 * 256] = label;
        add(&working, &Adjacency::of(&working), &mut segments, before * working.flux);
        segments
    }

    #[test]
    fn a_place_is_added_with_its_pixels_its_peak_and_its_label() {
        let segments = places('3', 0);
        assert_eq!(segments.pixels.iter().map(Vec::len).collect::<Vec<_>>(), [19 * 19]);
        assert!((segments.peaks[0] - 3.0).abs() < 1e-6);
        assert_eq!(segments.label.iter().filter(|&&label| label == 1).count(), 19 * 19);
        assert!(segments.pixels[0].is_sorted());
    }

    #[test]
    fn what_has_too_little_contrast_or_holds_a_light_is_none() {
        assert!(places('2', 0).pixels.is_empty());
        assert!(places('3', 7).pixels.is_empty());
    }

    #[test]
    fn what_gave_too_little_beside_the_lights_that_were_taken_is_none() {
        assert_eq!(places_of('3', 0, 3.0).pixels.len(), 1);
        assert!(places_of('3', 0, 9.0).pixels.is_empty());
    }

    #[test]
    fn only_faint_places_are_measured_without_their_background() {
        assert_eq!(behind(&[1.0, 2.0, 3.0], 2), [1.0, 2.0, 0.0]);
    }
}
