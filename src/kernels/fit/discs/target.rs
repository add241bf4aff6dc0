//! The map to which lights are compared, and their inner products with it and with each other.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::chord::mean_distance;
use super::high_degrees::HighDegrees;
use super::patches::{Patches, distances};
use super::zonal::Kernel;
use crate::kernels::expansion::{Cap, DEGREE, DiscSum, Harmonics};
use crate::kernels::fit::ambient::Ambient;
use crate::kernels::fit::comparison::Comparison;
use crate::kernels::fit::jet::Jet;
use crate::kernels::fit::light_disc::{Disc, on_tangents};
use crate::kernels::fit::objective::Reference;
use crate::kernels::fit::picture::{Patch, Picture};
use crate::kernels::harmonics::{cosine_lobe, irradiance_of_moments, radiance};

/// Discs that are done at a time: the vectors of most processors hold as many numbers.
const BLOCK: usize = 4;

/// The map under one kernel, and the ambient term that may explain it.
#[derive(Clone, Debug)]
pub struct Target {
    kernel: Kernel,
    ambient: Ambient,
    /// The sky over a floor, where there is one.
    half_sky: Option<Disc>,
    patches: Patches,
    /// The map times the kernel, but for the cones of the patches.
    field: Harmonics,
    /// `<L, L>` by channel.
    pub energy: [f64; 3],
    /// The bright parts in the degrees above the harmonics, for errors of the probe.
    pub high_degrees: Option<HighDegrees>,
    /// Products of the ambient columns with each other, and with the three channels.
    ambient_products: DMatrix<f64>,
}

impl Target {
    pub fn new(picture: &Picture, comparison: Comparison, ambient: Ambient, has_floor: bool) -> Self {
        let Picture { rest, patches, bright, .. } = picture;
        let kernel = Kernel::new(comparison);
        let field = rest.scaled_sum(&kernel.whole, bright, &kernel.smooth);
        let half_sky = (has_floor && ambient == Ambient::Constant).then(|| Disc::new(DVec3::Y, FRAC_PI_2));
        let ambient_products = DMatrix::zeros(ambient.coefficients(), ambient.coefficients() + 3);
        let is_probe = comparison == Comparison::Probe;
        let high_degrees = is_probe.then(|| HighDegrees::new(patches.iter().map(Patch::disc)));
        let (patches, energy) = (Patches::new(patches), [0.0; 3]);
        let mut target =
            Self { kernel, ambient, half_sky, patches, field, energy, high_degrees, ambient_products };
        target.energy = target.energy(picture);
        target.set_ambient_products(picture);
        target
    }

    /// `<L, L>`. What is finer than the harmonics of the rest falls off with the degree as `k^-2`, and the kernel as
    /// `k^-3`: it counts a quarter of what it would in the last degree.
    fn energy(&self, picture: &Picture) -> [f64; 3] {
        let Picture { rest, bright, fine, patches, .. } = picture;
        let Kernel { whole, smooth, cone, .. } = &self.kernel;
        let [rests, mixed, brights] =
            [rest.product(rest, whole), rest.product(bright, whole), bright.product(bright, smooth)];
        let last = 0.5 * (whole[DEGREE] + whole[DEGREE - 1]);
        let smooth = [0, 1, 2].map(|c| rests[c] + 2.0 * mixed[c] + brights[c] + 0.25 * last * fine[c]);
        if *cone <= 0.0 {
            return smooth;
        }
        let distances = picture.distances.get_or_init(|| distances(patches));
        [0, 1, 2].map(|c| smooth[c] - cone * distances[c])
    }

