//! Blocks of an OpenEXR part: strips of rows or tiles, each found by the table and unpacked by itself.

use std::borrow::Cow;
use std::ops::Range;

use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{IntegerBounds, SampleType as FileType};
use half::f16;
use rayon::prelude::*;

use super::attributes::{int, take};
use super::part::Part;
use super::zip;
use crate::error::Result;
use crate::formats::input::damage;
use crate::interrupt;

/// Type into which samples are read.
pub trait Sample: Copy + Default + Send + Sync {
    /// Sample of a half float.
    fn of_half(sample: f16) -> Self;
    /// Sample of a float.
    fn of_float(sample: f32) -> Self;
}

impl Sample for f16 {
    fn of_half(sample: f16) -> Self {
        sample
    }

    fn of_float(sample: f32) -> Self {
        Self::from_f32(sample)
    }
}

impl Sample for f32 {
    fn of_half(sample: f16) -> Self {
        sample.to_f32()
    }

    fn of_float(sample: f32) -> Self {
        sample
    }
}

/// Bytes of the samples of a block, line after line, whose channels lie one after another in each line.
enum Bytes<'a> {
    /// In the byte order of this machine.
    Whole(Cow<'a, [u8]>),
    /// The lower byte of each pair, and then the upper ones.
    Planes(Vec<u8>),
}

/// Reader of some channels of a part.
pub struct Blocks<'a> {
    /// Bytes of the file.
    pub bytes: &'a [u8],
    /// Part that is read.
    pub part: &'a Part,
    /// Numbers of the channels in the file.
    pub channels: Vec<usize>,
}

impl Blocks<'_> {
    /// Write the samples of some `rows` into `out`, pixel after pixel.
    pub fn read<T: Sample>(&self, rows: Range<usize>, mut out: &mut [T]) -> Result<()> {
        let (size, row) = (self.part.block.height(), self.part.layout.layer_size.0 * self.channels.len());
        let mut bands = Vec::new();
        let mut top = rows.start;
        while top < rows.end {
            let bottom = ((top / size + 1) * size).min(rows.end);
            let (band, rest) = out.split_at_mut((bottom - top) * row);
            bands.push((top..bottom, band));
            (out, top) = (rest, bottom);
        }
        bands.into_par_iter().try_for_each(|(rows, out)| self.read_band(rows, out))
    }

    /// Write `rows` that lie in one row of blocks.
    fn read_band<T: Sample>(&self, rows: Range<usize>, out: &mut [T]) -> Result<()> {
        let Vec2(width, height) = self.part.block;
        let row = rows.start / height;
        let columns = 0..self.part.layout.layer_size.0.div_ceil(width);
        let blocks = columns.into_par_iter().map(|column| self.unpack(Vec2(column, row)));
        let blocks: Vec<_> = blocks.collect::<Result<_>>()?;
        let lines = rows.start - row * height..rows.end - row * height;
        for (column, (bytes, columns)) in blocks.iter().enumerate() {
            self.copy(bytes, *columns, lines.clone(), column * width, out);
        }
        Ok(())
    }

    /// Samples of a block, and their columns.
    fn unpack(&self, place: Vec2<usize>) -> Result<(Bytes<'_>, usize)> {
        interrupt::check();
        let packed = self.find(place).ok_or_else(|| damage(DAMAGE))?;
        let (layout, block) = (&self.part.layout, self.part.block);
        let left_top = Vec2(place.0 * block.0, place.1 * block.1);
        let size = Vec2(
            block.0.min(layout.layer_size.0 - left_top.0),
            block.1.min(layout.layer_size.1 - left_top.1),
        );
        let length = size.area() * layout.channels.bytes_per_pixel;
        let bytes = match layout.compression {
            // What does not become smaller is stored as it is.
            _ if cfg!(target_endian = "little") && packed.len() == length => {
                Some(Bytes::Whole(packed.into()))
            }
            Compression::ZIP1 | Compression::ZIP16 if packed.len() != length => {
                zip::unpack(packed, length).map(Bytes::Planes)
            }
            Compression::DWAA(_) | Compression::DWAB(_)
                if !claims_fit(packed, size, layout.channels.bytes_per_pixel) =>
            {
                None
            }
            compression => {
                let bounds = IntegerBounds::new(left_top.to_i32(), size);
                let bytes =
                    compression.decompress_image_section_from_le(layout, packed.to_vec(), bounds, true);
                bytes.ok().map(|bytes| Bytes::Whole(bytes.into()))
            }
        };
        bytes.map(|bytes| (bytes, size.0)).ok_or_else(|| damage(DAMAGE))
    }

    /// Bytes of a block in the file; None if they are not there.
    fn find(&self, Vec2(column, row): Vec2<usize>) -> Option<&[u8]> {
        let layout = &self.part.layout;
        let columns = layout.layer_size.0.div_ceil(self.part.block.0);
        let entry = self.part.table + size_of::<u64>() * (row * columns + column);
        let offset = u64::from_le_bytes(*self.bytes.get(entry..)?.first_chunk()?);
        let mut rest = self.bytes.get(usize::try_from(offset).ok()?..)?;
        let mut is_next = |wanted: i64| int(&mut rest).is_ok_and(|found| i64::from(found) == wanted);
        let top = i64::from(layout.own_attributes.layer_position.1) + (row * self.part.block.1) as i64;
        let is_here = self.part.number.is_none_or(|number| is_next(number as i64))
            && match layout.blocks {
                BlockDescription::ScanLines => is_next(top),
                BlockDescription::Tiles(_) => {
                    [column, row, 0, 0].iter().all(|&number| is_next(number as i64))
                }
            };
        let length = int(&mut rest).ok()?;
        take(&mut rest, usize::try_from(length).ok()?).ok().filter(|_| is_here)
    }

    /// Copy some `lines` of the samples of a block.
    fn copy<T: Sample>(
        &self,
        block: &Bytes<'_>,
        columns: usize,
        lines: Range<usize>,
        left: usize,
        out: &mut [T],
    ) {
        let list = &self.part.layout.channels;
        let (width, channels) = (self.part.layout.layer_size.0, self.channels.len());
        let starts = self.starts(columns);
        for (line, out) in lines.zip(out.chunks_exact_mut((width * channels).max(1))) {
            let pixels = &mut out[left * channels..][..columns * channels];
            for (place, &channel) in self.channels.iter().enumerate() {
                let kind = list.list[channel].sample_type;
                let start = line * columns * list.bytes_per_pixel + starts[channel];
                let bytes = start..start + kind.bytes_per_sample() * columns;
                match channels {
                    // The usual number, known to the compiler, takes half the time.
                    3 => block.copy(
                        kind,
                        bytes,
                        pixels.as_chunks_mut::<3>().0.iter_mut().map(|pixel| &mut pixel[place]),
                    ),
                    _ => block.copy(kind, bytes, pixels[place..].iter_mut().step_by(channels)),
                }
            }
        }
    }

    /// Start of each channel in a line of the block, in bytes.
    fn starts(&self, columns: usize) -> Vec<usize> {
        let sizes =
            self.part.layout.channels.list.iter().map(|channel| channel.sample_type.bytes_per_sample());
        let next = |start: &mut usize, size| Some(std::mem::replace(start, *start + size * columns));
        sizes.scan(0, next).collect()
    }
}

