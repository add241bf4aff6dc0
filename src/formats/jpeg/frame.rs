//! Frame of a JPEG picture: size, components and their sampling (ITU-T T.81, A.1 and B.2.2).

use crate::error::Result;
use crate::formats::input::{damage, unread};

/// Codes of the markers with a meaning here (T.81, table B.1).
pub(super) mod marker {
    /// Second byte of a marker.
    pub type Code = u8;

    pub const HUFFMAN_TABLES: Code = 0xC4;
    pub const ARITHMETIC_TABLES: Code = 0xCC;
    pub const START: Code = 0xD8;
    pub const END: Code = 0xD9;
    pub const SCAN: Code = 0xDA;
    pub const STEPS: Code = 0xDB;
    pub const RESTART_INTERVAL: Code = 0xDD;
    pub const APP0: Code = 0xE0;
    pub const APP1: Code = 0xE1;
    pub const APP2: Code = 0xE2;
    pub const APP14: Code = 0xEE;
    pub const COMMENT: Code = 0xFE;
}

/// True for the markers SOF0 to SOF15 of frames.
pub(super) fn is_frame(code: u8) -> bool {
    (0xC0..=0xCF).contains(&code)
        && ![marker::HUFFMAN_TABLES, 0xC8, marker::ARITHMETIC_TABLES].contains(&code)
}

/// Coefficients of a block, row after row.
pub(super) type Block = [i16; 64];

/// Size and components of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub height: usize,
    pub width: usize,
    pub is_progressive: bool,
    pub components: Vec<Component>,
}

/// One of the components, such as luminance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Component {
    /// Name in scans.
    pub id: u8,
    /// Blocks in a row of a minimum coded unit.
    pub across: usize,
    /// Blocks in a column of a minimum coded unit.
    pub down: usize,
    /// Number of its table of quantisation steps.
    pub steps: usize,
}

impl Frame {
    /// Frame of a segment `body` with the marker `code`.
    pub fn read(code: u8, body: &[u8]) -> Result<Self> {
        check_process(code)?;
        let &[precision, y1, y0, x1, x0, count, ref rest @ ..] = body else {
            return Err(damage("the JPEG file is damaged: its frame is too short"));
        };
        if precision != 8 {
            return Err(unread(format!(
                "it is a JPEG of {precision} bits a sample, which are not read; give 8 bits, or a PNG or TIFF of 16"
            )));
        }
        let (height, width) = (u16::from_be_bytes([y1, y0]).into(), u16::from_be_bytes([x1, x0]).into());
        if height == 0 || width == 0 {
            return Err(damage("it has no size before its pixels; the file is damaged"));
        }
        if ![1, 3, 4].contains(&count) || rest.len() != 3 * usize::from(count) {
            return Err(unread(format!("it is a JPEG of {count} components; give 1, 3 or 4")));
        }
        let components = rest.as_chunks().0.iter().copied().map(Component::read).collect::<Option<Vec<_>>>();
        let mut components =
            components.ok_or_else(|| damage("the JPEG file is damaged: its frame has wrong factors"))?;
        if let [only] = &mut components[..] {
            // A single component has one block in a unit, whatever its factors are (A.2.2).
            (only.across, only.down) = (1, 1);
        }
        let frame = Self { height, width, is_progressive: code == 0xC2, components };
        frame.check_components()?;
        Ok(frame)
    }

    fn check_components(&self) -> Result<()> {
        let ids = self.components.iter().map(|component| component.id);
        if ids.clone().enumerate().any(|(place, id)| ids.clone().skip(place + 1).any(|other| other == id)) {
            return Err(damage("the JPEG file is damaged: two components have the same name"));
        }
        let (across, down) = self.unit();
        if self.components.iter().any(|one| across % one.across != 0 || down % one.down != 0) {
            return Err(unread(
                "its chroma has a fraction of a sample for each pixel; give a JPEG of 4:4:4, 4:2:2 or 4:2:0",
            ));
        }
        Ok(())
    }

    /// Blocks of the finest component in a row and in a column of a minimum coded unit.
    pub fn unit(&self) -> (usize, usize) {
        let across = self.components.iter().map(|component| component.across).max().unwrap_or(1);
        (across, self.components.iter().map(|component| component.down).max().unwrap_or(1))
    }

    /// Minimum coded units in a column and in a row of interleaved scans.
    pub fn units(&self) -> (usize, usize) {
        let (across, down) = self.unit();
        (self.height.div_ceil(8 * down), self.width.div_ceil(8 * across))
    }

    /// Rows and columns of the samples of a component.
    pub fn samples(&self, component: &Component) -> (usize, usize) {
        let (across, down) = self.unit();
        ((self.height * component.down).div_ceil(down), (self.width * component.across).div_ceil(across))
    }

    /// Refuse a file of `length` bytes that is too short for the blocks: each takes at least one bit.
    pub fn check_length(&self, length: usize) -> Result<()> {
        let blocks = self.components.iter().map(|component| {
            let (rows, columns) = self.samples(component);
            rows.div_ceil(8) * columns.div_ceil(8)
        });
        if blocks.sum::<usize>() > 8 * length {
            let (width, height) = (self.width, self.height);
            return Err(damage(format!(
                "the JPEG file is incomplete: {length} bytes cannot hold {width}x{height} pixels"
            )));
        }
        Ok(())
    }
}

impl Component {
    fn read([id, factors, steps]: [u8; 3]) -> Option<Self> {
        let (across, down) = (usize::from(factors >> 4), usize::from(factors & 15));
        let is_valid = (1..=4).contains(&across) && (1..=4).contains(&down) && steps < 4;
        is_valid.then_some(Self { id, across, down, steps: steps.into() })
    }
}

/// Refuse other processes than sequential and progressive coding by Huffman codes.
fn check_process(code: u8) -> Result<()> {
    let process = match code {
        0xC0..=0xC2 => return Ok(()),
        0xC3 | 0xC7 | 0xCB | 0xCF => "lossless coding",
        0xC5 | 0xC6 | 0xCD | 0xCE => "hierarchical coding",
        _ => "arithmetic coding",
    };
    Err(unread(format!(
        "it is a JPEG of {process}, which is not read; save it as an ordinary JPEG or as PNG"
    )))
}
