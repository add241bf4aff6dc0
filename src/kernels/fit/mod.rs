//! Ambient + M directional lights that make a white probe look as it does under the map.
//!
//! [`fit`] is the whole story; each line of it is a room of its own:
//!
//! | step                                          | file                       |
//! |-----------------------------------------------|----------------------------|
//! | what is to be reproduced, and how near it is  | `samples.rs`, `probe.rs`   |
//! | a rig on the probe, its ambient term          | `model.rs`, `ambient.rs`   |
//! | what runs over all normals                    | `blocks.rs`, `sums.rs`     |
//! | inner products of the model and derivatives   | `moments.rs`               |
//! | best radiances, none negative                 | `radiances.rs`, `nnls.rs`  |
//! | best directions near given ones               | `solver.rs`, `quadratic.rs`|
//! | more and more lights, while they help         | `way.rs`                   |
//! | best set of so many lights                    | `search.rs`, `moves.rs`,   |
//! |                                               | `spread.rs`                |
//! | what one more light would explain             | `candidates.rs`            |
//! | how well the probe determines them            | `uncertainty.rs`           |

mod ambient;
mod blocks;
mod candidates;
mod model;
mod moments;
mod moves;
mod nnls;
mod probe;
mod quadratic;
mod radiances;
mod samples;
mod search;
mod solver;
mod spread;
mod sums;
mod uncertainty;
mod way;

pub use ambient::Ambient;
pub use probe::Probe;
pub use samples::Samples;
pub use uncertainty::{Uncertainty, uncertainty};

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2, Zip};
use rayon::prelude::*;

use self::solver::State;
use super::sphere::{check_rows, check_values, unit_vectors, vectors};
use crate::error::{Error, Result};

/// Ambient and directional lights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig {
    /// Coefficients of the environment's radiance, RGB: as many as [`Ambient`] has.
    pub ambient: Vec<DVec3>,
    /// Towards each light.
    pub directions: Vec<DVec3>,
    /// Irradiance of each light at normal incidence, RGB.
    pub irradiance: Vec<DVec3>,
}

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

/// The best rig found with one number of lights.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Lights that were allowed; the rig has fewer where some are black.
    pub lights: usize,
    /// The lights.
    pub rig: Rig,
    /// Relative RMS error on the values that judge.
    pub error: f64,
    /// Steps of the solver on the way there.
    pub steps: usize,
    /// Why it took no more.
    pub stop: StopReason,
}

/// Who judges, and what is good enough.
#[derive(Clone, Debug)]
pub struct Goal {
    /// Values that are not fitted, or the fitted ones again.
    pub judge: Samples,
    /// Relative RMS error at which no more lights are added.
    pub error: Option<f64>,
}

/// What is asked of [`fit`].
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// Where the first lights start, brightest first. Those beyond start where they explain most.
    pub start: &'a [DVec3],
    /// How many of these keep their directions, and get only their radiances.
    pub held: usize,
    /// Lights at most.
    pub lights: usize,
    /// Steps after which the solver gives up on a start.
    pub max_steps: usize,
    /// Who judges, and what is good enough.
    pub goal: &'a Goal,
}

/// The best rig with as many lights as `request` allows, after those with fewer on the way there.
///
/// Fewer lights come where these explain the probe or reach the goal, or where more lower no error.
/// Without a goal, those on the way are only as good as the way needs, and the given starts are taken in
/// one step.
///
/// # Errors
///
/// [`Error::TooFewNormals`] when there are fewer equations than unknowns.
pub fn fit(probe: &Probe, request: &Request<'_>) -> Result<Vec<Solution>> {
    check_unknowns(probe, request.lights)?;
    // In the thread pool as a whole: from outside, each of the parallel loops would wake it anew.
    rayon::scope(|_| {
        let states = way::states(probe, request)?;
        Ok(states.par_iter().map(|state| solution(probe, request, state)).collect())
    })
}

