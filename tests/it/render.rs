//! Pictures, drawn on any available adapter, in software if necessary. Without an adapter these
//! tests fail and report what to install.

use std::sync::Arc;

use meniscus::mesh::{DVec3, FaceId, Topology};
use meniscus::options::Choice as _;
use meniscus::render::{
    Background, Bounds, Camera, CutPlane, DynamicSurface, Geometry, Gpu, Image, LineStyle, Marker,
    Material, Overlay, Polyline, Scene, StandardView, SurfaceOptions, Vertex, ViewMode, ViewStyle,
    colormap, picture,
};
use meniscus::shapes;

fn gpu() -> Gpu {
    Gpu::new().unwrap_or_else(|e| panic!("these tests need a graphics adapter: {e}"))
}

/// A sphere of radius 1 (up to 1e-3) around `centre`, in units of `scale`.
fn ball(scale: f64, centre: DVec3) -> Scene {
    let (positions, triangles) = shapes::icosphere(10);
    let topology = Topology::from_triangles(positions.len(), &triangles).expect("a sphere");
    let faces: Vec<FaceId> = topology.faces().collect();
    let surface = DynamicSurface::new(&topology, &faces, &SurfaceOptions::default());
    let placed: Vec<DVec3> = positions.iter().map(|&p| scale * p + centre).collect();
    let geometry = surface.evaluate(&placed, centre, true, None);
    scene(vec![geometry], Vec::new(), scale, centre)
}

fn scene(surfaces: Vec<Geometry>, overlays: Vec<Overlay>, scale: f64, centre: DVec3) -> Scene {
    Scene {
        centre,
        bounds: Bounds::new(centre - DVec3::splat(scale), centre + DVec3::splat(scale)),
        surfaces: surfaces.into_iter().map(Arc::new).collect(),
        overlays: overlays.into_iter().map(Arc::new).collect(),
    }
}

/// From the front, parallel; 1.25 units are half the height.
fn front(scale: f64, centre: DVec3) -> Camera {
    let mut camera = Camera::fit(&Bounds::new(
        centre - DVec3::splat(scale),
        centre + DVec3::splat(scale),
    ));
    camera.standard_view(StandardView::Front);
    camera.orthographic = true;
    camera.distance *= 1.25 * scale / camera.half_height();
    camera
}

fn isophotes(stripes: u32) -> ViewStyle {
    ViewStyle {
        mode: ViewMode::Isophotes,
        stripes,
        light: DVec3::new(0.0, 1.0, 0.0),
        background: Background::Gradient {
            top: [0.0, 0.0, 1.0],
            bottom: [0.0, 1.0, 0.0],
        },
        ..ViewStyle::default()
    }
}

const SIDE: u32 = 200;

fn shoot(gpu: &Gpu, scene: &Scene, camera: &Camera, style: &ViewStyle) -> image::RgbaImage {
    picture(gpu, scene, camera, style, [SIDE, SIDE], false).expect("a picture")
}

/// The place in the world of the middle of a pixel, from −1.25 to 1.25.
fn place(x: u32, y: u32) -> [f64; 2] {
    let at = |p: u32| 2.5 * (f64::from(p) + 0.5) / f64::from(SIDE) - 1.25;
    [at(x), -at(y)]
}

#[test]
fn isophotes_of_a_sphere_are_where_they_should_be() {
    let gpu = gpu();
    let stripes = 5;
    let image = shoot(
        &gpu,
        &ball(1.0, DVec3::ZERO),
        &front(1.0, DVec3::ZERO),
        &isophotes(stripes),
    );
    let (mut light, mut dark) = (0, 0);
    for (x, y, pixel) in image.enumerate_pixels() {
        let [px, py] = place(x, y);
        if px.hypot(py) > 0.95 {
            continue;
        }
        // n·l is the height on a unit sphere lit from above
        let phase = 0.5 * (py + 1.0) * f64::from(stripes) + 0.25;
        let in_period = phase.rem_euclid(1.0);
        // at least two pixels away from an edge of the wave; a pixel is 0.03 of a period
        let to_edge = (in_period - 0.5).abs().min(in_period).min(1.0 - in_period);
        if to_edge < 0.08 {
            continue;
        }
        let bright = pixel[0] > 128;
        assert_eq!(bright, in_period < 0.5, "{x} {y} {phase}: {pixel:?}");
        *(if bright { &mut light } else { &mut dark }) += 1;
    }
    assert!(light > 5000 && dark > 5000, "{light} {dark}");
}

