//! Damped least squares for a few numbers (Levenberg and Marquardt; Nocedal and Wright, section 10.3).

use nalgebra::{SMatrix, SVector};

/// Steps at most; shapes need 5 to 20.
const STEPS: usize = 30;
/// Relative decrease of the cost that ends the descent.
const SMALLEST_DECREASE: f64 = 1e-4;

/// Numbers that minimise the sum of squares of weighted residuals, and that sum.
///
/// `residuals` calls its second argument with the weight, the value and the derivatives of each residual.
pub fn minimise<const N: usize>(
    start: [f64; N],
    mut residuals: impl FnMut(&[f64; N], &mut dyn FnMut(f64, f64, &[f64; N])),
) -> ([f64; N], f64) {
    let mut damping = 1e-3;
    let mut numbers = start;
    let (mut cost, mut gradient, mut hessian) = normal_equations(&numbers, &mut residuals);
    for _ in 0..STEPS {
        let mut damped = hessian;
        for i in 0..N {
            damped[(i, i)] += damping * hessian[(i, i)] + 1e-30;
        }
        let Some(factor) = damped.cholesky() else {
            damping *= 10.0;
            continue;
        };
        let step = factor.solve(&gradient);
        let trial: [f64; N] = std::array::from_fn(|i| numbers[i] - step[i]);
        let next = normal_equations(&trial, &mut residuals);
        if next.0.is_finite() && next.0 < cost {
            let decrease = (cost - next.0) / cost;
            numbers = trial;
            (cost, gradient, hessian) = next;
            damping = (0.2 * damping).max(1e-9);
            if decrease < SMALLEST_DECREASE {
                break;
            }
        } else {
            damping *= 5.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    (numbers, cost)
}

/// Cost, gradient and approximate Hessian of some numbers.
fn normal_equations<const N: usize>(
    numbers: &[f64; N],
    residuals: &mut impl FnMut(&[f64; N], &mut dyn FnMut(f64, f64, &[f64; N])),
) -> (f64, SVector<f64, N>, SMatrix<f64, N, N>) {
    let (mut cost, mut gradient, mut hessian) = (0.0, SVector::zeros(), SMatrix::<f64, N, N>::zeros());
    residuals(numbers, &mut |weight, value, derivatives| {
        cost += weight * value * value;
        if derivatives.iter().all(|&derivative| derivative == 0.0) {
            return;
        }
        for (i, &along) in derivatives.iter().enumerate() {
            gradient[i] += weight * value * along;
            for (j, &across) in derivatives.iter().enumerate() {
                hessian[(i, j)] += weight * along * across;
            }
        }
    });
    (cost, gradient, hessian)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_is_recovered_from_its_samples() {
        let (numbers, cost) = minimise([1.0, 0.0], |&[scale, rate], add| {
            for i in 0..10 {
                let x = 0.1 * f64::from(i);
                let power = (rate * x).exp();
                add(1.0, scale * power - 3.0 * (-2.0 * x).exp(), &[power, scale * x * power]);
            }
        });
        assert!(cost < 1e-9, "{numbers:?} {cost}");
        assert!((numbers[0] - 3.0).abs() < 1e-4 && (numbers[1] + 2.0).abs() < 1e-4, "{numbers:?}");
    }
}
