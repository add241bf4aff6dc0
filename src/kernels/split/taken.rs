//! What is taken from the pixels of a light, so that it has one direction.
//!
//! A pixel that is brighter than the membrane becomes the membrane; one that is darker stays. That leaves `M`,
//! and takes vectors that are nearly parallel. With the bump `b` of the membrane and the place `t` of a pixel across
//! the light's direction, each channel is tilted to
//!
//! ```text
//!   L' = M (1 + b k.t)      with k so that      integral of (L - L') t dw = 0
//! ```
//!
//! which is linear in k: two sums over the pixels tell it, that of `(L - M) t` and that of `M b t t^T`. Neither needs
//! the direction, for `t` is the direction of a pixel without its part along that of the light. So the pixels of a
//! light are read twice, once for the sums and once to be tilted.
//!
//! For a sun whose glare is around it, tilts of a few per cent do. A window that is blue above and green below would
//! need so much that it showed as a colour: no single direction stands for it. Such a channel is not tilted, and its
//! vector tells what is left across the direction. That has no luminance, for the direction is that of the luminance
//! taken.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use glam::{BVec4A, DMat2, DMat3, DVec2, DVec3, Vec4};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::cells::{Cells, Row};
use super::level::{Level, Value};
use super::moments;
use super::pixels::{Map, Part, RowOfPixels};
use crate::kernels::detect::tree::dot;
use crate::kernels::image::{LUMINANCE, luminance_f32};
use crate::kernels::sphere::tangents;

/// The largest tilt, as a share of the radiance, at the middle of a pixel of the working image. Of 20 maps, the suns
/// need .08 to .26, and windows .7 to 27.
const LARGEST_TILT: f64 = 0.3;
/// Across the axis, less than this share of a vector is the rounding of samples.
const ROUNDING: f64 = 1e-7;

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

/// Room for pixels of lights: their flat indices, and what is left of them.
pub struct Room<'a> {
    pub pixels: &'a mut [i64],
    pub left: &'a mut [[f32; 3]],
}

impl<'a> Room<'a> {
    /// The first so many places, which the room has no more then.
    fn for_pixels(&mut self, count: usize) -> Room<'a> {
        let (pixels, other_pixels) = std::mem::take(&mut self.pixels).split_at_mut(count);
        let (left, other_left) = std::mem::take(&mut self.left).split_at_mut(count);
        *self = Room { pixels: other_pixels, left: other_left };
        Room { pixels, left }
    }
}

/// How much of each pixel is left.
#[derive(Default)]
struct Rule {
    /// Whether nothing is taken of a channel where it is darker than the membrane.
    is_dark: BVec4A,
    /// A vector for each channel: what is left changes by the share `bump * tilt.d` in the direction `d`.
    tilts: [DVec3; 3],
}

/// Take the light in some pixels of the working image, whose cells are `working`. Where nothing is taken, it keeps the
/// direction in which it was `found`.
pub fn take(
    map: &Map<'_>,
    working: &Cells,
    region: &[u32],
    parts: &[Part],
    found: DVec3,
    room: &mut Room<'_>,
) -> Taken {
    let (rule, sums) = keep_dark_channels(map, parts);
    let axis = toward(&sums.vectors).try_normalize().unwrap_or(found);
    let tilts = sums.tilts(axis, |tilt| steepest(map.membrane.level, working, region, tilt));
    let reach = |direction| reach(working, map.membrane.level.size.1, region, direction);
    leave(map, parts, &Rule { tilts, ..rule }, room).measured(found, reach)
}

/// In a channel of which the membrane holds more than the light, take nothing from any pixel that is darker.
///
/// So a red lamp before a white wall takes no negative blue with it.
fn keep_dark_channels(map: &Map<'_>, parts: &[Part]) -> (Rule, Sums) {
    let sums = Sums::of(map, parts, &Rule::default());
    let axis = toward(&sums.vectors);
    let is_dark = sums.vectors.map(|vector| vector.dot(axis) < 0.0);
    let rule = Rule { is_dark: BVec4A::new(is_dark[0], is_dark[1], is_dark[2], false), ..Rule::default() };
    let sums = if is_dark.contains(&true) { Sums::of(map, parts, &rule) } else { sums };
    (rule, sums)
}

/// The vector of the luminance, from those of the channels.
fn toward(vectors: &[DVec3; 3]) -> DVec3 {
    vectors.iter().zip(LUMINANCE).map(|(vector, weight)| weight * *vector).sum()
}

/// Angle from a direction within which some pixels of the working image lie.
fn reach(working: &Cells, columns: usize, region: &[u32], direction: DVec3) -> f64 {
    let cosine = |place: usize| direction.dot(working.mean(place / columns, place % columns));
    let least = region.iter().map(|&place| cosine(place as usize)).fold(1.0, f64::min);
    least.max(-1.0).acos() + working.half_diagonal()
}

