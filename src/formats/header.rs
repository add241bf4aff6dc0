//! Statements of a picture file about its samples: one struct for all formats. Callers decide what follows from them.

use std::collections::BTreeMap;

use super::gain_map::GainMap;

/// Statements about one image of a file: its samples, colour, place and exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Format: "radiance", "openexr", "png", "jpeg" or "tiff".
    pub kind: &'static str,
    /// Name of the part in the file; empty if it has none.
    pub name: String,
    /// Stereo view, such as "left"; empty if the file names none.
    pub view: String,
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Channels, in the order in which they are numbered.
    pub channels: Vec<Channel>,
    /// Meaning of the channel A.
    pub alpha: Alpha,
    /// Rows that are decoded together; a read of a multiple of them decodes nothing twice.
    pub block: usize,
    /// Statements about the colour space.
    pub colour: Colour,
    /// EXIF orientation, 1 to 8.
    pub orientation: u8,
    /// Rectangle of the samples; None if they are the whole picture.
    pub data_window: Option<Window>,
    /// Rectangle of the whole picture, in the same coordinates; None without `data_window`.
    pub display_window: Option<Window>,
    /// Multipliers of the channels; samples divided by them are radiance: EXPOSURE times COLORCORR of Radiance.
    pub exposure: [f64; 3],
    /// Luminance of RGB (1, 1, 1) in cd/m2: `whiteLuminance` of OpenEXR.
    pub white_luminance: Option<f64>,
    /// Environment attribute: "latlong", "cube", or empty.
    pub environment: &'static str,
    /// True if the outer pixels lie on the seam and the poles.
    pub border_sampled: bool,
    /// Numbers of the EXIF by the names of `exif::TAGS`, such as "`ExposureTime`".
    pub exif: BTreeMap<&'static str, f64>,
    /// XMP packets; JPEG may have several.
    pub xmp: Vec<Vec<u8>>,
    /// Description or comments; empty without one.
    pub description: String,
    /// Gain map that raises the samples to high dynamic range, once they are linear.
    pub gain_map: Option<GainMap>,
    /// Remarks of the reader on content that is left out.
    pub notes: Vec<String>,
}

impl Header {
    /// Header of a whole picture that states nothing but its size and channels.
    pub fn plain(kind: &'static str, height: usize, width: usize, channels: Vec<Channel>) -> Self {
        Self {
            kind,
            height,
            width,
            channels,
            name: String::new(),
            view: String::new(),
            alpha: Alpha::None,
            block: 1,
            colour: Colour::default(),
            orientation: 1,
            data_window: None,
            display_window: None,
            exposure: [1.0; 3],
            white_luminance: None,
            environment: "",
            border_sampled: false,
            exif: BTreeMap::new(),
            xmp: Vec::new(),
            description: String::new(),
            gain_map: None,
            notes: Vec::new(),
        }
    }

    /// Type into which these channels are read: their own, or floats if their types differ.
    pub fn sample_type(&self, channels: &[usize]) -> SampleType {
        let mut types = channels.iter().map(|&channel| self.channels[channel].sample);
        let first = types.next().unwrap_or(SampleType::F32);
        if types.all(|other| other == first) { first } else { SampleType::F32 }
    }
}

/// Rectangle of pixels: x and y of its corner, width, height.
pub type Window = (i64, i64, i64, i64);

/// One of the channels of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name: "R", "G", "B", "Y" for grey, "A", or any other of OpenEXR.
    pub name: String,
    /// Type of its samples.
    pub sample: SampleType,
}

/// Channels with the usual `names`, one letter each.
pub fn channels(names: &str, sample: SampleType) -> Vec<Channel> {
    names.chars().map(|name| Channel { name: name.to_string(), sample }).collect()
}

/// Type of the samples of a channel, after few bits were widened to 8 and 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    /// Codes from 0 to 255.
    U8,
    /// Codes from 0 to 65535.
    U16,
    /// Half floats.
    F16,
    /// Floats.
    F32,
}

/// Meaning of an alpha channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// There is none, or none that counts.
    None,
    /// Colours are not multiplied by alpha.
    Straight,
    /// Colours are multiplied by alpha.
    Premultiplied,
}

/// Statements about the colour space, which may contradict each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Colour {
    /// Codes of primaries, transfer, matrix and full range (ITU-T H.273): cICP of PNG.
    pub cicp: Option<[u8; 4]>,
    /// ICC profile; empty without one.
    pub icc: Vec<u8>,
    /// True if the file names sRGB: chunk sRGB of PNG, `ColorSpace` 1 of EXIF.
    pub is_srgb: bool,
    /// Exponent of encoding, such as 0.45455: gAMA of PNG.
    pub gamma: Option<f64>,
    /// The x and y of red, green, blue and white.
    pub chromaticities: Option<[f64; 8]>,
    /// True if the samples are CIE XYZ: XYZE of Radiance.
    pub is_xyz: bool,
    /// Name of a colour space: `colorInteropID` of OpenEXR; empty without one.
    pub name: String,
}
