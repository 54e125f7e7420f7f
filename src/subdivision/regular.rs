//! The regular patch: quartic box spline over 12 control vertices, in closed form.

/// A term `coefficient * u^i v^j w^k / 12` in barycentric coordinates of the triangle, `i+j+k = 4`.
type Term = (f64, [u8; 3]);

/// Basis function of the corner `u`.
const CORNER: [Term; 15] = [
    (6.0, [4, 0, 0]),
    (24.0, [3, 1, 0]),
    (24.0, [3, 0, 1]),
    (24.0, [2, 2, 0]),
    (60.0, [2, 1, 1]),
    (24.0, [2, 0, 2]),
    (8.0, [1, 3, 0]),
    (36.0, [1, 2, 1]),
    (36.0, [1, 1, 2]),
    (8.0, [1, 0, 3]),
    (1.0, [0, 4, 0]),
    (6.0, [0, 3, 1]),
    (12.0, [0, 2, 2]),
    (6.0, [0, 1, 3]),
    (1.0, [0, 0, 4]),
];

/// Basis function of the vertex opposite the edge `(u, v)`.
const OPPOSITE: [Term; 9] = [
    (1.0, [4, 0, 0]),
    (6.0, [3, 1, 0]),
    (12.0, [2, 2, 0]),
    (6.0, [1, 3, 0]),
    (1.0, [0, 4, 0]),
    (2.0, [3, 0, 1]),
    (6.0, [2, 1, 1]),
    (6.0, [1, 2, 1]),
    (2.0, [0, 3, 1]),
];

/// Basis function of the neighbour of the corner `u` alone that lies on the side of `v`.
const OUTER: [Term; 2] = [(1.0, [4, 0, 0]), (2.0, [3, 1, 0])];

/// For each control vertex its function and which corners play `(u, v, w)`.
const FUNCTIONS: [(&[Term], [usize; 3]); 12] = [
    (&CORNER, [0, 1, 2]),
    (&CORNER, [1, 2, 0]),
    (&CORNER, [2, 0, 1]),
    (&OPPOSITE, [0, 1, 2]),
    (&OUTER, [1, 0, 2]),
    (&OUTER, [1, 2, 0]),
    (&OPPOSITE, [1, 2, 0]),
    (&OUTER, [2, 1, 0]),
    (&OUTER, [2, 0, 1]),
    (&OPPOSITE, [2, 0, 1]),
    (&OUTER, [0, 2, 1]),
    (&OUTER, [0, 1, 2]),
];

/// Values and derivatives (value, `a`, `b`, `aa`, `ab`, `bb`) of the 12 basis functions of a
/// triangle with three regular corners at the barycentric coordinates `at`, along the directions
/// `a` and `b`, differences of barycentric coordinates.
pub(super) fn evaluate(at: [f64; 3], a: [f64; 3], b: [f64; 3]) -> [[f64; 6]; 12] {
    // powers[corner][e] = at[corner]^e
    let powers = at.map(|x| [1.0, x, x * x, x * x * x, x * x * x * x]);
    let mut out = [[0.0; 6]; 12];
    for (row, (terms, corners)) in out.iter_mut().zip(FUNCTIONS) {
        let x = corners.map(|c| powers[c]);
        let (da, db) = (corners.map(|c| a[c]), corners.map(|c| b[c]));
        for &(coefficient, exponents) in terms {
            add_term(coefficient / 12.0, exponents, &x, da, db, row);
        }
    }
    out
}

/// Adds one term, its gradient along `a`, `b` and its Hessian on them.
fn add_term(
    coefficient: f64,
    exponents: [u8; 3],
    x: &[[f64; 5]; 3],
    a: [f64; 3],
    b: [f64; 3],
    row: &mut [f64; 6],
) {
    // derivative of order d of x_c^e
    let power = |c: usize, d: u8| -> f64 {
        let e = exponents[c];
        if e < d {
            return 0.0;
        }
        let factor = match d {
            0 => 1.0,
            1 => f64::from(e),
            _ => f64::from(e) * f64::from(e - 1),
        };
        factor * x[c][usize::from(e - d)]
    };
    let p: [[f64; 3]; 3] = [0, 1, 2].map(|c| [power(c, 0), power(c, 1), power(c, 2)]);
    let gradient = [
        p[0][1] * p[1][0] * p[2][0],
        p[0][0] * p[1][1] * p[2][0],
        p[0][0] * p[1][0] * p[2][1],
    ];
    let h01 = p[0][1] * p[1][1] * p[2][0];
    let h02 = p[0][1] * p[1][0] * p[2][1];
    let h12 = p[0][0] * p[1][1] * p[2][1];
    let h00 = p[0][2] * p[1][0] * p[2][0];
    let h11 = p[0][0] * p[1][2] * p[2][0];
    let h22 = p[0][0] * p[1][0] * p[2][2];
    let dot = |s: [f64; 3], t: [f64; 3]| s[0] * t[0] + s[1] * t[1] + s[2] * t[2];
    let hessian = |t: [f64; 3]| {
        [
            h00 * t[0] + h01 * t[1] + h02 * t[2],
            h01 * t[0] + h11 * t[1] + h12 * t[2],
            h02 * t[0] + h12 * t[1] + h22 * t[2],
        ]
    };
    row[0] += coefficient * p[0][0] * p[1][0] * p[2][0];
    row[1] += coefficient * dot(gradient, a);
    row[2] += coefficient * dot(gradient, b);
    let ha = hessian(a);
    row[3] += coefficient * dot(ha, a);
    row[4] += coefficient * dot(ha, b);
    row[5] += coefficient * dot(hessian(b), b);
}
