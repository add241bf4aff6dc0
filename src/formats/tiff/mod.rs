//! TIFF files, of 32 and of 64 bits (`BigTIFF`).
//!
//! | step                                        | file            |
//! |---------------------------------------------|-----------------|
//! | form of a page, refusals of other forms     | `page.rs`       |
//! | statements of a page                        | `statements.rs` |
//! | strips and tiles of some rows               | `rows.rs`       |
//! | compressed bytes of a strip to its bytes    | `unpack.rs`     |
//! | differences to samples                      | `predictor.rs`  |
//! | bytes to samples                            | `samples.rs`    |
//! | a file of samples                           | `write.rs`      |

mod page;
mod predictor;
mod rows;
mod samples;
mod statements;
#[cfg(test)]
mod tests;
mod unpack;
pub mod write;

use std::collections::BTreeSet;
use std::ops::Range;

use self::page::Page;
use self::rows::{Cache, Request};
use super::directory::{Directory, File};
use super::header::{Header, SampleType};
use super::input::damage;
use super::picture::{PictureFile, SamplesMut, wrong_type};
use crate::error::{Error, Result};

/// A TIFF file whose pages were found; any of their rows can be decoded.
#[derive(Debug)]
pub struct Tiff<Bytes> {
    bytes: Bytes,
    headers: Vec<Header>,
    pages: Vec<(Page, Cache)>,
}

/// Most pages of a file.
const MOST_PAGES: usize = 4096;

/// Pages of the TIFF file in `bytes`, each of at most `max_pixels`, without masks and reduced copies.
///
/// # Errors
///
/// If the first page is damaged, too large, or of a kind that is not converted. Other pages are left out for that.
pub fn open<Bytes>(bytes: Bytes, max_pixels: usize) -> Result<Tiff<Bytes>>
where
    Bytes: AsRef<[u8]> + Send + Sync + 'static,
{
    let file = File::new(bytes.as_ref()).ok_or_else(damage_of_tags)?;
    let (mut headers, mut pages, mut reasons) = (Vec::new(), Vec::new(), Vec::new());
    let mut texts = file.bytes.len();
    for (number, directory) in full_pages(file)?.into_iter().enumerate() {
        let page = Page::read(&directory, file, max_pixels);
        let page = page
            .and_then(|page| statements::header(&page, &directory, &mut texts).map(|header| (page, header)));
        match page {
            Ok((page, header)) => {
                if number == 0 && is_lesser(&directory) {
                    reasons.push("by its tags the picture is a reduced copy or a mask, and the file has no page at full size".into());
                }
                pages.push((page, Cache::default()));
                headers.push(header);
            }
            Err(error) if number == 0 => return Err(error),
            Err(error) => reasons.push(format!("page {number} was left out: {error}")),
        }
    }
    for header in &mut headers {
        header.notes.clone_from(&reasons);
    }
    Ok(Tiff { bytes, headers, pages })
}

impl<Bytes: AsRef<[u8]> + Send + Sync> PictureFile for Tiff<Bytes> {
    fn parts(&self) -> &[Header] {
        &self.headers
    }

    fn read(&self, part: usize, channels: &[usize], rows: Range<usize>, out: SamplesMut<'_>) -> Result<()> {
        let file = File::new(self.bytes.as_ref()).ok_or_else(damage_of_tags)?;
        let (page, cache) = &self.pages[part];
        let is_in_pieces = page.block() >= page.height && rows.len() < page.height;
        let request = Request { file, page, channels, cache: is_in_pieces.then_some(cache) };
        match (page.sample_type(), out) {
            (SampleType::U8, SamplesMut::Bytes(out)) => request.write(rows, out),
            (SampleType::U16, SamplesMut::Words(out)) => request.write(rows, out),
            (SampleType::F16, SamplesMut::Halves(out)) => request.write(rows, out),
            (SampleType::F32, SamplesMut::Floats(out)) => request.write(rows, out),
            _ => Err(wrong_type()),
        }
    }
}

/// Directories of the pages at full size; all pages if each claims to be a reduced copy or a mask.
///
/// Only the first page of a texture counts: the others are its smaller levels.
fn full_pages(file: File<'_>) -> Result<Vec<Directory<'_>>> {
    let mut all = directories(file)?;
    if all[0].has(statements::TEXTURE_FORMAT) {
        all.truncate(1);
    }
    let full: Vec<Directory<'_>> = all.iter().filter(|page| !is_lesser(page)).copied().collect();
    Ok(if full.is_empty() { all } else { full })
}

/// True for a reduced copy or a mask, by the tag of TIFF 6 or by the older one.
fn is_lesser(page: &Directory<'_>) -> bool {
    const KIND: (u16, u64) = (254, 0b101);
    const OLDER: (u16, u64) = (255, 2);
    page.integer(KIND.0).unwrap_or(0) & KIND.1 != 0 || page.integer(OLDER.0) == Some(OLDER.1)
}

/// Directories of all pages, at least one; a damaged one ends the list.
fn directories(file: File<'_>) -> Result<Vec<Directory<'_>>> {
    let (mut all, mut places) = (Vec::new(), BTreeSet::new());
    let mut next = file.first_place();
    while let Some(place) = next.filter(|&place| all.len() < MOST_PAGES && places.insert(place)) {
        let Some(directory) = Directory::read(file, place) else { break };
        next = directory.next();
        all.push(directory);
    }
    if all.is_empty() { Err(damage_of_tags()) } else { Ok(all) }
}

fn damage_of_tags() -> Error {
    damage("the TIFF file is damaged or incomplete: its tags cannot be read")
}
