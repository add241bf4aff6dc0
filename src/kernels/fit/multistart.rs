//! Directions that no gradient suggests: even starts, and perturbed ones.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::settings::SEARCH;
use super::state::State;
use crate::error::Result;
use crate::kernels::sampling;
use crate::kernels::sphere::{exponential_map, tangents, to_vectors};

/// Sets of lights spread evenly: the first as it is (Madsen et al. 2003, section 3.2), the others turned.
///
/// # Errors
///
/// As [`sampling::halton`].
pub fn even(count: usize, lights: usize) -> Result<Vec<Vec<DVec3>>> {
    let first = to_vectors(sampling::even_sphere(lights).view());
    let turns = sampling::halton(count, &[2, 3, 5])?;
    let turns = turns.rows().into_iter().skip(1).map(|at| rotation([at[0], at[1], at[2]]));
    let others: Vec<Vec<DVec3>> =
        turns.map(|turn| first.iter().map(|&direction| turn * direction).collect()).collect();
    Ok(std::iter::once(first).chain(others).collect())
}

/// Evenly distributed rotations from evenly distributed points of the unit cube (Shoemake 1992).
fn rotation([u, v, w]: [f64; 3]) -> DQuat {
    let (sin_v, cos_v) = (TAU * v).sin_cos();
    let (sin_w, cos_w) = (TAU * w).sin_cos();
    let (one, other) = ((1.0 - u).sqrt(), u.sqrt());
    DQuat::from_xyzw(one * sin_v, one * cos_v, other * sin_w, other * cos_w)
}

/// `count` sets of the directions of `state`, each turned a little but for the first `fixed`.
///
/// Later sets are turned farther, and each `round` turns them otherwise.
///
/// # Errors
///
/// As [`sampling::halton`].
pub fn perturb(state: &State, fixed: usize, count: usize, round: usize) -> Result<Vec<Vec<DVec3>>> {
    let lights = state.lights();
    let places = sampling::halton((round + 1) * count * lights, &[2, 3])?;
    let perturb = |start: usize| {
        let farthest = SEARCH.farthest * (start + 1) as f64 / count as f64;
        let turn = |(light, &direction): (usize, &DVec3)| {
            if light < fixed {
                return direction;
            }
            let place = places.row((round * count + start) * lights + light);
            let ((sin, cos), distance) = ((TAU * place[0]).sin_cos(), farthest * place[1].sqrt());
            let [s, t] = tangents(direction);
            exponential_map(direction, (s * cos + t * sin) * distance)
        };
        state.moments.directions.iter().enumerate().map(turn).collect()
    };
    Ok((0..count).map(perturb).collect())
}
