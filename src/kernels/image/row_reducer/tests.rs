//! Tests of the reduction by rows.

use approx::assert_relative_eq;
use ndarray::{Array1, Array3};
use proptest::prelude::*;

use super::*;
use crate::kernels::image::white::code_histogram;
use crate::kernels::image::{reduce, unusable};
use crate::kernels::repair::clipped_fraction::clipped_fraction;

fn options(map: &Array3<f32>, registration: Registration, columns: usize) -> ReductionOptions {
    let (height, width, _) = map.dim();
    ReductionOptions { height, width, registration, columns, source_fraction: 5e-3, has_floor: false }
}

/// Reducer of all `samples`, a number of rows of `blocks` at a time.
fn reducer<T: Sample>(
    options: ReductionOptions,
    samples: &[T],
    table: &[f32],
    blocks: usize,
) -> RowReducer<T> {
    let mut reducer = RowReducer::new(options, table.to_vec()).unwrap();
    for rows in samples.chunks(3 * options.width * reducer.block() * blocks) {
        let integrals = reducer.integrals(rows).unwrap();
        reducer.add(integrals, rows);
    }
    reducer
}

/// All bits of a working map as text.
fn bits(map: Result<WorkingMap>) -> String {
    format!("{map:?}")
}

/// Bits of the reduction by rows.
fn of_rows<T: Sample>(reducer: &RowReducer<T>) -> String {
    bits(reducer.finish().map(|reduction| reduction.map))
}

fn of_array(map: &Array3<f32>, options: ReductionOptions) -> String {
    let ReductionOptions { registration, columns, source_fraction, has_floor, .. } = options;
    bits(reduce(map.view(), registration, columns, source_fraction, has_floor))
}

/// Codes of a dim map with lamps of all sizes anywhere: at the poles, the seam and in the last row as well.
fn codes() -> impl Strategy<Value = Array3<u8>> {
    let lamps = prop::collection::vec((0.0..1.0_f64, 0.0..1.0_f64, 1_usize..6, 100_u8..=255), 0..6);
    (2_usize..50, 2_usize..100, 0_u8..60, lamps, any::<bool>()).prop_map(
        |(height, width, level, lamps, is_dark_above)| {
            let mut map = Array3::from_shape_fn((height, width, 3), |(y, x, c)| {
                let is_black = is_dark_above && y < height / 2;
                if is_black { 0 } else { level + ((7 * y + 3 * x + c) % 11) as u8 }
            });
            for (down, across, side, code) in lamps {
                let (top, left) = ((down * height as f64) as usize, (across * width as f64) as usize);
                for y in top..(top + side).min(height) {
                    (0..side).for_each(|x| map[[y, (left + x) % width, x % 3]] = code);
                }
            }
            map
        },
    )
}

/// Values that grow as the 9th power, so that a lamp may have nearly all of the flux.
fn table(codes: usize) -> Vec<f32> {
    (0..codes).map(|code| (code as f32 / (codes - 1) as f32).powi(9) * 1e4).collect()
}

