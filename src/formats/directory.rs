//! Directories in the layout of TIFF (TIFF 6.0, section 2; `BigTIFF`): tags and where their values lie.
//!
//! EXIF has the same layout, in a segment of JPEG, a chunk of PNG, and a TIFF file itself.
//!
//! Nothing is copied, and no memory is allocated for anything that the bytes claim.

/// Bytes of a file with its byte order and the size of its offsets.
#[derive(Clone, Copy, Debug)]
pub struct File<'a> {
    /// All bytes.
    pub bytes: &'a [u8],
    /// True if numbers begin with their lowest byte.
    pub is_little_endian: bool,
    /// True for `BigTIFF`, whose offsets have 8 bytes.
    pub is_big: bool,
}

/// List of tags.
#[derive(Clone, Copy, Debug)]
pub struct Directory<'a> {
    file: File<'a>,
    /// Place of the first entry.
    first: usize,
    /// Number of entries.
    count: usize,
}

/// Integers in a file, such as the offsets of strips.
#[derive(Clone, Copy, Debug)]
pub struct Integers {
    place: usize,
    /// Bytes of one of them: 1, 2, 4 or 8.
    size: usize,
    /// Number of integers.
    pub count: usize,
}

/// Most tags of a directory that are read.
const MOST_TAGS: usize = 1024;

impl<'a> File<'a> {
    /// File with the header of TIFF or `BigTIFF`; None for other bytes.
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        let (is_little_endian, is_big) = match bytes.first_chunk()? {
            b"II*\0" => (true, false),
            b"MM\0*" => (false, false),
            b"II+\0" => (true, true),
            b"MM\0+" => (false, true),
            _ => return None,
        };
        Some(Self { bytes, is_little_endian, is_big })
    }

    /// First directory.
    pub fn first(self) -> Option<Directory<'a>> {
        Directory::read(self, self.first_place()?)
    }

    /// Place of the first directory.
    pub fn first_place(self) -> Option<usize> {
        self.offset(self.offset_size())
    }

    /// Some bytes at `place`, the lowest first.
    fn take<const N: usize>(self, place: usize) -> Option<[u8; N]> {
        let mut bytes: [u8; N] = *self.bytes.get(place..)?.first_chunk()?;
        if !self.is_little_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn short(self, place: usize) -> Option<u16> {
        self.take(place).map(u16::from_le_bytes)
    }

    /// Unsigned integer of 1, 2, 4 or 8 bytes.
    fn integer(self, place: usize, size: usize) -> Option<u64> {
        match size {
            1 => self.take::<1>(place).map(|[byte]| byte.into()),
            2 => self.short(place).map(u64::from),
            4 => self.take(place).map(u32::from_le_bytes).map(u64::from),
            _ => self.take(place).map(u64::from_le_bytes),
        }
    }

    fn offset(self, place: usize) -> Option<usize> {
        self.integer(place, self.offset_size()).and_then(|offset| usize::try_from(offset).ok())
    }

    fn offset_size(self) -> usize {
        if self.is_big { 8 } else { 4 }
    }
}

impl<'a> Directory<'a> {
    /// Directory at a `place`; None if it does not lie in the file.
    pub fn read(file: File<'a>, place: usize) -> Option<Self> {
        let size = if file.is_big { 8 } else { 2 };
        let count = usize::try_from(file.integer(place, size)?).ok()?;
        let first = place.checked_add(size)?;
        let end = count.checked_mul(entry_size(file))?.checked_add(first)?;
        (count <= MOST_TAGS && end <= file.bytes.len()).then_some(Self { file, first, count })
    }

