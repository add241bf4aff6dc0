//! Statements of a JPEG picture before its first scan: size, colour model, profile, XMP, EXIF, other pictures.

use super::frame::{Frame, is_frame, marker};
use super::planes::Model;
use super::segments::{Segment, Segments};
use crate::error::Result;
use crate::formats::input::damage;

const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";
const EXTENDED_XMP: &[u8] = b"http://ns.adobe.com/xmp/extension/\0";
const EXIF: &[u8] = b"Exif\0\0";
const PROFILE: &[u8] = b"ICC_PROFILE\0";
const PICTURES: &[u8] = b"MPF\0";
const GAIN_MAP: &[u8] = b"urn:iso:std:iso:ts:21496:-1\0";
/// Most bytes of a profile, and of extended XMP.
const MOST_PROFILE: usize = 16 << 20;
const MOST_XMP: usize = 4 << 20;

/// Statements of a picture.
#[derive(Default)]
pub(super) struct Metadata<'a> {
    frame: Option<Frame>,
    has_jfif: bool,
    /// Transform that Adobe's segment names.
    adobe: Option<u8>,
    /// EXIF in the layout of TIFF; empty without one.
    pub exif: &'a [u8],
    /// XMP packets, without extended ones.
    pub xmp: Vec<&'a [u8]>,
    extensions: Vec<Extension<'a>>,
    profile: Vec<Chunk<'a>>,
    /// Index of the pictures in the file (CIPA DC-007), and its position.
    pub pictures: Option<(&'a [u8], usize)>,
    /// Parameters of a gain map (ISO 21496-1).
    pub gain_map: Option<&'a [u8]>,
    /// First comment; empty without one.
    pub comment: &'a [u8],
}

/// Part of an ICC profile.
struct Chunk<'a> {
    number: u8,
    count: u8,
    bytes: &'a [u8],
}

/// Part of an extended XMP packet.
struct Extension<'a> {
    digest: &'a [u8],
    length: usize,
    offset: usize,
    bytes: &'a [u8],
}

impl<'a> Metadata<'a> {
    /// Statements of the picture at `start` in a file, and its frame.
    pub fn read(bytes: &'a [u8], start: usize) -> Result<(Self, Frame)> {
        let mut segments = Segments::new(bytes, start)?;
        let mut found = Self::default();
        loop {
            let segment = segments.next()?;
            if [marker::SCAN, marker::END].contains(&segment.code) {
                break;
            }
            found.take(&segment)?;
        }
        let frame = found.frame.take();
        frame
            .map(|frame| (found, frame))
            .ok_or_else(|| damage("it has no size before its pixels; the file is damaged"))
    }

    fn take(&mut self, segment: &Segment<'a>) -> Result<()> {
        let body = segment.body;
        match segment.code {
            code if is_frame(code) && self.frame.is_some() => {
                return Err(damage("the JPEG file is damaged: it has two frames"));
            }
            code if is_frame(code) => self.frame = Some(Frame::read(code, body)?),
            marker::START => {
                return Err(damage("the JPEG file is damaged: another picture begins before its pixels"));
            }
            marker::APP0 => self.has_jfif |= body.starts_with(b"JFIF\0"),
            marker::APP1 => self.take_texts(body),
            marker::APP2 => self.take_profile(body, segment.place),
            marker::APP14 if body.starts_with(b"Adobe") => self.adobe = body.get(11).copied().or(self.adobe),
            marker::COMMENT if self.comment.is_empty() => self.comment = body,
            _ => {}
        }
        Ok(())
    }

    fn take_texts(&mut self, body: &'a [u8]) {
        if let Some(packet) = body.strip_prefix(XMP) {
            self.xmp.push(packet);
        } else if let Some(exif) = body.strip_prefix(EXIF).filter(|_| self.exif.is_empty()) {
            self.exif = exif;
        } else if let Some(extension) = body.strip_prefix(EXTENDED_XMP).and_then(Extension::read) {
            self.extensions.push(extension);
        }
    }

    fn take_profile(&mut self, body: &'a [u8], place: usize) {
        if let Some(&[number, count, ref bytes @ ..]) = body.strip_prefix(PROFILE) {
            self.profile.push(Chunk { number, count, bytes });
        } else if let Some(pictures) = body.strip_prefix(PICTURES) {
            self.pictures = self.pictures.or(Some((pictures, place + PICTURES.len())));
        } else if let Some(parameters) = body.strip_prefix(GAIN_MAP) {
            self.gain_map = self.gain_map.or(Some(parameters));
        }
    }

    /// Relation of the components of a `frame` and colours, by the rules of libjpeg.
    pub fn model(&self, frame: &Frame) -> Model {
        let ids: Vec<_> = frame.components.iter().map(|component| component.id).collect();
        match (ids.len(), self.adobe) {
            (1, _) => Model::Grey,
            (3, Some(0)) if !self.has_jfif => Model::Rgb,
            (3, None) if !self.has_jfif && ids == b"RGB" => Model::Rgb,
            (3, _) => Model::Differences,
            (_, None | Some(0)) => Model::Cmyk,
            _ => Model::CmykDifferences,
        }
    }

    /// ICC profile of all chunks in their order; empty without one, None if chunks are missing or too large.
    pub fn profile(&self) -> Option<Vec<u8>> {
        let mut chunks: Vec<_> = self.profile.iter().collect();
        chunks.sort_by_key(|chunk| chunk.number);
        let count = chunks.len();
        let is_sound = (1..)
            .zip(&chunks)
            .all(|(number, chunk)| usize::from(chunk.number) == number && usize::from(chunk.count) == count);
        let length: usize = chunks.iter().map(|chunk| chunk.bytes.len()).sum();
        (is_sound && length <= MOST_PROFILE)
            .then(|| chunks.iter().flat_map(|chunk| chunk.bytes).copied().collect())
    }

    /// All XMP packets; an extended packet belongs to a packet that names its digest.
    pub fn packets(&self) -> Vec<Vec<u8>> {
        let mut packets: Vec<_> = self.xmp.iter().map(|packet| packet.to_vec()).collect();
        let is_named = |digest: &[u8]| {
            self.xmp.iter().any(|packet| packet.windows(digest.len()).any(|part| part == digest))
        };
        if let Some(first) = self.extensions.iter().find(|extension| is_named(extension.digest)) {
            packets.extend(self.extended_packet(first));
        }
        packets
    }

    /// Packet of all parts with the digest of a `first` one; None if some are missing.
    fn extended_packet(&self, first: &Extension<'_>) -> Option<Vec<u8>> {
        let mut parts: Vec<_> = self.extensions.iter().filter(|part| part.digest == first.digest).collect();
        parts.sort_by_key(|part| part.offset);
        let mut packet = Vec::new();
        for part in parts {
            let is_next = part.offset == packet.len() && part.length == first.length;
            if !is_next || packet.len() + part.bytes.len() > MOST_XMP {
                return None;
            }
            packet.extend_from_slice(part.bytes);
        }
        (packet.len() == first.length).then_some(packet)
    }
}

impl<'a> Extension<'a> {
    /// Part in the layout of XMP, part 3, section 1.1.3.1.
    fn read(body: &'a [u8]) -> Option<Self> {
        let (digest, body) = body.split_at_checked(32)?;
        let (&length, body) = body.split_first_chunk()?;
        let (&offset, bytes) = body.split_first_chunk()?;
        let [length, offset] = [length, offset].map(|bytes| u32::from_be_bytes(bytes) as usize);
        Some(Self { digest, length, offset, bytes })
    }
}
