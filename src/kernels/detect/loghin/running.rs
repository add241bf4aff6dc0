//! Maximum of a window that runs along a line (van Herk 1992; Gil and Werman 1993).
//!
//! The work does not grow with the window.

/// For each value, the index of the first largest one within `reach` on either side.
///
/// On a `circle` the last value lies beside the first; a window that reaches all around starts at the first.
pub fn first_maxima(values: &[f32], reach: usize, circle: bool) -> Vec<u32> {
    let size = values.len();
    if circle && 2 * reach >= size {
        let best = (1..size).fold(0, |best, i| if values[i] > values[best] { i } else { best });
        return vec![best as u32; size];
    }
    // Extend the line beyond its ends.
    let reach = reach.min(size);
    let beyond = |part: &[f32]| if circle { part.to_vec() } else { vec![f32::NEG_INFINITY; part.len()] };
    let extended = [&beyond(&values[size - reach..]), values, &beyond(&values[..reach])].concat();
    // Find the maxima there, and count from where the values start.
    let mut maxima = in_windows(&extended, 2 * reach + 1);
    for i in &mut maxima {
        let place = *i as usize + size - reach;
        *i = (if place >= 2 * size {
            place - 2 * size
        } else if place >= size {
            place - size
        } else {
            place
        }) as u32;
    }
    maxima
}

/// The index of the first maximum of each window of `length` values.
fn in_windows(values: &[f32], length: usize) -> Vec<u32> {
    const NOTHING: (f32, usize) = (f32::NEG_INFINITY, 0);
    let windows = values.len() + 1 - length;
    let mut maxima = Vec::with_capacity(windows);
    let mut to_the_end = vec![NOTHING; length];
    for start in (0..windows).step_by(length) {
        // Find the maximum from each value of a block to its end.
        let (block, rest) = values[start..].split_at(length);
        let mut left = NOTHING;
        for (i, &value) in block.iter().enumerate().rev() {
            if value >= left.0 {
                left = (value, start + i);
            }
            to_the_end[i] = left;
        }
        // Each window that starts in the block ends there or in the next one: find the maximum up to its end.
        maxima.push(left.1 as u32);
        let mut right = NOTHING;
        for (i, (&value, left)) in rest.iter().zip(&to_the_end[1..]).enumerate() {
            if value > right.0 {
                right = (value, start + length + i);
            }
            maxima.push(if right.0 > left.0 { right.1 } else { left.1 } as u32);
        }
    }
    maxima
}
