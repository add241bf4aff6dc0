//! Any bytes are an image or a refusal: no panic, no hang, no sample below 0, no row that differs from the whole.

#![no_main]

use envlights::formats::Rows;
use envlights::formats::png::{self, Samples};
use envlights::formats::radiance::{Radiance, write};
use libfuzzer_sys::fuzz_target;
use ndarray::{Array3, s};

const MOST_PIXELS: usize = 1 << 16;
/// Least sample that has all bits in a Radiance file.
const LEAST_NORMAL: f32 = 1e-35;

fuzz_target!(
    init: {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        pool.build_global().expect("the first pool");
    },
    |bytes: &[u8]| {
        radiance(bytes);
        picture(bytes);
    }
);

/// A picture that opens can be read, as a whole and by rows, and is the same after it is written.
fn radiance(bytes: &[u8]) {
    let Ok(picture) = Radiance::open(bytes, MOST_PIXELS) else { return };
    let (height, width) = picture.size();
    let samples = picture.samples(0..height).expect("its lines were checked");
    assert!(samples.iter().all(|sample| sample.is_finite() && *sample >= 0.0));
    let row = bytes.len() % height;
    let alone = picture.samples(row..row + 1).expect("its lines were checked");
    assert_eq!(alone, samples.slice(s![row..=row, .., ..]));
    let mut file = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    file.extend(write::encode(samples.view(), true));
    let again = Radiance::open(file, MOST_PIXELS).expect("a whole file").samples(0..height).expect("memory");
    assert_same(&samples, &again);
}

/// Equal pixels, but for those that are too dark for all bits.
fn assert_same(samples: &Array3<f32>, again: &Array3<f32>) {
    for (pixel, other) in samples.lanes(ndarray::Axis(2)).into_iter().zip(again.lanes(ndarray::Axis(2))) {
        if pixel.iter().any(|&sample| sample > LEAST_NORMAL) {
            assert_eq!(pixel, other);
        }
    }
}

/// A header has the size of its samples, and samples need a header.
fn picture(bytes: &[u8]) {
    let header = png::header(bytes, MOST_PIXELS);
    let Ok(samples) = png::samples(bytes, MOST_PIXELS) else { return };
    let header = header.expect("the samples were read");
    let size = (header.height, header.width, header.channels);
    assert!((1..=4).contains(&header.channels) && (1..=8).contains(&header.orientation));
    match samples {
        Samples::Eight(samples) => assert!(samples.dim() == size && !header.is_16_bit),
        Samples::Sixteen(samples) => assert!(samples.dim() == size && header.is_16_bit),
    }
}
