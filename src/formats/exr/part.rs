//! One image of an OpenEXR file: its attributes as a header, and the layout of its blocks.

use std::collections::BTreeMap;

use exr::compression::Compression;
use exr::io::PeekRead;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelList, Chromaticities, IntegerBounds, LineOrder, SampleType as FileType, Text, TileDescription,
};
use exr::meta::header::Header as Layout;

use super::attributes::{Attributes, int};
use super::channels::{is_alpha, order};
use crate::error::{Error, Result};
use crate::formats::header::{Alpha, Colour, Header, Window};
use crate::formats::input::{check_size, damage, unread};

/// Image of a file.
#[derive(Debug)]
pub struct Part {
    /// Layout of its blocks, as the crate describes it.
    pub layout: Layout,
    /// Numbers of the channels of the header in the file.
    pub order: Vec<usize>,
    /// Columns and rows of a block.
    pub block: Vec2<usize>,
    /// Position of the table of its blocks in the file.
    pub table: usize,
    /// Number by which blocks name their part; None in a file with one.
    pub number: Option<usize>,
}

impl Part {
    /// Statements and layout of the part with these `attributes`; `is_tiled` holds if they do not state it.
    pub fn read(
        attributes: &Attributes<'_>,
        number: Option<usize>,
        is_tiled: bool,
        table: usize,
    ) -> Result<(Header, Self)> {
        let layout = layout(attributes, number.is_some(), is_tiled)?;
        let (channels, order) = order(&layout.channels.list);
        let Vec2(width, height) = layout.layer_size;
        let tile = layout.max_block_pixel_size();
        let block = Vec2(tile.0.min(width), tile.1.min(height));
        let mut header = Header::plain("openexr", height, width, channels);
        header.block = block.1;
        describe(&mut header, attributes)?;
        set_windows(&mut header, &layout);
        Ok((header, Self { layout, order, block, table, number }))
    }

    /// Refuse more than `max_pixels`, and more samples than the bytes of the file can hold.
    pub fn check(&self, max_pixels: usize, file: usize) -> Result<()> {
        /// Most bytes that a byte becomes, of all compressions but PIZ and DWA: 1032 by deflate, 4/3 by PXR24.
        const EXPANSION: usize = 1400;
        /// Most bytes of a block, which is decoded as a whole.
        const MOST_BYTES: usize = 1 << 30;
        let Vec2(width, height) = self.layout.layer_size;
        let Vec2(full_width, full_height) = self.layout.shared_attributes.display_window.size;
        check_size(height, width, max_pixels)?;
        check_size(full_height, full_width, max_pixels)?;
        let sample_bytes = self.layout.channels.bytes_per_pixel;
        let is_bounded = !matches!(
            self.layout.compression,
            Compression::PIZ | Compression::DWAA(_) | Compression::DWAB(_)
        );
        if is_bounded && !self.layout.deep && width * height * sample_bytes > file.saturating_mul(EXPANSION) {
            return Err(damage(format!(
                "it claims {width}x{height} pixels, which its {file} bytes cannot hold"
            )));
        }
        if self.block.area().saturating_mul(sample_bytes) > MOST_BYTES {
            return Err(unread("it holds blocks of more than 1 GiB; write it with smaller tiles"));
        }
        Ok(())
    }

    /// Refuse kinds of images that are not converted.
    pub fn check_kind(&self) -> Result<()> {
        if self.layout.deep {
            return Err(unread("it is a deep image; give a flattened one"));
        }
        if self.layout.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(unread(
                "it holds luminance and chroma of half resolution (Y, RY, BY), which are not converted; \
                 give R, G and B",
            ));
        }
        if matches!(self.layout.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
            return Err(unread("its samples are compressed by HTJ2K, which is not read; write it with ZIP"));
        }
        Ok(())
    }

    /// Refuse integers of 32 bits among the `channels` of the header.
    pub fn check_samples(&self, channels: &[usize]) -> Result<()> {
        let is_integer =
            |&channel: &usize| self.layout.channels.list[self.order[channel]].sample_type == FileType::U32;
        if channels.iter().any(is_integer) {
            return Err(unread("its samples are uint; give floating point, uint8 or uint16"));
        }
        Ok(())
    }

    /// Bytes of the table of its blocks.
    pub fn table_length(&self) -> usize {
        self.layout.chunk_count * size_of::<u64>()
    }
}

/// Layout of the blocks of a part.
fn layout(attributes: &Attributes<'_>, is_multipart: bool, is_tiled: bool) -> Result<Layout> {
    let display = window(attributes, "displayWindow")?;
    let data = window(attributes, "dataWindow")?;
    let compression = attributes.demand("compression", "compression", Compression::read)?;
    let channels = channels(attributes)?;
    let kind = attributes.text("type", 64);
    let (is_tiled, is_deep) = match kind.as_str() {
        "deepscanline" => (false, true),
        "deeptile" => (true, true),
        _ if !is_multipart => (is_tiled, false),
        "scanlineimage" => (false, false),
        "tiledimage" => (true, false),
        _ => return Err(damage("its header is damaged: a part has a wrong attribute type")),
    };
    let blocks = if is_tiled { tiles(attributes)? } else { BlockDescription::ScanLines };
    let mut layout = Layout::new(Text::from(""), data.size, channels.list)
        .with_encoding(compression, blocks, LineOrder::Unspecified)
        .with_position(data.position)
        .with_display_window(display);
    layout.deep = is_deep;
    match attributes.value("chunkCount", "int", |bytes| Ok(int(bytes).unwrap_or(-1)))? {
        Some(count) if usize::try_from(count) != Ok(layout.chunk_count) => {
            Err(damage("its header is damaged: its number of blocks (chunkCount) contradicts its size"))
        }
        _ => Ok(layout),
    }
}

