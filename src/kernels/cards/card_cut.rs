//! Cards of the lights of a map: their shapes, textures and irradiance, and the map without them.
//!
//! A card takes the removed radiance of all pixels that it touches, unless an earlier card took it. What lies beside
//! the cards returns to the map.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::card_matrix::{self, point, sizes, square_towards, upright};
use super::footprint::{Footprint, MOST_SAMPLES, RemovedRadiance};
use super::panes::{self, Group};
use super::shape_fit::{FittedShape, Shape, fit};
use super::window_fill::fill_windows;
use super::window_search;
use crate::kernels::polygon::vector_irradiance;

/// Texels along a side of a texture at most.
const MOST_TEXELS: f64 = 4096.0;
/// Share of the flux of a point or another light in its square.
const SQUARE_SHARE: f64 = 0.99;

/// Light to cut out: its direction, and the angular radius of its disc.
pub struct CardLight {
    /// Unit vector.
    pub direction: DVec3,
    /// Angular radius.
    pub radius: f64,
}

/// Card of one light or of several panes.
pub struct CardCut {
    /// Shape of the light.
    pub shape: Shape,
    /// Columns U, V, O.
    pub matrix: DMat3,
    /// Intersection over union of light and shape.
    pub overlap: f64,
    /// Irradiance of each channel at normal incidence, towards the centre.
    pub irradiance: DVec3,
    /// Angular radius of the light as a disc; none for that of the card.
    pub radius: Option<f64>,
    /// Radiance of the card.
    pub texture: Texture,
    /// Numbers of the lights from 1.
    pub lights: Vec<u32>,
    /// True for a window that edges of the map show.
    pub is_window: bool,
}

/// Radiance of the texels of a card, row after row.
#[derive(Default)]
pub struct Texture {
    pub size: [usize; 2],
    pub texels: Vec<[f32; 3]>,
}

/// Cards of some lights; `rest` receives what lies beside them.
pub fn cut(removed: RemovedRadiance<'_>, lights: &[CardLight], rest: &mut [[f32; 3]]) -> Vec<CardCut> {
    let members = removed.members(lights.len());
    let single = |light: usize| {
        let number = [light as u32 + 1];
        Footprint::new(&removed, &number, &members[light], MOST_SAMPLES).and_then(|footprint| fit(&footprint))
    };
    // Lights do not depend on each other: the same bits for any number of threads.
    let fits: Vec<Option<FittedShape>> = (0..lights.len()).into_par_iter().map(single).collect();
    let groups = window_search::find(&removed, &members, fits);
    let cards = panes::merge(&removed, &members, groups);
    let filled = fill_windows(&removed, &cards);
    let removed = &RemovedRadiance { rest: filled.as_deref().unwrap_or(removed.rest), ..removed };
    let mut order: Vec<usize> = (0..cards.len()).collect();
    order.sort_by_key(|&card| !is_outline(cards[card].1.as_ref()));
    let mut cutter = Cutter { removed, taken: vec![0.0; removed.map.len()] };
    let mut cuts: Vec<(usize, CardCut)> =
        order.into_iter().map(|card| (card, cutter.cut(lights, &members, &cards[card]))).collect();
    cuts.sort_by_key(|(card, _)| *card);
    for (pixel, rest) in rest.iter_mut().enumerate() {
        let back = (1.0 - cutter.taken[pixel]) * removed.radiance(pixel);
        for (channel, value) in rest.iter_mut().enumerate() {
            *value = (f64::from(removed.rest[pixel][channel]) + back[channel]) as f32;
        }
    }
    cuts.into_iter().map(|(_, cut)| cut).collect()
}

fn is_outline(fit: Option<&FittedShape>) -> bool {
    fit.is_some_and(|fit| !matches!(fit.shape, Shape::Point | Shape::Other))
}

struct Cutter<'a> {
    removed: &'a RemovedRadiance<'a>,
    /// Taken share of each pixel.
    taken: Vec<f64>,
}

