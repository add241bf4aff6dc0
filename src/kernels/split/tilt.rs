//! A tilt of what is left of a light's pixels, so that what was taken has one direction.
//!
//! Closed pixels leave `M`, and take vectors that are nearly parallel. With the bump `b` of the membrane and the place
//! `t` of a pixel across the light's direction, each channel is tilted to
//!
//! ```text
//!   L' = M (1 + b k.t)      with k so that      integral of (L - L') t dw = 0
//! ```
//!
//! which is linear in k: two sums over the pixels tell it, that of `(L - M) t` and that of `M b t t^T`. Neither needs
//! the direction, for `t` is the direction of a pixel without its part along that of the light.
//!
//! For a sun whose glare is around it, tilts of a few per cent do. A window that is blue above and green below would
//! need so much that it showed as a colour: no single direction stands for it. Such a channel is not tilted, and its
//! vector tells what is left across the direction. That has no luminance, for the direction is that of the luminance
//! taken.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use glam::{DMat2, DMat3, DVec2, DVec3};
use pulp::{Arch, Simd, WithSimd};

use super::cells::{Cells, Columns, Row};
use super::level::Level;
use super::loss::Loss;
use super::moments::Luminances;
use super::pixels::{Bands, Map, Slab};
use super::planes::Planes;
use super::stretched::Stretched;
use crate::kernels::detect::segment::run::Run;
use crate::kernels::sphere::tangents;

/// The largest tilt, as a share of the radiance, at the middle of a pixel of the working image. Of 20 maps, the suns
/// need .08 to .26, and windows .7 to 27.
const LARGEST_TILT: f64 = 0.3;
/// Across the axis, less than this share of a vector is the rounding of samples.
const ROUNDING: f64 = 1e-7;

/// A vector `k` for each channel: the tilt that makes its vector parallel to that of the luminance, 0 where that would
/// show in a pixel of the working image in the `hole`.
pub fn tilts(loss: &Loss, found: DVec3, membrane: &Level, working: &Cells, hole: &[Run]) -> [DVec3; 3] {
    let axis = loss.toward().try_normalize().unwrap_or(found);
    let across = tangents(axis);
    array::from_fn(|channel| {
        let (vector, tensor) = (loss.vectors[channel], loss.tensors[channel]);
        let moment = DVec2::from(across.map(|side| vector.dot(side)));
        let tilt = solved(tensor, moment, across);
        let is_aligned = moment.length() <= ROUNDING * vector.length();
        // A slope that is not a number is none: nothing is left that could be tilted.
        let is_small = || tilt.is_finite() && steepest(membrane, working, hole, tilt) <= LARGEST_TILT;
        if !is_aligned && is_small() { tilt } else { DVec3::ZERO }
    })
}

/// The tilt across an axis that takes a moment away.
fn solved(tensor: DMat3, moment: DVec2, across: [DVec3; 2]) -> DVec3 {
    let column = |side| DVec2::from(across.map(|other| other.dot(tensor * side)));
    let slope = DMat2::from_cols(column(across[0]), column(across[1])).inverse() * moment;
    slope.x * across[0] + slope.y * across[1]
}

/// Largest change by a tilt in some pixels of the working image.
fn steepest(membrane: &Level, working: &Cells, hole: &[Run], tilt: DVec3) -> f64 {
    let changes = |run: &Run| {
        let values = &membrane.values[run.pixels(membrane.size.1)];
        let changes = values.iter().zip(working.dot_products(run, tilt));
        changes.map(|(value, dot)| (f64::from(value[3]) * dot).abs()).fold(0.0, f64::max)
    };
    hole.iter().map(changes).fold(0.0, f64::max)
}

/// Tilt what is left in the `rest` of the lights that have a tilt, of which so much was lost when they were `closed`; what
/// each light loses then.
pub fn tilt(
    map: &Map<'_>,
    bands: &Bands,
    tilts: &[[DVec3; 3]],
    mut closed: Vec<Loss>,
    rest: &mut [[f32; 3]],
) -> Vec<Loss> {
    let is_tilted: Vec<bool> = tilts.iter().map(|tilts| *tilts != [DVec3::ZERO; 3]).collect();
    let left = map.loss_of_each(&bands.of(&is_tilted), rest, |light, runs, slab| {
        Arch::new().dispatch(Tilted { map, runs, tilts: &tilts[light], slab })
    });
    for light in (0..closed.len()).filter(|&light| is_tilted[light]) {
        let Loss { vectors, tensors, .. } = closed[light];
        let vectors = array::from_fn(|channel| vectors[channel] - tensors[channel] * tilts[light][channel]);
        closed[light] = Loss { vectors, tensors, ..left[light] };
    }
    closed
}

/// Closed pixels of a light that are tilted.
struct Tilted<'a, 'b> {
    map: &'a Map<'a>,
    runs: &'a [Run],
    tilts: &'a [DVec3; 3],
    slab: &'a mut Slab<'b>,
}

impl WithSimd for Tilted<'_, '_> {
    /// The luminance that is taken; no vectors.
    type Output = Loss;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Loss {
        let Self { map, runs, tilts, slab } = self;
        let (mut loss, mut taken, mut membrane) = (Loss::NONE, Luminances::default(), Stretched::default());
        let (mut given, mut left, mut bump) = (Planes::default(), Planes::default(), Planes::default());
        for strip in map.strips(runs) {
            let columns = map.cells.columns(strip.columns.clone());
            let pixels = columns.width.len();
            given.start(pixels);
            left.start(pixels);
            bump.start(pixels);
            taken.start(pixels);
            membrane.stretch(map.membrane, map.block, &strip.behind, pixels, strip.rows.start);
            for row in strip.rows.clone() {
                let cells = &map.cells.rows[row];
                membrane.row(row, &mut bump);
                given.read(map.given(row, &strip));
                left.read(slab.at(row, &strip));
                tilt_row(tilts, cells, &columns, &bump, &mut left);
                left.write(slab.at(row, &strip));
                given.luminance_without(&left, taken.row());
                taken.add(cells);
            }
            let (flux, squares) = taken.integrals(&columns);
            loss = loss.and(Loss { flux, squares, ..Loss::NONE });
        }
        loss
    }
}

/// Tilt each channel of what is left in a row.
#[inline(always)]
fn tilt_row(
    tilts: &[DVec3; 3],
    cells: &Row,
    columns: &Columns<&[f64]>,
    bump: &Planes<1>,
    left: &mut Planes<3>,
) {
    let [bump] = bump.channels();
    for (left, tilt) in left.channels_mut().into_iter().zip(tilts).filter(|(_, tilt)| **tilt != DVec3::ZERO) {
        // Factors of the sine and the cosine of the column, and what is even: the mean direction over the row.
        let [sin, cos, even] = [tilt.x * cells.squares, -tilt.z * cells.squares, tilt.y * cells.products]
            .map(|factor| (factor / cells.band) as f32);
        let directions = columns.mean_sin.iter().zip(columns.mean_cos);
        for ((left, bump), (&sine, &cosine)) in left.iter_mut().zip(bump).zip(directions) {
            let tilt = sin * sine as f32 + cos * cosine as f32 + even;
            *left = (*left + *left * (bump * tilt)).min(f32::MAX);
        }
    }
}
