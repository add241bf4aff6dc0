//! Options of a fit.

use glam::DVec3;

use super::ambient::Ambient;
use super::comparison::Comparison;

/// Options of one fit.
#[derive(Clone, Debug)]
pub struct FitOptions {
    /// Ambient term beside the lights.
    pub ambient: Ambient,
    /// Initial directions of the first lights, brightest first.
    pub start: Vec<DVec3>,
    /// Number of these that keep their directions.
    pub fixed: usize,
    /// Greatest number of lights.
    pub lights: usize,
    /// Relative RMS error that ends the search.
    pub error: Option<f64>,
    /// Relative RMS error with shadows that ends the search.
    pub shadow_error: Option<f64>,
    /// Relative RMS error of a shiny object that ends the search.
    pub gloss_error: Option<f64>,
    /// Factors of the kernel of that object, by degree.
    pub gloss_factors: Vec<f64>,
    /// Comparison that gives the lights their sizes; points if absent.
    pub sizes: Option<Comparison>,
    /// Greatest angular radius of a light, in radians.
    pub max_radius: Option<f64>,
    /// Greatest number of steps of one descent.
    pub max_steps: usize,
    /// True if a floor hides the light from below the horizon.
    pub has_floor: bool,
    /// Error of the rendering, below which no light is added.
    pub error_floor: f64,
    /// True for forward selection and eight plain starts, with which benchmarks compare the search.
    pub is_plain: bool,
}

#[cfg(test)]
impl Default for FitOptions {
    /// Any points beside a constant ambient term.
    fn default() -> Self {
        Self {
            ambient: Ambient::Constant,
            start: Vec::new(),
            fixed: 0,
            lights: 0,
            error: None,
            shadow_error: None,
            gloss_error: None,
            gloss_factors: Vec::new(),
            sizes: None,
            max_radius: None,
            max_steps: 100,
            has_floor: false,
            error_floor: 0.0,
            is_plain: false,
        }
    }
}

impl FitOptions {
    /// True if the caller named an error that is good enough.
    pub fn has_goal(&self) -> bool {
        self.error.is_some() || self.shadow_error.is_some() || self.gloss_error.is_some()
    }
}
