//! Eigenvalues and eigenvectors of a symmetric 3x3 matrix, to full accuracy.

use glam::{DMat3, DVec3};

/// Sweeps that are never needed: Jacobi's method converges quadratically, five or six do for 3x3.
const MOST_SWEEPS: usize = 30;

/// The decomposition `A = V diag(values) Vᵀ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decomposition {
    /// Eigenvalues, ascending.
    pub values: DVec3,
    /// Eigenvectors as columns, in the order of the values; orthonormal, right-handed.
    pub vectors: DMat3,
}

/// Decomposes a symmetric matrix by cyclic Jacobi rotations (Jacobi 1846; Golub and Van Loan, Matrix Computations, section
/// 8.5). Of all methods it is the most accurate for small eigenvalues (Demmel and Veselic 1992, doi:10.1137/0613074), and it leaves
/// a diagonal matrix as it is, axes included. Of `matrix` the upper triangle is used.
#[must_use]
pub fn symmetric(matrix: DMat3) -> Decomposition {
    let upper = |row: usize, column: usize| matrix.col(row.max(column))[row.min(column)];
    let mut a = [0, 1, 2].map(|row| [0, 1, 2].map(|column| upper(row, column)));
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MOST_SWEEPS {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            turned |= rotate(&mut a, &mut v, p, q);
        }
        if !turned {
            break;
        }
    }
    let mut order = [0, 1, 2];
    // Stable: equal values keep the order of the axes.
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    let column = |i: usize| DVec3::new(v[0][i], v[1][i], v[2][i]).normalize();
    let [first, second, _] = order.map(column);
    // Rotations keep the columns perpendicular to round-off; this removes what is left of it.
    let second = (second - first * first.dot(second)).normalize();
    Decomposition {
        values: DVec3::from_array(order.map(|i| a[i][i])),
        vectors: DMat3::from_cols(first, second, first.cross(second)),
    }
}

/// Makes the entry (p, q) zero; false if it is negligible already.
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) -> bool {
    let off = a[p][q];
    if off == 0.0 || off.abs() <= f64::EPSILON * 0.25 * (a[p][p] * a[q][q]).abs().sqrt() {
        return false;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * off);
    // The smaller root of t² + 2 theta t - 1 = 0 turns by at most 45 degrees.
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    a[p][p] -= t * off;
    a[q][q] += t * off;
    a[p][q] = 0.0;
    a[q][p] = 0.0;
    let r = 3 - p - q;
    let (rp, rq) = (a[r][p], a[r][q]);
    a[r][p] = c * rp - s * rq;
    a[r][q] = s * rp + c * rq;
    a[p][r] = a[r][p];
    a[q][r] = a[r][q];
    for row in v.iter_mut() {
        let (vp, vq) = (row[p], row[q]);
        row[p] = c * vp - s * vq;
        row[q] = s * vp + c * vq;
    }
    true
}
