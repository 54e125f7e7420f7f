//! Parsers of arguments.

use crate::analysis::Plane;
use crate::mesh::DVec3;

/// `X,Y,Z`.
pub fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|word| word.trim().parse::<f64>())
        .collect::<Result<_, _>>()
        .map_err(|_| "write three numbers, as in 0.1,-2,3.5".to_owned())?;
    match numbers[..] {
        [x, y, z] if x.is_finite() && y.is_finite() && z.is_finite() => Ok(DVec3::new(x, y, z)),
        _ => Err("write three numbers, as in 0.1,-2,3.5".into()),
    }
}

/// `X,Y,Z,R`: centre and radius.
pub fn ball(text: &str) -> Result<(DVec3, f64), String> {
    let error = || "write a centre and a positive radius, as in 0.1,-2,3.5,0.25".to_owned();
    let (centre, radius) = text.rsplit_once(',').ok_or_else(error)?;
    let centre = point(centre).map_err(|_| error())?;
    match radius.trim().parse::<f64>() {
        Ok(r) if r.is_finite() && r > 0.0 => Ok((centre, r)),
        _ => Err(error()),
    }
}

/// A positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("write a positive number".into()),
    }
}

/// `X,Y,Z,NX,NY,NZ`: a point of a plane and its normal.
pub fn plane(text: &str) -> Result<Plane, String> {
    let error = || "write a point and a non-zero normal, as in 0,0,0.5,0,0,1".to_owned();
    let third = text.match_indices(',').nth(2).ok_or_else(error)?.0;
    let [at, normal] = [&text[..third], &text[third + 1..]].map(point);
    match (at, normal) {
        (Ok(point), Ok(normal)) if normal.try_normalize().is_some() => Ok(Plane { point, normal }),
        _ => Err(error()),
    }
}

/// `NAME=VALUE`.
pub fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or("write NAME=VALUE, as in a=0.3")?;
    let value = value
        .trim()
        .parse::<f64>()
        .map_err(|_| format!("`{value}` is not a number"))?;
    Ok((name.trim().to_owned(), value))
}
