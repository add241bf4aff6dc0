//! Lights of a map as the branches of its component tree.
//!
//! [`detect`] calls the steps in this order:
//!
//! | step                                                       | file                 |
//! |------------------------------------------------------------|----------------------|
//! | reduce the map to a working image                          | `working_image.rs`   |
//! | choose the threshold above which a pixel is bright         | `threshold.rs`       |
//! | which pixels are neighbours, pixels side by side           | `adjacency.rs`, `run.rs` |
//! | the component tree: segments of connected bright pixels    | `components.rs`      |
//! | - bright pixels that no saddle divides                     | `top.rs`             |
//! | - what is joined with what                                 | `forest.rs`          |
//! | join the segments that only a bar divides                  | `bridging.rs`        |
//! | add large places of low contrast with a sharp rim          | `faint.rs`           |
//! | - cells that stand out of what is around them              | `candidates.rs`      |
//! | - connected pixels above a level                           | `fill.rs`            |
//! | - how far the luminance falls across the rim               | `rim.rs`             |
//! | trim the segments; the pixels on the outline of each       | `outline.rs`         |
//! | the local background of each segment                       | `background.rs`      |
//! | measure each light in the map's own pixels                 | `measure.rs`         |
//! | - its coverage of each pixel                               | `coverage.rs`        |
//! | - its moments                                              | `moments.rs`         |
//! | - dot products in wide vectors                             | `dot_product.rs`     |
//! | join the panes of one opening behind bars                  | `bars.rs`            |
//! | which lights are worth a line                              | `worth.rs`           |
//! | drop the dimmest lights, merge neighbours (Ward's linkage) | `linkage.rs`         |
//! | the radius of discs of few pixels                          | `small_discs.rs`     |

pub(super) mod adjacency;
pub(super) mod background;
pub(super) mod bars;
pub(super) mod bridging;
mod candidates;
pub(super) mod components;
mod coverage;
mod dot_product;
mod faint;
mod fill;
mod forest;
pub(super) mod linkage;
pub(super) mod measure;
pub(super) mod moments;
pub(super) mod outline;
mod rim;
pub(super) mod run;
mod small_discs;
#[cfg(test)]
pub(super) mod test_maps;
pub(super) mod threshold;
mod top;
pub(super) mod working_image;
mod worth;

use ndarray::ArrayView3;

use adjacency::Adjacency;
pub use bars::{WIDEST_ANGLE, WIDEST_BAR};
use components::{BrightPixels, Segments};
pub use dot_product::dot;
pub use faint::LARGEST_PLACE;
use linkage::Selection;
pub use moments::Light;
pub use run::{Run, runs};
pub use threshold::{Original, OriginalWhite, Rule, Threshold};
pub use working_image::WorkingImage;

use super::clipping::Ceiling;
use crate::error::Result;
use crate::kernels::sphere::Registration;

/// How [`detect`] decides. Defaults are chosen in Python, in one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most columns of the working image, in pixels.
    pub working_columns: usize,
    /// A light's peak over the threshold, at least.
    pub rise: f64,
    /// A light's peak over the highest saddle to a brighter one, at least: 4 tells two lamps apart
    /// where the way between them falls to a quarter of the dimmer.
    pub prominence: f64,
    /// A light ends where its luminance has fallen to this share of its peak.
    pub extent: f64,
    /// Dark gaps up to this angle, in radians, do not divide a light.
    pub gap: f64,
    /// Lights with a smaller share of the map's flux are left out.
    pub min_flux_share: f64,
    /// Lights whose share of the map's flux times contrast is smaller are left out: see `worth.rs`.
    pub min_worth: f64,
    /// Most lights; neighbours are merged until there are no more.
    pub max_lights: usize,
    /// The map from which lights were taken to make this one: what counts is judged as there.
    pub original: Option<Original>,
}

/// Lights, and how they were found.
#[derive(Clone, Debug)]
pub struct Detection {
    /// Most flux first.
    pub lights: Vec<Light>,
    /// Flat indices into the working image, of the pixels within the edge of a light.
    pub pixels: Vec<u32>,
    /// The light of each of `pixels`.
    pub light_of_pixel: Vec<u32>,
    /// How many panes behind bars each light was joined from; 0 for all others.
    pub panes: Vec<usize>,
    /// Whether each light was found by its rim, as a place of low contrast.
    pub is_faint: Vec<bool>,
    /// How they were found.
    pub report: Report,
    /// The working image.
    pub luminance: Vec<f32>,
}

