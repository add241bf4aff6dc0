//! Front end for clipped maps: maps that were cut off at a clip level, as 8-bit pictures are.
//!
//! The threshold of an unclipped map is twice the luminance that most of the sphere does not exceed. In a picture of
//! usual exposure that lies above the clip level. Therefore the component tree works on expanded luminance, and lights
//! that the clip level has made equal are separated by the depth of their clipped regions.
//!
//! | step                                                     | file              |
//! |----------------------------------------------------------|-------------------|
//! | reduced luminance, and reduced expanded luminance        | `expanded_map.rs` |
//! | clip level of the map                                    | `clip_level.rs`   |
//! | expansion of luminance below the clip level              | `expansion.rs`    |
//! | clipped region with its gaps filled                      | `plateau.rs`      |
//! | depth of each of its pixels                              | `depth.rs`        |
//! | division of segments at the necks of the clipped region  | `necks.rs`        |
//! | direction of each light and its uncertainty              | `position.rs`     |
//! | weights, and the lights that are dropped                 | `order.rs`        |

mod clip_level;
pub mod depth;
mod expanded_map;
mod expansion;
pub mod necks;
pub mod order;
pub mod plateau;
mod position;

use ndarray::{ArrayView2, ArrayView3};

pub use clip_level::ClipLevel;
use expanded_map::ExpandedMap;
pub use expansion::{compress, expand};
pub use position::LightPosition;

use super::segment::adjacency::Adjacency;
use super::segment::components::Segments;
use super::segment::light_moments::LightMoments;
use super::segment::merge::Selection;
use super::segment::threshold::{self, Threshold};
use super::segment::working_image::WorkingImage;
use crate::error::Result;
use crate::kernels::image::LEAST_WHITE;
use crate::kernels::sphere::Registration;

/// Settings of the working image of a clipped map.
struct WorkingSettings {
    /// Columns of an unclipped map's working image over those of a clipped map: clipped regions have no fine detail.
    /// Without it, detection in a picture takes about three times as long.
    fewer_columns: usize,
    /// Least number of columns.
    least_columns: usize,
    /// Bright fraction of the sphere above which the image gets fewer columns: time grows with bright pixels.
    most_bright: f64,
}

const WORKING: WorkingSettings = WorkingSettings { fewer_columns: 2, least_columns: 16, most_bright: 0.12 };

/// A clipped map, reduced.
pub struct ClippedMap {
    /// Reduced expanded luminance.
    pub expanded: WorkingImage,
    level: ClipLevel,
    /// Fraction of the sphere at the largest value that the map can hold.
    clipped_fraction: f64,
}

/// Properties of the lights of a clipped map.
#[derive(Clone, Debug)]
pub struct ClippedLights {
    /// Position of each light.
    pub positions: Vec<LightPosition>,
    /// Weight of each light: lights are ordered by it.
    pub weights: Vec<f64>,
    /// Clip level of the map.
    pub level: ClipLevel,
    /// Fraction of the sphere at the largest value that the map can hold.
    pub clipped_fraction: f64,
}

impl ClippedMap {
    /// Reduced luminance of a map that can hold values up to `clip_level`, its expansion, and the threshold of the expansion.
    /// `seen` is the share of each pixel that the map shows.
    ///
    /// `None` if nothing was cut off.
    ///
    /// # Errors
    ///
    /// Errors of [`WorkingImage::of`].
    pub fn of(
        radiance: ArrayView3<'_, f32>,
        seen: Option<ArrayView2<'_, f32>>,
        registration: Registration,
        columns: usize,
        clip_level: f64,
        threshold: Option<f64>,
    ) -> Result<Option<(WorkingImage, Self, Threshold)>> {
        let columns = (columns / WORKING.fewer_columns).max(WORKING.least_columns);
        let reduced = |columns, level| -> Result<ExpandedMap> {
            Ok(ExpandedMap::of(radiance, registration, columns, level)?.with_seen(seen, registration))
        };
        let first = reduced(columns, clip_level)?;
        let Some(level) = ClipLevel::of(&first.working, first.maximum, clip_level) else { return Ok(None) };
        let clipped_fraction = clip_level::share_above(&first.working, LEAST_WHITE * clip_level);
        let end = level.luminance();
        let mut map = if end < clip_level { reduced(columns, end)? } else { first };
        let mut level_of_bright = threshold_of(&map, end, threshold);
        // Reduce the map further if much of it is bright.
        let bright = clip_level::share_above(&map.expanded, level_of_bright.luminance);
        let factor = (bright / WORKING.most_bright).sqrt().ceil() as usize;
        if factor > 1 && map.working.size.1 > WORKING.least_columns {
            map = reduced((map.working.size.1 / factor).max(WORKING.least_columns), end)?;
            level_of_bright = threshold_of(&map, end, threshold);
        }
        let ExpandedMap { working, expanded, .. } = map;
        Ok(Some((working, Self { expanded, level, clipped_fraction }, level_of_bright)))
    }

    /// Threshold in luminance instead of expanded luminance.
    pub fn compress(&self, threshold: Threshold) -> Threshold {
        let end = self.level.luminance() as f32;
        Threshold { luminance: f64::from(compress(threshold.luminance as f32, end)), ..threshold }
    }

    /// Divide segments at the necks of the clipped region, and drop those of little weight.
    ///
    /// `bright` are the pixels above the threshold. Gaps of up to `gap` radians in the clipped region are filled.
    pub fn divide(
        &self,
        working: &WorkingImage,
        adjacency: &Adjacency,
        bright: &[u32],
        segments: Segments,
        gap: f64,
    ) -> (Segments, ClippedLights) {
        let expanded = &self.expanded;
        let plateau = plateau::plateau(expanded, bright, gap);
        let depth = depth::depths(working, &plateau);
        let parts = necks::parts(working, &plateau, &depth);
        let segments = necks::divide(adjacency, segments, &parts, &working.luminance);
        let positions = position::positions(working, expanded, &segments, &depth);
        let weights = order::weights(expanded, &segments, &positions);
        let (segments, positions, weights) = order::drop_least(segments, positions, weights);
        let (level, clipped_fraction) = (self.level, self.clipped_fraction);
        (segments, ClippedLights { positions, weights, level, clipped_fraction })
    }
}

impl ClippedLights {
    /// Turn measured `lights` to their positions.
    pub fn turn(&self, lights: &mut [LightMoments]) {
        for (light, position) in lights.iter_mut().zip(&self.positions) {
            light.turn_to(position.direction);
        }
    }

    /// Positions and weights of the selected lights.
    #[must_use]
    pub fn join(self, selection: &Selection) -> Self {
        let (positions, weights) =
            order::join(&selection.lights, &selection.part_of, &self.positions, &self.weights);
        Self { positions, weights, ..self }
    }
}

/// Threshold of expanded luminance: a fixed one of luminance, or one chosen from the map.
fn threshold_of(map: &ExpandedMap, end: f64, fixed: Option<f64>) -> Threshold {
    if let Some(luminance) = fixed {
        return Threshold::fixed(f64::from(expand((luminance / end) as f32)));
    }
    let mut threshold = threshold::from_histogram(&map.expanded);
    let share = clip_level::share_of_seen(&map.working, LEAST_WHITE * end);
    threshold.luminance = expansion::below_white(threshold.luminance, share);
    threshold
}
