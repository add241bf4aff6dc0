//! Scans of a JPEG picture: entropy-coded data to coefficients (ITU-T T.81, F.2 and G.2).
//!
//! A file that libjpeg would warn about is refused: wrong codes, missing scans, lost restart markers, a missing end.

use std::ops::Range;

use super::frame::{Block, Frame, marker};
use super::huffman::{Bits, Table};
use super::planes::Planes;
use super::segments::{Segment, Segments};
use crate::error::{Error, Result};
use crate::formats::input::damage;
use crate::interrupt;

/// Most scans of a picture. Programs write 1 to 20; each scan of a hostile file takes time.
const MOST_SCANS: usize = 256;
/// Rows of units that are decoded while the rows before them are transformed.
const BAND: usize = 4;

/// Position of each coefficient in its block, by its number in a scan (T.81, figure A.6).
const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40, 48, 41, 34, 27, 20, 13, 6, 7,
    14, 21, 28, 35, 42, 49, 56, 57, 50, 43, 36, 29, 22, 15, 23, 30, 37, 44, 51, 58, 59, 52, 45, 38, 31, 39,
    46, 53, 60, 61, 54, 47, 55, 62, 63,
];

/// Samples of all components of the picture at `start` in a file.
///
/// # Errors
///
/// If the file is damaged or incomplete, or there is no memory.
pub(super) fn decode(bytes: &[u8], start: usize, frame: &Frame) -> Result<Planes> {
    frame.check_length(bytes.len())?;
    let mut decoder = Decoder::new(frame)?;
    let mut segments = Segments::new(bytes, start)?;
    for _ in 0..=MOST_SCANS {
        if !decoder.read_tables(&mut segments)? {
            return decoder.finish();
        }
    }
    Err(damage(format!("it is a JPEG of more than {MOST_SCANS} scans; save it again")))
}

/// Tables, and what the scans gave.
struct Decoder<'a> {
    frame: &'a Frame,
    steps: [Option<[i32; 64]>; 4],
    dc: [Option<Table>; 4],
    ac: [Option<Table>; 4],
    interval: usize,
    /// Lowest bit of each coefficient that was read, for each component; None without any.
    accuracy: Vec<[Option<u8>; 64]>,
    /// Coefficients of the whole picture; empty if its only scan is transformed at once.
    stored: Vec<Vec<Block>>,
    planes: Planes,
}

/// Parameters of a scan (T.81, B.2.3).
struct Scan<'a> {
    /// Components and their tables.
    parts: Vec<Part<'a>>,
    /// Numbers of the coefficients.
    band: Range<usize>,
    /// True if the coefficients are refined by one bit.
    is_refinement: bool,
    /// Lowest bit that is read.
    low: u8,
    is_progressive: bool,
}

/// Component of a scan.
struct Part<'a> {
    component: usize,
    dc: Option<&'a Table>,
    ac: Option<&'a Table>,
}

impl<'a> Decoder<'a> {
    fn new(frame: &'a Frame) -> Result<Self> {
        Ok(Self {
            frame,
            steps: [None; 4],
            dc: Default::default(),
            ac: Default::default(),
            interval: 0,
            accuracy: vec![[None; 64]; frame.components.len()],
            stored: Vec::new(),
            planes: Planes::new(frame)?,
        })
    }

    /// Read segments up to the end of the next scan; false at the end of the picture.
    fn read_tables(&mut self, segments: &mut Segments<'_>) -> Result<bool> {
        loop {
            let Segment { code, body, .. } = segments.next()?;
            match code {
                marker::STEPS => self.read_steps(body)?,
                marker::HUFFMAN_TABLES => self.read_huffman(body)?,
                marker::RESTART_INTERVAL => self.interval = interval(body)?,
                marker::SCAN => {
                    let (data, ranges) = segments.scan_data(self.interval)?;
                    return self.read_scan(body, &data, &ranges).map(|()| true);
                }
                marker::END => return Ok(false),
                marker::START => {
                    return Err(damage("the JPEG file is incomplete: another picture begins inside"));
                }
                _ => {}
            }
        }
    }