    fn set_ambient_products(&mut self, picture: &Picture) {
        let ambient = self.ambient.coefficients();
        let mut out = DMatrix::zeros(ambient, ambient + 3);
        let beside_pole = [1e-9, -1e-9].map(|x| Disc::new(DVec3::new(x, 1.0, 0.0), FRAC_PI_2));
        let beside_pole = if self.half_sky.is_some() { self.values(&beside_pole) } else { Vec::new() };
        for channel in 0..3 {
            let [rest, bright] = [&picture.rest, &picture.bright].map(|part| part.moments(channel));
            let (whole, first, second) = (rest.0 + bright.0, rest.1 + bright.1, rest.2 + bright.2);
            let harmonics = irradiance_of_moments(whole, first, second);
            for i in 0..ambient {
                out[(i, ambient + channel)] = match (&self.half_sky, self.ambient) {
                    // Two discs beside the pole: a disc at it is drawn 1e-5 away.
                    (Some(_), _) => PI * beside_pole.iter().map(|sky| sky.value[channel]).sum::<f64>(),
                    (_, Ambient::Sh2) => self.kernel.whole[degree(i)] * harmonics[i] / cosine_lobe(i),
                    _ => self.kernel.whole[0] * whole,
                };
            }
        }
        for i in 0..ambient {
            out[(i, i)] = match (&self.half_sky, self.ambient) {
                (Some(sky), _) => (2.0 * PI).powi(2) * self.pair::<0>(sky, sky).value,
                (_, Ambient::Sh2) => self.kernel.whole[degree(i)],
                _ => 4.0 * PI * self.kernel.whole[0],
            };
        }
        self.ambient_products = out;
    }

    /// Gram matrix of the ambient columns and of `discs` of flux 1, and their products with the three channels.
    pub fn products(&self, discs: &[Disc]) -> (DMatrix<f64>, DMatrix<f64>) {
        let ambient = self.ambient.coefficients();
        let size = ambient + discs.len();
        let (mut gram, mut rhs) = (DMatrix::zeros(size, size), DMatrix::zeros(size, 3));
        gram.view_mut((0, 0), (ambient, ambient)).copy_from(&self.ambient_products.columns(0, ambient));
        rhs.rows_mut(0, ambient).copy_from(&self.ambient_products.columns(ambient, 3));
        let sides = self.values(discs);
        for (j, (disc, sides)) in discs.iter().zip(&sides).enumerate() {
            let row = ambient + j;
            (0..3).for_each(|channel| rhs[(row, channel)] = sides.value[channel]);
            for (column, product) in self.with_ambient(disc).iter().enumerate() {
                (gram[(row, column)], gram[(column, row)]) = (product.value, product.value);
            }
            for (k, other) in discs[..=j].iter().enumerate() {
                let product = self.pair::<0>(disc, other).value;
                (gram[(row, ambient + k)], gram[(ambient + k, row)]) = (product, product);
            }
        }
        (gram, rhs)
    }

