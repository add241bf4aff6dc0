//! Discs to start from: lights without a size, as wide as the light of the map around each.
//!
//! Above the ambient radiance, each direction of the map belongs to its nearest light. The disc of the same mean of
//! 1 - cos of the angle to its centre has `cos a = 1 - 2 mean(1 - cos)`.
//!
//! Beside harmonics, this says little: they hold some of the spread light, and the probe hardly tells a light from
//! its opposite, for the difference is nearly a harmonic of degree 1. Shadows do. So small discs are tried as well,
//! and every light on the side that is better.

use glam::DVec3;

use super::disc_cost::Shadows;
use crate::kernels::fit::ambient::Ambient;
use crate::kernels::fit::objective::Objective;
use crate::kernels::fit::rig::Rig;
use crate::kernels::fit::settings::DISCS;
use crate::kernels::fit::state::State;
use crate::kernels::image::WorkingMap;

/// States to start from, near a `rig` of lights without a size.
pub fn starts(shadows: &Shadows<'_>, map: &WorkingMap, rig: &Rig, fixed: usize) -> Vec<State> {
    let spread = spread(map, rig).into_iter().map(|radius| DISCS.start * radius).collect();
    let mut starts: Vec<Vec<f64>> = vec![spread];
    if shadows.reference().ambient == Ambient::Sh2 {
        starts.extend(DISCS.small.map(|radius| vec![radius; rig.directions.len()]));
    }
    let state = |radii: &Vec<f64>| {
        let lights = rig.directions.iter().zip(radii);
        let discs = lights.map(|(&direction, &radius)| shadows.disc(direction, radius)).collect();
        let state = shadows.state(discs);
        if shadows.reference().ambient == Ambient::Sh2 {
            on_better_sides(shadows, state, fixed)
        } else {
            state
        }
    };
    starts.iter().map(state).collect()
}

/// Turn each light, one after the other, to the opposite direction if that lowers the cost.
fn on_better_sides(shadows: &Shadows<'_>, mut state: State, fixed: usize) -> State {
    for light in fixed..state.lights() {
        let mut discs = state.moments.discs.clone();
        discs[light] = shadows.disc(-discs[light].direction, discs[light].radius);
        let opposite = shadows.state(discs);
        if opposite.cost < state.cost {
            state = opposite;
        }
    }
    state
}

/// Radius of the disc that is spread like the light around each light.
fn spread(map: &WorkingMap, rig: &Rig) -> Vec<f64> {
    let ambient = if rig.ambient.len() == 1 { rig.ambient[0].element_sum() } else { 0.0 };
    let mut spread = Spread { directions: &rig.directions, sums: vec![[0.0; 2]; rig.directions.len()] };
    let columns: Vec<(f64, [f64; 2])> = map
        .grid
        .phi_edges
        .windows(2)
        .map(|edges| (edges[1] - edges[0], (0.5 * (edges[0] + edges[1])).sin_cos().into()))
        .collect();
    for (edges, row) in map.rows(&map.radiance) {
        let band = edges[0].cos() - edges[1].cos();
        let (sine, cosine) = (0.5 * (edges[0] + edges[1])).sin_cos();
        for (cell, (width, [sin, cos])) in row.iter().zip(&columns) {
            let above = f64::from(cell[0] + cell[1] + cell[2]) - ambient;
            if above > 0.0 {
                spread.add(DVec3::new(sin * sine, cosine, -cos * sine), above * band * width);
            }
        }
    }
    for source in map.source_vectors() {
        let vector: DVec3 = source.iter().sum();
        let flux = vector.length();
        if flux > 0.0 {
            spread.add(vector / flux, flux);
        }
    }
    spread.radii()
}

/// Flux that is nearest to each light, and its integral of 1 - cos of the angle to the light.
struct Spread<'a> {
    directions: &'a [DVec3],
    sums: Vec<[f64; 2]>,
}

impl Spread<'_> {
    /// Add flux from a direction.
    fn add(&mut self, towards: DVec3, flux: f64) {
        let mut nearest = (f64::NEG_INFINITY, 0);
        for (light, direction) in self.directions.iter().enumerate() {
            let cosine = direction.dot(towards);
            if cosine > nearest.0 {
                nearest = (cosine, light);
            }
        }
        if let Some(sum) = self.sums.get_mut(nearest.1) {
            sum[0] += flux;
            sum[1] += flux * (1.0 - nearest.0);
        }
    }

    /// Radius of the disc of the same mean of 1 - cos, for each light.
    fn radii(&self) -> Vec<f64> {
        let radius = |[flux, spread]: &[f64; 2]| {
            let mean = if *flux > 0.0 { spread / flux } else { 0.0 };
            (1.0 - 2.0 * mean).clamp(-1.0, 1.0).acos()
        };
        self.sums.iter().map(radius).collect()
    }
}
