//! Directions that no gradient suggests: even starts, and nudges.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::solver::State;
use crate::error::Result;
use crate::kernels::sampling;
use crate::kernels::sphere::{exponential_map, tangents, to_vectors};

/// The longest nudge, in radians: to the next small valley, not to the next light.
const FARTHEST: f64 = 0.3;

/// So many starts of lights spread evenly: the first as they are (Madsen et al. 2003, section 3.2), the
/// others of `spare` more, each turned elsewhere.
///
/// # Errors
///
/// As [`sampling::halton`].
pub fn starts(count: usize, lights: usize, spare: usize) -> Result<Vec<Vec<DVec3>>> {
    let (first, others) = (even(lights), even(lights + spare));
    let turns = sampling::halton(count, &[2, 3, 5])?;
    let turns = turns.rows().into_iter().skip(1).map(|at| rotation([at[0], at[1], at[2]]));
    let others = turns.map(|turn| others.iter().map(|&direction| turn * direction).collect());
    Ok(std::iter::once(first).chain(others).collect())
}

fn even(lights: usize) -> Vec<DVec3> {
    to_vectors(sampling::even_sphere(lights).view())
}

/// Evenly distributed rotations from evenly distributed points of the unit cube (Shoemake 1992).
fn rotation([u, v, w]: [f64; 3]) -> DQuat {
    let (sin_v, cos_v) = (TAU * v).sin_cos();
    let (sin_w, cos_w) = (TAU * w).sin_cos();
    let (one, other) = ((1.0 - u).sqrt(), u.sqrt());
    DQuat::from_xyzw(one * sin_v, one * cos_v, other * sin_w, other * cos_w)
}

/// The lights of `state`, but for the first `held`, each turned somewhere else near: `count` times, the
/// last time the farthest; in each `round` elsewhere.
///
/// # Errors
///
/// As [`sampling::halton`].
pub fn nudges(state: &State, held: usize, count: usize, round: usize) -> Result<Vec<Vec<DVec3>>> {
    let lights = state.lights();
    let places = sampling::halton((round + 1) * count * lights, &[2, 3])?;
    let nudge = |nudge: usize| {
        let farthest = FARTHEST * (nudge + 1) as f64 / count as f64;
        let turn = |(light, &direction): (usize, &DVec3)| {
            if light < held {
                return direction;
            }
            let place = places.row((round * count + nudge) * lights + light);
            let ((sin, cos), distance) = ((TAU * place[0]).sin_cos(), farthest * place[1].sqrt());
            let [s, t] = tangents(direction);
            exponential_map(direction, (s * cos + t * sin) * distance)
        };
        state.moments.directions.iter().enumerate().map(turn).collect()
    };
    Ok((0..count).map(nudge).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::kernels::fit::{Ambient, Probe, Samples};

    #[test]
    fn even_starts_are_spread_and_differ() {
        let starts = starts(12, 8, 1).unwrap();
        assert_eq!(starts.iter().map(Vec::len).collect::<Vec<_>>(), [[8].as_slice(), &[9; 11]].concat());
        for start in &starts {
            let sum: DVec3 = start.iter().sum();
            assert!(sum.length() < 1.5, "{sum}");
            assert!(start.iter().all(|l| (l.length() - 1.0).abs() < 1e-12));
        }
        // Turned evenly, the first light of all starts is everywhere.
        let first: DVec3 = starts.iter().map(|start| start[0]).sum();
        assert!(first.length() < 4.0, "{first}");
        assert!(starts.windows(2).all(|pair| pair[0][0].distance(pair[1][0]) > 0.1));
    }

    #[test]
    fn nudges_are_short_and_elsewhere_in_each_round() {
        let (normals, weights) = sampling::icosphere(320).unwrap();
        let seen = normals.mapv(f64::abs);
        let samples = Samples::new(normals.view(), weights.view(), seen.view()).unwrap();
        let lights = [DVec3::Y, DVec3::X, DVec3::NEG_Z];
        let state = State::new(&Probe::new(samples, Ambient::Constant), &lights);
        let rounds = [0, 1].map(|round| nudges(&state, 1, 8, round).unwrap());
        for nudge in rounds.iter().flatten() {
            assert_eq!(nudge[0], DVec3::Y); // held
            for (new, old) in nudge[1..].iter().zip(&lights[1..]) {
                let angle = new.angle_between(*old);
                assert!(angle > 0.0 && angle <= FARTHEST + 1e-12, "{angle}");
            }
        }
        assert!(rounds[0].iter().all(|nudge| !rounds[1].contains(nudge)));
    }
}
