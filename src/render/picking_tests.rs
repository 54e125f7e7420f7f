use super::*;
use crate::mesh::{LoopId, Mesh, boundary_loops};
use crate::render::{Bounds, CutPlane, StandardView};
use crate::shapes::{self, Hole, HoleShape};

const SIZE: [f64; 2] = [400.0, 300.0];
const TOLERANCE: f64 = 6.0;

struct Model {
    mesh: Mesh,
    loops: Vec<BoundaryLoop>,
    picker: Picker,
}

fn model((positions, triangles): shapes::TriangleMesh) -> Model {
    let mesh = Mesh::from_triangles(positions, &triangles).expect("a manifold");
    let loops = boundary_loops(&mesh);
    Model {
        picker: Picker::new(&mesh.positions, &mesh.topology, &loops),
        mesh,
        loops,
    }
}

/// A unit sphere with a round hole at the north pole (+z).
fn cup() -> Model {
    model(shapes::cut_where(&shapes::sphere(1500, 1), |p| p.z > 0.9))
}

fn cameras(model: &Model, view: StandardView) -> [Camera; 2] {
    let bounds = Bounds::of(model.mesh.positions.iter().copied()).expect("points");
    [false, true].map(|orthographic| {
        let mut camera = Camera::fit(&bounds);
        camera.orthographic = orthographic;
        camera.standard_view(view);
        camera.fit_to(&bounds);
        camera
    })
}

fn pixel(camera: &Camera, p: DVec3) -> [f64; 2] {
    let [x, y] = camera.project(p, SIZE[0] / SIZE[1]).expect("in front");
    [0.5 * (x + 1.0) * SIZE[0], 0.5 * (1.0 - y) * SIZE[1]]
}

fn pick(model: &Model, camera: &Camera, at: [f64; 2]) -> Option<LoopId> {
    model.picker.pick_loop(camera, SIZE, at, TOLERANCE)
}

#[test]
fn a_hole_is_picked_by_rim_and_opening_but_not_through_the_surface() {
    let cup = cup();
    let rim: Vec<DVec3> = cup.loops[0]
        .vertices
        .iter()
        .map(|&v| cup.mesh.position(v))
        .collect();
    let middle = DVec3::Z;
    for camera in cameras(&cup, StandardView::Front) {
        assert_eq!(
            pick(&cup, &camera, pixel(&camera, middle)),
            Some(LoopId::FIRST)
        );
        for &p in &rim {
            assert_eq!(pick(&cup, &camera, pixel(&camera, p)), Some(LoopId::FIRST));
            let outside = DVec3::new(1.3 * p.x, 1.3 * p.y, p.z);
            assert_eq!(pick(&cup, &camera, pixel(&camera, outside)), None);
        }
    }
    for camera in cameras(&cup, StandardView::Back) {
        assert_eq!(pick(&cup, &camera, pixel(&camera, middle)), None);
        for &p in &rim {
            assert_eq!(pick(&cup, &camera, pixel(&camera, p)), None);
        }
    }
    // seen from the side, the rim is a line at the upper end
    for camera in cameras(&cup, StandardView::Top) {
        let nearest = rim.iter().copied().max_by(|a, b| a.y.total_cmp(&b.y));
        let at = pixel(&camera, nearest.expect("a rim"));
        assert_eq!(pick(&cup, &camera, at), Some(LoopId::FIRST));
        let below = pixel(&camera, DVec3::new(0.0, 0.8, 0.6));
        assert_eq!(pick(&cup, &camera, below), None);
    }
}

#[test]
fn from_within_holes_are_picked_from_their_other_side() {
    let cup = cup();
    let mut camera = cameras(&cup, StandardView::Back)[0];
    // inside the sphere, looking towards +z
    camera.distance = 0.5;
    camera.pivot = DVec3::new(0.0, 0.0, 0.6);
    assert!(camera.eye().length() < 0.2);
    assert_eq!(
        pick(&cup, &camera, pixel(&camera, DVec3::Z)),
        Some(LoopId::FIRST)
    );
    let wall = pixel(&camera, DVec3::new(0.55, 0.0, 0.83));
    assert_eq!(pick(&cup, &camera, wall), None);
}

#[test]
fn the_nearer_of_two_openings_is_picked() {
    // a sphere with holes at both poles: the far one is visible through the near one
    let pipe = model(shapes::cut_where(&shapes::sphere(1500, 1), |p| {
        p.z.abs() > 0.9
    }));
    assert_eq!(pipe.loops.len(), 2);
    let north = (0..2)
        .find(|&i| pipe.loops[i].centroid.z > 0.0)
        .expect("one is above");
    for (view, expected) in [
        (StandardView::Front, north),
        (StandardView::Back, 1 - north),
    ] {
        for camera in cameras(&pipe, view) {
            let picker = |i: usize| {
                // these loops are holes, whatever their classification
                let mut loops = pipe.loops.clone();
                for l in &mut loops {
                    l.is_outer_boundary = false;
                }
                let picker = Picker::new(&pipe.mesh.positions, &pipe.mesh.topology, &loops);
                let at = pixel(&camera, DVec3::ZERO);
                picker.pick_loop(&camera, SIZE, at, TOLERANCE) == Some(i.into())
            };
            assert!(picker(expected));
        }
    }
}

