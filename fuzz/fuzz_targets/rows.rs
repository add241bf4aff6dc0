//! Rows that arrive in order are reduced to the bits of the whole array, or both are refused.

#![no_main]

use envlights::kernels::image::{Cleaning, ReductionOptions, RowReducer, Sample, reduce, unusable};
use envlights::kernels::sphere::Registration;
use libfuzzer_sys::fuzz_target;
use ndarray::{Array3, ArrayView3, s};

fuzz_target!(
    init: {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
        pool.build_global().expect("the first pool");
    },
    |bytes: &[u8]| {
        if let Some((&[columns, share, flags, blocks, width], data)) = bytes.split_first_chunk() {
            let width = usize::from(width).max(1);
            let case = Case { columns, share, flags, blocks };
            match flags >> 7 {
                0 => case.reduce_codes(&rectangle(data, width)),
                _ => case.reduce_floats(&rectangle(&floats(data), width)),
            }
        }
    }
);

/// Options of a reduction, one byte each.
struct Case {
    columns: u8,
    share: u8,
    flags: u8,
    blocks: u8,
}

impl Case {
    /// Codes whose values grow like a power, so that a lamp may have nearly all of the flux.
    fn reduce_codes<Code: Sample>(&self, codes: &Array3<Code>) {
        let power = 1 + i32::from(self.share % 16);
        let value = |code: usize| (code as f32 / (Code::CODES - 1) as f32).powi(power) * 1e4;
        let table: Vec<f32> = (0..Code::CODES).map(value).collect();
        let values = codes.map(|code| table[code.code()]);
        self.compare(codes, &table, values.view());
    }

    /// Values, which are cleaned as in the whole array.
    fn reduce_floats(&self, values: &Array3<f32>) {
        let mut usable = values.map(|&value| if value <= 0.0 { 0.0 } else { value });
        if let Ok(counts) = unusable(values.view())
            && let Ok(mut cleaning) = Cleaning::of(counts)
        {
            cleaning.apply(values.view(), true, usable.view_mut()).expect("three channels");
        }
        self.compare(values, &[], usable.view());
    }

    fn compare<T: Sample>(&self, samples: &Array3<T>, table: &[f32], values: ArrayView3<'_, f32>) {
        let options = self.options(values);
        let ReductionOptions { registration, columns, source_fraction, has_floor, .. } = options;
        let whole = reduce(values, registration, columns, source_fraction, has_floor);
        let Ok(mut reducer) = RowReducer::new(options, table.to_vec()) else {
            assert!(whole.is_err(), "only the whole array is a map");
            return;
        };
        let step = reducer.block() * (1 + usize::from(self.blocks % 8));
        for top in (0..options.height).step_by(step) {
            let rows = samples.slice(s![top..(top + step).min(options.height), .., ..]);
            let rows = rows.as_slice().expect("whole rows");
            let integrals = reducer.integrals(rows).expect("whole rows of blocks");
            reducer.add(integrals, rows);
        }
        let Ok(reduction) = reducer.finish() else {
            assert!(samples.is_empty() || whole.is_err(), "a finite sample is enough");
            return;
        };
        assert_eq!(format!("{:?}", reduction.map), format!("{:?}", whole.expect("cleaned samples")));
        check_counts(&reducer, table);
    }

    fn options(&self, values: ArrayView3<'_, f32>) -> ReductionOptions {
        let (height, width, _) = values.dim();
        let registration =
            if self.flags & 1 == 0 { Registration::CellCentred } else { Registration::BorderSampled };
        ReductionOptions {
            height,
            width,
            registration,
            columns: usize::from(self.columns).max(1),
            source_fraction: 1e-4 + f64::from(self.share) / 256.0,
            has_floor: self.flags & 2 != 0,
        }
    }
}

/// The histogram covers the sphere, and clipped pixels are a fraction of it.
fn check_counts<T: Sample>(reducer: &RowReducer<T>, table: &[f32]) {
    let sphere: f64 = reducer.histogram().iter().sum();
    assert!((sphere / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "the histogram covers {sphere}");
    if let Some([sphere, flux]) = table.last().and_then(|&white| reducer.clipped(white)) {
        assert!((0.0..1.0 + 1e-9).contains(&sphere) && (0.0..1.0 + 1e-5).contains(&flux), "{sphere} {flux}");
    }
}

/// Rows of `width` pixels, as many as there are samples for.
fn rectangle<T: Copy>(samples: &[T], width: usize) -> Array3<T> {
    let height = samples.len() / (3 * width);
    let samples = samples[..3 * width * height].to_vec();
    Array3::from_shape_vec((height, width, 3), samples).expect("whole rows")
}

/// Each number of 16 bits as the upper bits of a float: infinity, NaN and minus signs among them.
fn floats(bytes: &[u8]) -> Vec<f32> {
    let upper = |&pair: &[u8; 2]| f32::from_bits(u32::from(u16::from_be_bytes(pair)) << 16);
    bytes.as_chunks().0.iter().map(upper).collect()
}
