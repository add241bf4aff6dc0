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
//! | what a light in a new place would explain       | `candidates.rs`, `moves.rs`        |
//! | best set of a number of lights                  | `search.rs`, `multistart.rs`       |
//! | which number                                    | `light_count.rs`                   |
//! | how well the probe determines them              | `uncertainty.rs`                   |

mod ambient;
mod candidates;
mod descent;
mod light_count;
mod moves;
mod multistart;
mod newton;
mod nnls;
mod objective;
mod problem;
mod radiances;
mod rig;
mod samples;
mod search;
mod sphere;
mod state;
mod uncertainty;

pub use ambient::Ambient;
pub use objective::Objective;
pub use problem::Problem;
pub use rig::{Rig, irradiance};
pub use samples::{Judged, Probe, Samples};
pub use sphere::Sphere;
pub use uncertainty::Uncertainty;

use glam::DVec3;
use ndarray::{ArrayView1, ArrayView2, Zip};

use self::state::State;
use super::image::WorkingMap;
use super::probe;
use super::sphere::{check_rows, check_values};
use crate::error::{Error, Result};

/// Why the solver stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The error stopped falling.
    Converged,
    /// Nothing is left to explain.
    Exact,
    /// The step limit came first.
    OutOfSteps,
}

/// What a caller asks for.
#[derive(Clone, Debug)]
pub struct Asked {
    /// What the rig may have beside the lights.
    pub ambient: Ambient,
    /// Where the first lights start, brightest first.
    pub start: Vec<DVec3>,
    /// How many of these keep their directions.
    pub fixed: usize,
    /// Lights at most.
    pub lights: usize,
    /// Relative RMS error that is good enough.
    pub error: Option<f64>,
    /// Steps after which a descent gives up.
    pub max_steps: usize,
}

/// The best rig, and how it was found.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Ambient and lights, those that were fixed first.
    pub rig: Rig,
    /// How far it is from the probe.
    pub judged: Judged,
    /// Relative RMS error by number of lights.
    pub errors: Vec<(usize, f64)>,
    /// Steps of the solver on the way there.
    pub steps: usize,
    /// Why it took no more.
    pub stop: StopReason,
    /// How far each light may stand elsewhere before the error grows by a tenth, in radians: under a map.
    pub tolerances: Vec<f64>,
    /// Standard errors and condition number: for measured values.
    pub uncertainty: Uncertainty,
}

/// Normals, (n, 3), and their weights.
pub type Normals<'a> = (ArrayView2<'a, f64>, ArrayView1<'a, f64>);

/// The best rig for the probe under a map at every normal, judged at some. Where it has a `floor`, light from below
/// the horizon neither counts nor is used. Errors below `error_floor` are those of rendering.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::LengthMismatch`], [`Error::NotFinite`], [`Error::NotUnit`],
/// [`Error::Negative`], [`Error::TooBright`].
pub fn under_map(
    map: &WorkingMap,
    judging: Normals<'_>,
    asked: &Asked,
    floor: bool,
    error_floor: f64,
) -> Result<Fitted> {
    let (judge, sphere) =
        rayon::join(|| rendered(map, judging), || Sphere::new(map, asked.ambient, floor));
    let problem = asked.problem(&sphere);
    let (state, mut fitted) = fit(&problem, &judge?, error_floor)?;
    fitted.tolerances = uncertainty::tolerances(&problem, &state, fitted.judged.error);
    Ok(fitted)
}

/// The best rig for the probe under a map at `fitted` normals, judged at others.
///
/// # Errors
///
/// As [`under_map`], and [`Error::TooFewNormals`].
pub fn at_normals(
    map: &WorkingMap,
    fitted: Normals<'_>,
    judging: Normals<'_>,
    asked: &Asked,
    error_floor: f64,
) -> Result<Fitted> {
    let (samples, judge) = (rendered(map, fitted)?, rendered(map, judging)?);
    check_unknowns(asked, samples.normals.len())?;
    let probe = Probe::new(samples, asked.ambient);
    let problem = asked.problem(&probe);
    let (state, mut fitted) = fit(&problem, &judge, error_floor)?;
    fitted.tolerances = uncertainty::tolerances(&problem, &state, fitted.judged.error);
    Ok(fitted)
}

