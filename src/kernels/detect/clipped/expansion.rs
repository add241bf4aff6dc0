//! Expanded luminance: values close to the clip level become much larger.
//!
//! The curve of Schlick (1994), backwards, with y in units of the clip level:
//!
//! ```text
//!   y' = y / (1 + e - y)        e = 0.02:  y' = 50 at the clip level, y in the dark
//!   y  = (1 + e) y' / (1 + y')
//! ```
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

/// Inverse of the expanded clip level. Larger values merge lamps with the white walls around them.
const DISTANCE: f32 = 0.02;
/// The threshold is at most the expansion of this fraction of the clip level.
const HIGHEST_THRESHOLD: f32 = 0.97;
/// On a sphere with more than this fraction clipped, no light is brighter than its surroundings.
const MOSTLY_WHITE: f64 = 0.5;

/// Expand a fraction of the clip level.
#[inline(always)]
pub fn expand(share: f32) -> f32 {
    let share = if share < 1.0 { share } else { 1.0 };
    share / (1.0 + DISTANCE - share)
}

/// Limit the threshold so that a clipped light exceeds it, unless most of the sphere is clipped.
pub fn below_white(threshold: f64, share_at_white: f64) -> f64 {
    let highest = f64::from(expand(HIGHEST_THRESHOLD));
    if share_at_white < MOSTLY_WHITE { threshold.min(highest) } else { threshold }
}

/// Compress an expanded luminance: the inverse of [`expand`], for the clip level `end`.
#[inline(always)]
pub fn compress(expanded: f32, end: f32) -> f32 {
    end * (1.0 + DISTANCE) * (expanded / (1.0 + expanded))
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn white_becomes_fifty_and_compression_undoes_expansion() {
        assert_relative_eq!(expand(1.0), 50.0, max_relative = 1e-4);
        assert_relative_eq!(expand(7.0), 50.0, max_relative = 1e-4);
        for share in [0.0_f32, 0.01, 0.3, 0.9, 0.99, 1.0] {
            let back = compress(expand(share), 3.0);
            assert_relative_eq!(back, 3.0 * share, max_relative = 1e-4, epsilon = 1e-9);
        }
    }

    #[test]
    fn the_threshold_stays_below_white_but_on_an_even_sphere() {
        assert!(below_white(100.0, 0.3) < f64::from(expand(1.0)));
        assert_relative_eq!(below_white(100.0, 0.8), 100.0);
        assert_relative_eq!(below_white(2.0, 0.3), 2.0);
    }
}
