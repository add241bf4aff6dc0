//! Frames from a basis of one or two bytes a value.
//!
//! The prediction of a frame is limited by reading the basis, so a basis with a quarter of the bytes is four times as
//! fast. Its values are stored in tiles of 32 texels, (tiles, rank, 32). Each half of a tile has its
//! own scale for each component:
//!
//! ```text
//!   image[t, c] = sum over r of  coefficients[r, c] scales[tile, r, lane / 16] values[tile, r, lane],
//!   t = 32 tile + lane
//! ```
//!
//! The sums of a tile stay in registers. A frame that uses only the first components reads no others.
#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use half::f16;
use half::slice::HalfFloatSliceExt;
use ndarray::parallel::prelude::*;
use ndarray::{Array3, ArrayView3, Axis};
use pulp::{Arch, Simd, WithSimd};
use rayon::slice::ParallelSlice;

use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::check_memory;

/// Texels of a tile. With more, the sums no longer fit in registers and a frame is slower.
pub const TILE: usize = 32;
/// Texels with a common scale. Fewer cost more memory, more cost accuracy.
pub const SHARE: usize = 16;
/// Scales of one component of a tile.
type Scales = [f32; TILE / SHARE];
/// Tiles in one task of rayon.
const SPAN: usize = 128;
/// Vectors whose sums are kept in registers together: three channels of them fill the registers of AVX2.
const GROUP: usize = 4;

/// Stored type of a value of the basis: a byte or a half.
pub trait BasisValue: Copy + Sync {
    /// Convert values to f32 in `wide`, which has the same length; scales are applied later.
    fn widen(stored: &[Self], wide: &mut [f32]);
}

impl BasisValue for i8 {
    #[inline(always)]
    fn widen(stored: &[Self], wide: &mut [f32]) {
        for (wide, &value) in wide.iter_mut().zip(stored) {
            *wide = f32::from(value);
        }
    }
}

impl BasisValue for f16 {
    #[inline(always)]
    fn widen(stored: &[Self], wide: &mut [f32]) {
        stored.convert_to_f32_slice(wide);
    }
}

/// Images with these `coefficients`, in tiles.
///
/// # Inputs
///
/// - `values`: (tiles, rank, 32), bytes or halves.
/// - `scales`: (tiles, rank, 2).
/// - `coefficients`: (n, components, 3) for the first components; the others are not read.
/// - `places`: index in `values` of each tile of an image; a negative index marks a black tile.
///
/// # Returns
///
/// (n, 32 `places.len()`, 3).
///
/// # Errors
///
/// [`Error::WrongShape`] for tiles of another size or coefficients that are no RGB, [`Error::OutOfRange`] for
/// more components than the basis has, or a place that is not in `values`; [`Error::NoMemory`].
pub fn frames<T: BasisValue>(
    values: ArrayView3<'_, T>,
    scales: ArrayView3<'_, f32>,
    coefficients: ArrayView3<'_, f32>,
    places: &[i64],
) -> Result<Array3<f32>> {
    let (values, scales) = (values.as_standard_layout(), scales.as_standard_layout());
    let basis = TiledBasis::new(values.view(), scales.view())?;
    basis.check(coefficients, places)?;
    check_memory(&[3 * coefficients.dim().0, TILE * places.len().div_ceil(2)])?; // 4 bytes each
    // Copy the coefficients of each image in rows of RGB.
    let images: Vec<Vec<[f32; 3]>> = coefficients
        .outer_iter()
        .map(|rows| rows.rows().into_iter().map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect())
        .collect();
    // Mix some tiles of all images in each task.
    let mut out = Array3::zeros((images.len(), TILE * places.len(), 3));
    let arch = Arch::new();
    out.axis_chunks_iter_mut(Axis(1), TILE * SPAN).into_par_iter().zip(places.par_chunks(SPAN)).for_each(
        |(mut out, places)| {
            interrupt::check();
            let mut out: Vec<_> = out
                .outer_iter_mut()
                .map(|image| image.into_slice().unwrap_or_default().as_chunks_mut::<3>().0)
                .collect();
            arch.dispatch(Span { basis: &basis, out: &mut out, images: &images, places });
        },
    );
    Ok(out)
}

/// Stored tiles of the basis with their scales.
struct TiledBasis<'a, T> {
    values: &'a [[T; TILE]],
    scales: &'a [Scales],
    rank: usize,
}

