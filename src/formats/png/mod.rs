//! PNG files, by the crate `png`: samples of 8 or 16 bits and the statements about their colour.

mod texts;
pub mod write;

use std::io::Cursor;
use std::ops::Range;
use std::slice::from_ref;

use ndarray::Array3;
use png::{
    BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Info, Limits, Reader, Transformations,
};

use crate::error::{Error, Result};
use crate::formats::exif;
use crate::formats::header::{Alpha, Colour, Header, SampleType, channels};
use crate::formats::input::{check_size, damage, zeros};
use crate::formats::picture::{PictureFile, Samples, SamplesMut, WholeSamples};

/// A PNG file whose header was read.
#[derive(Debug)]
pub struct Png<Bytes> {
    bytes: Bytes,
    header: Header,
    max_pixels: usize,
    samples: WholeSamples,
}

impl<Bytes: AsRef<[u8]>> Png<Bytes> {
    /// File in `bytes` of at most `max_pixels`.
    ///
    /// # Errors
    ///
    /// If it is damaged, or the image has too many pixels.
    pub fn open(bytes: Bytes, max_pixels: usize) -> Result<Self> {
        let header = header(bytes.as_ref(), max_pixels)?;
        Ok(Self { bytes, header, max_pixels, samples: WholeSamples::default() })
    }
}

impl<Bytes: AsRef<[u8]> + Send + Sync> PictureFile for Png<Bytes> {
    fn parts(&self) -> &[Header] {
        from_ref(&self.header)
    }

    fn read(&self, _: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()> {
        self.samples.copy(channels, rows, out, || samples(self.bytes.as_ref(), self.max_pixels))
    }
}

/// Header of the PNG file in `bytes`.
fn header(bytes: &[u8], max_pixels: usize) -> Result<Header> {
    let reader = open(bytes, max_pixels)?;
    let (colour, depth) = reader.output_color_type();
    let info = reader.info();
    let sample = if depth == BitDepth::Sixteen { SampleType::U16 } else { SampleType::U8 };
    let names = ["Y", "YA", "RGB", "RGBA"][colour.samples() - 1];
    let exif = info.exif_metadata.as_deref().map(exif::numbers).unwrap_or_default();
    let size = (info.height as usize, info.width as usize);
    let mut header = Header::plain("png", size.0, size.1, channels(names, sample));
    header.alpha = if names.ends_with('A') { Alpha::Straight } else { Alpha::None };
    header.orientation = exif::orientation(&exif);
    header.exif = exif;
    header.colour = statements(info);
    header.xmp = vec![texts::xmp(info)];
    header.description = texts::description(info);
    if info.animation_control.is_some() {
        header.notes.push("only the first image of the animation was read".into());
    }
    Ok(header)
}

/// Statements of the chunks about colour.
fn statements(info: &Info<'_>) -> Colour {
    let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_scaled()) / SCALE);
    Colour {
        cicp: info.coding_independent_code_points.map(|codes| {
            let is_full = u8::from(codes.is_video_full_range_image);
            [codes.color_primaries, codes.transfer_function, codes.matrix_coefficients, is_full]
        }),
        icc: info.icc_profile.as_ref().map(|profile| profile.to_vec()).unwrap_or_default(),
        is_srgb: info.srgb.is_some(),
        gamma: gamma.filter(|&gamma| gamma > 0.0),
        chromaticities: chromaticities(info),
        ..Colour::default()
    }
}

/// Factor of the integers in the chunks gAMA and cHRM.
const SCALE: f64 = 100_000.0;

fn chromaticities(info: &Info<'_>) -> Option<[f64; 8]> {
    let said = info.chrm_chunk?;
    let (red, green, blue, white) = (said.red, said.green, said.blue, said.white);
    let numbers = [red.0, red.1, green.0, green.1, blue.0, blue.1, white.0, white.1];
    Some(numbers.map(|number| f64::from(number.into_scaled()) / SCALE))
}

/// All samples of the PNG file in `bytes`, which is read to its end.
fn samples(bytes: &[u8], max_pixels: usize) -> Result<Samples> {
    let mut reader = open(bytes, max_pixels)?;
    let (colour, depth) = reader.output_color_type();
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    let shape = (height, width, colour.samples());
    let no_memory = || Error::NoMemory { shape: vec![shape.0, shape.1, shape.2] };
    let size = reader.output_buffer_size().ok_or_else(no_memory)?;
    let mut samples = zeros(shape, size)?;
    let frame = reader.next_frame(&mut samples).map_err(|error| refusal(&error))?;
    if (frame.width as usize, frame.height as usize) != (width, height) {
        return Err(damage("the PNG file is damaged: its first image has another size than its header"));
    }
    reader.finish().map_err(|error| refusal(&error))?;
    if depth == BitDepth::Sixteen {
        let codes = samples.as_chunks().0.iter().map(|&code| u16::from_be_bytes(code)).collect();
        return Array3::from_shape_vec(shape, codes).map(Samples::Words).map_err(|_| no_memory());
    }
    Array3::from_shape_vec(shape, samples).map(Samples::Bytes).map_err(|_| no_memory())
}

/// Bytes for all texts and the profile, which may be packed.
const MOST_METADATA: usize = 1 << 25;

/// Reader in front of the pixels; palettes, transparent colours and few bits are expanded.
fn open(bytes: &[u8], max_pixels: usize) -> Result<Reader<Cursor<&[u8]>>> {
    let mut options = DecodeOptions::default();
    // By default the crate passes over the checksum of the pixels.
    options.set_ignore_adler32(false);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    decoder.set_limits(Limits { bytes: MOST_METADATA });
    decoder.set_transformations(Transformations::EXPAND);
    let info = decoder.read_header_info().map_err(|error| refusal(&error))?;
    check_size(info.height as usize, info.width as usize, max_pixels)?;
    let reader = decoder.read_info().map_err(|error| refusal(&error))?;
    check_palette(reader.info())?;
    Ok(reader)
}

/// Refuse a palette of other than 1 to 256 whole colours, on which the crate (0.18.1) panics.
fn check_palette(info: &Info<'_>) -> Result<()> {
    let palette = info.palette.as_deref().filter(|_| info.color_type == ColorType::Indexed);
    let length = palette.map_or(3, <[u8]>::len);
    if length.is_multiple_of(3) && (1..=256).contains(&(length / 3)) {
        return Ok(());
    }
    Err(damage(format!(
        "the PNG file is damaged: its palette has {length} bytes; wanted 1 to 256 colours of 3 bytes"
    )))
}

/// Sentence about the damage that the crate found.
fn refusal(error: &DecodingError) -> Error {
    let is_end =
        matches!(error, DecodingError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof);
    if is_end {
        return damage("the PNG file is incomplete");
    }
    damage(format!("the PNG file is damaged: {}", error.to_string().trim_end_matches('.')))
}
