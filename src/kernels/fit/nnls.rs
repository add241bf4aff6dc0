//! Non-negative least squares from inner products (Lawson and Hanson 1974, chapter 23).
//!
//! Minimise `x^T G x - 2 b^T x` where all values of x but the first few must not be negative. No renderer
//! accepts a negative lamp, and an unconstrained fit of a real map has one from the second light on.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::factors::Factors;

/// Independent columns, and the factors of their Gram matrix.
#[derive(Clone, Debug)]
pub struct Support {
    /// Their indices, in ascending order.
    pub columns: Vec<usize>,
    pub factors: Factors,
}

impl Support {
    /// Factor the Gram matrix of `columns`; `None` if they are not independent.
    pub fn new(gram: &DMatrix<f64>, columns: Vec<usize>) -> Option<Self> {
        /// Relative squared distance of a column from the span of the others at which no digit of it is left.
        const DEPENDENT: f64 = 1e-12;
        let part = |count| DMatrix::from_fn(count, count, |i, j| gram[(columns[i], columns[j])]);
        let is_all = columns.len() == gram.ncols();
        let factors = Factors::new(if is_all { gram.clone() } else { part(columns.len()) })?;
        let mut pivots = columns.iter().zip(factors.pivots());
        let are_independent = pivots.all(|(&column, &pivot)| pivot > DEPENDENT * gram[(column, column)]);
        are_independent.then_some(Self { columns, factors })
    }

    /// The unconstrained minimum over the columns; other values are 0.
    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut x = right.to_vec();
        if self.columns.len() == right.len() {
            self.factors.solve(&mut x);
            return x;
        }
        let mut values: Vec<f64> = self.columns.iter().map(|&i| right[i]).collect();
        self.factors.solve(&mut values);
        x.fill(0.0);
        self.columns.iter().zip(values).for_each(|(&column, value)| x[column] = value);
        x
    }
}

/// Solution, and the columns with nonzero unknowns.
type Answer = (Vec<f64>, Arc<Support>);

/// Solution for each column of `right`, and its support. The first `free` unknowns may be negative.
///
/// `guess` holds initial supports, if any. Columns of `right` with equal supports share one object.
pub fn solve(
    gram: &DMatrix<f64>,
    right: &DMatrix<f64>,
    free: usize,
    guess: &[Arc<Support>],
) -> (DMatrix<f64>, Vec<Arc<Support>>) {
    let mut x = DMatrix::zeros(right.nrows(), right.ncols());
    let mut known: Vec<Arc<Support>> = Vec::with_capacity(right.ncols());
    let mut supports = Vec::with_capacity(right.ncols());
    let all: Vec<usize> = (0..right.nrows()).collect();
    for (i, (mut x, right)) in x.column_iter_mut().zip(right.column_iter()).enumerate() {
        let right = right.as_slice();
        let guess = guess.get(i).map_or(&all, |guess| &guess.columns);
        let (values, support) = block_pivoting(gram, right, free, guess, &mut known)
            .unwrap_or_else(|| active_set(gram, right, free));
        x.copy_from_slice(&values);
        supports.push(support);
    }
    (x, supports)
}

/// Block principal pivoting (Portugal, Júdice and Vicente 1994): remove all negative columns and add all that lower the
/// cost, until there are none. `None` if that takes too many rounds.
///
/// Each support that is factored joins the `known` ones.
fn block_pivoting(
    gram: &DMatrix<f64>,
    right: &[f64],
    free: usize,
    guess: &[usize],
    known: &mut Vec<Arc<Support>>,
) -> Option<Answer> {
    const ROUNDS: usize = 5;
    let mut support = shared_support(gram, guess, known)?;
    for _ in 0..ROUNDS {
        let x = support.solve(right);
        let is_next = |&column: &usize| {
            let is_in = || support.columns.binary_search(&column).is_ok();
            column < free || x[column] > 0.0 || !is_in() && fall(gram, right, &x, column).is_some()
        };
        let next = (0..right.len()).filter(is_next);
        if next.clone().eq(support.columns.iter().copied()) {
            return Some((x, support));
        }
        support = shared_support(gram, &next.collect::<Vec<usize>>(), known)?;
    }
    None
}

/// The support of `columns`: one of the `known` ones, or a new one that joins them.
fn shared_support(
    gram: &DMatrix<f64>,
    columns: &[usize],
    known: &mut Vec<Arc<Support>>,
) -> Option<Arc<Support>> {
    if let Some(support) = known.iter().find(|support| support.columns == columns) {
        return Some(support.clone());
    }
    let support = Arc::new(Support::new(gram, columns.to_vec())?);
    known.push(support.clone());
    Some(support)
}

