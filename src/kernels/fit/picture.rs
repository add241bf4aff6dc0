//! A map as discs, which are its bright parts, and harmonics of the rest: all objectives of a fit compare lights with it.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::DVec3;

use super::ambient::Ambient;
use super::objective::{Reference, distinct_channels};
use crate::kernels::expansion::{Expansion, Harmonics};
use crate::kernels::image::{MOST_PARTS, Part, WorkingMap};

/// A map as bright parts and harmonics of the rest.
#[derive(Clone, Debug)]
pub struct Picture {
    /// The harmonics of all cells that are not bright.
    pub cells: Harmonics,
    /// The harmonics of these cells and of the dullest parts.
    pub rest: Harmonics,
    /// The brightest parts.
    pub patches: Vec<Patch>,
    /// The harmonics of the patches.
    pub bright: Harmonics,
    /// Integral of the squared radiance that the harmonics of the rest leave out, by channel.
    pub fine: [f64; 3],
    /// Mean distances between the patches, by channel, for the kernels that need them.
    pub distances: OnceLock<[f64; 3]>,
}

impl Picture {
    /// Separate the bright parts of a map from its other cells.
    pub fn new(map: &WorkingMap) -> Self {
        let Expansion { rest: cells, fine } = Expansion::new(map);
        let mut rest = cells.clone();
        let mut patches = patches(map, &mut rest);
        // Add the dullest to the harmonics if there are too many.
        patches.sort_by(|a, b| b.radiance().total_cmp(&a.radiance()));
        let dull = patches.split_off(MOST_PARTS.min(patches.len()));
        rest.add_discs(dull.iter().map(Patch::disc));
        let mut bright = Harmonics::zero();
        bright.add_discs(patches.iter().map(Patch::disc));
        Self { cells, rest, patches, bright, fine, distances: OnceLock::new() }
    }

    /// The channels of the map, and the ambient term beside its lights.
    pub fn reference(&self, ambient: Ambient, has_floor: bool) -> Reference {
        let parts = [&self.rest, &self.bright];
        let is_black = |channel: usize| parts.iter().all(|part| part.moments(channel).0 == 0.0);
        let are_same = |a: usize, b: usize| parts.iter().all(|part| part.has_equal_channels(a, b));
        let (channels, like) = distinct_channels(is_black, are_same);
        Reference { channels, like, ..Reference::nothing(ambient, has_floor) }
    }
}

/// A part of a bright cell of the map, as a disc of the same spread.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    pub direction: DVec3,
    pub share: f64,
    pub flux: [f64; 3],
}

impl Patch {
    /// Its direction, A and flux.
    pub fn disc(&self) -> (DVec3, f64, [f64; 3]) {
        (self.direction, self.share, self.flux)
    }

    /// Its radiance, summed over the channels.
    fn radiance(&self) -> f64 {
        self.flux.iter().sum::<f64>() / (4.0 * PI * self.share)
    }
}

/// The parts of the map's sources and bright cells as discs.
///
/// The channels of a part may have different directions; the first degree of the `rest` takes the difference.
fn patches(map: &WorkingMap, rest: &mut Harmonics) -> Vec<Patch> {
    let mut patches = Vec::new();
    for &Part { irradiance: [x, y, z], spread: share } in &map.parts {
        let vectors = [0, 1, 2].map(|c| DVec3::new(x[c], y[c], z[c]));
        let Some(direction) = vectors.iter().sum::<DVec3>().try_normalize() else { continue };
        let along = vectors.map(|vector| vector.dot(direction).max(0.0));
        for c in 0..3 {
            rest.add_first(c, vectors[c] - along[c] * direction);
        }
        patches.push(Patch { direction, share, flux: along.map(|vector| vector / (1.0 - share)) });
    }
    patches
}
