// Surfaces: light, colours of the file, isophotes, zebra, maps of curvature and deviation.

const SHADED = 0u;
const COLOUR = 1u;
const ISOPHOTES = 2u;
const ZEBRA = 3u;
const MEAN = 4u;
const GAUSS = 5u;
const K1 = 6u;
const K2 = 7u;
const DEVIATION = 8u;
const DISTANCE = 9u;

const PATCH = 1u;
const ILL_POSED = 2u;
const SELECTED = 4u;
const CURVATURE = 8u;
const DEVIATION_KNOWN = 16u;
const DISTANCE_KNOWN = 32u;
const TEXTURED = 64u;

// Materials: the light of a sphere of each, seen from the front.
@group(0) @binding(1) var materials: texture_2d_array<f32>;
@group(0) @binding(2) var material_sampler: sampler;
@group(1) @binding(0) var picture: texture_2d<f32>;
@group(1) @binding(1) var picture_sampler: sampler;

// Colour of the front of the mesh (sRGB).
const PLAIN = vec3(0.70, 0.73, 0.77);

struct SurfaceVertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) mean: f32,
    @location(3) gauss: f32,
    @location(4) deviation: f32,
    @location(5) flags: u32,
    // of the file (sRGB); opacity 0 if it is unknown
    @location(6) colour: vec4<f32>,
    // place in the picture
    @location(7) uv: vec2<f32>,
}

struct SurfacePoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    // mapped number, 1 if it is known, 1 if the flow is ill-posed
    @location(2) value: vec3<f32>,
    @location(3) @interpolate(flat) flags: u32,
    @location(4) colour: vec4<f32>,
    @location(5) uv: vec2<f32>,
}

@vertex
fn vs_surface(v: SurfaceVertex) -> SurfacePoint {
    var out: SurfacePoint;
    out.position = v.position * frame.eye.w;
    out.clip = to_tile(frame.clip_from_scaled * vec4(out.position, 1.0));
    out.normal = v.normal;
    let mode = frame.choice.x;
    // principal curvatures are computed at the vertices, because the root of interpolated H and K
    // would be noisy
    let spread = sqrt(max(v.mean * v.mean - v.gauss, 0.0));
    var value = v.mean;
    if mode == GAUSS {
        value = v.gauss;
    } else if mode == K1 {
        value = v.mean + spread;
    } else if mode == K2 {
        value = v.mean - spread;
    } else if mode == DEVIATION || mode == DISTANCE {
        value = v.deviation;
    }
    var needed = CURVATURE;
    if mode == DEVIATION {
        needed = DEVIATION_KNOWN;
    } else if mode == DISTANCE {
        needed = DISTANCE_KNOWN;
    }
    let known = select(0.0, 1.0, (v.flags & needed) != 0u);
    let ill = select(0.0, 1.0, (v.flags & ILL_POSED) != 0u);
    // relative to the range, so that the exponent does not overflow
    out.value = vec3((value - frame.range.x) * frame.range.y, known, ill);
    out.flags = v.flags;
    out.colour = v.colour;
    out.uv = v.uv;
    return out;
}

// Mean of a square wave of period 1 (1 on the first half) over an interval of the given width.
fn bands(phase: f32, width: f32) -> f32 {
    let w = max(width, 1e-4);
    let low = phase - 0.5 * w;
    let high = phase + 0.5 * w;
    let integral_low = 0.5 * floor(low) + min(fract(low), 0.5);
    let integral_high = 0.5 * floor(high) + min(fract(high), 0.5);
    return (integral_high - integral_low) / w;
}

fn change(x: f32) -> f32 {
    return length(vec2(dpdx(x), dpdy(x)));
}

// The stops of the colour map, which are inserted here.
//MAP

fn colormap(t: f32) -> vec3<f32> {
    let at = clamp(t, 0.0, 1.0) * f32(MAP_STOPS - 1u);
    let i = min(u32(at), MAP_STOPS - 2u);
    var map = MAP;
    return mix(map[i], map[i + 1u], at - f32(i));
}

// Linear light on a surface of unit colour, and its gloss in w. The light is soft and moves with the
// camera: sky above and ground below, a broad key light, and a rim light along the outline.
fn light(n: vec3<f32>, towards_eye: vec3<f32>) -> vec4<f32> {
    let sky = 0.5 + 0.5 * dot(n, frame.up.xyz);
    let around = mix(vec3(0.20, 0.18, 0.17), vec3(0.36, 0.38, 0.42), sky);
    let key = normalize(-0.45 * frame.right.xyz + 0.65 * frame.up.xyz + 0.75 * frame.back.xyz);
    let wrapped = 0.5 + 0.5 * dot(n, key);
    let diffuse = vec3(0.60, 0.59, 0.57) * wrapped * wrapped;
    let outline = 1.0 - max(dot(n, towards_eye), 0.0);
    let rim = vec3(0.20, 0.22, 0.26) * sky * outline * outline * outline;
    let half_way = normalize(key + towards_eye);
    let gloss = 0.10 * pow(max(dot(n, half_way), 0.0), 32.0);
    return vec4(around + diffuse + rim, gloss);
}

