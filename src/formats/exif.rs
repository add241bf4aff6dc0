//! Numbers of EXIF (CIPA DC-008), from bytes in the layout of TIFF: a segment of JPEG, a chunk of PNG, a TIFF file.
//!
//! Nothing but the tags of [`TAGS`] is read, and no memory is allocated for anything that the bytes claim.

use std::collections::BTreeMap;

use super::directory::{Directory, File};

/// Names and codes of the tags whose numbers are used.
pub const TAGS: [(&str, u16); 14] = [
    ("Orientation", 0x0112),
    ("ExposureTime", 0x829A),
    ("FNumber", 0x829D),
    ("PhotographicSensitivity", 0x8827),
    ("ShutterSpeedValue", 0x9201),
    ("ApertureValue", 0x9202),
    ("FocalLength", 0x920A),
    ("ColorSpace", 0xA001),
    ("PixelXDimension", 0xA002),
    ("PixelYDimension", 0xA003),
    ("FocalPlaneXResolution", 0xA20E),
    ("FocalPlaneYResolution", 0xA20F),
    ("FocalPlaneResolutionUnit", 0xA210),
    ("FocalLengthIn35mmFilm", 0xA405),
];

/// Tag of the place of the EXIF directory.
const EXIF_DIRECTORY: u16 = 0x8769;

/// First number of each tag of [`TAGS`], by its name; damaged tags, and all tags of damaged bytes, are left out.
///
/// The tags lie in the first directory or in the EXIF directory, which wins.
pub fn numbers(bytes: &[u8]) -> BTreeMap<&'static str, f64> {
    File::new(bytes).and_then(File::first).map(|first| numbers_of(&first)).unwrap_or_default()
}

/// EXIF orientation among the `numbers`, 1 to 8; 1 without one.
pub fn orientation(numbers: &BTreeMap<&'static str, f64>) -> u8 {
    let stated = numbers.get("Orientation").copied().unwrap_or(1.0);
    (1..=8).find(|&value| (f64::from(value) - stated).abs() < f64::EPSILON).unwrap_or(1)
}

/// First number of each tag of [`TAGS`] in a directory or in its EXIF directory.
pub fn numbers_of(first: &Directory<'_>) -> BTreeMap<&'static str, f64> {
    let exif = first.child(EXIF_DIRECTORY);
    let number_of = |tag| exif.and_then(|exif| exif.number(tag)).or_else(|| first.number(tag));
    TAGS.iter().filter_map(|&(name, tag)| Some((name, number_of(tag)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of a first directory with Orientation and of an EXIF directory with one entry of each type.
    fn example(is_little_endian: bool) -> Vec<u8> {
        let order = |mut bytes: Vec<u8>| {
            if is_little_endian {
                bytes.reverse();
            }
            bytes
        };
        let short = |value: u16| order(value.to_be_bytes().to_vec());
        let long = |value: u32| order(value.to_be_bytes().to_vec());
        let entry = |tag, kind, value: Vec<u8>| {
            let mut value = value;
            value.resize(4, 0);
            [short(tag), short(kind), long(1), value].concat()
        };
        let (exif, after) = (8 + 2 + 24 + 4, 8 + 2 + 24 + 4 + 2 + 7 * 12 + 4);
        let mut bytes = if is_little_endian { b"II*\0".to_vec() } else { b"MM\0*".to_vec() };
        bytes.extend([long(8), short(2), entry(0x0112, 3, short(6)), entry(0x8769, 4, long(exif))].concat());
        bytes.extend([long(0), short(7)].concat());
        bytes.extend(entry(0x829A, 5, long(after)));
        bytes.extend(entry(0x9201, 10, long(after + 8)));
        bytes.extend(entry(0x920A, 11, order(35.5_f32.to_be_bytes().to_vec())));
        bytes.extend(entry(0xA002, 4, long(70_000)));
        bytes.extend(entry(0xA20E, 12, long(after + 16)));
        bytes.extend(entry(0xA210, 1, vec![3]));
        bytes.extend(entry(0xA001, 5, long(after + 4)));
        bytes.extend([long(0), long(1), long(250), long((-3_i32).cast_unsigned()), long(2)].concat());
        bytes.extend(order(99.25_f64.to_be_bytes().to_vec()));
        bytes
    }

    #[test]
    fn numbers_of_both_byte_orders_are_read() {
        let wanted = BTreeMap::from([
            ("Orientation", 6.0),
            ("ExposureTime", 0.004),
            ("ShutterSpeedValue", -1.5),
            ("FocalLength", 35.5),
            ("ColorSpace", 250.0 / f64::from((-3_i32).cast_unsigned())),
            ("PixelXDimension", 70_000.0),
            ("FocalPlaneXResolution", 99.25),
            ("FocalPlaneResolutionUnit", 3.0),
        ]);
        for is_little_endian in [true, false] {
            let found = numbers(&example(is_little_endian));
            assert_eq!(found, wanted);
            assert_eq!(orientation(&found), 6);
        }
    }

    /// A cut leaves out what is missing; a changed byte does no harm.
    #[test]
    fn damaged_bytes_give_fewer_numbers() {
        let whole = example(true);
        let mut last = 0;
        for length in 0..=whole.len() {
            let seen = numbers(&whole[..length]).len();
            assert!(seen >= last, "{length}");
            last = seen;
        }
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 0xFF;
            numbers(&bytes);
        }
    }

    #[test]
    fn undefined_orientations_and_quotients_by_zero_are_passed_over() {
        assert_eq!(orientation(&BTreeMap::from([("Orientation", 9.0)])), 1);
        assert_eq!(orientation(&BTreeMap::new()), 1);
        let mut bytes = example(false);
        let after = bytes.len() - 24;
        bytes[after + 4..after + 8].fill(0);
        assert!(!numbers(&bytes).contains_key("ExposureTime"));
    }
}
