//! Ambient + M directional lights that make a white probe look as it does under the map.
//!
//! [`fit`] is the whole story:
//!
//! | step                                            | file                               |
//! |-------------------------------------------------|------------------------------------|
//! | what is asked, and ambient + lights             | `problem.rs`, `rig.rs`, `ambient.rs` |
//! | what is minimised: two moments of lights        | `objective.rs`                     |
//! | - at every normal, in closed form               | `sphere/`                          |
//! | - at given normals                              | `samples/`                         |
//! | best radiances, none negative                   | `radiances.rs`, `nnls.rs`          |
//! | best directions near given ones                 | `state.rs`, `newton.rs`, `descent.rs` |
//! | - gradient and hessian in wide vectors          | `curvature.rs`, `dense.rs`         |
//! | what a light in a new place would explain       | `candidates.rs`, `moves.rs`        |
//! | best set of a number of lights                  | `search.rs`, `multistart.rs`       |
//! | which number                                    | `light_count.rs`                   |
//! | lights with a size, right in shadows            | `discs/`                           |
//! | the error of one probe beside another           | `relative_rms.rs`                  |
//! | how well the probe determines them              | `uncertainty.rs`                   |

mod ambient;
mod candidates;
mod curvature;
mod dense;
mod descent;
mod discs;
mod light_count;
mod moves;
mod multistart;
mod newton;
mod nnls;
mod objective;
mod options;
mod problem;
mod radiances;
mod relative_rms;
mod rig;
mod samples;
mod search;
mod sphere;
mod state;
mod uncertainty;

pub use ambient::Ambient;
pub use discs::Comparison;
pub use objective::Objective;
pub use options::FitOptions;
pub use problem::Problem;
pub use relative_rms::relative_rms;
pub use rig::Rig;
pub use samples::{Judged, Probe, Samples};
pub use sphere::Sphere;
pub use state::StopReason;
pub use uncertainty::Uncertainty;

use self::discs::{Sized, Sizes};
use self::light_count::{Goal, Tried};
use self::relative_rms::relative_error;
use self::sphere::evaluation_probe;
use self::state::State;
use super::expansion::Expansion;
use super::image::WorkingMap;
use super::lanes;
use crate::error::{Error, Result};

/// The best rig, and how it was found.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Ambient and lights, those that were fixed first.
    pub rig: Rig,
    /// Angular radius of each light, in radians: 0 for a point.
    pub radii: Vec<f64>,
    /// How far it is from the probe.
    pub judged: Judged,
    /// Relative RMS error of the irradiance where things stand in the way, under a map: `discs/`.
    pub shadow_error: f64,
    /// Normals that this was measured at.
    pub judging: usize,
    /// Relative RMS error by number of lights: of points, unless an error was asked for.
    pub errors: Vec<(usize, f64)>,
    /// Channels that were fitted: neither black nor the same as another.
    pub channels: usize,
    /// Steps of the solver on the way there.
    pub steps: usize,
    /// Why it took no more.
    pub stop: StopReason,
    /// How far each light may stand elsewhere before the error grows by a tenth, in radians: under a map.
    pub tolerances: Vec<f64>,
    /// Standard errors and condition number: for measured values.
    pub uncertainty: Uncertainty,
}

/// Normals that judge a rig under a map, at least.
const JUDGING: usize = 5120;

/// The best rig for the probe under a map. Errors below `error_floor` are those of rendering.
///
/// # Errors
///
/// [`Error::TooFewNormals`], [`Error::TooBright`].
pub fn under_map(map: &WorkingMap, has_floor: bool, asked: &FitOptions, error_floor: f64) -> Result<Fitted> {
    let expansion = Expansion::new(map);
    let comparison = asked.sizes.unwrap_or(Comparison::Shadows);
    let sizes = || Sizes::new(map, &expansion, asked.ambient, has_floor, comparison);
    check_unknowns(asked, JUDGING)?;
    let figures = || rayon::join(sizes, || evaluation_probe(map, &expansion, JUDGING));
    let sphere = || Sphere::of(map, &expansion, asked.ambient, has_floor);
    if asked.has_goal() {
        let (sphere, (sizes, judge)) = rayon::join(sphere, figures);
        let figures = Figures { judge: &judge?, sizes: Some(sizes), asked };
        return fit(&asked.problem(&sphere), &figures, error_floor);
    }
    // The closed form knows the errors of points: the search need not wait for the figures.
    let search = || {
        let sphere = sphere();
        searched(&asked.problem(&sphere), &asked.goal(), error_floor).map(|path| (sphere, path))
    };
    let (found, (sizes, judge)) = rayon::join(search, figures);
    let figures = Figures { judge: &judge?, sizes: Some(sizes), asked };
    let (sphere, path) = found?;
    let problem = asked.problem(&sphere);
    let path = path.into_iter().map(|tried| figures.on_the_way(&problem, tried.state)).collect();
    Ok(best(&problem, &figures, path, error_floor))
}

