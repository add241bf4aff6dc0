//! Huffman codes of JPEG (ITU-T T.81, annex C and F.2.2) and the bits of an entropy-coded segment.

#![allow(clippy::inline_always, reason = "the bit buffer stays in registers")]

use crate::error::Result;
use crate::formats::input::damage;

/// Bits that one look-up decodes; longer codes take a search.
const QUICK: u32 = 10;

/// A Huffman table.
#[derive(Clone)]
pub(super) struct Table {
    quick: Vec<Entry>,
    /// For each length, the end of its codes with 16 bits, and the index of their first symbol less their first code.
    ends: [(u32, i32); 17],
    symbols: Vec<u8>,
}

/// Code that begins some bits: its symbol, and the integer after it if that fits too.
#[derive(Clone, Copy, Default)]
struct Entry {
    /// Integer after the code; 0 if it does not fit.
    value: i16,
    symbol: u8,
    /// Bits of the code; 0 if the code is longer than the look-up.
    code: u8,
    /// Bits of code and integer.
    total: u8,
}

impl Table {
    /// Table of the numbers of codes of 1 to 16 bits, and their symbols.
    pub fn new(counts: &[u8; 16], symbols: &[u8]) -> Result<Self> {
        let mut table =
            Self { quick: vec![Entry::default(); 1 << QUICK], ends: [(0, 0); 17], symbols: symbols.to_vec() };
        let (mut code, mut index) = (0_u32, 0_usize);
        for (length, &count) in (1..).zip(counts) {
            let first = index as i32 - code as i32;
            for _ in 0..count {
                table.enter(code, length, symbols[index]);
                (code, index) = (code + 1, index + 1);
            }
            table.ends[length as usize] = (code << (16 - length), first);
            if code > 1 << length {
                return Err(damage("the JPEG file is damaged: a Huffman table has too many codes"));
            }
            code <<= 1;
        }
        Ok(table)
    }

    /// Enter a `code` for all bits that may follow it.
    fn enter(&mut self, code: u32, length: u32, symbol: u8) {
        let Some(free) = QUICK.checked_sub(length) else { return };
        let size = u32::from(symbol & 15);
        for rest in 0..1_u32 << free {
            let mut entry = Entry { value: 0, symbol, code: length as u8, total: length as u8 };
            if (1..=free).contains(&size) {
                entry.value = extend(rest >> (free - size), size) as i16;
                entry.total += size as u8;
            }
            if let Some(place) = self.quick.get_mut((code << free | rest) as usize) {
                *place = entry;
            }
        }
    }
}

/// Integer of `size` bits whose highest bit is 1 for positive ones (F.2.2.1, EXTEND).
#[inline(always)]
fn extend(bits: u32, size: u32) -> i32 {
    let is_negative = size > 0 && bits >> (size - 1) == 0;
    bits as i32 - if is_negative { (1 << size) - 1 } else { 0 }
}

/// Bits of an entropy-coded segment without its stuffed bytes; zeros follow its end.
pub(super) struct Bits<'a> {
    data: &'a [u8],
    /// Bytes that are in the buffer or were there.
    at: usize,
    /// Next bits, from the highest on.
    buffer: u64,
    count: u32,
    /// True after a code that the table does not have, or a place outside of a block.
    pub is_wrong: bool,
}

impl<'a> Bits<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        Self { data, at: 0, buffer: 0, count: 0, is_wrong: false }
    }

    /// Fill the buffer up to at least 56 bits, for a code and an integer.
    #[inline(always)]
    fn refill(&mut self) {
        let next = self.data.get(self.at..).and_then(<[u8]>::first_chunk);
        let word = next.map_or_else(|| self.last_word(), |&bytes| u64::from_be_bytes(bytes));
        self.buffer |= word >> self.count;
        self.at += (63 - self.count as usize) >> 3;
        self.count |= 0b11_1000;
    }

    #[cold]
    fn last_word(&self) -> u64 {
        let mut bytes = [0; 8];
        let rest = self.data.get(self.at..).unwrap_or_default();
        bytes[..rest.len()].copy_from_slice(rest);
        u64::from_be_bytes(bytes)
    }

    #[inline(always)]
    fn skip(&mut self, count: u32) {
        self.buffer <<= count;
        self.count -= count;
    }

    /// Integer of up to 16 bits, which are in the buffer.
    #[inline(always)]
    fn take(&mut self, count: u32) -> u32 {
        let bits = (self.buffer >> 1 >> (63 - count)) as u32;
        self.skip(count);
        bits
    }

    /// Some bits, at most 16, as a number.
    #[inline(always)]
    pub fn number(&mut self, count: u32) -> u32 {
        if self.count < count {
            self.refill();
        }
        self.take(count)
    }

    /// Next bit.
    #[inline(always)]
    pub fn is_set(&mut self) -> bool {
        self.number(1) == 1
    }

    /// Next symbol of a `table`.
    #[inline(always)]
    pub fn symbol(&mut self, table: &Table) -> u8 {
        self.refill();
        let entry = table.quick[(self.buffer >> (64 - QUICK)) as usize];
        if entry.code == 0 {
            return self.long_symbol(table);
        }
        self.skip(u32::from(entry.code));
        entry.symbol
    }

    /// Next symbol of a `table`, and the integer after it, whose size is in the low half of the symbol.
    #[inline(always)]
    pub fn symbol_and_integer(&mut self, table: &Table) -> (u8, i32) {
        self.refill();
        let entry = table.quick[(self.buffer >> (64 - QUICK)) as usize];
        if entry.value != 0 {
            self.skip(u32::from(entry.total));
            return (entry.symbol, i32::from(entry.value));
        }
        let symbol = if entry.code == 0 { self.long_symbol(table) } else { entry.symbol };
        self.skip(u32::from(entry.code));
        let size = u32::from(symbol & 15);
        (symbol, extend(self.take(size), size))
    }

    #[cold]
    fn long_symbol(&mut self, table: &Table) -> u8 {
        let bits = (self.buffer >> 48) as u32;
        let Some(length) = (QUICK as usize + 1..=16).find(|&length| bits < table.ends[length].0) else {
            self.is_wrong = true;
            return 0;
        };
        self.skip(length as u32);
        let index = (bits >> (16 - length)) as i32 + table.ends[length].1;
        table.symbols.get(index as usize).copied().unwrap_or_default()
    }

    /// Refuse wrong codes, bits after the end, and bytes other than zeros that were left over.
    pub fn finish(&self) -> Result<()> {
        let used = (8 * self.at - self.count as usize).div_ceil(8);
        let Some(rest) = self.data.get(used..) else {
            return Err(damage("the JPEG file is incomplete: its pixels end too early"));
        };
        if self.is_wrong || rest.iter().any(|&byte| byte != 0) {
            return Err(damage("the JPEG file is damaged: its pixels hold wrong codes"));
        }
        Ok(())
    }
}
