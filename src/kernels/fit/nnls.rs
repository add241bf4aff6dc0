//! Non-negative least squares from inner products (Lawson and Hanson 1974, chapter 23).
//!
//! Minimise `x^T G x - 2 b^T x`, of which all but the first few values may not be negative. No renderer
//! takes a negative lamp, and an unconstrained fit of a real map asks for one from the second light on.

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn, U1};

/// Part of a matrix, or all of it.
pub type View<'a> = DMatrixView<'a, f64, U1, Dyn>;

/// The minimiser for each column of `right`; the first `free` values of it may have any sign.
pub fn solve(gram: &View<'_>, right: &View<'_>, free: usize) -> DMatrix<f64> {
    let all: Vec<usize> = (0..gram.nrows()).collect();
    // Most often nothing wants to be negative, and one factorisation is all it takes.
    let mut solution = factor(gram, &all).map(|factor| factor.solve(right));
    let x = solution.get_or_insert_with(|| DMatrix::repeat(gram.nrows(), right.ncols(), f64::NAN));
    for (mut x, right) in x.column_iter_mut().zip(right.column_iter()) {
        if !x.iter().skip(free).all(|&value| value >= 0.0) {
            let right = right.into_owned();
            let guess = without_negative(gram, &right, x.clone_owned(), free);
            x.copy_from(&guess.unwrap_or_else(|| active_set(gram, &right, free)));
        }
    }
    solution.unwrap_or_default()
}

/// What is left when all that wants to be negative goes at once, again and again, if that is the
/// minimum: if nothing that went would lower the cost by coming back.
fn without_negative(
    gram: &View<'_>,
    right: &DVector<f64>,
    mut x: DVector<f64>,
    free: usize,
) -> Option<DVector<f64>> {
    let mut active: Vec<usize> = (0..x.len()).collect();
    let is_kept = |x: &DVector<f64>, column: usize| column < free || x[column] > 0.0;
    while !active.iter().all(|&column| is_kept(&x, column)) {
        active.retain(|&column| is_kept(&x, column));
        x = on(gram, right, &active)?;
    }
    steepest(gram, right, &x, &active, &[]).is_none().then_some(x)
}

fn active_set(gram: &View<'_>, right: &DVector<f64>, free: usize) -> DVector<f64> {
    let mut active: Vec<usize> = (0..free).collect();
    let mut x = on(gram, right, &active).unwrap_or_else(|| DVector::zeros(right.len()));
    // Columns that were let in and came out at once: rounding, not descent.
    let mut refused: Vec<usize> = Vec::new();
    while let Some(next) = steepest(gram, right, &x, &active, &refused) {
        active.push(next);
        let Some(moved) = retreat(gram, right, &x, &mut active, free) else {
            active.retain(|&column| column != next);
            refused.push(next);
            continue;
        };
        x = moved;
        if active.contains(&next) {
            refused.clear();
        } else {
            refused.push(next);
        }
    }
    x
}

/// The column outside `active` along which the cost falls fastest, if it falls at all.
fn steepest(
    gram: &View<'_>,
    right: &DVector<f64>,
    x: &DVector<f64>,
    active: &[usize],
    refused: &[usize],
) -> Option<usize> {
    const ROUNDING: f64 = 1e-13;
    let fall = right - gram * x;
    // Per length of the column, so that the choice does not depend on the unit of a column.
    let rate = |&column: &usize| fall[column] / gram[(column, column)].sqrt().max(f64::MIN_POSITIVE);
    let floor = |column: usize| ROUNDING * right[column].abs();
    (0..right.len())
        .filter(|column| !active.contains(column) && !refused.contains(column))
        .filter(|&column| gram[(column, column)] > 0.0 && fall[column] > floor(column))
        .max_by(|a, b| rate(a).total_cmp(&rate(b)))
}

