//! One line of pixels, from packets to samples.

#![allow(clippy::inline_always, reason = "only inlined functions use the vectors of the processor")]

use pulp::{Arch, Simd, WithSimd};

use super::lines::{Line, old_run};

/// Longest packet; a plane has room for one that is copied as a whole.
const PACKET: usize = 128;
/// Bytes that are copied for every packet, without looking at its length.
const COPIED: usize = 32;

/// The bytes of a line, one plane for each of red, green, blue and exponent.
pub(super) struct Planes {
    bytes: [Vec<u8>; 4],
    width: usize,
}

impl Planes {
    pub fn new(width: usize) -> Self {
        Self { bytes: std::array::from_fn(|_| vec![0; width + COPIED]), width }
    }

    /// Write the samples of a `line` into `out`; `None` if its runs are damaged.
    pub fn decode(&mut self, bytes: &[u8], line: &Line, out: &mut [f32]) -> Option<()> {
        // A packet may be read as a whole before its length is known.
        let to = if line.is_planar { bytes.len().min(line.to + PACKET + 1) } else { line.to };
        let bytes = bytes.get(line.from..to)?;
        Arch::new().dispatch(Decode { bytes, is_planar: line.is_planar, planes: self, out })
    }

    #[inline(always)]
    fn expand_planes(&mut self, bytes: &[u8]) -> Option<()> {
        let mut at = 0;
        for plane in &mut self.bytes {
            at += expand_plane(bytes.get(at..)?, self.width, plane)?;
        }
        Some(())
    }

    #[inline(always)]
    fn expand_pixels(&mut self, bytes: &[u8]) -> Option<()> {
        let (mut x, mut shift, mut last) = (0, 0, [0; 4]);
        for &pixel in bytes.as_chunks::<4>().0 {
            let run = old_run(pixel, &mut shift);
            if run.is_none() {
                last = pixel;
            }
            let end = usize::checked_add(x, run.unwrap_or(1))?;
            for (plane, value) in self.bytes.iter_mut().zip(last) {
                plane.get_mut(x..end)?.fill(value);
            }
            x = end;
        }
        (x == self.width).then_some(())
    }
}

/// Operation of [`Planes::decode`] with the vectors of the processor.
struct Decode<'a> {
    bytes: &'a [u8],
    is_planar: bool,
    planes: &'a mut Planes,
    out: &'a mut [f32],
}

impl WithSimd for Decode<'_> {
    type Output = Option<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Option<()> {
        let Self { bytes, is_planar, planes, out } = self;
        if is_planar {
            planes.expand_planes(bytes)?;
        } else {
            planes.expand_pixels(bytes)?;
        }
        let width = planes.width;
        to_floats(planes.bytes.each_ref().map(|plane| &plane[..width]), out);
        Some(())
    }
}

/// Expand the packets of one plane into `out`, which is longer than `width`; return the bytes that they take.
#[inline(always)]
fn expand_plane(bytes: &[u8], width: usize, out: &mut [u8]) -> Option<usize> {
    let (mut x, mut at) = (0, 0);
    while x < width && at + PACKET < bytes.len() {
        let count = usize::from(bytes[at]);
        let is_run = count > PACKET;
        let pixels = if is_run { count - PACKET } else { count };
        let source: &[u8; COPIED] = bytes[at + 1..].first_chunk()?;
        // Select without a branch: packets are short, and their kinds are unpredictable.
        let mask = if is_run { 0xff } else { 0 };
        let first = source[0] & mask;
        let packet: &mut [u8; COPIED] = out.get_mut(x..)?.first_chunk_mut()?;
        for (packet, byte) in packet.iter_mut().zip(source) {
            *packet = (byte & !mask) | first;
        }
        if pixels > COPIED {
            let rest = out.get_mut(x + COPIED..x + pixels)?;
            if is_run {
                rest.fill(first);
            } else {
                rest.copy_from_slice(&bytes[at + 1 + COPIED..at + 1 + pixels]);
            }
        }
        x += pixels;
        at += if is_run { 2 } else { pixels + 1 };
    }
    expand_end(bytes, width, out, x, at)
}

/// Expand the packets near the end of the file, without reading beyond them.
fn expand_end(bytes: &[u8], width: usize, out: &mut [u8], mut x: usize, mut at: usize) -> Option<usize> {
    while x < width {
        let count = usize::from(*bytes.get(at)?);
        if count > PACKET {
            out.get_mut(x..x + count - PACKET)?.fill(*bytes.get(at + 1)?);
            x += count - PACKET;
            at += 2;
        } else {
            out.get_mut(x..x + count)?.copy_from_slice(bytes.get(at + 1..at + 1 + count)?);
            x += count;
            at += count + 1;
        }
    }
    (x == width).then_some(at)
}

/// The power 2^(e - 136), exact also where it is subnormal. The factor of exponent 0, which marks black, is 0.
#[inline(always)]
fn scale(exponent: u8) -> f32 {
    /// The power 2^-8: the bits of a normal number reach only down to 2^-126.
    const SHIFT: f32 = 1.0 / 256.0;
    let exponent = u32::from(exponent);
    let bits = if exponent > 1 { (exponent - 1) << 23 } else { exponent << 22 };
    f32::from_bits(bits) * SHIFT
}

/// Samples of four planes, three for each pixel.
#[inline(always)]
fn to_floats(planes: [&[u8]; 4], out: &mut [f32]) {
    const PIXELS: usize = 16;
    let (blocks, rest) = out.as_chunks_mut::<{ 3 * PIXELS }>();
    let done = blocks.len() * PIXELS;
    let [red, green, blue, exponent] = planes.map(|plane| plane.as_chunks::<PIXELS>().0);
    for ((((red, green), blue), exponent), out) in red.iter().zip(green).zip(blue).zip(exponent).zip(blocks) {
        let (mut scales, mut values) = ([0.0; PIXELS], [[0.0; PIXELS]; 3]);
        for (scale_of_pixel, &exponent) in scales.iter_mut().zip(exponent) {
            *scale_of_pixel = scale(exponent);
        }
        for (values, plane) in values.iter_mut().zip([red, green, blue]) {
            for i in 0..PIXELS {
                values[i] = f32::from(plane[i]) * scales[i];
            }
        }
        for i in 0..PIXELS {
            out[3 * i] = values[0][i];
            out[3 * i + 1] = values[1][i];
            out[3 * i + 2] = values[2][i];
        }
    }
    for (i, pixel) in rest.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        let scale = scale(planes[3][done + i]);
        *pixel = std::array::from_fn(|channel| f32::from(planes[channel][done + i]) * scale);
    }
}
