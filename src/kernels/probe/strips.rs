//! The horizon of a ring of normals across the rows.
//!
//! Normals of one height see the same width of a row. So the half-width h, the columns that it cuts and
//! what they count are found once for the ring. Over a strip of polar angles, with the exact integrals e of
//! sin^2 theta and p of sin theta cos theta,
//!
//! ```text
//!   integral of n.w = integral of L (n_e e cos psi + n_y p) dpsi over -h .. h,   psi = phi - phi_n
//!   cos h           = -n_y p / (n_e e)          where the integrand changes its sign: the best single h
//! ```
//!
//! The true horizon leaves h by up to half its own spread `H` over the strip. As the integrand falls to 0 at
//! h with the slope `k = n_e e sin h`, each end of the interval lacks
//!
//! ```text
//!   mean of k (h(theta) - h)^2 / 2 = k H^2 / 24
//! ```
//!
//! times the radiance there. A row that the horizon crosses over many columns is cut into several strips.

use std::ops::Range;

use super::even::EvenColumns;
use super::horizon::row_integrals;

/// Columns that the horizon crosses in one strip, at most. With 1 the irradiance of 64 columns is exact to 1e-6
/// instead of 5e-6, and takes an eighth more time.
const COLUMNS_OF_A_STRIP: f64 = 2.0;

/// Normals of one height, some whole columns apart.
pub struct Ring {
    /// `n_y`.
    pub height: f64,
    /// `n_e`, the length of `(n_x, n_z)`.
    pub radius: f64,
    /// Place of the first normal, in columns from the first edge.
    pub start: f64,
    /// Solid angle that each of its normals stands for.
    pub solid_angle: f64,
}

/// What a ring sees of a strip, its horizon included. Columns are counted as the first normal sees them.
pub struct Strip {
    /// The columns that its horizon cuts; the flux is taken from the left edges of both.
    pub first: isize,
    pub last: isize,
    /// Weight of the integrals of L cos phi and L sin phi: e.
    pub equatorial: f64,
    /// Weight of the integral of L: `n_y p`.
    pub polar: f64,
    /// Weight of the radiance of the two columns: what their parts count.
    pub at_first: f64,
    pub at_last: f64,
}

/// What a ring sees of a row.
pub struct RowView {
    /// The strips that its horizon cuts.
    pub strips: Range<usize>,
    /// Weights of all that is in front of the horizon, as those of a strip.
    pub equatorial: f64,
    pub polar: f64,
}

/// What a ring sees of each row.
pub struct View {
    pub strips: Vec<Strip>,
    pub rows: Vec<RowView>,
}

impl Ring {
    pub fn view(&self, theta_edges: &[f64], columns: &EvenColumns) -> View {
        let half_widths: Vec<f64> = theta_edges.iter().map(|&theta| self.half_width(theta)).collect();
        let mut view = View { strips: Vec::new(), rows: Vec::new() };
        for (theta, half_widths) in theta_edges.windows(2).zip(half_widths.windows(2)) {
            view.add_row(self, [theta[0], theta[1]], [half_widths[0], half_widths[1]], columns);
        }
        view
    }

    /// Half the width of what it sees at the polar angle `theta`.
    fn half_width(&self, theta: f64) -> f64 {
        (-self.height / (self.radius * theta.tan())).clamp(-1.0, 1.0).acos()
    }

    /// The strip of the weights e and `n_y p` that it sees up to the `cosine` of h, the true horizon
    /// being spread over `spread`.
    fn strip(&self, [e, polar]: [f64; 2], cosine: f64, spread: f64, columns: &EvenColumns) -> Strip {
        let (half_width, sine) = (cosine.acos(), (1.0 - cosine * cosine).sqrt());
        let bend = self.radius * e * sine * spread * spread / 24.0;
        // Find the columns that the horizon cuts, and how far it is from their left edges.
        let places = [self.start - half_width / columns.width, self.start + half_width / columns.width];
        let cut = places.map(f64::floor);
        let parts = [0, 1].map(|end| (places[end] - cut[end]) * columns.width);
        // Integrate n.w over a part that ends where psi has the sine.
        let integral = |part: f64, sine: f64| {
            let (sin_part, cos_part) = part.sin_cos();
            self.radius * e * (sine * (1.0 - cos_part) + cosine * sin_part) + polar * part
        };
        Strip {
            first: cut[0] as isize,
            last: cut[1] as isize,
            equatorial: e,
            polar,
            at_first: bend - integral(parts[0], -sine),
            at_last: bend + integral(parts[1], sine),
        }
    }
}

impl View {
    /// Add the row between two polar angles, at which the ring sees `half_widths`.
    fn add_row(&mut self, ring: &Ring, theta: [f64; 2], half_widths: [f64; 2], columns: &EvenColumns) {
        let mut row = RowView { strips: self.strips.len()..0, equatorial: 0.0, polar: 0.0 };
        // Cut the row into strips of one height.
        let crossed = (half_widths[0] - half_widths[1]).abs() / columns.width;
        let strips = (crossed / COLUMNS_OF_A_STRIP).ceil().max(1.0);
        let edge = |i: f64| theta[0] + (theta[1] - theta[0]) * i / strips;
        let mut above = half_widths[0];
        for i in 1..=strips as usize {
            let is_last = i == strips as usize;
            let below = if is_last { half_widths[1] } else { ring.half_width(edge(i as f64)) };
            let [e, p] = row_integrals(edge(i as f64 - 1.0), edge(i as f64));
            let polar = ring.height * p;
            // Take all of it, nothing, or what is in front of the horizon.
            let cosine = -polar / (ring.radius * e);
            if cosine <= -1.0 {
                row.equatorial += e;
                row.polar += polar;
            } else if cosine < 1.0 {
                self.strips.push(ring.strip([e, polar], cosine, above - below, columns));
            }
            above = below;
        }
        row.strips.end = self.strips.len();
        self.rows.push(row);
    }
}
