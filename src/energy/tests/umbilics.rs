//! Symmetric expressions in κ1, κ2 at and near umbilics.

use super::*;

/// f(H, K) from closed forms in t = H² − K, to compare with typed expressions near umbilics.
fn reference(text: &str, h: f64, t: f64) -> Option<Jet2> {
    // Series of cosh √t and sinh √t / √t and their derivatives converge for every t used here.
    let (mut c, mut s) = ([0.0; 3], [0.0; 3]);
    for n in (0..40).rev() {
        let fact = |m: u32| (1..=m).map(f64::from).product::<f64>();
        let x = f64::from(n);
        let shifted = |m: u32| {
            if n >= m {
                t.powi((n - m).cast_signed())
            } else {
                0.0
            }
        };
        for (i, w) in [1.0, x, x * (x - 1.0)].into_iter().enumerate() {
            c[i] += w * shifted(i as u32) / fact(2 * n);
            s[i] += w * shifted(i as u32) / fact(2 * n + 1);
        }
    }
    // F(H, t) and its derivatives f, H, t, HH, Ht, tt.
    let e = h.exp();
    let [f, fh, ft, fhh, fht, ftt] = match text {
        "exp(k1)+exp(k2)" => {
            [e * c[0], e * c[0], e * c[1], e * c[0], e * c[1], e * c[2]].map(|x| 2.0 * x)
        }
        // e^κ1 κ1 + e^κ2 κ2 = 2e^H (H cosh s + s² sinh s/s).
        "k1*exp(k1)+k2*exp(k2)" => {
            let g = |i: usize| h * c[i] + t * s[i] + if i > 0 { i as f64 * s[i - 1] } else { 0.0 };
            let (g0, g1, g2) = (g(0), g(1), g(2));
            [g0, g0 + c[0], g1, g0 + 2.0 * c[0], g1 + c[1], g2].map(|x| 2.0 * e * x)
        }
        "(exp(k1)-exp(k2))/(k1-k2)" => [s[0], s[0], s[1], s[0], s[1], s[2]].map(|x| e * x),
        _ => return None,
    };
    Some(Jet2 {
        f,
        h: fh + 2.0 * h * ft,
        k: -ft,
        hh: fhh + 2.0 * ft + 4.0 * h * fht + 4.0 * h * h * ftt,
        hk: -fht - 2.0 * h * ftt,
        kk: ftt,
    })
}

/// Distances from the umbilic: 0, then 1e-12 to 3 densely enough to straddle every switch.
fn gaps() -> impl Iterator<Item = f64> {
    std::iter::once(0.0).chain((0..=250).map(|i| 1e-12 * 10_f64.powf(f64::from(i) * 0.05)))
}

#[test]
fn symmetric_polynomials_are_right_at_and_near_umbilics() {
    for (i, (text, preset)) in [
        ("k1^4+k2^4", Preset::K1P4PlusK2P4),
        ("(k1-k2)^2", Preset::K1MinusK2Squared),
        ("k1^2+k2^2", Preset::K1SqPlusK2Sq),
        (
            "(k1^5-k2^5)/(k1-k2) - k1*k2*(k1^2+k1*k2+k2^2)",
            Preset::K1P4PlusK2P4,
        ),
        ("1/(1/k1^4)+1/(1/k2^4)", Preset::K1P4PlusK2P4),
        ("sqrt(k1^8)+sqrt(k2^8)", Preset::K1P4PlusK2P4),
    ]
    .into_iter()
    .enumerate()
    {
        let (typed, closed) = (unrecognised(text), Energy::preset(preset));
        for radius in [1.0, 1e-3, 1e3] {
            for (gap, sign) in gaps().flat_map(|gap| [(gap, 1.0), (gap, -1.0)]) {
                let (h, s) = (sign / radius, gap / radius);
                // κ2 = 0 is where the reciprocals end.
                if i == 4 && (gap - 1.0).abs() < 0.3 {
                    continue;
                }
                let k = (h - s) * (h + s);
                let c = h.abs().max(s);
                let d = distance(&typed.jet(h, k), &closed.jet(h, k), c);
                let kind = usize::from(i > 3);
                assert!(
                    d < [1e-14, 1e-11][kind],
                    "{text} R {radius} gap {gap:e}: {d:e}"
                );
            }
        }
    }
}

#[test]
fn functions_of_principal_curvatures_are_right_at_and_near_umbilics() {
    for text in [
        "exp(k1)+exp(k2)",
        "k1*exp(k1)+k2*exp(k2)",
        "(exp(k1)-exp(k2))/(k1-k2)",
    ] {
        let energy = parsed(text);
        for (gap, h) in gaps().flat_map(|gap| [-1.0, 0.0, 0.4].map(|h| (gap, h))) {
            let k = (h - gap) * (h + gap);
            let want = reference(text, h, h * h - k).expect("has a closed form");
            let d = distance(&energy.jet(h, k), &want, 1.0);
            assert!(d < 1e-11, "{text} H {h} gap {gap:e}: {d:e}");
        }
    }
}

