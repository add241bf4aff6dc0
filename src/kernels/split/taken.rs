//! Lights that are taken out of a map, so that each has one direction.
//!
//! Their pixels are closed (`close.rs`), and what is left of them is tilted (`tilt.rs`) where that makes the vectors of
//! all channels parallel.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::cells::Cells;
use super::close::{close, dim};
use super::loss::Loss;
use super::pixels::{Bands, Map};
use super::region::Regions;
use super::tilt::{tilt, tilts};
use crate::kernels::detect::segment::run::{Run, runs};

/// A light that was taken out of a map.
#[derive(Clone, Debug)]
pub struct Taken {
    /// Unit vector of the luminance that was taken.
    pub direction: DVec3,
    /// Irradiance at normal incidence of each channel: the part of its vector along the direction.
    pub irradiance: DVec3,
    /// Integral of the luminance.
    pub flux: f64,
    /// That of a light of the same radiance everywhere with the same flux and the same square of it.
    pub solid_angle: f64,
    /// Angle from the direction within which all lies that was taken.
    pub reach: f64,
    /// Vector irradiance of each channel.
    pub vectors: DMat3,
}

/// Take the lights in their pixels of the working image, whose cells are `working`, out of the `rest`, a copy of the
/// map. A light of which nothing is taken keeps the direction in which it was `found`.
pub fn take(
    map: &Map<'_>,
    working: &Cells,
    regions: &Regions,
    found: &[DVec3],
    rest: &mut [[f32; 3]],
) -> Vec<Taken> {
    let level = map.membrane;
    let [holes, glow] = [&regions.holes, &regions.glow]
        .map(|lights| lights.iter().map(|pixels| runs(pixels, level.size.1)).collect::<Vec<_>>());
    let bands = Bands::new(&holes, level.size.0);
    let dimmed = dim(map, &Bands::new(&glow, level.size.0), rest);
    let closed = close_but_dark_channels(map, &bands, rest);
    let lights = || (0..found.len()).into_par_iter();
    let tilts = |i: usize| tilts(&closed[i].and(dimmed[i]), found[i], level, working, &holes[i]);
    let tilts: Vec<[DVec3; 3]> = lights().map(tilts).collect();
    let closed = tilt(map, &bands, &tilts, closed, rest);
    let taken = |i: usize| {
        let pixels = || holes[i].iter().chain(&glow[i]);
        light(&closed[i].and(dimmed[i]), found[i], |axis| reach(working, pixels(), axis))
    };
    lights().map(taken).collect()
}

/// Close the pixels. In a channel of which the membrane holds more than the light, take nothing from any pixel that is
/// darker.
///
/// So a red lamp before a white wall takes no negative blue with it.
fn close_but_dark_channels(map: &Map<'_>, bands: &Bands, rest: &mut [[f32; 3]]) -> Vec<Loss> {
    let mut losses = close(map, bands, &vec![[false; 3]; bands.lights], rest);
    let is_dark = |loss: &Loss| loss.vectors.map(|vector| vector.dot(loss.toward()) < 0.0);
    let dark: Vec<[bool; 3]> = losses.iter().map(is_dark).collect();
    let has_dark: Vec<bool> = dark.iter().map(|dark| dark.contains(&true)).collect();
    let again = close(map, &bands.of(&has_dark), &dark, rest);
    let changed = losses.iter_mut().zip(again).zip(has_dark).filter(|(_, has_dark)| *has_dark);
    changed.for_each(|((loss, again), _)| *loss = again);
    losses
}

/// The light that was lost; it keeps the direction in which it was `found` where that is nothing.
fn light(loss: &Loss, found: DVec3, reach: impl Fn(DVec3) -> f64) -> Taken {
    let (flux, squares) = (loss.flux, loss.squares);
    let direction = loss.toward().try_normalize().unwrap_or(found);
    let [red, green, blue] = loss.vectors;
    Taken {
        direction,
        irradiance: DVec3::from_array(loss.vectors.map(|vector| vector.dot(direction).max(0.0))),
        flux,
        solid_angle: if squares > 0.0 { flux * flux / squares } else { 0.0 },
        reach: if flux > 0.0 { reach(direction) } else { 0.0 },
        vectors: DMat3::from_cols(red, green, blue),
    }
}

/// Angle from a direction within which some pixels of the working image lie.
fn reach<'a>(working: &Cells, pixels: impl Iterator<Item = &'a Run>, direction: DVec3) -> f64 {
    let cosines = pixels.flat_map(|run| working.dot_products(run, direction));
    let least = cosines.fold(1.0, f64::min);
    least.max(-1.0).acos() + working.half_diagonal()
}
