//! Moments and derivatives of several sets of lights, each in a lane of its own.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::kernel::{Block, mixed_derivatives};
use crate::kernels::fit::lanes::{LANES, Lanes};
use crate::kernels::fit::objective::{Given, MomentsAbreast};
use crate::kernels::fit::wide::{Matrix, Wide};
use crate::kernels::sphere::tangents;

/// What [`Objective::abreast`](crate::kernels::fit::Objective::abreast) asks for.
pub struct Asked<'a> {
    pub given: &'a Given,
    pub sets: &'a [Vec<DVec3>; LANES],
    /// `<v_l, y>` of each light and side, set after set.
    pub sides: [Vec<DVec3>; LANES],
    pub fixed: usize,
}

impl WithSimd for Asked<'_> {
    type Output = MomentsAbreast;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> MomentsAbreast {
        let Self { given, sets, sides, fixed } = self;
        let (ambient, channels) = (given.ambient.coefficients(), given.channels.len());
        let lights = sets.iter().map(Vec::len).max().unwrap_or(0);
        let (columns, turns) = (ambient + lights, 2 * (lights - fixed));
        let mut abreast = MomentsAbreast {
            frames: array::from_fn(|lane| sets[lane].iter().map(|&l| tangents(l)).collect()),
            gram: Matrix::zeros(columns, columns),
            rhs: Matrix::zeros(channels, columns),
            model: Matrix::zeros(columns, turns),
            both: Matrix::zeros(turns, turns),
            slopes: Matrix::zeros(channels, turns),
        };
        add_ambient(given, &mut abreast);
        for (lane, (set, sides)) in sets.iter().zip(&sides).enumerate() {
            for (light, (&l, sides)) in set.iter().zip(sides.chunks(given.sides().max(1))).enumerate() {
                add_sides(&mut abreast, lane, ambient, fixed, light, l, sides);
            }
        }
        add_lights(simd, sets, &mut abreast, ambient, fixed);
        abreast
    }
}

/// What the ambient columns have in common with each other and the irradiance.
fn add_ambient(given: &Given, abreast: &mut MomentsAbreast) {
    let ambient = given.ambient.coefficients();
    for i in 0..ambient {
        for k in 0..ambient {
            abreast.gram[(i, k)] = Wide::splat(given.ambient_products[(i, k)]);
        }
        for channel in 0..given.channels.len() {
            abreast.rhs[(channel, i)] = Wide::splat(given.ambient_products[(i, ambient + channel)]);
        }
    }
}

/// What a light of one lane has in common with the `sides`: the ambient columns and the irradiance.
#[inline(always)]
fn add_sides(
    MomentsAbreast { frames, gram, rhs, model, slopes, .. }: &mut MomentsAbreast,
    lane: usize,
    ambient: usize,
    fixed: usize,
    light: usize,
    l: DVec3,
    sides: &[DVec3],
) {
    let frame = frames[lane][light];
    let turn = if light < fixed { 0..0 } else { 2 * (light - fixed)..2 * (light - fixed + 1) };
    for (column, side) in sides[..ambient].iter().enumerate() {
        gram[(ambient + light, column)].0[lane] = side.dot(l);
        gram[(column, ambient + light)].0[lane] = side.dot(l);
        for a in turn.clone() {
            model[(column, a)].0[lane] = side.dot(frame[a % 2]);
        }
    }
    for (channel, side) in sides[ambient..].iter().enumerate() {
        rhs[(channel, ambient + light)].0[lane] = side.dot(l);
        for a in turn.clone() {
            slopes[(channel, a)].0[lane] = side.dot(frame[a % 2]);
        }
    }
}

/// What the lights of each lane have in common with each other.
#[inline(always)]
fn add_lights<S: Simd>(
    simd: S,
    sets: &[Vec<DVec3>; LANES],
    abreast: &mut MomentsAbreast,
    ambient: usize,
    fixed: usize,
) {
    let lights = abreast.gram.rows() - ambient;
    let mut axes = Vec::with_capacity(lights);
    for light in 0..lights {
        axes.push([
            gathered(sets, |set| set.get(light).copied()),
            gathered(&abreast.frames, |frame| frame.get(light).map(|frame| frame[0])),
            gathered(&abreast.frames, |frame| frame.get(light).map(|frame| frame[1])),
        ]);
    }
    let MomentsAbreast { gram, model, both, .. } = abreast;
    for j in 0..lights {
        for k in 0..=j {
            for i in 0..Lanes::<S>::VECTORS {
                let mixed = mixed_derivatives(&frames_at(simd, &axes[j], i), &frames_at(simd, &axes[k], i));
                mixed.value.write(&mut gram[(ambient + j, ambient + k)].0, i);
                mixed.value.write(&mut gram[(ambient + k, ambient + j)].0, i);
                if j < fixed {
                    continue;
                }
                let own = 2 * (j - fixed);
                for a in 0..2 {
                    mixed.own[a].write(&mut model[(ambient + k, own + a)].0, i);
                }
                if k < fixed {
                    continue;
                }
                let other = 2 * (k - fixed);
                for b in 0..2 {
                    mixed.other[b].write(&mut model[(ambient + j, other + b)].0, i);
                    for a in 0..2 {
                        mixed.both[a][b].write(&mut both[(other + b, own + a)].0, i);
                    }
                }
            }
        }
    }
}

/// A light and its tangents, in one vector of lanes.
#[inline(always)]
fn frames_at<S: Simd>(simd: S, [light, one, other]: &[Block; 3], vector: usize) -> [[Lanes<S>; 3]; 3] {
    [light.at(simd, vector), one.at(simd, vector), other.at(simd, vector)]
}

/// A vector of each lane, zero where there is none.
fn gathered<A>(lanes: &[A; LANES], vector: impl Fn(&A) -> Option<DVec3>) -> Block {
    Block::new(lanes.iter().map(|lane| vector(lane).unwrap_or(DVec3::ZERO)))
}
