//! Conversion of a picture of the sphere to another layout, which preserves its flux and that of each bright pixel.
//!
//! A picture is constant in each pixel, as in the exact probe. Each new pixel is the mean over a grid of samples. The
//! result is scaled to the flux of the old picture if both show the whole sphere. Bright pixels, which small lights consist of, are left out at
//! first; then `splat.rs` adds each with its own flux and direction.

use glam::DMat3;
use ndarray::{Array2, ArrayView2, ArrayView3, ArrayViewMut3};
use rayon::prelude::*;

use super::block_rows::samples_of;
use super::samples::check_rgb;
use super::splat::{BrightPixel, splat};
use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::projection::{DirectionArrays, Line, NO_PIXEL, Places, SphereProjection};
use crate::kernels::sphere;

/// Settings of a resampling.
struct ResamplingSettings {
    /// Samples along each side of a new pixel that is no larger than the old ones.
    side: usize,
    /// Samples along each side of a new pixel, for each old pixel along it.
    samples_per_pixel: f64,
    /// A bright pixel has more than this fraction of the flux of any channel.
    bright_fraction: f64,
    /// Least ratio of a bright pixel to the mean radiance of what is seen.
    bright_contrast: f64,
    /// Columns of one look-up, so that all its arrays stay in the first cache.
    columns_at_once: usize,
}

const RESAMPLING: ResamplingSettings = ResamplingSettings {
    side: 3,
    samples_per_pixel: 2.0,
    bright_fraction: 1e-4,
    bright_contrast: 10.0,
    columns_at_once: 768,
};

/// Picture of radiance with its layout.
pub struct SourcePicture<'a> {
    /// Radiance, (height, width, 3), multiplied by `seen`.
    pub radiance: ArrayView3<'a, f32>,
    /// Share of each pixel that is seen, (height, width); `None` if all is.
    pub seen: Option<ArrayView2<'a, f32>>,
    /// Layout of the pixels.
    pub layout: &'a dyn SphereProjection,
}

/// Write `picture` in the layout `to`, so that light from the direction d comes from `rotation * d`.
///
/// Returns the share of each new pixel that is seen, (height, width); `None` if both layouts show the whole sphere.
///
/// # Errors
///
/// [`Error::NotAMap`], [`Error::WrongShape`], [`Error::NoMemory`].
pub fn resample(
    picture: &SourcePicture<'_>,
    to: &dyn SphereProjection,
    rotation: DMat3,
    out: ArrayViewMut3<'_, f32>,
) -> Result<Option<Array2<f32>>> {
    let size = picture.layout.size();
    check_rgb(picture.radiance)?;
    check_size(&picture.radiance.shape()[..2], size)?;
    sphere::check_memory(&[size[0], size[1], 4])?;
    let is_partial = picture.seen.is_some() || !picture.layout.is_whole() || !to.is_whole();
    if is_partial {
        with_shares(picture, to, rotation, out).map(Some)
    } else {
        whole(picture, to, rotation, out)
    }
}

fn check_size(shape: &[usize], [height, width]: [usize; 2]) -> Result<()> {
    if shape == [height, width] {
        return Ok(());
    }
    Err(Error::WrongShape { what: "the picture", wanted: "of its layout", shape: shape.to_vec() })
}

/// Resample a picture of the whole sphere.
fn whole(
    picture: &SourcePicture<'_>,
    to: &dyn SphereProjection,
    rotation: DMat3,
    mut out: ArrayViewMut3<'_, f32>,
) -> Result<Option<Array2<f32>>> {
    let samples = samples_of(picture.radiance, 0..picture.radiance.dim().0);
    let old = samples.as_chunks::<3>().0;
    let lights = Lights::of(old, picture.layout, picture.layout.extent().0);
    let new = rgb_of(&mut out)?;
    let rest = lights.without(old, |rgb, _| *rgb);
    let width = to.size()[1];
    let gather = Gather::new(&rest, picture.layout, to, rotation);
    new.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
        gather.row(row, line, |rgb, sums: [f64; 3]| *rgb = sums.map(|value| value as f32));
    });
    // Whole pictures keep their flux.
    let factors = ratio(flux(&rest, picture.layout), flux(new, to));
    scale(new, width, factors);
    lights.add_to(new, picture.layout, to, rotation);
    Ok(None)
}

