use nalgebra_sparse::CooMatrix;

use super::super::test_matrices::noise;
use super::*;

fn matrix(n: usize, entries: &[(usize, usize, f64)]) -> CscMatrix<f64> {
    let mut coo = CooMatrix::new(n, n);
    for &(i, j, a) in entries {
        coo.push(i, j, a);
    }
    CscMatrix::from(&coo)
}

/// Upwind convection-diffusion on a grid, rows and columns in natural order.
fn convection(nx: usize, wind: f64) -> CscMatrix<f64> {
    let mut entries = Vec::new();
    for v in 0..nx * nx {
        entries.push((v, v, 4.0 + 2.0 * wind));
        let (i, j) = (v % nx, v / nx);
        if i > 0 {
            entries.push((v, v - 1, -1.0 - wind));
        }
        if i + 1 < nx {
            entries.push((v, v + 1, -1.0));
        }
        if j > 0 {
            entries.push((v, v - nx, -1.0 - wind));
        }
        if j + 1 < nx {
            entries.push((v, v + nx, -1.0));
        }
    }
    matrix(nx * nx, &entries)
}

#[test]
fn unsymmetric_systems_are_solved_to_rounding() {
    let a = convection(24, 3.0);
    let n = a.nrows();
    let exact = noise(5, 2 * n);
    let mut b = vec![0.0; 2 * n];
    for (i, j, &v) in a.triplet_iter() {
        b[i] += v * exact[j];
        b[n + i] += v * exact[n + j];
    }
    let mut lu = SparseLu::new(&a).expect("regular");
    lu.solve_in_place(&mut b, 2);
    assert!(b.iter().zip(&exact).all(|(x, e)| (x - e).abs() < 1e-12));
}

#[test]
fn pivoting_meets_zero_diagonals_and_bad_units() {
    // A cyclic shift has no diagonal at all; rows and columns in units 1e12 apart.
    let n = 7;
    let entries: Vec<_> = (0..n)
        .map(|i| (i, (i + 1) % n, 1e-12 * 10_000_f64.powf(i as f64)))
        .collect();
    let a = matrix(n, &entries);
    let mut x: Vec<f64> = entries.iter().map(|e| e.2 * (e.1 as f64 + 1.0)).collect();
    SparseLu::new(&a)
        .expect("regular")
        .solve_in_place(&mut x, 1);
    for (j, x) in x.iter().enumerate() {
        assert!((x - (j as f64 + 1.0)).abs() < 1e-14 * (j as f64 + 1.0));
    }
}

#[test]
fn singular_matrices_are_refused() {
    let numeric = matrix(2, &[(0, 0, 1.0), (0, 1, 2.0), (1, 0, 3.0), (1, 1, 6.0)]);
    let empty_column = matrix(3, &[(0, 0, 1.0), (1, 0, 1.0), (2, 2, 1.0), (0, 2, 1.0)]);
    // Neumann Laplacian of a path: constants are its null space, no pivot is exactly zero.
    let n = 50;
    let mut entries = Vec::new();
    for i in 1..n {
        let w = 0.1 * i as f64;
        entries.extend([(i, i, w), (i - 1, i - 1, w), (i, i - 1, -w), (i - 1, i, -w)]);
    }
    for a in [numeric, empty_column, matrix(n, &entries)] {
        assert!(matches!(
            SparseLu::new(&a),
            Err(LinearError::Singular { .. })
        ));
    }
}

#[test]
fn shapes() {
    let wide = CscMatrix::<f64>::zeros(2, 3);
    let error = SparseLu::new(&wide).expect_err("not square");
    assert_eq!(
        error,
        LinearError::NotSquare {
            rows: 2,
            columns: 3
        }
    );
    SparseLu::new(&CscMatrix::zeros(0, 0))
        .expect("empty")
        .solve_in_place(&mut [], 1);
}
