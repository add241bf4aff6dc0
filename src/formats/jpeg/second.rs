//! Gain map of a JPEG file: in its second picture, whose numbers are in a segment of ISO 21496-1 or in XMP (hdrgm).

use super::frame::marker;
use super::metadata::Metadata;
use super::picture::Picture;
use super::segments::Segments;
use crate::error::Result;
use crate::formats::gain_map::{GainMap, Parameters};
use crate::formats::input::{check_size, damage};

/// Name spaces of XMP for gain maps.
const ADOBE: &str = "http://ns.adobe.com/hdr-gain-map/1.0/";
const APPLE: &str = "http://ns.apple.com/HDRGainMap/1.0/";

/// Remark on a gain map that is meant for the primaries of the brighter rendition.
const OTHER_PRIMARIES: &str =
    "the gain map is for other primaries than those of the picture; it was applied in the latter";

/// Gain map of the file whose first picture has the statements `first`, and the remark if one cannot be applied.
pub(super) fn gain_map(
    bytes: &[u8],
    first: &Metadata<'_>,
    max_pixels: usize,
) -> (Option<GainMap>, Option<String>) {
    let mut is_named = first.gain_map.is_some() || names_gain_map(first);
    for start in pictures(bytes, first, is_named) {
        let Ok((second, frame)) = Metadata::read(bytes, start) else { continue };
        is_named |= second.gain_map.is_some() || names_gain_map(&second);
        let Some((parameters, is_of_base)) = parameters(&second) else { continue };
        let has_other = !is_of_base && second.profile() != first.profile();
        let picture = Picture::new(start, frame, &second);
        if let Ok(codes) = codes(bytes, &picture, max_pixels) {
            return (Some(GainMap { codes, parameters }), has_other.then(|| OTHER_PRIMARIES.into()));
        }
    }
    let note = "the file's gain map was not applied, so its high dynamic range was left out";
    (None, is_named.then(|| note.into()))
}

fn codes(bytes: &[u8], picture: &Picture, max_pixels: usize) -> Result<ndarray::Array3<u8>> {
    check_size(picture.frame.height, picture.frame.width, max_pixels)?;
    picture.samples(bytes, 0..picture.frame.height)
}

fn names_gain_map(metadata: &Metadata<'_>) -> bool {
    metadata.xmp.iter().any(|packet| {
        let text = String::from_utf8_lossy(packet);
        [ADOBE, APPLE].iter().any(|&space| prefix(&text, space).is_some_and(|prefix| text.contains(&prefix)))
    })
}

/// Positions of the pictures after the first one: those of the index, else the next one if it `is_needed`.
fn pictures(bytes: &[u8], first: &Metadata<'_>, is_needed: bool) -> Vec<usize> {
    let is_picture =
        |&start: &usize| bytes.get(start..).is_some_and(|rest| rest.starts_with(&[0xFF, marker::START]));
    let indexed =
        first.pictures.and_then(|(index, place)| indexed_pictures(index, place)).unwrap_or_default();
    let mut pictures: Vec<_> = indexed.into_iter().filter(is_picture).collect();
    if pictures.is_empty() && is_needed {
        pictures.extend(next_picture(bytes).ok());
    }
    pictures
}