    fn read_steps(&mut self, mut body: &[u8]) -> Result<()> {
        let wrong = || damage("the JPEG file is damaged: it has wrong steps of quantisation");
        while let [place, rest @ ..] = body {
            let size = if place >> 4 == 0 { 1 } else { 2 };
            let (values, after) = rest.split_at_checked(64 * size).ok_or_else(wrong)?;
            let table = self.steps.get_mut(usize::from(place & 15)).ok_or_else(wrong)?.get_or_insert([0; 64]);
            for (value, &position) in values.chunks_exact(size).zip(&ZIGZAG) {
                table[usize::from(position)] =
                    value.iter().fold(0, |number, &byte| number << 8 | i32::from(byte));
            }
            body = after;
        }
        Ok(())
    }

    fn read_huffman(&mut self, mut body: &[u8]) -> Result<()> {
        let wrong = || damage("the JPEG file is damaged: it has wrong Huffman tables");
        while let [place, rest @ ..] = body {
            let counts = rest.first_chunk::<16>().ok_or_else(wrong)?;
            let count: usize = counts.iter().map(|&count| usize::from(count)).sum();
            let symbols = rest.get(16..16 + count).ok_or_else(wrong)?;
            let tables = if place >> 4 == 0 { &mut self.dc } else { &mut self.ac };
            *tables.get_mut(usize::from(place & 15)).ok_or_else(wrong)? = Some(Table::new(counts, symbols)?);
            body = &rest[16 + symbols.len()..];
        }
        Ok(())
    }

    fn read_scan(&mut self, body: &[u8], data: &[u8], ranges: &[Range<usize>]) -> Result<()> {
        let (dc, ac) = (std::mem::take(&mut self.dc), std::mem::take(&mut self.ac));
        let scan = Scan::read(body, self.frame, &dc, &ac)?;
        self.note_accuracy(&scan)?;
        for part in &scan.parts {
            let steps = self.steps[self.frame.components[part.component].steps].as_ref();
            self.planes.set_steps(part.component, steps)?;
        }
        let units = Units::new(self.frame, &scan);
        let reader = Reader::new(data, ranges, self.interval, units.rows * units.columns)?;
        let is_whole = !scan.is_progressive && scan.parts.len() == self.frame.components.len();
        if is_whole {
            self.transform_scan(&scan, &units, reader)
        } else {
            self.store_scan(&scan, &units, reader)
        }?;
        (self.dc, self.ac) = (dc, ac);
        Ok(())
    }

    /// Refuse a scan that repeats or skips bits of coefficients.
    fn note_accuracy(&mut self, scan: &Scan<'_>) -> Result<()> {
        let before = scan.is_refinement.then_some(scan.low + 1);
        for part in &scan.parts {
            let accuracy = &mut self.accuracy[part.component];
            if accuracy[scan.band.clone()].iter().any(|&low| low != before) {
                return Err(damage("the JPEG file is damaged: a scan is missing or comes twice"));
            }
            accuracy[scan.band.clone()].fill(Some(scan.low));
            if accuracy[0].is_none() {
                return Err(damage("the JPEG file is damaged: a scan is missing"));
            }
        }
        Ok(())
    }

    /// Decode the only scan in bands of rows; each is transformed while the next one is decoded.
    fn transform_scan(&mut self, scan: &Scan<'_>, units: &Units, mut reader: Reader<'_>) -> Result<()> {
        let planes = &mut self.planes;
        let mut read_band = |first: usize, blocks: &mut [Vec<Block>]| -> Result<()> {
            for blocks in blocks.iter_mut() {
                blocks.fill([0; 64]);
            }
            for row in 0..BAND.min(units.rows.saturating_sub(first)) {
                interrupt::check();
                reader.decode_row(scan, units, row, blocks)?;
            }
            Ok(())
        };
        let mut blocks = self.frame.blocks(BAND)?;
        let mut next = blocks.clone();
        read_band(0, &mut blocks)?;
        for first in (0..units.rows).step_by(BAND) {
            let (read, ()) =
                rayon::join(|| read_band(first + BAND, &mut next), || planes.transform(first, &blocks));
            read?;
            std::mem::swap(&mut blocks, &mut next);
        }
        reader.finish()
    }

