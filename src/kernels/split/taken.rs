//! What is taken from the pixels of a light, so that it has one direction.
//!
//! A pixel that is brighter than the membrane becomes the membrane; one that is darker stays. That leaves `M`,
//! and takes vectors that are nearly parallel. With the bump `b` of the membrane, at most 1, and the place `t` of
//! a pixel across the light's direction, each channel is tilted to
//!
//! ```text
//!   L' = M (1 + b k.t)      with k so that      integral of (L - L') t dw = 0
//! ```
//!
//! which is linear in k. For a sun whose glare is around it, tilts of a few per cent do. A window that is blue
//! above and green below would need so much that it showed as a colour: no single direction stands for it. Such
//! a channel is not tilted, and its vector tells what is left across the direction. That has no luminance, for
//! the direction is that of the luminance taken.

use glam::{DMat2, DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::cells::Cells;
use super::level::Enlarged;
use crate::interrupt;
use crate::kernels::image::{LUMINANCE, luminance_f32};
use crate::kernels::sphere::tangents;

/// Pixels that one task sums. Another number would add in another order.
const PIXELS_OF_A_PART: usize = 4096;
/// The largest tilt, as a share of the radiance. Of 20 maps, the suns need .08 to .26, and windows .7 to 27.
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
    /// Angle from the direction within which all pixels lie from which something was taken.
    pub reach: f64,
    /// Vector irradiance of each channel.
    pub vectors: DMat3,
}

/// A map, its cells, and the membrane in its pixels.
pub struct Map<'a> {
    /// Its pixels, row after row, and its height and width.
    pub pixels: &'a [[f32; 3]],
    pub size: (usize, usize),
    pub cells: Cells,
    pub membrane: Enlarged<'a>,
    /// Pixels of the map along each side of a pixel of the working image.
    pub block: usize,
}

/// A pixel of a light.
pub struct Pixel {
    pub row: usize,
    pub column: usize,
    given: [f32; 3],
    pub left: [f32; 3],
    bump: f32,
}

/// Take the light in some pixels of the working image. Where nothing is taken, it keeps the `direction` that it
/// was found in.
pub fn take(map: &Map<'_>, region: &[u32], direction: DVec3) -> (Taken, Vec<Vec<Pixel>>) {
    let cells = &map.cells;
    let mut pixels = closed(map, region);
    let vectors = keep_dark_channels(&mut pixels, cells);
    let axis = toward(&vectors).try_normalize().unwrap_or(direction);
    align(&mut pixels, cells, axis, vectors.map(DVec3::length));
    (measured(&pixels, cells, direction), pixels)
}

/// The map's pixels behind some of the working image, with the membrane wherever it is darker, in parts.
fn closed(map: &Map<'_>, region: &[u32]) -> Vec<Vec<Pixel>> {
    let ((height, width), block) = (map.size, map.block);
    let columns = map.membrane.level.size.1;
    let pixel = |row: usize, column: usize| {
        let given = map.pixels[row * width + column];
        let [red, green, blue, bump] = map.membrane.at(row, column).map(|value| value as f32);
        let fill = [red, green, blue];
        let left = if luminance_f32(given) > luminance_f32(fill) { fill } else { given };
        Pixel { row, column, given, left, bump }
    };
    region
        .par_chunks(PIXELS_OF_A_PART / block.pow(2).min(PIXELS_OF_A_PART))
        .map(|part| {
            interrupt::check();
            let mut pixels = Vec::with_capacity(part.len() * block.pow(2));
            for &place in part {
                let (row, column) = (place as usize / columns * block, place as usize % columns * block);
                for row in row..(row + block).min(height) {
                    pixels.extend((column..(column + block).min(width)).map(|column| pixel(row, column)));
                }
            }
            pixels
        })
        .collect()
}

/// In a channel of which the membrane holds more than the light, take nothing from any pixel that is darker.
///
/// So a red lamp before a white wall takes no negative blue with it. Gives the vector irradiance of what is taken.
fn keep_dark_channels(pixels: &mut [Vec<Pixel>], cells: &Cells) -> [DVec3; 3] {
    let before = vectors(pixels, cells);
    let axis = toward(&before);
    let is_dark = before.map(|vector| vector.dot(axis) < 0.0);
    for channel in (0..3).filter(|&channel| is_dark[channel]) {
        for pixel in pixels.iter_mut().flatten() {
            pixel.left[channel] = pixel.left[channel].min(pixel.given[channel]);
        }
    }
    if is_dark.contains(&true) { vectors(pixels, cells) } else { before }
}

/// The vector of the luminance, from those of the channels.
fn toward(vectors: &[DVec3; 3]) -> DVec3 {
    vectors.iter().zip(LUMINANCE).map(|(vector, weight)| weight * *vector).sum()
}

/// The sum of a quantity over all pixels, part by part, in the same order for any number of threads.
fn sum<T: Send>(
    pixels: &[Vec<Pixel>],
    of: impl Fn(&[Pixel]) -> T + Sync,
    add: impl Fn(T, T) -> T,
) -> Option<T> {
    let part = |part: &Vec<Pixel>| {
        interrupt::check();
        of(part)
    };
    let parts: Vec<T> = pixels.par_iter().map(part).collect();
    parts.into_iter().reduce(add)
}

