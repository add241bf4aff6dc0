//! Header of a Radiance picture: lines of text, an empty line, and the resolution.

use crate::error::Result;
use crate::formats::header::{Header, SampleType, channels};
use crate::formats::input::damage;

/// Header of a Radiance picture while its lines are read.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    /// Place of the next line; at the end, that of the first line of pixels.
    pub place: usize,
    pub header: Header,
}

impl<'a> Reader<'a> {
    /// Header at the start of `bytes`.
    ///
    /// # Errors
    ///
    /// If it is incomplete, or its FORMAT is missing or unknown.
    pub fn read(bytes: &'a [u8]) -> Result<Self> {
        if !bytes.starts_with(b"#?") {
            return Err(damage("a Radiance file starts with #?"));
        }
        let header = Header::plain("radiance", 0, 0, channels("RGB", SampleType::F32));
        let mut reader = Self { bytes, place: 0, header };
        let mut format = None;
        reader.line()?;
        loop {
            let line = reader.line()?;
            if line.is_empty() {
                break;
            }
            if let Some(value) = value(line, b"FORMAT") {
                format = Some(value);
            } else {
                reader.statement(line);
            }
        }
        reader.header.colour.is_xyz = is_xyz(format)?;
        reader.header.description = description(bytes, reader.place);
        let resolution = reader.line()?;
        reader.set_resolution(resolution)?;
        Ok(reader)
    }

    /// Next line, without its end.
    fn line(&mut self) -> Result<&'a [u8]> {
        let rest = &self.bytes[self.place..];
        let length = rest.iter().position(|&byte| byte == b'\n').ok_or_else(|| {
            damage("the Radiance header is incomplete; wanted an empty line and the resolution")
        })?;
        self.place += length + 1;
        Ok(rest[..length].strip_suffix(b"\r").unwrap_or(&rest[..length]))
    }

    /// Apply an exposure, a colour correction or primaries; pass over everything else.
    fn statement(&mut self, line: &[u8]) {
        if let Some(factors) = value(line, b"EXPOSURE").and_then(numbers::<1>) {
            self.multiply([factors[0]; 3]);
        } else if let Some(factors) = value(line, b"COLORCORR").and_then(numbers::<3>) {
            self.multiply(factors);
        } else if let Some(primaries) = value(line, b"PRIMARIES").and_then(numbers::<8>) {
            let is_named = primaries.iter().any(|&number| number != 0.0);
            self.header.colour.chromaticities = is_named.then_some(primaries);
        }
    }

    /// Multiply the exposure by `factors`, unless one of them is not a positive finite number.
    fn multiply(&mut self, factors: [f64; 3]) {
        let product: [f64; 3] = std::array::from_fn(|i| self.header.exposure[i] * factors[i]);
        if product.iter().all(|product| product.is_normal() && *product > 0.0) {
            self.header.exposure = product;
        }
    }

    /// Set size and orientation from a line such as `-Y 512 +X 1024`.
    fn set_resolution(&mut self, line: &[u8]) -> Result<()> {
        let wrong = || {
            damage(format!(
                "the resolution of the Radiance file is \"{}\"; wanted -Y height +X width, or another order of these",
                line[..line.len().min(60)].escape_ascii()
            ))
        };
        let text = std::str::from_utf8(line).map_err(|_| wrong())?;
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let [one, height, other, width] = words[..] else { return Err(wrong()) };
        self.header.orientation = match (one, other) {
            ("-Y", "+X") => 1,
            ("-Y", "-X") => 2,
            ("+Y", "-X") => 3,
            ("+Y", "+X") => 4,
            ("+X", "-Y") => 5,
            ("-X", "-Y") => 6,
            ("-X", "+Y") => 7,
            ("+X", "+Y") => 8,
            _ => return Err(wrong()),
        };
        self.header.height = height.parse().map_err(|_| wrong())?;
        self.header.width = width.parse().map_err(|_| wrong())?;
        Ok(())
    }
}

/// Lines before the `end` of the header, or the first ones of a long header.
fn description(bytes: &[u8], end: usize) -> String {
    const LONGEST: usize = 1 << 16;
    String::from_utf8_lossy(&bytes[..end.min(LONGEST)]).into_owned()
}

/// True for samples in CIE XYZ, by the value of FORMAT.
fn is_xyz(format: Option<&[u8]>) -> Result<bool> {
    const KNOWN: &str = "32-bit_rle_rgbe or 32-bit_rle_xyze";
    match format {
        Some(b"32-bit_rle_rgbe") => Ok(false),
        Some(b"32-bit_rle_xyze") => Ok(true),
        Some(other) => Err(damage(format!(
            "the FORMAT of the Radiance file is \"{}\"; wanted {KNOWN}",
            other[..other.len().min(60)].escape_ascii()
        ))),
        None => Err(damage(format!("the Radiance header has no FORMAT line; wanted {KNOWN}"))),
    }
}

/// Text behind `name=`.
fn value<'a>(line: &'a [u8], name: &[u8]) -> Option<&'a [u8]> {
    let rest = line.trim_ascii().strip_prefix(name)?.trim_ascii_start();
    Some(rest.strip_prefix(b"=")?.trim_ascii())
}

/// Exactly `N` finite numbers.
fn numbers<const N: usize>(text: &[u8]) -> Option<[f64; N]> {
    let words = std::str::from_utf8(text).ok()?.split_ascii_whitespace();
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
    let numbers: [f64; N] = numbers?.try_into().ok()?;
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}