    /// Decode a scan into the stored coefficients of the picture.
    fn store_scan(&mut self, scan: &Scan<'_>, units: &Units, mut reader: Reader<'_>) -> Result<()> {
        if self.stored.is_empty() {
            self.stored = self.frame.blocks(self.frame.units().0)?;
        }
        for row in 0..units.rows {
            interrupt::check();
            reader.decode_row(scan, units, row, &mut self.stored)?;
        }
        reader.finish()
    }

    /// Samples of the picture, if all bits of all coefficients were read.
    fn finish(mut self) -> Result<Planes> {
        if self.accuracy.iter().flatten().any(|&low| low != Some(0)) {
            return Err(damage("the JPEG file is incomplete: some of its scans are missing"));
        }
        if !self.stored.is_empty() {
            self.planes.transform(0, &self.stored);
        }
        Ok(self.planes)
    }
}

impl Frame {
    /// Blocks of zeros of each component, for some `rows` of units.
    fn blocks(&self, rows: usize) -> Result<Vec<Vec<Block>>> {
        let columns = self.units().1;
        let blocks = self.components.iter().map(|component| {
            let shape = [rows * component.down, columns * component.across, 64];
            let count = shape[0] * shape[1];
            let no_memory = |_| Error::NoMemory { shape: shape.to_vec() };
            // `vec!` clears no page by itself, but aborts without memory; this reports it.
            Vec::<Block>::new().try_reserve_exact(count).map_err(no_memory)?;
            Ok(vec![[0; 64]; count])
        });
        blocks.collect()
    }
}

/// Content of the segment of a restart interval.
fn interval(body: &[u8]) -> Result<usize> {
    let bytes =
        body.first_chunk().ok_or_else(|| damage("the JPEG file is damaged: it has no restart interval"))?;
    Ok(u16::from_be_bytes(*bytes).into())
}

impl<'a> Scan<'a> {
    /// Scan of the `body` of its segment, with tables for the first and for the other coefficients.
    fn read(
        body: &[u8],
        frame: &Frame,
        dc: &'a [Option<Table>; 4],
        ac: &'a [Option<Table>; 4],
    ) -> Result<Self> {
        let wrong = || damage("the JPEG file is damaged: a scan has wrong parameters");
        let count = usize::from(*body.first().ok_or_else(wrong)?);
        let &[from, to, bits] =
            body.get(1 + 2 * count..).and_then(|rest| rest.try_into().ok()).ok_or_else(wrong)?;
        let mut parts = Vec::new();
        for &[id, tables] in body[1..=2 * count].as_chunks().0 {
            let component = frame.components.iter().position(|one| one.id == id).ok_or_else(wrong)?;
            let (dc, ac) = (dc.get(usize::from(tables >> 4)), ac.get(usize::from(tables & 15)));
            parts.push(Part { component, dc: dc.and_then(Option::as_ref), ac: ac.and_then(Option::as_ref) });
        }
        let (high, low, is_progressive) = (bits >> 4, bits & 15, frame.is_progressive);
        // Some cameras write a wrong range of coefficients into sequential scans.
        let (band, low) = if is_progressive { (from.into()..usize::from(to) + 1, low) } else { (0..64, 0) };
        let scan = Self { parts, band, is_refinement: is_progressive && high > 0, low, is_progressive };
        let is_sound = scan.is_sound(frame) && (!scan.is_refinement || high == low + 1);
        if is_sound { Ok(scan) } else { Err(wrong()) }
    }

    /// True if the parts, the coefficients and the tables fit together.
    fn is_sound(&self, frame: &Frame) -> bool {
        /// Most blocks in a unit of an interleaved scan (T.81, B.2.3).
        const MOST_BLOCKS: usize = 10;
        let blocks = self.parts.iter().map(|part| {
            let component = &frame.components[part.component];
            component.across * component.down
        });
        let is_interleaved = self.parts.len() > 1;
        let are_different = (1..self.parts.len()).all(|place| {
            self.parts[..place].iter().all(|part| part.component != self.parts[place].component)
        });
        let needs_dc = self.band.start == 0 && !self.is_refinement;
        let needs_ac = self.band.end > 1;
        let is_band = self.band.start < self.band.end && self.band.end <= 64 && self.low <= 13;
        let is_pure =
            !self.is_progressive || if needs_ac { self.band.start > 0 && !is_interleaved } else { true };
        let has_tables = self
            .parts
            .iter()
            .all(|part| (!needs_dc || part.dc.is_some()) && (!needs_ac || part.ac.is_some()));
        let is_small = !is_interleaved || blocks.sum::<usize>() <= MOST_BLOCKS;
        !self.parts.is_empty() && are_different && is_band && is_pure && has_tables && is_small
    }
}

