//! Files that the crate writes come back; damaged and cut ones give an error; others are refused with a way out.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test may panic, and exact values are expected")]

use exr::block::UncompressedBlock;
use exr::block::writer::ChunksWriter;
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{
    ChannelDescription, Compression, IntegerBounds, LevelMode, LineOrder, SampleType as FileType, Text,
    TileDescription,
};
use exr::meta::header::Header as Layout;
use exr::meta::{BlockDescription, Headers};
use half::f16;
use ndarray::{Array3, s};

use super::open;
use super::write::{self, Options, write};
use crate::error::Error;
use crate::formats::header::{Alpha, Header};
use crate::formats::picture::{PictureFile, Samples};

const COMPRESSIONS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];
const TILES: BlockDescription = BlockDescription::Tiles(TileDescription {
    tile_size: Vec2(16, 8),
    level_mode: LevelMode::Singular,
    rounding_mode: RoundingMode::Down,
});
/// Most pixels of a file.
fn limit() -> usize {
    1 << 16
}

/// Value of a channel at a pixel, smooth and exact in all types.
fn value(x: usize, y: usize, channel: usize) -> f32 {
    (x / 4 + 2 * (y / 4)) as f32 / 8.0 + channel as f32
}

fn layout(name: &str, width: usize, height: usize, channels: &[(&str, FileType)]) -> Layout {
    let list = channels.iter().map(|(name, kind)| ChannelDescription::named(*name, *kind)).collect();
    Layout::new(Text::from(name), (width, height), list)
}

/// Bytes of a file whose samples are those of `value`.
fn file(layouts: Vec<Layout>) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let headers: Headers = layouts.into();
    exr::block::write(&mut bytes, headers, true, |meta, writer| {
        for (number, index) in meta.enumerate_ordered_header_block_indices().collect::<Vec<_>>() {
            let header = &meta.headers[index.layer];
            let mut data = Vec::new();
            for y in 0..index.pixel_size.1 {
                for (channel, description) in header.channels.list.iter().enumerate() {
                    for x in 0..index.pixel_size.0 {
                        let value = value(index.pixel_position.0 + x, index.pixel_position.1 + y, channel);
                        match description.sample_type {
                            FileType::F16 => data.extend(f16::from_f32(value).to_ne_bytes()),
                            FileType::F32 => data.extend(value.to_ne_bytes()),
                            FileType::U32 => data.extend((value as u32).to_ne_bytes()),
                        }
                    }
                }
            }
            let chunk = UncompressedBlock { index, data }.compress_to_chunk(&meta.headers)?;
            writer.write_chunk(number, chunk)?;
        }
        Ok(())
    })
    .unwrap();
    bytes.into_inner()
}