proptest! {
    #[test]
    fn rows_of_any_type_give_the_bits_of_the_array(
        codes in codes(), columns in 1_usize..60, blocks in 1_usize..5, share in 1e-4..0.5_f64,
        is_border in any::<bool>(), has_floor in any::<bool>(),
    ) {
        let registration = [Registration::CellCentred, Registration::BorderSampled][usize::from(is_border)];
        let (table_8, table_16) = (table(256), table(65536));
        let map = codes.map(|&code| table_8[usize::from(code)]);
        let options = ReductionOptions { source_fraction: share, has_floor, ..options(&map, registration, columns) };
        let expected = of_array(&map, options);
        prop_assert!(expected.starts_with("Ok"));
        let bytes = reducer(options, codes.as_slice().unwrap(), &table_8, blocks);
        prop_assert_eq!(&of_rows(&bytes), &expected);
        let floats = reducer(options, map.as_slice().unwrap(), &[], blocks);
        prop_assert_eq!(&of_rows(&floats), &expected);
        let words = codes.map(|&code| u16::from(code) * 257);
        let map = words.map(|&code| table_16[usize::from(code)]);
        let words = reducer(options, words.as_slice().unwrap(), &table_16, blocks);
        prop_assert_eq!(of_rows(&words), of_array(&map, options));
    }

    #[test]
    fn the_largest_codes_are_counted_as_in_the_whole_map(codes in codes(), is_border in any::<bool>()) {
        let registration = [Registration::CellCentred, Registration::BorderSampled][usize::from(is_border)];
        let table = table(256);
        let map = codes.map(|&code| table[usize::from(code)]);
        let reducer = reducer(options(&map, registration, 8), codes.as_slice().unwrap(), &table, 1);
        let white = table[250];
        let expected = clipped_fraction(map.view(), registration, Some(white)).unwrap();
        let [sphere, flux] = reducer.clipped((0.985 * f64::from(white)) as f32).unwrap();
        assert_relative_eq!(sphere, expected.sphere, max_relative = 1e-9, epsilon = 1e-12);
        assert_relative_eq!(flux, expected.flux, max_relative = 1e-5, epsilon = 1e-12);
        let weights = Array1::from(band_heights(&Registration::CellCentred.theta_edges(map.dim().0)));
        let all = code_histogram(codes.view(), weights.view());
        let column = std::f64::consts::TAU / map.dim().1 as f64;
        let histogram = reducer.histogram();
        assert_relative_eq!(histogram.iter().sum::<f64>(), 4.0 * std::f64::consts::PI, max_relative = 1e-9);
        if !is_border {
            for code in 214..256 {
                assert_relative_eq!(histogram[code], column * all[code], max_relative = 1e-9, epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn an_even_map_retains_an_eighth_of_its_pixels_at_most() {
    let map = Array3::from_elem((512, 1024, 3), 0.5_f32);
    let mut reducer = RowReducer::new(options(&map, Registration::CellCentred, 256), Vec::new()).unwrap();
    let mut most = 0;
    for rows in map.as_slice().unwrap().chunks(3 * 1024 * 32) {
        let integrals = reducer.integrals(rows).unwrap();
        reducer.add(integrals, rows);
        most = most.max(reducer.retained_bytes());
    }
    assert!((1..=map.len() * 4 / 8).contains(&most), "{most}");
    assert_eq!(reducer.retained_bytes(), 0);
}

#[test]
fn missing_rows_and_parts_of_blocks_give_no_map() {
    let map = Array3::from_elem((20, 40, 3), 0.5_f32);
    let options = options(&map, Registration::CellCentred, 10);
    let samples = map.as_slice().unwrap();
    let mut missing = RowReducer::new(options, Vec::new()).unwrap();
    assert!(missing.integrals(&samples[..3 * 40 * 3]).is_err(), "three of four rows of a block");
    assert!(missing.integrals(&samples[..3 * 40 * 4 + 3]).is_err(), "a part of a row");
    let rows = &samples[..3 * 40 * 8];
    let integrals = missing.integrals(rows).unwrap();
    missing.add(integrals, rows);
    assert!(missing.finish().is_err());
    assert!(missing.integrals(samples).is_err(), "more rows than the map has");
}

#[test]
fn samples_that_no_light_can_have_are_cleaned_as_in_the_whole_map() {
    let options = |map: &Array3<f32>| options(map, Registration::CellCentred, 10);
    let mut map = Array3::from_shape_fn((40, 80, 3), |(y, x, c)| ((7 * y + 3 * x + c) % 11) as f32);
    map[[13, 7, 1]] = f32::NAN;
    map[[16, 79, 0]] = -4.0;
    // A sun over the seam, over the edges of blocks and of additions.
    for (y, x) in (12..20).flat_map(|y| [78, 79, 0, 1].map(|x| (y, x))) {
        (0..3).for_each(|c| map[[y, x, c]] = f32::INFINITY);
    }
    map[[0, 3, 2]] = f32::INFINITY;
    map[[39, 3, 2]] = 65000.0;
    for blocks in 1..4 {
        let reducer = reducer(options(&map), map.as_slice().unwrap(), &[], blocks);
        let reduction = reducer.finish().unwrap();
        let unusable = unusable(map.view()).unwrap();
        let mut cleaning = Cleaning::of(unusable).unwrap();
        let mut cleaned = Array3::zeros(map.dim());
        cleaning.apply(map.view(), true, cleaned.view_mut()).unwrap();
        assert_eq!(reduction.cleaning, cleaning);
        assert_eq!(of_rows(&reducer), of_array(&cleaned, options(&map)));
        let clipped = clipped_fraction(cleaned.view(), Registration::CellCentred, Some(65504.0)).unwrap();
        assert_relative_eq!(reduction.clipped_flux, clipped.flux, max_relative = 1e-5);
    }
    let nothing = Array3::from_elem((4, 8, 3), f32::NAN);
    assert!(reducer(options(&nothing), nothing.as_slice().unwrap(), &[], 1).finish().is_err());
}

#[test]
fn negative_samples_count_as_0() {
    for value in [-1.0, f32::NEG_INFINITY] {
        let mut map = Array3::from_elem((20, 40, 3), 0.5_f32);
        map[[13, 7, 1]] = value;
        let options = options(&map, Registration::CellCentred, 10);
        let reducer = reducer(options, map.as_slice().unwrap(), &[], 2);
        assert_eq!(reducer.finish().unwrap().cleaning.unusable.negative, 1);
        map[[13, 7, 1]] = 0.0;
        assert_eq!(of_rows(&reducer), of_array(&map, options));
    }
}