/// Minimum coded units of a scan.
struct Units {
    rows: usize,
    columns: usize,
    /// For each part: its blocks in a row and a column of a unit, and in a row of the picture.
    blocks: Vec<[usize; 3]>,
}

impl Units {
    fn new(frame: &Frame, scan: &Scan<'_>) -> Self {
        let (mut rows, mut columns) = frame.units();
        let parts = scan.parts.iter().map(|part| &frame.components[part.component]);
        let mut blocks: Vec<_> =
            parts.clone().map(|one| [one.across, one.down, one.across * columns]).collect();
        if let [[across, down, _]] = &mut blocks[..] {
            (*across, *down) = (1, 1);
            let samples = parts.map(|component| frame.samples(component)).next().unwrap_or_default();
            (rows, columns) = (samples.0.div_ceil(8), samples.1.div_ceil(8));
        }
        Self { rows, columns, blocks }
    }
}

/// Reader of the units of a scan, one restart interval after the other.
struct Reader<'a> {
    data: &'a [u8],
    ranges: std::slice::Iter<'a, Range<usize>>,
    /// Units of an interval, and those that are left in this one.
    interval: usize,
    left: usize,
    bits: Bits<'a>,
    /// Last first coefficient of each component.
    predictions: [i32; 4],
    /// Blocks whose coefficients are all zero, as an end of band states.
    empty_blocks: u32,
}

impl<'a> Reader<'a> {
    fn new(data: &'a [u8], ranges: &'a [Range<usize>], interval: usize, units: usize) -> Result<Self> {
        let interval = if interval == 0 { units } else { interval };
        let wanted = units.div_ceil(interval);
        // Some programs write a restart marker behind the last interval too.
        let is_closed = ranges.len() == wanted + 1 && ranges.last().is_some_and(Range::is_empty);
        if ranges.len() != wanted && !is_closed {
            return Err(damage("the JPEG file is damaged: a restart marker is missing"));
        }
        let ranges = ranges[..wanted].iter();
        Ok(Self {
            data,
            ranges,
            interval,
            left: 0,
            bits: Bits::new(&[]),
            predictions: [0; 4],
            empty_blocks: 0,
        })
    }

    /// Begin the next interval if this one is at its end.
    fn next_unit(&mut self) -> Result<()> {
        if self.left == 0 {
            self.finish()?;
            let range = self.ranges.next().cloned().unwrap_or_default();
            (self.bits, self.left) = (Bits::new(&self.data[range]), self.interval);
            (self.predictions, self.empty_blocks) = ([0; 4], 0);
        }
        self.left -= 1;
        Ok(())
    }

    /// Refuse an interval with wrong codes or too many bytes.
    fn finish(&self) -> Result<()> {
        self.bits.finish()
    }

