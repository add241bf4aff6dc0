//! Radiance behind windows, so that a card takes its whole view: continued from around the frame.

use super::card_pixels::CardPixels;
use super::footprint::RemovedRadiance;
use super::panes::Group;
use crate::kernels::fill::harmonic_fill;

/// The rest of a map with a fill inside of all windows; none without windows. Darker pixels stay.
pub fn fill_windows(removed: &RemovedRadiance<'_>, cards: &[Group]) -> Option<Vec<[f32; 3]>> {
    let holes = pixels_inside(&removed.pixels, cards);
    if holes.is_empty() {
        return None;
    }
    let known = |pixel: usize| glam::Vec3A::from_array(removed.rest[pixel]);
    let fill = harmonic_fill(removed.pixels.grid().clone(), holes.clone(), known);
    let mut rest = removed.rest.to_vec();
    for hole in holes {
        rest[hole] = fill.values[hole].min(known(hole)).to_array();
    }
    Some(rest)
}

/// Pixels that a window touches, in ascending order.
fn pixels_inside(pixels: &CardPixels, cards: &[Group]) -> Vec<usize> {
    let windows = cards.iter().filter_map(|(_, fit)| fit.as_ref().filter(|fit| fit.is_window));
    let touched =
        |matrix| pixels.inside(matrix, false, |(), _| (), || ()).into_iter().map(|(pixel, ..)| pixel);
    let mut inside: Vec<usize> = windows.flat_map(|window| touched(&window.matrix)).collect();
    inside.sort_unstable();
    inside.dedup();
    inside
}