fn rendered(map: &WorkingMap, (normals, weights): Normals<'_>) -> Result<Samples> {
    Samples::new(normals, weights, probe::working_irradiance(map, normals)?.view())
}

/// The best rig for irradiance at given normals, which judge it as well.
///
/// # Errors
///
/// [`Error::TooFewNormals`] when there are fewer equations than unknowns.
pub fn to_samples(samples: Samples, asked: &Asked) -> Result<Fitted> {
    check_unknowns(asked, samples.normals.len())?;
    let probe = Probe::new(samples, asked.ambient);
    let (_, mut fitted) = fit(&asked.problem(&probe), &probe.samples, 0.0)?;
    fitted.uncertainty = uncertainty::uncertainty(&probe, &fitted.rig, asked.fixed);
    Ok(fitted)
}

/// The best place, and what the caller sees of it.
fn fit(problem: &Problem<'_>, judge: &Samples, error_floor: f64) -> Result<(State, Fitted)> {
    let path = light_count::path(problem, judge, error_floor)?;
    let state = path[light_count::chosen(problem, &path, error_floor)].0.clone().polished(problem);
    let state = state.without_black(problem).unwrap_or(state);
    let rig = state.rig(problem.objective.given());
    let fitted = Fitted {
        judged: judge.judged(&rig),
        rig,
        errors: path.iter().map(|(state, error)| (state.lights(), *error)).collect(),
        steps: state.steps,
        stop: state.stop.unwrap_or(StopReason::Converged),
        tolerances: Vec::new(),
        uncertainty: Uncertainty::default(),
    };
    Ok((state, fitted))
}

impl Asked {
    fn problem<'a>(&'a self, objective: &'a dyn Objective) -> Problem<'a> {
        let Self { start, fixed, lights, error, max_steps, .. } = self;
        Problem { objective, start, fixed: *fixed, lights: *lights, error: *error, max_steps: *max_steps }
    }
}

/// Three equations at each normal; in each channel the coefficients of the ambient term and a radiance for
/// each light, and its two angles.
fn check_unknowns(asked: &Asked, seen: usize) -> Result<()> {
    let lights = asked.lights;
    let wanted = (3 * asked.ambient.coefficients() + 5 * lights).div_ceil(3).max(1);
    if seen < wanted {
        return Err(Error::TooFewNormals { seen, wanted, lights });
    }
    Ok(())
}

/// Weighted relative RMS difference of two probes, (n, 3) each.
///
/// # Errors
///
/// [`crate::error::Error::WrongColumns`], [`crate::error::Error::LengthMismatch`];
/// [`crate::error::Error::NotFinite`] for any number, and [`crate::error::Error::Negative`] for a weight.
pub fn relative_rms(
    seen: ArrayView2<'_, f64>,
    wanted: ArrayView2<'_, f64>,
    weights: ArrayView1<'_, f64>,
) -> Result<f64> {
    check_rows("wanted", wanted, 3)?;
    check_values("wanted", wanted.nrows(), ("seen", seen), weights)?;
    let (mut difference, mut reference) = (0.0, 0.0);
    Zip::from(seen.rows()).and(wanted.rows()).and(weights).for_each(|seen, wanted, &weight| {
        for (a, b) in seen.iter().zip(wanted) {
            difference += weight * (a - b) * (a - b);
            reference += weight * b * b;
        }
    });
    Ok(if reference > 0.0 { (difference / reference).sqrt() } else { difference.sqrt() })
}

