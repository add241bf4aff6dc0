//! Decompression of a strip or tile, of known size.

use std::borrow::Cow;

use fdeflate::Decompressor;
use weezl::{BitOrder, LzwStatus, decode::Configuration};

use super::page::{Compression, MOST_RATIO, Page};
use crate::error::Result;
use crate::formats::input::{damage, zeros};
use crate::interrupt;

/// Bytes of the first `rows` of a strip or tile, from its `stored` bytes in the file.
///
/// # Errors
///
/// If they are damaged or have another size than the page states.
pub fn unpack<'a>(page: &Page, stored: &'a [u8], rows: usize) -> Result<Cow<'a, [u8]>> {
    let (wanted, whole) = (rows * page.row_bytes(), page.chunk_height * page.row_bytes());
    if page.compression == Compression::None {
        return Ok(Cow::Borrowed(stored));
    }
    if wanted > stored.len().saturating_mul(MOST_RATIO) {
        return Err(damage_of_strip());
    }
    // One more byte, so that deflate reaches its end and its checksum.
    let mut samples = zeros((page.chunk_height, page.row_bytes(), 1), whole + 1)?;
    let length = match page.compression {
        Compression::Deflate => inflate(stored, &mut samples),
        Compression::Lzw => lzw(stored, &mut samples),
        Compression::None | Compression::PackBits => pack_bits(stored, &mut samples),
    };
    if !length.is_some_and(|length| (wanted..=whole).contains(&length)) {
        return Err(damage_of_strip());
    }
    samples.truncate(wanted);
    Ok(Cow::Owned(samples))
}

fn damage_of_strip() -> crate::error::Error {
    damage("the TIFF file is damaged: a strip or tile does not unpack to its size")
}

/// Number of bytes, or None for a damaged stream; the checksum at its end counts.
fn inflate(mut stored: &[u8], out: &mut [u8]) -> Option<usize> {
    /// Bytes between two checks for an interruption.
    const AT_ONCE: usize = 1 << 18;
    let (mut stream, mut length) = (Decompressor::new(), 0);
    while !stream.is_done() && length < out.len() {
        interrupt::check();
        let piece = &stored[..stored.len().min(AT_ONCE)];
        let (read, written) = stream.read(piece, out, length, piece.len() == stored.len()).ok()?;
        stored = &stored[read..];
        length += written;
    }
    Some(length)
}

/// Number of bytes, at most those of a strip, which may lack its mark of the end.
fn lzw(mut stored: &[u8], out: &mut [u8]) -> Option<usize> {
    let most = out.len() - 1;
    let mut stream =
        Configuration::with_tiff_size_switch(BitOrder::Msb, 8).with_yield_on_full_buffer(true).build();
    let mut length = 0;
    while length < most {
        interrupt::check();
        let step = stream.decode_bytes(stored, &mut out[length..most]);
        stored = &stored[step.consumed_in..];
        length += step.consumed_out;
        match step.status.ok()? {
            LzwStatus::Ok => {}
            LzwStatus::NoProgress | LzwStatus::Done => break,
        }
    }
    Some(length)
}

/// Number of bytes, at most those of a strip: runs of one byte, and bytes as they are.
fn pack_bits(mut stored: &[u8], out: &mut [u8]) -> Option<usize> {
    let most = out.len() - 1;
    let mut length = 0;
    while let Some((&head, rest)) = stored.split_first().filter(|_| length < most) {
        let count = usize::from(if head < 128 { head } else { !head + 1 }) + 1;
        let used = if head < 128 { count } else { usize::from(head > 128) };
        let bytes = rest.get(..used)?;
        let end = if head == 128 { length } else { (length + count).min(most) };
        match bytes {
            [] => {}
            &[byte] => out[length..end].fill(byte),
            bytes => out[length..end].copy_from_slice(&bytes[..end - length]),
        }
        (stored, length) = (&rest[used..], end);
    }
    Some(length)
}
