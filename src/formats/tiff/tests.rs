use std::io::Write as _;

use ndarray::{Array3, s};

use half::f16;

use super::*;
use crate::formats::header::Alpha;
use crate::formats::picture::Samples;

/// A file to be made; its samples are a function of their place.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_excessive_bools, reason = "one for each choice of a file")]
struct Example {
    is_little: bool,
    is_big: bool,
    size: (usize, usize),
    samples: usize,
    bits: usize,
    is_float: bool,
    compression: u64,
    predictor: u64,
    is_planar: bool,
    /// Rows of a strip, or height and width of a tile.
    chunk: (usize, Option<usize>),
    photometric: u64,
}

const EXAMPLE: Example = Example {
    is_little: true,
    is_big: false,
    size: (7, 9),
    samples: 3,
    bits: 8,
    is_float: false,
    compression: 1,
    predictor: 1,
    is_planar: false,
    chunk: (3, None),
    photometric: 2,
};

impl Example {
    /// Sample as a number, which any of the types holds.
    fn value(&self, (y, x, channel): (usize, usize, usize)) -> u64 {
        let mixed = (y * 31 + x * 7 + channel * 3) as u64;
        mixed * mixed % if self.is_float { 2000 } else { 1 << self.bits }
    }

    fn integer(&self, value: u64, size: usize) -> Vec<u8> {
        if self.is_little {
            value.to_le_bytes()[..size].to_vec()
        } else {
            value.to_be_bytes()[8 - size..].to_vec()
        }
    }

    /// Bits of a sample.
    fn code(&self, value: u64) -> u64 {
        match (self.is_float, self.bits) {
            (true, 16) => f16::from_f64(value as f64).to_bits().into(),
            (true, 32) => (value as f32).to_bits().into(),
            (true, _) => (value as f64).to_bits(),
            (false, _) => value,
        }
    }

    /// A row of a strip or tile, as differences if there is a predictor.
    fn row(&self, codes: &[u64], step: usize) -> Vec<u8> {
        let size = self.bits / 8;
        let before = |place: usize| if place < step { 0 } else { codes[place - step] };
        match self.predictor {
            3 => {
                let all: Vec<[u8; 8]> = codes.iter().map(|code| code.to_be_bytes()).collect();
                let sorted: Vec<u8> =
                    (8 - size..8).flat_map(|byte| all.iter().map(move |one| one[byte])).collect();
                let before = |place: usize| if place < step { 0 } else { sorted[place - step] };
                sorted.iter().enumerate().map(|(place, byte)| byte.wrapping_sub(before(place))).collect()
            }
            _ if self.bits < 8 || !self.bits.is_multiple_of(8) => {
                let bit = |place: usize| codes[place / self.bits] >> (self.bits - 1 - place % self.bits) & 1;
                let bits: Vec<u64> = (0..codes.len() * self.bits).map(bit).collect();
                bits.chunks(8)
                    .map(|byte| (0..8).fold(0, |all, bit| all << 1 | *byte.get(bit).unwrap_or(&0) as u8))
                    .collect()
            }
            predictor => {
                let difference = |(place, code): (usize, &u64)| match predictor {
                    2 => code.wrapping_sub(before(place)),
                    _ => *code,
                };
                codes
                    .iter()
                    .enumerate()
                    .map(difference)
                    .flat_map(|code| self.integer(code & (u64::MAX >> (64 - self.bits)), size))
                    .collect()
            }
        }
    }

