// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_shadow.c.
//
// Look up shadows in one bit a cell: WGSL. Put it behind radtex.wgsl, then
//
//     let here = radtex_shadow(bits, vec2i(W, H), uv);
//     let L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
//     light = colour * max(L.z, 0.0) * radtex_visible(bits, here, n, L);                      // a light without a size
//     light = colour * radtex_sun(bits, here, n, frame, to_sun, angle, 32);                   // with one: cosine included
//     light = colour * radtex_rectangle(bits, here, n, frame, position, corner, side, up, 32);
//
// `bits` is <name>.shadow.exr, bottom row first (v = 0 is row 0): an rg32uint texture of W x H pixels, viewed as an
// array (dimension "2d-array"), whose layer k holds the words 2 k and 2 k + 1; 8 x 8 cells need one. Bit q * n + p, the
// least significant first, is 1 where the direction of the cell (p, q) is blocked. `frame` comes from radtex_frame: its
// columns are T, Bt and N, in the space of all other vectors.

// A place among texels: the nearest, and how far the place is from its middle, -1/2 to 1/2.
struct RadtexShadow {
    beyond: vec2f,
    nearest: vec2i,
    texels: vec2i,
}

// The texel t, of nine, around the nearest.
fn radtex_shadow_texel(nearest: vec2i, texels: vec2i, t: i32) -> vec2i {
    return clamp(nearest + vec2i(i32(u32(t) % 3u), i32(u32(t) / 3u)) - 1, vec2i(0, 0), texels - 1);
}

// The word of a texel that has the bit k.
fn radtex_bits(bits: texture_2d_array<u32>, texels: vec2i, texel: vec2i, k: i32) -> u32 {
    let words = textureLoad(bits, texel, k >> 6, 0).xy;
    return select(words.y, words.x, (k & 32) == 0);
}

// What every lookup at `uv` reads, for however many lights. With layers, `bits` also is each lookup's first argument.
fn radtex_shadow(bits: texture_2d_array<u32>, texels: vec2i, uv: vec2f) -> RadtexShadow {
    let position = uv * vec2f(texels);
    let corner = floor(position);
    var here: RadtexShadow;
    here.beyond = position - corner - 0.5;
    here.nearest = vec2i(corner);
    here.texels = texels;
    return here;
}

// 1 where the cell k of texel t, of nine, is open, 0 where it is blocked.
fn radtex_open(bits: texture_2d_array<u32>, here: RadtexShadow, t: i32, k: i32) -> f32 {
    var word = radtex_bits(bits, here.texels, radtex_shadow_texel(here.nearest, here.texels, t), k);
    return select(0.0, 1.0, ((word >> u32(k & 31)) & 1u) == 0u);
}

// The same between the four texels around the place.
fn radtex_open_here(bits: texture_2d_array<u32>, here: RadtexShadow, k: i32) -> f32 {
    let x = select(1, -1, here.beyond.x < 0.0);
    let y = select(3, -3, here.beyond.y < 0.0);
    let f = abs(here.beyond);
    return mix(mix(radtex_open(bits, here, 4, k), radtex_open(bits, here, 4 + x, k), f.x),
        mix(radtex_open(bits, here, 4 + y, k), radtex_open(bits, here, 4 + x + y, k), f.x), f.y);
}

// Where a direction of the frame lies among the middles of n x n cells.
fn radtex_between_cells(n: i32, I: vec3f) -> vec2f {
    let inner = f32(n) - 0.5;
    return clamp((radtex_bucket(I) + 1.0) * 0.5 * f32(n), vec2f(0.5, 0.5), vec2f(inner, inner)) - 0.5;
}

// How much of a light in the unit direction I of the frame is seen, 0 to 1: texels and cells are blended.
fn radtex_visible(bits: texture_2d_array<u32>, here: RadtexShadow, n: i32, I: vec3f) -> f32 {
    let position = radtex_between_cells(n, I);
    let low = vec2i(position);
    let high = min(low + 1, vec2i(n - 1, n - 1));
    let f = position - vec2f(low);
    let below = mix(radtex_open_here(bits, here, low.y * n + low.x),
        radtex_open_here(bits, here, low.y * n + high.x), f.x);
    let above = mix(radtex_open_here(bits, here, high.y * n + low.x),
        radtex_open_here(bits, here, high.y * n + high.x), f.x);
    return mix(below, above, f.y);
}