/// Largest change by a tilt in some pixels of the working image.
fn steepest(membrane: &Level, working: &Cells, region: &[u32], tilt: DVec3) -> f64 {
    let change = |place: usize| {
        let (row, column) = (place / membrane.size.1, place % membrane.size.1);
        (f64::from(membrane.values[place][3]) * tilt.dot(working.mean(row, column))).abs()
    };
    region.iter().map(|&place| change(place as usize)).fold(0.0, f64::max)
}

impl Rule {
    /// What is left of a pixel before the tilt.
    #[inline(always)]
    fn closed(&self, given: [f32; 3], fill: Value) -> [f32; 3] {
        // By masks in place of branches: in an even sky, no processor can tell which way the next pixel goes.
        let [given_luminance, luminance] =
            [given, [fill[0], fill[1], fill[2]]].map(|pixel| Vec4::splat(luminance_f32(pixel)));
        let (given, fill) = (Vec4::new(given[0], given[1], given[2], 0.0), Vec4::from_array(fill));
        let fill = Vec4::select(self.is_dark, fill.min(given), fill);
        Vec4::select(given_luminance.cmpgt(luminance), fill, given).truncate().to_array()
    }
}

/// What is taken, before any tilt, and what a tilt would change.
struct Sums {
    /// Vector irradiance of what is taken.
    vectors: [DVec3; 3],
    /// Second moments of what is left, times the bump.
    tensors: [DMat3; 3],
}

impl Sums {
    fn of(map: &Map<'_>, parts: &[Part], rule: &Rule) -> Self {
        let sum = |part| Arch::new().dispatch(SumsOf { map, part, rule });
        let sums: Vec<Self> = parts.par_iter().map(sum).collect();
        let mut whole = Self { vectors: [DVec3::ZERO; 3], tensors: [DMat3::ZERO; 3] };
        for part in sums {
            add(&mut whole.vectors, part.vectors);
            add(&mut whole.tensors, part.tensors);
        }
        whole
    }

    /// The tilt of each channel that makes its vector parallel to `axis`, where its `steepest` change is small.
    fn tilts(&self, axis: DVec3, steepest: impl Fn(DVec3) -> f64) -> [DVec3; 3] {
        let across = tangents(axis);
        std::array::from_fn(|channel| {
            let (vector, tensor) = (self.vectors[channel], self.tensors[channel]);
            let moment = DVec2::from(across.map(|side| vector.dot(side)));
            let column = |side| DVec2::from(across.map(|other| other.dot(tensor * side)));
            let slope = DMat2::from_cols(column(across[0]), column(across[1])).inverse() * moment;
            let tilt = slope.x * across[0] + slope.y * across[1];
            let is_aligned = moment.length() <= ROUNDING * vector.length();
            // A slope that is not a number is none: nothing is left that could be tilted.
            if !is_aligned && tilt.is_finite() && steepest(tilt) <= LARGEST_TILT { tilt } else { DVec3::ZERO }
        })
    }
}

/// The sums of a part.
struct SumsOf<'a> {
    map: &'a Map<'a>,
    part: &'a Part,
    rule: &'a Rule,
}

impl WithSimd for SumsOf<'_> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sums {
        let mut sums = Sums { vectors: [DVec3::ZERO; 3], tensors: [DMat3::ZERO; 3] };
        let (mut fill, mut left, mut taken, mut kept) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for place in self.map.rows(self.part) {
            let RowOfPixels { given, row, columns, .. } = self.map.row(&place, &mut fill);
            let pixels = given.iter().zip(&fill);
            refill(&mut left, pixels.map(|(&given, &fill)| self.rule.closed(given, fill)));
            for channel in 0..3 {
                take_from(&mut taken, given, &left, channel);
                let pixels = left.iter().zip(&fill);
                refill(&mut kept, pixels.map(|(left, fill)| left[channel] * fill[3]));
                sums.vectors[channel] += moments::first(&taken, row, &columns);
                sums.tensors[channel] += moments::second(&kept, row, &columns);
            }
        }
        sums
    }
}

