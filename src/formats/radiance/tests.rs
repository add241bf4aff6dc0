#![allow(clippy::float_cmp, reason = "exact values are expected")]

use proptest::prelude::*;

use super::*;
use crate::formats::picture::Samples;

fn file(resolution: &str, pixels: &[u8]) -> Vec<u8> {
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{resolution}\n");
    [header.as_bytes(), pixels].concat()
}

fn reason(bytes: &[u8]) -> String {
    Radiance::open(bytes, 1 << 20).expect_err("damage is refused").to_string()
}

/// Samples of some rows, one after the other.
fn samples<Bytes: AsRef<[u8]> + Send + Sync>(picture: &Radiance<Bytes>, rows: Range<usize>) -> Vec<f32> {
    let Ok(Samples::Floats(samples)) = picture.samples(0, &[0, 1, 2], rows) else { return Vec::new() };
    samples.into_iter().collect()
}

/// Value of a sample by the definition.
fn value(mantissa: u8, exponent: u8) -> f32 {
    if exponent == 0 { 0.0 } else { (f64::from(mantissa) * 2_f64.powi(i32::from(exponent) - 136)) as f32 }
}

/// Packets of one plane: runs or literals, of the lengths in `choices`.
fn packets(plane: &[u8], choices: &[u8], out: &mut Vec<u8>) {
    let (mut x, mut turn) = (0, 0);
    while x < plane.len() {
        let wanted = usize::from(choices[turn % choices.len()]).clamp(1, 127);
        turn += 1;
        let same = plane[x..].iter().take_while(|&&byte| byte == plane[x]).count().min(wanted);
        if same > 1 {
            out.extend([128 + same as u8, plane[x]]);
            x += same;
        } else {
            let length = wanted.min(plane.len() - x);
            out.push(length as u8);
            out.extend(&plane[x..x + length]);
            x += length;
        }
    }
}

/// One line with new runs.
fn new_line(pixels: &[[u8; 4]], choices: &[u8]) -> Vec<u8> {
    let width = (pixels.len() as u16).to_be_bytes();
    let mut out = vec![2, 2, width[0], width[1]];
    for channel in 0..4 {
        let plane: Vec<u8> = pixels.iter().map(|pixel| pixel[channel]).collect();
        packets(&plane, choices, &mut out);
    }
    out
}

/// One line with old runs, or flat if `has_runs` is false.
fn old_line(pixels: &[[u8; 4]], has_runs: bool) -> Vec<u8> {
    let (mut out, mut x) = (Vec::new(), 0);
    while x < pixels.len() {
        out.extend(pixels[x]);
        let same = pixels[x..].iter().take_while(|&&pixel| pixel == pixels[x]).count() - 1;
        x += 1;
        if has_runs && same > 0 {
            out.extend([1, 1, 1, same as u8]);
            if same > 255 {
                out.extend([1, 1, 1, (same >> 8) as u8]);
            }
            x += same;
        }
    }
    out
}

/// A pixel that is neither a run nor the start of planes.
fn pixel() -> impl Strategy<Value = [u8; 4]> {
    any::<[u8; 4]>().prop_map(|[red, green, blue, exponent]| [red | 4, green, blue, exponent])
}

/// Lines of `width` pixels, in which many neighbours are equal.
fn lines() -> impl Strategy<Value = Vec<Vec<[u8; 4]>>> {
    (1_usize..700).prop_flat_map(|width| {
        let run = (pixel(), 1_usize..600);
        let line = prop::collection::vec(run, 1..40).prop_map(move |runs| {
            let mut line: Vec<_> =
                runs.into_iter().flat_map(|(pixel, length)| vec![pixel; length]).take(width).collect();
            let last = line[line.len() - 1];
            line.resize(width, last);
            line
        });
        prop::collection::vec(line, 1..6)
    })
}

proptest! {
    #[test]
    fn every_way_to_pack_pixels_is_unpacked(
        lines in lines(),
        choices in prop::collection::vec(any::<u8>(), 1..20),
        kinds in prop::collection::vec(0_u8..3, 6),
    ) {
        let width = lines[0].len();
        let mut data = Vec::new();
        for (line, kind) in lines.iter().zip(kinds) {
            data.extend(match kind {
                0 if (8..32768).contains(&width) => new_line(line, &choices),
                1 => old_line(line, true),
                _ => old_line(line, false),
            });
        }
        let bytes = file(&format!("-Y {} +X {width}", lines.len()), &data);
        let picture = Radiance::open(bytes.as_slice(), 1 << 20).expect("a whole file");
        let wanted: Vec<f32> = lines.iter().flatten()
            .flat_map(|&[red, green, blue, exponent]| [red, green, blue].map(|one| value(one, exponent)))
            .collect();
        prop_assert_eq!(samples(&picture, 0..lines.len()), wanted.as_slice());
        // Any row alone is the same, and every lack of bytes is noticed.
        prop_assert_eq!(samples(&picture, lines.len() - 1..lines.len()), &wanted[wanted.len() - 3 * width..]);
        prop_assert!(Radiance::open(&bytes[..bytes.len() - 1], 1 << 20).is_err());
    }

    #[test]
    fn any_bytes_give_pixels_or_a_sentence(data in prop::collection::vec(any::<u8>(), 0..400), width in 1_usize..40) {
        let bytes = file(&format!("-Y 3 +X {width}"), &data);
        if let Ok(picture) = Radiance::open(bytes.as_slice(), 1 << 20) {
            prop_assert!(picture.samples(0, &[0, 1, 2], 0..3).is_ok());
        }
    }
}