#[test]
fn openings_of_any_outline_are_picked_exactly() {
    let shape = shapes::plane(2.0, 60, 1);
    let angle = HoleShape::Angle {
        arm: 1.0,
        width: 0.3,
    };
    let star = HoleShape::Star {
        outer: 0.5,
        inner: 0.2,
        points: 5,
    };
    for hole in [angle, star] {
        let cut = shapes::cut_holes(
            &shape,
            &[Hole {
                centre: DVec3::ZERO,
                shape: hole,
                turn: 0.3,
                seed: 4,
            }],
        );
        let plate = model(cut);
        let hole = plate
            .loops
            .iter()
            .find(|l| !l.is_outer_boundary)
            .map(|l| l.id);
        let hole = hole.expect("a hole and the border of the plane");
        for view in [StandardView::Front, StandardView::Back] {
            for camera in cameras(&plate, view) {
                let (mut inside, mut outside) = (0, 0);
                for x in (10..400).step_by(20) {
                    for y in (10..300).step_by(20) {
                        let at = [f64::from(x), f64::from(y)];
                        let surface = plate.picker.surface(&camera, SIZE, at);
                        let open = plate.picker.pick_loop(&camera, SIZE, at, 0.0);
                        let (o, d) = {
                            let ndc = [at[0] / 200.0 - 1.0, 1.0 - at[1] / 150.0];
                            camera.ray(ndc, SIZE[0] / SIZE[1])
                        };
                        let p = o - d * (o.z / d.z);
                        let within = p.x.abs() < 0.95 && p.y.abs() < 0.95;
                        // a point of the plate is on the surface or in the hole, never both
                        if within {
                            assert_eq!(open.is_some(), surface.is_none(), "{p}");
                            inside += usize::from(open == Some(hole));
                            outside += usize::from(surface.is_some());
                        } else if p.x.abs() > 1.05 || p.y.abs() > 1.05 {
                            // the outer boundary has no opening
                            assert_eq!((open, surface.is_some()), (None, false));
                        }
                    }
                }
                assert!(inside > 3 && outside > 20, "{inside} {outside}");
            }
        }
    }
}

#[test]
fn outer_boundaries_are_picked_by_their_line() {
    let plate = model(shapes::plane(2.0, 20, 1));
    assert!(plate.loops[0].is_outer_boundary);
    for camera in cameras(&plate, StandardView::Front) {
        let edge = pixel(&camera, DVec3::new(1.0, 0.2, 0.0));
        assert_eq!(pick(&plate, &camera, edge), Some(LoopId::FIRST));
        let beside = [edge[0] + 2.0 * TOLERANCE, edge[1]];
        assert_eq!(pick(&plate, &camera, beside), None);
        assert_eq!(pick(&plate, &camera, pixel(&camera, DVec3::ZERO)), None);
    }
}

#[test]
fn hits_are_under_the_cursor_and_in_front() {
    for (scale, shift) in [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e5)] {
        let (mut positions, triangles) = shapes::sphere(500, 2);
        for p in &mut positions {
            *p = *p * scale + DVec3::splat(shift);
        }
        let ball = model((positions, triangles));
        for camera in cameras(&ball, StandardView::Isometric) {
            let at = [210.0, 140.0];
            let hit = ball.picker.surface(&camera, SIZE, at).expect("a hit");
            let back = pixel(&camera, hit.point);
            assert!((back[0] - at[0]).hypot(back[1] - at[1]) < 1e-4);
            let outward = hit.point - DVec3::splat(shift);
            assert!(outward.dot(camera.forward()) < 0.0, "the near side");
            let corners = ball.mesh.corners(hit.face);
            let [a, b, c] = corners;
            let off = crate::mesh::closest_point_on_triangle(hit.point, a, b, c);
            assert!(off.distance(hit.point) < 1e-9 * (scale + shift));
            assert!(ball.picker.surface(&camera, SIZE, [1.0, 1.0]).is_none());
        }
    }
}

/// What a cut hides is not picked and hides nothing.
#[test]
fn a_cut_is_looked_through() {
    let cup = cup();
    let rim = cup.mesh.position(cup.loops[0].vertices[0]);
    let with_cut = |view| {
        cameras(&cup, view).map(|mut camera| {
            let (point, normal) = (DVec3::ZERO, DVec3::Z);
            camera.cut = Some(CutPlane { point, normal });
            camera
        })
    };
    let beside = DVec3::new(0.6, 0.0, 0.0);
    // the hole is in the hidden half
    for camera in with_cut(StandardView::Front) {
        assert_eq!(pick(&cup, &camera, pixel(&camera, rim)), None);
        assert_eq!(pick(&cup, &camera, pixel(&camera, DVec3::Z)), None);
        let hit = cup.picker.surface(&camera, SIZE, pixel(&camera, beside));
        assert!(hit.expect("the rear half").point.z < -0.5);
    }
    // the hole is seen from the inside
    for camera in with_cut(StandardView::Back) {
        let hole = Some(LoopId::FIRST);
        assert_eq!(pick(&cup, &camera, pixel(&camera, rim)), hole);
        assert_eq!(pick(&cup, &camera, pixel(&camera, DVec3::Z)), hole);
        let hit = cup.picker.surface(&camera, SIZE, pixel(&camera, beside));
        assert!(hit.expect("the other half").point.z > 0.5);
    }
}
