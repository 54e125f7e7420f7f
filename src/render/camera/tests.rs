use super::*;
use crate::options::Choice;

const ASPECT: f64 = 1.6;

fn cameras() -> Vec<Camera> {
    let mut all = Vec::new();
    for scale in [1e-6, 1.0, 1e6] {
        let centre = DVec3::new(3.0, -2.0, 5.0) * scale;
        let bounds = Bounds::new(centre - DVec3::splat(scale), centre + DVec3::ONE * scale);
        for orthographic in [false, true] {
            let mut camera = Camera::fit(&bounds);
            camera.orthographic = orthographic;
            camera.orbit(0.7, -0.4, false);
            camera.orientation *= DQuat::from_rotation_z(-0.2);
            all.push(camera);
            camera.set_pivot(centre + DVec3::new(0.5, 0.3, -0.2) * scale);
            all.push(camera);
        }
    }
    all
}

/// Points around the middle of the view.
fn points(camera: &Camera) -> [DVec3; 3] {
    [[0.1, 0.2, -0.3], [-0.2, 0.1, 0.2], [0.0, -0.25, 0.05]]
        .map(|p| camera.middle() + DVec3::from_array(p) * camera.half_height())
}

fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-9
}

fn seen(camera: &Camera, p: DVec3) -> [f64; 2] {
    camera.project(p, ASPECT).expect("in front of the eye")
}