#[test]
fn every_exponent_is_exact() {
    for exponent in 0..=255 {
        let picture = Radiance::open(file("-Y 1 +X 1", &[200, 7, 255, exponent]), 1).expect("a whole file");
        let wanted = [200, 7, 255].map(|mantissa| value(mantissa, exponent));
        assert_eq!(samples(&picture, 0..1), wanted, "exponent {exponent}");
    }
}

#[test]
fn each_order_of_lines_is_an_orientation() {
    let orders = [
        "-Y 1 +X 2",
        "-Y 1 -X 2",
        "+Y 1 -X 2",
        "+Y 1 +X 2",
        "+X 1 -Y 2",
        "-X 1 -Y 2",
        "-X 1 +Y 2",
        "+X 1 +Y 2",
    ];
    for (order, orientation) in orders.iter().zip(1..) {
        let picture = Radiance::open(file(order, &[9; 8]), 2).expect("a whole file");
        let header = &picture.parts()[0];
        assert_eq!((header.orientation, header.height, header.width), (orientation, 1, 2), "{order}");
    }
}

#[test]
fn statements_of_a_header_are_read() {
    let header = "#?RGBE\r\n# a comment\r\nFORMAT = 32-bit_rle_xyze\r\nEXPOSURE=2\r\nEXPOSURE= 0.25\r\nEXPOSURE=0\r\n\
                  EXPOSURE=nan\r\nCOLORCORR=1 2 4\r\nCOLORCORR=1 0 1\r\nPRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329\r\n\r\n\
                  -Y 1 +X 1\r\n";
    let picture = Radiance::open([header.as_bytes(), &[9; 4]].concat(), 1).expect("a whole file");
    let header = &picture.parts()[0];
    assert!(header.colour.is_xyz);
    assert!(header.description.contains("# a comment"));
    assert_eq!(header.exposure, [0.5, 1.0, 2.0]);
    assert_eq!(header.colour.chromaticities, Some([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]));
    let zeros = "#?x\nFORMAT=32-bit_rle_rgbe\nPRIMARIES=0 0 0 0 0 0 0 0\n\n-Y 1 +X 1\n";
    let picture = Radiance::open([zeros.as_bytes(), &[9; 4]].concat(), 1).expect("a whole file");
    assert_eq!(picture.parts()[0].colour.chromaticities, None);
}

#[test]
fn wrong_headers_are_refused() {
    let wrong = [
        ("", "starts with #?"),
        ("#?RADIANCE", "header is incomplete"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "header is incomplete"),
        ("#?RADIANCE\n\n-Y 1 +X 1\n", "no FORMAT line"),
        ("#?RADIANCE\nFORMAT=32-bit_float\n\n-Y 1 +X 1\n", "\"32-bit_float\"; wanted"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +Y 1\n", "the resolution"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y -1 +X 1\n", "the resolution"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X\n", "the resolution"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 1\n", "at least one pixel"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000 +X 2000\n", "up to 1048576 pixels"),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99 +X 1\n", "cannot hold its 99 lines"),
    ];
    for (header, sentence) in wrong {
        assert!(reason(header.as_bytes()).contains(sentence), "{header:?}: {}", reason(header.as_bytes()));
    }
}

#[test]
fn wrong_lines_are_refused() {
    let planes = [2, 2, 0, 8, 136, 1, 136, 1, 136, 1, 136, 1];
    assert!(Radiance::open(file("-Y 1 +X 8", &planes), 8).is_ok());
    let mut other = planes;
    other[3] = 9;
    assert!(
        reason(&file("-Y 1 +X 8", &other))
            .contains("line 0 of the Radiance file announces 9 pixels; wanted 8")
    );
    for length in [0, 137] {
        let mut other = planes;
        other[6] = length;
        assert!(reason(&file("-Y 1 +X 8", &other)).contains("too long"), "a run of {length}");
    }
    assert!(reason(&file("-Y 1 +X 8", &planes[..11])).contains("line 0 of the Radiance file is incomplete"));
    assert!(reason(&file("-Y 1 +X 3", &[1, 1, 1, 3, 9, 9, 9, 9])).contains("starts with a run"));
    assert!(reason(&file("-Y 1 +X 3", &[9, 9, 9, 9, 1, 1, 1, 3])).contains("too long"));
    let shifted: Vec<u8> = [[9; 4], [1, 1, 1, 0], [1, 1, 1, 1]].concat();
    assert!(Radiance::open(file("-Y 1 +X 257", &shifted), 257).is_ok());
    let endless: Vec<u8> = [vec![9; 4], [1, 1, 1, 0].repeat(20)].concat();
    assert!(reason(&file("-Y 1 +X 257", &endless)).contains("too long"));
}