fn rgb(kind: FileType) -> [(&'static str, FileType); 3] {
    ["B", "G", "R"].map(|name| (name, kind))
}

fn floats(samples: Samples) -> Array3<f32> {
    match samples {
        Samples::Floats(samples) => samples,
        Samples::Halves(samples) => samples.mapv(f16::to_f32),
        _ => unreachable!(),
    }
}

#[test]
fn every_type_and_compression_comes_back_in_strips_and_tiles() {
    for compression in COMPRESSIONS {
        for kind in [FileType::F16, FileType::F32] {
            for (blocks, order) in [
                (BlockDescription::ScanLines, LineOrder::Increasing),
                (BlockDescription::ScanLines, LineOrder::Decreasing),
                (TILES, LineOrder::Unspecified),
            ] {
                let layout = layout("", 37, 21, &rgb(kind)).with_encoding(compression, blocks, order);
                let picture = open(file(vec![layout.with_position(Vec2(-3, 5))]), limit()).unwrap();
                let samples = picture.samples(0, &[0, 1, 2], 0..21).unwrap();
                assert_eq!(matches!(samples, Samples::Halves(_)), kind == FileType::F16);
                let samples = floats(samples);
                let tolerance = if compression.may_loose_data() { 0.03 } else { 0.0 };
                for ((y, x, channel), &sample) in samples.indexed_iter() {
                    let expected = value(x, y, 2 - channel);
                    assert!((sample - expected).abs() <= tolerance, "{compression:?} {kind:?} {blocks:?}");
                }
                let some = floats(picture.samples(0, &[2, 0], 7..19).unwrap());
                assert_eq!(some.slice(s![.., .., 0]), samples.slice(s![7..19, .., 2]));
                assert_eq!(some.slice(s![.., .., 1]), samples.slice(s![7..19, .., 0]));
            }
        }
    }
}

#[test]
fn statements_are_those_of_each_part() {
    let mut first = layout("beauty", 20, 10, &rgb(FileType::F16));
    let channels =
        [("A", FileType::F32), ("B", FileType::F16), ("id", FileType::U32), ("n.Y", FileType::F32)];
    let mut second = layout("subimage01", 10, 20, &channels);
    for part in [&mut first, &mut second] {
        *part = part.clone().with_encoding(
            Compression::ZIP16,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        );
        part.shared_attributes.display_window = IntegerBounds::new((0, 0), (20, 10));
    }
    first.own_attributes.comments = Some(Text::from("a\nb"));
    first.own_attributes.view_name = Some(Text::from("left"));
    first.own_attributes.exposure = Some(0.25);
    first.own_attributes.white_luminance = Some(100.0);
    let picture = open(file(vec![first, second]), limit()).unwrap();
    let [first, second] = picture.parts() else { panic!() };
    assert_eq!(
        (first.name.as_str(), first.view.as_str(), first.description.as_str()),
        ("beauty", "left", "a\nb")
    );
    assert_eq!((first.exif["ExposureTime"], first.white_luminance), (0.25, Some(100.0)));
    assert_eq!((first.data_window, first.alpha, first.block), (None, Alpha::None, 10));
    assert_eq!((second.name.as_str(), second.alpha, second.block), ("", Alpha::Premultiplied, 16));
    assert_eq!((second.data_window, second.display_window), (Some((0, 0, 10, 20)), Some((0, 0, 20, 10))));
    let names: Vec<_> = second.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["B", "A", "id", "n.Y"]);
    assert!(matches!(picture.samples(1, &[0], 3..5).unwrap(), Samples::Halves(_)));
    let mixed = floats(picture.samples(1, &[0, 1], 3..18).unwrap());
    assert_eq!((mixed[[14, 7, 0]], mixed[[14, 7, 1]]), (value(7, 17, 1), value(7, 17, 0)));
    let refusal = picture.samples(1, &[0, 2], 0..1).unwrap_err();
    assert!(matches!(&refusal, Error::UnreadFile { reason } if reason.contains("its samples are uint")));
}

#[test]
fn channels_of_positions_keep_their_order() {
    let channels = ["N.X", "N.Y", "N.Z", "Z", "a", "green", "y"].map(|name| (name, FileType::F32));
    let picture = open(file(vec![layout("", 4, 4, &channels)]), limit()).unwrap();
    let names: Vec<_> = picture.parts()[0].channels.iter().map(|channel| channel.name.clone()).collect();
    assert_eq!(names, ["green", "y", "a", "Z", "N.X", "N.Y", "N.Z"]);
}

