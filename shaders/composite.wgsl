// Copies the finished picture of a viewport into the window.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

struct CompositePoint {
    @builtin(position) clip: vec4<f32>,
    @location(0) at: vec2<f32>,
}

@vertex
fn vs_composite(@builtin(vertex_index) index: u32) -> CompositePoint {
    let corner = vec2(f32(index & 1u) * 2.0, f32(index >> 1u) * 2.0);
    var out: CompositePoint;
    out.clip = vec4(2.0 * corner.x - 1.0, 1.0 - 2.0 * corner.y, 0.0, 1.0);
    out.at = corner;
    return out;
}

// For a target with encoded colours, as that of egui.
@fragment
fn fs_encoded(p: CompositePoint) -> @location(0) vec4<f32> {
    return textureSample(picture, picture_sampler, p.at);
}

// For a target that encodes colours itself.
@fragment
fn fs_linear(p: CompositePoint) -> @location(0) vec4<f32> {
    let c = textureSample(picture, picture_sampler, p.at);
    let high = pow((c.rgb + 0.055) / 1.055, vec3(2.4));
    return vec4(select(high, c.rgb / 12.92, c.rgb <= vec3(0.04045)), c.a);
}
