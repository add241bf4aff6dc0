//! Lights of a map as the branches of its component tree.
//!
//! [`detect`] is the whole story; each line of it is a room of its own:
//!
//! | step                                     | file              |
//! |------------------------------------------|-------------------|
//! | the map in fewer pixels, in one pass     | `summary.rs`      |
//! | how bright is bright                     | `threshold.rs`    |
//! | which pixels touch, and in which rows    | `touch.rs`, `run.rs` |
//! | which pixels hang together, and how well | `components.rs`   |
//! | which lights only a bar divides          | `gaps.rs`         |
//! | which pixels lie around each light       | `outline.rs`      |
//! | what is behind each light                | `surroundings.rs` |
//! | what each light sends                    | `measure.rs`      |
//! | - of each pixel                          | `covered.rs`      |
//! | - in all                                 | `light.rs`        |
//! | - in wide vectors                        | `lanes.rs`        |
//! | how many lights there may be             | `budget.rs`       |

mod budget;
mod components;
mod covered;
#[cfg(test)]
mod drawn;
mod gaps;
mod lanes;
mod light;
mod measure;
mod outline;
mod run;
mod summary;
mod surroundings;
mod threshold;
mod touch;

use ndarray::ArrayView3;

use budget::Choice;
use components::{BrightPixels, Regions};
pub use light::Light;
pub use summary::{Summary, summarise};
pub use threshold::{Reason, Threshold};
use touch::Sheet;

use crate::error::Result;
use crate::kernels::sphere::Registration;

/// How [`detect`] decides. Defaults are chosen in Python, in one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most columns of the working image, in pixels.
    pub working_columns: usize,
    /// A light's peak over the highest saddle to a brighter one, at least: 4 tells two lamps apart
    /// where the way between them falls to a quarter of the dimmer.
    pub prominence: f64,
    /// A light ends where its luminance has fallen to this share of its peak.
    pub extent: f64,
    /// Dark gaps up to this angle, in radians, do not divide a light.
    pub gap: f64,
    /// Lights with a smaller share of the map's flux are left out.
    pub min_flux_share: f64,
    /// Most lights; neighbours are merged until there are no more.
    pub max_lights: usize,
}

/// Lights, and what was seen on the way to them.
#[derive(Clone, Debug)]
pub struct Detection {
    /// Most flux first.
    pub lights: Vec<Light>,
    /// Flat indices into the working image, of the pixels within the edge of a light.
    pub pixels: Vec<u32>,
    /// The light of each of `pixels`.
    pub light_of_pixel: Vec<u32>,
    /// What was looked at, and what was not.
    pub seen: Seen,
}

/// What was looked at, and what was not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Above what a pixel is bright.
    pub threshold: Threshold,
    /// Integral of the map's luminance.
    pub flux: f64,
    /// Height and width of the working image.
    pub working_size: (usize, usize),
    /// Tiles of the working image.
    pub tiles: usize,
    /// Tiles that hold a bright pixel.
    pub opened_tiles: usize,
    /// Lights below `min_flux_share`.
    pub dropped: usize,
    /// Lights that became part of another for `max_lights`.
    pub merged: usize,
}

/// Lights of an equirectangular map of radiance, (height, width, 3), finite and not negative.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::NotFinite`], [`crate::error::Error::Negative`],
/// [`crate::error::Error::TooBright`].
pub fn detect(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    options: &Options,
) -> Result<Detection> {
    // In the thread pool as a whole: from outside, each of the parallel loops would wake it anew.
    rayon::scope(|_| detect_in_pool(radiance, registration, options))
}

fn detect_in_pool(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    options: &Options,
) -> Result<Detection> {
    let summary = summarise(radiance, registration, options.working_columns)?;
    let sheet = Sheet::of(&summary);
    let threshold = threshold::from_histogram(&summary);
    let bright = components::bright_pixels(&summary, threshold.luminance);
    let regions = components::regions(&summary, &sheet, &bright, &threshold, options);
    let regions = gaps::bridge(&summary, &sheet, regions, options.prominence, options.gap);
    let regions = outline::trim(&sheet, regions);
    let outline = outline::outline(&sheet, &regions);
    let backgrounds = surroundings::backgrounds(&summary, &sheet, &regions, &outline);
    let lights = measure::measure(radiance, registration, &summary, &regions, &backgrounds);
    let choice = budget::choose(lights, options.min_flux_share * summary.flux, options.max_lights);
    let seen = Seen::of(&summary, threshold, &bright, &choice);
    Ok(Detection::new(&regions, choice, seen))
}

impl Seen {
    fn of(summary: &Summary, threshold: Threshold, bright: &BrightPixels, choice: &Choice) -> Self {
        Self {
            threshold,
            flux: summary.flux,
            working_size: summary.size,
            tiles: summary.tile_maxima.len(),
            opened_tiles: bright.opened_tiles,
            dropped: choice.dropped,
            merged: choice.part_of.len() - choice.dropped - choice.lights.len(),
        }
    }
}

impl Detection {
    /// Of each light, whether it is a flat top at the level of the brightest, as where a camera saturates.
    pub fn are_clipped(&self) -> impl Iterator<Item = bool> {
        let brightest = self.lights.iter().map(|light| light.peak).fold(0.0, f64::max);
        self.lights.iter().map(move |light| light.is_clipped(brightest))
    }

    fn new(regions: &Regions, choice: Choice, seen: Seen) -> Self {
        let (mut pixels, mut light_of_pixel) = (Vec::new(), Vec::new());
        for (region, light) in regions.pixels.iter().zip(&choice.part_of) {
            let Some(light) = light else { continue };
            pixels.extend(region.iter().filter(|&&index| regions.label[index as usize] != 0));
            light_of_pixel.resize(pixels.len(), *light as u32);
        }
        Self { lights: choice.lights, pixels, light_of_pixel, seen }
    }
}
