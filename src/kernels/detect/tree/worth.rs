//! Which lights are worth a line.
//!
//! A light counts by what it gives and by how far it stands out. With its flux `F` of the map's `F_0`, its peak `P`
//! and the local background `B`, it is listed where
//!
//! ```text
//!   F / F_0 * P / B >= least
//! ```
//!
//! so with 0.0005 five millionths of the flux are enough for a lamp of a hundred times its background, but not for a
//! chink in the leaves that is three times as bright as they are. At 0.001 a known lamp of the generated maps is lost.

use super::moments::Light;

/// Whether a light before this `background` is listed, in a map of the flux `whole`.
pub fn is_worth_a_line(light: &Light, background: f64, whole: f64, least: f64) -> bool {
    light.flux * light.peak >= least * whole * background
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_listed(flux: f64, peak: f32, background: f64) -> bool {
        let mut light = Light::of_peak(peak);
        light.flux = flux;
        is_worth_a_line(&light, background, 100.0, 0.01)
    }

    #[test]
    fn a_light_is_listed_for_its_flux_or_for_its_contrast() {
        assert!(is_listed(0.5, 4.0, 2.0) && !is_listed(0.49, 4.0, 2.0)); // a pale place of half a hundredth
        assert!(is_listed(0.01, 200.0, 2.0) && !is_listed(0.01, 20.0, 2.0)); // a small lamp; a small chink
        assert!(is_listed(1e-9, 1.0, 0.0)); // before black
    }
}
