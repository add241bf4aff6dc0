//! Windows with a view: upright rectangles on walls, found by their edges.
//!
//! No level of luminance shows the frame of a window with sky above and a garden below. But windows stand upright: in the
//! plane of their wall, their sides are level and plumb. So walls of all azimuths are tried. In each, the rectangle is
//! searched whose four sides separate a bright inside from a darker outside, and which holds the light.

use std::f64::consts::FRAC_PI_3;

use glam::{DMat3, DVec2};
use rayon::prelude::*;

use super::card_matrix::{place_of, point, sizes};
use super::footprint::RemovedRadiance;
use super::panes::Group;
use super::shape_fit::{FittedShape, Shape};
use super::wall_plane::{LightSamples, Sides, WallPlane, luminance, wall_frame};
use crate::kernels::sphere;

/// Walls that are tried, up to 60 degrees on each side of the light.
const WALLS: usize = 31;
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
/// Points on each side of a rectangle whose sides are refined.
const POINTS: usize = 48;
/// Distance from a side of the points that are compared, and of those that tell the level of luminance, in pixels.
const INNER: f64 = 0.75;
const OUTER: f64 = 3.0;
/// First step of a side in pixels and of the wall relative to those of the search, halvings, and sweeps of each.
const FIRST_STEP: f64 = 0.5;
const HALVINGS: i32 = 5;
const SWEEPS: i32 = 3;

/// Cards of lights: those of unsure shapes become windows if edges show them more surely. Others inside of a window join it.
pub fn find(
    removed: &RemovedRadiance<'_>,
    members: &[Vec<u32>],
    fits: Vec<Option<FittedShape>>,
) -> Vec<Group> {
    let is_other = |fit: &Option<FittedShape>| fit.as_ref().is_some_and(|fit| fit.shape == Shape::Other);
    let flux = |members: &Vec<u32>| -> f64 {
        members.iter().map(|&pixel| removed.luminous_flux(pixel as usize)).sum()
    };
    let fluxes: Vec<f64> = members.iter().map(flux).collect();
    let least = LEAST_FLUX * fluxes.iter().sum::<f64>();
    let window = |(light, fit): (usize, &Option<FittedShape>)| {
        let fit = fit.as_ref().filter(|fit| fit.shape != Shape::Point && fit.overlap < SURE_OVERLAP)?;
        if fluxes[light] < least {
            return None;
        }
        window_of(removed, &members[light]).filter(|window| is_better(window, fit))
    };
    let windows: Vec<Option<FittedShape>> = fits.par_iter().enumerate().map(window).collect();
    let mut groups: Vec<Group> = Vec::new();
    for (light, (fit, window)) in fits.into_iter().zip(windows).enumerate() {
        let number = light as u32 + 1;
        let holds = |group: &&mut Group| {
            let outline = group.1.as_ref().filter(|fit| fit.is_window);
            outline
                .is_some_and(|outline| share_inside(removed, &members[light], &outline.matrix) >= LEAST_SHARE)
        };
        let holder = if is_other(&fit) { groups.iter_mut().find(holds) } else { None };
        match holder {
            Some(group) => group.0.push(number),
            None => groups.push((vec![number], window.or(fit))),
        }
    }
    groups
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
    let sum: glam::DVec3 = light.samples.iter().map(|(direction, flux)| *flux * *direction).sum();
    let (_, azimuth) = sphere::angles(sum);
    let rectangle = |azimuth: f64, cells: f64| {
        crate::interrupt::check();
        let (contrast, sides) = best_rectangle(&WallPlane::new(removed, &light, azimuth, cells)?)?;
        Some((contrast, azimuth, sides))
    };
    let turn = |wall: usize| FRAC_PI_3 * (2.0 * wall as f64 / (WALLS - 1) as f64 - 1.0);
    let walls = (0..WALLS).filter_map(|wall| rectangle(azimuth + turn(wall), COARSE_CELLS));
    let mut walls: Vec<(f64, f64, Sides)> = walls.collect();
    walls.sort_by(|a, b| b.0.total_cmp(&a.0));
    let fine = walls.iter().take(FINE_WALLS).filter_map(|(_, azimuth, _)| rectangle(*azimuth, FINE_CELLS));
    let best = fine.max_by(|a, b| a.0.total_cmp(&b.0));
    let (contrast, azimuth, sides) = best.filter(|(contrast, ..)| *contrast >= LEAST_CONTRAST)?;
    let (azimuth, sides) = refine(removed, azimuth, sides);
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

/// Directions and flux of some of the pixels of a light, and the mean luminance of all.
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

/// Azimuth and sides at which the map changes most over the sides, within three pixels of a start.
fn refine(removed: &RemovedRadiance<'_>, azimuth: f64, sides: Sides) -> (f64, Sides) {
    let levels = rim(removed, azimuth, sides, OUTER).map(|[inside, outside]| inside.max(outside).max(1e-30));
    let levels: Vec<f64> = levels.collect();
    // The luminance is divided by a constant for each point: a logarithm would move the side outwards.
    let change = |numbers: &[f64; 5]| -> f64 {
        let (azimuth, sides) = on_wall(numbers);
        let rim = rim(removed, azimuth, sides, INNER);
        rim.zip(&levels).map(|([inside, outside], level)| ((inside - outside) / level).clamp(-1.0, 1.0)).sum()
    };
    let pixel = FIRST_STEP * removed.pixels.step();
    let steps = [FIRST_STEP * FRAC_PI_3 / (WALLS - 1) as f64, pixel, pixel, pixel, pixel];
    let mut best = from_wall(azimuth, sides);
    let mut most = change(&best);
    for sweep in 0..HALVINGS * SWEEPS {
        let scale = 0.5_f64.powi(sweep / SWEEPS);
        for (n, step) in steps.iter().enumerate() {
            for sign in [-1.0, 1.0] {
                let mut moved = best;
                moved[n] += sign * step * scale;
                let value = change(&moved);
                if value > most {
                    (best, most) = (moved, value);
                }
            }
        }
    }
    on_wall(&best)
}

/// Azimuths of the wall and of the left and right side, and tangents of elevation of bottom and top between them.
///
/// The wall may turn while these stay, so the sides barely move.
fn from_wall(azimuth: f64, [left, right, bottom, top]: Sides) -> [f64; 5] {
    let turns = [left.atan(), right.atan()];
    let middle = (0.5 * (turns[0] + turns[1])).cos();
    [azimuth, azimuth + turns[0], azimuth + turns[1], bottom * middle, top * middle]
}

/// Inverse of [`from_wall`].
fn on_wall(&[azimuth, left, right, bottom, top]: &[f64; 5]) -> (f64, Sides) {
    let turns = [left - azimuth, right - azimuth];
    let middle = (0.5 * (turns[0] + turns[1])).cos();
    (azimuth, [turns[0].tan(), turns[1].tan(), bottom / middle, top / middle])
}

/// Luminance inside and outside of the points on the sides of a rectangle, at a distance in pixels.
fn rim<'a>(
    removed: &'a RemovedRadiance<'_>,
    azimuth: f64,
    [left, right, bottom, top]: Sides,
    pixels: f64,
) -> impl Iterator<Item = [f64; 2]> + 'a {
    let frame = wall_frame(azimuth);
    let (low, high) = (DVec2::new(left, bottom), DVec2::new(right, top));
    let (top_left, bottom_right) = (DVec2::new(left, top), DVec2::new(right, bottom));
    let sides = [
        (low, top_left, DVec2::X),
        (bottom_right, high, DVec2::NEG_X),
        (low, bottom_right, DVec2::Y),
        (top_left, high, DVec2::NEG_Y),
    ];
    sides.into_iter().flat_map(move |(from, to, inwards)| {
        (0..POINTS).map(move |i| {
            let place = from.lerp(to, (i as f64 + 0.5) / POINTS as f64);
            let offset = pixels * removed.pixels.step() * (1.0 + place.length_squared()) * inwards;
            [place + offset, place - offset].map(|place| luminance(removed, frame * place.extend(1.0)))
        })
    })
}

