//! Options of a fit, and the numbers that its search depends on.

use glam::DVec3;

use super::ambient::Ambient;
use super::comparison::Comparison;
use super::objective::PointObjective;

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

/// Numbers of the search. Larger ones find lower minima more often and take longer.
#[derive(Clone, Copy, Debug)]
pub struct SearchSettings {
    /// Sets of lights that forward selection carries from one number of lights to the next.
    pub beam: usize,
    /// Directions tried for a light that is added to a set.
    pub added: usize,
    /// Evenly spread starts per light, and the greatest number of starts.
    pub starts_per_light: usize,
    pub most_starts: usize,
    /// Distinct minima that are improved by exchanges of lights.
    pub minima: usize,
    /// Distinct minima from which lights with a size descend: with one, their error is 2 % larger on average.
    pub sized_minima: usize,
    /// Exchanges of one light that are tried together.
    pub exchanges: usize,
    /// Perturbations of all lights that are tried together around each of the best minima.
    pub perturbations: usize,
    /// Relative decrease of the cost in one step that ends a first, rough descent.
    pub rough: f64,
    /// Relative difference to the lowest cost up to which minima are descended to the last digit.
    pub near: f64,
    /// Relative difference of two costs below which their minima count as the same.
    pub same: f64,
}

impl SearchSettings {
    /// Points over all normals: two starts for each light, up to twelve, and exchanges among the three best minima.
    const SMOOTH: Self = Self {
        beam: 1,
        added: 1,
        starts_per_light: 2,
        most_starts: 12,
        minima: 3,
        sized_minima: 2,
        exchanges: 2,
        perturbations: 0,
        rough: 3e-2,
        near: 1e-3,
        same: 2e-3,
    };
    /// Harmonics beside the lights have more local minima: without the exchanges, 4 lights leave up to 16 % more error.
    const HARMONICS: Self = Self {
        beam: 12,
        added: 6,
        starts_per_light: 12,
        most_starts: 96,
        minima: 20,
        exchanges: 8,
        ..Self::SMOOTH
    };
    /// Known normals cut each minimum into many small ones: without perturbations, the error is up to 2 % larger.
    const KINKS: Self = Self {
        beam: 4,
        added: 4,
        starts_per_light: 8,
        most_starts: 96,
        minima: 16,
        exchanges: 8,
        perturbations: 24,
        near: 1e-2,
        ..Self::SMOOTH
    };

    /// Eight starts without exchanges: the search that the other settings have to beat.
    const PLAIN: Self = Self { starts_per_light: 8, most_starts: 8, minima: 1, exchanges: 0, ..Self::SMOOTH };

    /// Settings for an objective.
    pub fn of(objective: &dyn PointObjective, is_plain: bool) -> Self {
        match objective.reference().free() {
            _ if is_plain => Self::PLAIN,
            0 if objective.has_kinks() => Self::KINKS,
            0 => Self::SMOOTH,
            _ => Self::HARMONICS,
        }
    }

    /// Number of even starts for a number of lights.
    pub fn starts(&self, lights: usize) -> usize {
        (self.starts_per_light * lights).clamp(1, self.most_starts)
    }
}
