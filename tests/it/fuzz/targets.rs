//! The fuzz targets as functions of bytes. `fuzz/` includes this file too, so it uses only the
//! library.

use std::collections::BTreeMap;
use std::path::Path;

use meniscus::energy::Energy;
use meniscus::fill::Controls;
use meniscus::io::{self, Format};
use meniscus::mesh::{self, check_mesh};
use meniscus::runner::Schedule;

/// A function of arbitrary bytes that panics on an error of the program.
pub type Target = fn(&[u8]);

pub fn obj(bytes: &[u8]) {
    mesh_file(Format::Obj, bytes);
}

pub fn ply(bytes: &[u8]) {
    mesh_file(Format::Ply, bytes);
}

pub fn stl(bytes: &[u8]) {
    mesh_file(Format::Stl, bytes);
}

pub fn off(bytes: &[u8]) {
    mesh_file(Format::Off, bytes);
}

pub fn gltf(bytes: &[u8]) {
    mesh_file(Format::Glb, bytes);
}

/// The bytes are the model of an archive. Changed bytes of an archive would only fail its checksums.
pub fn threemf(bytes: &[u8]) {
    mesh_file(Format::ThreeMf, bytes);
    mesh_file(Format::ThreeMf, &archive("3D/3dmodel.model", bytes));
}

/// A ZIP archive with one part that is stored as it is.
fn archive(name: &str, bytes: &[u8]) -> Vec<u8> {
    let crc = !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 * (crc & 1))
        })
    });
    let (size, length) = (bytes.len() as u32, name.len() as u16);
    let mut entry = vec![10, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
    for number in [crc, size, size] {
        entry.extend(number.to_le_bytes());
    }
    entry.extend(length.to_le_bytes());
    entry.extend([0; 2]);
    let local = [b"PK\x03\x04", &entry[..], name.as_bytes(), bytes].concat();
    let central = [b"PK\x01\x02\x0a\0", &entry[..], &[0; 14], name.as_bytes()].concat();
    let mut end = b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec();
    for number in [central.len(), local.len()] {
        end.extend((number as u32).to_le_bytes());
    }
    [local, central, end, vec![0; 2]].concat()
}

/// A reader refuses a file or gives a sound soup; building refuses the soup or gives a valid mesh; a
/// mesh that is written reads back with the same bits.
fn mesh_file(format: Format, bytes: &[u8]) {
    let name = Path::new("mesh");
    let soup = match io::read(format, bytes, name) {
        Ok(soup) => soup,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let count = soup.positions.len();
    assert!(soup.positions.iter().all(|p| p.is_finite()));
    assert!(soup.corners.iter().all(|&v| (v as usize) < count));
    assert!(soup.offsets.is_sorted());
    assert_eq!(
        soup.offsets.last().map_or(0, |&n| n as usize),
        soup.corners.len()
    );
    let Ok(opened) = io::from_soup(&soup, name) else {
        return;
    };
    let built = &opened.mesh;
    assert_eq!(check_mesh(built), Ok(()));
    io::with_output(built, |output| {
        for exact in [Format::Obj, Format::Ply, Format::Off] {
            assert_eq!(io::check(exact, output), Ok(()));
            let mut written = Vec::new();
            io::write(exact, output, &mut written).expect("a vector takes everything");
            let again = io::read(exact, &written, name).expect("what was written");
            let bits = |p: &mesh::DVec3| p.to_array().map(f64::to_bits);
            assert!(
                again
                    .positions
                    .iter()
                    .map(bits)
                    .eq(output.positions.iter().map(bits))
            );
            assert_eq!(again.corners, output.triangles.as_flattened());
        }
        for format in [Format::Glb, Format::Gltf, Format::ThreeMf] {
            if io::check(format, output).is_ok() {
                let mut written = Vec::new();
                io::write(format, output, &mut written).expect("a vector takes everything");
                let again = io::read(format, &written, name).expect("what was written");
                assert_eq!(again.face_count(), output.triangles.len());
            }
        }
    });
}

/// A typed energy is refused with its place marked, or can be evaluated anywhere.
pub fn expression(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let params = BTreeMap::from([("a".to_owned(), 0.5), ("H0".to_owned(), -1.0)]);
    match Energy::parse(&text, &params) {
        Ok(energy) => {
            for (h, k) in [
                (0.0, 0.0),
                (1.0, 1.0),
                (-0.7, 0.1),
                (0.3, -2.0),
                (1e200, 1e-200),
            ] {
                let jet = energy.jet(h, k);
                // the result is the same every time
                let again = energy.jet(h, k);
                assert_eq!(format!("{jet:?}"), format!("{again:?}"));
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A schedule is refused, or written as text that reads back as the same schedule.
pub fn schedule(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let Ok(schedule) = Schedule::parse(&text) else {
        return;
    };
    assert_eq!(Schedule::parse(&schedule.to_csv()), Ok(schedule.clone()));
    // refused or not, without a panic
    schedule.recording(&Controls::default()).ok();
}

/// A project file, whose head these bytes are, is refused, or written as text that reads back as the
/// same project. Meshes have targets of their own.
#[cfg(feature = "window")]
pub fn project(bytes: &[u8]) {
    use meniscus::app::rewrite_project;
    let Ok(first) = rewrite_project(&with_mesh(&String::from_utf8_lossy(bytes))) else {
        return;
    };
    assert_eq!(rewrite_project(&first), Ok(first.clone()));
}

/// The text of a project from its head: with an open tetrahedron.
#[cfg(feature = "window")]
pub fn with_mesh(head: &str) -> String {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
    format!("{head}\n#--- mesh (OBJ) ---\n{mesh}")
}