// How open each of up to 8 x 8 cells is in the mean of nine texels, read once for all points of a light.
fn radtex_blend(bits: texture_2d_array<u32>, here: RadtexShadow, cells: ptr<function, array<f32, 64>>) {
    let across = vec3f(0.5 - here.beyond.x, 1.0, 0.5 + here.beyond.x) * 0.5;
    let up = vec3f(0.5 - here.beyond.y, 1.0, 0.5 + here.beyond.y) * 0.5;
    for (var t = 0; t < 9; t++) {
        let words = textureLoad(bits, radtex_shadow_texel(here.nearest, here.texels, t), 0, 0).xy;
        let weight = across[t % 3] * up[t / 3];
        for (var k = 0; k < 64; k++) {
            let word = select(words.y, words.x, k < 32);
            (*cells)[k] += weight * f32(1u - ((word >> u32(k & 31)) & 1u));
        }
    }
}

// What each of many points of a light sees. Up to 8 x 8 cells: between four, and sharpened, for a shadow's edge lies
// where so wide a blend is about a half. More are fine enough for the light's own size to blend them.
fn radtex_visible_point(bits: texture_2d_array<u32>, here: RadtexShadow, cells: ptr<function, array<f32, 64>>, n: i32,
                        I: vec3f) -> f32 {
    if n > 8 {
        let cell = clamp(vec2i((radtex_bucket(I) + 1.0) * 0.5 * f32(n)), vec2i(0), vec2i(n - 1));
        return radtex_open_here(bits, here, cell.y * n + cell.x);
    }
    let position = radtex_between_cells(n, I);
    let low = vec2i(position);
    let high = min(low + 1, vec2i(n - 1));
    let f = position - vec2f(low);
    let below = mix((*cells)[low.y * n + low.x], (*cells)[low.y * n + high.x], f.x);
    let above = mix((*cells)[high.y * n + low.x], (*cells)[high.y * n + high.x], f.x);
    return saturate(2.0 * mix(below, above, f.y) - 0.5);
}

// The frame (T, Bt, N) as columns: what radtex_incidence brings vectors into.
fn radtex_frame(normal: vec3f, tangent: vec3f, bitangent_sign: f32) -> mat3x3f {
    let x = radtex_incidence(vec3f(1.0, 0.0, 0.0), normal, tangent, bitangent_sign);
    let y = radtex_incidence(vec3f(0.0, 1.0, 0.0), normal, tangent, bitangent_sign);
    let z = radtex_incidence(vec3f(0.0, 0.0, 1.0), normal, tangent, bitangent_sign);
    return transpose(mat3x3f(x, y, z));
}

fn radtex_in_frame(direction: vec3f, frame: mat3x3f) -> vec3f {
    return direction * frame;
}

// A sun's irradiance over that which it has at a right angle, from `count` points, even on its disc, `angle` wide in
// radians.
fn radtex_sun(bits: texture_2d_array<u32>, here: RadtexShadow, n: i32, frame: mat3x3f, to_sun: vec3f, angle: f32,
              count: i32) -> f32 {
    var cells: array<f32, 64>;
    if n <= 8 { radtex_blend(bits, here, &cells); }
    let axis = normalize(to_sun);
    let across = normalize(cross(select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(axis.z) < 0.9), axis));
    let up = cross(axis, across);
    let rim = cos(0.5 * angle);
    var sum = 0.0;
    for (var k = 0; k < count; k++) {
        let share = select(0.0, (f32(k) + 0.5) / f32(count), count > 1);
        let turn = f32(k) * 2.39996323;  // a sunflower
        let cosine = 1.0 - share * (1.0 - rim);
        let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        let L = radtex_in_frame(cosine * axis + sine * (cos(turn) * across + sin(turn) * up), frame);
        if L.z > 0.0 { sum += L.z * radtex_visible_point(bits, here, &cells, n, L); }
    }
    return sum / f32(count) * 2.0 / (1.0 + rim);
}

// A rectangle's irradiance over its radiance: it lies at `corner`, its sides are `side` and `up`, and it shines along
// cross(side, up). Divide by the area for a lamp of given power. Points are spread by Roberts's sequence.
fn radtex_rectangle(bits: texture_2d_array<u32>, here: RadtexShadow, n: i32, frame: mat3x3f, position: vec3f,
                    corner: vec3f, side: vec3f, up: vec3f, count: i32) -> f32 {
    var cells: array<f32, 64>;
    if n <= 8 { radtex_blend(bits, here, &cells); }
    let face = cross(side, up);  // as long as the area
    var sum = 0.0;
    for (var k = 0; k < count; k++) {
        let place = fract(0.5 + f32(k + 1) * vec2f(0.754877666, 0.569840291));
        let way = corner + place.x * side + place.y * up - position;
        let squared = max(dot(way, way), 1e-30);
        let L = radtex_in_frame(way * inverseSqrt(squared), frame);
        let weight = max(L.z, 0.0) * max(-dot(way, face), 0.0) / (squared * sqrt(squared));
        if weight > 0.0 { sum += weight * radtex_visible_point(bits, here, &cells, n, L); }
    }
    return sum / f32(count);
}
