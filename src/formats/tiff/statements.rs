//! Header of a page: names of its channels, and what its tags state about colour, place and exposure.

use super::page::{Form, Page};
use crate::error::Result;
use crate::formats::directory::Directory;
use crate::formats::exif;
use crate::formats::header::{Alpha, Channel, Colour, Header};
use crate::formats::input::damage;

const DESCRIPTION: u16 = 270;
const EXTRA_SAMPLES: u16 = 338;
const XMP: u16 = 700;
/// Format of a texture, by Pixar.
pub const TEXTURE_FORMAT: u16 = 33302;
const ICC: u16 = 34675;
/// Longest texts and profiles that are read, in bytes.
const MOST: (usize, usize, usize) = (1 << 16, 4 << 20, 16 << 20);

/// Header of a `page` with its `directory`, whose texts and profiles are taken off the number of bytes in `texts`.
///
/// # Errors
///
/// If they need more: the pages of a damaged file may all claim the same long text.
pub fn header(page: &Page, directory: &Directory<'_>, texts: &mut usize) -> Result<Header> {
    let bytes = |tag, most| directory.bytes(tag, most).unwrap_or_default();
    let (icc, xmp, description) = (bytes(ICC, MOST.2), bytes(XMP, MOST.1), bytes(DESCRIPTION, MOST.0));
    let length = icc.len() + xmp.len() + description.len();
    *texts =
        texts.checked_sub(length).ok_or_else(|| damage("the TIFF file is damaged: its texts overlap"))?;
    let exif = exif::numbers_of(directory);
    let (names, alpha) = channels(page, directory);
    let sample = page.sample_type();
    let channels = names.into_iter().map(|name| Channel { name, sample }).collect();
    Ok(Header {
        alpha,
        block: page.block(),
        colour: Colour {
            icc: icc.to_vec(),
            is_srgb: exif.get("ColorSpace") == Some(&1.0),
            ..Colour::default()
        },
        orientation: exif::orientation(&exif),
        environment: environment(bytes(TEXTURE_FORMAT, MOST.0)),
        xmp: vec![xmp.to_vec()],
        exif,
        description: text(description),
        ..Header::plain("tiff", page.height, page.width, channels)
    })
}

/// Text up to its first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

fn environment(format: &[u8]) -> &'static str {
    match text(format).as_str() {
        said if said.contains("CubeFace") => "cube",
        said if said.contains("LatLong") => "latlong",
        _ => "",
    }
}

/// Names of the channels, and the meaning of alpha.
///
/// Alpha is the last extra sample that says so, or a fourth channel without a statement.
fn channels(page: &Page, directory: &Directory<'_>) -> (Vec<String>, Alpha) {
    let count = page.channels();
    let mut names: Vec<String> = (0..count).map(usual_name).collect();
    if count == 1 {
        names[0] = "Y".to_string();
    }
    let mut alpha = (count > 3).then_some((3, Alpha::Premultiplied));
    for (channel, meaning) in extra_samples(page, directory) {
        match meaning {
            1 | 2 => {
                let is_straight = meaning == 2 || alpha.is_some_and(|(_, alpha)| alpha == Alpha::Straight);
                alpha = Some((channel, if is_straight { Alpha::Straight } else { Alpha::Premultiplied }));
            }
            _ if alpha.is_some_and(|(place, _)| place == channel) => {
                names[channel] = format!("channel{channel}");
                alpha = None;
            }
            _ => {}
        }
    }
    let Some((place, alpha)) = alpha else { return (names, Alpha::None) };
    names[place] = "A".to_string();
    if count == 2 && place == 1 {
        names[0] = "Y".to_string();
    }
    (names, alpha)
}

fn usual_name(channel: usize) -> String {
    ["R", "G", "B", "A"].get(channel).map_or_else(|| format!("channel{channel}"), |name| (*name).to_string())
}

/// Channels after the colours, and their meanings: 1 alpha in the colour, 2 alpha by itself, 0 any other.
fn extra_samples(page: &Page, directory: &Directory<'_>) -> Vec<(usize, u64)> {
    if matches!(page.form, Form::Palette(_)) {
        return Vec::new();
    }
    let colours = if page.photometric == 2 { 3 } else { 1 };
    let meanings =
        directory.integers(EXTRA_SAMPLES).into_iter().flat_map(|values| values.iter(directory.file()));
    (colours..page.channels()).zip(meanings).collect()
}
