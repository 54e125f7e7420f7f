// Lines and markers: a quad for each segment, expanded in pixels and clipped to a capsule. A marker
// is a segment of length 0. Colours are premultiplied.

// Colour of the lines where patches join the mesh.
const SEAM = vec4(0.78, 0.40, 0.05, 0.85);
// Width of the dark casing on each side of a line in pixels.
const CASING = 1.5;

struct Segment {
    @location(0) start: vec3<f32>,
    @location(1) end: vec3<f32>,
    @location(2) colour: vec4<f32>,
    @location(3) width: f32,
}

struct LinePoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>,
    // along and across the segment, in pixels from its start
    @location(1) at: vec2<f32>,
    @location(2) @interpolate(flat) length: f32,
    @location(3) @interpolate(flat) half_width: f32,
}

// A point of a line in clip space, shifted slightly towards the eye so that its surface does not
// hide it.
fn pulled(position: vec3<f32>) -> vec4<f32> {
    var at = position * frame.eye.w;
    if frame.back.w > 0.5 {
        at += (frame.eye.xyz - at) * frame.size.w;
    } else {
        at += frame.back.xyz * frame.size.w;
    }
    return frame.clip_from_scaled * vec4(at, 1.0);
}

fn expand(
    start: vec3<f32>,
    end: vec3<f32>,
    colour: vec4<f32>,
    half_width: f32,
    casing: f32,
    corner: u32,
) -> LinePoint {
    var out: LinePoint;
    out.colour = colour;
    out.half_width = half_width;
    out.length = 0.0;
    out.at = vec2(0.0);
    // clip the part that the cut hides
    let from_cut = vec2(before_cut(start * frame.eye.w), before_cut(end * frame.eye.w));
    if from_cut.x > 0.0 && from_cut.y > 0.0 {
        out.clip = vec4(0.0, 0.0, -1.0, 1.0);
        return out;
    }
    let met = from_cut.x / (from_cut.x - from_cut.y);
    var a = pulled(select(start, mix(start, end, met), from_cut.x > 0.0));
    var b = pulled(select(end, mix(start, end, met), from_cut.y > 0.0));
    // clip the part behind the eye
    let least = bitcast<f32>(frame.choice.w);
    if a.w < least && b.w < least {
        out.clip = vec4(0.0, 0.0, -1.0, 1.0);
        return out;
    }
    if a.w < least {
        a = mix(a, b, (least - a.w) / (b.w - a.w));
    } else if b.w < least {
        b = mix(b, a, (least - b.w) / (a.w - b.w));
    }
    let from_ndc = 0.5 * frame.size.xy;
    let pixel_a = a.xy / a.w * from_ndc;
    let pixel_b = b.xy / b.w * from_ndc;
    let between = pixel_b - pixel_a;
    let span = length(between);
    let along = select(vec2(1.0, 0.0), between / max(span, 1e-6), span > 1e-6);
    let across = vec2(-along.y, along.x);
    let reach = half_width + casing + 1.0;
    let at_end = (corner & 1u) != 0u;
    let side = select(-reach, reach, (corner & 2u) != 0u);
    let beyond = select(-reach, reach, at_end);
    let pixel = select(pixel_a, pixel_b, at_end) + along * beyond + across * side;
    let depth = select(a.z / a.w, b.z / b.w, at_end);
    out.clip = to_tile(vec4(pixel / from_ndc, depth, 1.0));
    out.at = vec2(select(0.0, span, at_end) + beyond, side);
    out.length = span;
    return out;
}

@vertex
fn vs_line(s: Segment, @builtin(vertex_index) corner: u32) -> LinePoint {
    let scale = frame.size.z;
    return expand(s.start, s.end, s.colour, 0.5 * s.width * scale, CASING * scale, corner);
}

@vertex
fn vs_wire(
    @location(0) start: vec3<f32>,
    @location(1) end: vec3<f32>,
    @builtin(vertex_index) corner: u32,
) -> LinePoint {
    return expand(start, end, frame.wire, 0.5 * frame.size.z, 0.0, corner);
}

@vertex
fn vs_seam(
    @location(0) start: vec3<f32>,
    @location(1) end: vec3<f32>,
    @builtin(vertex_index) corner: u32,
) -> LinePoint {
    return expand(start, end, SEAM, 0.8 * frame.size.z, 0.0, corner);
}

// Fraction of a pixel within `reach` of the segment.
fn coverage(p: LinePoint, reach: f32) -> f32 {
    let nearest = clamp(p.at.x, 0.0, p.length);
    let distance = length(vec2(p.at.x - nearest, p.at.y));
    return clamp(reach - distance + 0.5, 0.0, 1.0);
}

@fragment
fn fs_casing(p: LinePoint) -> @location(0) vec4<f32> {
    let alpha = 0.85 * p.colour.a * coverage(p, p.half_width + CASING * frame.size.z);
    if alpha <= 0.0 {
        discard;
    }
    return vec4(vec3(0.05) * alpha, alpha);
}

@fragment
fn fs_core(p: LinePoint) -> @location(0) vec4<f32> {
    let alpha = p.colour.a * coverage(p, p.half_width);
    if alpha <= 0.0 {
        discard;
    }
    return vec4(p.colour.rgb * alpha, alpha);
}

// Behind the surface: thinner and faint.
@fragment
fn fs_hidden(p: LinePoint) -> @location(0) vec4<f32> {
    let alpha = frame.range.z * p.colour.a * coverage(p, 0.6 * p.half_width);
    if alpha <= 0.0 {
        discard;
    }
    return vec4(p.colour.rgb * alpha, alpha);
}
