//! Samples of the components of a JPEG picture, and rows of colours from them.
//!
//! Chroma of half resolution is interpolated by the triangle filter of libjpeg ("fancy upsampling"), in its integers.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::frame::{Block, Frame};
use super::inverse::{GROUP, Workspace};
use crate::error::Result;
use crate::formats::input::{damage, zeros};

/// Samples of all components.
#[derive(Debug)]
pub(super) struct Planes {
    planes: Vec<Plane>,
    width: usize,
}

/// Samples of one component, in whole blocks.
#[derive(Debug)]
struct Plane {
    samples: Vec<u8>,
    stride: usize,
    /// Rows and columns that belong to the picture.
    height: usize,
    width: usize,
    /// Pixels of the picture in a row and in a column of one sample.
    across: usize,
    down: usize,
    /// Rows of blocks in a row of units.
    unit: usize,
    /// Steps of quantisation; None before the first scan.
    steps: Option<[i32; 64]>,
}

/// Relation of components and colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Model {
    /// One component.
    Grey,
    /// Luminance and two colour differences.
    Differences,
    /// Red, green and blue.
    Rgb,
    /// Cyan, magenta, yellow and black, each as 255 less its amount.
    Cmyk,
    /// Cyan, magenta and yellow as luminance and differences, and black.
    CmykDifferences,
}

impl Planes {
    pub fn new(frame: &Frame) -> Result<Self> {
        let (units, unit) = (frame.units(), frame.unit());
        let planes = frame.components.iter().map(|component| {
            let (height, width) = frame.samples(component);
            let stride = 8 * units.1 * component.across;
            let rows = 8 * units.0 * component.down;
            Ok(Plane {
                samples: zeros((rows, stride, 1), rows * stride)?,
                stride,
                height,
                width,
                across: unit.0 / component.across,
                down: unit.1 / component.down,
                unit: component.down,
                steps: None,
            })
        });
        Ok(Self { planes: planes.collect::<Result<_>>()?, width: frame.width })
    }

    /// Set the steps of quantisation of a component, those of its first scan.
    pub fn set_steps(&mut self, component: usize, steps: Option<&[i32; 64]>) -> Result<()> {
        let kept = &mut self.planes[component].steps;
        *kept = kept.or(steps.copied());
        kept.map(|_| ()).ok_or_else(|| damage("the JPEG file is damaged: it has no steps of quantisation"))
    }

    /// Transform the `blocks` of the components, whose first row of units is `first`.
    pub fn transform(&mut self, first: usize, blocks: &[Vec<Block>]) {
        for (plane, blocks) in self.planes.iter_mut().zip(blocks) {
            let Some(steps) = plane.steps else { continue };
            let start = first * plane.unit * 8 * plane.stride;
            let rows = plane.samples[start..].par_chunks_mut(8 * plane.stride);
            let stride = plane.stride;
            rows.zip(blocks.par_chunks(stride / 8)).for_each(|(out, blocks)| {
                Arch::new().dispatch(Transform { blocks, steps: &steps, stride, out });
            });
        }
    }

    /// Write some rows of colours, from the row `first` on, into `out`: one sample for each pixel of grey, else three.
    pub fn write_rows(&self, model: Model, first: usize, out: &mut [u8]) {
        /// Rows of a task, which allocates rows of components.
        const ROWS: usize = 16;
        let size = ROWS * model.channels() * self.width;
        out.par_chunks_mut(size).enumerate().for_each(|(task, out)| {
            Arch::new().dispatch(Write { planes: self, model, first: first + task * ROWS, out });
        });
    }

    #[inline(always)]
    fn write_row(&self, model: Model, row: usize, scratch: &mut [Scratch], out: &mut [u8]) {
        let mut rows: [&[u8]; 4] = [&[]; 4];
        for ((plane, scratch), samples) in self.planes.iter().zip(scratch).zip(&mut rows) {
            *samples = &plane.full_row(row, scratch)[..self.width];
        }
        match model {
            Model::Grey => out.copy_from_slice(rows[0]),
            Model::Rgb => write_pixels(rows, out, |[red, green, blue, _]| [red, green, blue]),
            Model::Differences => write_pixels(rows, out, |[y, cb, cr, _]| rgb(y, cb, cr)),
            Model::Cmyk => write_pixels(rows, out, |[c, m, y, k]| [c, m, y].map(|ink| product(ink, k))),
            Model::CmykDifferences => {
                write_pixels(rows, out, |[y, cb, cr, k]| rgb(y, cb, cr).map(|ink| product(255 - ink, k)));
            }
        }
    }
}

impl Model {
    /// Samples of a pixel.
    pub fn channels(self) -> usize {
        if self == Self::Grey { 1 } else { 3 }
    }
}

/// Transform of a row of `blocks` with the vectors of the processor.
struct Transform<'a> {
    blocks: &'a [Block],
    steps: &'a [i32; 64],
    stride: usize,
    out: &'a mut [u8],
}

impl WithSimd for Transform<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut workspace = Workspace::new();
        for (place, blocks) in self.blocks.chunks(GROUP).enumerate() {
            workspace.inverse(blocks, self.steps, self.stride, &mut self.out[8 * GROUP * place..]);
        }
    }
}

/// Operation of [`Planes::write_rows`] with the vectors of the processor.
struct Write<'a> {
    planes: &'a Planes,
    model: Model,
    first: usize,
    out: &'a mut [u8],
}

impl WithSimd for Write<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { planes, model, first, out } = self;
        let mut scratch = vec![Scratch::default(); planes.planes.len()];
        for (row, out) in (first..).zip(out.chunks_exact_mut(model.channels() * planes.width)) {
            planes.write_row(model, row, &mut scratch, out);
        }
    }
}