#[test]
fn size_and_place_of_the_model_do_not_show() {
    let gpu = gpu();
    let style = isophotes(7);
    let reference = shoot(
        &gpu,
        &ball(1.0, DVec3::ZERO),
        &front(1.0, DVec3::ZERO),
        &style,
    );
    for (scale, centre) in [
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1e5, -2e5, 3e5)),
    ] {
        let image = shoot(&gpu, &ball(scale, centre), &front(scale, centre), &style);
        let differ = reference
            .pixels()
            .zip(image.pixels())
            .filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 8))
            .count();
        assert!(differ <= 20, "{scale} {centre}: {differ} pixels");
    }
}

#[test]
fn the_same_picture_twice_and_on_another_device() {
    let (scene, camera) = (ball(1.0, DVec3::ZERO), Camera::fit(&Bounds::default()));
    let style = isophotes(9);
    let first = gpu();
    let image = shoot(&first, &scene, &camera, &style);
    assert_eq!(shoot(&first, &scene, &camera, &style), image);
    assert_eq!(shoot(&gpu(), &scene, &camera, &style), image);
}

#[test]
fn background_and_transparency() {
    let gpu = gpu();
    let (scene, camera) = (ball(1.0, DVec3::ZERO), front(1.0, DVec3::ZERO));
    let style = isophotes(5);
    let image = shoot(&gpu, &scene, &camera, &style);
    let close = |a: [u8; 4], b: [u8; 4]| (0..4).all(|k| a[k].abs_diff(b[k]) <= 3);
    assert!(close(image.get_pixel(0, 0).0, [0, 1, 254, 255]));
    assert!(close(
        image.get_pixel(SIDE - 1, SIDE - 1).0,
        [0, 254, 1, 255]
    ));
    let clear = picture(&gpu, &scene, &camera, &style, [SIDE, SIDE], true).expect("a picture");
    let mut partly = 0;
    for (x, y, pixel) in clear.enumerate_pixels() {
        let [px, py] = place(x, y);
        let r = px.hypot(py);
        if r > 1.02 {
            assert_eq!(pixel.0, [0; 4]);
        } else if r < 0.98 {
            assert_eq!(pixel, image.get_pixel(x, y));
        } else {
            partly += usize::from(pixel[3] > 0 && pixel[3] < 255);
        }
    }
    assert!(partly > 50, "the outline is smooth: {partly}");
}

#[test]
fn large_pictures_are_put_together_without_seams() {
    // more than one tile each way; a band of pixels around the seam is compared with a shifted view
    let gpu = gpu();
    let (scene, camera) = (ball(1.0, DVec3::ZERO), front(1.0, DVec3::ZERO));
    let (width, height) = (2200, 60);
    let style = ViewStyle {
        wireframe: true,
        ..isophotes(6)
    };
    let image = picture(&gpu, &scene, &camera, &style, [width, height], false).expect("a picture");
    let mut shifted = camera;
    // 100 pixels to the left, so that the seam falls elsewhere
    shifted.pan(-100.0, 0.0, f64::from(height));
    let other = picture(&gpu, &scene, &shifted, &style, [width, height], false).expect("a picture");
    let mut differ = 0;
    for x in 1100..width - 100 {
        for y in 0..height {
            let (a, b) = (image.get_pixel(x, y), other.get_pixel(x - 100, y));
            // the ground's noise depends on the place
            differ += usize::from((0..3).any(|k| a[k].abs_diff(b[k]) > 12));
        }
    }
    assert!(differ <= 10, "{differ}");
    let error = picture(&gpu, &scene, &camera, &style, [0, 10], false).expect_err("no pixels");
    assert!(error.to_string().contains("0 × 10"), "{error}");
    assert!(picture(&gpu, &scene, &camera, &style, [8193, 10], false).is_err());
}