#[cfg(test)]
#[allow(clippy::all, clippy::pedantic, missing_docs)]
mod timing {
    use super::*;
    use crate::kernels::{image, sphere::Registration};
    use ndarray::Array3;
    use std::time::Instant;
    fn best<T>(name: &str, mut f: impl FnMut() -> T) {
        let mut least = f64::INFINITY;
        for _ in 0..std::env::var("ROUNDS").map_or(30, |v| v.parse().unwrap()) { let t = Instant::now(); std::hint::black_box(f()); least = least.min(t.elapsed().as_secs_f64()); }
        print!("{name} {:.3}  ", 1e3 * least);
    }
    #[test]
    fn timing() {
        for name in ["hall", "venice", "warehouse", "kloppenheim"] {
            let bytes = std::fs::read(format!("/tmp/w/q/{name}.raw")).unwrap();
            let values: Vec<f32> = bytes.chunks(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
            let map = Array3::from_shape_vec((512, 1024, 3), values).unwrap();
            let w = image::reduce(map.view(), Registration::CellCentred, 256, 2e-3).unwrap();
            print!("{name} sources {} ", w.sources.dim().0);
            best("reduce", || image::reduce(map.view(), Registration::CellCentred, 256, 2e-3).unwrap());
            best("sphere", || Sphere::new(&w, Ambient::Constant, false));
            let sphere = Sphere::new(&w, Ambient::Constant, false);
            if let Ok(mode) = std::env::var("MODE") {
                if name != "venice" { continue; }
                let problem = Problem { objective: &sphere, start: &[], fixed: 0, lights: 8, error: None, max_steps: 100 };
                let path = light_count::path(&problem, &Samples::of(vec![DVec3::Y], vec![1.0], vec![DVec3::Y]), 0.0).unwrap();
                let state = path.last().unwrap().0.clone();
                let c = candidates::Candidates::new(&sphere);
                match mode.as_str() {
                    "sphere" => for _ in 0..3000 { std::hint::black_box(Sphere::new(&w, Ambient::Constant, false)); },
                    "search" => for _ in 0..500 {
                        let search = search::Search::new(&problem);
                        let mut beam = vec![State::new(&sphere, &[])];
                        for _ in 0..8 { beam = search.grown(&beam); }
                        std::hint::black_box(search.best(beam).unwrap());
                    },
                    "newton" => for _ in 0..300000 { std::hint::black_box(newton::Quadratic::around(&problem, &state, true)); },
                    "state" => for _ in 0..600000 { std::hint::black_box(State::new(&sphere, &state.moments.directions)); },
                    _ => for _ in 0..100000 { std::hint::black_box(c.beside(&state).unwrap().moved(3)); },
                }
                continue;
            }
            best("candidates", || candidates::Candidates::new(&sphere));
            for lights in [4, 8] {
                let problem = Problem { objective: &sphere, start: &[], fixed: 0, lights, error: None, max_steps: 100 };
                state::PLACES.store(0, std::sync::atomic::Ordering::Relaxed);
                let search = || {
                    let search = search::Search::new(&problem);
                    let mut beam = vec![State::new(&sphere, &[])];
                    for _ in 0..lights { beam = search.grown(&beam); }
                    let grown = state::PLACES.load(std::sync::atomic::Ordering::Relaxed);
                    (grown, search.best(beam).unwrap())
                };
                let (grown, _) = search();
                let places = state::PLACES.load(std::sync::atomic::Ordering::Relaxed);
                best(&format!("{lights} lights: places {grown} + {}", places - grown), search);
                let state = search().1.unwrap();
                let (a, b) = (state.moments.directions.clone(), sphere.moments(state.moments.directions.clone()));
                best("moments", || sphere.moments(a.clone()));
                best("state", || State::new(&sphere, &a));
                best("gauss", || newton::Quadratic::around(&problem, &state, false));
                best("newton", || newton::Quadratic::around(&problem, &state, true));
                let model = newton::Quadratic::around(&problem, &state, true);
                best("step", || model.step(1e-3, &[]));
                let c = candidates::Candidates::new(&sphere);
                best("beside", || c.beside(&state).unwrap().added());
                let _ = b;
            }
            println!();
        }
    }
}
