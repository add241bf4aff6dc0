//! PNG files, by the crate `png`: samples of 8 or 16 bits and the statements about their colour.

pub mod write;

use std::io::Cursor;

use ndarray::Array3;
use png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Info, Reader, Transformations};

use crate::error::{Error, Result};
use crate::formats::input::{check_size, damage, zeros};

/// Statements of a PNG file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Header {
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Samples of a pixel, 1 to 4; the last of 2 or 4 is alpha.
    pub channels: usize,
    /// True for samples of 16 bits, false for 8.
    pub is_16_bit: bool,
    /// Primaries, transfer function, matrix and full range of the chunk cICP.
    pub cicp: Option<[u8; 4]>,
    /// ICC profile of the chunk iCCP; empty without one.
    pub icc: Vec<u8>,
    /// True with a chunk sRGB.
    pub is_srgb: bool,
    /// Exponent of the chunk gAMA, such as 0.45455.
    pub gamma: Option<f64>,
    /// The x and y of red, green, blue and white, of the chunk cHRM.
    pub chromaticities: Option<[f64; 8]>,
    /// EXIF orientation, 1 to 8.
    pub orientation: u8,
    /// XMP packet; empty without one.
    pub xmp: Vec<u8>,
    /// True for an animation; its first image is read.
    pub is_animated: bool,
}

/// Samples in the type of the file, (height, width, channels).
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Samples of up to 8 bits, scaled to 8.
    Eight(Array3<u8>),
    /// Samples of 16 bits.
    Sixteen(Array3<u16>),
}

/// Header of the PNG file in `bytes`, of at most `max_pixels`.
///
/// # Errors
///
/// If it is damage, or the image has too many pixels.
pub fn header(bytes: &[u8], max_pixels: usize) -> Result<Header> {
    let reader = open(bytes, max_pixels)?;
    let (colour, depth) = reader.output_color_type();
    let info = reader.info();
    let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_scaled()) / SCALE);
    Ok(Header {
        height: info.height as usize,
        width: info.width as usize,
        channels: colour.samples(),
        is_16_bit: depth == BitDepth::Sixteen,
        cicp: info.coding_independent_code_points.map(|codes| {
            let is_full = u8::from(codes.is_video_full_range_image);
            [codes.color_primaries, codes.transfer_function, codes.matrix_coefficients, is_full]
        }),
        icc: info.icc_profile.as_ref().map(|profile| profile.to_vec()).unwrap_or_default(),
        is_srgb: info.srgb.is_some(),
        gamma: gamma.filter(|&gamma| gamma > 0.0),
        chromaticities: chromaticities(info),
        orientation: info.exif_metadata.as_deref().and_then(orientation).unwrap_or(1),
        xmp: xmp(info),
        is_animated: info.animation_control.is_some(),
    })
}

/// Factor of the integers in the chunks gAMA and cHRM.
const SCALE: f64 = 100_000.0;

fn chromaticities(info: &Info<'_>) -> Option<[f64; 8]> {
    let said = info.chrm_chunk?;
    let (red, green, blue, white) = (said.red, said.green, said.blue, said.white);
    let numbers = [red.0, red.1, green.0, green.1, blue.0, blue.1, white.0, white.1];
    Some(numbers.map(|number| f64::from(number.into_scaled()) / SCALE))
}

fn xmp(info: &Info<'_>) -> Vec<u8> {
    let packet = info.utf8_text.iter().find(|text| text.keyword == "XML:com.adobe.xmp");
    packet.and_then(|text| text.get_text().ok()).map(String::into_bytes).unwrap_or_default()
}

/// Value of the tag Orientation in the first directory of `exif`, which has the layout of TIFF.
fn orientation(exif: &[u8]) -> Option<u8> {
    const ORIENTATION: u16 = 0x112;
    const ENTRY: usize = 12;
    let is_little = match exif.first_chunk()? {
        b"II" => true,
        b"MM" => false,
        _ => return None,
    };
    let short = |at: usize| {
        let bytes = *exif.get(at..)?.first_chunk()?;
        Some(if is_little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let bytes = *exif.get(4..)?.first_chunk()?;
    let directory = if is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) } as usize;
    let entries = usize::from(short(directory)?);
    let mut places = (0..entries).map(|entry| directory + 2 + entry * ENTRY);
    let entry = places.find(|&place| short(place) == Some(ORIENTATION))?;
    let value = u8::try_from(short(entry + 8)?).ok()?;
    (1..=8).contains(&value).then_some(value)
}

/// All samples of the PNG file in `bytes`, of at most `max_pixels`; the file is read to its end.
///
/// # Errors
///
/// If the file is damaged or incomplete, the image has too many pixels, or there is no memory.
pub fn samples(bytes: &[u8], max_pixels: usize) -> Result<Samples> {
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
        return Array3::from_shape_vec(shape, codes).map(Samples::Sixteen).map_err(|_| no_memory());
    }
    Array3::from_shape_vec(shape, samples).map(Samples::Eight).map_err(|_| no_memory())
}

/// Reader in front of the pixels; palettes, transparent colours and few bits are expanded.
fn open(bytes: &[u8], max_pixels: usize) -> Result<Reader<Cursor<&[u8]>>> {
    let mut options = DecodeOptions::default();
    // By default the crate passes over the checksum of the pixels.
    options.set_ignore_adler32(false);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
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