impl Cutter<'_> {
    fn cut(&mut self, lights: &[CardLight], members: &[Vec<u32>], (numbers, fit): &Group) -> CardCut {
        let first = numbers[0] as usize - 1;
        let (shape, matrix, overlap) = match fit {
            Some(fit) if is_outline(Some(fit)) => (fit.shape, upright(&fit.matrix), fit.overlap),
            other => {
                let shape = other.as_ref().map_or(Shape::Point, |fit| fit.shape);
                let square = self.square(&lights[first], &members[first]);
                (shape, square, other.as_ref().map_or(0.0, |fit| fit.overlap))
            }
        };
        let is_square = matches!(shape, Shape::Point | Shape::Other);
        let parts = self.take(&matrix, shape == Shape::Disc, is_square.then_some(numbers));
        let centre = card_matrix::centre(&matrix);
        let flux = |&(pixel, share, _): &(usize, f64, f64)| {
            let pixels = &self.removed.pixels;
            share
                * pixels.solid_angle(pixel)
                * pixels.direction(pixel).dot(centre)
                * self.removed.radiance(pixel)
        };
        let irradiance: DVec3 = parts.iter().map(flux).sum();
        let texture = self.texture(&matrix, shape == Shape::Disc, &parts, irradiance);
        let radius = is_square.then(|| lights[first].radius.min(disc_radius(&matrix)));
        let is_window = fit.as_ref().is_some_and(|fit| fit.is_window);
        CardCut { shape, matrix, overlap, irradiance, radius, texture, lights: numbers.clone(), is_window }
    }

    /// Facing square around most of the flux of a light.
    fn square(&self, light: &CardLight, members: &[u32]) -> DMat3 {
        let removed = self.removed;
        let flux = |pixel: u32| {
            removed.radiance(pixel as usize).element_sum() * removed.pixels.solid_angle(pixel as usize)
        };
        let sum: DVec3 =
            members.iter().map(|&pixel| flux(pixel) * removed.pixels.direction(pixel as usize)).sum();
        let centre = sum.try_normalize().unwrap_or(light.direction);
        let angle = |pixel: u32| removed.pixels.direction(pixel as usize).angle_between(centre);
        let mut far: Vec<(f64, f64)> = members.iter().map(|&pixel| (angle(pixel), flux(pixel))).collect();
        far.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = far.iter().map(|(_, flux)| flux).sum();
        let mut sum = 0.0;
        let inside = far.iter().find(|(_, flux)| {
            sum += flux;
            sum >= SQUARE_SHARE * total
        });
        let radius = inside.map_or(0.0, |(angle, _)| *angle) + removed.pixels.step();
        square_towards(centre, radius)
    }

    /// Pixels of a card with their taken share and covered part; of a square, only those of its lights or of none.
    fn take(&mut self, matrix: &DMat3, is_ellipse: bool, only: Option<&Vec<u32>>) -> Vec<(usize, f64, f64)> {
        let parts = self.removed.pixels.inside(matrix, is_ellipse, |(), _| (), || ());
        let mut taken = Vec::with_capacity(parts.len());
        for (pixel, part, ()) in parts {
            let label = self.removed.label(pixel);
            let is_other = only.is_some_and(|lights| label != 0 && !lights.contains(&label));
            let share = if is_other { 0.0 } else { 1.0 - self.taken[pixel] };
            self.taken[pixel] += share;
            taken.push((pixel, share, part));
        }
        taken
    }

    /// Texture of a card with this irradiance, interpolated between the pixels that it took.
    fn texture(
        &self,
        matrix: &DMat3,
        is_disc: bool,
        parts: &[(usize, f64, f64)],
        irradiance: DVec3,
    ) -> Texture {
        let pixels = &self.removed.pixels;
        let shares: rustc_hash::FxHashMap<usize, (f64, f64)> =
            parts.iter().map(|&(pixel, share, part)| (pixel, (share, part))).collect();
        let size = texture_size(matrix, pixels.step());
        let radiance = |place: DVec2| {
            let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
            for (pixel, weight) in pixels.around(point(matrix, place).normalize()) {
                if let Some((share, part)) = shares.get(&pixel) {
                    sum += weight * share * self.removed.radiance(pixel);
                    weights += weight * part;
                }
            }
            if weights > 1e-3 { sum / weights } else { DVec3::ZERO }
        };
        let cover = |place| if is_disc { ellipse_cover(place, size) } else { 1.0 };
        let texels: Vec<DVec3> = places(size)
            .map(|place| match cover(place) {
                0.0 => DVec3::ZERO,
                part => part * radiance(place),
            })
            .collect();
        let seen = irradiance_of(matrix, size, &texels);
        let gain =
            DVec3::from_array([0, 1, 2].map(|c| if seen[c] > 0.0 { irradiance[c] / seen[c] } else { 0.0 }));
        let texels = texels.into_iter().map(|texel| (texel * gain).as_vec3().to_array()).collect();
        Texture { size, texels }
    }
}

/// Angular radius of the disc in a facing square.
fn disc_radius(matrix: &DMat3) -> f64 {
    (0.5 * sizes(matrix)[0]).min(std::f64::consts::FRAC_PI_2)
}

/// Rows and columns of a texture whose texels are about as large as pixels.
fn texture_size(matrix: &DMat3, step: f64) -> [usize; 2] {
    let [along, down] = sizes(matrix);
    [down, along].map(|angle| (angle / step).ceil().clamp(2.0, MOST_TEXELS) as usize)
}

/// Places of the texels, row after row.
fn places([rows, columns]: [usize; 2]) -> impl Iterator<Item = DVec2> {
    let place = move |i: usize| DVec2::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
    (0..rows * columns).map(move |i| place(i) / DVec2::new(columns as f64, rows as f64))
}

/// Part of a texel inside the inscribed ellipse, by 4 x 4 samples.
fn ellipse_cover(place: DVec2, [rows, columns]: [usize; 2]) -> f64 {
    let sample = |i: i32| {
        let offset = DVec2::new(f64::from(i % 4) - 1.5, f64::from(i / 4) - 1.5) / 4.0;
        card_matrix::is_inside(place + offset / DVec2::new(columns as f64, rows as f64), true)
    };
    (0..16).filter(|&i| sample(i)).count() as f64 / 16.0
}

/// Irradiance of texels at normal incidence, towards the centre: each by the vector irradiance of its polygon.
fn irradiance_of(matrix: &DMat3, [rows, columns]: [usize; 2], texels: &[DVec3]) -> DVec3 {
    let centre = card_matrix::centre(matrix);
    let corner = |row: usize, column: usize| {
        point(matrix, DVec2::new(column as f64 / columns as f64, row as f64 / rows as f64)).normalize()
    };
    let mut sum = DVec3::ZERO;
    for (i, texel) in texels.iter().enumerate() {
        let (row, column) = (i / columns, i % columns);
        let around = [
            corner(row, column),
            corner(row, column + 1),
            corner(row + 1, column + 1),
            corner(row + 1, column),
        ];
        sum += *texel * vector_irradiance(&around).dot(centre);
    }
    sum
}