/// Vector irradiance of what is taken, for each channel.
fn vectors(pixels: &[Vec<Pixel>], cells: &Cells) -> [DVec3; 3] {
    let of = |part: &[Pixel]| {
        let mut sums = [DVec3::ZERO; 3];
        for pixel in part {
            let (integral, _) = cells.at(pixel.row, pixel.column);
            for (sum, taken) in sums.iter_mut().zip(pixel.taken()) {
                *sum += taken * integral;
            }
        }
        sums
    };
    sum(pixels, of, |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]).unwrap_or_default()
}

impl Pixel {
    fn taken(&self) -> [f64; 3] {
        std::array::from_fn(|channel| f64::from(self.given[channel]) - f64::from(self.left[channel]))
    }
}

/// Tilt what is left so that the vector of each channel, of these `lengths`, becomes parallel to `axis`.
fn align(pixels: &mut [Vec<Pixel>], cells: &Cells, axis: DVec3, lengths: [f64; 3]) {
    let across = tangents(axis);
    let highest = pixels.iter().flatten().map(|pixel| pixel.bump).fold(f32::MIN_POSITIVE, f32::max);
    // The bump of a pixel, its place across the axis, and the integral of that over the pixel.
    let place = |pixel: &Pixel| {
        let (integral, solid_angle) = cells.at(pixel.row, pixel.column);
        let integral = DVec2::new(integral.dot(across[0]), integral.dot(across[1]));
        (f64::from(pixel.bump / highest), integral / solid_angle, integral)
    };
    // Solve for the slope of each channel.
    let of = |part: &[Pixel]| {
        let mut sums = [(DVec2::ZERO, DMat2::ZERO); 3];
        for pixel in part {
            let (bump, at, integral) = place(pixel);
            let product = bump * DMat2::from_cols(integral * at.x, integral * at.y);
            for ((sum, taken), left) in sums.iter_mut().zip(pixel.taken()).zip(pixel.left) {
                sum.0 += taken * integral;
                sum.1 += f64::from(left) * product;
            }
        }
        sums
    };
    let add = |a: [(DVec2, DMat2); 3], b: [(DVec2, DMat2); 3]| {
        [0, 1, 2].map(|channel| (a[channel].0 + b[channel].0, a[channel].1 + b[channel].1))
    };
    let Some(sums) = sum(pixels, of, add) else { return };
    let slopes = [0, 1, 2].map(|channel| {
        let (moment, products) = sums[channel];
        let is_aligned = moment.length() <= ROUNDING * lengths[channel];
        if is_aligned { DVec2::ZERO } else { products.inverse() * moment }
    });
    // Tilt the channels that need no more than the largest tilt.
    let steepest = |part: &[Pixel]| {
        part.iter().fold([0.0_f64; 3], |most, pixel| {
            let (bump, at, _) = place(pixel);
            [0, 1, 2].map(|channel| most[channel].max((bump * slopes[channel].dot(at)).abs()))
        })
    };
    let tilts = sum(pixels, steepest, |a, b| [0, 1, 2].map(|i| a[i].max(b[i]))).unwrap_or_default();
    // A slope that is not a number is none: nothing is left that could be tilted.
    let is_tilted = |channel: usize| tilts[channel] <= LARGEST_TILT && slopes[channel].is_finite();
    let slopes = [0, 1, 2].map(|channel| if is_tilted(channel) { slopes[channel] } else { DVec2::ZERO });
    pixels.par_iter_mut().flatten_iter().for_each(|pixel| {
        let (bump, at, _) = place(pixel);
        for (left, slope) in pixel.left.iter_mut().zip(slopes) {
            let tilted = f64::from(*left) * (1.0 + bump * slope.dot(at));
            *left = tilted.min(f64::from(f32::MAX)) as f32;
        }
    });
}

/// What was taken, after all rounding.
fn measured(pixels: &[Vec<Pixel>], cells: &Cells, found: DVec3) -> Taken {
    let vectors = vectors(pixels, cells);
    let direction = toward(&vectors).try_normalize().unwrap_or(found);
    let irradiance = DVec3::from_array(vectors.map(|vector| vector.dot(direction).max(0.0)));
    let of = |part: &[Pixel]| {
        let mut sums = (0.0, 0.0, 1.0_f64);
        for pixel in part {
            let (integral, solid_angle) = cells.at(pixel.row, pixel.column);
            let taken = pixel.taken();
            let luminance: f64 = taken.iter().zip(LUMINANCE).map(|(taken, weight)| weight * taken).sum();
            sums.0 += luminance * solid_angle;
            sums.1 += luminance * luminance * solid_angle;
            if taken.iter().any(|taken| taken.abs() > 0.0) {
                sums.2 = sums.2.min(integral.dot(direction) / solid_angle);
            }
        }
        sums
    };
    let (flux, squares, least) =
        sum(pixels, of, |a, b| (a.0 + b.0, a.1 + b.1, a.2.min(b.2))).unwrap_or((0.0, 0.0, 1.0));
    Taken {
        direction,
        irradiance,
        flux,
        solid_angle: if squares > 0.0 { flux * flux / squares } else { 0.0 },
        reach: if flux > 0.0 { least.clamp(-1.0, 1.0).acos() + cells.half_diagonal() } else { 0.0 },
        vectors: DMat3::from_cols(vectors[0], vectors[1], vectors[2]),
    }
}