impl<'a, T: BasisValue> TiledBasis<'a, T> {
    /// View of arrays in the standard layout.
    fn new(values: ArrayView3<'a, T>, scales: ArrayView3<'a, f32>) -> Result<Self> {
        let (tiles, rank, lanes) = values.dim();
        if lanes != TILE {
            let shape = values.shape().to_vec();
            return Err(Error::WrongShape { what: "values", wanted: "(tiles, rank, 32)", shape });
        }
        if scales.dim() != (tiles, rank, TILE / SHARE) {
            let (wanted, shape) = ("(tiles, rank, 2), as values have it", scales.shape().to_vec());
            return Err(Error::WrongShape { what: "scales", wanted, shape });
        }
        let (values, _) = values.to_slice().unwrap_or_default().as_chunks();
        Ok(Self { values, scales: scales.to_slice().unwrap_or_default().as_chunks().0, rank })
    }

    fn check(&self, coefficients: ArrayView3<'_, f32>, places: &[i64]) -> Result<()> {
        let (_, components, channels) = coefficients.dim();
        if channels != 3 {
            let (wanted, shape) = ("(n, components, 3)", coefficients.shape().to_vec());
            return Err(Error::WrongShape { what: "coefficients", wanted, shape });
        }
        if components > self.rank {
            return Err(Error::OutOfRange {
                what: "the number of components in coefficients",
                value: components as f64,
                least: 0.0,
                most: self.rank as f64,
            });
        }
        let tiles = self.values.len().checked_div(self.rank).unwrap_or(0);
        match places.iter().find(|&&place| place >= tiles as i64) {
            None => Ok(()),
            Some(&place) => Err(Error::OutOfRange {
                what: "places",
                value: place as f64,
                least: -1.0,
                most: tiles as f64 - 1.0,
            }),
        }
    }
}

/// Several tiles of all images, computed with the widest vectors of the processor.
struct Span<'a, T> {
    basis: &'a TiledBasis<'a, T>,
    out: &'a mut [&'a mut [[f32; 3]]],
    images: &'a [Vec<[f32; 3]>],
    places: &'a [i64],
}

impl<T: BasisValue> WithSimd for Span<'_, T> {
    type Output = ();

    /// Convert each tile to f32 once and mix it for every image.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let components = self.images.first().map_or(0, Vec::len);
        let mut wide = vec![[0.0; TILE]; components];
        for (tile, &place) in self.places.iter().enumerate() {
            // Skip black tiles.
            let Ok(place) = usize::try_from(place) else { continue };
            let first = self.basis.rank * place;
            let stored = &self.basis.values[first..first + components];
            let scales = &self.basis.scales[first..first + components];
            // Convert the tile in one long loop, which the compiler vectorises.
            T::widen(stored.as_flattened(), wide.as_flattened_mut());
            // Scale each half of the tile.
            for (wide, scales) in wide.iter_mut().zip(scales) {
                for (wide, &scale) in wide.as_chunks_mut::<SHARE>().0.iter_mut().zip(scales) {
                    let scale = simd.splat_f32s(scale);
                    for value in S::as_mut_simd_f32s(wide).0 {
                        *value = simd.mul_f32s(*value, scale);
                    }
                }
            }
            // Mix the tile of each image.
            for (out, coefficients) in self.out.iter_mut().zip(self.images) {
                let [red, green, blue] = mix(simd, &wide, coefficients);
                for (lane, texel) in out[TILE * tile..TILE * (tile + 1)].iter_mut().enumerate() {
                    *texel = [red[lane], green[lane], blue[lane]];
                }
            }
        }
    }
}