/// Resample a picture with unseen parts, and the share that is seen.
///
/// Samples cut off radiance and share at the same border, so the rest needs no factor: an even picture stays even.
fn with_shares(
    picture: &SourcePicture<'_>,
    to: &dyn SphereProjection,
    rotation: DMat3,
    mut out: ArrayViewMut3<'_, f32>,
) -> Result<Array2<f32>> {
    let samples = samples_of(picture.radiance, 0..picture.radiance.dim().0);
    let old = samples.as_chunks::<3>().0;
    let shares: Option<Vec<f32>> = picture.seen.map(|seen| seen.iter().copied().collect());
    let lights = Lights::of(old, picture.layout, seen_extent(picture));
    let new = rgb_of(&mut out)?;
    let share = |pixel: usize| shares.as_ref().map_or(1.0, |shares| shares[pixel]);
    let rest = lights.without(old, |&[r, g, b], pixel| [r, g, b, share(pixel)]);
    let width = to.size()[1];
    let gather = Gather::new(&rest, picture.layout, to, rotation);
    let mut seen = Array2::zeros((to.size()[0], width));
    let rows = new.par_chunks_mut(width).zip(seen.outer_iter_mut().into_par_iter());
    rows.enumerate().for_each(|(row, (line, mut seen))| {
        let mut seen = seen.iter_mut();
        gather.row(row, line, |rgb, [r, g, b, share]: [f64; 4]| {
            *rgb = [r, g, b].map(|value| value as f32);
            if let Some(seen) = seen.next() {
                *seen = share as f32;
            }
        });
    });
    // A pixel with light is seen at least in a part.
    let least = 1.0 / (gather.side * gather.side) as f32;
    for pixel in lights.add_to(new, picture.layout, to, rotation) {
        let share = &mut seen[[pixel / width, pixel % width]];
        *share = share.max(least);
    }
    Ok(seen)
}

/// Pixels of the result, which is contiguous.
fn rgb_of<'a>(out: &'a mut ArrayViewMut3<'_, f32>) -> Result<&'a mut [[f32; 3]]> {
    let shape = out.shape().to_vec();
    let samples =
        out.as_slice_mut().ok_or(Error::WrongShape { what: "the result", wanted: "contiguous", shape })?;
    Ok(samples.as_chunks_mut::<3>().0)
}

/// Means of old pixels over grids of samples in each new pixel.
struct Gather<'a, const N: usize> {
    old: &'a [[f32; N]],
    from: &'a dyn SphereProjection,
    to: &'a dyn SphereProjection,
    /// Rotation from new directions to old ones.
    back: DMat3,
    places: Box<dyn Places + 'a>,
    side: usize,
}

impl<'a, const N: usize> Gather<'a, N> {
    fn new(
        old: &'a [[f32; N]],
        from: &'a dyn SphereProjection,
        to: &'a dyn SphereProjection,
        rotation: DMat3,
    ) -> Self {
        let old_pixels = (to.mean_solid_angle() / from.mean_solid_angle()).sqrt();
        let side = RESAMPLING.side.max((RESAMPLING.samples_per_pixel * old_pixels).ceil() as usize);
        let back = rotation.transpose();
        Self { old, from, to, back, places: to.places(side, back), side }
    }

    /// Add the old pixels of some samples, and count the samples outside of the new picture, whose `xs` are NaN.
    fn add(&self, (sum, outside): &mut ([f64; N], usize), pixels: &[u32], xs: &[f64]) {
        let mut part = *sum;
        for (&pixel, x) in pixels.iter().zip(xs) {
            if pixel != NO_PIXEL {
                add(&mut part, self.old[pixel as usize].map(f64::from));
            } else if x.is_nan() {
                *outside += 1;
            }
        }
        *sum = part;
    }

    /// Mean of the samples inside of the new picture; of a pixel without any, the value at its centroid.
    fn mean(&self, sum: [f64; N], inside: usize, pixel: usize) -> [f64; N] {
        if inside > 0 {
            return sum.map(|value| value / inside as f64);
        }
        if self.to.solid_angle(pixel) <= 0.0 {
            return sum;
        }
        match self.from.pixel((self.back * self.to.moment(pixel)).to_array()) {
            NO_PIXEL => sum,
            old => self.old[old as usize].map(f64::from),
        }
    }

