//! Lights that a camera has clipped: flat tops at the level of the brightest light.

/// Pixels that reach this share of a light's peak are its top.
pub const TOP: f64 = 0.99;
/// A top of this many pixels or more is flat.
const FLAT_TOP_PIXELS: usize = 4;

/// Whether a light is clipped: as bright as the brightest light, with many pixels at its peak.
pub fn is_clipped(peak: f64, top_pixels: usize, brightest: f64) -> bool {
    peak >= TOP * brightest && top_pixels >= FLAT_TOP_PIXELS
}