/// The best place with each number of lights, by the errors that the objective knows.
fn searched(problem: &Problem<'_>, goal: &Goal, error_floor: f64) -> Result<Vec<Tried>> {
    let energy = problem.objective.given().energy;
    if !energy.is_finite() {
        return Err(Error::TooBright);
    }
    let judge = |state: &State| {
        let error = relative_error(state.cost, energy);
        Tried { state: state.clone(), error, shadow_error: 0.0 }
    };
    light_count::path(problem, goal, &judge, error_floor)
}

/// `<E, E>` of the probe under a map, over all normals and channels, in closed form.
pub fn energy(map: &WorkingMap) -> f64 {
    Sphere::new(map, Ambient::Constant, false).given().energy
}

/// The best rig for irradiance at given normals, which judge it as well.
///
/// # Errors
///
/// [`Error::TooFewNormals`] when there are fewer equations than unknowns.
pub fn to_samples(samples: Samples, asked: &FitOptions) -> Result<Fitted> {
    check_unknowns(asked, samples.normals.len())?;
    let probe = Probe::new(samples, asked.ambient);
    let figures = Figures { judge: &probe.samples, sizes: None, asked };
    let mut fitted = fit(&asked.problem(&probe), &figures, 0.0)?;
    fitted.uncertainty = uncertainty::uncertainty(&probe, &fitted.rig, asked.fixed);
    Ok(fitted)
}

/// What judges a place of the search.
struct Figures<'a> {
    judge: &'a Samples,
    /// What knows of shadows, under a map.
    sizes: Option<Sizes<'a>>,
    asked: &'a FitOptions,
}

impl Figures<'_> {
    /// On the way to a number of lights: in full where an error was asked for, else as points.
    fn on_the_way(&self, problem: &Problem<'_>, state: State) -> Tried {
        if self.asked.has_goal() {
            return self.full(problem, state).0;
        }
        let error = self.judge.error(&state.rig(problem.objective.given()));
        Tried { state, error, shadow_error: 0.0 }
    }

    /// The rig, with sizes where these were asked for, and its errors.
    fn full(&self, problem: &Problem<'_>, state: State) -> (Tried, Sized, Judged) {
        let given = problem.objective.given();
        let rig = state.rig(given);
        let found = match (&self.sizes, self.asked.sizes) {
            (Some(sizes), Some(_)) => sizes.fitted(given, &rig, problem.fixed, problem.max_steps),
            _ => Sized::points(rig),
        };
        let judged = match self.asked.sizes {
            Some(_) => discs::judged(self.judge, &found.rig, &found.radii),
            None => self.judge.judged(&found.rig),
        };
        let shadow_error =
            self.sizes.as_ref().map_or(0.0, |sizes| sizes.shadow_error(given, &found.rig, &found.radii));
        (Tried { state, error: judged.error, shadow_error }, found, judged)
    }
}

/// The best rig for a problem.
fn fit(problem: &Problem<'_>, figures: &Figures<'_>, error_floor: f64) -> Result<Fitted> {
    let judge = |state: &State| figures.on_the_way(problem, state.clone());
    let path = light_count::path(problem, &figures.asked.goal(), &judge, error_floor)?;
    Ok(best(problem, figures, path, error_floor))
}

