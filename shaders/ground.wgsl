// The background: a gradient from the top to the bottom of the whole picture.

@vertex
fn vs_ground(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // one triangle that covers the target
    let corner = vec2(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    return vec4(corner, 0.0, 1.0);
}

@fragment
fn fs_ground(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let t = (frame.tile.y + at.y) / frame.size.y;
    let colour = mix(frame.ground_top, frame.ground_bottom, t);
    // noise below one colour level, which avoids visible bands in the gradient
    let place = frame.tile.xy + at.xy;
    let noise = fract(52.9829189 * fract(dot(place, vec2(0.06711056, 0.00583715)))) - 0.5;
    return vec4(colour.rgb + noise / 255.0 * colour.a, colour.a);
}
