//! The value at which a picture ends.
//!
//! Most pictures reach white. A film curve may let one end a little below it, with a single peak at the top;
//! its largest luminance then takes the place of white. A picture that ends far below white, or in a broad
//! even top, has lost nothing: what it shows is what there is.

use super::super::clipping::LEAST_WHITE;
use super::super::tree::Original;
use super::super::tree::working_image::{TILE, WorkingImage};

/// A picture that ends below this share of white has lost nothing to it.
const LEAST_END: f64 = 0.7;
/// The top of a picture: this share of its largest luminance, and more.
const TOP: f64 = 0.9;
/// A top that covers more than this share of the sphere is not a peak.
const MOST_OF_THE_SPHERE: f64 = 0.05;

/// Where a picture ends; luminance in the units of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// At white.
    White(f64),
    /// In a peak below white.
    Peak(f64),
    /// Below white, with nothing lost.
    Whole(f64),
}

impl Ending {
    /// Where a picture ends whose values end at `white`, from the `maximum` luminance of its pixels: a lamp that is
    /// smaller than a working pixel reaches white too.
    pub fn of(working: &WorkingImage, maximum: f64, white: f64) -> Self {
        if maximum >= LEAST_WHITE * white {
            return Self::White(white);
        }
        let is_peak = || share_above(working, TOP * maximum) < MOST_OF_THE_SPHERE;
        if maximum >= LEAST_END * white && is_peak() { Self::Peak(maximum) } else { Self::Whole(maximum) }
    }

    /// Where a picture ended before lights were taken out of it.
    pub fn of_original(original: &Original) -> Self {
        original.white.map_or(Self::Whole(original.peak), |white| Self::White(white.end))
    }

    /// The luminance at which values are cut off, if any.
    pub fn luminance(self) -> Option<f64> {
        match self {
            Self::White(end) | Self::Peak(end) => Some(end),
            Self::Whole(_) => None,
        }
    }
}

/// The share of the sphere whose luminance is `least` or more. Only tiles that hold any are read.
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
