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

use std::array;

use glam::{BVec4A, DMat2, DMat3, DVec2, DVec3, Vec4, Vec4Swizzles};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::cells::{Cells, Row};
use super::glow::share_left;
use super::level::Level;
use super::moments::{First, Second};
use super::pixels::{Map, Part, Slab};
use crate::kernels::image::{LUMINANCE, LUMINANCE_F32};
use crate::kernels::sphere::tangents;

/// The largest tilt, as a share of the radiance, at the middle of a pixel of the working image. Of 20 maps, the suns
/// need .08 to .26, and windows .7 to 27.
const LARGEST_TILT: f64 = 0.3;
/// Across the axis, less than this share of a vector is the rounding of samples.
const ROUNDING: f64 = 1e-7;

/// Weights of a pixel's channels in its luminance.
const LUMINANCE_OF_RGB: Vec4 = Vec4::new(LUMINANCE_F32[0], LUMINANCE_F32[1], LUMINANCE_F32[2], 0.0);

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

/// How much of each pixel is left.
#[derive(Default)]
struct Rule {
    /// Whether nothing is taken of a channel where it is darker than the membrane.
    is_dark: BVec4A,
    /// A vector for each channel: what is left changes by the share `bump * tilt.d` in the direction `d`.
    tilts: [DVec3; 3],
}

/// Pixels of the working image of which a light is taken: those that are closed, and its glow.
pub struct Pixels<'a> {
    pub hole: &'a [u32],
    pub glow: &'a [u32],
}

