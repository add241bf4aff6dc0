//! Clip level of a map.
//!
//! Most 8-bit pictures reach the largest value that they can hold. A film curve may let one end a little below it, in a
//! single small peak, whose luminance is then the clip level. A picture that ends far below, or in a broad even top,
//! has lost nothing, so it is treated as any other map.

use super::super::segment::working_image::{TILE, WorkingImage};
use crate::kernels::image::LEAST_WHITE;
use crate::kernels::image::SeenPart;

/// Settings of the clip level of a map that ends below the largest possible value.
///
/// The rule of histograms, `white_of`, does not replace it. Without a peak, the brightest light is found in 76 instead
/// of 100 % of the pictures with Reinhard's curve (`benchmarks/clipped_maps.py`), and 4 of 17 have no light.
struct PeakSettings {
    /// A map whose maximum is below this fraction of the largest possible value is not clipped.
    least_end: f64,
    /// Pixels of this fraction of the largest luminance and more form the top of a map.
    top: f64,
    /// A top that covers more than this fraction of what is seen is not a peak.
    largest_top: f64,
}

const PEAK: PeakSettings = PeakSettings { least_end: 0.7, top: 0.9, largest_top: 0.05 };

/// Luminance at which a map was cut off, in the units of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClipLevel {
    /// The largest value that the map can hold.
    White(f64),
    /// The top of a small peak a little below that.
    Peak(f64),
}

impl ClipLevel {
    /// Clip level of a map that can hold values up to `clip_level`; `None` if nothing was cut off.
    ///
    /// `maximum` is the largest luminance of the map's own pixels: a lamp smaller than a working pixel is clipped too.
    pub fn of(working: &WorkingImage, maximum: f64, clip_level: f64) -> Option<Self> {
        if maximum >= LEAST_WHITE * clip_level {
            return Some(Self::White(clip_level));
        }
        let is_peak = || share_of_seen(working, PEAK.top * maximum) < PEAK.largest_top;
        (maximum >= PEAK.least_end * clip_level && is_peak()).then_some(Self::Peak(maximum))
    }

    /// Luminance at which values are cut off.
    pub fn luminance(self) -> f64 {
        match self {
            Self::White(level) | Self::Peak(level) => level,
        }
    }
}

/// Fraction of what is seen whose luminance is `least` or more.
pub fn share_of_seen(working: &WorkingImage, least: f64) -> f64 {
    share_above(working, least) / working.seen.as_ref().map_or(1.0, SeenPart::fraction)
}

/// Fraction of the sphere whose luminance is `least` or more. Only tiles that hold any are read.
pub fn share_above(working: &WorkingImage, least: f64) -> f64 {
    let least = least as f32;
    let (height, width) = working.size;
    let mut solid_angle = 0.0;
    for (tile_row, maxima) in working.tile_maxima.outer_iter().enumerate() {
        if maxima.iter().all(|&maximum| maximum < least) {
            continue;
        }
        for row in tile_row * TILE..((tile_row + 1) * TILE).min(height) {
            let pixels = &working.luminance[row * width..(row + 1) * width];
            let count = pixels.iter().filter(|&&luminance| luminance >= least).count();
            solid_angle += count as f64 * working.bands[row];
        }
    }
    solid_angle / (2.0 * width as f64)
}