/// The three channels of a tile.
#[inline(always)]
fn mix<S: Simd>(simd: S, components: &[[f32; TILE]], coefficients: &[[f32; 3]]) -> [[f32; TILE]; 3] {
    const { assert!((TILE / S::F32_LANES).is_multiple_of(GROUP), "a tile must be whole groups of vectors") };
    let mut sums = [[0.0; TILE]; 3];
    for group in 0..TILE / S::F32_LANES / GROUP {
        let mut vectors = [[simd.splat_f32s(0.0); 3]; GROUP];
        for (component, rgb) in components.iter().zip(coefficients) {
            let (component, _) = S::as_simd_f32s(component);
            let rgb = rgb.map(|value| simd.splat_f32s(value));
            // By index, so that the compiler keeps each sum in one register: half again as fast.
            for i in 0..GROUP {
                for channel in 0..3 {
                    let value = component[GROUP * group + i];
                    vectors[i][channel] = simd.mul_add_e_f32s(rgb[channel], value, vectors[i][channel]);
                }
            }
        }
        for (channel, sums) in sums.iter_mut().enumerate() {
            let (sums, _) = S::as_mut_simd_f32s(sums);
            for i in 0..GROUP {
                sums[GROUP * group + i] = vectors[i][channel];
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use ndarray::s;

    use super::*;

    /// 1, the least and the largest normal, subnormal ones, both zeros.
    #[test]
    fn halves_are_widened_exactly() {
        let kept = [0x3c00, 0xc000, 0x0400, 0x7bff, 0x0001, 0x83ff, 0x0000, 0x8000].map(f16::from_bits);
        let expected =
            [1.0, -2.0, 2f32.powi(-14), 65504.0, 2f32.powi(-24), -1023.0 * 2f32.powi(-24), 0.0, -0.0];
        let mut wide = [f32::NAN; 8];
        f16::widen(&kept, &mut wide);
        assert_eq!(wide.map(f32::to_bits), expected.map(f32::to_bits));
    }

    /// Small whole numbers: the sums are exact. One tile is black, one image stops at two components.
    #[test]
    fn frames_are_the_sums_over_the_components() {
        let (tiles, rank) = (SPAN + 3, 5);
        let values = Array3::from_shape_fn((tiles, rank, TILE), |(i, r, l)| (i + 3 * r + 7 * l) as i8 % 13);
        let scales = Array3::from_shape_fn((tiles, rank, 2), |(i, r, h)| 2f32.powi((i + r + h) as i32 % 3));
        let coefficients = Array3::from_shape_fn((2, rank, 3), |(n, r, c)| (n + 2 * r + c) as f32 - 4.0);
        let mut places: Vec<i64> = (0..tiles as i64).rev().collect();
        places[7] = -1;
        for components in [rank, 2, 0] {
            let coefficients = coefficients.slice(s![.., ..components, ..]);
            let result = frames(values.view(), scales.view(), coefficients, &places).expect("they fit");
            for ((n, t, c), &result) in result.indexed_iter() {
                let expected = usize::try_from(places[t / TILE]).map_or(0.0, |tile| {
                    let term = |r| {
                        coefficients[[n, r, c]]
                            * scales[[tile, r, t % TILE / SHARE]]
                            * f32::from(values[[tile, r, t % TILE]])
                    };
                    (0..components).map(term).sum()
                });
                assert!(
                    (result - expected).abs() < 1e-9,
                    "image {n}, texel {t}, channel {c}: {result}, {expected}"
                );
            }
        }
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let values = Array3::<i8>::zeros((2, 1, TILE));
        let scales = Array3::ones((2, 1, 2));
        let call = |values: &Array3<i8>, components, places: &[i64]| {
            let coefficients = Array3::zeros((1, components, 3));
            frames(values.view(), scales.view(), coefficients.view(), places)
                .map_or_else(|error| error.to_string(), |_| String::new())
        };
        let components = "the number of components in coefficients must be from 0 to 1; got 2";
        assert_eq!(call(&values, 2, &[0]), components);
        assert_eq!(call(&values, 1, &[2]), "places must be from -1 to 1; got 2");
        let tiles = "values must have the shape (tiles, rank, 32); got [2, 1, 16]";
        assert_eq!(call(&Array3::zeros((2, 1, 16)), 1, &[0]), tiles);
        let scaled = "scales must have the shape (tiles, rank, 2), as values have it; got [2, 1, 2]";
        assert_eq!(call(&Array3::zeros((2, 2, TILE)), 1, &[0]), scaled);
        let two = Array3::zeros((1, 1, 2));
        let refusal = frames(values.view(), scales.view(), two.view(), &[0]).map_err(|e| e.to_string());
        let expected = "coefficients must have the shape (n, components, 3); got [1, 1, 2]";
        assert_eq!(refusal, Err(expected.to_owned()));
    }

    /// Arrays in Fortran order, as `numpy` saves a transposed array.
    #[test]
    fn a_basis_in_another_order_is_the_same() {
        let values = Array3::from_shape_fn((2, 3, TILE), |(i, r, l)| (i + 3 * r + 7 * l) as i8 % 13);
        let scales = Array3::from_shape_fn((2, 3, 2), |(i, r, h)| (i + 2 * r + 5 * h) as f32);
        let coefficients = Array3::from_shape_fn((1, 3, 3), |(_, r, c)| (r + c) as f32);
        let call = |values: ArrayView3<'_, i8>, scales: ArrayView3<'_, f32>| {
            frames(values, scales, coefficients.view(), &[1, 0]).expect("they fit")
        };
        let reversed = |array: &Array3<f32>| array.t().as_standard_layout().into_owned();
        let transposed = values.t().as_standard_layout().into_owned();
        assert_eq!(call(values.view(), scales.view()), call(transposed.t(), reversed(&scales).t()));
    }
}
