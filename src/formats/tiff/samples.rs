//! Samples from the bytes of a row: few bits scaled, palettes looked up, doubles rounded to floats.

use half::f16;

use super::page::{Form, Page};

/// Type of the samples that readers get.
pub trait Sample: Copy + Default + Send + Sync {
    /// Append the samples of a row of `page` to `out`.
    fn append(page: &Page, is_little_endian: bool, row: &[u8], out: &mut Vec<Self>);

    /// Sample of a page whose 0 is white.
    fn complement(self) -> Self {
        self
    }
}

impl Sample for u8 {
    fn append(page: &Page, _: bool, row: &[u8], out: &mut Vec<Self>) {
        match &page.form {
            Form::Palette(colours) => {
                out.extend(codes(row, page.bits).flat_map(|code| colours[code as usize]));
            }
            _ if page.bits == 8 => out.extend(row),
            _ => out.extend(codes(row, page.bits).map(|code| (code * 0xFF / highest(page.bits)) as u8)),
        }
    }

    fn complement(self) -> Self {
        !self
    }
}

impl Sample for u16 {
    fn append(page: &Page, is_little_endian: bool, row: &[u8], out: &mut Vec<Self>) {
        if page.bits == 16 {
            numbers(row, is_little_endian, out, u16::from_le_bytes);
        } else {
            out.extend(codes(row, page.bits).map(|code| (code * 0xFFFF / highest(page.bits)) as u16));
        }
    }

    fn complement(self) -> Self {
        !self
    }
}

impl Sample for f16 {
    fn append(_: &Page, is_little_endian: bool, row: &[u8], out: &mut Vec<Self>) {
        numbers(row, is_little_endian, out, f16::from_le_bytes);
    }
}

impl Sample for f32 {
    fn append(page: &Page, is_little_endian: bool, row: &[u8], out: &mut Vec<Self>) {
        if page.bits == 64 {
            numbers(row, is_little_endian, out, |bytes| f64::from_le_bytes(bytes) as f32);
        } else {
            numbers(row, is_little_endian, out, f32::from_le_bytes);
        }
    }
}

/// Append the numbers of a row, each of `SIZE` bytes.
fn numbers<T, const SIZE: usize>(
    row: &[u8],
    is_little_endian: bool,
    out: &mut Vec<T>,
    number: impl Fn([u8; SIZE]) -> T,
) {
    let bytes = row.as_chunks::<SIZE>().0;
    if is_little_endian {
        out.extend(bytes.iter().map(|&one| number(one)));
    } else {
        out.extend(bytes.iter().map(|&one| number(std::array::from_fn(|byte| one[SIZE - 1 - byte]))));
    }
}

/// Integers of up to 14 bits, the highest bit first; the last bits of the row may fill its last byte.
fn codes(row: &[u8], bits: usize) -> impl Iterator<Item = u32> {
    (0..row.len() * 8 / bits).map(move |number| {
        let (first, last) = (number * bits, (number + 1) * bits - 1);
        let bytes = row[first / 8..=last / 8].iter().fold(0, |all, &byte| all << 8 | u32::from(byte));
        bytes >> (7 - last % 8) & highest(bits)
    })
}

/// Largest integer of some bits.
fn highest(bits: usize) -> u32 {
    (1 << bits) - 1
}