/// The best place of those tried, and what the caller sees of it.
fn best(problem: &Problem<'_>, figures: &Figures<'_>, path: Vec<Tried>, error_floor: f64) -> Fitted {
    let chosen = light_count::chosen(problem, &figures.asked.goal(), &path, error_floor);
    let state = path[chosen].state.clone().polished(problem);
    let state = state.without_black(problem).unwrap_or(state);
    let (tried, found, judged) = figures.full(problem, state);
    let mut errors: Vec<(usize, f64)> =
        path.iter().map(|tried| (tried.state.lights(), tried.error)).collect();
    // Beside points stands the error of points.
    let are_points = figures.asked.sizes.is_none() || found.radii.is_empty();
    if figures.asked.has_goal() || are_points {
        errors[chosen].1 = judged.error;
    }
    let state = tried.state;
    // Measured values have standard errors instead.
    let is_map = figures.sizes.is_some();
    let of_points = || is_map.then(|| uncertainty::tolerances(problem, &state, judged.error));
    let tolerances = found.tolerances.or_else(of_points).unwrap_or_default();
    Fitted {
        rig: found.rig,
        radii: found.radii,
        judged,
        shadow_error: tried.shadow_error,
        judging: figures.judge.normals.len(),
        errors,
        channels: problem.objective.given().channels.len(),
        steps: state.steps + found.steps,
        stop: found.stop.or(state.stop).unwrap_or(StopReason::Converged),
        tolerances,
        uncertainty: Uncertainty::default(),
    }
}

impl FitOptions {
    fn goal(&self) -> Goal {
        Goal { error: self.error, shadow_error: self.shadow_error }
    }

    fn problem<'a>(&'a self, objective: &'a dyn Objective) -> Problem<'a> {
        let Self { start, fixed, lights, error, max_steps, .. } = self;
        Problem { objective, start, fixed: *fixed, lights: *lights, error: *error, max_steps: *max_steps }
    }
}

/// Three equations at each normal; in each channel the coefficients of the ambient term and a radiance for
/// each light, and its two angles.
fn check_unknowns(asked: &FitOptions, seen: usize) -> Result<()> {
    let lights = asked.lights;
    let wanted = (3 * asked.ambient.coefficients() + 5 * lights).div_ceil(3).max(1);
    if seen < wanted {
        return Err(Error::TooFewNormals { seen, wanted, lights });
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::rig::irradiance;
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::direction;
    use glam::DVec3;
    use ndarray::s;

    fn asked(lights: usize, ambient: Ambient) -> FitOptions {
        FitOptions {
            ambient,
            start: Vec::new(),
            fixed: 0,
            lights,
            error: None,
            shadow_error: None,
            sizes: None,
            max_steps: 100,
        }
    }

    fn found(rig: &Rig, lights: usize) -> Fitted {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let seen = irradiance(rig, normals.view()).unwrap();
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        to_samples(samples, &asked(lights, Ambient::Constant)).unwrap()
    }

    #[test]
    fn three_lights_and_ambient_come_back() {
        let rig = Rig {
            ambient: vec![DVec3::new(0.2, 0.1, 0.3)],
            directions: vec![direction(0.4, 1.0), direction(1.3, 3.5), direction(2.5, 5.0)],
            irradiance: vec![DVec3::new(3.0, 2.5, 2.0), DVec3::new(0.5, 1.0, 1.5), DVec3::splat(0.7)],
            has_floor: false,
        };
        let found = found(&rig, 3).rig;
        for (wanted, irradiance) in rig.directions.iter().zip(&rig.irradiance) {
            let nearest = found.directions.iter().zip(&found.irradiance);
            let (l, e) =
                nearest.min_by(|a, b| (a.0 - wanted).length().total_cmp(&(b.0 - wanted).length())).unwrap();
            assert!((l - wanted).length() < 1e-9, "{l} {wanted}");
            assert!((e - irradiance).length() < 1e-8, "{e} {irradiance}");
        }
        assert!((found.ambient[0] - rig.ambient[0]).length() < 1e-9);
    }

    #[test]
    fn there_must_be_as_many_equations_as_unknowns() {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let enough = |ambient, count: usize, lights| {
            let normals = normals.slice(s![..count, ..]);
            let samples = Samples::new(normals, weights.slice(s![..count]), normals).unwrap();
            check_unknowns(&asked(lights, ambient), samples.normals.len()).is_ok()
        };
        for (ambient, unknowns) in [(Ambient::None, 0), (Ambient::Constant, 3), (Ambient::Sh2, 27)] {
            for lights in 0..4 {
                let least = (1..20).find(|&count| enough(ambient, count, lights)).unwrap();
                assert!(3 * least >= unknowns + 5 * lights && least >= 1);
                assert!(least == 1 || 3 * (least - 1) < unknowns + 5 * lights);
            }
        }
    }

    #[test]
    fn black_needs_no_light() {
        let found = found(&Rig::default(), 4);
        assert_eq!(found.errors.len(), 1);
        assert_eq!(found.rig.ambient, [DVec3::ZERO]);
        assert!(found.rig.directions.is_empty());
    }
}