#[test]
fn axes_are_orthonormal_and_right_handed() {
    for c in cameras() {
        assert!((c.right().cross(c.up()) + c.forward()).length() < 1e-12);
        assert!((c.orientation.length() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_projected_point_is_on_its_ray() {
    for c in cameras() {
        for p in points(&c) {
            let (origin, direction) = c.ray(seen(&c, p), ASPECT);
            let off = (p - origin).cross(direction).length();
            assert!(off < 1e-9 * c.distance, "{off:e}");
        }
    }
}

#[test]
fn zooming_keeps_the_point_under_the_cursor() {
    for c in cameras() {
        for cursor in [[0.0, 0.0], [0.7, -0.9], [-1.0, 0.4]] {
            let half = c.half_height();
            let p =
                c.middle() + c.right() * (cursor[0] * ASPECT * half) + c.up() * (cursor[1] * half);
            for factor in [0.5, 1.25, 40.0] {
                let mut after = c;
                after.zoom_to(factor, cursor, ASPECT);
                assert!(near(seen(&after, p), cursor));
                assert!((after.half_height() * factor / half - 1.0).abs() < 1e-12);
                // and the pivot keeps its place
                assert!(near(seen(&after, after.pivot), seen(&c, c.pivot)));
            }
        }
    }
}

#[test]
fn zooming_ends_in_front_of_the_surface_under_the_cursor() {
    for c in cameras() {
        let [point, ..] = points(&c);
        let cursor = seen(&c, point);
        let nearest = 0.01 * c.distance;
        let mut after = c;
        for _ in 0..60 {
            let before = after.distance;
            after.zoom_towards(Some(point), 1.2, nearest, cursor, ASPECT);
            assert!(near(seen(&after, point), cursor));
            assert!(after.distance >= 0.999 * nearest && after.distance <= before.max(c.distance));
        }
        assert!(after.pivot.distance(point) < 1e-9 * c.distance);
        assert!((after.distance / nearest - 1.0).abs() < 1e-9);
        // a camera that is nearer already stays there
        let mut still = after;
        still.zoom_towards(None, 2.0, 10.0 * nearest, cursor, ASPECT);
        assert_eq!(still.distance, after.distance);
        after.zoom_towards(Some(point), 0.5, nearest, cursor, ASPECT);
        assert!(after.distance > 1.9 * nearest);
    }
}

#[test]
fn a_new_pivot_does_not_change_the_picture_and_stays_in_place() {
    for c in cameras() {
        let [pivot, others @ ..] = points(&c);
        let mut after = c;
        after.set_pivot(pivot);
        for p in others {
            assert!(near(seen(&c, p), seen(&after, p)));
        }
        let place = seen(&after, pivot);
        after.orbit(0.3, 0.2, true);
        after.orbit(-0.1, 0.5, false);
        assert!(near(seen(&after, pivot), place));
        let behind = c.eye() - c.forward() * c.distance;
        let mut same = c;
        same.set_pivot(behind);
        assert_eq!(same.pivot == behind, c.orthographic);
    }
}

#[test]
fn panning_follows_the_mouse_at_the_pivot() {
    for c in cameras() {
        let mut after = c;
        after.pan(30.0, -20.0, 200.0);
        let p = c.middle();
        let place = seen(&after, p);
        assert!(near(place, [30.0 / (100.0 * ASPECT), 0.2]));
    }
}

#[test]
fn the_surface_follows_the_mouse_when_orbiting() {
    for turntable in [false, true] {
        let mut c = Camera::fit(&Bounds::default());
        c.standard_view(StandardView::Front);
        let front = DVec3::Z * 0.5;
        c.orbit(0.2, 0.1, turntable);
        let [x, y] = seen(&c, front);
        assert!(x > 0.01 && y < -0.01, "{x} {y}");
        // over the pole, the turntable still follows
        c.standard_view(StandardView::Front);
        c.orbit(0.0, 2.0, turntable);
        let nearest = c.eye().normalize() * 0.5;
        let before = seen(&c, nearest);
        c.orbit(0.2, 0.0, turntable);
        assert!(seen(&c, nearest)[0] > before[0]);
    }
}

#[test]
fn turntables_keep_the_vertical() {
    let mut c = Camera::fit(&Bounds::default());
    for i in 0..50 {
        c.orbit(0.3, 0.1 * f64::from(i % 7) - 0.3, true);
        assert!(c.right().y.abs() < 1e-12);
    }
}

#[test]
fn near_and_far_hold_the_bounds() {
    for scale in [1e-6, 1.0, 1e6] {
        let bounds = Bounds::new(DVec3::splat(9.0 * scale), DVec3::splat(11.0 * scale));
        for orthographic in [false, true] {
            let mut c = Camera::fit(&bounds);
            c.orthographic = orthographic;
            for zoom in [0.01, 1.0, 3.0] {
                let mut c = c;
                c.zoom_to(zoom, [0.1, 0.1], ASPECT);
                let matrix = c.view_projection(ASPECT, &bounds, bounds.centre());
                for i in 0..8 {
                    let pick = |k: u32| if i >> k & 1 == 0 { -scale } else { scale };
                    let p = DVec3::new(pick(0), pick(1), pick(2));
                    let clip = matrix * p.extend(1.0);
                    let ndc = clip.truncate() / clip.w;
                    let expected = seen(&c, bounds.centre() + p);
                    assert!(near([ndc.x, ndc.y], expected));
                    assert!((0.0..=1.0).contains(&ndc.z), "{scale} {zoom} {}", ndc.z);
                }
                // nearer is greater
                let toward = -c.forward() * 0.1 * scale;
                let depth = |p: DVec3| {
                    let clip = matrix * p.extend(1.0);
                    clip.z / clip.w
                };
                assert!(depth(toward) > depth(DVec3::ZERO));
            }
        }
    }
    // inside the bounds the near plane stays in front of the eye
    let mut c = Camera::fit(&Bounds::default());
    c.distance = 0.1;
    let [near, far] = c.near_far(&Bounds::default());
    assert!(near > 0.0 && near < 1e-4 && far > 0.5);
}

#[test]
fn fitting_shows_everything_in_any_format() {
    let bounds = Bounds::new(DVec3::new(-1.0, 2.0, 0.0), DVec3::new(3.0, 4.0, 1.0));
    for aspect in [0.3, 1.0, 3.0] {
        for &view in StandardView::ALL {
            for orthographic in [false, true] {
                let mut c = Camera::fit(&bounds);
                c.orthographic = orthographic;
                c.standard_view(view);
                c.fit_aspect(&bounds, aspect);
                for i in 0..8 {
                    let pick = |k: usize| {
                        if i >> k & 1 == 0 {
                            bounds.low[k]
                        } else {
                            bounds.high[k]
                        }
                    };
                    let p = DVec3::new(pick(0), pick(1), pick(2));
                    let [x, y] = c.project(p, aspect).expect("in front");
                    assert!(x.abs() < 1.0 && y.abs() < 1.0);
                }
            }
        }
    }
}

#[test]
fn standard_views_have_their_directions() {
    let from = |view| {
        let mut c = Camera::fit(&Bounds::default());
        c.standard_view(view);
        (c.eye().normalize(), c.up())
    };
    let close = |a: DVec3, b: DVec3| (a - b).length() < 1e-12;
    for (view, eye, up) in [
        (StandardView::Front, DVec3::Z, DVec3::Y),
        (StandardView::Back, DVec3::NEG_Z, DVec3::Y),
        (StandardView::Left, DVec3::NEG_X, DVec3::Y),
        (StandardView::Right, DVec3::X, DVec3::Y),
        (StandardView::Top, DVec3::Y, DVec3::NEG_Z),
        (StandardView::Bottom, DVec3::NEG_Y, DVec3::Z),
    ] {
        let (e, u) = from(view);
        assert!(close(e, eye) && close(u, up), "{view:?} {e} {u}");
    }
    let (eye, _) = from(StandardView::Isometric);
    assert!(close(eye, DVec3::ONE.normalize()));
}

#[test]
fn text_gives_the_same_picture_back() {
    for c in cameras() {
        let back = Camera::parse(&c.to_text(), &Bounds::default()).expect("its own text");
        for p in points(&c) {
            assert!(near(seen(&c, p), seen(&back, p)));
        }
        assert_eq!(
            back.to_text(),
            Camera::parse(&back.to_text(), &Bounds::default())
                .expect("again")
                .to_text()
        );
    }
    let bounds = Bounds::default();
    assert!(Camera::parse("Top", &bounds).is_ok());
    for (text, what) in [
        ("", "no such view"),
        ("sideways", "no such view"),
        ("1,2,3", "nine numbers"),
        ("0,0,0,0,0,0,1,5,x,persp", "not a number"),
        ("0,0,0,0,0,0,0,5,30,persp", "rotation"),
        ("0,0,0,0,0,0,1,-5,30,persp", "distance"),
        ("0,0,0,0,0,0,1,5,300,persp", "field of view"),
        ("0,0,0,0,0,0,1,5,30,fish", "neither"),
    ] {
        let error = Camera::parse(text, &bounds).expect_err(text).to_string();
        assert!(error.contains(what), "{error}");
    }
}

/// What is at the left edge of a wide picture stays at that of a narrow one; a wider one shows more.
#[test]
fn a_narrower_picture_keeps_its_width() {
    for orthographic in [false, true] {
        let mut camera = Camera::fit(&Bounds::new(-DVec3::ONE, DVec3::ONE));
        camera.orthographic = orthographic;
        let (origin, direction) = camera.ray([-1.0, 0.0], 1.6);
        let point = origin + 5.0 * direction;
        let mut narrow = camera;
        narrow.keep_width(1.6, 0.9);
        let [x, _] = narrow.project(point, 0.9).expect("in front");
        assert!((x + 1.0).abs() < 1e-12, "{x}");
        assert_eq!(narrow.eye(), camera.eye());
        let mut wide = camera;
        wide.keep_width(1.6, 2.0);
        assert!((wide.fov_y - camera.fov_y).abs() < 1e-12);
    }
}