#[test]
fn other_kinds_and_wrong_claims_are_refused_with_the_reason() {
    let whole = file(vec![layout("", 8, 8, &rgb(FileType::F16))]);
    assert!(matches!(open(whole.clone(), 63), Err(Error::HugeImage { height: 8, width: 8, limit: 63 })));
    let large =
        layout("", 8, 8, &rgb(FileType::F16)).with_display_window(IntegerBounds::new((0, 0), (300, 300)));
    assert!(matches!(open(file(vec![large]), limit()), Err(Error::HugeImage { height: 300, .. })));
    for (attribute, offset, value, words) in [
        ("chlist\0", 14, &[2][..], "of half resolution (Y, RY, BY), which are not converted"),
        ("compression\0compression\0", 4, &[11], "compressed by HTJ2K"),
        ("type\0string\0\x0a\0\0\0tiledimage", -14, b"\x08\0\0\0deeptile", "it is a deep image"),
        ("dataWindow\0box2i\0", 4, &[200], "its attribute dataWindow has a wrong value"),
        ("chlist\0", 4, b"Z", "in alphabetical order"),
        ("chunkCount\0int\0", 4, &[77], "(chunkCount) contradicts its size"),
    ] {
        let mut bytes = whole.clone();
        let name = bytes.windows(attribute.len()).position(|window| window == attribute.as_bytes()).unwrap();
        let end = name + attribute.len();
        let start = end.saturating_add_signed(offset);
        bytes.splice(start..end.max(start + value.len()), value.iter().copied());
        let refusal = open(bytes, limit()).err().unwrap().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}

#[test]
fn a_written_file_comes_back_and_is_the_same_for_any_number_of_threads() {
    let samples = Array3::from_shape_fn((37, 19, 4), |(y, x, channel)| value(x, y, channel));
    for (name, compression) in write::COMPRESSIONS {
        for is_half in [false, true] {
            let options = Options {
                channels: &["R", "G", "B", "A"],
                is_half,
                compression,
                chromaticities: Some([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]),
                white_luminance: Some(1.0),
                environment: "cube",
                comments: "a: \u{e9}\nb",
            };
            let bytes = write(samples.view(), &options).unwrap();
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            assert!(one.install(|| write(samples.view(), &options)) == Ok(bytes.clone()), "{name}");
            let picture = open(bytes, limit()).unwrap();
            let header = &picture.parts()[0];
            assert_eq!((header.environment, header.border_sampled), ("cube", true));
            assert_eq!((header.description.as_str(), header.white_luminance), (options.comments, Some(1.0)));
            assert_eq!(header.colour.chromaticities.unwrap()[7], f64::from(0.329_f32));
            assert_eq!(header.alpha, Alpha::Premultiplied);
            assert_eq!(floats(picture.samples(0, &[0, 1, 2, 3], 0..37).unwrap()), samples);
        }
    }
    let wrong = Options { channels: &["R"], ..EMPTY };
    assert!(matches!(write(samples.view(), &wrong), Err(Error::WrongShape { .. })));
    let twice = Options { channels: &["R", "R", "G", "B"], ..EMPTY };
    assert!(matches!(write(samples.view(), &twice), Err(Error::NoSuchLayout { .. })));
    assert!(matches!(write(Array3::zeros((0, 2, 1)).view(), &wrong), Err(Error::EmptyImage { .. })));
}

const EMPTY: Options<'_> = Options {
    channels: &[],
    is_half: true,
    compression: Compression::ZIP16,
    chromaticities: None,
    white_luminance: None,
    environment: "",
    comments: "",
};

/// All samples of the first part, and of the others if they are of the same kind; the number of rows on success.
fn read_all(bytes: Vec<u8>) -> Result<usize, Error> {
    let picture = open(bytes, limit())?;
    let rows = |(part, header): (usize, &Header)| {
        let channels: Vec<usize> = (0..header.channels.len()).collect();
        picture.samples(part, &channels, 0..header.height).map(|_| header.height)
    };
    picture.parts().iter().enumerate().map(rows).sum()
}

#[test]
fn cut_and_mutated_files_give_an_answer_or_an_error() {
    let mut random = 1_u64;
    let mut next = |limit: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % limit
    };
    for compression in COMPRESSIONS {
        for kind in [FileType::F16, FileType::F32] {
            for blocks in [BlockDescription::ScanLines, TILES] {
                let part = |name| {
                    layout(name, 19, 11, &rgb(kind)).with_encoding(compression, blocks, LineOrder::Increasing)
                };
                let whole = file(vec![part("a"), part("b")]);
                assert_eq!(read_all(whole.clone()), Ok(22));
                for length in (0..whole.len()).step_by(7) {
                    assert!(read_all(whole[..length].to_vec()).is_err(), "{compression:?} cut at {length}");
                }
                for _ in 0..300 {
                    let mut mutant = whole.clone();
                    for _ in 0..=next(4) {
                        let place = next(mutant.len());
                        mutant[place] = [0, 1, 127, 128, 255, next(256) as u8][next(6)];
                    }
                    let _ = read_all(mutant);
                }
            }
        }
    }
}