/// `g` at a number: value, first and second derivative.
type Curve = fn(f64) -> [f64; 3];

#[test]
fn sums_over_principal_curvatures_are_right_where_one_of_them_vanishes() {
    let curves: [(&str, Curve); 4] = [
        ("sqrt(1e-8+k1^2)+sqrt(1e-8+k2^2)", |x| {
            let r = (1e-8 + x * x).sqrt();
            [r, x / r, 1e-8 / (r * r * r)]
        }),
        ("1/(1e-6+k1^2)+1/(1e-6+k2^2)", |x| {
            let r = (1e-6 + x * x).recip();
            [r, -2.0 * x * r * r, 2.0 * r * r * (4.0 * x * x * r - 1.0)]
        }),
        ("exp(-1e6*k1^2)+exp(-1e6*k2^2)", |x| {
            let e = (-1e6 * x * x).exp();
            [e, -2e6 * x * e, 2e6 * e * (2e6 * x * x - 1.0)]
        }),
        ("log(1e-8+k1^2)+log(1e-8+k2^2)", |x| {
            let r = (1e-8 + x * x).recip();
            [-r.ln(), 2.0 * x * r, 2.0 * r * (1.0 - 2.0 * x * x * r)]
        }),
    ];
    for (text, g) in curves {
        let energy = parsed(text);
        for k2 in [0.0, 1e-6, -1e-4, 1e-3, -0.02, 0.1, 0.5, -0.999, 0.9] {
            // With κ1 = 1, d = κ1 − κ2: κ1_H = 2κ1/d, κ2_H = −2κ2/d, κ2_K = −κ1_K = 1/d.
            let (jet, d) = (energy.jet(0.5 * (1.0 + k2), k2), 1.0 - k2);
            let ([f1, g1, gg1], [f2, g2, gg2]) = (g(1.0), g(k2));
            let (slope, n, sum) = ((g2 - g1) / d, g1 - g2 * k2, 1.0 + k2);
            let want = Jet2 {
                f: f1 + f2,
                h: 2.0 * n / d,
                k: slope,
                hh: 4.0 * (gg1 + g1 + k2 * (gg2 * k2 + g2) - n * sum / d) / (d * d),
                hk: -2.0 * (gg1 + gg2 * k2 + slope * sum) / (d * d),
                kk: (gg1 + gg2 + 2.0 * slope) / (d * d),
            };
            for (found, want) in members(&jet).into_iter().zip(members(&want)) {
                let size = 1.0 + want.abs() + (g1.abs() + g2.abs()) / (d * d);
                assert!(
                    (found - want).abs() < 1e-11 * size,
                    "{text} {k2}: {found} {want}"
                );
            }
        }
    }
}

#[test]
fn nothing_jumps_across_the_switch() {
    let texts = [
        "log(3+k1)+log(3+k2)",
        "tanh(k1)+tanh(k2)",
        "(k1+3)^1.5+(k2+3)^1.5",
        "sin(k1)*sin(k2)",
        "cos(2*k1)+cos(2*k2)",
        "sqrt(3+k1)*sqrt(3+k2)",
        "(k1+3)^(k1)+(k2+3)^k2",
        "(k1+3)^20.5+(k2+3)^20.5",
    ];
    for text in texts {
        let energy = parsed(text);
        for i in 0..4000 {
            let (h, s) = (0.4, 1e-3 * 1.0017_f64.powi(i));
            let near = energy.jet(h, h * h - s * s);
            let step = 1e-9 * s;
            let far = energy.jet(h, h * h - (s + step) * (s + step));
            // The jets differ by derivatives times 2 s · step, below 1e-9 of their size times s².
            let d = distance(&near, &far, 1.0);
            let smooth = 1e-8 * s * s;
            assert!(d < 1e-11 + smooth, "{text} s {s:e}: {d:e}");
        }
    }
}

#[test]
fn a_little_below_the_umbilic_is_continuous() {
    // Roundoff makes H² < K on a sphere.
    for text in ["k1^4+k2^4", "exp(k1)+exp(k2)", "log(3+k1)*log(3+k2)"] {
        let energy = unrecognised(text);
        let (at, below) = (energy.jet(-1.0, 1.0), energy.jet(-1.0, 1.0 + 1e-15));
        assert!(distance(&at, &below, 1.0) < 1e-13, "{text}");
    }
    // Data that no surface has: rational expressions are continued, everything else stays finite.
    let (h, k) = (0.3, 2.0);
    let preset = Energy::preset(Preset::K1P4PlusK2P4).jet(h, k);
    assert!(distance(&unrecognised("k1^4+k2^4").jet(h, k), &preset, 1.4) < 1e-14);
    assert!(parsed("exp(k1)+exp(k2)").jet(h, k).is_finite());
}
