//! Order of channels: the file has that of the alphabet, callers expect red, green, blue and alpha.

use std::collections::BTreeSet;

use exr::meta::attribute::{ChannelDescription, SampleType as FileType};

use crate::formats::header::{Channel, SampleType};

/// Usual names within a layer, in their order.
const USUAL: [&str; 20] = [
    "R", "Red", "G", "Green", "B", "Blue", "Y", "real", "imag", "A", "Alpha", "AR", "RA", "AG", "GA", "AB",
    "BA", "Z", "Depth", "Zback",
];
/// Usual names of a layer that holds positions or normals, in their order.
const OF_POSITIONS: [&str; 20] = [
    "R", "Red", "G", "Green", "B", "Blue", "X", "Y", "Z", "real", "imag", "A", "Alpha", "AR", "RA", "AG",
    "GA", "AB", "BA", "Depth",
];

/// Channels by layer and then by their usual order, as OpenImageIO has it, with their numbers in the `list` of the file.
pub fn order(list: &[ChannelDescription]) -> (Vec<Channel>, Vec<usize>) {
    let names: Vec<String> =
        list.iter().map(|one| String::from_utf8_lossy(one.name.as_slice()).into_owned()).collect();
    let layers_with = |suffixes: &[&str]| -> BTreeSet<&str> {
        let parts = names.iter().map(|name| split(name));
        parts
            .filter(|(_, suffix)| position(suffixes, suffix) < suffixes.len())
            .map(|(layer, _)| layer)
            .collect()
    };
    let (with_x, with_y_or_z) = (layers_with(&["X"]), layers_with(&["Y", "Z"]));
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by_cached_key(|&number| {
        let (layer, suffix) = split(&names[number]);
        let holds_positions = with_x.contains(layer) && with_y_or_z.contains(layer);
        let usual = if holds_positions { &OF_POSITIONS } else { &USUAL };
        (layer, position(usual, suffix), suffix)
    });
    let channel =
        |&number: &usize| Channel { name: names[number].clone(), sample: sample(list[number].sample_type) };
    (order.iter().map(channel).collect(), order)
}

/// True for the names of alpha in any layer.
pub fn is_alpha(name: &str) -> bool {
    position(&["A", "Alpha"], split(name).1) < 2
}

/// Layer of a channel, with its dot, and the rest of its name.
fn split(name: &str) -> (&str, &str) {
    name.split_at(name.rfind('.').map_or(0, |dot| dot + 1))
}

/// Place of a `suffix` among `names` in any case; their number if it is not among them.
fn position(names: &[&str], suffix: &str) -> usize {
    names.iter().position(|name| name.eq_ignore_ascii_case(suffix)).unwrap_or(names.len())
}

/// Type of the samples. Integers of 32 bits are refused when they are read.
fn sample(kind: FileType) -> SampleType {
    match kind {
        FileType::F16 => SampleType::F16,
        FileType::F32 | FileType::U32 => SampleType::F32,
    }
}