/// Positions in an index of pictures (CIPA DC-007, 5.2.3), which are relative to its `place`.
fn indexed_pictures(index: &[u8], place: usize) -> Option<Vec<usize>> {
    /// Most pictures that are looked at.
    const MOST_PICTURES: usize = 16;
    let is_little_endian = index.starts_with(b"II");
    let long = |at: usize| {
        let bytes = *index.get(at..)?.first_chunk()?;
        Some(if is_little_endian { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) } as usize)
    };
    let short = |at: usize| {
        let bytes = *index.get(at..)?.first_chunk()?;
        Some(if is_little_endian { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
    };
    let directory = long(4)?;
    let mut fields = (0..usize::from(short(directory)?)).map(|field| directory + 2 + 12 * field);
    let field = fields.find(|&field| short(field) == Some(0xB002))?;
    let (size, entries) = (long(field + 4)?, long(field + 8)?);
    let offsets =
        (0..(size / 16).min(MOST_PICTURES)).filter_map(|entry| long(entries.checked_add(16 * entry + 8)?));
    Some(offsets.filter(|&offset| offset > 0).map(|offset| place + offset).collect())
}

/// Position of the picture behind the end of the first one.
fn next_picture(bytes: &[u8]) -> Result<usize> {
    let mut segments = Segments::new(bytes, 0)?;
    loop {
        match segments.next()?.code {
            marker::SCAN => drop(segments.scan_data(1)?),
            marker::END => break,
            _ => {}
        }
    }
    let end = segments.position();
    let gap = bytes[end..].windows(3).position(|bytes| bytes == [0xFF, marker::START, 0xFF]);
    gap.map(|gap| end + gap).ok_or_else(|| damage("there is no second picture"))
}

/// Numbers of a gain map, and true if its primaries are those of the base.
fn parameters(second: &Metadata<'_>) -> Option<(Parameters, bool)> {
    let texts = || {
        second.xmp.iter().find_map(|packet| Some((xmp_parameters(&String::from_utf8_lossy(packet))?, true)))
    };
    let found = second.gain_map.and_then(iso_parameters).or_else(texts);
    found.filter(|(parameters, _)| parameters.are_sound())
}

/// Numbers in the binary layout of ISO 21496-1, annex C.2; None if the base is the brighter rendition.
fn iso_parameters(mut bytes: &[u8]) -> Option<(Parameters, bool)> {
    let (version, rest) = bytes.split_first_chunk::<4>()?;
    let (&flags, rest) = rest.split_first()?;
    bytes = rest;
    let [has_channels, is_of_base, has_denominator] = [7, 6, 3].map(|bit| flags >> bit & 1 == 1);
    let mut long = || {
        let (number, rest) = bytes.split_first_chunk()?;
        bytes = rest;
        Some(u32::from_be_bytes(*number))
    };
    let common = if has_denominator { Some(long()?) } else { None };
    let mut ratio = |is_signed: bool| {
        let above = long()?;
        let below = common.map_or_else(&mut long, Some)?;
        let above = if is_signed { f64::from(above.cast_signed()) } else { f64::from(above) };
        Some(above / f64::from(below))
    };
    let is_brighter = ratio(false)? > ratio(false)?;
    let mut channels = [[0.0; 5]; 3];
    let count = if has_channels { 3 } else { 1 };
    for channel in &mut channels[..count] {
        *channel = [ratio(true)?, ratio(true)?, ratio(false)?, ratio(true)?, ratio(true)?];
    }
    if count == 1 {
        channels = [channels[0]; 3];
    }
    let number = |place: usize| channels.map(|channel| channel[place]);
    let parameters = Parameters {
        minimum: number(0),
        maximum: number(1),
        gamma: number(2),
        base_offset: number(3),
        alternate_offset: number(4),
    };
    let is_read = version[..2] == [0, 0] && !is_brighter;
    is_read.then_some((parameters, is_of_base))
}

/// Numbers among the properties of XMP (Adobe, gain map 1.0); None if the base is the brighter rendition.
fn xmp_parameters(text: &str) -> Option<Parameters> {
    let prefix = prefix(text, ADOBE)?;
    let value = |name: &str| property(text, &format!("{prefix}{name}"));
    let number = |name: &str, default: f64| value(name).map_or(Some([default; 3]), |value| numbers(&value));
    let is_brighter =
        value("BaseRenditionIsHDR").is_some_and(|value| value.trim().eq_ignore_ascii_case("true"));
    let parameters = Parameters {
        minimum: number("GainMapMin", 0.0)?,
        maximum: numbers(&value("GainMapMax")?)?,
        gamma: number("Gamma", 1.0)?,
        base_offset: number("OffsetSDR", 1.0 / 64.0)?,
        alternate_offset: number("OffsetHDR", 1.0 / 64.0)?,
    };
    (!is_brighter).then_some(parameters)
}

/// Prefix of the names of a name `space`, with its colon.
fn prefix(text: &str, space: &str) -> Option<String> {
    let before =
        text[..text.find(space)?].trim_end_matches(['"', '\'']).trim_end().strip_suffix('=')?.trim_end();
    let name = &before[before.rfind("xmlns:")? + "xmlns:".len()..];
    Some(format!("{name}:"))
}

/// Value of an attribute, or content of an element without its tags.
fn property(text: &str, name: &str) -> Option<String> {
    for (place, _) in text.match_indices(name) {
        let after = text[place + name.len()..].trim_start();
        if let Some(value) = after.strip_prefix('=') {
            let value = value.trim_start();
            let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
            return value[1..].split(quote).next().map(String::from);
        }
        if text[..place].ends_with('<') && after.starts_with('>') {
            let content = &after[1..after.find(&format!("</{name}"))?];
            let words = content.split('<').map(|part| part.rsplit('>').next().unwrap_or_default());
            return Some(words.collect::<Vec<_>>().join(" "));
        }
    }
    None
}

/// Three numbers, or one for all channels.
fn numbers(text: &str) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    match numbers[..] {
        [number] => Some([number; 3]),
        [red, green, blue] => Some([red, green, blue]),
        _ => None,
    }
}