    /// Decode a `row` of the units of a scan into the `blocks` of the components.
    fn decode_row(
        &mut self,
        scan: &Scan<'_>,
        units: &Units,
        row: usize,
        blocks: &mut [Vec<Block>],
    ) -> Result<()> {
        for column in 0..units.columns {
            self.next_unit()?;
            for (part, &[across, down, stride]) in scan.parts.iter().zip(&units.blocks) {
                for y in 0..down {
                    let first = (row * down + y) * stride + column * across;
                    for block in &mut blocks[part.component][first..first + across] {
                        if scan.is_progressive {
                            self.progressive_block(scan, part, block);
                        } else {
                            self.sequential_block(part, block);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn sequential_block(&mut self, part: &Part<'_>, block: &mut Block) {
        let (Some(dc), Some(ac)) = (part.dc, part.ac) else { return };
        block[0] = self.first_coefficient(dc, part.component);
        let mut k = 1;
        while k < 64 {
            let (symbol, value) = self.bits.symbol_and_integer(ac);
            k += usize::from(symbol >> 4);
            match (symbol, ZIGZAG.get(k)) {
                (0, _) => return,
                (0xF0, _) => {}
                (_, Some(&place)) if symbol & 15 != 0 => block[usize::from(place) & 63] = value as i16,
                _ => self.bits.is_wrong = true,
            }
            k += 1;
        }
    }

    /// First coefficient of the next block, from its difference to the one before.
    fn first_coefficient(&mut self, table: &Table, component: usize) -> i16 {
        let (symbol, difference) = self.bits.symbol_and_integer(table);
        self.bits.is_wrong |= symbol > 15;
        let prediction = &mut self.predictions[component];
        *prediction = prediction.wrapping_add(difference);
        *prediction as i16
    }

    fn progressive_block(&mut self, scan: &Scan<'_>, part: &Part<'_>, block: &mut Block) {
        match (scan.band.start, scan.is_refinement, part.dc, part.ac) {
            (0, false, Some(dc), _) => block[0] = self.first_coefficient(dc, part.component) << scan.low,
            (0, ..) => block[0] |= i16::from(self.bits.is_set()) << scan.low,
            (_, false, _, Some(ac)) => self.read_band(scan, ac, block),
            (_, true, _, Some(ac)) => self.refine_band(scan, ac, block),
            _ => {}
        }
    }

    /// Read the highest bits of the coefficients of a band (T.81, G.1.2.2).
    fn read_band(&mut self, scan: &Scan<'_>, table: &Table, block: &mut Block) {
        if self.empty_blocks > 0 {
            self.empty_blocks -= 1;
            return;
        }
        let mut k = scan.band.start;
        while k < scan.band.end {
            let (symbol, value) = self.bits.symbol_and_integer(table);
            let (run, size) = (symbol >> 4, symbol & 15);
            if size == 0 && run < 15 {
                self.empty_blocks = self.end_of_band(run) - 1;
                return;
            }
            k += usize::from(run);
            if size != 0 {
                self.bits.is_wrong |= k >= scan.band.end;
                block[usize::from(ZIGZAG[k & 63])] = (value << scan.low) as i16;
            }
            k += 1;
        }
    }

    /// Blocks that end here, this one too.
    fn end_of_band(&mut self, run: u8) -> u32 {
        (1 << run) + self.bits.number(run.into())
    }

    /// Read one more bit of the coefficients of a band (T.81, G.1.2.3).
    fn refine_band(&mut self, scan: &Scan<'_>, table: &Table, block: &mut Block) {
        let mut k = scan.band.start;
        while self.empty_blocks == 0 && k < scan.band.end {
            let symbol = self.bits.symbol(table);
            let (run, size) = (symbol >> 4, symbol & 15);
            if size == 0 && run < 15 {
                self.empty_blocks = self.end_of_band(run);
                break;
            }
            self.bits.is_wrong |= size > 1;
            let sign = if size == 0 {
                0
            } else if self.bits.is_set() {
                1
            } else {
                -1
            };
            k = self.refine_run(scan, k, run, block);
            if sign != 0 {
                self.bits.is_wrong |= k >= scan.band.end;
                block[usize::from(ZIGZAG[k & 63])] = sign << scan.low;
            }
            k += 1;
        }
        if self.empty_blocks > 0 {
            self.refine_run(scan, k, u8::MAX, block);
            self.empty_blocks -= 1;
        }
    }

    /// Refine coefficients from number `k` on, past `zeros` of zero; return the number of the next zero.
    fn refine_run(&mut self, scan: &Scan<'_>, mut k: usize, mut zeros: u8, block: &mut Block) -> usize {
        while k < scan.band.end {
            let coefficient = &mut block[usize::from(ZIGZAG[k & 63])];
            if *coefficient == 0 {
                if zeros == 0 {
                    break;
                }
                zeros -= 1;
            } else if self.bits.is_set() && *coefficient & (1 << scan.low) == 0 {
                *coefficient = coefficient.wrapping_add(coefficient.signum() << scan.low);
            }
            k += 1;
        }
        k
    }
}
