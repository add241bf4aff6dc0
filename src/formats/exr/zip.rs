//! Blocks of ZIP: differences of bytes, deflated, the even bytes of the samples in front of the odd ones.

use zune_inflate::{DeflateDecoder, DeflateOptions};

/// The `length` bytes of a block, still in two halves; None if they are damaged.
pub fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    let options = DeflateOptions::default().set_limit(length).set_size_hint(length);
    let mut bytes = DeflateDecoder::new_with_options(packed, options).decode_zlib().ok()?;
    add_differences(&mut bytes);
    (bytes.len() == length).then_some(bytes)
}

/// Each byte but the first is the difference to the one before it, plus 128.
fn add_differences(bytes: &mut [u8]) {
    let mut sum = bytes.first().copied().unwrap_or_default();
    for byte in bytes.iter_mut().skip(1) {
        sum = sum.wrapping_add(*byte).wrapping_sub(128);
        *byte = sum;
    }
}