    /// Set each pixel of a new row from the mean of its samples, 0 for those that the old picture does not show.
    ///
    /// Samples outside of the new picture do not count.
    fn row(&self, row: usize, line: &mut [[f32; 3]], mut set: impl FnMut(&mut [f32; 3], [f64; N])) {
        let most = RESAMPLING.columns_at_once.div_ceil(self.side);
        let mut directions = DirectionArrays::new(most * self.side);
        let mut pixels = vec![NO_PIXEL; most * self.side];
        for (block, line) in line.chunks_mut(most).enumerate() {
            interrupt::check();
            let mut sums = vec![([0.0; N], 0_usize); line.len()];
            for number in 0..self.side {
                let place = Line { row, line: number, first: block * most, columns: line.len() };
                self.places.directions(&place, &mut directions);
                let pixels = &mut pixels[..line.len() * self.side];
                self.from.pixels(&directions, pixels);
                let xs = directions.components()[0].chunks(self.side);
                for ((sum, pixels), xs) in sums.iter_mut().zip(pixels.chunks(self.side)).zip(xs) {
                    self.add(sum, pixels, xs);
                }
            }
            let first = row * self.to.size()[1] + block * most;
            for (index, (rgb, (sum, outside))) in line.iter_mut().zip(sums).enumerate() {
                set(rgb, self.mean(sum, self.side * self.side - outside, first + index));
            }
        }
    }
}

/// Bright pixels, in rising order.
struct Lights(Vec<BrightPixel>);

impl Lights {
    /// Bright pixels of a picture that shows a solid angle of `extent`.
    fn of(old: &[[f32; 3]], layout: &dyn SphereProjection, extent: f64) -> Self {
        let (width, total) = (layout.size()[1], flux(old, layout));
        let in_row = |(row, line): (usize, &[[f32; 3]])| -> Vec<BrightPixel> {
            interrupt::check();
            let angles = layout.solid_angles_of_row(row).into_iter();
            let pixels =
                line.iter().zip(angles).enumerate().filter_map(|(column, (&radiance, solid_angle))| {
                    let pixel = row * width + column;
                    let most =
                        (RESAMPLING.bright_fraction / solid_angle).max(RESAMPLING.bright_contrast / extent);
                    let is_bright =
                        radiance.iter().zip(total).any(|(&value, flux)| f64::from(value) > most * flux);
                    let flux = radiance.map(|value| f64::from(value) * solid_angle);
                    is_bright.then_some(BrightPixel { pixel, flux })
                });
            pixels.collect()
        };
        Self(old.par_chunks(width).enumerate().flat_map_iter(in_row).collect())
    }

    /// Old pixels as `value` returns them, black in all channels of light where they are bright.
    fn without<const N: usize>(
        &self,
        old: &[[f32; 3]],
        value: impl Fn(&[f32; 3], usize) -> [f32; N] + Sync,
    ) -> Vec<[f32; N]> {
        let mut rest = vec![[0.0; N]; old.len()];
        let blocks = rest.par_chunks_mut(1 << 14).zip(old.par_chunks(1 << 14)).enumerate();
        blocks.for_each(|(block, (rest, old))| {
            interrupt::check();
            for (index, (rest, old)) in rest.iter_mut().zip(old).enumerate() {
                *rest = value(old, (block << 14) + index);
            }
        });
        for light in &self.0 {
            rest[light.pixel] = value(&[0.0; 3], light.pixel);
        }
        rest
    }

    /// Add the bright pixels to a result, and return the pixels that they reach.
    fn add_to(
        &self,
        new: &mut [[f32; 3]],
        from: &dyn SphereProjection,
        to: &dyn SphereProjection,
        rotation: DMat3,
    ) -> Vec<usize> {
        let parts = splat(&self.0, from, to, rotation);
        for &(pixel, radiance) in &parts {
            let mut sum = new[pixel].map(f64::from);
            add(&mut sum, radiance);
            new[pixel] = finite(sum);
        }
        parts.into_iter().map(|(pixel, _)| pixel).collect()
    }
}

