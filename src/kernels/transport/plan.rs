//! The plan of a transport between two sets of directions, and the assignment as a transport of single units.

use glam::DVec3;
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};

use super::spanning_tree::cheapest_flows;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::kernels::sphere::{check_lengths, check_memory, check_not_negative, check_rows, unit_vectors};

/// Units of mass of a whole set: its weights are rounded to 1e-18 of their sum.
const WHOLE: i64 = 1 << 60;

/// Largest share that the plan leaves out, in units of mass: 1e-14. Equal weights that differ by rounding would fill
/// the plan with such pairs.
const ROUNDING: i64 = WHOLE / 100_000_000_000_000;

/// Movement of mass at the least mean angle.
pub struct TransportPlan {
    /// Mean angle in radians, weighted by the shares: the Wasserstein distance W1.
    pub mean_angle: f64,
    /// Rows of the sets that mass moves between, (k, 2), in rising order.
    pub pairs: Array2<i64>,
    /// Moved share of each pair, above 1e-14; their sum is 1 up to that.
    pub shares: Vec<f64>,
}

/// Optimal transport of the shares of `from_weights` to those of `to_weights`.
///
/// The cost of a pair is the angle between its directions, (n, 3) and (m, 3). The plan has at most n + m - 1 pairs.
/// Its mean square angle is the least among plans of this cost. A weight of 0 takes no part.
///
/// # Errors
///
/// [`Error::WrongColumns`], [`Error::NotFinite`], [`Error::NotUnit`], [`Error::LengthMismatch`], [`Error::Negative`];
/// [`Error::NoWeight`] if no weight of a set is above 0; [`Error::NoMemory`].
pub fn transport_plan(
    from: ArrayView2<'_, f64>,
    from_weights: ArrayView1<'_, f64>,
    to: ArrayView2<'_, f64>,
    to_weights: ArrayView1<'_, f64>,
) -> Result<TransportPlan> {
    let source = MassSet::new(["from_directions", "from_weights"], from, from_weights)?;
    let sink = MassSet::new(["to_directions", "to_weights"], to, to_weights)?;
    let angles = angles_between(&source.directions, &sink.directions)?;
    let mut flows = cheapest_flows(angles.view(), &source.units, &sink.units);
    flows.retain(|&(_, units)| units > ROUNDING);
    let pairs = flows.iter().map(|&((i, j), _)| [source.rows[i], sink.rows[j]]);
    let shares: Vec<f64> = flows.iter().map(|&(_, units)| units as f64 / WHOLE as f64).collect();
    let moved = flows.iter().zip(&shares).map(|(&(arc, _), share)| angles[arc] * share);
    Ok(TransportPlan { mean_angle: moved.sum(), pairs: Array2::from(pairs.collect::<Vec<_>>()), shares })
}

/// Column of each row in an assignment with the least sum of costs, for a square table.
///
/// # Errors
///
/// [`Error::WrongColumns`] if there are not as many columns as rows; [`Error::NotFinite`].
pub fn assignment(costs: ArrayView2<'_, f64>) -> Result<Vec<i64>> {
    let size = costs.nrows();
    check_rows("costs", costs, size)?;
    if size == 0 {
        return Ok(vec![]);
    }
    let flows = cheapest_flows(costs, &vec![1; size], &vec![1; size]);
    Ok(flows.iter().map(|&((_, column), _)| column as i64).collect())
}

/// Directions with mass.
struct MassSet {
    /// Rows of the argument.
    rows: Vec<i64>,
    /// Unit vectors.
    directions: Vec<DVec3>,
    /// Units of mass, above 0; [`WHOLE`] together.
    units: Vec<i64>,
}

impl MassSet {
    /// Check both arguments, and leave out the rows without mass.
    fn new(
        [name, name_of_weights]: [&'static str; 2],
        directions: ArrayView2<'_, f64>,
        weights: ArrayView1<'_, f64>,
    ) -> Result<Self> {
        let directions = unit_vectors(name, directions)?;
        check_rows(name_of_weights, weights.insert_axis(Axis(1)), 1)?;
        check_lengths(name, directions.len(), [(name_of_weights, weights.len())])?;
        check_not_negative(name_of_weights, weights.iter().copied())?;
        let units = whole_units(weights).ok_or(Error::NoWeight { what: name_of_weights })?;
        let rows: Vec<usize> = (0..units.len()).filter(|&row| units[row] > 0).collect();
        Ok(Self {
            directions: rows.iter().map(|&row| directions[row]).collect(),
            units: rows.iter().map(|&row| units[row]).collect(),
            rows: rows.iter().map(|&row| row as i64).collect(),
        })
    }
}

/// Units of mass of each weight; `None` if all weights are 0.
fn whole_units(weights: ArrayView1<'_, f64>) -> Option<Vec<i64>> {
    let largest = weights.iter().copied().fold(0.0, f64::max);
    let heaviest = weights.iter().position(|&weight| weight >= largest).filter(|_| largest > 0.0)?;
    // Divide by the largest weight first: the sum of weights may overflow.
    let whole: f64 = weights.iter().map(|weight| weight / largest).sum();
    let share = |weight: &f64| weight / largest / whole;
    let mut units: Vec<i64> =
        weights.iter().map(|weight| (share(weight) * WHOLE as f64).round() as i64).collect();
    // Give the remainder of rounding to the heaviest, whose share it changes by less than 1e-15.
    units[heaviest] += WHOLE - units.iter().sum::<i64>();
    Some(units)
}

/// Angle in radians between each direction of `from` and each of `to`, (n, m).
///
/// The arctangent of both products keeps all digits; the arccosine loses half of them near 0 and pi.
fn angles_between(from: &[DVec3], to: &[DVec3]) -> Result<Array2<f64>> {
    // Of the angles, and later of their squares.
    check_memory(&[from.len(), to.len(), 2])?;
    let mut angles = Array2::zeros((from.len(), to.len()));
    for (mut row, &one) in angles.outer_iter_mut().zip(from) {
        interrupt::check();
        row.iter_mut()
            .zip(to)
            .for_each(|(angle, &other)| *angle = one.cross(other).length().atan2(one.dot(other)));
    }
    Ok(angles)
}
