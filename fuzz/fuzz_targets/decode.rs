//! Any bytes are an image or a refusal: no panic, no hang, no row that differs from the whole.

#![no_main]

use envlights::formats::open;
use envlights::formats::picture::{PictureFile, Samples};
use envlights::formats::radiance::write;
use libfuzzer_sys::fuzz_target;
use ndarray::{Array3, s};

const MOST_PIXELS: usize = 1 << 16;
/// Least sample that has all bits in a Radiance file.
const LEAST_NORMAL: f32 = 1e-35;
/// Kinds of files by their first bytes.
const KINDS: [(&str, &[u8]); 6] = [
    ("radiance", b"#?"),
    ("openexr", b"\x76\x2f\x31\x01"),
    ("png", b"\x89PNG"),
    ("jpeg", b"\xff\xd8"),
    ("tiff", b"II"),
    ("tiff", b"MM"),
];

fuzz_target!(
    init: {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        pool.build_global().expect("the first pool");
    },
    |bytes: &[u8]| {
        let Some((kind, _)) = KINDS.iter().find(|(_, start)| bytes.starts_with(start)) else { return };
        let Ok(file) = open(kind, bytes.to_vec(), MOST_PIXELS) else { return };
        (0..file.parts().len()).for_each(|part| read(&*file, part, bytes.len()));
        if *kind == "radiance" {
            write_again(&*file);
        }
    }
);

/// A part that is read as a whole is the same row by row, and with its channels in another order.
fn read(file: &dyn PictureFile, part: usize, turn: usize) {
    let header = &file.parts()[part];
    assert!((1..=8).contains(&header.orientation) && header.height * header.width <= MOST_PIXELS);
    let channels: Vec<usize> = (0..header.channels.len()).collect();
    let Ok(whole) = file.samples(part, &channels, 0..header.height) else { return };
    let row = turn % header.height;
    let backwards: Vec<usize> = channels.iter().rev().copied().collect();
    let alone = file.samples(part, &backwards, row..row + 1).expect("the whole was read");
    assert_eq!(bits(&alone), bits(&whole).slice(s![row..=row, .., ..;-1]));
}

/// Bits of samples: NaN is equal to itself.
fn bits(samples: &Samples) -> Array3<u32> {
    match samples {
        Samples::Bytes(samples) => samples.mapv(u32::from),
        Samples::Words(samples) => samples.mapv(u32::from),
        Samples::Halves(samples) => samples.mapv(|sample| sample.to_bits().into()),
        Samples::Floats(samples) => samples.mapv(f32::to_bits),
    }
}

/// A Radiance picture is the same after it is written, and has no sample below 0.
fn write_again(file: &dyn PictureFile) {
    let (height, width) = (file.parts()[0].height, file.parts()[0].width);
    let samples = floats(file, height);
    assert!(samples.iter().all(|sample| sample.is_finite() && *sample >= 0.0));
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(write::encode(samples.view(), true));
    let again = open("radiance", bytes, MOST_PIXELS).expect("a whole file");
    assert_same(&samples, &floats(&*again, height));
}

fn floats(file: &dyn PictureFile, height: usize) -> Array3<f32> {
    let Ok(Samples::Floats(samples)) = file.samples(0, &[0, 1, 2], 0..height) else {
        panic!("lines were checked")
    };
    samples
}

/// Equal pixels, but for those that are too dark for all bits.
fn assert_same(samples: &Array3<f32>, again: &Array3<f32>) {
    for (pixel, other) in samples.lanes(ndarray::Axis(2)).into_iter().zip(again.lanes(ndarray::Axis(2))) {
        if pixel.iter().any(|&sample| sample > LEAST_NORMAL) {
            assert_eq!(pixel, other);
        }
    }
}
