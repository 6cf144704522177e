// The picture of the reference renderer: see the render module's documentation.

struct Item {
    clip_from_model: mat4x4f,
    light_in_model: vec3f,
    layer: u32,
    ambient: vec3f,
    id: u32,
    diffuse: vec3f,
}

@group(0) @binding(0) var textures: texture_2d_array<f32>;
@group(0) @binding(1) var bilinear: sampler;
// A uniform of its own for each draw: lavapipe reads storage buffers vertex by vertex, which took a third of a tile's time.
@group(1) @binding(0) var<uniform> item: Item;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
    @location(1) incidence: f32,
}

struct Pixel {
    // Alpha marks the pixels of a tile's target: the other placements' pipeline does not write it.
    @location(0) color: vec4f,
    @location(1) id: u32,
}

@vertex
fn project(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f) -> Corner {
    return Corner(item.clip_from_model * vec4f(position, 1.0), uv, dot(normal, item.light_in_model));
}

// IEC 61966-2-1.
fn decode(encoded: vec3f) -> vec3f {
    return select(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3f(2.4)), encoded > vec3f(0.04045));
}

fn encode(linear: vec3f) -> vec3f {
    return select(linear * 12.92, 1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055, linear > vec3f(0.0031308));
}

// Level of detail and mixture are ours, since drivers approximate both.
fn albedo(uv: vec2f) -> vec3f {
    let size = vec2f(textureDimensions(textures));
    let coarsest = f32(textureNumLevels(textures) - 1u);
    let along_row = dpdx(uv) * size;
    let along_column = dpdy(uv) * size;
    let footprint = max(dot(along_row, along_row), dot(along_column, along_column));
    let detail = clamp(0.5 * log2(footprint), 0.0, coarsest);
    let level = floor(detail);
    let fraction = detail - level;
    // A loop, which lavapipe leaves where no pixel of a vector wants the coarser level; of a condition it would do both sides.
    var mixed = vec3f(0.0);
    var next = level;
    loop {
        let texel = textureSampleLevel(textures, bilinear, uv, item.layer, min(next, coarsest)).rgb;
        mixed = select(mix(mixed, texel, fraction), texel, next == level);
        next += 1.0;
        if (next > level + ceil(fraction)) {
            break;
        }
    }
    return mixed;
}

@fragment
fn shade(corner: Corner) -> Pixel {
    let light = item.ambient + item.diffuse * max(corner.incidence, 0.0);
    return Pixel(vec4f(encode(decode(albedo(corner.uv)) * light), 1.0), item.id);
}
