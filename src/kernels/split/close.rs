//! The pixels of a light, closed: one that is brighter than the membrane becomes the membrane, and one that is darker
//! stays. Those of its glow are dimmed.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use pulp::{Arch, Simd, WithSimd};

use super::glow::Bright;
use super::level::Value;
use super::loss::Loss;
use super::moments::{First, Luminances, Second};
use super::pixels::{Bands, Map, Slab, Strip};
use super::planes::Planes;
use crate::kernels::detect::tree::Run;

/// What each light loses, but for its flux, where its pixels are closed; in channels that are `dark`, what is darker
/// than the membrane stays.
pub fn close(map: &Map<'_>, bands: &Bands, dark: &[[bool; 3]]) -> Vec<Loss> {
    bands.sum_of_each(|light, runs| Arch::new().dispatch(Closed { map, runs, is_dark: dark[light] }))
}

/// Leave of each pixel of a glow in the `rest` what may stay.
pub fn dim(map: &Map<'_>, bands: &Bands, rest: &mut [[f32; 3]]) -> Vec<Loss> {
    map.loss_of_each(bands, rest, |_, runs, slab| Arch::new().dispatch(Dimmed { map, runs, slab }))
}

/// Pixels of a light that are closed.
struct Closed<'a> {
    map: &'a Map<'a>,
    runs: &'a [Run],
    is_dark: [bool; 3],
}

impl WithSimd for Closed<'_> {
    type Output = Loss;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Loss {
        let Self { map, runs, is_dark } = self;
        let (mut first, mut second) = (First::default(), Second::default());
        let (mut loss, mut row) = (Loss::NONE, ClosedRow::default());
        for strip in map.strips(runs) {
            let columns = map.cells.columns(strip.columns.clone());
            first.start(columns.width.len());
            second.start(columns.width.len());
            row.start(columns.width.len());
            for number in strip.rows.clone() {
                row.close(map, number, &strip, is_dark);
                first.add(&row.given, &row.left, &map.cells.rows[number]);
                second.add(row.bumped(), &map.cells.rows[number]);
            }
            let (vectors, tensors) = (first.vectors(&columns), second.tensors(&columns));
            loss = loss.and(Loss { vectors, tensors, ..Loss::NONE });
        }
        loss
    }
}

/// Pixels of a row that are closed: those of the map, the membrane and its bump, and what is left.
#[derive(Default)]
pub struct ClosedRow {
    pub given: Planes<3>,
    pub fill: Planes<4>,
    pub left: Planes<3>,
    bumped: Planes<3>,
    brighter: Vec<f32>,
    room: Vec<Value>,
}

impl ClosedRow {
    /// Make room for so many pixels.
    pub fn start(&mut self, pixels: usize) {
        self.fill.start(pixels);
        for planes in [&mut self.given, &mut self.left, &mut self.bumped] {
            planes.start(pixels);
        }
        self.brighter.resize(pixels, 0.0);
    }

    /// Find what is left of a row of a strip.
    #[inline(always)]
    pub fn close(&mut self, map: &Map<'_>, row: usize, strip: &Strip, is_dark: [bool; 3]) {
        self.given.read(map.given(row, strip));
        map.membrane.row(row, &strip.behind, &mut self.room, &mut self.fill);
        // Above 0 where a pixel is brighter than the membrane.
        self.given.luminance_without(&self.fill, &mut self.brighter);
        let channels = self.given.channels().into_iter().zip(self.fill.channels()).zip(is_dark);
        for (left, ((given, fill), is_dark)) in self.left.channels_mut().into_iter().zip(channels) {
            let pixels = given.iter().zip(fill).zip(&self.brighter);
            for (left, ((&given, &fill), &brighter)) in left.iter_mut().zip(pixels) {
                let fill = if is_dark { fill.min(given) } else { fill };
                *left = if brighter > 0.0 { fill } else { given };
            }
        }
    }

    /// What is left, times the bump.
    #[inline(always)]
    fn bumped(&mut self) -> &Planes<3> {
        let [_, _, _, bump] = self.fill.channels();
        for (bumped, left) in self.bumped.channels_mut().into_iter().zip(self.left.channels()) {
            bumped.iter_mut().zip(left.iter().zip(bump)).for_each(|(out, (left, bump))| *out = left * bump);
        }
        &self.bumped
    }
}

/// Pixels of a glow that are dimmed.
struct Dimmed<'a, 'b> {
    map: &'a Map<'a>,
    runs: &'a [Run],
    slab: &'a mut Slab<'b>,
}

impl WithSimd for Dimmed<'_, '_> {
    type Output = Loss;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Loss {
        let Self { map, runs, slab } = self;
        let (mut loss, mut first, mut taken) = (Loss::NONE, First::default(), Luminances::default());
        let (mut given, mut left) = (Planes::default(), Planes::default());
        for strip in map.strips(runs) {
            let columns = map.cells.columns(strip.columns.clone());
            let pixels = columns.width.len();
            first.start(pixels);
            taken.start(pixels);
            given.start(pixels);
            left.start(pixels);
            for row in strip.rows.clone() {
                let cells = &map.cells.rows[row];
                given.read(map.given(row, &strip));
                dim_row(map.bright, &given, &mut left, taken.row());
                left.write(slab.at(row, &strip));
                first.add(&given, &left, cells);
                taken.add(cells);
            }
            let (flux, squares) = taken.integrals(&columns);
            loss = loss.and(Loss { vectors: first.vectors(&columns), flux, squares, ..Loss::NONE });
        }
        loss
    }
}

/// What is left of the pixels of a row of a glow, and the luminance of what is taken.
#[inline(always)]
fn dim_row(bright: Bright, given: &Planes<3>, left: &mut Planes<3>, taken: &mut [f32]) {
    given.luminance(taken);
    let shares = taken;
    for share in shares.iter_mut() {
        *share = bright.share_left(*share);
    }
    for (left, given) in left.channels_mut().into_iter().zip(given.channels()) {
        left.iter_mut()
            .zip(given)
            .zip(shares.iter())
            .for_each(|((left, given), share)| *left = given * share);
    }
    given.luminance_without(left, shares);
}