    /// File that it lies in.
    pub fn file(&self) -> File<'a> {
        self.file
    }

    /// Place of the next directory; None without one.
    pub fn next(&self) -> Option<usize> {
        let place = self.file.offset(self.first + self.count * entry_size(self.file))?;
        Some(place).filter(|&place| place > 0)
    }

    /// Directory to which a `tag` points.
    pub fn child(&self, tag: u16) -> Option<Self> {
        Self::read(self.file, usize::try_from(self.integer(tag)?).ok()?)
    }

    /// True if there is such a `tag`, even with a damaged value.
    pub fn has(&self, tag: u16) -> bool {
        self.entry(tag).is_some()
    }

    /// First value of a `tag` of unsigned integers.
    pub fn integer(&self, tag: u16) -> Option<u64> {
        self.integers(tag)?.get(self.file, 0)
    }

    /// Values of a `tag` of unsigned integers; None if some lie outside of the file.
    pub fn integers(&self, tag: u16) -> Option<Integers> {
        let (kind, count, place) = self.values(tag)?;
        let size = [(1, 1), (3, 2), (4, 4), (13, 4), (16, 8), (18, 8)].iter().find(|one| one.0 == kind)?.1;
        Some(Integers { place, size, count })
    }

    /// Bytes of a `tag` of bytes or text, at most `most` of them; None if there are more.
    pub fn bytes(&self, tag: u16, most: usize) -> Option<&'a [u8]> {
        let (kind, count, place) = self.values(tag)?;
        (matches!(kind, 1 | 2 | 7) && count <= most).then(|| &self.file.bytes[place..place + count])
    }

    /// First value of a `tag` of numbers, if it is finite.
    pub fn number(&self, tag: u16) -> Option<f64> {
        let (kind, count, place) = self.values(tag)?;
        (count > 0).then(|| self.value(kind, place)).flatten().filter(|value| value.is_finite())
    }

    fn value(&self, kind: u16, place: usize) -> Option<f64> {
        let four = |place| self.file.take::<4>(place);
        match kind {
            1 => self.file.integer(place, 1).map(|value| value as f64),
            3 => self.file.integer(place, 2).map(|value| value as f64),
            4 => self.file.integer(place, 4).map(|value| value as f64),
            5 => Some(
                f64::from(u32::from_le_bytes(four(place)?)) / f64::from(u32::from_le_bytes(four(place + 4)?)),
            ),
            6 => self.file.take(place).map(i8::from_le_bytes).map(f64::from),
            8 => self.file.take(place).map(i16::from_le_bytes).map(f64::from),
            9 => four(place).map(i32::from_le_bytes).map(f64::from),
            10 => Some(
                f64::from(i32::from_le_bytes(four(place)?)) / f64::from(i32::from_le_bytes(four(place + 4)?)),
            ),
            11 => four(place).map(f32::from_le_bytes).map(f64::from),
            12 => self.file.take(place).map(f64::from_le_bytes),
            _ => None,
        }
    }

    /// Type of the values of a `tag`, their number and their place, which lies in the file with all of them.
    fn values(&self, tag: u16) -> Option<(u16, usize, usize)> {
        let entry = self.entry(tag)?;
        let kind = self.file.short(entry + 2)?;
        let count = self.file.offset(entry + 4)?;
        let field = entry + 4 + self.file.offset_size();
        let length = count.checked_mul(size_of_kind(kind)?)?;
        let place = if length <= self.file.offset_size() { field } else { self.file.offset(field)? };
        (place.checked_add(length)? <= self.file.bytes.len()).then_some((kind, count, place))
    }

    /// Place of the entry of a `tag`.
    fn entry(&self, tag: u16) -> Option<usize> {
        let mut entries = (0..self.count).map(|entry| self.first + entry * entry_size(self.file));
        entries.find(|&entry| self.file.short(entry) == Some(tag))
    }
}

impl Integers {
    /// Integer by its number; None if there are fewer.
    pub fn get(self, file: File<'_>, number: usize) -> Option<u64> {
        (number < self.count).then(|| file.integer(self.place + number * self.size, self.size)).flatten()
    }

    /// All of them.
    pub fn iter(self, file: File<'_>) -> impl Iterator<Item = u64> {
        (0..self.count).filter_map(move |number| self.get(file, number))
    }
}

fn entry_size(file: File<'_>) -> usize {
    if file.is_big { 20 } else { 12 }
}

/// Bytes of a value of a type; None for types that are not defined.
fn size_of_kind(kind: u16) -> Option<usize> {
    match kind {
        1 | 2 | 6 | 7 => Some(1),
        3 | 8 => Some(2),
        4 | 9 | 11 | 13 => Some(4),
        5 | 10 | 12 | 16..=18 => Some(8),
        _ => None,
    }
}
