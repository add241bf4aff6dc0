//! Lights of maps whose values end at a known white, as those of 8-bit pictures do.
//!
//! The threshold of [`super::tree`] is twice the luminance that most of the sphere does not exceed. In a
//! picture of usual exposure that is above white. Here the tree works on expanded luminance, and what white
//! has made equal is told apart by its shape. [`detect`] calls the steps in this order:
//!
//! | step                                                            | file           |
//! |-----------------------------------------------------------------|----------------|
//! | the map in fewer pixels: luminance, and expanded luminance      | `reduction.rs` |
//! | the value at which the picture ends                             | `ending.rs`    |
//! | the curve that expands luminance below it                       | `expansion.rs` |
//! | threshold, component tree, bridging                             | `../tree/`     |
//! | the plateau of white pixels, its bars closed                    | `plateau.rs`   |
//! | the depth of each of its pixels                                 | `depth.rs`     |
//! | divide segments at the necks of the plateau                     | `necks.rs`     |
//! | the direction of each light, and how uncertain it is            | `placement.rs` |
//! | which lights are kept, and their order                          | `order.rs`     |
//!
//! [`shares`], in `sharing.rs`, spreads the light that white has cut off over the same plateau.

mod depth;
mod ending;
mod expansion;
mod necks;
mod order;
mod placement;
mod plateau;
mod reduction;
mod sharing;

use ndarray::ArrayView3;

pub use ending::Ending;
pub use expansion::{compressed, expand};
pub use placement::Place;
use reduction::Reduced;
pub use sharing::{plateau_depth, shares};

use super::clipping::LEAST_WHITE;
use super::tree::adjacency::Adjacency;
use super::tree::moments::Light;
use super::tree::threshold::{self, Threshold};
use super::tree::{
    Detection, Options, Original, Report, WorkingImage, background, bars, bridging, components, measure,
    outline,
};
use crate::error::Result;
use crate::kernels::sphere::Registration;

/// The share of the sphere that may be bright before fewer pixels do: the work is that of bright pixels, and so large a
/// bright area has no fine detail.
const MOST_BRIGHT: f64 = 0.12;
/// But not fewer columns than these.
const LEAST_COLUMNS: usize = 16;

/// Lights of a map that ends at white, and how they were found.
#[derive(Clone, Debug)]
pub struct WhiteDetection {
    /// The lights as the tree measures them: their flux is what white has left of it. Its threshold is that
    /// of the map's luminance.
    pub detection: Detection,
    /// Where each light is.
    pub places: Vec<Place>,
    /// How much each light is likely to give: the order of lights.
    pub weights: Vec<f64>,
    /// Where the picture ends.
    pub ending: Ending,
    /// Share of the sphere at white.
    pub clipped_share: f64,
    /// The weight that a light needs.
    pub least_weight: f64,
}

/// Lights of an equirectangular map of radiance, (height, width, 3), finite and not negative, of which `white`
/// is the largest luminance that it can hold.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`], [`crate::error::Error::TooBright`].
pub fn detect(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    white: f64,
    options: &Options,
) -> Result<WhiteDetection> {
    // Run all of it inside the thread pool: from outside, each parallel loop would wake the pool anew.
    rayon::scope(|_| detect_in_pool(radiance, registration, white, options))
}

