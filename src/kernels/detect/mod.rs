//! Lights of a map. [`detect`] finds them with the component tree of Salembier et al. (1998); `loghin/` holds the
//! steps of Loghin (2021), which Python combines.
//!
//! One pipeline serves maps that hold all radiance and maps that were cut off at a clip level, such as 8-bit
//! pictures. Two front ends supply the image in which bright pixels are connected, and its threshold:
//!
//! | step of [`detect`]                                  | unclipped map               | clipped map                   |
//! |-----------------------------------------------------|-----------------------------|-------------------------------|
//! | reduce the map                                      | `segment/working_image.rs`  | `clipped/expanded_map.rs`     |
//! | image that is searched                              | luminance                   | expanded luminance            |
//! | choose the threshold                                | `segment/threshold.rs`      | same, on expanded luminance   |
//! | connect bright pixels to segments                   | `segment/components.rs`     | same                          |
//! | join segments across narrow gaps                    | `segment/bridging.rs`       | same                          |
//! | divide segments where the clipped region is narrow  |                             | `clipped/necks.rs`            |
//! | direction, uncertainty and weight of each light     |                             | `clipped/position.rs`, `clipped/order.rs` |
//! | trim segments, find their outlines                  | `segment/outline.rs`        | same                          |
//! | local background of each segment                    | `segment/background.rs`     | same                          |
//! | measure lights in the map's own pixels              | `segment/measure.rs`        | same                          |
//! | join the panes of one window                        | `segment/bars.rs`           | same                          |
//! | drop the weakest lights, merge neighbours           | `segment/merge.rs`          | same                          |
//!
//! `plane_threshold.rs` is the threshold for a plane image, such as a photograph.

pub mod clipped;
pub mod clipping;
pub mod detection_options;
pub mod loghin;
pub mod plane_threshold;
pub mod segment;

use ndarray::{ArrayView2, ArrayView3};

use clipped::{ClippedLights, ClippedMap};
use clipping::Ceiling;
pub use detection_options::DetectionOptions;
use segment::adjacency::Adjacency;
use segment::components::{self, Segments};
use segment::light_moments::LightMoments;
use segment::merge::Selection;
use segment::threshold::{self, Threshold};
use segment::working_image::WorkingImage;
use segment::{background, bars, bridging, bright_pixels, measure, outline};

use crate::error::Result;
use crate::kernels::sphere::{Registration, check_lengths};

/// Lights, their pixels and the numbers of the report.
#[derive(Clone, Debug)]
pub struct Detection {
    /// Most flux first.
    pub lights: Vec<LightMoments>,
    /// Flat indices into the working image, of the pixels within the edge of a light.
    pub pixels: Vec<u32>,
    /// Light of each of `pixels`.
    pub light_of_pixel: Vec<u32>,
    /// Number of window panes that each light was joined from; 0 for all others.
    pub panes: Vec<usize>,
    /// For each light, true if it touches the border of the seen part of the map.
    pub is_cut: Vec<bool>,
    /// Numbers of the report.
    pub report: DetectionNumbers,
    /// Luminance of the working image.
    pub luminance: Vec<f32>,
    /// Properties of the lights of a clipped map.
    pub clipped: Option<ClippedLights>,
}

/// Threshold, sizes and counts of one detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionNumbers {
    /// Luminance above which a pixel is bright.
    pub threshold: Threshold,
    /// Integral of the map's luminance.
    pub flux: f64,
    /// Height and width of the working image.
    pub working_size: (usize, usize),
    /// Tiles of the working image.
    pub tiles: usize,
    /// Tiles that hold a bright pixel.
    pub opened_tiles: usize,
    /// Lights dropped for their flux or their worth.
    pub dropped: usize,
    /// Lights that became part of another for `max_lights`.
    pub merged: usize,
}

/// Lights of an equirectangular map of radiance, (height, width, 3), finite and not negative.
///
/// `seen` is the share of each pixel that the map shows, from 0 to 1, by which its radiance is multiplied already.
///
/// # Errors
///
/// [`crate::error::Error::NotAMap`], [`crate::error::Error::UnusableSamples`], [`crate::error::Error::TooBright`],
/// [`crate::error::Error::LengthMismatch`].
pub fn detect(
    radiance: ArrayView3<'_, f32>,
    seen: Option<ArrayView2<'_, f32>>,
    registration: Registration,
    options: &DetectionOptions,
) -> Result<Detection> {
    if let Some(seen) = &seen {
        let (height, width, _) = radiance.dim();
        check_lengths("pixels", height * width, [("seen", seen.len())])?;
        check_lengths("rows", height, [("seen", seen.nrows())])?;
    }
    // Run all of it inside the thread pool: from outside, each parallel loop would wake the pool anew.
    rayon::scope(|_| {
        let scene = Scene::of(radiance, seen, registration, options)?;
        Ok(scene.lights(radiance, registration, options))
    })
}

/// Reduced map, and the image in which bright pixels are connected.
struct Scene {
    /// Reduced luminance.
    working: WorkingImage,
    /// Threshold of the searched image.
    threshold: Threshold,
    /// Image that is searched in a clipped map; `working` is searched in others.
    clipped: Option<ClippedMap>,
}

