//! Luminance of linear RGB, once for each float type.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

/// Weights of linear Rec.709 red, green and blue in luminance.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Weights of luminance in single precision.
pub const LUMINANCE_F32: [f32; 3] = [LUMINANCE[0] as f32, LUMINANCE[1] as f32, LUMINANCE[2] as f32];

/// Luminance of linear Rec.709 RGB.
pub fn luminance(rgb: [f64; 3]) -> f64 {
    LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2]
}

/// Luminance of linear Rec.709 RGB in single precision.
#[inline(always)]
pub fn luminance_f32(rgb: [f32; 3]) -> f32 {
    LUMINANCE_F32[0] * rgb[0] + LUMINANCE_F32[1] * rgb[1] + LUMINANCE_F32[2] * rgb[2]
}