/// From `x` towards the minimum on the active columns, giving up those that reach 0 on the way.
fn retreat(
    gram: &View<'_>,
    right: &DVector<f64>,
    x: &DVector<f64>,
    active: &mut Vec<usize>,
    free: usize,
) -> Option<DVector<f64>> {
    let mut x = x.clone();
    loop {
        let goal = on(gram, right, active)?;
        let share = active
            .iter()
            .filter(|&&column| column >= free && goal[column] <= 0.0)
            .map(|&column| x[column] / (x[column] - goal[column]))
            .fold(f64::INFINITY, f64::min);
        if share == f64::INFINITY {
            return Some(goal);
        }
        x += (&goal - &x) * share;
        active
            .retain(|&column| column < free || goal[column] > 0.0 || x[column] > 1e-15 * goal[column].abs());
        for column in (0..x.len()).filter(|column| !active.contains(column)) {
            x[column] = 0.0;
        }
    }
}

/// The unconstrained minimum over `columns`, 0 elsewhere; none where they are not independent.
fn on(gram: &View<'_>, right: &DVector<f64>, columns: &[usize]) -> Option<DVector<f64>> {
    let solved = factor(gram, columns)?.solve(&DVector::from_fn(columns.len(), |i, _| right[columns[i]]));
    let mut x = DVector::zeros(right.len());
    for (value, &column) in solved.iter().zip(columns) {
        x[column] = *value;
    }
    Some(x)
}

/// Cholesky factor of the Gram matrix of `columns`; none where they are not independent.
pub fn factor(gram: &View<'_>, columns: &[usize]) -> Option<Cholesky<f64, Dyn>> {
    /// A column this close to the span of the others has lost all its digits.
    const DEPENDENT: f64 = 1e-12;
    let size = columns.len();
    let part = DMatrix::from_fn(size, size, |i, j| gram[(columns[i], columns[j])]);
    let factor = Cholesky::new(part)?;
    let lower = factor.l_dirty();
    let independent = |i: usize| lower[(i, i)] * lower[(i, i)] > DEPENDENT * gram[(columns[i], columns[i])];
    (0..size).all(independent).then_some(factor)
}

/// `rows L^-T` with the factor `L` of a Gram matrix `A^T A`: inner products with the columns of A become
/// those with the orthonormal columns `A L^-T` that span the same.
///
/// All rows at once, column by column: each column is long, the triangle is small.
pub fn orthonormal(factor: &Cholesky<f64, Dyn>, mut rows: DMatrix<f64>) -> DMatrix<f64> {
    let lower = factor.l_dirty();
    for i in 0..lower.nrows() {
        let (done, mut rest) = rows.columns_range_pair_mut(..i, i..);
        let mut column = rest.column_mut(0);
        for (k, done) in done.column_iter().enumerate() {
            column.axpy(-lower[(i, k)], &done, 1.0);
        }
        column /= lower[(i, i)];
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Karush-Kuhn-Tucker: no free value has a slope, no bound one wants to grow.
        #[test]
        fn the_answer_is_optimal(
            columns in proptest::collection::vec(0.0..1.0_f64, 40),
            target in proptest::collection::vec(-1.0..1.0_f64, 8),
        ) {
            let a = DMatrix::from_vec(8, 5, columns);
            let y = DVector::from_vec(target);
            let (gram, right) = (a.transpose() * &a, a.transpose() * y);
            let x = solve(&gram.as_view(), &DMatrix::from_columns(std::slice::from_ref(&right)).as_view(), 0).column(0).into_owned();
            let fall = &right - &gram * &x;
            for i in 0..5 {
                prop_assert!(x[i] >= 0.0, "{x}");
                prop_assert!(fall[i] < 1e-8, "{fall}");
                prop_assert!((fall[i] * x[i]).abs() < 1e-7, "{fall} {x}");
            }
        }

        #[test]
        fn twin_columns_do_no_harm(right in 0.1..2.0_f64) {
            let gram = DMatrix::from_element(2, 2, 1.0);
            let x = solve(&gram.as_view(), &DMatrix::from_element(2, 1, right).as_view(), 0);
            prop_assert!((x.sum() - right).abs() < 1e-12, "{x}");
        }
    }
}