/// Add to the sum of each channel.
fn add<T: std::ops::AddAssign>(sums: &mut [T; 3], terms: [T; 3]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// What is taken of a channel of each pixel.
#[inline(always)]
fn take_from(taken: &mut Vec<f64>, given: &[[f32; 3]], left: &[[f32; 3]], channel: usize) {
    let pixels = given.iter().zip(left);
    refill(taken, pixels.map(|(given, left)| f64::from(given[channel]) - f64::from(left[channel])));
}

#[inline(always)]
fn refill<T>(values: &mut Vec<T>, new: impl Iterator<Item = T>) {
    values.clear();
    values.extend(new);
}

/// What was taken, after all rounding.
struct Measures {
    vectors: [DVec3; 3],
    /// Integral of the luminance, and of its square.
    flux: f64,
    squares: f64,
}

impl Measures {
    const NONE: Self = Self { vectors: [DVec3::ZERO; 3], flux: 0.0, squares: 0.0 };

    fn and(mut self, other: &Self) -> Self {
        add(&mut self.vectors, other.vectors);
        Self { flux: self.flux + other.flux, squares: self.squares + other.squares, ..self }
    }

    fn measured(&self, found: DVec3, reach: impl Fn(DVec3) -> f64) -> Taken {
        let Self { vectors, flux, squares } = *self;
        let direction = toward(&vectors).try_normalize().unwrap_or(found);
        Taken {
            direction,
            irradiance: DVec3::from_array(vectors.map(|vector| vector.dot(direction).max(0.0))),
            flux,
            solid_angle: if squares > 0.0 { flux * flux / squares } else { 0.0 },
            reach: if flux > 0.0 { reach(direction) } else { 0.0 },
            vectors: DMat3::from_cols(vectors[0], vectors[1], vectors[2]),
        }
    }
}

/// Leave of each pixel what the rule says.
fn leave(map: &Map<'_>, parts: &[Part], rule: &Rule, room: &mut Room<'_>) -> Measures {
    let rooms: Vec<Room<'_>> = parts.iter().map(|part| room.for_pixels(part.pixels)).collect();
    let parts = parts.par_iter().zip(rooms);
    let left = |(part, room)| Arch::new().dispatch(Left { map, part, rule, room });
    let measures: Vec<Measures> = parts.map(left).collect();
    measures.iter().fold(Measures::NONE, Measures::and)
}

/// What is left of a part.
struct Left<'a> {
    map: &'a Map<'a>,
    part: &'a Part,
    rule: &'a Rule,
    room: Room<'a>,
}

impl WithSimd for Left<'_> {
    type Output = Measures;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Measures {
        let Self { map, part, rule, mut room } = self;
        let mut measures = Measures::NONE;
        let (mut fill, mut taken, mut luminance) = (Vec::new(), Vec::new(), Vec::new());
        for place in map.rows(part) {
            let RowOfPixels { first, given, row, columns } = map.row(&place, &mut fill);
            let Room { pixels, left } = room.for_pixels(given.len());
            pixels.iter_mut().zip(first..).for_each(|(pixel, index)| *pixel = index as i64);
            let tilt = RowTilt::new(&rule.tilts, row);
            for ((left, (&given, &fill)), column) in left.iter_mut().zip(given.iter().zip(&fill)).zip(0..) {
                *left = tilt.of(
                    rule.closed(given, fill),
                    fill[3],
                    columns.mean_sin[column],
                    columns.mean_cos[column],
                );
            }
            refill(&mut luminance, given.iter().map(|_| 0.0));
            for (channel, weight) in LUMINANCE.into_iter().enumerate() {
                take_from(&mut taken, given, left, channel);
                measures.vectors[channel] += moments::first(&taken, row, &columns);
                luminance.iter_mut().zip(&taken).for_each(|(sum, taken)| *sum += weight * taken);
            }
            measures.flux += row.band * dot(&luminance, columns.width);
            refill(&mut taken, luminance.iter().map(|value| value * value));
            measures.squares += row.band * dot(&taken, columns.width);
        }
        measures
    }
}

/// The tilt of each channel along a row: factors of the sine and the cosine of the column, and what is even.
struct RowTilt {
    sin: Vec4,
    cos: Vec4,
    even: Vec4,
}

impl RowTilt {
    #[inline(always)]
    fn new(tilts: &[DVec3; 3], row: &Row) -> Self {
        let of = |factor: fn(DVec3) -> f64, integral: f64| {
            let share = integral / row.band;
            let [red, green, blue] = tilts.map(|tilt| (share * factor(tilt)) as f32);
            Vec4::new(red, green, blue, 0.0)
        };
        Self {
            sin: of(|tilt| tilt.x, row.squares),
            cos: of(|tilt| -tilt.z, row.squares),
            even: of(|tilt| tilt.y, row.products),
        }
    }

    #[inline(always)]
    fn of(&self, closed: [f32; 3], bump: f32, sin: f64, cos: f64) -> [f32; 3] {
        let closed = Vec4::new(closed[0], closed[1], closed[2], 0.0);
        let tilt = self.sin * sin as f32 + self.cos * cos as f32 + self.even;
        (closed + closed * (bump * tilt)).min(Vec4::splat(f32::MAX)).truncate().to_array()
    }
}
