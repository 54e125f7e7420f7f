//! Mesh files read independently of the library under test: just positions and polygons.

use std::path::Path;

use meniscus::mesh::DVec3;

#[derive(Clone, Debug, Default)]
pub struct RawMesh {
    pub positions: Vec<DVec3>,
    pub faces: Vec<Vec<u32>>,
}

impl RawMesh {
    /// The polygons as fans of triangles.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let fan = |f: &Vec<u32>| -> Vec<[u32; 3]> {
            f.windows(2).skip(1).map(|w| [f[0], w[0], w[1]]).collect()
        };
        self.faces.iter().flat_map(fan).collect()
    }

    /// A mesh of triangles.
    pub fn from_triangles(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        Self {
            positions: positions.to_vec(),
            faces: triangles.iter().map(|t| t.to_vec()).collect(),
        }
    }
}

/// Reads an OBJ, STL or PLY file; `Err` contains the reason if it is invalid.
pub fn read(path: &Path) -> Result<RawMesh, String> {
    let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
    match path.extension().and_then(|e| e.to_str()) {
        Some("obj") => obj(&String::from_utf8_lossy(&bytes)),
        Some("stl") => stl(&bytes),
        Some("ply") => ply(&bytes),
        other => Err(format!("{}: unknown format {other:?}", path.display())),
    }
}

fn number(token: Option<&str>) -> Result<f64, String> {
    let token = token.ok_or("a number is missing")?;
    token.parse().map_err(|_| format!("no number: {token:?}"))
}

fn obj(text: &str) -> Result<RawMesh, String> {
    let joined = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let mut mesh = RawMesh::default();
    for line in joined.lines() {
        let mut tokens = line.split_whitespace();
        match tokens.next() {
            Some("v") => {
                let (x, y, z) = (tokens.next(), tokens.next(), tokens.next());
                let p = DVec3::new(number(x)?, number(y)?, number(z)?);
                mesh.positions.push(p);
            }
            Some("f") => {
                let corner = |token: &str| {
                    let index = token.split('/').next().unwrap_or_default();
                    let index: i64 = index.parse().map_err(|_| format!("no index: {token:?}"))?;
                    let count = mesh.positions.len() as i64;
                    let index = if index < 0 { count + index } else { index - 1 };
                    u32::try_from(index).map_err(|_| format!("index {token}"))
                };
                let face: Vec<u32> = tokens.map(corner).collect::<Result<_, _>>()?;
                mesh.faces.push(face);
            }
            _ => {}
        }
    }
    let count = mesh.positions.len() as u32;
    if mesh.faces.iter().flatten().any(|&v| v >= count) {
        return Err("an index is out of range".into());
    }
    Ok(mesh)
}

fn stl(bytes: &[u8]) -> Result<RawMesh, String> {
    let mut mesh = RawMesh::default();
    let declared = bytes
        .get(80..84)
        .and_then(|b| Some(u32::from_le_bytes(b.try_into().ok()?) as usize));
    if let Some(count) = declared.filter(|n| bytes.len() == 84 + 50 * n) {
        for f in 0..count {
            let record = &bytes[84 + 50 * f + 12..84 + 50 * f + 48];
            let floats: Vec<f64> = record
                .chunks_exact(4)
                .map(|c| f64::from(f32::from_le_bytes([c[0], c[1], c[2], c[3]])))
                .collect();
            let at = |k: usize| DVec3::new(floats[3 * k], floats[3 * k + 1], floats[3 * k + 2]);
            mesh.positions.extend([at(0), at(1), at(2)]);
        }
    } else {
        let text = std::str::from_utf8(bytes).map_err(|_| "neither binary nor ascii STL")?;
        for line in text.lines() {
            let mut tokens = line.split_whitespace();
            if tokens.next() == Some("vertex") {
                let (x, y, z) = (tokens.next(), tokens.next(), tokens.next());
                let p = DVec3::new(number(x)?, number(y)?, number(z)?);
                mesh.positions.push(p);
            }
        }
    }
    mesh.faces = (0..mesh.positions.len() as u32 / 3)
        .map(|f| vec![3 * f, 3 * f + 1, 3 * f + 2])
        .collect();
    Ok(mesh)
}