/// Write the `colour` of each pixel: first one plane for each channel, by vectors, then pixel after pixel.
#[inline(always)]
fn write_pixels(rows: [&[u8]; 4], out: &mut [u8], colour: impl Fn([u8; 4]) -> [u8; 3]) {
    const PIXELS: usize = 64;
    for (place, out) in out.chunks_mut(3 * PIXELS).enumerate() {
        let (first, count) = (PIXELS * place, out.len() / 3);
        let mut samples = [[0; PIXELS]; 4];
        for (samples, row) in samples.iter_mut().zip(rows).filter(|(_, row)| !row.is_empty()) {
            samples[..count].copy_from_slice(&row[first..first + count]);
        }
        let mut colours = [[0; PIXELS]; 3];
        for x in 0..PIXELS {
            let [red, green, blue] = colour([samples[0][x], samples[1][x], samples[2][x], samples[3][x]]);
            (colours[0][x], colours[1][x], colours[2][x]) = (red, green, blue);
        }
        for (x, out) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *out = [colours[0][x], colours[1][x], colours[2][x]];
        }
    }
}

/// Colour of luminance and differences (ITU-T T.871, 7), in the integers of libjpeg.
#[inline(always)]
fn rgb(y: u8, cb: u8, cr: u8) -> [u8; 3] {
    /// 65536 times 1.402, 1.772, 0.71414 and 0.34414.
    const FACTORS: [i32; 4] = [91_881, 116_130, 46_802, 22_554];
    let (y, cb, cr) = (i32::from(y), i32::from(cb) - 128, i32::from(cr) - 128);
    let red = y + ((FACTORS[0] * cr + 32_768) >> 16);
    let green = y + ((-FACTORS[3] * cb - FACTORS[2] * cr + 32_768) >> 16);
    let blue = y + ((FACTORS[1] * cb + 32_768) >> 16);
    [red.clamp(0, 255) as u8, green.clamp(0, 255) as u8, blue.clamp(0, 255) as u8]
}

/// Product of two samples as fractions of 255.
#[inline(always)]
fn product(a: u8, b: u8) -> u8 {
    ((2 * u32::from(a) * u32::from(b) + 255) / 510) as u8
}

/// Memory for a row of a component.
#[derive(Clone, Default)]
struct Scratch {
    /// Sums over two rows, with a copy of the first and of the last one around them.
    sums: Vec<u16>,
    samples: Vec<u8>,
}

impl Plane {
    /// Samples of a `row` of the picture, one or more for each pixel.
    #[inline(always)]
    fn full_row<'a>(&'a self, row: usize, scratch: &'a mut Scratch) -> &'a [u8] {
        // libjpeg interpolates no shorter rows.
        let is_wide = self.width > 2;
        match (self.across, self.down) {
            (1, 1) => return self.row(row),
            (1, 2) => self.between_rows(row, scratch),
            (2, 1) if is_wide => self.between_columns(self.row(row), None, scratch),
            (2, 2) if is_wide => self.between_columns(self.row(row / 2), Some(self.other_row(row)), scratch),
            _ => self.repeat(row / self.down, scratch),
        }
        &scratch.samples
    }

    /// Samples of a row of this component.
    #[inline(always)]
    fn row(&self, row: usize) -> &[u8] {
        &self.samples[row * self.stride..][..self.width]
    }

    /// Second nearest row of samples to a `row` of the picture, at twice the resolution.
    #[inline(always)]
    fn other_row(&self, row: usize) -> &[u8] {
        let other = if row.is_multiple_of(2) {
            (row / 2).saturating_sub(1)
        } else {
            (row / 2 + 1).min(self.height - 1)
        };
        self.row(other)
    }

    #[inline(always)]
    fn between_rows(&self, row: usize, scratch: &mut Scratch) {
        let bias = 1 + row as u16 % 2;
        scratch.samples.resize(self.width, 0);
        let rows = self.row(row / 2).iter().zip(self.other_row(row));
        for (out, (&near, &far)) in scratch.samples.iter_mut().zip(rows) {
            *out = ((3 * u16::from(near) + u16::from(far) + bias) >> 2) as u8;
        }
    }

    /// Interpolate a row in columns, after its mean with `other` row at weights of 3 to 1.
    #[inline(always)]
    fn between_columns(&self, near: &[u8], other: Option<&[u8]>, scratch: &mut Scratch) {
        let Scratch { sums, samples } = scratch;
        sums.resize(self.width + 2, 0);
        samples.resize(2 * self.width, 0);
        let inner = &mut sums[1..=self.width];
        if let Some(other) = other {
            for (sum, (&near, &far)) in inner.iter_mut().zip(near.iter().zip(other)) {
                *sum = 3 * u16::from(near) + u16::from(far);
            }
        } else {
            for (sum, &near) in inner.iter_mut().zip(near) {
                *sum = u16::from(near);
            }
        }
        (sums[0], sums[self.width + 1]) = (sums[1], sums[self.width]);
        let (biases, shift) = if other.is_some() { ([8, 7], 4) } else { ([1, 2], 2) };
        let windows = sums.iter().zip(&sums[1..]).zip(&sums[2..]);
        for (out, ((&before, &sum), &after)) in samples.as_chunks_mut::<2>().0.iter_mut().zip(windows) {
            *out = [(3 * sum + before + biases[0]) >> shift, (3 * sum + after + biases[1]) >> shift]
                .map(|sum| sum as u8);
        }
    }

    #[inline(always)]
    fn repeat(&self, row: usize, scratch: &mut Scratch) {
        scratch.samples.clear();
        scratch
            .samples
            .extend(self.row(row).iter().flat_map(|&sample| std::iter::repeat_n(sample, self.across)));
    }
}
