//! The best directions near given ones: variable projection with damped Gauss-Newton steps.
//!
//! For fixed directions the best radiances `x` are a small linear problem (`nnls.rs`), so only the
//! 2M tangent coordinates `t` of the directions are left (Golub and Pereyra 1973). With Kaufman's
//! approximation of the Jacobian, and `P_c` the projection on the columns that channel c uses,
//!
//! ```text
//!   J_c = -(1 - P_c) D_c        D_c[:, jk] = x_jc da_j/dt_k
//!   J^T J [jk, j'k'] = sum_c x_jc x_j'c ( da_jk.da_j'k' - (A_c^T da_jk)^T G_c^-1 (A_c^T da_j'k') )
//!   J^T r [jk]       = -sum_c x_jc da_jk.r_c
//! ```
//!
//! all of them inner products that [`Moments`] already holds. The tangent plane has no pole, where
//! the paper's angles theta and phi lose a rank.

use glam::DVec3;
use nalgebra::{DMatrix, DVector};

use super::model::{self, Moments, column};
use super::{Probe, Rig, Solution, StopReason, nnls};
use crate::kernels::sphere::exponential_map;

/// A light never turns by more than this in one step, in radians: the model is linear only nearby.
const LONGEST_STEP: f64 = 0.5;
/// Relative cost of rounding alone.
const EXACT: f64 = 1e-26;

/// One place of the search: directions, their best radiances, and what that costs.
struct State {
    moments: Moments,
    rig: Rig,
    cost: f64,
}

impl State {
    fn new(probe: &Probe, directions: Vec<DVec3>) -> Self {
        let moments = Moments::new(probe, &directions);
        let rig = best_radiances(probe, &moments, directions);
        let cost = model::cost(probe, &rig);
        Self { moments, rig, cost }
    }

    fn solution(self, probe: &Probe, steps: usize, stop: StopReason) -> Solution {
        let residual = if probe.energy > 0.0 { (self.cost / probe.energy).sqrt() } else { 0.0 };
        Solution { rig: lit(self.rig), residual, steps, stop }
    }
}

/// The best ambient term alone, if the model has one.
pub fn ambient_only(probe: &Probe) -> Solution {
    let state = State::new(probe, Vec::new());
    let stop = if state.cost <= EXACT * probe.energy { StopReason::Exact } else { StopReason::Converged };
    state.solution(probe, 0, stop)
}

/// The best radiances of lights in fixed directions.
pub fn radiances(probe: &Probe, directions: &[DVec3]) -> Rig {
    best_radiances(probe, &Moments::new(probe, directions), directions.to_vec())
}

/// From `directions` downhill until a step lowers the cost by less than the share `still` of it.
pub fn refine(probe: &Probe, directions: &[DVec3], max_steps: usize, still: f64) -> Solution {
    let mut state = State::new(probe, directions.to_vec());
    let mut damping = 1e-3;
    for step in 0..max_steps {
        if state.cost <= EXACT * probe.energy {
            return state.solution(probe, step, StopReason::Exact);
        }
        let (curvature, slope) = normal_equations(&state);
        let Some(next) = downhill(probe, &state, &curvature, &slope, &mut damping) else {
            return state.solution(probe, step, StopReason::Converged);
        };
        let fall = state.cost - next.cost;
        let is_still = fall <= still * state.cost;
        state = next;
        if is_still {
            return state.solution(probe, step + 1, StopReason::Converged);
        }
    }
    state.solution(probe, max_steps, StopReason::OutOfSteps)
}

/// The first damped step that lowers the cost; none when even the shortest does not.
fn downhill(
    probe: &Probe,
    state: &State,
    curvature: &DMatrix<f64>,
    slope: &DVector<f64>,
    damping: &mut f64,
) -> Option<State> {
    const STIFFEST: f64 = 1e8;
    while *damping < STIFFEST {
        let step = damped_step(curvature, slope, *damping)?;
        let next = State::new(probe, turned(state, &step));
        if next.cost < state.cost {
            *damping = (*damping * 0.1).max(1e-12);
            return Some(next);
        }
        *damping *= 10.0;
    }
    None
}

/// `(H + damping diag H) step = -slope` (Levenberg 1944, Marquardt 1963).
fn damped_step(curvature: &DMatrix<f64>, slope: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let mut damped = curvature.clone();
    // A light that no channel uses has no slope and no curvature: it stays where it is.
    let floor = 1e-14 * curvature.diagonal().max();
    for i in 0..slope.len() {
        damped[(i, i)] += damping * curvature[(i, i)] + floor;
    }
    (floor > 0.0).then(|| damped.cholesky().map(|factor| factor.solve(&-slope))).flatten()
}

