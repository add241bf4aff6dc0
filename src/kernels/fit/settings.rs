//! Tuned numbers of a search and of discs, each with the figure that changes without it.
//!
//! The numbers of a descent are in `damped_newton.rs`. All figures are changes of the error on real and generated maps.

use super::objective::PointObjective;

/// Numbers of the search. Larger counts find lower minima more often and take longer.
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
    /// Distinct minima from which lights with a size descend: with one, their error is 2 % larger on average. As many
    /// ends of even starts: without them, the error of 8 discs on 22 real maps is 3 % larger on average, at most 31 %.
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
    /// Relative decrease of the cost in one step that ends a final descent.
    pub fine: f64,
    /// Directions for a new light: 96 are about 20 degrees apart.
    pub directions: usize,
    /// Directions for one light of an exchange.
    pub directions_of_light: usize,
    /// Cosine of two directions above which descents from both reach the same minimum. Without it and `back`, the error
    /// of 4 and 8 discs is up to 9 % larger.
    pub apart: f64,
    /// Cosine of a light's old and new direction above which a descent leads back.
    pub back: f64,
    /// Cost of an exchange over the present cost, above which it is abandoned after a rough descent. This saves time.
    pub hopeless: f64,
    /// The longest perturbation, in radians: to the next small minimum, not to the next light.
    pub farthest: f64,
    /// Relative decrease of the error that is worth one more light.
    pub worth_a_light: f64,
    /// Lights in a row that may fail to lower the error.
    pub patience: usize,
}

/// Points over all normals: two starts for each light, up to twelve, and exchanges among the three best minima.
pub const SEARCH: SearchSettings = SearchSettings {
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
    fine: 1e-9,
    directions: 96,
    directions_of_light: 2,
    apart: 0.8,
    back: 0.9,
    hopeless: 1.2,
    farthest: 0.3,
    worth_a_light: 1e-3,
    patience: 3,
};

impl SearchSettings {
    /// Harmonics beside the lights have more local minima: without the exchanges, 4 lights leave up to 16 % more error.
    const HARMONICS: Self = Self {
        beam: 12,
        added: 6,
        starts_per_light: 12,
        most_starts: 96,
        minima: 20,
        exchanges: 8,
        ..SEARCH
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
        ..SEARCH
    };
    /// Eight starts without exchanges: the search that the other settings have to beat.
    const PLAIN: Self = Self { starts_per_light: 8, most_starts: 8, minima: 1, exchanges: 0, ..SEARCH };

    /// Settings for an objective.
    pub fn of(objective: &dyn PointObjective, is_plain: bool) -> Self {
        match objective.reference().free() {
            _ if is_plain => Self::PLAIN,
            0 if objective.has_kinks() => Self::KINKS,
            0 => SEARCH,
            _ => Self::HARMONICS,
        }
    }

    /// Number of even starts for a number of lights.
    pub fn starts(&self, lights: usize) -> usize {
        (self.starts_per_light * lights).clamp(1, self.most_starts)
    }
}

/// Numbers of lights with a size.
#[derive(Clone, Copy, Debug)]
pub struct DiscSettings {
    /// Relative decrease of the cost in one step that ends the descent of a start. With 3e-2, the error of one fit in 16 is
    /// 9 % larger.
    pub rough: f64,
    /// Relative decrease that ends the last descent: a mirrored map then has mirrored lights.
    pub fine: f64,
    /// Radius that a disc starts with, over that of the spread of the light around it. A sun in a bright sky counts more
    /// than the sky.
    pub start: f64,
    /// Radii of small discs that are tried beside harmonics, in radians: without them, the error is up to 12 % larger.
    pub small: [f64; 2],
    /// Initial radius of a new disc, between that of a sun and that of a window, in radians.
    pub new: f64,
    /// Directions for a new disc: 80 are some 22 degrees apart.
    pub directions: usize,
    /// Fewest lights of a forward selection: with 4, it lowers the error of none of nine real maps.
    pub fewest: usize,
    /// Weight of the probe in the mixed kernel. The shadow error is several times the probe's error, and errors count
    /// squared. With this weight, sizes increase the probe's error on hardly any of 21 real maps, and the shadow error is
    /// close to its minimum.
    pub probe: f64,
    /// Blur of small discs, in spreads of a pixel: without it, suns are up to a pixel too wide.
    pub blur: f64,
    /// The greatest radius without another bound, in radians: 75 degrees.
    pub greatest: f64,
    /// The least radius, in radians: 0.003 degrees. A smaller one changes no shadow visibly.
    pub least: f64,
    /// Error of the products, as a fraction of the energy: without it, costs below 0 end a descent at once.
    pub noise: f64,
}

/// Numbers for all maps.
pub const DISCS: DiscSettings = DiscSettings {
    rough: 1e-2,
    fine: 1e-9,
    start: 0.65,
    small: [0.05, 0.3],
    new: 0.2,
    directions: 80,
    fewest: 5,
    probe: 0.973,
    blur: 1.4,
    greatest: 75.0 / 180.0 * std::f64::consts::PI,
    least: 5e-5,
    noise: 1e-7,
};
