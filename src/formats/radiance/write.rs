//! Encoder of Radiance pixels: RGBE with run-length encoded rows.

use ndarray::{ArrayView1, ArrayView2, ArrayView3, Axis};
use rayon::prelude::*;

use super::lines::PLANAR_WIDTHS;
use crate::interrupt;

/// Length from which equal bytes are shorter as a run.
const LEAST_RUN: usize = 4;
/// Most bytes in a run, and in bytes that are not a run.
const MOST: (usize, usize) = (127, 128);

/// Bytes of some rows, (rows, width, 3), after the header.
///
/// Samples are finite, at least 0 and below 255.5 * 2^119. Mantissas are rounded to nearest if `rounds`, else down: the
/// programs of Radiance add half a step when they read.
pub fn encode(radiance: ArrayView3<'_, f32>, rounds: bool) -> Vec<u8> {
    let half = if rounds { 0.5 } else { 0.0 };
    let rows: Vec<Vec<u8>> =
        radiance.axis_iter(Axis(0)).into_par_iter().map(|row| encode_row(row, half)).collect();
    rows.concat()
}

fn encode_row(row: ArrayView2<'_, f32>, half: f64) -> Vec<u8> {
    interrupt::check();
    let pixels: Vec<[u8; 4]> = row.outer_iter().map(|rgb| rgbe(rgb, half)).collect();
    let width = pixels.len();
    if !PLANAR_WIDTHS.contains(&width) {
        return pixels.concat();
    }
    let mut bytes = vec![2, 2, (width >> 8) as u8, (width & 0xff) as u8];
    for channel in 0..4 {
        let plane: Vec<u8> = pixels.iter().map(|pixel| pixel[channel]).collect();
        push_runs(&mut bytes, &plane);
    }
    bytes
}

/// Mantissas, rounded down after `half` is added, and the shared exponent of the largest channel.
fn rgbe(rgb: ArrayView1<'_, f32>, half: f64) -> [u8; 4] {
    let largest = rgb.iter().copied().fold(0.0, f32::max);
    let mut exponent = ((largest.to_bits() >> 23) & 0xff) as i32 - 126;
    let mantissa = |sample: f32, exponent: i32| (f64::from(sample) * 2_f64.powi(8 - exponent) + half).floor();
    if mantissa(largest, exponent) > 255.0 {
        exponent += 1;
    }
    let shared = exponent + 128;
    // Numbers below 2^-127 have fewer bits. As in Radiance they are black: mantissas of 1, 1, 1 mean a run in narrow rows.
    if shared < 1 || mantissa(largest, exponent) < 128.0 {
        return [0; 4];
    }
    let byte = |channel: usize| mantissa(rgb[channel], exponent) as u8;
    [byte(0), byte(1), byte(2), shared.min(255) as u8]
}

/// Append one channel of a row, runs of equal bytes and the bytes between them.
fn push_runs(bytes: &mut Vec<u8>, plane: &[u8]) {
    let mut start = 0;
    while start < plane.len() {
        let (before, run) = next_run(&plane[start..]);
        for part in plane[start..start + before].chunks(MOST.1) {
            bytes.push(part.len() as u8);
            bytes.extend_from_slice(part);
        }
        if run > 0 {
            bytes.extend([(MOST.1 + run) as u8, plane[start + before]]);
        }
        start += before + run;
    }
}

/// Number of bytes before the next run, and its length; 0 if there is none.
fn next_run(plane: &[u8]) -> (usize, usize) {
    let mut start = 0;
    while start < plane.len() {
        let equal = |byte: &&u8| **byte == plane[start];
        let run = plane[start..].iter().take(MOST.0).take_while(equal).count();
        if run >= LEAST_RUN {
            return (start, run);
        }
        start += run;
    }
    (plane.len(), 0)
}

#[cfg(test)]
mod tests {
    use ndarray::{Array3, arr1};

    use super::*;

    #[test]
    fn mantissas_are_rounded_and_carry_into_the_exponent() {
        assert_eq!(rgbe(arr1(&[1.0, 0.5, 0.25]).view(), 0.5), [128, 64, 32, 129]);
        assert_eq!(rgbe(arr1(&[0.999, 0.0, 0.1]).view(), 0.5), [128, 0, 13, 129]);
        assert_eq!(rgbe(arr1(&[129.6 / 128.0, 0.0, 0.0]).view(), 0.5), [130, 0, 0, 129]);
        assert_eq!(rgbe(arr1(&[0.0; 3]).view(), 0.5), [0; 4]);
        assert_eq!(rgbe(arr1(&[1.6e38, 0.0, 0.0]).view(), 0.5)[3], 255);
    }

    #[test]
    fn pixels_too_dark_for_all_bits_are_black_and_no_runs() {
        for bits in [1, 0x8000, 0xc000, 0x0001_8000, 0x003f_8000] {
            assert_eq!(rgbe(arr1(&[f32::from_bits(bits); 3]).view(), 0.5), [0; 4], "{bits:x}");
        }
        assert_eq!(rgbe(arr1(&[f32::from_bits(0x0040_0000); 3]).view(), 0.5), [128, 128, 128, 2]);
    }

    #[test]
    fn runs_and_other_bytes_come_back() {
        for plane in [
            vec![7; 300],
            (0..=255).collect(),
            [vec![1, 2, 2, 3], vec![5; 130], vec![6, 6, 6]].concat(),
            (0..400).map(|i| (i / 5 % 3) as u8).collect(),
        ] {
            let mut bytes = Vec::new();
            push_runs(&mut bytes, &plane);
            let (mut back, mut at) = (Vec::new(), 0);
            while at < bytes.len() {
                let count = usize::from(bytes[at]);
                if count > 128 {
                    back.extend(vec![bytes[at + 1]; count - 128]);
                    at += 2;
                } else {
                    back.extend_from_slice(&bytes[at + 1..=at + count]);
                    at += 1 + count;
                }
            }
            assert_eq!(back, plane);
        }
    }

    #[test]
    fn narrow_rows_are_not_encoded() {
        assert_eq!(encode(Array3::ones((2, 4, 3)).view(), true).len(), 2 * 4 * 4);
        assert!(encode(Array3::ones((2, 800, 3)).view(), true).len() < 200);
    }
}