#[test]
fn maps_show_the_colours_of_the_legend() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    for (mode, value) in [
        (ViewMode::Mean, -1.0f32),
        (ViewMode::Gauss, 1.0),
        (ViewMode::K1, -1.0),
        (ViewMode::K2, -1.0),
    ] {
        let style = ViewStyle {
            mode,
            range: Some([-2.0, 1.5]),
            ..ViewStyle::default()
        };
        let image = shoot(&gpu, &ball(1.0, DVec3::ZERO), &camera, &style);
        let expected = colormap((value + 2.0) / 3.5);
        let pixel = image.get_pixel(SIDE / 2 + 3, SIDE / 2 + 5).0;
        // light reduces all three linear channels by the same factor
        let linear = |c: f64| ((c + 0.055) / 1.055).powf(2.4);
        let ratio = |k: usize| linear(f64::from(pixel[k]) / 255.0) / linear(f64::from(expected[k]));
        let [r, g, b] = [ratio(0), ratio(1), ratio(2)];
        assert!((0.6..1.05).contains(&g), "{mode:?} {pixel:?} {expected:?}");
        assert!(
            (r / g - 1.0).abs() < 0.1 && (b / g - 1.0).abs() < 0.1,
            "{mode:?} {r} {g} {b}"
        );
    }
}

#[test]
fn colours_of_the_file_are_drawn_with_light_and_under_stripes() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    let mut scene = ball(1.0, DVec3::ZERO);
    let mut geometry = (*scene.surfaces[0]).clone();
    for v in &mut geometry.vertices {
        v.color = if v.position[0] < 0.0 {
            [200, 40, 40, 255]
        } else {
            [0; 4]
        };
    }
    scene.surfaces = vec![Arc::new(geometry)];
    let drawn = |style: &ViewStyle| {
        let image = shoot(&gpu, &scene, &camera, style);
        // left of the middle red, right of it the plain material
        [SIDE / 3, 2 * SIDE / 3].map(|x| image.get_pixel(x, SIDE / 2 + 5).0)
    };
    let is_red = |[r, g, b, _]: [u8; 4]| r > 60 && r / 2 > g && r / 2 > b;
    for (mode, stripes_on_colors, red) in [
        (ViewMode::Shaded, false, false),
        (ViewMode::Color, false, true),
        (ViewMode::Isophotes, false, false),
        (ViewMode::Isophotes, true, true),
        (ViewMode::Zebra, true, true),
        (ViewMode::Mean, false, false),
    ] {
        let style = ViewStyle {
            mode,
            stripes_on_colors,
            ..ViewStyle::default()
        };
        let [left, right] = drawn(&style);
        assert_eq!(is_red(left), red, "{mode:?} {left:?}");
        assert!(!is_red(right), "{mode:?} {right:?}");
    }
}