    fn pack(&self, bytes: &[u8]) -> Vec<u8> {
        match self.compression {
            5 => weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8)
                .encode(bytes)
                .expect("packs"),
            8 | 32946 => {
                let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                packed.write_all(bytes).and_then(|()| packed.finish()).expect("packs")
            }
            // A run, a mark without meaning, and bytes as they are.
            32773 => {
                let same = bytes.iter().take_while(|&&byte| byte == bytes[0]).count().min(128);
                let mut packed =
                    if same > 1 { vec![(257 - same) as u8, bytes[0], 128] } else { vec![0, bytes[0]] };
                bytes[same..]
                    .chunks(128)
                    .for_each(|piece| packed.extend([&[piece.len() as u8 - 1], piece].concat()));
                packed
            }
            _ => bytes.to_vec(),
        }
    }

    fn strips(&self) -> Vec<Vec<u8>> {
        let (rows, columns) = (self.chunk.0, self.chunk.1.unwrap_or(self.size.1));
        let planes: Vec<Vec<usize>> = if self.is_planar {
            (0..self.samples).map(|one| vec![one]).collect()
        } else {
            vec![(0..self.samples).collect()]
        };
        let mut strips = Vec::new();
        for channels in &planes {
            for top in (0..self.size.0).step_by(rows) {
                for left in (0..self.size.1).step_by(columns) {
                    let bottom =
                        if self.chunk.1.is_some() { top + rows } else { self.size.0.min(top + rows) };
                    let code = |y, x, channel| self.code(self.value((y, x, channel)));
                    let row = |y| {
                        let pixels = (left..left + columns)
                            .flat_map(|x| channels.iter().map(move |&one| code(y, x, one)));
                        self.row(&pixels.collect::<Vec<_>>(), channels.len())
                    };
                    strips.push(self.pack(&(top..bottom).flat_map(row).collect::<Vec<u8>>()));
                }
            }
        }
        strips
    }

    /// The file, with more `tags`: code, type and values.
    fn file(&self, tags: &[(u16, u16, Vec<u64>)]) -> Vec<u8> {
        self.page(tags, 0, &self.strips())
    }

    /// A whole file whose first page lies after `gap` bytes.
    fn page(&self, more: &[(u16, u16, Vec<u64>)], gap: usize, strips: &[Vec<u8>]) -> Vec<u8> {
        let long = |tag, value: usize| (tag, 4, vec![value as u64]);
        let (offsets, lengths) = if self.chunk.1.is_some() { (324, 325) } else { (273, 279) };
        let mut tags = vec![
            long(256, self.size.1),
            long(257, self.size.0),
            (258, 3, vec![self.bits as u64; self.samples]),
            (259, 3, vec![self.compression]),
            (262, 3, vec![self.photometric]),
            (offsets, 4, vec![0; strips.len()]),
            long(277, self.samples),
            (lengths, 4, strips.iter().map(|strip| strip.len() as u64).collect()),
            (284, 3, vec![if self.is_planar { 2 } else { 1 }]),
            (317, 3, vec![self.predictor]),
            (339, 3, vec![if self.is_float { 3 } else { 1 }; self.samples]),
        ];
        match self.chunk {
            (rows, Some(columns)) => tags.extend([long(322, columns), long(323, rows)]),
            (rows, None) => tags.push(long(278, rows)),
        }
        tags.retain(|tag| more.iter().all(|other| other.0 != tag.0));
        tags.extend(more.iter().cloned());
        let start = self.directory(&tags, gap).len();
        let mut place = start as u64;
        let places = strips.iter().map(|strip| (place, place += strip.len() as u64).0).collect::<Vec<_>>();
        tags.iter_mut().filter(|tag| tag.0 == offsets).for_each(|tag| tag.2.clone_from(&places));
        [self.directory(&tags, gap), strips.concat()].concat()
    }

    fn directory(&self, tags: &[(u16, u16, Vec<u64>)], gap: usize) -> Vec<u8> {
        let size = if self.is_big { 8 } else { 4 };
        let mut file = if self.is_little { b"II".to_vec() } else { b"MM".to_vec() };
        file.extend(self.integer(if self.is_big { 43 } else { 42 }, 2));
        if self.is_big {
            file.extend([self.integer(8, 2), vec![0; 2]].concat());
        }
        file.extend(self.integer((file.len() + size + gap) as u64, size));
        file.extend(vec![0; gap]);
        file.extend(self.integer(tags.len() as u64, if self.is_big { 8 } else { 2 }));
        let mut values = Vec::new();
        let after = file.len() + tags.len() * (4 + 2 * size) + size;
        for (tag, kind, numbers) in tags {
            let each = match kind {
                3 => 2,
                4 => 4,
                16 => 8,
                _ => 1,
            };
            let mut bytes: Vec<u8> = numbers.iter().flat_map(|&number| self.integer(number, each)).collect();
            file.extend([self.integer((*tag).into(), 2), self.integer((*kind).into(), 2)].concat());
            file.extend(self.integer(numbers.len() as u64, size));
            if bytes.len() > size {
                let place = self.integer((after + values.len()) as u64, size);
                values.extend(std::mem::replace(&mut bytes, place));
            }
            bytes.resize(size, 0);
            file.extend(bytes);
        }
        file.extend(self.integer(0, size));
        [file, values].concat()
    }

    fn truth(&self) -> Samples {
        let shape = (self.size.0, self.size.1, self.samples);
        let value = |place| self.value(place);
        let scaled = |place, most: u64| value(place) * most / ((1 << self.bits) - 1);
        match (self.is_float, self.bits) {
            (true, 16) => {
                Samples::Halves(Array3::from_shape_fn(shape, |place| f16::from_f64(value(place) as f64)))
            }
            (true, _) => Samples::Floats(Array3::from_shape_fn(shape, |place| value(place) as f32)),
            (false, ..=8) => Samples::Bytes(Array3::from_shape_fn(shape, |place| scaled(place, 0xFF) as u8)),
            (false, _) => Samples::Words(Array3::from_shape_fn(shape, |place| scaled(place, 0xFFFF) as u16)),
        }
    }
}

