//! Form of one page: its samples, and the strips or tiles that hold them; refusals of what is not converted.

use crate::error::Result;
use crate::formats::directory::{Directory, File, Integers};
use crate::formats::header::SampleType;
use crate::formats::input::{check_size, damage, unread};

/// Form of the samples of a page.
#[derive(Clone, Debug)]
pub struct Page {
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Samples of a pixel in the file.
    pub samples: usize,
    /// Bits of a sample in the file.
    pub bits: usize,
    /// Colour model: 0 grey with white as 0, 1 grey, 2 RGB, 3 palette.
    pub photometric: u64,
    /// Meaning of the bits.
    pub form: Form,
    /// Compression of the strips or tiles.
    pub compression: Compression,
    /// Prediction of a sample from its neighbour.
    pub predictor: Predictor,
    /// True if each channel has its own strips or tiles.
    pub is_planar: bool,
    /// Rows of a strip or tile.
    pub chunk_height: usize,
    /// Columns of a strip or tile.
    pub chunk_width: usize,
    /// True for tiles, which are whole at the right and at the bottom, too.
    is_tiled: bool,
    offsets: Integers,
    lengths: Option<Integers>,
}

/// Meaning of the bits of a sample.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// Unsigned integers, which are scaled to 8 or 16 bits.
    Codes,
    /// Floating point numbers.
    Floats,
    /// Indices of colours.
    Palette(Vec<[u8; 3]>),
}

/// Compressions that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Samples as they are; any row can be read by itself.
    None,
    /// LZW of TIFF 5 and later.
    Lzw,
    /// Deflate.
    Deflate,
    /// Runs of bytes.
    PackBits,
}

/// Predictions of a sample from its left neighbour, if any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predictor {
    /// Samples themselves.
    None,
    /// Differences of integers.
    Horizontal,
    /// Differences of the bytes of floating point numbers, sorted by significance.
    Floats,
}

/// Tags of the form of a page.
mod tags {
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const BITS: u16 = 258;
    pub const COMPRESSION: u16 = 259;
    pub const PHOTOMETRIC: u16 = 262;
    pub const FILL_ORDER: u16 = 266;
    pub const STRIP_OFFSETS: u16 = 273;
    pub const SAMPLES: u16 = 277;
    pub const STRIP_ROWS: u16 = 278;
    pub const STRIP_LENGTHS: u16 = 279;
    pub const PLANAR: u16 = 284;
    pub const PREDICTOR: u16 = 317;
    pub const PALETTE: u16 = 320;
    pub const TILE_WIDTH: u16 = 322;
    pub const TILE_HEIGHT: u16 = 323;
    pub const TILE_OFFSETS: u16 = 324;
    pub const TILE_LENGTHS: u16 = 325;
    pub const SAMPLE_FORMAT: u16 = 339;
    pub const DEPTH: u16 = 32997;
}

/// Most samples of a pixel.
const MOST_SAMPLES: usize = 256;
/// Highest ratio of samples to stored bytes: LZW reaches about 2600, deflate 1032.
pub const MOST_RATIO: usize = 4096;
/// Pixels that a tile may have though the picture is smaller.
const LARGE_TILE: usize = 1 << 22;

impl Page {
    /// Form of the page in a `directory`, of at most `max_pixels`.
    ///
    /// # Errors
    ///
    /// If a tag is missing or damaged, the samples are of a kind that is not converted, or there are too many pixels.
    pub fn read(directory: &Directory<'_>, file: File<'_>, max_pixels: usize) -> Result<Self> {
        let number = |tag, default| number(directory, tag, default);
        let (height, width) = (number(tags::HEIGHT, 0)?, number(tags::WIDTH, 0)?);
        let samples = number(tags::SAMPLES, 1)?;
        let photometric = photometric(directory, samples)?;
        check_size(height, width, max_pixels)?;
        check_model(directory, photometric, samples)?;
        let compression = compression(number(tags::COMPRESSION, 1)?)?;
        let bits = bits_of(directory, file, tags::BITS, "bits", 1)?;
        let form = form(directory, file, photometric, bits)?;
        let (offsets, lengths, chunk_height, chunk_width) = chunks(directory, height, width)?;
        let page = Self {
            height,
            width,
            samples,
            bits,
            photometric,
            predictor: predictor(directory, compression, bits, &form)?,
            form,
            compression,
            is_planar: samples > 1 && number(tags::PLANAR, 1)? == 2,
            chunk_height,
            chunk_width,
            is_tiled: directory.has(tags::TILE_OFFSETS),
            offsets,
            lengths,
        };
        page.check_claims(file)?;
        Ok(page)
    }

    /// Type of the samples that readers get.
    pub fn sample_type(&self) -> SampleType {
        match (&self.form, self.bits) {
            (Form::Palette(_), _) | (Form::Codes, ..=8) => SampleType::U8,
            (Form::Codes, _) => SampleType::U16,
            (Form::Floats, 16) => SampleType::F16,
            (Form::Floats, _) => SampleType::F32,
        }
    }

    /// Samples of a pixel that readers get.
    pub fn channels(&self) -> usize {
        if matches!(self.form, Form::Palette(_)) { 3 } else { self.samples }
    }

