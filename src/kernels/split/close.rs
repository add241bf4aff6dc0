//! The pixels of a light, closed: one that is brighter than the membrane becomes the membrane, and one that is darker
//! stays. Those of its glow are dimmed.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use pulp::{Arch, Simd, WithSimd};

use super::glow::Bright;
use super::loss::Loss;
use super::moments::{First, Luminances, Second};
use super::pixels::{Bands, Map, Slab};
use super::planes::Planes;
use super::stretched::Stretched;
use crate::kernels::detect::segment::run::Run;

/// Leave of each pixel of a light in the `rest` the membrane where that is darker; what each light loses. In channels
/// that are `dark`, what is darker than the membrane stays.
pub fn close(map: &Map<'_>, bands: &Bands, dark: &[[bool; 3]], rest: &mut [[f32; 3]]) -> Vec<Loss> {
    map.loss_of_each(bands, rest, |light, runs, slab| {
        Arch::new().dispatch(Closed { map, runs, is_dark: dark[light], slab })
    })
}

/// Leave of each pixel of a glow in the `rest` what may stay.
pub fn dim(map: &Map<'_>, bands: &Bands, rest: &mut [[f32; 3]]) -> Vec<Loss> {
    map.loss_of_each(bands, rest, |_, runs, slab| Arch::new().dispatch(Dimmed { map, runs, slab }))
}

/// Pixels of a light that are closed.
struct Closed<'a, 'b> {
    map: &'a Map<'a>,
    runs: &'a [Run],
    is_dark: [bool; 3],
    slab: &'a mut Slab<'b>,
}

impl WithSimd for Closed<'_, '_> {
    type Output = Loss;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Loss {
        let Self { map, runs, is_dark, slab } = self;
        let (mut first, mut second, mut taken) = Default::default();
        let (mut loss, mut row, mut membrane) = (Loss::NONE, ClosedRow::default(), Stretched::default());
        for strip in map.strips(runs) {
            let columns = map.cells.columns(strip.columns.clone());
            start(columns.width.len(), &mut first, &mut second, &mut taken);
            row.start(columns.width.len());
            membrane.stretch(map.membrane, map.block, &strip.behind, strip.columns.len(), strip.rows.start);
            for number in strip.rows.clone() {
                let cells = &map.cells.rows[number];
                membrane.row(number, &mut row.fill);
                row.given.read(map.given(number, &strip));
                row.close(is_dark);
                row.left.write(slab.at(number, &strip));
                first.add(&row.given, &row.left, cells);
                second.add(row.bumped(), cells);
                row.given.luminance_without(&row.left, taken.row());
                taken.add(cells);
            }
            let (vectors, tensors) = (first.vectors(&columns), second.tensors(&columns));
            let (flux, squares) = taken.integrals(&columns);
            loss = loss.and(Loss { vectors, tensors, flux, squares });
        }
        loss
    }
}

/// Make room for sums over so many pixels of a row.
fn start(pixels: usize, first: &mut First, second: &mut Second, taken: &mut Luminances) {
    first.start(pixels);
    second.start(pixels);
    taken.start(pixels);
}

/// Pixels of a row that are closed: those of the map, the membrane and its bump, and what is left.
#[derive(Default)]
struct ClosedRow {
    given: Planes<3>,
    fill: Planes<4>,
    left: Planes<3>,
    bumped: Planes<3>,
    brighter: Vec<f32>,
}

impl ClosedRow {
    /// Make room for so many pixels.
    fn start(&mut self, pixels: usize) {
        self.fill.start(pixels);
        for planes in [&mut self.given, &mut self.left, &mut self.bumped] {
            planes.start(pixels);
        }
        self.brighter.resize(pixels, 0.0);
    }

    /// Find what is left.
    #[inline(always)]
    fn close(&mut self, is_dark: [bool; 3]) {
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