fn solution(probe: &Probe, request: &Request<'_>, state: &State) -> Solution {
    let rig = state.rig(probe).lit(request.held);
    Solution {
        lights: state.lights(),
        error: request.goal.judge.error(&rig),
        rig,
        steps: state.steps,
        stop: state.stop.unwrap_or(StopReason::Converged),
    }
}

impl Rig {
    /// An `ambient` term of (0, 1 or 9, 3), and lights of (m, 3) `directions` and (m, 3) `irradiance`.
    ///
    /// # Errors
    ///
    /// [`Error::NotAmbient`], [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`],
    /// [`Error::LengthMismatch`].
    pub fn new(
        ambient: ArrayView2<'_, f64>,
        directions: ArrayView2<'_, f64>,
        irradiance: ArrayView2<'_, f64>,
    ) -> Result<Self> {
        let seen = ambient.nrows();
        Ambient::with(seen).ok_or(Error::NotAmbient { seen })?;
        let (ambient, irradiance) = (vectors("ambient", ambient)?, vectors("irradiance", irradiance)?);
        let directions = unit_vectors("direction", directions)?;
        if irradiance.len() != directions.len() {
            let (wanted, seen) = (directions.len(), irradiance.len());
            return Err(Error::LengthMismatch { what: "irradiance", other: "directions", wanted, seen });
        }
        Ok(Self { ambient, directions, irradiance })
    }

    /// Without the lights that no channel uses, but for the first `held`.
    fn lit(self, held: usize) -> Self {
        let lights = self.directions.into_iter().zip(self.irradiance).enumerate();
        let lit = lights.filter(|(light, (_, e))| *light < held || e.max_element() > 0.0);
        let (directions, irradiance) = lit.map(|(_, light)| light).unzip();
        Self { ambient: self.ambient, directions, irradiance }
    }
}

/// Three equations at each normal; in each channel the coefficients of the ambient term and a radiance for
/// each light, and its two angles.
fn check_unknowns(probe: &Probe, lights: usize) -> Result<()> {
    let wanted = (3 * probe.ambient.coefficients() + 5 * lights).div_ceil(3).max(1);
    let seen = probe.samples.normals.len();
    if seen < wanted {
        return Err(Error::TooFewNormals { seen, wanted, lights });
    }
    Ok(())
}

/// Weighted relative RMS difference of two probes, (n, 3) each.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::LengthMismatch`]; [`Error::NotFinite`] for any number, and
/// [`Error::Negative`] for a weight.
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

/// Irradiance of `rig` at `normals`, (n, 3).
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`].
pub fn irradiance(rig: &Rig, normals: ArrayView2<'_, f64>) -> Result<Array2<f64>> {
    let normals = unit_vectors("normal", normals)?;
    Ok(super::sphere::from_vectors(normals.iter().map(|&normal| model::irradiance(rig, normal))))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::sampling;
    use crate::kernels::sphere::direction;
    use ndarray::s;

    fn found(rig: &Rig, lights: usize) -> Vec<Solution> {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let seen = irradiance(rig, normals.view()).unwrap();
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        let probe = Probe::new(samples.clone(), Ambient::Constant);
        let goal = Goal { judge: samples, error: None };
        fit(&probe, &Request { start: &[], held: 0, lights, max_steps: 100, goal: &goal }).unwrap()
    }

    #[test]
    fn three_lights_and_ambient_come_back() {
        let rig = Rig {
            ambient: vec![DVec3::new(0.2, 0.1, 0.3)],
            directions: vec![direction(0.4, 1.0), direction(1.3, 3.5), direction(2.5, 5.0)],
            irradiance: vec![DVec3::new(3.0, 2.5, 2.0), DVec3::new(0.5, 1.0, 1.5), DVec3::splat(0.7)],
        };
        let solutions = found(&rig, 3);
        let found = &solutions[3].rig;
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
            check_unknowns(&Probe::new(samples, ambient), lights).is_ok()
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
        let solutions = found(&Rig::default(), 4);
        assert_eq!(solutions.len(), 1);
        assert_eq!(solutions[0].rig.ambient, [DVec3::ZERO]);
    }
}