/// Rectangle of pixels, at least one.
fn window(attributes: &Attributes<'_>, name: &str) -> Result<IntegerBounds> {
    let wrong = || damage(format!("its header is damaged: its attribute {name} has a wrong value"));
    let mut corners = attributes.demand(name, "box2i", |bytes| Ok(*bytes))?;
    let mut corner = || Ok::<_, Error>((int(&mut corners)?, int(&mut corners)?));
    let ((left, top), (right, bottom)) = (corner()?, corner()?);
    if left > right || top > bottom {
        return Err(wrong());
    }
    // The crate swaps corners in the wrong order.
    attributes.demand(name, "box2i", |bytes| {
        let window = IntegerBounds::read(bytes)?;
        window.validate(None).map(|()| window)
    })
}

/// Channels of a part, at least one.
fn channels(attributes: &Attributes<'_>) -> Result<ChannelList> {
    /// Most channels of a part, as OpenImageIO has it.
    const MOST: usize = 4096;
    let most_bytes = MOST * 272; // with names of 255
    let channels = attributes.demand("channels", "chlist", |bytes| {
        ChannelList::read(&mut PeekRead::new(&bytes[..bytes.len().min(most_bytes)]))
    })?;
    let names: Vec<_> = channels.list.iter().map(|channel| channel.name.as_slice()).collect();
    if !(1..=MOST).contains(&names.len())
        || names[0].is_empty()
        || !names.is_sorted_by(|one, next| one < next)
    {
        return Err(damage(format!(
            "its header is damaged: its channels must be 1 to {MOST}, each with its own name, in alphabetical order"
        )));
    }
    Ok(channels)
}

fn tiles(attributes: &Attributes<'_>) -> Result<BlockDescription> {
    let tiles = attributes.demand("tiles", "tiledesc", |bytes| {
        let tiles = TileDescription::read(bytes)?;
        tiles.validate().map(|()| tiles)
    })?;
    Ok(BlockDescription::Tiles(tiles))
}

/// Numeric attributes by their names in the EXIF. OpenImageIO keeps the EXIF of photographs under such names.
const EXIF: [(&str, &str); 6] = [
    ("expTime", "ExposureTime"),
    ("aperture", "FNumber"),
    ("Exif:ShutterSpeedValue", "ShutterSpeedValue"),
    ("Exif:ApertureValue", "ApertureValue"),
    ("Exif:PhotographicSensitivity", "PhotographicSensitivity"),
    ("Exif:ISOSpeedRatings", "ISOSpeedRatings"),
];

/// Statements of the attributes in the terms of all formats.
fn describe(header: &mut Header, attributes: &Attributes<'_>) -> Result<()> {
    /// Most bytes of a text.
    const MOST: usize = 1 << 16;
    /// Most bytes of an XMP packet.
    const MOST_XMP: usize = 1 << 22;
    header.name = part_name(attributes.text("name", MOST));
    header.view = attributes.text("view", MOST);
    header.description = attributes.text("comments", MOST);
    header.xmp = vec![attributes.text("xmp", MOST_XMP).into_bytes()];
    header.colour = colour(attributes)?;
    header.white_luminance = attributes.number("whiteLuminance").filter(|&luminance| luminance > 0.0);
    let orientation = attributes.number("Orientation").filter(|said| (1.0..=8.0).contains(said));
    header.orientation = orientation.map_or(1, |said| said as u8);
    let has_alpha = header.channels.iter().any(|channel| is_alpha(&channel.name));
    header.alpha = if has_alpha { Alpha::Premultiplied } else { Alpha::None };
    let environment = attributes.value("envmap", "envmap", |bytes| Ok(bytes.first() == Some(&1)))?;
    header.environment = environment.map_or("", |is_cube| if is_cube { "cube" } else { "latlong" });
    // OpenEXR defines that the outer pixels of such maps lie on the seam, the poles and the edges.
    header.border_sampled = environment.is_some();
    let numbers = EXIF.iter().filter_map(|(name, tag)| Some((*tag, attributes.number(name)?)));
    header.exif = numbers.collect::<BTreeMap<_, _>>();
    Ok(())
}

/// Name of a part; empty for names like "subimage00", which OpenImageIO invents when it writes.
fn part_name(name: String) -> String {
    let number = name.strip_prefix("subimage").unwrap_or_default();
    let is_invented = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    if is_invented { String::new() } else { name }
}

fn colour(attributes: &Attributes<'_>) -> Result<Colour> {
    let is_aces = attributes.number("acesImageContainerFlag") == Some(1.0);
    let name = if is_aces { "lin_ap0_scene".to_string() } else { attributes.text("colorInteropID", 255) };
    let chromaticities = attributes.value("chromaticities", "chromaticities", Chromaticities::read)?;
    Ok(Colour {
        is_srgb: attributes.number("Exif:ColorSpace") == Some(1.0),
        chromaticities: chromaticities.map(|xy| {
            let points = [xy.red, xy.green, xy.blue, xy.white];
            std::array::from_fn(|place| {
                let Vec2(x, y) = points[place / 2];
                f64::from(if place % 2 == 0 { x } else { y })
            })
        }),
        name,
        ..Colour::default()
    })
}

/// Windows, if they differ. The display window of a cube is that of one face.
fn set_windows(header: &mut Header, layout: &Layout) {
    let [data, display] = [layout.data_window(), layout.shared_attributes.display_window].map(rectangle);
    if data != display && header.environment != "cube" {
        (header.data_window, header.display_window) = (Some(data), Some(display));
    }
}

fn rectangle(window: IntegerBounds) -> Window {
    let (Vec2(x, y), Vec2(width, height)) = (window.position, window.size);
    (i64::from(x), i64::from(y), width as i64, height as i64)
}
