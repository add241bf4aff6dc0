//! Segments of a JPEG file in their order (ITU-T T.81, B.1).

use std::ops::Range;

use super::frame::marker;
use crate::error::Result;
use crate::formats::input::damage;

/// A marker and the content of its segment.
pub(super) struct Segment<'a> {
    pub code: u8,
    pub body: &'a [u8],
    /// Position of the content in the file.
    pub place: usize,
}

/// Segments of a picture that begins at a place in a file.
pub(super) struct Segments<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Segments<'a> {
    /// Segments after the marker of the start, which must lie at the place `start`.
    pub fn new(bytes: &'a [u8], start: usize) -> Result<Self> {
        if bytes.get(start..).is_none_or(|rest| !rest.starts_with(&[0xFF, marker::START])) {
            return Err(damage("the JPEG file is damaged: it does not begin with the marker of a picture"));
        }
        Ok(Self { bytes, at: start + 2 })
    }

    /// Position behind the last segment.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Next segment; markers without content, but for that of the end, are passed over.
    pub fn next(&mut self) -> Result<Segment<'a>> {
        loop {
            match self.marker()? {
                0x01 | 0xD0..=0xD7 => {}
                marker::END => return Ok(Segment { code: marker::END, body: &[], place: self.at }),
                code => return self.content(code),
            }
        }
    }

    /// Code of the next marker, after fill bytes.
    fn marker(&mut self) -> Result<u8> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let fill = rest.iter().take_while(|&&byte| byte == 0xFF).count();
        let code = *rest.get(fill).ok_or_else(incomplete)?;
        if fill == 0 || code == 0 {
            return Err(damage(format!("the JPEG file is damaged: there is no marker at byte {}", self.at)));
        }
        self.at += fill + 1;
        Ok(code)
    }

    fn content(&mut self, code: u8) -> Result<Segment<'a>> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let length = usize::from(u16::from_be_bytes(*rest.first_chunk().ok_or_else(incomplete)?));
        if length < 2 {
            return Err(damage("the JPEG file is damaged: a segment is shorter than its length"));
        }
        let body = rest.get(2..length).ok_or_else(incomplete)?;
        let place = self.at + 2;
        self.at += length;
        Ok(Segment { code, body, place })
    }

    /// Data of a scan without its stuffed bytes, and the range of each restart interval.
    ///
    /// The markers of restarts must follow each other in their order; there are none without an `interval`.
    pub fn scan_data(&mut self, interval: usize) -> Result<(Vec<u8>, Vec<Range<usize>>)> {
        let (mut data, mut ranges, mut start) = (Vec::new(), Vec::new(), 0);
        loop {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let run = rest.iter().position(|&byte| byte == 0xFF).ok_or_else(incomplete)?;
            data.extend_from_slice(&rest[..run]);
            self.at += run;
            match *rest.get(run + 1).ok_or_else(incomplete)? {
                0 => {
                    data.push(0xFF);
                    self.at += 2;
                }
                0xFF => self.at += 1,
                code @ 0xD0..=0xD7 if interval > 0 => {
                    ranges.push(start..data.len());
                    start = data.len();
                    check_order(code, ranges.len())?;
                    self.at += 2;
                }
                _ => break,
            }
        }
        ranges.push(start..data.len());
        Ok((data, ranges))
    }
}

/// Refuse a restart marker with another `code` than that of its `count`.
fn check_order(code: u8, count: usize) -> Result<()> {
    if usize::from(code & 7) == (count - 1) % 8 {
        return Ok(());
    }
    Err(damage("the JPEG file is damaged: a restart marker is missing"))
}

fn incomplete() -> crate::error::Error {
    damage("the JPEG file is incomplete")
}