fn detect_in_pool(
    radiance: ArrayView3<'_, f32>,
    registration: Registration,
    white: f64,
    options: &Options,
) -> Result<WhiteDetection> {
    // Find where the picture ends, or where the original did. One that ends far below white has lost nothing to it.
    let reduced = |end| Reduced::of(radiance, registration, options.working_columns, end);
    let first = reduced(white)?;
    let original = options.original.as_ref();
    let ending =
        original.map_or_else(|| Ending::of(&first.working, first.maximum, white), Ending::of_original);
    let clipped_share = ending::share_above(&first.working, LEAST_WHITE * white);
    let Some(end) = ending.luminance() else {
        let detection = super::tree::detect(radiance, registration, options)?;
        return Ok(WhiteDetection::measured(detection, ending, clipped_share));
    };
    // Expand it anew if it ends in a peak below white, as few pictures do.
    let first = if end < white { reduced(end)? } else { first };
    // Reduce it further if much of it is bright; an original comes with as many columns as it had then.
    let mut level = threshold_of(&first, end, original);
    let bright_share = ending::share_above(&first.expanded, level.luminance);
    let wanted = if original.is_some() { 1.0 } else { (bright_share / MOST_BRIGHT).sqrt() };
    let factor = coarser_by(&first.working, radiance.dim().1, wanted);
    let Reduced { working, expanded, .. } = if factor > 1 {
        let coarser = first.coarser(factor);
        level = threshold_of(&coarser, end, original);
        coarser
    } else {
        first
    };
    // Find the segments of lights in the expanded image.
    let adjacency = Adjacency::of(&working);
    let bright = components::bright_pixels(&expanded, level.luminance);
    let segments = components::segments(
        &expanded,
        &adjacency,
        &bright,
        &level,
        options.rise,
        options.prominence,
        options.extent,
    );
    let segments = bridging::bridge(&expanded, &adjacency, segments, options.prominence, options.gap);
    // Divide them at the necks of the plateau.
    let plateau = plateau::closed(&expanded, &bright.indices, options.gap);
    let depth = depth::depths(&working, &plateau);
    let parts = necks::parts(&working, &plateau, &depth);
    let segments = necks::divide(&adjacency, segments, &parts, &working.luminance);
    // Place the lights, weigh them and leave out the least.
    let places = placement::places(&working, &expanded, &segments, &depth);
    let weights = order::weights(&expanded, &segments, &places);
    let cut_off = original.and_then(|original| original.white);
    let least_weight = cut_off.map_or_else(|| order::least_weight(&weights), |cut_off| cut_off.least_weight);
    let (segments, places, weights) = order::without_the_least(segments, places, weights, least_weight);
    // Measure them in the map's own pixels.
    let segments = outline::trim(&adjacency, segments);
    let outline = outline::outline(&adjacency, &segments);
    let backgrounds = background::local_backgrounds(&working, &adjacency, &segments, &outline);
    let lights = measure::measure(radiance, registration, &working, &segments, &backgrounds);
    let lights: Vec<_> =
        lights.into_iter().zip(&places).map(|(light, place)| light.turned_to(place.direction)).collect();
    // Join panes, and select the lights that hold enough flux.
    let openings = bars::join(&working, &adjacency, &segments, &outline, options.gap, lights, backgrounds);
    let is_listed = |light: &Light, _| light.flux >= options.min_flux_share * working.flux;
    let (selection, panes) = openings.select(is_listed, options.max_lights);
    let level = level.map(|expanded| f64::from(compressed(expanded as f32, end as f32)));
    let report = Report::of(&working, level, &bright, &selection);
    let part_of = selection.part_of.clone();
    let is_faint = vec![false; selection.lights.len()];
    let detection = Detection::new(&segments, selection, panes, is_faint, report, working.luminance);
    let (places, weights) = order::joined(&detection.lights, &part_of, &places, &weights);
    Ok(WhiteDetection { detection, places, weights, ending, clipped_share, least_weight })
}

/// By what factor the pixels of a map of this `width` become coarser, at most the next whole number from `wanted` on:
/// one with which they are those of a reduction to as many columns. That is how the pixels of lights are found again.
fn coarser_by(working: &WorkingImage, width: usize, wanted: f64) -> usize {
    let is_reduction = |factor: &usize| {
        let block = factor * working.block;
        let columns = width.div_ceil(block);
        columns >= LEAST_COLUMNS && width.div_ceil(columns) == block
    };
    (2..=wanted.ceil() as usize).rev().find(is_reduction).unwrap_or(1)
}

/// The expanded luminance above which a pixel is bright, of a picture that ends there, or of its original.
fn threshold_of(reduced: &Reduced, end: f64, original: Option<&Original>) -> Threshold {
    if let Some(original) = original {
        return Threshold::of(original).map(|luminance| f64::from(expand((luminance / end) as f32)));
    }
    let mut threshold = threshold::from_histogram(&reduced.expanded);
    let white_share = ending::share_above(&reduced.working, LEAST_WHITE * end);
    threshold.luminance = expansion::below_white(threshold.luminance, white_share);
    threshold
}

impl WhiteDetection {
    /// Lights of a picture that has lost nothing to white.
    fn measured(detection: Detection, ending: Ending, clipped_share: f64) -> Self {
        let places = detection.lights.iter().map(Place::measured).collect();
        let weights = detection.lights.iter().map(|light| light.flux).collect();
        Self { detection, places, weights, ending, clipped_share, least_weight: 0.0 }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use ndarray::Array3;

    use super::*;

    #[test]
    fn coarser_pixels_are_told_by_the_number_of_their_columns() {
        for (width, columns) in [(256, 32), (300, 100), (74, 37), (1024, 512), (1440, 480), (64, 16)] {
            let map = Array3::from_elem((width / 2, width, 3), 0.5_f32);
            let working = WorkingImage::of(map.view(), Registration::CellCentred, columns).unwrap();
            for wanted in [0.3, 1.0, 1.2, 2.0, 2.9] {
                let factor = coarser_by(&working, width, wanted);
                assert!(factor >= 1 && factor as f64 <= wanted.ceil().max(1.0), "{width} {wanted}");
                let fewer = working.size.1.div_ceil(factor);
                assert!(factor == 1 || fewer >= LEAST_COLUMNS, "{width} {wanted}");
                assert_eq!(width.div_ceil(fewer), factor * working.block, "{width} {wanted}");
            }
        }
        let map = Array3::from_elem((512, 1024, 3), 0.5_f32);
        let working = WorkingImage::of(map.view(), Registration::CellCentred, 512).unwrap();
        assert_eq!([0.9, 1.7, 2.8].map(|wanted| coarser_by(&working, 1024, wanted)), [1, 2, 3]);
    }
}