impl Scene {
    /// The front end for this map.
    fn of(
        radiance: ArrayView3<'_, f32>,
        seen: Option<ArrayView2<'_, f32>>,
        registration: Registration,
        options: &DetectionOptions,
    ) -> Result<Self> {
        let (columns, threshold) = (options.working_columns, options.threshold);
        if let Some(clip_level) = options.clip_level
            && let Some((working, map, threshold)) =
                ClippedMap::of(radiance, seen, registration, columns, clip_level, threshold)?
        {
            return Ok(Self { working, threshold, clipped: Some(map) });
        }
        let working = WorkingImage::of(radiance, registration, columns)?.with_seen(seen, registration);
        let threshold = threshold.map_or_else(|| threshold::from_histogram(&working), Threshold::fixed);
        Ok(Self { working, threshold, clipped: None })
    }

    /// Image in which bright pixels are connected.
    fn searched_image(&self) -> &WorkingImage {
        self.clipped.as_ref().map_or(&self.working, |map| &map.expanded)
    }

    /// Lights of the map.
    fn lights(
        self,
        radiance: ArrayView3<'_, f32>,
        registration: Registration,
        options: &DetectionOptions,
    ) -> Detection {
        let (working, searched, adjacency) =
            (&self.working, self.searched_image(), Adjacency::of(&self.working));
        // Find the segments of lights.
        let bright = bright_pixels::bright_pixels(searched, self.threshold.luminance);
        let rule = options.tree_rule();
        let segments = components::segments(searched, &adjacency, &bright.indices, &self.threshold, &rule);
        let segments = bridging::bridge(searched, &adjacency, segments, options.prominence, options.gap);
        let (segments, positions) = match &self.clipped {
            Some(map) => {
                let (segments, positions) =
                    map.divide(working, &adjacency, &bright.indices, segments, options.gap);
                (segments, Some(positions))
            }
            None => (segments, None),
        };
        // Measure them in the map's own pixels.
        let segments = outline::trim(&adjacency, segments);
        let outline = outline::outline(&adjacency, &segments);
        let backgrounds = background::local_backgrounds(radiance, working, &adjacency, &segments, &outline);
        let mut lights = measure::measure(radiance, registration, working, &segments, &backgrounds);
        if let Some(positions) = &positions {
            positions.turn(&mut lights);
        }
        // Join panes, and select the lights that count.
        let backgrounds = backgrounds.iter().map(|background| background.luminance).collect();
        let windows = bars::join(working, &adjacency, &segments, &outline, options.gap, lights, backgrounds);
        let is_listed = |light: &LightMoments, background| {
            light.flux >= options.min_flux_fraction * working.flux
                && (positions.is_some() || options.is_worth_a_line(light, background, working.flux))
        };
        let (selection, panes) = windows.select(is_listed, options.max_lights);
        let clipped = positions.map(|positions| positions.join(&selection));
        let mut numbers = self.numbers(bright.opened_tiles, &selection);
        if let Some(map) = &self.clipped {
            numbers.threshold = map.compress(numbers.threshold);
        }
        let cut = working.seen.as_ref().map(|seen| outline::are_cut(seen, &adjacency, &segments, &outline));
        let is_cut = selection.any_of_parts(&cut.unwrap_or_default());
        let luminance = self.working.luminance;
        Detection::new(&segments, selection, panes, is_cut, numbers, luminance, clipped)
    }

    fn numbers(&self, opened_tiles: usize, selection: &Selection) -> DetectionNumbers {
        let Self { working, threshold, .. } = self;
        DetectionNumbers {
            threshold: *threshold,
            flux: working.flux,
            working_size: working.size,
            tiles: working.tile_maxima.len(),
            opened_tiles,
            dropped: selection.dropped,
            merged: selection.merged,
        }
    }
}

impl Detection {
    /// For each light, true if a camera or a file cut it off: at `clip_level` if that is known, else at the largest sample.
    pub fn are_clipped(&self, clip_level: Option<f64>) -> impl Iterator<Item = bool> {
        let maximum = self.lights.iter().map(|light| light.largest.sample).fold(0.0, f32::max);
        let ceiling =
            clip_level.map_or(Ceiling::Maximum(maximum), |clip_level| Ceiling::White(clip_level as f32));
        self.lights.iter().map(move |light| light.is_clipped(ceiling))
    }

    fn new(
        segments: &Segments,
        selection: Selection,
        panes: Vec<usize>,
        is_cut: Vec<bool>,
        report: DetectionNumbers,
        luminance: Vec<f32>,
        clipped: Option<ClippedLights>,
    ) -> Self {
        let (mut pixels, mut light_of_pixel) = (Vec::new(), Vec::new());
        for (segment, light) in segments.pixels.iter().zip(&selection.part_of) {
            let Some(light) = light else { continue };
            pixels.extend(segment.iter().filter(|&&index| segments.label[index as usize] != 0));
            light_of_pixel.resize(pixels.len(), *light as u32);
        }
        Self { lights: selection.lights, pixels, light_of_pixel, panes, is_cut, report, luminance, clipped }
    }
}