/// The active-set method of Lawson and Hanson, which always ends.
fn active_set(gram: &DMatrix<f64>, right: &[f64], free: usize) -> Answer {
    let nothing = || Support { columns: Vec::new(), factors: Factors::default() };
    let mut support = Support::new(gram, (0..free).collect()).unwrap_or_else(nothing);
    let mut x = support.solve(right);
    // Refuse columns that leave at once, because only rounding lowers the cost along them.
    let mut refused: Vec<usize> = Vec::new();
    while let Some(next) = steepest(gram, right, &x, &support.columns, &refused) {
        let mut active = support.columns.clone();
        active.insert(active.partition_point(|&column| column < next), next);
        let Some((moved, smaller)) = retreat(gram, right, &x, active, free) else {
            refused.push(next);
            continue;
        };
        (x, support) = (moved, smaller);
        if support.columns.contains(&next) {
            refused.clear();
        } else {
            refused.push(next);
        }
    }
    (x, Arc::new(support))
}

/// The column outside `active` along which the cost falls fastest; `None` if it falls along none.
fn steepest(
    gram: &DMatrix<f64>,
    right: &[f64],
    x: &[f64],
    active: &[usize],
    refused: &[usize],
) -> Option<usize> {
    let candidates = (0..right.len()).filter(|column| !active.contains(column) && !refused.contains(column));
    let falling = candidates.filter_map(|column| fall(gram, right, x, column).map(|fall| (column, fall)));
    falling.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(column, _)| column)
}

/// Decrease of the cost along a column of unit length; `None` if the cost does not decrease.
fn fall(gram: &DMatrix<f64>, right: &[f64], x: &[f64], column: usize) -> Option<f64> {
    const ROUNDING: f64 = 1e-13;
    let own = &gram.as_slice()[column * right.len()..(column + 1) * right.len()];
    let fall = right[column] - own.iter().zip(x).map(|(g, x)| g * x).sum::<f64>();
    (own[column] > 0.0 && fall > ROUNDING * right[column].abs()).then(|| fall / own[column].sqrt())
}

/// Move from `x` towards the minimum over the active columns, and remove those that reach 0 first.
fn retreat(
    gram: &DMatrix<f64>,
    right: &[f64],
    x: &[f64],
    mut active: Vec<usize>,
    free: usize,
) -> Option<(Vec<f64>, Support)> {
    let mut x = x.to_vec();
    loop {
        let support = Support::new(gram, active)?;
        let goal = support.solve(right);
        let step = support
            .columns
            .iter()
            .filter(|&&column| column >= free && goal[column] <= 0.0)
            .map(|&column| x[column] / (x[column] - goal[column]))
            .fold(f64::INFINITY, f64::min);
        if step == f64::INFINITY {
            return Some((goal, support));
        }
        x.iter_mut().zip(&goal).for_each(|(x, goal)| *x += (goal - *x) * step);
        active = support.columns;
        active
            .retain(|&column| column < free || goal[column] > 0.0 || x[column] > 1e-15 * goal[column].abs());
        for column in (0..x.len()).filter(|column| !active.contains(column)) {
            x[column] = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Karush-Kuhn-Tucker conditions: positive values have no gradient, and the cost grows along all others.
    fn assert_optimal(gram: &DMatrix<f64>, right: &DMatrix<f64>, x: &[f64], support: &Support) {
        let fall = right - gram * DMatrix::from_column_slice(x.len(), 1, x);
        for i in 0..x.len() {
            assert!(x[i] >= 0.0, "{x:?}");
            assert!(fall[i] < 1e-8, "{fall}");
            assert!((fall[i] * x[i]).abs() < 1e-7, "{fall} {x:?}");
            assert_eq!(support.columns.contains(&i), x[i] > 0.0, "{x:?}");
        }
    }

    proptest! {
        #[test]
        fn the_answer_is_optimal_from_any_guess(
            columns in proptest::collection::vec(0.0..1.0_f64, 40),
            target in proptest::collection::vec(-1.0..1.0_f64, 8),
            guess in proptest::collection::vec(proptest::bool::ANY, 5),
        ) {
            let a = DMatrix::from_vec(8, 5, columns);
            let (gram, right) = (a.tr_mul(&a), a.tr_mul(&DMatrix::from_vec(8, 1, target)));
            let guess: Vec<usize> = (0..5).filter(|&i| guess[i]).collect();
            let guess = Support::new(&gram, guess).map(Arc::new);
            for guess in [Vec::new(), guess.into_iter().collect()] {
                let (x, supports) = solve(&gram, &right, 0, &guess);
                assert_optimal(&gram, &right, x.as_slice(), &supports[0]);
            }
            let (x, support) = active_set(&gram, right.as_slice(), 0);
            assert_optimal(&gram, &right, &x, &support);
        }

        #[test]
        fn twin_columns_do_no_harm(right in 0.1..2.0_f64) {
            let gram = DMatrix::from_element(2, 2, 1.0);
            let (x, _) = solve(&gram, &DMatrix::from_element(2, 1, right), 0, &[]);
            prop_assert!((x.sum() - right).abs() < 1e-12, "{x}");
        }
    }
}
