#![allow(clippy::unwrap_used, reason = "a test may panic")]

use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use ndarray::Array3;
use proptest::prelude::*;

use super::frame::marker;
use super::*;
use crate::error::Error;
use crate::formats::picture::Samples;

/// Picture of smooth colours.
fn colours(height: usize, width: usize, channels: usize) -> Vec<u8> {
    let sample = |place: usize| {
        let (pixel, channel) = (place / channels, place % channels);
        let (y, x) = ((pixel / width) as f64, (pixel % width) as f64);
        (128.0 + 90.0 * (0.11 * y + 0.07 * x + channel as f64).sin()) as u8
    };
    (0..height * width * channels).map(sample).collect()
}

/// File of smooth colours, changed by some settings.
fn file(height: usize, width: usize, colour: ColorType, set: impl Fn(&mut Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    let channels = match colour {
        ColorType::Luma => 1,
        ColorType::Cmyk => 4,
        _ => 3,
    };
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, 97);
    encoder.set_sampling_factor(SamplingFactor::F_1_1);
    set(&mut encoder);
    encoder.encode(&colours(height, width, channels), width as u16, height as u16, colour).unwrap();
    bytes
}

fn rgb_file(set: impl Fn(&mut Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    file(21, 35, ColorType::Rgb, set)
}

fn read(bytes: Vec<u8>) -> Result<Array3<u8>> {
    let jpeg = open(bytes, 1 << 20)?;
    let header = &jpeg.parts()[0];
    match jpeg.samples(0, &[0, 1, 2][..header.channels.len()], 0..header.height)? {
        Samples::Bytes(samples) => Ok(samples),
        other => panic!("{other:?}"),
    }
}

fn refusal(bytes: Vec<u8>) -> String {
    read(bytes).unwrap_err().to_string()
}

/// Position of the first marker of a kind.
fn place(bytes: &[u8], code: u8) -> usize {
    bytes.windows(2).position(|pair| pair == [0xFF, code]).unwrap()
}

/// Bytes with a segment after the first marker.
fn with_segment(mut bytes: Vec<u8>, code: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    let length = (body.len() as u16 + 2).to_be_bytes();
    bytes.splice(2..2, [&[0xFF, code], &length[..], &body].concat());
    bytes
}

type Setting = fn(&mut Encoder<&mut Vec<u8>>);

const SETTINGS: [Setting; 8] = [
    |_| {},
    |encoder| encoder.set_sampling_factor(SamplingFactor::F_2_2),
    |encoder| encoder.set_sampling_factor(SamplingFactor::F_2_1),
    |encoder| encoder.set_sampling_factor(SamplingFactor::F_1_2),
    |encoder| encoder.set_sampling_factor(SamplingFactor::F_4_1),
    |encoder| encoder.set_progressive(true),
    |encoder| encoder.set_restart_interval(2),
    |encoder| {
        encoder.set_progressive(true);
        encoder.set_sampling_factor(SamplingFactor::F_2_2);
    },
];

#[test]
fn colours_of_all_samplings_return() {
    for (place, set) in SETTINGS.into_iter().enumerate() {
        for (height, width) in [(21, 35), (1, 1), (8, 16), (33, 2), (2, 67)] {
            let samples = read(file(height, width, ColorType::Rgb, set)).unwrap();
            assert_eq!(samples.dim(), (height, width, 3));
            for (&found, wanted) in samples.iter().zip(colours(height, width, 3)) {
                assert!(found.abs_diff(wanted) < 24, "{place}: {height}x{width}: {found}, want {wanted}");
            }
        }
    }
}

#[test]
fn grey_and_cmyk_are_read() {
    let grey = read(file(21, 35, ColorType::Luma, |_| {})).unwrap();
    assert!(grey.iter().zip(colours(21, 35, 1)).all(|(found, wanted)| found.abs_diff(wanted) < 4));
    // The encoder turns CMYK around, so that the file holds 255 less the ink.
    let inks = colours(21, 35, 4);
    let found = read(file(21, 35, ColorType::Cmyk, |_| {})).unwrap();
    for (pixel, inks) in found.as_slice().unwrap().chunks(3).zip(inks.chunks(4)) {
        for (&found, &ink) in pixel.iter().zip(inks) {
            let wanted = f64::from(255 - ink) * f64::from(255 - inks[3]) / 255.0;
            assert!((f64::from(found) - wanted).abs() < 6.0, "{found}, want {wanted}");
        }
    }
}

#[test]
fn rows_and_channels_are_those_of_the_whole() {
    let jpeg = open(rgb_file(SETTINGS[1]), 1 << 20).unwrap();
    let Samples::Bytes(whole) = jpeg.samples(0, &[0, 1, 2], 0..21).unwrap() else { panic!() };
    let Samples::Bytes(part) = jpeg.samples(0, &[2], 5..18).unwrap() else { panic!() };
    assert_eq!(part, whole.slice(ndarray::s![5..18, .., 2..]));
}

/// The table of first coefficients is number 2; scans of other coefficients say 0, which no table has.
#[test]
fn a_scan_needs_the_tables_of_its_own_coefficients_alone() {
    let mut bytes = file(21, 35, ColorType::Luma, SETTINGS[5]);
    let expected = read(bytes.clone()).unwrap();
    let (table, scan) = (place(&bytes, marker::HUFFMAN_TABLES) + 4, place(&bytes, marker::SCAN) + 6);
    assert_eq!((bytes[table], bytes[scan] >> 4), (0, 0));
    bytes[table] = 2;
    bytes[scan] |= 0x20;
    assert_eq!(read(bytes).unwrap(), expected);
}

/// All shorter files are refused, whatever their coding is; bytes behind the end are passed over.
#[test]
fn a_cut_file_is_refused() {
    for set in SETTINGS {
        let bytes = rgb_file(set);
        for length in (0..bytes.len() - 1).step_by(7).chain([bytes.len() - 2, bytes.len() - 1]) {
            assert!(read(bytes[..length].to_vec()).is_err(), "{length} of {}", bytes.len());
        }
        // The end may also be set behind what is left.
        for length in (place(&bytes, marker::SCAN) + 20..bytes.len() - 4).step_by(7) {
            let cut = [&bytes[..length], &[0xFF, marker::END]].concat();
            assert!(read(cut).is_err(), "{length} of {}", bytes.len());
        }
        let longer = [bytes.clone(), bytes.clone()].concat();
        assert_eq!(read(longer).unwrap(), read(bytes).unwrap());
    }
}

#[test]
fn harmless_bytes_are_passed_over() {
    let bytes = rgb_file(|_| {});
    let wanted = read(bytes.clone()).unwrap();
    let mut padded = bytes.clone();
    for code in [marker::END, marker::SCAN, marker::HUFFMAN_TABLES] {
        padded.splice(place(&padded, code)..place(&padded, code), [0xFF; 3]);
    }
    assert_eq!(read(padded).unwrap(), wanted);
    // Some encoders pad the last scan by zeros, or close the last interval by a restart marker.
    let zeros = [&bytes[..bytes.len() - 2], &[0, 0, 0xFF, marker::END]].concat();
    assert_eq!(read(zeros).unwrap(), wanted);
    let bytes = rgb_file(SETTINGS[6]);
    let restarts =
        bytes.windows(2).filter(|pair| pair[0] == 0xFF && (0xD0..0xD8).contains(&pair[1])).count() as u8;
    let closed = [&bytes[..bytes.len() - 2], &[0xFF, 0xD0 + restarts % 8, 0xFF, marker::END]].concat();
    assert_eq!(read(closed).unwrap(), wanted);
}

#[test]
fn lost_restarts_and_garbage_are_refused() {
    let bytes = rgb_file(SETTINGS[6]);
    let restart = place(&bytes, 0xD1);
    let mut lost = bytes.clone();
    lost.drain(restart..restart + 2);
    assert!(refusal(lost).contains("restart marker"));
    let mut other = bytes.clone();
    other[restart + 1] = 0xD3;
    assert!(refusal(other).contains("restart marker"));
    for code in [marker::STEPS, marker::HUFFMAN_TABLES, marker::SCAN] {
        let mut garbage = bytes.clone();
        garbage.splice(place(&bytes, code)..place(&bytes, code), [7; 3]);
        assert!(refusal(garbage).contains("no marker"));
    }
    let end = bytes.len() - 2;
    let mut garbage = bytes.clone();
    garbage.splice(end..end, [7; 3]);
    assert!(refusal(garbage).contains("damaged"));
}

#[test]
fn other_processes_are_refused_by_name() {
    let bytes = rgb_file(|_| {});
    let frame = place(&bytes, 0xC0);
    for (code, name) in
        [(0xC3, "lossless"), (0xC5, "hierarchical"), (0xC9, "arithmetic"), (0xCA, "arithmetic")]
    {
        let mut other = bytes.clone();
        other[frame + 1] = code;
        assert!(refusal(other).contains(name));
    }
    let mut deep = bytes;
    deep[frame + 4] = 12;
    assert!(refusal(deep).contains("12 bits"));
}

/// Blocks of 3 by 1 and 2 by 1, and of 1 by 3 and 1 by 2, in a unit.
#[test]
fn fractions_of_a_sample_along_one_axis_are_refused() {
    let bytes = rgb_file(|_| {});
    let factors = place(&bytes, 0xC0) + 11;
    for (first, second) in [(0x31, 0x21), (0x13, 0x12)] {
        let mut other = bytes.clone();
        (other[factors], other[factors + 3]) = (first, second);
        assert!(refusal(other).contains("a fraction of a sample"));
    }
}

/// A small file may not claim many pixels, since each block takes a bit.
#[test]
fn a_frame_is_compared_with_the_limit_and_the_file() {
    let mut bytes = rgb_file(|_| {});
    let frame = place(&bytes, 0xC0);
    bytes[frame + 5..frame + 9].fill(0xFF);
    assert!(matches!(open(bytes.clone(), 1 << 20), Err(Error::HugeImage { .. })));
    let refusal = open(bytes.clone(), usize::MAX).unwrap_err().to_string();
    assert!(refusal.contains("cannot hold 65535x65535 pixels"), "{refusal}");
    bytes[frame + 5..frame + 7].fill(0);
    assert!(refusal_of_open(bytes).contains("it has no size before its pixels"));
}

fn refusal_of_open(bytes: Vec<u8>) -> String {
    open(bytes, usize::MAX).unwrap_err().to_string()
}

#[test]
fn statements_are_read() {
    let exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    let mut bytes = rgb_file(|_| {});
    let digest = b"0123456789ABCDEF0123456789ABCDEF";
    let extension = |offset: u8, text: &[u8]| {
        [b"http://ns.adobe.com/xmp/extension/\0", &digest[..], &[0, 0, 0, 6, 0, 0, 0, offset], text].concat()
    };
    let xmp = b"http://ns.adobe.com/xap/1.0/\0";
    bytes = with_segment(bytes, marker::APP1, &[&extension(3, b"def")]);
    bytes = with_segment(bytes, marker::APP1, &[&extension(0, b"abc")]);
    bytes = with_segment(bytes, marker::APP1, &[xmp, b"second ", digest]);
    bytes = with_segment(bytes, marker::APP1, &[xmp, b"first"]);
    bytes = with_segment(bytes, marker::APP2, &[b"ICC_PROFILE\0\x02\x02", b"file"]);
    bytes = with_segment(bytes, marker::APP2, &[b"ICC_PROFILE\0\x01\x02", b"pro"]);
    bytes = with_segment(bytes, marker::APP1, &[exif]);
    bytes = with_segment(bytes, marker::COMMENT, &[b"a comment\0"]);
    let jpeg = open(bytes.clone(), 1 << 20).unwrap();
    let header = &jpeg.parts()[0];
    assert_eq!(
        (header.orientation, &header.colour.icc[..], &header.xmp[0][..]),
        (6, &b"profile"[..], &b"first"[..])
    );
    assert_eq!(header.xmp[1..], [[&b"second "[..], digest].concat(), b"abcdef".to_vec()]);
    assert_eq!(header.description, "a comment");
    assert!(header.notes.is_empty() && header.gain_map.is_none());

    // A profile without its second chunk is left out.
    let lost = place(&bytes, marker::APP2);
    bytes.drain(lost..lost + 2 + 2 + 14 + 3);
    let jpeg = open(bytes, 1 << 20).unwrap();
    assert!(jpeg.parts()[0].colour.icc.is_empty() && jpeg.parts()[0].notes[0].contains("ICC profile"));
}

/// File with a second picture, which has segments of a gain map.
fn with_gain_map(segments: &[(u8, &[&[u8]])]) -> Vec<u8> {
    let first = with_segment(
        rgb_file(|_| {}),
        marker::APP1,
        &[
            b"http://ns.adobe.com/xap/1.0/\0",
            b"<a xmlns:g='http://ns.adobe.com/hdr-gain-map/1.0/' g:Version='1.0'/>",
        ],
    );
    let mut second = file(5, 9, ColorType::Luma, |_| {});
    for &(code, parts) in segments {
        second = with_segment(second, code, parts);
    }
    [first, second].concat()
}

const XMP: (u8, &[&[u8]]) = (
    marker::APP1,
    &[
        b"http://ns.adobe.com/xap/1.0/\0",
        b"<a xmlns:g='http://ns.adobe.com/hdr-gain-map/1.0/' g:GainMapMax = \"2.5\" g:OffsetSDR=\"0.25\">",
        b"<g:Gamma><rdf:Seq><rdf:li>1</rdf:li> <rdf:li>0.5</rdf:li><rdf:li>2</rdf:li></rdf:Seq></g:Gamma></a>",
    ],
);

#[test]
fn a_gain_map_of_xmp_is_read() {
    let jpeg = open(with_gain_map(&[XMP]), 1 << 20).unwrap();
    let map = jpeg.parts()[0].gain_map.as_ref().unwrap();
    assert_eq!(map.codes.dim(), (5, 9, 1));
    assert_eq!((map.parameters.maximum, map.parameters.gamma), ([2.5; 3], [1.0, 0.5, 2.0]));
    assert_eq!((map.parameters.minimum, map.parameters.alternate_offset), ([0.0; 3], [1.0 / 64.0; 3]));
    assert!(jpeg.parts()[0].notes.is_empty());
}

/// Properties of XMP are attributes or elements.
#[test]
fn a_number_of_a_gain_map_may_be_an_element() {
    let text = b"<a xmlns:g='http://ns.adobe.com/hdr-gain-map/1.0/'><g:GainMapMax>2.5</g:GainMapMax></a>";
    let jpeg = open(with_gain_map(&[(marker::APP1, &[XMP.1[0], text])]), 1 << 20).unwrap();
    let parameters = jpeg.parts()[0].gain_map.as_ref().unwrap().parameters;
    assert_eq!((parameters.minimum, parameters.maximum), ([0.0; 3], [2.5; 3]));
}

/// The segment of ISO 21496-1 wins over XMP; with and without a common denominator.
#[test]
fn a_gain_map_of_iso_21496_is_read() {
    let urn = b"urn:iso:std:iso:ts:21496:-1\0";
    let common: Vec<u8> =
        [4_i32, 0, 8, -4, 12, 4, 1, 2].iter().flat_map(|number| number.to_be_bytes()).collect();
    let pairs = [0, 1, 2, 1, -1, 1, 3, 1, 1, 1, 1, 4, 1, 2];
    let pairs: Vec<u8> = pairs.iter().flat_map(|number: &i32| number.to_be_bytes()).collect();
    for (flags, numbers) in [(0x48, &common), (0x40, &pairs)] {
        let segment: &[&[u8]] = &[urn, &[0, 0, 0, 0, flags], numbers];
        let jpeg = open(with_gain_map(&[XMP, (marker::APP2, segment)]), 1 << 20).unwrap();
        let parameters = jpeg.parts()[0].gain_map.as_ref().unwrap().parameters;
        assert_eq!((parameters.minimum, parameters.maximum), ([-1.0; 3], [3.0; 3]));
        assert_eq!(
            (parameters.gamma, parameters.base_offset, parameters.alternate_offset),
            ([1.0; 3], [0.25; 3], [0.5; 3])
        );
    }
}

#[test]
fn a_gain_map_that_cannot_be_applied_is_noted() {
    let whole = with_gain_map(&[XMP]);
    let apple: &[&[u8]] =
        &[XMP.1[0], b"<a xmlns:H='http://ns.apple.com/HDRGainMap/1.0/' H:HDRGainMapVersion='65536'/>"];
    let infinite: &[&[u8]] =
        &[XMP.1[0], b"<a xmlns:g='http://ns.adobe.com/hdr-gain-map/1.0/' g:GainMapMax='1e9'/>"];
    let files = [
        whole[..whole.len() - 9].to_vec(),
        with_gain_map(&[]),
        with_gain_map(&[(marker::APP1, apple)]),
        with_gain_map(&[(marker::APP1, infinite)]),
    ];
    for bytes in files {
        let jpeg = open(bytes, 1 << 20).unwrap();
        let header = &jpeg.parts()[0];
        assert!(header.gain_map.is_none());
        assert!(header.notes[0].contains("gain map was not applied"));
        assert!(read(jpeg.bytes).is_ok());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A changed file gives samples or a refusal, and does not panic.
    #[test]
    fn a_changed_file_is_an_answer_or_a_refusal(
        setting in 0..SETTINGS.len(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = rgb_file(SETTINGS[setting]);
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let _ = read(bytes);
    }

    /// A changed gain map gives samples, or a note, or a refusal.
    #[test]
    fn a_changed_gain_map_is_an_answer_or_a_note(place in any::<prop::sample::Index>(), byte: u8) {
        let mut bytes = with_gain_map(&[XMP]);
        let place = place.index(bytes.len());
        bytes[place] = byte;
        let _ = read(bytes);
    }
}