/// Every direction turned by its part of `step`.
fn turned(state: &State, step: &DVector<f64>) -> Vec<DVec3> {
    let lights = state.rig.directions.iter().zip(&state.moments.tangents).enumerate();
    lights
        .map(|(light, (&direction, &[s, t]))| {
            let along = s * step[2 * light] + t * step[2 * light + 1];
            exponential_map(direction, along.clamp_length_max(LONGEST_STEP))
        })
        .collect()
}

/// Best radiances, channel by channel, for lights in `directions`.
fn best_radiances(probe: &Probe, moments: &Moments, directions: Vec<DVec3>) -> Rig {
    let columns = probe.columns(directions.len());
    let gram = DMatrix::from_fn(columns.len(), columns.len(), |i, j| moments.gram[(columns[i], columns[j])]);
    let mut rig = Rig { ambient: DVec3::ZERO, irradiance: vec![DVec3::ZERO; directions.len()], directions };
    for channel in 0..3 {
        let right = DVector::from_fn(columns.len(), |i, _| moments.right[(columns[i], channel)]);
        let x = nnls::solve(&gram, &right);
        let (ambient, lights) = x.as_slice().split_at(usize::from(probe.has_ambient));
        rig.ambient[channel] = ambient.first().copied().unwrap_or(0.0);
        for (irradiance, &value) in rig.irradiance.iter_mut().zip(lights) {
            irradiance[channel] = value;
        }
    }
    rig
}

/// `J^T J` and `J^T r` of the head of this file, (2M, 2M) and (2M,).
fn normal_equations(state: &State) -> (DMatrix<f64>, DVector<f64>) {
    let size = 2 * state.rig.directions.len();
    let (mut curvature, mut slope) = (DMatrix::zeros(size, size), DVector::zeros(size));
    for channel in 0..3 {
        add_channel(state, channel, &mut curvature, &mut slope);
    }
    (curvature, slope)
}

fn add_channel(state: &State, channel: usize, curvature: &mut DMatrix<f64>, slope: &mut DVector<f64>) {
    let Moments { gram, right, .. } = &state.moments;
    let rig = &state.rig;
    let lights = rig.directions.len();
    let of_light = |j: usize| rig.irradiance[j][channel];
    let derivative = |jk: usize| column(jk / 2) + 1 + jk % 2;

    // The columns that this channel uses, and their radiances.
    let mut used: Vec<(usize, f64)> = (0..lights).map(|j| (column(j), of_light(j))).collect();
    used.insert(0, (0, rig.ambient[channel]));
    used.retain(|&(_, radiance)| radiance > 0.0);
    let columns: Vec<usize> = used.iter().map(|&(column, _)| column).collect();
    let Some(factor) = nnls::factor(gram, &columns) else { return };

    // Scaled derivatives in the coordinates of the used columns' orthonormal basis: L^-1 A^T da x.
    let size = 2 * lights;
    let mut inside =
        DMatrix::from_fn(columns.len(), size, |i, jk| gram[(columns[i], derivative(jk))] * of_light(jk / 2));
    factor.l_dirty().solve_lower_triangular_mut(&mut inside);

    for jk in 0..size {
        let explained: f64 =
            used.iter().map(|&(column, radiance)| gram[(derivative(jk), column)] * radiance).sum();
        slope[jk] -= of_light(jk / 2) * (right[(derivative(jk), channel)] - explained);
        for other in 0..size {
            let whole = gram[(derivative(jk), derivative(other))] * of_light(jk / 2) * of_light(other / 2);
            curvature[(jk, other)] += whole - inside.column(jk).dot(&inside.column(other));
        }
    }
}

/// `rig` without the lights that no channel uses, brightest first.
fn lit(rig: Rig) -> Rig {
    let luminance = |e: &DVec3| crate::kernels::image::luminance(e.to_array());
    let mut lights: Vec<(DVec3, DVec3)> = rig.directions.into_iter().zip(rig.irradiance).collect();
    lights.retain(|(_, irradiance)| irradiance.max_element() > 0.0);
    lights.sort_by(|a, b| luminance(&b.1).total_cmp(&luminance(&a.1)));
    let (directions, irradiance) = lights.into_iter().unzip();
    Rig { ambient: rig.ambient, directions, irradiance }
}