fn read(file: Vec<u8>) -> Result<Samples> {
    let tiff = open(file, 1 << 20)?;
    let header = &tiff.parts()[0];
    tiff.samples(0, &(0..header.channels.len()).collect::<Vec<_>>(), 0..header.height)
}

fn reason(file: Vec<u8>) -> String {
    read(file).expect_err("it is refused").to_string()
}

/// All types, compressions, predictors, orders of bytes, strips and tiles.
fn examples() -> Vec<Example> {
    let mut all = Vec::new();
    for (is_float, bits) in [1, 2, 4, 6, 8, 10, 12, 14, 16]
        .map(|bits| (false, bits))
        .into_iter()
        .chain([16, 32, 64].map(|bits| (true, bits)))
    {
        for (compression, predictors) in [(1, 1..2), (5, 1..4), (8, 1..4), (32946, 1..2), (32773, 1..2)] {
            let can = |predictor: &u64| {
                *predictor == 1 || *predictor == 2 && bits % 8 == 0 || *predictor == 3 && is_float
            };
            for predictor in predictors.filter(can) {
                for way in 0..8 {
                    let chunk = [(3, None), (1, None), (7, None), (16, Some(4))][way % 4];
                    let (is_little, is_big, is_planar) =
                        (way < 4, (way + bits) % 3 == 0, (way + bits / 2) % 2 == 0);
                    let samples = 1 + (way + bits + predictor as usize) % 5;
                    let photometric = if samples < 3 { 1 } else { 2 };
                    let size = if way % 2 == 0 { (7, 9) } else { (5, 6) };
                    all.push(Example {
                        is_little,
                        is_big,
                        size,
                        samples,
                        bits,
                        is_float,
                        compression,
                        predictor,
                        is_planar,
                        chunk,
                        photometric,
                    });
                }
            }
        }
    }
    all
}

#[test]
fn all_kinds_of_samples_strips_and_tiles_are_read() {
    for example in examples() {
        let tiff = open(example.file(&[]), 1 << 20).expect("a whole file");
        let channels: Vec<usize> = (0..example.samples).collect();
        let whole = tiff.samples(0, &channels, 0..example.size.0).expect("whole samples");
        assert_eq!(whole, example.truth(), "{example:?}");
        let last = tiff.samples(0, &[example.samples - 1], 2..4).expect("some samples");
        let part = |all: &Array3<f32>| all.slice(s![2..4, .., -1..]).to_owned();
        if let (Samples::Floats(whole), Samples::Floats(last)) = (&whole, &last) {
            assert_eq!(last, part(whole), "{example:?}");
        }
        if let (Samples::Bytes(whole), Samples::Bytes(last)) = (&whole, &last) {
            assert_eq!(last, whole.slice(s![2..4, .., -1..]), "{example:?}");
        }
    }
}

/// A cut or changed file is read or refused. A cut of the samples is refused.
#[test]
fn damaged_files_are_refused_without_a_panic() {
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for example in examples().into_iter().step_by(7) {
        let file = example.file(&[]);
        for length in (0..file.len()).step_by(7) {
            assert!(read(file[..length].to_vec()).is_err(), "{length} {example:?}");
        }
        for _ in 0..300 {
            let mut changed = file.clone();
            for _ in 0..=random(3) {
                let place = random(changed.len());
                changed[place] = [0, 1, 255, random(256) as u8][random(4)];
            }
            let _ = read(changed);
        }
    }
}