    /// Samples of a pixel in one strip or tile.
    pub fn chunk_samples(&self) -> usize {
        if self.is_planar { 1 } else { self.samples }
    }

    /// Bytes of a row of a strip or tile.
    pub fn row_bytes(&self) -> usize {
        (self.chunk_width * self.chunk_samples() * self.bits).div_ceil(8)
    }

    /// Number of strips or tiles in a row of them.
    pub fn across(&self) -> usize {
        self.width.div_ceil(self.chunk_width)
    }

    /// Strips or tiles of one channel, or of all if they are stored together.
    fn chunks_of_plane(&self) -> usize {
        self.across() * self.height.div_ceil(self.chunk_height)
    }

    /// Rows that are stored in the strips or tiles `down` from the first.
    pub fn chunk_rows(&self, down: usize) -> usize {
        if self.is_tiled {
            self.chunk_height
        } else {
            self.chunk_height.min(self.height - down * self.chunk_height)
        }
    }

    /// Rows that are decoded together.
    pub fn block(&self) -> usize {
        if self.compression == Compression::None { 1 } else { self.chunk_height }
    }

    /// Stored bytes of a strip or tile: that of a `plane`, `down` and `across` strips or tiles from the first.
    ///
    /// # Errors
    ///
    /// If they do not lie in the file.
    pub fn chunk<'a>(
        &self,
        file: File<'a>,
        (plane, down, across): (usize, usize, usize),
    ) -> Result<&'a [u8]> {
        let number = plane * self.chunks_of_plane() + down * self.across() + across;
        let outside = || damage("the TIFF file is damaged or incomplete: a strip or tile lies outside of it");
        let usize_of =
            |integers: Integers| integers.get(file, number).and_then(|one| usize::try_from(one).ok());
        let start = usize_of(self.offsets).ok_or_else(outside)?;
        let length = match self.lengths {
            Some(lengths) if self.compression != Compression::None => {
                usize_of(lengths).ok_or_else(outside)?
            }
            _ => self.chunk_rows(down) * self.row_bytes(),
        };
        start.checked_add(length).and_then(|end| file.bytes.get(start..end)).ok_or_else(outside)
    }

    /// Refuse sizes that the file cannot hold, before memory is allocated.
    fn check_claims(&self, file: File<'_>) -> Result<()> {
        let planes = if self.is_planar { self.samples } else { 1 };
        let chunks = planes.saturating_mul(self.chunks_of_plane());
        if self.offsets.count < chunks || self.lengths.is_some_and(|lengths| lengths.count < chunks) {
            return Err(damage(format!(
                "the TIFF file is damaged: it has {} strips or tiles of {chunks}",
                self.offsets.count
            )));
        }
        let ratio = if self.compression == Compression::None { 1 } else { MOST_RATIO };
        let bits = self.height.saturating_mul(self.width).saturating_mul(self.samples * self.bits);
        if bits / 8 > file.bytes.len().saturating_mul(ratio) {
            return Err(damage("the TIFF file is damaged or incomplete: it is too short for its samples"));
        }
        Ok(())
    }
}

/// First integer of a tag, or `default` without the tag.
fn number(directory: &Directory<'_>, tag: u16, default: usize) -> Result<usize> {
    if !directory.has(tag) {
        return Ok(default);
    }
    let value = directory.integer(tag).and_then(|value| usize::try_from(value).ok());
    value.ok_or_else(|| damage(format!("the TIFF file is damaged: its tag {tag} has no number")))
}

/// Colour model, or a refusal of one that is not converted.
fn photometric(directory: &Directory<'_>, samples: usize) -> Result<u64> {
    let model = number(directory, tags::PHOTOMETRIC, if samples < 3 { 1 } else { 2 })? as u64;
    let name = match model {
        0..=3 => return Ok(model),
        4 => "a mask of transparency",
        5 => "CMYK colour",
        6 => "YCbCr colour",
        8 => "L*a*b* colour",
        9 => "ICC L*a*b* colour",
        10 => "ITU L*a*b* colour",
        32803 => "a raw colour filter array",
        32844 => "LogL luminance",
        32845 => "LogLuv colour",
        34892 => "linear raw samples",
        _ => "of an unknown colour model",
    };
    Err(unread(format!(
        "its samples are {name} (photometric {model}); give RGB, as floating point for high dynamic range"
    )))
}

/// Refuse volumes, too many channels, and bits in reverse order.
fn check_model(directory: &Directory<'_>, photometric: u64, samples: usize) -> Result<()> {
    let depth = number(directory, tags::DEPTH, 1)?;
    if depth > 1 {
        return Err(unread(format!("it is a volume of {depth} slices; give a flat image")));
    }
    if !(1..=MOST_SAMPLES).contains(&samples) {
        return Err(unread(format!("it has {samples} channels; give from 1 to {MOST_SAMPLES}")));
    }
    if photometric == 3 && samples != 1 {
        return Err(unread(format!("its palette has {samples} channels; give it without alpha, or as RGB")));
    }
    if number(directory, tags::FILL_ORDER, 1)? == 2 {
        return Err(unread("its bits are stored in reverse order (FillOrder 2); give the usual order"));
    }
    Ok(())
}