/// Take the light in some pixels of the working image, whose cells are `working`, out of the `rest`. Where nothing is
/// taken, it keeps the direction in which it was `found`.
pub fn take(
    map: &Map<'_>,
    working: &Cells,
    pixels: &Pixels<'_>,
    found: DVec3,
    rest: &mut [[f32; 3]],
) -> Taken {
    let parts = map.parts(pixels.hole);
    let glow = dim(map, &map.parts(pixels.glow), rest);
    let (rule, sums) = keep_dark_channels(map, &parts);
    let sums = sums.and(glow.sums);
    let axis = toward(&sums.vectors).try_normalize().unwrap_or(found);
    let tilts = sums.tilts(axis, |tilt| steepest(map.membrane.level, working, pixels.hole, tilt));
    let flux = glow.flux.and(leave(map, &parts, &Rule { tilts, ..rule }, rest));
    let reach = |direction| reach(working, map.membrane.level.size.1, pixels, direction);
    flux.light(sums.tilted(&tilts), found, reach)
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
fn reach(working: &Cells, columns: usize, pixels: &Pixels<'_>, direction: DVec3) -> f64 {
    let cosine = |place: usize| direction.dot(working.mean(place / columns, place % columns));
    let least =
        pixels.hole.iter().chain(pixels.glow).map(|&place| cosine(place as usize)).fold(1.0, f64::min);
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
    fn closed(&self, given: Vec4, fill: Vec4) -> Vec4 {
        // By masks in place of branches: in an even sky, no processor can tell which way the next pixel goes.
        let is_brighter = Vec4::splat((given - fill).dot(LUMINANCE_OF_RGB)).cmpgt(Vec4::ZERO);
        let fill = Vec4::select(self.is_dark, fill.min(given), fill);
        Vec4::select(is_brighter, fill, given)
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
    const NONE: Self = Self { vectors: [DVec3::ZERO; 3], tensors: [DMat3::ZERO; 3] };

    fn of(map: &Map<'_>, parts: &[Part], rule: &Rule) -> Self {
        let sum = |part| Arch::new().dispatch(SumsOf { map, part, rule });
        let sums: Vec<Self> = parts.par_iter().map(sum).collect();
        sums.into_iter().fold(Self::NONE, Self::and)
    }

    #[inline(always)]
    fn and(mut self, other: Self) -> Self {
        self.vectors.iter_mut().zip(other.vectors).for_each(|(sum, vector)| *sum += vector);
        self.tensors.iter_mut().zip(other.tensors).for_each(|(sum, tensor)| *sum += tensor);
        self
    }

    /// The tilt of each channel that makes its vector parallel to `axis`, where its `steepest` change is small.
    fn tilts(&self, axis: DVec3, steepest: impl Fn(DVec3) -> f64) -> [DVec3; 3] {
        let across = tangents(axis);
        array::from_fn(|channel| {
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

    /// The vectors of what is taken after these tilts.
    fn tilted(&self, tilts: &[DVec3; 3]) -> [DVec3; 3] {
        array::from_fn(|channel| self.vectors[channel] - self.tensors[channel] * tilts[channel])
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
        let Self { map, part, rule } = self;
        let (mut sums, mut first, mut second) = (Sums::NONE, First::default(), Second::default());
        let (mut room, mut left, mut bumped) = (Vec::new(), Vec::new(), Vec::new());
        for strip in map.strips(part) {
            first.start(3 * strip.columns.len());
            second.start(3 * strip.columns.len());
            left.resize(strip.columns.len(), [0.0; 3]);
            bumped.resize(strip.columns.len(), [0.0; 3]);
            for row in strip.rows.clone() {
                let given = map.given(row, &strip);
                let fill = map.membrane.row(row, &strip.behind, &mut room);
                let pixels = given.iter().zip(fill.values());
                for ((left, bumped), (&given, fill)) in left.iter_mut().zip(&mut bumped).zip(pixels) {
                    let closed = rule.closed(rgb(given), fill);
                    *left = closed.truncate().to_array();
                    *bumped = (closed * fill.wwww()).truncate().to_array();
                }
                first.add(given, &left, &map.cells.rows[row]);
                second.add(&bumped, &map.cells.rows[row]);
            }
            let columns = map.cells.columns(strip.columns);
            sums = sums.and(Sums { vectors: first.vectors(&columns), tensors: second.tensors(&columns) });
        }
        sums
    }
}

#[inline(always)]
fn rgb([red, green, blue]: [f32; 3]) -> Vec4 {
    Vec4::new(red, green, blue, 0.0)
}

/// Integrals of the luminance that is taken, and of its square.
#[derive(Clone, Copy)]
struct Flux {
    whole: f64,
    squares: f64,
}

impl Flux {
    const NONE: Self = Self { whole: 0.0, squares: 0.0 };

    fn and(self, other: Self) -> Self {
        Self { whole: self.whole + other.whole, squares: self.squares + other.squares }
    }

    /// Add what is taken of a pixel, of this solid angle.
    #[inline(always)]
    fn add(&mut self, taken: Vec4, solid_angle: f64) {
        let luminance = f64::from(taken.dot(LUMINANCE_OF_RGB));
        self.whole += solid_angle * luminance;
        self.squares += solid_angle * luminance * luminance;
    }

    /// The light of this flux and these vectors.
    fn light(self, vectors: [DVec3; 3], found: DVec3, reach: impl Fn(DVec3) -> f64) -> Taken {
        let Self { whole: flux, squares } = self;
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

/// What was taken of a glow.
struct Glow {
    sums: Sums,
    flux: Flux,
}

impl Glow {
    const NONE: Self = Self { sums: Sums::NONE, flux: Flux::NONE };
}

/// Leave of each pixel of a glow in the `rest` what may stay.
fn dim(map: &Map<'_>, parts: &[Part], rest: &mut [[f32; 3]]) -> Glow {
    let parts = parts.par_iter().zip(map.slabs(parts, rest));
    let dimmed = |(part, slab)| Arch::new().dispatch(Dimmed { map, part, slab });
    let glows: Vec<Glow> = parts.map(dimmed).collect();
    glows.into_iter().fold(Glow::NONE, |whole, part| Glow {
        sums: whole.sums.and(part.sums),
        flux: whole.flux.and(part.flux),
    })
}

/// What is left of the glow in a part.
struct Dimmed<'a> {
    map: &'a Map<'a>,
    part: &'a Part,
    slab: Slab<'a>,
}

impl WithSimd for Dimmed<'_> {
    type Output = Glow;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Glow {
        let Self { map, part, mut slab } = self;
        let (mut glow, mut first) = (Glow::NONE, First::default());
        for strip in map.strips(part) {
            first.start(3 * strip.columns.len());
            let means = map.cells.means(strip.columns.clone());
            for row in strip.rows.clone() {
                let (cells, given) = (&map.cells.rows[row], map.given(row, &strip));
                let rest = slab.at(row, &strip);
                for ((rest, &given), mean) in rest.iter_mut().zip(given).zip(means) {
                    let given = rgb(given);
                    let left = given * share_left(given.dot(LUMINANCE_OF_RGB), map.threshold);
                    *rest = left.truncate().to_array();
                    glow.flux.add(given - left, cells.band * mean[2]);
                }
                first.add(given, rest, cells);
            }
            let vectors = first.vectors(&map.cells.columns(strip.columns));
            glow.sums = glow.sums.and(Sums { vectors, ..Sums::NONE });
        }
        glow
    }
}

/// Leave of each pixel in the `rest` what the rule says.
fn leave(map: &Map<'_>, parts: &[Part], rule: &Rule, rest: &mut [[f32; 3]]) -> Flux {
    let parts = parts.par_iter().zip(map.slabs(parts, rest));
    let left = |(part, slab)| Arch::new().dispatch(Left { map, part, rule, slab });
    let parts: Vec<Flux> = parts.map(left).collect();
    parts.into_iter().fold(Flux::NONE, Flux::and)
}

/// What is left of a part.
struct Left<'a> {
    map: &'a Map<'a>,
    part: &'a Part,
    rule: &'a Rule,
    slab: Slab<'a>,
}

impl WithSimd for Left<'_> {
    type Output = Flux;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Flux {
        let Self { map, part, rule, mut slab } = self;
        let (mut flux, mut room) = (Flux::NONE, Vec::new());
        for strip in map.strips(part) {
            let means = map.cells.means(strip.columns.clone());
            for row in strip.rows.clone() {
                let (cells, given) = (&map.cells.rows[row], map.given(row, &strip));
                let fill = map.membrane.row(row, &strip.behind, &mut room);
                let tilt = RowTilt::new(&rule.tilts, cells);
                let pixels = given.iter().zip(fill.values()).zip(means);
                for (rest, ((&given, fill), &mean)) in slab.at(row, &strip).iter_mut().zip(pixels) {
                    let left = tilt.of(rule.closed(rgb(given), fill), fill.wwww(), mean);
                    *rest = left.truncate().to_array();
                    flux.add(rgb(given) - left, cells.band * mean[2]);
                }
            }
        }
        flux
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
    fn of(&self, closed: Vec4, bump: Vec4, [sin, cos, _]: [f64; 3]) -> Vec4 {
        let tilt = self.sin * sin as f32 + self.cos * cos as f32 + self.even;
        (closed + closed * (bump * tilt)).min(Vec4::splat(f32::MAX))
    }
}