    /// The fall of the cost if one of some candidates, alone, joins the `discs` with the coefficients `x`, which stay.
    ///
    /// Each of the `candidates` is a disc and its products with the map.
    pub fn falls<'a>(
        &self,
        reference: &Reference,
        candidates: impl Iterator<Item = (&'a Disc, &'a DiscSum)>,
        discs: &[Disc],
        x: &DMatrix<f64>,
    ) -> Vec<f64> {
        let fall = |(candidate, sides): (&Disc, &DiscSum)| {
            let with_ambient = self.with_ambient(candidate).into_iter().map(|product| product.value);
            let with_discs = discs.iter().map(|disc| self.pair::<0>(candidate, disc).value);
            let products: Vec<f64> = with_ambient.chain(with_discs).collect();
            let square = |c: usize| {
                let explained: f64 = products.iter().zip(&x.column(c)).map(|(product, x)| product * x).sum();
                reference.copies(c) * (sides.value[reference.channels[c]] - explained).max(0.0).powi(2)
            };
            let own = self.pair::<0>(candidate, candidate).value;
            (0..reference.channels.len()).map(square).sum::<f64>() / own
        };
        candidates.map(fall).collect()
    }

    /// Products of discs with the map.
    pub fn values(&self, discs: &[Disc]) -> Vec<DiscSum> {
        self.sides::<0>(discs, &vec![[0.0; 3]; discs.len()])
    }

    /// Products of discs with the map and their derivatives, for each disc second ones of the channels with its `shares`.
    pub fn sides_around(&self, discs: &[Disc], shares: &[[f64; 3]]) -> Vec<DiscSum> {
        self.sides::<2>(discs, shares)
    }

    /// Products of discs with the map; if N is 2, with derivatives.
    fn sides<const N: usize>(&self, discs: &[Disc], shares: &[[f64; 3]]) -> Vec<DiscSum> {
        let caps: Vec<Cap> = discs.iter().map(|disc| disc.cap).collect();
        let blocks = caps.par_chunks(BLOCK).zip(shares.par_chunks(BLOCK));
        let smooth = || blocks.flat_map_iter(|(caps, shares)| self.field.sums::<N>(caps, shares)).collect();
        if self.kernel.cone <= 0.0 {
            return smooth();
        }
        let around = |(cap, &shares): (&Cap, &[f64; 3])| self.patches.distances_to::<N>(cap, shares);
        let distances = || caps.par_iter().zip(shares).map(around).collect();
        let (mut sums, distances): (Vec<DiscSum>, Vec<DiscSum>) = rayon::join(smooth, distances);
        for (sum, distances) in sums.iter_mut().zip(&distances) {
            sum.add(distances, -self.kernel.cone);
        }
        sums
    }

    /// Product of a disc of flux 1 with itself, as a function of A.
    pub fn square(&self, disc: &Disc) -> Jet<1> {
        let Jet { value, first, second } = self.pair::<3>(disc, disc);
        // Both discs grow.
        let bend = second[1][1] + 2.0 * second[1][2] + second[2][2];
        Jet { value, first: [first[1] + first[2]], second: [[bend]] }
    }

    /// Product of two discs of flux 1; if N is 3, with derivatives by the cosine between them and by the A of each.
    pub fn pair<const N: usize>(&self, one: &Disc, other: &Disc) -> Jet<N> {
        let cosine = one.direction.dot(other.direction).min(1.0);
        let smooth = self.kernel.smooth_product(cosine, &one.factors, &other.factors);
        let [c, a, b] =
            [(cosine, 0), (one.share, 1), (other.share, 2)].map(|(value, i)| Jet::variable(value, i));
        smooth - mean_distance(c, a, b) * self.kernel.cone
    }

    /// Products of a disc of flux 1 with each ambient column, and their derivatives by its coordinates.
    pub fn with_ambient(&self, disc: &Disc) -> Vec<Jet<3>> {
        match (&self.half_sky, self.ambient) {
            (_, Ambient::None) => Vec::new(),
            (Some(sky), _) => {
                let product = self.pair::<3>(disc, sky) * (2.0 * PI);
                let [c, a, _] = [0, 1, 2];
                let own = Jet {
                    value: product.value,
                    first: [product.first[c], product.first[a]],
                    second: [c, a].map(|i| [c, a].map(|k| product.second[i][k])),
                };
                let along = disc.frame().map(|tangent| tangent.dot(sky.direction));
                vec![on_tangents(&own, disc.direction.dot(sky.direction), along)]
            }
            (_, Ambient::Constant) => vec![Jet::constant(self.kernel.whole[0])],
            (_, Ambient::Sh2) => {
                let harmonics = harmonics_around(disc);
                let of_degree = |i: usize| {
                    let [value, slope, bend] = disc.factors[degree(i)];
                    let mut factor = Jet::variable(value, 2);
                    (factor.first[2], factor.second[2][2]) = (slope, bend);
                    harmonics[i] * factor * self.kernel.whole[degree(i)]
                };
                (0..9).map(of_degree).collect()
            }
        }
    }
}

/// Degree of the i-th harmonic of [`Ambient::Sh2`].
fn degree(i: usize) -> usize {
    i.isqrt()
}

/// The nine harmonics by the tangent coordinates of a disc. They are polynomials of degree 2, so differences are exact.
fn harmonics_around(disc: &Disc) -> [Jet<3>; 9] {
    let (l, [s, t]) = (disc.direction, disc.frame());
    let [here, there, origin] = [radiance(l), radiance(2.0 * l), radiance(DVec3::ZERO)];
    let ahead = [s, t].map(|along| radiance(l + along));
    let behind = [s, t].map(|along| radiance(l - along));
    let both = radiance(l + s + t);
    std::array::from_fn(|i| {
        let first = [0, 1].map(|k| 0.5 * (ahead[k][i] - behind[k][i]));
        let bend = [0, 1].map(|k| ahead[k][i] + behind[k][i] - 2.0 * here[i]);
        let mixed = both[i] - ahead[0][i] - ahead[1][i] + here[i];
        // The sphere bends away from its tangents, where the polynomial has this slope outward.
        let outward = 0.5 * (there[i] - origin[i]);
        Jet {
            value: here[i],
            first: [first[0], first[1], 0.0],
            second: [[bend[0] - outward, mixed, 0.0], [mixed, bend[1] - outward, 0.0], [0.0; 3]],
        }
    })
}
