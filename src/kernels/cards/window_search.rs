//! Windows with a view: upright rectangles on walls, found by their edges.
//!
//! No level of luminance shows the frame of a window with sky above and a garden below. But windows stand upright: in the
//! plane of their wall, their sides are level and plumb. So walls of all azimuths are tried. In each, the rectangle is
//! searched whose four sides separate a bright inside from a darker outside, and which holds the light.

use std::f64::consts::FRAC_PI_3;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::card_matrix::{self, place_of, sizes};
use super::footprint::RemovedRadiance;
use super::panes::Group;
use super::shape_fit::{FittedShape, Shape};
use super::wall_plane::{LightSamples, Sides, WallPlane};
use super::window_sides::{matrix, refine};
use crate::kernels::sphere;

/// Walls that are tried on each side of the light, and the angle between two: 4 degrees, up to 60.
const WALLS: i32 = 15;
const TURN: f64 = FRAC_PI_3 / WALLS as f64;
/// Cells along a light on each of these walls, on the best of them, and number of the best.
const COARSE_CELLS: f64 = 40.0;
const FINE_CELLS: f64 = 128.0;
const FINE_WALLS: usize = 5;
/// Lines that are tried for each side.
const LINES: usize = 10;
/// Least share of the flux of a light in its window.
const LEAST_SHARE: f64 = 0.9;
/// Least contrast of a window: half the mean of its sides and half the least of them.
const LEAST_CONTRAST: f64 = 0.65;
/// Overlap above which a shape is sure, and no window is searched. True shapes reach 0.87 to 0.99.
const SURE_OVERLAP: f64 = 0.9;
/// Least area of a window relative to the shape that it replaces: the shape of a light without a view is more exact.
const LEAST_GAIN: f64 = 1.2;
/// Least thickness of a window in radians: 5 degrees.
const LEAST_SIZE: f64 = 0.087;
/// Least flux of a light relative to that of all, below which its view is not worth the search.
const LEAST_FLUX: f64 = 0.01;
/// Directions of a light at most.
const MOST_SAMPLES: usize = 2000;

/// Cards of lights: those of unsure shapes become windows if edges show them more surely. Others inside of a window join it.
pub fn find(
    removed: &RemovedRadiance<'_>,
    members: &[Vec<u32>],
    fits: Vec<Option<FittedShape>>,
) -> Vec<Group> {
    let is_other = |fit: &Option<FittedShape>| fit.as_ref().is_some_and(|fit| fit.shape == Shape::Other);
    let windows = windows_of(removed, members, &fits);
    let mut groups: Vec<Group> = Vec::new();
    for (light, (fit, window)) in fits.into_iter().zip(windows).enumerate() {
        let number = light as u32 + 1;
        let holds = |group: &&mut Group| {
            let outline = group.1.as_ref().filter(|fit| fit.is_window);
            outline.is_some_and(|outline| holds_light(removed, &members[light], &outline.matrix))
        };
        let holder = if is_other(&fit) { groups.iter_mut().find(holds) } else { None };
        match holder {
            Some(group) => group.0.push(number),
            None => groups.push((vec![number], window.or(fit))),
        }
    }
    groups
}

/// Better window of each light that is worth the search.
fn windows_of(
    removed: &RemovedRadiance<'_>,
    members: &[Vec<u32>],
    fits: &[Option<FittedShape>],
) -> Vec<Option<FittedShape>> {
    let flux = |members: &Vec<u32>| -> f64 {
        members.iter().map(|&pixel| removed.luminous_flux(pixel as usize)).sum()
    };
    let fluxes: Vec<f64> = members.iter().map(flux).collect();
    let least = LEAST_FLUX * fluxes.iter().sum::<f64>();
    let window = |(light, fit): (usize, &Option<FittedShape>)| {
        let is_unsure = |fit: &&FittedShape| fit.shape != Shape::Point && fit.overlap < SURE_OVERLAP;
        let fit = fit.as_ref().filter(is_unsure).filter(|_| fluxes[light] >= least)?;
        window_of(removed, &members[light]).filter(|window| is_better(window, fit))
    };
    fits.par_iter().enumerate().map(window).collect()
}

/// True for a window that is surer than a shape, and shows more than the shape holds.
fn is_better(window: &FittedShape, shape: &FittedShape) -> bool {
    let area = |fit: &FittedShape| sizes(&fit.matrix).into_iter().product::<f64>();
    let is_larger = shape.shape == Shape::Other || area(window) > LEAST_GAIN * area(shape);
    is_larger && window.overlap > shape.overlap
}

