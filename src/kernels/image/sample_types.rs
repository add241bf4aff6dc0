//! Samples in the type of a file, and their linear values.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// A sample as a file stores it: a code with a table of values, or the value itself.
pub trait Sample: Copy + PartialOrd + Send + Sync {
    /// Linear value of each code.
    type Table: Send + Sync;

    /// Number of codes; 0 for values.
    const CODES: usize;

    /// Least code that may belong to a clipped region: 214 of 255, below all clip levels; none for values.
    const TOP: Option<Self>;

    /// Number of the code.
    fn code(self) -> usize;

    /// Nearest code of 8 bits to a code of this type.
    #[inline]
    fn as_8_bits(code: usize) -> usize {
        let largest = Self::CODES.saturating_sub(1).max(1);
        (code * 255 + largest / 2) / largest
    }

    /// The table of these `values`; none if their number is not that of all codes.
    fn table(values: Vec<f32>) -> Option<Box<Self::Table>>;

    /// Linear values of some samples, in `buffer` unless they are the samples themselves.
    fn linear<'a>(samples: &'a [Self], table: &Self::Table, buffer: &'a mut Vec<f32>) -> &'a [f32];

    /// The first code with at least this linear `value`; none if values do not grow with codes.
    fn first_at_least(table: &Self::Table, value: f32) -> Option<Self>;
}

/// The larger one of two samples.
#[inline]
pub fn larger<T: Sample>(one: T, other: T) -> T {
    if one > other { one } else { other }
}

/// Codes of one integer type.
macro_rules! codes {
    ($code:ty, $count:literal, $top:literal) => {
        impl Sample for $code {
            type Table = [f32; $count];
            const CODES: usize = $count;
            const TOP: Option<Self> = Some($top);

            #[inline]
            fn code(self) -> usize {
                usize::from(self)
            }

            fn table(values: Vec<f32>) -> Option<Box<Self::Table>> {
                values.into_boxed_slice().try_into().ok()
            }

            fn linear<'a>(samples: &'a [Self], table: &Self::Table, buffer: &'a mut Vec<f32>) -> &'a [f32] {
                buffer.resize(samples.len(), 0.0);
                for (value, &code) in buffer.iter_mut().zip(samples) {
                    *value = table[usize::from(code)];
                }
                buffer
            }

            fn first_at_least(table: &Self::Table, value: f32) -> Option<Self> {
                let first = table.partition_point(|&one| one < value).min(table.len() - 1);
                if table.is_sorted() { Self::try_from(first).ok() } else { None }
            }
        }
    };
}

codes!(u8, 256, 214);
codes!(u16, 65536, 54870);

/// Values of one floating point type; `$linear` gives single precision.
macro_rules! values {
    ($value:ty, $linear:expr) => {
        impl Sample for $value {
            type Table = ();
            const CODES: usize = 0;
            const TOP: Option<Self> = None;

            #[inline]
            fn code(self) -> usize {
                0
            }

            fn table(values: Vec<f32>) -> Option<Box<()>> {
                values.is_empty().then(Box::default)
            }

            fn linear<'a>(samples: &'a [Self], (): &(), buffer: &'a mut Vec<f32>) -> &'a [f32] {
                $linear(samples, buffer)
            }

            fn first_at_least((): &(), _: f32) -> Option<Self> {
                None
            }
        }
    };
}

values!(f32, |samples: &'a [f32], _: &'a mut Vec<f32>| samples);
values!(f16, |samples: &'a [f16], buffer: &'a mut Vec<f32>| {
    buffer.resize(samples.len(), 0.0);
    samples.convert_to_f32_slice(buffer);
    buffer
});
