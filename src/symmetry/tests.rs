//! Symmetries of bodies with known ones, under motions, and of bodies without any.

use glam::DQuat;

use super::*;
use crate::mesh::vertex_normals;
use crate::shapes;

/// A bumpy body, symmetric to the plane x = 0 only if `symmetric`, after a motion.
fn body(symmetric: bool, motion: &Isometry) -> Mesh {
    let (mut positions, triangles) = shapes::icosphere(20);
    for p in &mut positions {
        let x = if symmetric { p.x.abs() } else { p.x };
        let bumps = 0.1 * (5.0 * p.y + 3.0 * x * x).sin() + 0.08 * (4.0 * p.z + x * x + 1.0).sin();
        *p *= DVec3::new(1.0, 1.3, 1.7) * (1.0 + bumps);
        if !symmetric {
            // lumps at places that no isometry exchanges
            let lumps = [
                (0.9, 0.5, 0.3, 0.9),
                (-0.3, -1.2, 0.6, 0.5),
                (0.2, 0.6, -1.5, 0.7),
            ];
            for (x, y, z, height) in lumps {
                let distance = p.distance_squared(DVec3::new(x, y, z));
                *p *= 1.0 + height * (-2.0 * distance).exp();
            }
        }
        *p = motion.apply(*p);
    }
    Mesh::from_triangles(positions, &triangles).expect("a closed mesh")
}

fn motion() -> Isometry {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.4, -0.9, 1.3));
    Isometry::about(DVec3::new(3.0, -2.0, 7.0), DMat3::from_quat(turn))
}

#[test]
fn the_reflection_of_a_symmetric_body_is_found_wherever_it_lies() {
    let at_rest = Isometry::about(DVec3::ZERO, DMat3::IDENTITY);
    for motion in [at_rest, motion()] {
        let found = symmetries(&body(true, &motion));
        assert_eq!(found.len(), 1);
        for p in [DVec3::X, DVec3::new(-0.3, 1.1, 0.2), DVec3::Z] {
            let mirrored = motion.apply(p * DVec3::new(-1.0, 1.0, 1.0));
            let image = found[0].apply(motion.apply(p));
            // the points are vertices of two different triangulations
            assert!(image.distance(mirrored) < 0.01, "{image} {mirrored}");
            assert!(found[0].invert(image).distance(motion.apply(p)) < 1e-12);
        }
    }
}

#[test]
fn bodies_without_symmetry_or_area_have_none() {
    assert_eq!(symmetries(&body(false, &motion())), []);
    let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
    let mesh = Mesh::from_triangles(line.to_vec(), &[[0, 1, 2]]).expect("a manifold");
    assert_eq!(symmetries(&mesh), []);
}

#[test]
fn a_fit_restores_a_motion_exactly() {
    let mesh = body(false, &motion());
    let all = Target::coarse(&mesh, usize::MAX);
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.01, -0.02, 0.015)));
    let start = Isometry::about(DVec3::new(2.5, -2.0, 7.5), turn);
    let samples = all.some(300);
    let fit = start.fitted(&samples, 0.7, 30, |_, sample| all.nearest(sample));
    let fit = fit.expect("pairs");
    // the identity is the only symmetry
    for sample in &samples {
        assert!(fit.apply(sample.point).distance(sample.point) < 1e-4);
        assert!(start.apply(sample.point).distance(sample.point) > 1e-3);
    }
    let distance = fit.median(&samples, |_, sample| all.nearest(sample));
    assert!(distance.expect("pairs") < 1e-5);
    // nothing is near
    assert_eq!(start.fitted(&samples, 0.7, 30, |_, _| None), None);
}

#[test]
fn beyond_a_boundary_nothing_is_nearest() {
    let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    let mesh = Mesh::from_triangles(square.to_vec(), &[[0, 1, 2], [0, 2, 3]]).expect("a square");
    let triangles: Vec<[u32; 3]> = mesh.topology.triangles().collect();
    let bvh = crate::mesh::TriangleBvh::new(&mesh.positions, &triangles);
    let look = |x: f64, y: f64, normal: DVec3| {
        let point = DVec3::new(x, y, 0.3);
        alike(&mesh, &bvh.closest_point(point)?, &Sample { point, normal }).map(|found| found.point)
    };
    assert_eq!(look(0.5, 0.25, DVec3::Z), Some(DVec3::new(0.5, 0.25, 0.0)));
    // on the edge between the triangles, beyond the rim, on the other side
    assert_eq!(look(0.5, 0.5, DVec3::Z), Some(DVec3::new(0.5, 0.5, 0.0)));
    assert_eq!(look(0.5, -0.1, DVec3::Z), None);
    assert_eq!(look(0.5, 0.25, -DVec3::Z), None);
}

#[test]
fn a_smooth_surface_is_nearer_to_a_sphere_than_its_triangles_and_keeps_sharp_edges() {
    let (positions, triangles) = shapes::icosphere(12);
    let mesh = Mesh::from_triangles(positions, &triangles).expect("a sphere");
    let bvh = crate::mesh::TriangleBvh::new(&mesh.positions, &triangles);
    let normals = vertex_normals(&mesh.positions, mesh.topology.triangles());
    let (mut flat, mut rounded) = (0.0f64, 0.0f64);
    for k in 0..200 {
        let k = f64::from(k);
        let normal = DVec3::new(k.sin(), (1.7 * k).cos(), (0.3 * k).sin()).normalize();
        let sample = Sample {
            point: 1.01 * normal,
            normal,
        };
        let distance = |p: DVec3| (p.length() - 1.0).abs();
        let found = bvh.closest_point(sample.point).expect("a face");
        flat = flat.max(distance(
            alike(&mesh, &found, &sample).expect("inside").point,
        ));
        rounded = rounded.max(distance(
            smooth(&mesh, &normals, &found, &sample).expect("inside"),
        ));
    }
    // measured: 2.3e-3 and 3.3e-5
    assert!(rounded < 0.05 * flat, "{flat:e} {rounded:e}");
    // two squares that meet at a right angle
    let corners = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::X + DVec3::Y,
        DVec3::Y,
        DVec3::Z,
        DVec3::X + DVec3::Z,
    ];
    let triangles = [[0, 1, 2], [0, 2, 3], [1, 0, 4], [1, 4, 5]];
    let mesh = Mesh::from_triangles(corners.to_vec(), &triangles).expect("two squares");
    let bvh = crate::mesh::TriangleBvh::new(&mesh.positions, &triangles);
    let above = Sample {
        point: DVec3::new(0.4, 0.3, 0.1),
        normal: DVec3::Z,
    };
    let found = bvh.closest_point(above.point).expect("a face");
    assert_eq!(
        smooth(
            &mesh,
            &vertex_normals(&mesh.positions, mesh.topology.triangles()),
            &found,
            &above
        ),
        Some(DVec3::new(0.4, 0.3, 0.0))
    );
}