/// Window around a light, if its edges show one.
fn window_of(removed: &RemovedRadiance<'_>, members: &[u32]) -> Option<FittedShape> {
    let light = samples(removed, members)?;
    let sum: DVec3 = light.samples.iter().map(|(direction, flux)| *flux * *direction).sum();
    let (_, azimuth) = sphere::angles(sum);
    let rectangle = |azimuth: f64, cells: f64| {
        crate::interrupt::check();
        let (contrast, sides) = best_rectangle(&WallPlane::new(removed, &light, azimuth, cells)?)?;
        Some((contrast, azimuth, sides))
    };
    let walls = (-WALLS..=WALLS).map(|wall| azimuth + TURN * f64::from(wall));
    let walls = walls.filter_map(|azimuth| rectangle(azimuth, COARSE_CELLS));
    let mut walls: Vec<(f64, f64, Sides)> = walls.collect();
    walls.sort_by(|a, b| b.0.total_cmp(&a.0));
    let fine = walls.iter().take(FINE_WALLS).filter_map(|(_, azimuth, _)| rectangle(*azimuth, FINE_CELLS));
    let best = fine.max_by(|a, b| a.0.total_cmp(&b.0));
    let (contrast, azimuth, sides) = best.filter(|(contrast, ..)| *contrast >= LEAST_CONTRAST)?;
    let (azimuth, sides) = refine(removed, azimuth, TURN, sides);
    let matrix = matrix(azimuth, sides);
    let is_thick = sizes(&matrix).into_iter().all(|size| size >= LEAST_SIZE);
    is_thick.then_some(FittedShape {
        shape: Shape::Rectangle,
        matrix,
        overlap: contrast,
        inner: light.luminance,
        is_window: true,
    })
}

/// Directions and flux of some pixels of a light, and their mean luminance.
fn samples(removed: &RemovedRadiance<'_>, members: &[u32]) -> Option<LightSamples> {
    let sample =
        |&pixel: &u32| (removed.pixels.direction(pixel as usize), removed.luminous_flux(pixel as usize));
    let stride = members.len().div_ceil(MOST_SAMPLES).max(1);
    let samples: Vec<_> = members.iter().step_by(stride).map(sample).collect();
    let area: f64 =
        members.iter().step_by(stride).map(|&pixel| removed.pixels.solid_angle(pixel as usize)).sum();
    let luminance = samples.iter().map(|(_, flux)| flux).sum::<f64>() / area;
    (luminance > 0.0).then_some(LightSamples { samples, luminance })
}

/// Contrast and sides of the best rectangle on a wall that holds the light.
fn best_rectangle(wall: &WallPlane) -> Option<(f64, Sides)> {
    let candidates = [0, 1, 2, 3].map(|side| wall.candidates(side, LINES));
    let [lefts, rights, bottoms, tops] = &candidates;
    let across = lefts.iter().flat_map(|&left| rights.iter().map(move |&right| [left, right]));
    let mut best: Option<(f64, [usize; 4])> = None;
    for [left, right] in across.filter(|[left, right]| left < right) {
        for &bottom in bottoms {
            for &top in tops.iter().filter(|top| bottom < **top) {
                let lines = [left, right, bottom, top];
                if wall.share(lines) < LEAST_SHARE {
                    continue;
                }
                let contrast = contrast([0, 1, 2, 3].map(|side| wall.contrast(side, lines)));
                if best.as_ref().is_none_or(|(other, _)| contrast > *other) {
                    best = Some((contrast, lines));
                }
            }
        }
    }
    best.map(|(contrast, lines)| (contrast, wall.sides(lines)))
}

/// Contrast of a rectangle from those of its sides.
fn contrast(sides: [f64; 4]) -> f64 {
    0.125 * sides.iter().sum::<f64>() + 0.5 * sides.into_iter().fold(f64::INFINITY, f64::min)
}

/// True if a card holds most of the flux of a light.
fn holds_light(removed: &RemovedRadiance<'_>, members: &[u32], matrix: &DMat3) -> bool {
    let Some(LightSamples { samples, .. }) = samples(removed, members) else { return false };
    let inverse = matrix.inverse();
    let is_in = |direction| place_of(&inverse, direction).is_some_and(|at| card_matrix::is_inside(at, false));
    let inside: f64 = samples.iter().filter(|(towards, _)| is_in(*towards)).map(|(_, flux)| flux).sum();
    inside >= LEAST_SHARE * samples.iter().map(|(_, flux)| flux).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contrast_of_a_rectangle_is_low_if_one_side_has_none() {
        assert!((contrast([1.0; 4]) - 1.0).abs() < 1e-12);
        assert!(contrast([1.0, 1.0, 1.0, 0.0]) < LEAST_CONTRAST);
    }
}