#[test]
fn texture_images_lie_where_their_coordinates_say() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    // red, green in the upper row, blue, white in the lower one
    let colors = [
        [200, 0, 0, 255],
        [0, 200, 0, 255],
        [0, 0, 200, 255],
        [200, 200, 200, 255],
    ];
    let pixels = image::RgbaImage::from_fn(64, 64, |x, y| {
        image::Rgba(colors[(2 * (y / 32) + x / 32) as usize])
    });
    let corners = [[-1.0f32, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let vertices = corners.map(|[x, y]| Vertex {
        position: [x, y, 0.0],
        normal: [0.0, 0.0, 1.0],
        flags: Vertex::TEXTURED,
        uv: [0.5 + 0.5 * x, 0.5 - 0.5 * y],
        ..Vertex::default()
    });
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    let mut geometry = Geometry::new(vertices.to_vec(), triangles, Vec::new());
    let style = ViewStyle {
        mode: ViewMode::Color,
        ..ViewStyle::default()
    };
    let drawn = |geometry: &Geometry| {
        let scene = scene(vec![geometry.clone()], Vec::new(), 1.0, DVec3::ZERO);
        let image = shoot(&gpu, &scene, &camera, &style);
        [[60, 60], [140, 60], [60, 140], [140, 140]].map(|[x, y]| image.get_pixel(x, y).0)
    };
    geometry.textures = vec![(0..2, Arc::new(Image::new(pixels.clone())))];
    let brightest = |p: [u8; 4]| [0, 1, 2].map(|k| p[k] > 60);
    let [red, green, blue, white] = drawn(&geometry).map(brightest);
    assert_eq!(red, [true, false, false]);
    assert_eq!(green, [false, true, false]);
    assert_eq!(blue, [false, false, true]);
    assert_eq!(white, [true, true, true]);
    // one of two triangles: the other one is black, because no image is bound
    geometry = Geometry::new(geometry.vertices, geometry.triangles, Vec::new());
    geometry.textures = vec![(1..2, Arc::new(Image::new(pixels)))];
    let [red, _, _, white] = drawn(&geometry).map(brightest);
    assert_eq!((red, white), ([true, false, false], [false; 3]));
}

#[test]
fn both_sides_are_lit_and_differ_and_patches_are_tinted() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    let square = |flip: bool, flags: u32| {
        let vertex = |x: f32, y: f32| Vertex {
            position: [x, y, 0.0],
            normal: [0.0, 0.0, if flip { -1.0 } else { 1.0 }],
            flags,
            ..Vertex::default()
        };
        let corners = [[-1., -1.], [1., -1.], [1., 1.], [-1., 1.]];
        let vertices = corners.map(|[x, y]| vertex(x, y)).to_vec();
        let turn = |[a, b, c]: [u32; 3]| if flip { [a, c, b] } else { [a, b, c] };
        let triangles = [[0, 1, 2], [0, 2, 3]].map(turn).to_vec();
        let geometry = Geometry::new(vertices, triangles, Vec::new());
        let scene = scene(vec![geometry], Vec::new(), 1.0, DVec3::ZERO);
        let image = shoot(&gpu, &scene, &camera, &ViewStyle::default());
        image.get_pixel(SIDE / 2, SIDE / 2).0
    };
    let (front, back) = (square(false, 0), square(true, 0));
    let apart = |a: [u8; 4], b: [u8; 4]| (0..3).any(|k| a[k].abs_diff(b[k]) > 30);
    assert!(apart(front, back), "{front:?} {back:?}");
    assert!(back.iter().take(3).all(|&c| c > 40), "lit: {back:?}");
    let patch = square(false, Vertex::PATCH);
    assert!(patch[0] > patch[2] + 60, "warm: {patch:?}");
    assert!(apart(front, square(false, Vertex::SELECTED)));
    assert!(apart(front, square(false, Vertex::ILL_POSED)) || apart(front, back));
}

#[test]
fn lines_are_drawn_in_front_faintly_behind_and_always() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    let ball = ball(1.0, DVec3::ZERO);
    let background = ViewStyle::default();
    let plain = shoot(&gpu, &ball, &camera, &background);
    // how much a horizontal line changes the middle of the picture, as in front of or behind it
    let change = |style: LineStyle, z: f32| -> i32 {
        let line = Polyline {
            points: vec![[-0.5, 0.0, z], [0.1, 0.0, z], [0.5, 0.0, z]],
            closed: false,
            color: [1.0, 0.9, 0.0, 1.0],
            width_px: 4.0,
            style,
        };
        let mut with_line = ball.clone();
        with_line.overlays = vec![Arc::new(Overlay::new(vec![line], Vec::new()))];
        let image = shoot(&gpu, &with_line, &camera, &background);
        let at = |i: &image::RgbaImage| i.get_pixel(SIDE / 2 + 20, SIDE / 2).0;
        let (a, b) = (at(&image), at(&plain));
        (0..3).map(|k| i32::from(a[k].abs_diff(b[k]))).sum()
    };
    let clear = change(LineStyle::OnTop, -1.5);
    assert!(clear > 150, "{clear}");
    assert_eq!(change(LineStyle::OnTop, 1.5), clear);
    assert_eq!(change(LineStyle::Depth, 1.5), clear);
    assert_eq!(change(LineStyle::Depth, -1.5), 0);
    assert_eq!(change(LineStyle::OnTopFaintWhenHidden, 1.5), clear);
    let faint = change(LineStyle::OnTopFaintWhenHidden, -1.5);
    assert!(faint > 20 && faint < clear / 2, "{faint} {clear}");
}

