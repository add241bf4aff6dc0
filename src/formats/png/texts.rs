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