/// How lights were found: the threshold, what was opened, dropped and merged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Above it a pixel is bright.
    pub threshold: Threshold,
    /// Integral of the map's luminance.
    pub flux: f64,
    /// Height and width of the working image.
    pub working_size: (usize, usize),
    /// Tiles of the working image.
    pub tiles: usize,
    /// Tiles that hold a bright pixel.
    pub opened_tiles: usize,
    /// Lights below `min_flux_share` or `min_worth`.
    pub dropped: usize,
    /// Lights that became part of another for `max_lights`.
    pub merged: usize,
}

/// Lights of an equirectangular map of radiance, (height, width, 3), finite and not negative.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`], [`crate::error::Error::TooBright`].
pub fn detect(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    options: &Options,
) -> Result<Detection> {
    // Run all of it inside the thread pool: from outside, each parallel loop would wake the pool anew.
    rayon::scope(|_| detect_in_pool(radiance, registration, options))
}

fn detect_in_pool(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    options: &Options,
) -> Result<Detection> {
    let working = WorkingImage::of(radiance, registration, options.working_columns)?;
    let adjacency = Adjacency::of(&working);
    let original = options.original.as_ref();
    let threshold = original.map_or_else(|| threshold::from_histogram(&working), Threshold::of);
    let whole = original.map_or(working.flux, |original| original.flux);
    let bright = components::bright_pixels(&working, threshold.luminance);
    let segments = components::segments(
        &working,
        &adjacency,
        &bright,
        &threshold,
        options.rise,
        options.prominence,
        options.extent,
    );
    let mut segments = bridging::bridge(&working, &adjacency, segments, options.prominence, options.gap);
    let first_faint = segments.pixels.len();
    faint::add(&working, &adjacency, &mut segments, whole);
    let segments = outline::trim(&adjacency, segments);
    let outline = outline::outline(&adjacency, &segments);
    let backgrounds = background::local_backgrounds(&working, &adjacency, &segments, &outline);
    let behind = faint::behind(&backgrounds, first_faint);
    let lights = measure::measure(radiance, registration, &working, &segments, &behind);
    let openings = bars::join(&working, &adjacency, &segments, &outline, options.gap, lights, backgrounds);
    // Select the lights that hold enough flux and are worth a line.
    let is_listed = |light: &Light, background: f64| {
        light.flux >= options.min_flux_share * working.flux
            && worth::is_worth_a_line(light, background, whole, options.min_worth)
    };
    let (mut selection, panes) = openings.select(is_listed, options.max_lights);
    small_discs::measure(radiance, registration, &mut selection.lights);
    let is_faint = selection.holding(first_faint);
    let report = Report::of(&working, threshold, &bright, &selection);
    Ok(Detection::new(&segments, selection, panes, is_faint, report, working.luminance))
}

impl Report {
    pub(super) fn of(
        working: &WorkingImage,
        threshold: Threshold,
        bright: &BrightPixels,
        selection: &Selection,
    ) -> Self {
        Self {
            threshold,
            flux: working.flux,
            working_size: working.size,
            tiles: working.tile_maxima.len(),
            opened_tiles: bright.opened_tiles,
            dropped: selection.dropped,
            merged: selection.merged,
        }
    }
}

impl Detection {
    /// Whether each light is clipped: at `white` where that is known, else at the map's largest sample.
    pub fn are_clipped(&self, white: Option<f32>) -> impl Iterator<Item = bool> {
        let maximum = self.lights.iter().map(|light| light.largest.sample).fold(0.0, f32::max);
        let ceiling = white.map_or(Ceiling::Maximum(maximum), Ceiling::White);
        self.lights.iter().map(move |light| light.is_clipped(ceiling))
    }

    pub(super) fn new(
        segments: &Segments,
        selection: Selection,
        panes: Vec<usize>,
        is_faint: Vec<bool>,
        report: Report,
        luminance: Vec<f32>,
    ) -> Self {
        let (mut pixels, mut light_of_pixel) = (Vec::new(), Vec::new());
        for (segment, light) in segments.pixels.iter().zip(&selection.part_of) {
            let Some(light) = light else { continue };
            pixels.extend(segment.iter().filter(|&&index| segments.label[index as usize] != 0));
            light_of_pixel.resize(pixels.len(), *light as u32);
        }
        Self { lights: selection.lights, pixels, light_of_pixel, panes, is_faint, report, luminance }
    }
}