#[test]
fn palettes_and_inverted_grey_become_colours() {
    let example = Example { samples: 1, bits: 4, ..EXAMPLE };
    let palette: Vec<u64> = (0..48).map(|number| number * 1285).collect();
    let codes = Example { photometric: 1, bits: 8, ..example };
    let file = Example { photometric: 3, ..example }.file(&[(320, 3, palette.clone())]);
    let expected = Array3::from_shape_fn((7, 9, 3), |(y, x, channel)| {
        ((example.value((y, x, 0)) + 16 * channel as u64) * 1285 / 257) as u8
    });
    assert_eq!(read(file).expect("a palette"), Samples::Bytes(expected));
    assert!(reason(Example { photometric: 3, ..example }.file(&[])).contains("it has no palette"));
    let with_alpha = Example { photometric: 3, samples: 2, ..example }.file(&[(320, 3, palette)]);
    assert!(reason(with_alpha).contains("its palette has 2 channels"));
    for bits in [8, 16] {
        let grey = Example { photometric: 0, bits, ..codes };
        match (read(grey.file(&[])).expect("grey"), grey.truth()) {
            (Samples::Bytes(found), Samples::Bytes(codes)) => {
                assert_eq!(found, codes.mapv(|code| 255 - code));
            }
            (Samples::Words(found), Samples::Words(codes)) => {
                assert_eq!(found, codes.mapv(|code| 65535 - code));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn extra_samples_name_the_channels_and_alpha() {
    let of = |samples: usize, photometric, extra: &[u64]| {
        let tags: Vec<_> = (!extra.is_empty()).then(|| (338, 3, extra.to_vec())).into_iter().collect();
        let tiff = open(Example { samples, photometric, ..EXAMPLE }.file(&tags), 1 << 20).expect("whole");
        let header = &tiff.parts()[0];
        let names: Vec<&str> = header.channels.iter().map(|channel| channel.name.as_str()).collect();
        (names.join(" "), header.alpha)
    };
    for (samples, photometric, extra, names, alpha) in [
        (1, 1, &[][..], "Y", Alpha::None),
        (2, 1, &[], "R G", Alpha::None),
        (2, 1, &[2], "Y A", Alpha::Straight),
        (2, 1, &[1], "Y A", Alpha::Premultiplied),
        (3, 2, &[], "R G B", Alpha::None),
        (4, 2, &[], "R G B A", Alpha::Premultiplied),
        (4, 2, &[2], "R G B A", Alpha::Straight),
        (4, 2, &[0], "R G B channel3", Alpha::None),
        (5, 2, &[0, 1], "R G B channel3 A", Alpha::Premultiplied),
        (5, 2, &[], "R G B A channel4", Alpha::Premultiplied),
    ] {
        assert_eq!(of(samples, photometric, extra), (names.to_string(), alpha), "{samples} {extra:?}");
    }
}

#[test]
fn statements_are_read_and_limited() {
    let text = |tag, text: &str| (tag, 2, text.bytes().chain([0]).map(u64::from).collect::<Vec<_>>());
    let bytes = |tag, length: usize| (tag, 7, vec![65; length]);
    let said = [
        text(270, "a map"),
        (274, 3, vec![6]),
        bytes(700, 9),
        text(33302, "CubeFace Environment"),
        bytes(34675, 5),
    ];
    let tiff = open(EXAMPLE.file(&said), 1 << 20).expect("whole");
    let header = &tiff.parts()[0];
    assert_eq!((header.description.as_str(), header.orientation, header.environment), ("a map", 6, "cube"));
    assert_eq!((header.xmp[0].len(), header.colour.icc.len(), header.exif["Orientation"]), (9, 5, 6.0));
    let tiff = open(EXAMPLE.file(&[bytes(700, (4 << 20) + 1), (274, 3, vec![9])]), 1 << 20).expect("whole");
    assert_eq!((tiff.parts()[0].xmp[0].len(), tiff.parts()[0].orientation), (0, 1));
}

/// Two pages; the first is linked to the second.
fn two_pages(first: &[(u16, u16, Vec<u64>)], second: &[(u16, u16, Vec<u64>)]) -> Vec<u8> {
    let mut file = EXAMPLE.file(first);
    let gap = file.len() - 8;
    let page = Example { samples: 1, photometric: 1, ..EXAMPLE };
    let next = page.page(second, gap, &page.strips());
    let link = 8 + 2 + 12 * usize::from(file[8]);
    file[link..link + 4].copy_from_slice(&(gap as u32 + 8).to_le_bytes());
    file.extend(&next[gap + 8..]);
    file
}

#[test]
fn reduced_copies_masks_and_damaged_pages_are_left_out() {
    let channels = |file: Vec<u8>| {
        let tiff = open(file, 1 << 20).expect("whole");
        let counts: Vec<usize> = tiff.parts().iter().map(|header| header.channels.len()).collect();
        (counts, tiff.parts()[0].notes.join(" "))
    };
    let kind = |kind| [(254, 4, vec![kind])];
    assert_eq!(channels(two_pages(&[], &[])), (vec![3, 1], String::new()));
    assert_eq!(channels(two_pages(&kind(1), &[])), (vec![1], String::new()));
    assert_eq!(channels(two_pages(&[], &kind(4))), (vec![3], String::new()));
    let older = |kind| [(255, 3, vec![kind])];
    assert_eq!(channels(two_pages(&older(2), &older(1))), (vec![1], String::new()));
    let (counts, notes) = channels(two_pages(&kind(1), &older(2)));
    assert_eq!(counts, [3, 1]);
    assert!(notes.contains("by its tags the picture is a reduced copy or a mask"), "{notes}");
    assert_eq!(channels(two_pages(&[(33302, 2, vec![65, 0])], &[])), (vec![3], String::new()));
    let (counts, notes) = channels(two_pages(&[], &[(259, 3, vec![7])]));
    assert_eq!(counts, [3]);
    assert!(notes.contains("page 1 was left out: its samples are compressed by JPEG"), "{notes}");
    // A page that follows itself, and a long text that both pages claim.
    let mut file = EXAMPLE.file(&[]);
    let link = 8 + 2 + 12 * usize::from(file[8]);
    file[link..link + 4].copy_from_slice(&8_u32.to_le_bytes());
    assert_eq!(channels(file).0, [3]);
}

#[test]
fn other_kinds_are_refused_in_a_sentence() {
    for (tag, value, sentence) in [
        (262, 5, "CMYK colour (photometric 5); give RGB"),
        (262, 32845, "its samples are LogLuv colour (photometric 32845); give RGB"),
        (259, 7, "compressed by JPEG (compression 7)"),
        (259, 4, "CCITT fax"),
        (266, 2, "FillOrder 2"),
        (32997, 3, "it is a volume of 3 slices; give a flat image"),
        (277, 300, "it has 300 channels"),
        (339, 2, "its samples are int8; give floating point, uint8 or uint16"),
        (258, 32, "its samples are uint; give floating point, uint8 or uint16"),
        (256, 1 << 20, "an image may have up to"),
        (257, 300, "has 3 strips or tiles of 100"),
    ] {
        let said = reason(EXAMPLE.file(&[(tag, 4, vec![value])]));
        assert!(said.contains(sentence), "{said}");
    }
    assert!(reason(EXAMPLE.file(&[(258, 3, vec![8, 8, 16])])).contains("different bits"));
    let outside = Example { compression: 8, ..EXAMPLE }.file(&[(279, 4, vec![u64::from(u32::MAX); 3])]);
    assert!(reason(outside).contains("a strip or tile lies outside of it"));
}

/// A deflate stream of more than a strip, a changed checksum, and a claim that the file is too short for.
#[test]
fn a_strip_unpacks_to_its_size_only() {
    let example = Example { compression: 8, ..EXAMPLE };
    let mut strips = example.strips();
    strips[1] = example.pack(&vec![0; 1 << 20]);
    assert!(reason(example.page(&[], 0, &strips)).contains("does not unpack to its size"));
    strips = example.strips();
    *strips[1].last_mut().expect("a checksum") ^= 1;
    assert!(reason(example.page(&[], 0, &strips)).contains("does not unpack to its size"));
    let huge = [(256, 4, vec![1000]), (257, 4, vec![1000]), (278, 4, vec![1000])];
    assert!(reason(EXAMPLE.file(&huge)).contains("too short"));
    let tile = Example { chunk: (16, Some(16)), ..EXAMPLE }.file(&[(322, 4, vec![1 << 20])]);
    assert!(reason(tile).contains("strips or tiles of 16 rows of 1048576"));
}

#[test]
fn what_is_written_is_read() {
    for size in [(1, 1, 3), (33, 5, 3), (64, 128, 3)] {
        let samples = Array3::from_shape_fn(size, |(y, x, channel)| (y * 7 + x * channel) as f32 / 3.0 - 1.0);
        let file = write::encode(samples.view(), "a map\nof two lines");
        assert_eq!(file, write::encode(samples.view(), "a map\nof two lines"));
        assert_eq!(open(file.clone(), 1 << 20).expect("whole").parts()[0].description, "a map\nof two lines");
        assert_eq!(read(file).expect("whole"), Samples::Floats(samples));
    }
}
