//! Sides of a window, moved to where the map changes most.

use glam::{DMat3, DVec2};

use super::card_matrix::point;
use super::footprint::RemovedRadiance;
use super::wall_plane::{Sides, luminance, wall_frame};

/// Points on each side of a rectangle.
const POINTS: usize = 48;
/// Distance from a side of the points that are compared, and of those that tell the level of luminance, in pixels.
const INNER: f64 = 0.75;
const OUTER: f64 = 3.0;
/// First step of a side, in pixels, and of the wall, in angles between neighbouring walls; halvings, and sweeps of each.
const FIRST_STEP: f64 = 0.5;
const HALVINGS: i32 = 5;
const SWEEPS: i32 = 3;

/// Azimuth and sides at which the map changes most over the sides, within three pixels of a start.
///
/// `turn` is the angle between neighbouring walls of the search.
pub fn refine(removed: &RemovedRadiance<'_>, azimuth: f64, turn: f64, sides: Sides) -> (f64, Sides) {
    let levels = rim(removed, azimuth, sides, OUTER).map(|[inside, outside]| inside.max(outside).max(1e-30));
    let levels: Vec<f64> = levels.collect();
    // The luminance is divided by a constant for each point: a logarithm would move the side outwards.
    let change = |numbers: &[f64; 5]| -> f64 {
        let (azimuth, sides) = on_wall(numbers);
        let rim = rim(removed, azimuth, sides, INNER);
        rim.zip(&levels).map(|([inside, outside], level)| ((inside - outside) / level).clamp(-1.0, 1.0)).sum()
    };
    let pixel = FIRST_STEP * removed.pixels.step();
    let steps = [FIRST_STEP * turn, pixel, pixel, pixel, pixel];
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
pub fn matrix(azimuth: f64, [left, right, bottom, top]: Sides) -> DMat3 {
    let frame = wall_frame(azimuth);
    let corner = frame * DVec2::new(left, top).extend(1.0);
    let matrix = DMat3::from_cols((right - left) * frame.x_axis, (bottom - top) * frame.y_axis, corner);
    matrix * (1.0 / point(&matrix, DVec2::splat(0.5)).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::cards::card_matrix::corners;

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