/// Matrix of a rectangle on the wall of an azimuth, with its centre at distance 1.
fn matrix(azimuth: f64, [left, right, bottom, top]: Sides) -> DMat3 {
    let frame = wall_frame(azimuth);
    let corner = frame * DVec2::new(left, top).extend(1.0);
    let matrix = DMat3::from_cols((right - left) * frame.x_axis, (bottom - top) * frame.y_axis, corner);
    matrix * (1.0 / point(&matrix, DVec2::splat(0.5)).length())
}

/// Share of the flux of a light inside of a card.
fn share_inside(removed: &RemovedRadiance<'_>, members: &[u32], matrix: &DMat3) -> f64 {
    let Some(light) = samples(removed, members) else { return 0.0 };
    let inverse = matrix.inverse();
    let is_inside = |direction| {
        place_of(&inverse, direction).is_some_and(|place| super::card_matrix::is_inside(place, false))
    };
    let flux = |inside: bool| -> f64 {
        light
            .samples
            .iter()
            .filter(|(direction, _)| !inside || is_inside(*direction))
            .map(|(_, flux)| flux)
            .sum()
    };
    flux(true) / flux(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::cards::card_matrix::corners;

    #[test]
    fn the_contrast_of_a_rectangle_is_low_if_one_side_has_none() {
        assert!((contrast([1.0; 4]) - 1.0).abs() < 1e-12);
        assert!(contrast([1.0, 1.0, 1.0, 0.0]) < LEAST_CONTRAST);
    }

    #[test]
    fn a_wall_may_turn_while_its_sides_stay() {
        let sides = [-0.2, 0.9, -0.4, 0.3];
        let (azimuth, again) = on_wall(&from_wall(2.0, sides));
        assert!((azimuth - 2.0).abs() < 1e-12 && again.iter().zip(sides).all(|(a, b)| (a - b).abs() < 1e-12));
        let mut turned = from_wall(2.0, sides);
        turned[0] += 0.1;
        let (azimuth, sides) = on_wall(&turned);
        assert!(
            corners(&matrix(azimuth, sides))[0]
                .angle_between(corners(&matrix(2.0, [-0.2, 0.9, -0.4, 0.3]))[0])
                < 0.03
        );
    }

    #[test]
    fn the_matrix_of_a_rectangle_has_its_corners() {
        let [top_left, _, bottom_right, _] = corners(&matrix(2.0, [-0.2, 0.9, -0.4, 0.3]));
        let place = |corner: glam::DVec3| {
            let local = wall_frame(2.0).transpose() * corner;
            local.truncate() / local.z
        };
        assert!(place(top_left).abs_diff_eq(DVec2::new(-0.2, 0.3), 1e-12));
        assert!(place(bottom_right).abs_diff_eq(DVec2::new(0.9, -0.4), 1e-12));
    }
}
