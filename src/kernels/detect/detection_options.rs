//! Options of detection. Their defaults are in the Python signature.

use super::segment::components::TreeRule;
use super::segment::light_moments::LightMoments;

/// Options of [`super::detect`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetectionOptions {
    /// Most columns of the working image; a clipped map is searched in half of them.
    pub working_columns: usize,
    /// Luminance above which a pixel is bright; chosen from the map if `None`.
    pub threshold: Option<f64>,
    /// Least ratio of a light's peak to the threshold.
    pub rise: f64,
    /// Least ratio of a light's peak to the highest saddle between it and a brighter light.
    pub prominence: f64,
    /// A light ends where its luminance has fallen to this fraction of its peak.
    pub extent: f64,
    /// Dark gaps up to this angle, in radians, do not divide a light.
    pub gap: f64,
    /// Lights with a smaller fraction of the map's flux are dropped.
    pub min_flux_fraction: f64,
    /// Least product of a light's fraction of the map's flux and its contrast; not used for clipped maps.
    pub min_worth: f64,
    /// Most lights; neighbours are merged until there are no more.
    pub max_lights: usize,
    /// Largest value that the map can hold, if it is known.
    pub white: Option<f64>,
}

impl DetectionOptions {
    /// The options that divide bright pixels into segments.
    pub fn tree_rule(&self) -> TreeRule {
        TreeRule { rise: self.rise, prominence: self.prominence, extent: self.extent }
    }

    /// True if a light before this `background` is listed, in a map of the flux `whole`.
    ///
    /// For the light's flux `F` and peak `P`, the map's flux `F_0` and the local background `B`, it is listed if
    ///
    /// ```text
    ///   F / F_0 * P / B >= min_worth
    /// ```
    pub fn is_worth_a_line(&self, light: &LightMoments, background: f64, whole: f64) -> bool {
        light.flux * light.peak >= self.min_worth * whole * background
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Options that list every light.
    const OPTIONS: DetectionOptions = DetectionOptions {
        working_columns: 1024,
        threshold: None,
        rise: 2.5,
        prominence: 4.0,
        extent: 0.1,
        gap: 0.014,
        min_flux_fraction: 0.0,
        min_worth: 0.0,
        max_lights: 1000,
        white: None,
    };

    #[test]
    fn a_light_is_listed_for_its_flux_or_for_its_contrast() {
        let is_listed = |flux: f64, peak: f32, background: f64| {
            let mut light = LightMoments::of_peak(peak);
            light.flux = flux;
            DetectionOptions { min_worth: 0.01, ..OPTIONS }.is_worth_a_line(&light, background, 100.0)
        };
        assert!(is_listed(0.5, 4.0, 2.0) && !is_listed(0.49, 4.0, 2.0)); // a large pale light
        assert!(is_listed(0.01, 200.0, 2.0) && !is_listed(0.01, 20.0, 2.0)); // a small lamp, a gap in leaves
        assert!(is_listed(1e-9, 1.0, 0.0)); // before black
    }
}