/// Solid angle of the part of a picture that is seen.
///
/// The mean radiance refers to it: if it were the whole sphere, all pixels of an even photograph would be bright.
fn seen_extent(picture: &SourcePicture<'_>) -> f64 {
    let Some(seen) = picture.seen else { return picture.layout.extent().0 };
    let rows = seen.outer_iter().enumerate().map(|(row, shares)| {
        let angles = picture.layout.solid_angles_of_row(row);
        shares.iter().zip(angles).map(|(&share, angle)| f64::from(share) * angle).sum::<f64>()
    });
    rows.sum()
}

/// Flux of the channels of light, summed by rows and then in their order.
fn flux<const N: usize>(map: &[[f32; N]], layout: &dyn SphereProjection) -> [f64; 3] {
    let width = layout.size()[1];
    let rows = map.par_chunks(width).enumerate().map(|(row, line)| {
        interrupt::check();
        let mut sum = [0.0; 3];
        for (samples, solid_angle) in line.iter().zip(layout.solid_angles_of_row(row)) {
            add(&mut sum, [0, 1, 2].map(|i| f64::from(samples[i]) * solid_angle));
        }
        sum
    });
    let mut total = [0.0; 3];
    rows.collect::<Vec<_>>().into_iter().for_each(|row| add(&mut total, row));
    total
}

fn scale(new: &mut [[f32; 3]], width: usize, factors: [f64; 3]) {
    new.par_chunks_mut(width).for_each(|line| {
        interrupt::check();
        for rgb in line {
            *rgb = finite(std::array::from_fn(|i| f64::from(rgb[i]) * factors[i]));
        }
    });
}

/// `above` over `below`, channel by channel; 0 for a channel without flux.
fn ratio(above: [f64; 3], below: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| if below[i] > 0.0 { above[i] / below[i] } else { 0.0 })
}

/// Single precision, limited to its largest value, because scaled samples may exceed it.
fn finite(rgb: [f64; 3]) -> [f32; 3] {
    rgb.map(|value| value.min(f64::from(f32::MAX)) as f32)
}

fn add<const N: usize>(sum: &mut [f64; N], other: [f64; N]) {
    sum.iter_mut().zip(other).for_each(|(sum, value)| *sum += value);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use glam::DVec3;
    use ndarray::Array3;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    use super::*;
    use crate::kernels::projection::Equirectangular;

    fn rotate(map: &Array3<f32>, rotation: DMat3) -> Array3<f32> {
        let (height, width, _) = map.dim();
        let layout = Equirectangular::new([height, width]);
        let picture = SourcePicture { radiance: map.view(), seen: None, layout: &layout };
        let mut new = Array3::zeros(map.dim());
        resample(&picture, &layout, rotation, new.view_mut()).unwrap();
        new
    }

    proptest! {
        #[test]
        fn flux_is_preserved(
            values in prop::collection::vec(0.0_f32..1.0, 8 * 16 * 3), suns in prop::collection::vec(0_usize..128, 0..4),
            axis in prop::array::uniform3(-1.0..1.0_f64), angle in 0.0..PI,
        ) {
            let axis = DVec3::from_array(axis);
            prop_assume!(axis.length() > 0.1);
            let mut map = Array3::from_shape_vec((8, 16, 3), values).unwrap();
            for sun in suns {
                map[[sun / 16, sun % 16, 1]] = 1e5;
            }
            let turned = rotate(&map, DMat3::from_axis_angle(axis.normalize(), angle));
            let layout = Equirectangular::new([8, 16]);
            let flux = |map: &Array3<f32>| flux(map.as_slice().unwrap().as_chunks::<3>().0, &layout);
            for (measured, expected) in flux(&turned).into_iter().zip(flux(&map)) {
                prop_assert!((measured / expected - 1.0).abs() < 1e-6, "{measured} {expected}");
            }
        }
    }

    #[test]
    fn a_map_near_the_largest_float_stays_finite() {
        let map = Array3::from_shape_fn((8, 16, 3), |(row, _, _)| if row < 4 { f32::MAX } else { 0.0 });
        let turned = rotate(&map, DMat3::from_rotation_x(0.3));
        assert!(turned.iter().all(|value| value.is_finite()));
    }
}
