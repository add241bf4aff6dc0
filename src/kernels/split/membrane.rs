//! The membrane: a smooth radiance in the holes that meets what is around them.
//!
//! It solves Laplace's equation on the sphere, for each channel, so that it lies between the darkest and the
//! brightest pixel around its hole. The coarsest image in which no hole is left starts the next finer one, and
//! so on (cascadic multigrid: Bornemann and Deuflhard 1996, "The cascadic multigrid method for elliptic
//! problems").
//!
//! Beside it stands a bump, the solution of Poisson's equation with a source of 1: smooth, 0 at the rim of
//! each hole and positive inside.

use rayon::prelude::*;

use super::level::Level;
use super::region::Regions;
use super::working::Working;

/// Relaxations of the finest level; each coarser one, with a quarter of the pixels, has twice as many.
const SWEEPS: usize = 8;
/// Relaxations of a level, at most.
const MOST_SWEEPS: usize = 256;
/// Rows of the coarsest level, at least.
const LEAST_ROWS: usize = 4;

/// The working image with the holes closed; its fourth value is the bump.
pub fn membrane(working: &Working, regions: &Regions) -> Level {
    let values = working
        .radiance
        .par_iter()
        .zip(&regions.is_hole)
        .map(|(&[red, green, blue], &is_hole)| if is_hole { [0.0; 4] } else { [red, green, blue, 0.0] });
    let mut levels = vec![Level::new(working.grid.clone(), values.collect(), regions.is_hole.clone())];
    while levels[levels.len() - 1].has_holes() && levels[levels.len() - 1].size.0 > LEAST_ROWS {
        levels.push(levels[levels.len() - 1].coarser());
    }
    let mut solved = levels.pop().expect("one level at least");
    if solved.has_holes() {
        solved.relax(MOST_SWEEPS);
    }
    while let Some(mut finer) = levels.pop() {
        finer.start_from(&solved);
        finer.relax((SWEEPS << levels.len()).min(MOST_SWEEPS));
        solved = finer;
    }
    solved
}