// Linear light of a material on a surface that faces as `n`.
fn material_light(material: u32, n: vec3<f32>, towards_eye: vec3<f32>) -> vec3<f32> {
    let right = normalize(cross(frame.up.xyz, towards_eye));
    let up = cross(towards_eye, right);
    let at = 0.5 + 0.49 * vec2(dot(n, right), -dot(n, up));
    return linear_from_srgb(textureSampleLevel(materials, material_sampler, at, material - 1u, 0.0).rgb);
}

@fragment
fn fs_surface(
    p: SurfacePoint,
    @builtin(front_facing) front: bool,
) -> @location(0) vec4<f32> {
    let texel = textureSample(picture, picture_sampler, p.uv);
    // both sides are lit; the back has different colours
    let outward = normalize(p.normal + vec3(0.0, 0.0, 1e-20));
    let n = select(-outward, outward, front);
    let sight = select(frame.back.xyz, normalize(frame.eye.xyz - p.position), frame.back.w > 0.5);
    let lit = light(n, sight);
    let brightness = min(dot(lit.rgb, vec3(0.2126, 0.7152, 0.0722)), 1.1);
    let mode = frame.choice.x;
    let stripes = frame.light.w;

    let mirrored = reflect(-sight, n);
    let to_light = dot(n, frame.light.xyz);
    let to_sky = dot(mirrored, frame.light.xyz);
    // a quarter more, so that both ends of the range are in the middle of a light band
    let phase = 0.5 * (select(to_light, to_sky, mode == ZEBRA) + 1.0) * stripes + 0.25;
    let band = bands(phase, change(phase));

    let textured = (p.flags & TEXTURED) != 0u;
    let has_colour = textured || p.colour.a > 0.999;
    let coloured = has_colour && (frame.choice.y & 2u) != 0u;
    let material = frame.choice.y >> 2u;
    let in_patch = (p.flags & PATCH) != 0u && (frame.choice.y & 1u) != 0u && !coloured;
    let selected = (p.flags & SELECTED) != 0u;
    var base = select(vec3(0.44, 0.33, 0.40), PLAIN, front);
    if in_patch {
        base = select(vec3(0.45, 0.33, 0.20), vec3(0.94, 0.82, 0.60), front);
    }
    if coloured {
        base = select(p.colour.rgb, texel.rgb, textured) * select(0.55, 1.0, front);
    }
    if selected {
        base = mix(base, vec3(0.20, 0.45, 0.95), 0.5);
    }
    var colour = vec3(0.0);
    if mode == SHADED && material > 0u {
        let colour_of_base = linear_from_srgb(base) / linear_from_srgb(PLAIN);
        colour = colour_of_base * material_light(material, n, sight);
    } else if mode == SHADED || mode == COLOUR {
        colour = linear_from_srgb(base) * lit.rgb + lit.w;
    } else if mode == ISOPHOTES || mode == ZEBRA {
        // light bands have the brightened colour of the surface, dark ones the same hue
        let plain = front && !in_patch && !selected;
        let bright = mix(vec3(1.0), base, select(select(0.75, 0.35, plain), 1.0, coloured));
        let dark = base * select(select(0.15, 0.24, in_patch), 0.45, coloured);
        let stripe = mix(linear_from_srgb(dark), linear_from_srgb(bright), band);
        colour = stripe * mix(1.0, brightness, 0.5);
    } else {
        let unknown = vec3(0.55);
        let mapped = mix(unknown, colormap(p.value.x), step(0.999, p.value.y));
        // the colour must stay legible: half of the light, and a darker back
        colour = linear_from_srgb(mapped) * mix(1.0, brightness, 0.5) * select(0.55, 1.0, front);
    }
    if selected {
        // also on dark bands and maps
        colour = mix(colour, linear_from_srgb(vec3(0.25, 0.50, 1.0)), 0.35);
    }
    if frame.choice.z != 0u && p.value.z > 0.5 {
        // hatching, in pixels of the picture
        let across = (frame.tile.x + p.clip.x + frame.tile.y + p.clip.y) / (9.0 * frame.size.z);
        let hatch = bands(across, 0.35);
        colour = mix(colour, linear_from_srgb(vec3(0.80, 0.05, 0.45)), 0.8 * hatch);
    }
    if before_cut(p.position) > 0.0 {
        discard;
    }
    return vec4(srgb_from_linear(colour), 1.0);
}
