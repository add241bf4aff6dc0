//! Texts of a PNG file, unpacked up to a limit: 0.5 MB of a chunk may hold 0.5 GB.

use png::Info;

/// Longest XMP packet and longest description, in bytes.
const MOST: (usize, usize) = (4 << 20, 1 << 16);

/// XMP packet; empty without one, or if it is too long.
pub fn xmp(info: &Info<'_>) -> Vec<u8> {
    utf8(info, "XML:com.adobe.xmp", MOST.0).map(String::into_bytes).unwrap_or_default()
}

/// Text with the keyword of a description; empty without one, or if it is too long.
pub fn description(info: &Info<'_>) -> String {
    let keyword = super::write::DESCRIPTION;
    let plain = info.uncompressed_latin1_text.iter().find(|text| text.keyword == keyword);
    let packed = || {
        let mut text = info.compressed_latin1_text.iter().find(|text| text.keyword == keyword)?.clone();
        text.decompress_text_with_limit(MOST.1).ok()?;
        text.get_text().ok()
    };
    let text = plain.map(|text| text.text.clone()).or_else(packed).or_else(|| utf8(info, keyword, MOST.1));
    text.filter(|text| text.len() <= MOST.1).unwrap_or_default()
}

/// International text with a `keyword`, of at most `most` bytes.
fn utf8(info: &Info<'_>, keyword: &str, most: usize) -> Option<String> {
    let mut text = info.utf8_text.iter().find(|text| text.keyword == keyword)?.clone();
    text.decompress_text_with_limit(most).ok()?;
    text.get_text().ok().filter(|text| text.len() <= most)
}

#[cfg(test)]
mod tests {
    use png::text_metadata::{ITXtChunk, TEXtChunk, ZTXtChunk};

    use super::*;

    #[test]
    fn texts_of_every_kind_are_read_up_to_their_limits() {
        for (length, is_read) in [(MOST.1, true), (MOST.1 + 1, false)] {
            let (keyword, text) = ("Description", "a".repeat(length));
            let mut plain = Info::default();
            plain.uncompressed_latin1_text.push(TEXtChunk::new(keyword, text.clone()));
            let mut packed = Info::default();
            let mut chunk = ZTXtChunk::new(keyword, text.clone());
            chunk.compress_text().expect("memory");
            packed.compressed_latin1_text.push(chunk);
            let mut international = Info::default();
            international.utf8_text.push(ITXtChunk::new(keyword, text.clone()));
            for info in [plain, packed, international] {
                assert_eq!(description(&info), if is_read { text.clone() } else { String::new() });
            }
        }
        for (length, is_read) in [(MOST.0, true), (MOST.0 + 1, false), (1 << 26, false)] {
            let mut chunk = ITXtChunk::new("XML:com.adobe.xmp", "a".repeat(length));
            chunk.compress_text().expect("memory");
            let mut info = Info::default();
            info.utf8_text.push(chunk);
            assert_eq!(xmp(&info).len(), if is_read { length } else { 0 });
        }
    }
}