/// The simple PLY files of the test set: float or double x, y, z first, then one list per face.
fn ply(bytes: &[u8]) -> Result<RawMesh, String> {
    let end = b"end_header\n";
    let body_at = bytes
        .windows(end.len())
        .position(|w| w == end)
        .ok_or("no end_header")?
        + end.len();
    let header = String::from_utf8_lossy(&bytes[..body_at]).into_owned();
    let (mut vertices, mut faces, mut scalars) = (0, 0, Vec::new());
    let (mut format, mut list) = ("", Vec::new());
    for line in header.lines() {
        let t: Vec<&str> = line.split_whitespace().collect();
        match t.as_slice() {
            ["format", kind, ..] => format = *kind,
            ["element", "vertex", n] => vertices = n.parse().map_err(|_| "vertex count")?,
            ["element", "face", n] => faces = n.parse().map_err(|_| "face count")?,
            ["property", "list", count, index, _] => {
                list = vec![(*count).to_owned(), (*index).to_owned()];
            }
            ["property", kind, _] => scalars.push((*kind).to_owned()),
            _ => {}
        }
    }
    let mut values = PlyValues {
        body: &bytes[body_at..],
        at: 0,
        big: format == "binary_big_endian",
        ascii: format == "ascii",
    };
    let mut mesh = RawMesh::default();
    for _ in 0..vertices {
        let row: Vec<f64> = scalars
            .iter()
            .map(|kind| values.next(kind))
            .collect::<Result<_, _>>()?;
        mesh.positions.push(DVec3::new(row[0], row[1], row[2]));
    }
    for _ in 0..faces {
        let corners = values.next(&list[0])? as usize;
        let face: Vec<u32> = (0..corners)
            .map(|_| values.next(&list[1]).map(|v| v as u32))
            .collect::<Result<_, _>>()?;
        mesh.faces.push(face);
    }
    Ok(mesh)
}

struct PlyValues<'a> {
    body: &'a [u8],
    at: usize,
    big: bool,
    ascii: bool,
}

impl PlyValues<'_> {
    fn next(&mut self, kind: &str) -> Result<f64, String> {
        if self.ascii {
            while self.body.get(self.at).is_some_and(u8::is_ascii_whitespace) {
                self.at += 1;
            }
            let start = self.at;
            while self
                .body
                .get(self.at)
                .is_some_and(|b| !b.is_ascii_whitespace())
            {
                self.at += 1;
            }
            let token = std::str::from_utf8(&self.body[start..self.at]).ok();
            return number(token);
        }
        let size = match kind {
            "char" | "uchar" | "int8" | "uint8" => 1,
            "short" | "ushort" | "int16" | "uint16" => 2,
            "double" | "float64" => 8,
            _ => 4,
        };
        let mut raw = [0u8; 8];
        raw[..size].copy_from_slice(
            self.body
                .get(self.at..self.at + size)
                .ok_or("PLY file too short")?,
        );
        self.at += size;
        if self.big {
            raw[..size].reverse();
        }
        let word = [raw[0], raw[1], raw[2], raw[3]];
        Ok(match kind {
            "uchar" | "uint8" => f64::from(raw[0]),
            "char" | "int8" => f64::from(raw[0] as i8),
            "ushort" | "uint16" => f64::from(u16::from_le_bytes([raw[0], raw[1]])),
            "short" | "int16" => f64::from(i16::from_le_bytes([raw[0], raw[1]])),
            "double" | "float64" => f64::from_le_bytes(raw),
            "float" | "float32" => f64::from(f32::from_le_bytes(word)),
            "uint" | "uint32" => f64::from(u32::from_le_bytes(word)),
            "int" | "int32" => f64::from(i32::from_le_bytes(word)),
            other => return Err(format!("PLY type {other:?}")),
        })
    }
}