/// True if the lengths that a block of DWA claims fit its size: the crate (1.74.2) allocates any, and ends the process.
fn claims_fit(packed: &[u8], size: Vec2<usize>, pixel_bytes: usize) -> bool {
    // The cosine transform is that of squares with this side.
    let side = 8;
    let most = 2 * size.0.next_multiple_of(side) * size.1.next_multiple_of(side) * pixel_bytes;
    let lengths = packed.as_chunks::<8>().0;
    let fits = |length: &[u8; 8]| u64::from_le_bytes(*length) <= most as u64;
    // Unpacked lengths: raw samples, tokens and bytes of runs, AC and DC of the cosine transform.
    [1, 6, 7, 8, 9].into_iter().all(|place| lengths.get(place).is_some_and(fits))
}

/// Refusal of a block, the same for all damages: threads find them in any order.
const DAMAGE: &str = "a block of its pixels is damaged or missing";

impl Bytes<'_> {
    /// Write the samples in a `range` of the bytes.
    fn copy<'a, T: Sample + 'a>(
        &self,
        kind: FileType,
        range: Range<usize>,
        out: impl Iterator<Item = &'a mut T>,
    ) {
        match self {
            Self::Whole(bytes) if kind == FileType::F16 => {
                let samples = bytes[range].as_chunks().0;
                out.zip(samples).for_each(|(out, &bytes)| *out = T::of_half(f16::from_ne_bytes(bytes)));
            }
            Self::Whole(bytes) => {
                let samples = bytes[range].as_chunks().0;
                out.zip(samples).for_each(|(out, &bytes)| *out = T::of_float(f32::from_ne_bytes(bytes)));
            }
            Self::Planes(bytes) => {
                let (lower, upper) = bytes.split_at(bytes.len() / 2);
                let range = range.start / 2..range.end / 2;
                copy_planes(kind, &lower[range.clone()], &upper[range], out);
            }
        }
    }
}

/// Write samples whose pairs of bytes have the `lower` and `upper` bytes, in the byte order of the file.
fn copy_planes<'a, T: Sample + 'a>(
    kind: FileType,
    lower: &[u8],
    upper: &[u8],
    out: impl Iterator<Item = &'a mut T>,
) {
    if kind == FileType::F16 {
        let pairs = lower.iter().zip(upper).map(|(&lower, &upper)| f16::from_le_bytes([lower, upper]));
        out.zip(pairs).for_each(|(out, sample)| *out = T::of_half(sample));
    } else {
        let pairs = lower.as_chunks::<2>().0.iter().zip(upper.as_chunks::<2>().0);
        let samples =
            pairs.map(|(lower, upper)| f32::from_le_bytes([lower[0], upper[0], lower[1], upper[1]]));
        out.zip(samples).for_each(|(out, sample)| *out = T::of_float(sample));
    }
}