fn compression(code: usize) -> Result<Compression> {
    let name = match code {
        1 => return Ok(Compression::None),
        5 => return Ok(Compression::Lzw),
        8 | 32946 => return Ok(Compression::Deflate),
        32773 => return Ok(Compression::PackBits),
        2..=4 => "CCITT fax compression",
        6 | 7 => "JPEG",
        34712 => "JPEG 2000",
        34925 => "LZMA",
        50000 => "Zstandard",
        50001 => "WebP",
        50002 => "JPEG XL",
        _ => "an unknown method",
    };
    let way_out = "give LZW, deflate or no compression";
    Err(unread(format!(
        "its samples are compressed by {name} (compression {code}), which is not read; {way_out}"
    )))
}

/// Common value of a tag with a value for each channel.
fn bits_of(directory: &Directory<'_>, file: File<'_>, tag: u16, name: &str, default: usize) -> Result<usize> {
    let first = number(directory, tag, default)?;
    let mut others = directory.integers(tag).into_iter().flat_map(|values| values.iter(file));
    if others.any(|other| other != first as u64) {
        return Err(unread(format!("its channels have different {name}; give the same for all")));
    }
    Ok(first)
}

fn form(directory: &Directory<'_>, file: File<'_>, photometric: u64, bits: usize) -> Result<Form> {
    let format = bits_of(directory, file, tags::SAMPLE_FORMAT, "types of samples", 1)?;
    match (photometric, format, bits) {
        (3, _, 1 | 2 | 4 | 8) => palette(directory, file, bits).map(Form::Palette),
        (0..=2, 1 | 4, 1 | 2 | 4 | 6 | 8 | 10 | 12 | 14 | 16) => Ok(Form::Codes),
        (0..=2, 3, 16 | 32 | 64) => Ok(Form::Floats),
        _ => {
            let name = match (format, bits) {
                (1 | 4, 24 | 32) => "uint".to_string(),
                (1 | 4, _) => format!("uint{bits}"),
                (2, 32) => "int".to_string(),
                (2, _) => format!("int{bits}"),
                (3, _) => format!("float{bits}"),
                _ => "complex numbers".to_string(),
            };
            Err(unread(format!("its samples are {name}; give floating point, uint8 or uint16")))
        }
    }
}

/// Colours of a palette: all of red, all of green, all of blue, of 16 bits.
fn palette(directory: &Directory<'_>, file: File<'_>, bits: usize) -> Result<Vec<[u8; 3]>> {
    let colours = 1 << bits;
    let values = directory.integers(tags::PALETTE).filter(|values| values.count == 3 * colours);
    let values =
        values.ok_or_else(|| damage("the TIFF file is damaged: it has no palette for its samples"))?;
    let code = |number| (values.get(file, number).unwrap_or(0) / 257) as u8;
    Ok((0..colours).map(|one| [code(one), code(colours + one), code(2 * colours + one)]).collect())
}

/// Prediction, which only LZW and deflate have.
fn predictor(
    directory: &Directory<'_>,
    compression: Compression,
    bits: usize,
    form: &Form,
) -> Result<Predictor> {
    if !matches!(compression, Compression::Lzw | Compression::Deflate) {
        return Ok(Predictor::None);
    }
    match (number(directory, tags::PREDICTOR, 1)?, form, bits) {
        (1, ..) => Ok(Predictor::None),
        (2, _, 8 | 16 | 32 | 64) => Ok(Predictor::Horizontal),
        (3, Form::Floats, _) => Ok(Predictor::Floats),
        (other, ..) => {
            Err(unread(format!("its samples have the predictor {other}, which {bits} bits cannot have")))
        }
    }
}

/// Offsets and lengths of the strips or tiles, their rows and their columns.
fn chunks(
    directory: &Directory<'_>,
    height: usize,
    width: usize,
) -> Result<(Integers, Option<Integers>, usize, usize)> {
    let missing = || damage("the TIFF file is damaged: it does not say where its strips or tiles lie");
    let is_tiled = directory.has(tags::TILE_OFFSETS);
    let (offsets, lengths) = if is_tiled {
        (tags::TILE_OFFSETS, tags::TILE_LENGTHS)
    } else {
        (tags::STRIP_OFFSETS, tags::STRIP_LENGTHS)
    };
    let offsets = directory.integers(offsets).ok_or_else(missing)?;
    let lengths = directory.integers(lengths);
    let (rows, columns) = if is_tiled {
        (number(directory, tags::TILE_HEIGHT, 0)?, number(directory, tags::TILE_WIDTH, 0)?)
    } else {
        (number(directory, tags::STRIP_ROWS, height)?.min(height), width)
    };
    let most = LARGE_TILE.max(height.saturating_mul(width).saturating_mul(4));
    if rows == 0 || columns == 0 || rows.saturating_mul(columns) > most {
        return Err(damage(format!(
            "the TIFF file is damaged: it has strips or tiles of {rows} rows of {columns}"
        )));
    }
    Ok((offsets, lengths, rows, columns))
}
