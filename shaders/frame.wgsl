// Shared by all passes: the uniforms of the frame, colour spaces, the transformation to a tile.

struct Frame {
    // from positions times `scale` to clip space, depth 1 near and 0 far
    clip_from_scaled: mat4x4<f32>,
    // axes of the camera in the world
    right: vec4<f32>,
    up: vec4<f32>,
    // towards the eye; w is 1 in perspective and 0 in a parallel projection
    back: vec4<f32>,
    // times `scale`; w is `scale`, which scales the scene to size 1
    eye: vec4<f32>,
    // direction to the light of isophotes, or across the lines of the zebra environment, in the
    // world; w is the number of bands
    light: vec4<f32>,
    // of the colour map: low end, one over the width; then the opacity of hidden lines
    range: vec4<f32>,
    // of the whole picture in pixels; then the factor on line widths and the shift of lines towards
    // the eye
    size: vec4<f32>,
    // the drawn tile of the picture: corner and size in pixels
    tile: vec4<f32>,
    ground_top: vec4<f32>,
    ground_bottom: vec4<f32>,
    wire: vec4<f32>,
    // hidden half space: unit vector towards the eye, and the distance of its plane along it
    cut: vec4<f32>,
    // view mode, surface (bits: tint patches, colours of the file; then the material), hatch ill-posed points, minimum depth in front of the eye (bits)
    choice: vec4<u32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Distance of a point (times `scale`) in front of the cut, where it is hidden. Lines in the plane of the
// cut stay visible.
fn before_cut(position: vec3<f32>) -> f32 {
    return dot(frame.cut.xyz, position) - frame.cut.w - 1e-4;
}

fn srgb_from_linear(c: vec3<f32>) -> vec3<f32> {
    let x = clamp(c, vec3(0.0), vec3(1.0));
    let high = 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055;
    return select(high, 12.92 * x, x <= vec3(0.0031308));
}

fn linear_from_srgb(c: vec3<f32>) -> vec3<f32> {
    let high = pow((c + 0.055) / 1.055, vec3(2.4));
    return select(high, c / 12.92, c <= vec3(0.04045));
}

// From clip space of the whole picture to that of the tile.
fn to_tile(clip: vec4<f32>) -> vec4<f32> {
    let scale = frame.size.xy / frame.tile.zw;
    // centre of the tile in the picture's normalized coordinates
    let centre = (2.0 * frame.tile.xy + frame.tile.zw) / frame.size.xy - 1.0;
    let shift = vec2(-centre.x, centre.y) * scale;
    return vec4(clip.xy * scale + shift * clip.w, clip.zw);
}
