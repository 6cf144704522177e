// The picture of the reference renderer: see the render module's documentation.
//
// Triangles write only what their surface is, and then each pixel is shaded once: lavapipe runs a fragment shader for whole
// blocks of pixels, of which a small triangle covers few.

// Of a drawn placement, an instance of its own: lavapipe reads a storage buffer vertex by vertex, and newer ones allocate memory for each
// dynamic offset of a uniform.
struct Item {
    @location(3) clip_from_x: vec4f,
    @location(4) clip_from_y: vec4f,
    @location(5) clip_from_z: vec4f,
    @location(6) clip_from_origin: vec4f,
    // xyz: the light, in the model's frame; w: the side of the texture, texels.
    @location(7) light_side: vec4f,
    // x: the texture's layer and batch as bits of a surface; y: the id.
    @location(8) texture_id: vec2u,
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv_incidence: vec3f,
    // Of the item. The fragment shader reads no uniform: lavapipe would copy all its state, 33 kB, for each that changes.
    @location(1) @interpolate(flat) texture_id_side: vec3u,
}

@vertex
fn project(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) uv: vec2f, item: Item) -> Corner {
    let clip_from_model = mat4x4f(item.clip_from_x, item.clip_from_y, item.clip_from_z, item.clip_from_origin);
    let clip = clip_from_model * vec4f(position, 1.0);
    let incidence = dot(normal, item.light_side.xyz);
    let labels = vec3u(item.texture_id, bitcast<u32>(item.light_side.w));
    return Corner(clip, vec3f(uv, incidence), labels);
}

// The square of a pixel's extent along an axis of the image, from what is linear in the image.
fn extent(over_depth: vec2f, uv: vec2f, nearness: f32) -> f32 {
    let step = over_depth - uv * nearness;
    return dot(step, step);
}

// Images of their own for what is read alone: lavapipe takes some two hundred instructions to mask a block of pixels of 128 bits.
struct Described {
    // x: texture coordinates; y: `n . l` in 11 bits, the mip level in 4, the layer in 8, the batch.
    @location(0) surface: vec2u,
    @location(1) id: u32,
    // Of a tile's target; the other placements' pipeline does not write it.
    @location(2) mark: u32,
}

@fragment
fn describe(corner: Corner) -> Described {
    let uv = corner.uv_incidence.xy;
    let labels = corner.texture_id_side;
    let nearness = corner.position.w;
    let over_depth = uv * nearness;
    let along_row = extent(dpdx(over_depth), uv, dpdx(nearness));
    let along_column = extent(dpdy(over_depth), uv, dpdy(nearness));
    let texels = bitcast<f32>(labels.z) / nearness;
    // Between 2^(2l - 1) and 2^(2l + 1) at level l.
    let footprint = max(along_row, along_column) * (texels * texels);
    let exponent = (bitcast<i32>(footprint) >> 23u) - 127;
    let coarsest = (i32(labels.z) >> 23u) - 127;
    let level = u32(clamp((exponent + 1) >> 1u, 0, coarsest));
    let incidence = u32(clamp(corner.uv_incidence.z, 0.0, 1.0) * 2047.0 + 0.5);
    let surface = vec2u(pack2x16unorm(fract(uv)), incidence | (level << 11u) | labels.x);
    return Described(surface, labels.y, 1u);
}

@group(0) @binding(0) var surfaces: texture_2d<u32>;
@group(1) @binding(0) var textures: texture_2d_array<f32>;
@group(1) @binding(1) var bilinear: sampler;

struct Sheet {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) ambient: vec3f,
    @location(1) @interpolate(flat) diffuse: vec3f,
    @location(2) @interpolate(flat) batch: u32,
}

// Two triangles over a viewport given by its lower and upper corner in clip coordinates.
@vertex
fn cover(
    @builtin(vertex_index) index: u32,
    @location(0) corners: vec4f,
    @location(1) ambient: vec3f,
    @location(2) diffuse: vec3f,
    @location(3) batch: u32,
) -> Sheet {
    let corner = index % 3u + index / 3u;
    let position = select(corners.xy, corners.zw, vec2(corner % 2u == 1u, corner > 1u));
    return Sheet(vec4f(position, 0.0, 1.0), ambient, diffuse, batch);
}

// sRGB is a line near black and beyond it, but for an offset, a power: irradiance then multiplies the encoded colour by a power of
// its own. Of both the greater is right in dim light, and the lesser in bright light.
fn lit(albedo: vec3f, irradiance: vec3f) -> vec3f {
    let curve = (albedo + 0.055) * pow(irradiance, vec3f(1.0 / 2.4)) - 0.055;
    let line = albedo * irradiance;
    return select(line, curve, (curve > line) != (irradiance > vec3f(1.0)));
}

@fragment
fn shade(sheet: Sheet) -> @location(0) vec4f {
    let surface = textureLoad(surfaces, vec2i(sheet.position.xy), 0);
    if ((surface.y >> 23u) != sheet.batch) {
        discard;
    }
    let incidence = f32(surface.y & 2047u) / 2047.0;
    let level = f32((surface.y >> 11u) & 15u);
    let layer = (surface.y >> 15u) & 255u;
    let texel = textureSampleLevel(textures, bilinear, unpack2x16unorm(surface.x), layer, level);
    return vec4f(lit(texel.rgb, sheet.ambient + sheet.diffuse * incidence), 1.0);
}