#[test]
fn markers_and_casings_keep_lines_visible_on_any_ground() {
    let gpu = gpu();
    let camera = front(1.0, DVec3::ZERO);
    let marker = Marker {
        position: [0.0; 3],
        color: [1.0, 1.0, 1.0, 1.0],
        radius_px: 6.0,
        style: LineStyle::OnTop,
    };
    for ground in [[0.0; 3], [1.0; 3], [0.5; 3]] {
        let style = ViewStyle {
            background: Background::Gradient {
                top: ground,
                bottom: ground,
            },
            ..ViewStyle::default()
        };
        let overlay = Overlay::new(Vec::new(), vec![marker]);
        let scene = scene(Vec::new(), vec![overlay], 1.0, DVec3::ZERO);
        let image = shoot(&gpu, &scene, &camera, &style);
        let row: Vec<u8> = (0..SIDE).map(|x| image.get_pixel(x, SIDE / 2)[0]).collect();
        let brightest = row.iter().max().expect("pixels");
        let darkest = row.iter().min().expect("pixels");
        assert!(
            brightest - darkest > 180,
            "{ground:?}: {darkest} {brightest}"
        );
    }
}

/// The half towards the eye is hidden with its lines, from either side; lines in the plane stay.
#[test]
fn a_cut_hides_the_half_in_front() {
    let gpu = gpu();
    let line = |z: f32, y: f32| Polyline {
        points: vec![[-0.9, y, z], [0.9, y, z]],
        closed: false,
        color: [0.0, 1.0, 0.0, 1.0],
        width_px: 6.0,
        style: LineStyle::OnTop,
    };
    let mut one = ball(1.0, DVec3::ZERO);
    let lines = vec![line(0.5, 0.4), line(0.0, -0.4)];
    one.overlays = vec![Arc::new(Overlay::new(lines, Vec::new()))];
    let style = ViewStyle::default();
    let pixel = |image: &image::RgbaImage, y: f64| {
        let row = (f64::from(SIDE) * (0.5 - y / 2.5)) as u32;
        *image.get_pixel(SIDE / 2, row)
    };
    let is_line = |p: image::Rgba<u8>| p[1] > 200 && p[0] < 60;
    // the inside of the ball is reddish, its outside bluish
    let is_inside = |p: image::Rgba<u8>| p[0] > p[2];
    let mut camera = front(1.0, DVec3::ZERO);
    let whole = shoot(&gpu, &one, &camera, &style);
    assert!(!is_inside(pixel(&whole, 0.0)));
    assert!(is_line(pixel(&whole, 0.4)) && is_line(pixel(&whole, -0.4)));
    camera.cut = Some(CutPlane {
        point: DVec3::ZERO,
        normal: DVec3::Z,
    });
    let cut = shoot(&gpu, &one, &camera, &style);
    assert!(is_inside(pixel(&cut, 0.0)));
    assert!(!is_line(pixel(&cut, 0.4)) && is_line(pixel(&cut, -0.4)));
    camera.standard_view(StandardView::Back);
    let behind = shoot(&gpu, &one, &camera, &style);
    assert!(is_inside(pixel(&behind, 0.0)) && is_line(pixel(&behind, 0.4)));
}

/// Each material shades differently, tints patches, and leaves other modes alone.
#[test]
fn materials_shade_surfaces() {
    let gpu = gpu();
    let (one, camera) = (ball(1.0, DVec3::ZERO), front(1.0, DVec3::ZERO));
    let with = |material: Material, mode: ViewMode| {
        let style = ViewStyle {
            material,
            mode,
            ..ViewStyle::default()
        };
        shoot(&gpu, &one, &camera, &style)
    };
    let shaded: Vec<_> = Material::ALL
        .iter()
        .map(|&m| with(m, ViewMode::Shaded))
        .collect();
    for (i, a) in shaded.iter().enumerate() {
        for b in &shaded[i + 1..] {
            let pairs = a.pixels().zip(b.pixels());
            let differ = pairs.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 15));
            assert!(differ.count() > 8_000);
        }
    }
    // lit from above at the left
    let clay = &shaded[1];
    let brightness = |x, y| {
        clay.get_pixel(x, y).0[..3]
            .iter()
            .map(|&c| u32::from(c))
            .sum::<u32>()
    };
    assert!(brightness(70, 60) > brightness(130, 150) + 50);
    let [plain, steel] = [Material::Plain, Material::Steel].map(|m| with(m, ViewMode::Mean));
    assert_eq!(plain, steel);
}
