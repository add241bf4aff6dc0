//! Attributes of OpenEXR: a name, a type and the bytes of a value each, in a header for each part.

use exr::error::Result as ExrResult;

use crate::error::Result;
use crate::formats::input::{damage, unread};

/// Bytes of a file in front of the table of its blocks.
pub struct Preamble<'a> {
    /// True if blocks name their part.
    pub is_multipart: bool,
    /// True if the only part has tiles.
    pub is_tiled: bool,
    /// Attributes of each part.
    pub parts: Vec<Attributes<'a>>,
    /// Length in bytes.
    pub length: usize,
}

impl<'a> Preamble<'a> {
    /// Signature, version and headers of the file in `bytes`.
    pub fn read(bytes: &'a [u8]) -> Result<Self> {
        const VERSION: i32 = 2;
        let [tiled, long_names, deep, multipart] = [9, 10, 11, 12].map(|bit| 1 << bit);
        let mut rest = bytes;
        if take(&mut rest, 4)? != exr::meta::magic_number::BYTES {
            return Err(damage("it is not an OpenEXR file"));
        }
        let flags = int(&mut rest)?;
        let version = flags & !(tiled | long_names | deep | multipart);
        if version == 0 {
            return Err(damage("its header is damaged: it claims the version 0"));
        }
        if version != VERSION {
            return Err(unread("its version of OpenEXR is unknown; write it with version 2"));
        }
        let is_multipart = flags & multipart != 0;
        let parts = if is_multipart { headers(&mut rest)? } else { vec![Attributes::read(&mut rest)?] };
        let length = bytes.len() - rest.len();
        Ok(Self { is_multipart, is_tiled: flags & tiled != 0, parts, length })
    }
}

/// Headers of several parts, up to an empty one.
fn headers<'a>(bytes: &mut &'a [u8]) -> Result<Vec<Attributes<'a>>> {
    /// Most parts of a file; each takes some memory. Render passes are at most some hundred.
    const MOST_PARTS: usize = 4096;
    let mut parts = Vec::new();
    while bytes.first() != Some(&0) {
        if parts.len() == MOST_PARTS {
            return Err(damage(format!("its header is damaged: it claims more than {MOST_PARTS} parts")));
        }
        parts.push(Attributes::read(bytes)?);
    }
    take(bytes, 1)?;
    if parts.is_empty() {
        return Err(damage("its header is damaged: it claims no part"));
    }
    Ok(parts)
}

/// Attributes of a part, which are searched for at each request, so that no claim of a file takes memory.
pub struct Attributes<'a> {
    bytes: &'a [u8],
}

/// Name, type and value of an attribute.
type Attribute<'a> = (&'a [u8], &'a [u8], &'a [u8]);

impl<'a> Attributes<'a> {
    fn read(bytes: &mut &'a [u8]) -> Result<Self> {
        let start = *bytes;
        while next(bytes)?.is_some() {}
        Ok(Self { bytes: &start[..start.len() - bytes.len()] })
    }

    /// Type and bytes of the first attribute with a `name`.
    fn find(&self, name: &str) -> Option<(&'a [u8], &'a [u8])> {
        let mut rest = self.bytes;
        while let Ok(Some((found, kind, value))) = next(&mut rest) {
            if found == name.as_bytes() {
                return Some((kind, value));
            }
        }
        None
    }

    /// Value of the type `kind`, decoded by `read`; None without such an attribute.
    pub fn value<T>(
        &self,
        name: &str,
        kind: &str,
        read: impl FnOnce(&mut &'a [u8]) -> ExrResult<T>,
    ) -> Result<Option<T>> {
        let found = self.find(name).filter(|(found, _)| *found == kind.as_bytes());
        let value = found.map(|(_, mut value)| read(&mut value)).transpose();
        value.map_err(|_| damage(format!("its header is damaged: its attribute {name} has a wrong value")))
    }

    /// Value of the type `kind` that a file must have.
    pub fn demand<T>(
        &self,
        name: &str,
        kind: &str,
        read: impl FnOnce(&mut &'a [u8]) -> ExrResult<T>,
    ) -> Result<T> {
        let missing = || damage(format!("its header is damaged: it has no attribute {name}"));
        self.value(name, kind, read)?.ok_or_else(missing)
    }

    /// Text of up to `most` bytes; empty if there is none, or it is longer.
    pub fn text(&self, name: &str, most: usize) -> String {
        let found = self.find(name).filter(|(kind, value)| *kind == b"string" && value.len() <= most);
        found.and_then(|(_, value)| String::from_utf8(value.to_vec()).ok()).unwrap_or_default()
    }

    /// Number of any type, or a fraction; None if there is none.
    pub fn number(&self, name: &str) -> Option<f64> {
        let (kind, value) = self.find(name)?;
        let word = |at: usize| value.get(at..at + 4)?.first_chunk().copied();
        let number = match kind {
            b"float" => f64::from(f32::from_le_bytes(word(0)?)),
            b"int" => f64::from(i32::from_le_bytes(word(0)?)),
            b"double" => f64::from_le_bytes(*value.first_chunk()?),
            b"rational" => f64::from(i32::from_le_bytes(word(0)?)) / f64::from(u32::from_le_bytes(word(4)?)),
            _ => return None,
        };
        number.is_finite().then_some(number)
    }
}

/// Next attribute of a header; None at its end.
fn next<'a>(bytes: &mut &'a [u8]) -> Result<Option<Attribute<'a>>> {
    let name = name(bytes)?;
    if name.is_empty() {
        return Ok(None);
    }
    let kind = self::name(bytes)?;
    let length = usize::try_from(int(bytes)?).map_err(|_| damage(CUT))?;
    Ok(Some((name, kind, take(bytes, length)?)))
}

const CUT: &str = "its header is damaged or incomplete";

/// Bytes up to a zero, which is passed over.
fn name<'a>(bytes: &mut &'a [u8]) -> Result<&'a [u8]> {
    let most = usize::from(u8::MAX);
    let end = bytes.iter().take(most + 1).position(|&byte| byte == 0).ok_or_else(|| damage(CUT))?;
    Ok(&take(bytes, end + 1)?[..end])
}

/// Little-endian number of 32 bits.
pub fn int(bytes: &mut &[u8]) -> Result<i32> {
    let (head, rest) = bytes.split_first_chunk().ok_or_else(|| damage(CUT))?;
    *bytes = rest;
    Ok(i32::from_le_bytes(*head))
}

/// First `length` bytes.
pub fn take<'a>(bytes: &mut &'a [u8], length: usize) -> Result<&'a [u8]> {
    let (head, rest) = bytes.split_at_checked(length).ok_or_else(|| damage(CUT))?;
    *bytes = rest;
    Ok(head)
}
