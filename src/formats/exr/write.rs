//! Writer of OpenEXR: one image in strips of rows, as half floats or floats, the same bytes for any number of threads.

use std::io::Cursor;

use exr::block::chunk::Chunk;
use exr::block::writer::ChunksWriter;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::error::Result as ExrResult;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, Chromaticities, EnvironmentMap, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{BlockDescription, Headers};
use half::f16;
use ndarray::{ArrayView3, s};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::formats::input::check_size;
use crate::interrupt;

/// Lossless compressions by their names.
pub const COMPRESSIONS: [(&str, Compression); 5] = [
    ("zip", Compression::ZIP16),
    ("zips", Compression::ZIP1),
    ("piz", Compression::PIZ),
    ("rle", Compression::RLE),
    ("none", Compression::Uncompressed),
];

/// Storage and statements of a file.
#[derive(Clone, Debug)]
pub struct Options<'a> {
    /// Names of the channels; the colour is multiplied by "A".
    pub channels: &'a [&'a str],
    /// True for samples of 16 bits, false for 32.
    pub is_half: bool,
    /// Compression of `COMPRESSIONS`.
    pub compression: Compression,
    /// The x and y of red, green, blue and white.
    pub chromaticities: Option<[f32; 8]>,
    /// Luminance of RGB (1, 1, 1) in cd/m2.
    pub white_luminance: Option<f32>,
    /// Environment attribute: "latlong", "cube", or empty.
    pub environment: &'a str,
    /// Comments; empty for none.
    pub comments: &'a str,
}

/// Bytes of a file with the `samples`, (rows, width, channels).
///
/// # Errors
///
/// If there are no pixels, the number of channels differs from that of the names, or a side is too long.
pub fn write(samples: ArrayView3<'_, f32>, options: &Options<'_>) -> Result<Vec<u8>> {
    /// Blocks that are packed before they are written: enough for all threads, few for the memory.
    const BLOCKS_AT_ONCE: usize = 64;
    let (height, width, channels) = samples.dim();
    check_size(height, width, usize::MAX)?;
    if channels != options.channels.len() || channels == 0 {
        return Err(Error::WrongShape {
            what: "the samples of a picture",
            wanted: "(rows, columns, channels)",
            shape: samples.shape().to_vec(),
        });
    }
    let mut order: Vec<usize> = (0..channels).collect();
    order.sort_by_key(|&channel| options.channels[channel]);
    let headers = Headers::from_iter([header(height, width, &order, options)]);
    let mut bytes = Cursor::new(Vec::new());
    exr::block::write(&mut bytes, headers, true, |meta, writer| {
        let blocks: Vec<_> = meta.enumerate_ordered_header_block_indices().collect();
        for blocks in blocks.chunks(BLOCKS_AT_ONCE) {
            let packed = blocks.par_iter().map(|&(number, block)| {
                let packed = pack(&samples, block, &order, options.is_half, &meta.headers);
                packed.map(|chunk| (number, chunk))
            });
            for (number, chunk) in packed.collect::<ExrResult<Vec<_>>>()? {
                writer.write_chunk(number, chunk)?;
            }
        }
        Ok(())
    })
    .map_err(|_| Error::NoSuchLayout {
        what: "names of channels must differ, and sides be shorter than 2^30",
    })?;
    Ok(bytes.into_inner())
}

fn header(height: usize, width: usize, order: &[usize], options: &Options<'_>) -> Header {
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let sample = if options.is_half { SampleType::F16 } else { SampleType::F32 };
    let channel = |&channel: &usize| ChannelDescription::new(text(options.channels[channel]), sample, false);
    let channels = order.iter().map(channel).collect();
    let mut header = Header::new(text(""), (width, height), channels)
        .with_encoding(options.compression, BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(LayerAttributes {
            white_luminance: options.white_luminance,
            environment_map: match options.environment {
                "" => None,
                "cube" => Some(EnvironmentMap::Cube),
                _ => Some(EnvironmentMap::LatitudeLongitude),
            },
            comments: (!options.comments.is_empty()).then(|| text(options.comments)),
            ..LayerAttributes::default()
        });
    header.shared_attributes.chromaticities = options.chromaticities.map(|xy| Chromaticities {
        red: Vec2(xy[0], xy[1]),
        green: Vec2(xy[2], xy[3]),
        blue: Vec2(xy[4], xy[5]),
        white: Vec2(xy[6], xy[7]),
    });
    header
}

/// Compressed block: in each row, the samples of each channel one after another.
fn pack(
    samples: &ArrayView3<'_, f32>,
    index: BlockIndex,
    order: &[usize],
    is_half: bool,
    headers: &[Header],
) -> ExrResult<Chunk> {
    interrupt::check();
    let (top, rows) = (index.pixel_position.1, index.pixel_size.1);
    let mut data = Vec::with_capacity(rows * samples.dim().1 * headers[0].channels.bytes_per_pixel);
    for row in samples.slice(s![top..top + rows, .., ..]).outer_iter() {
        for &channel in order {
            let samples = row.column(channel);
            if is_half {
                samples
                    .iter()
                    .for_each(|&sample| data.extend_from_slice(&f16::from_f32(sample).to_ne_bytes()));
            } else {
                samples.iter().for_each(|sample| data.extend_from_slice(&sample.to_ne_bytes()));
            }
        }
    }
    UncompressedBlock { index, data }.compress_to_chunk(headers)
}
