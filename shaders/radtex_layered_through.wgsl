// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_layered_through.c.
//
// Look up a radiance texture in the layered layout, of an object that light comes through: WGSL. Put it behind
// radtex_layered.wgsl, then
//
//     let light = radtex_layered_through(uv, position, N, V, T, B);
//
// where N, T and B are the unit normal, tangent and bitangent of the baked UV map in the world space of the bake.

override RADTEX_EXIT_CELLS: i32 = 16;    // cells along the sides of buckets
override RADTEX_THROUGH_CELLS: i32 = 8;
// 16: the ways around are taken one by one, 32 fetches; 4: as the textures' filter blends those of texels, 8 fetches,
// which is far off where they part.
override RADTEX_EXIT_TAPS: i32 = 16;
override RADTEX_FIELD: bool = false;  // closed glass: rays are followed through its distance field, two fetches a step

struct RadtexThrough {
    direction_range: vec4f,
    place_range: vec4f,
    tile: vec4f,
    colour_range: vec4f,
    rest_range: vec4f,
    rest_tile: vec4f,
    field_range: vec4f,
    field_low: vec4f,
    field_size: vec4f,
    field_glass: vec4f,
    field_tint: vec4f,
}

@group(1) @binding(15) var<uniform> radtex_exit: RadtexThrough;
@group(1) @binding(16) var radtex_exit_direction_map: texture_2d<f32>;
@group(1) @binding(17) var radtex_exit_place_map: texture_2d<f32>;
@group(1) @binding(18) var radtex_through_colour_map: texture_2d<f32>;
@group(1) @binding(19) var radtex_through_rest_map: texture_2d<f32>;
@group(1) @binding(20) var radtex_field_map: texture_2d<f32>;

// The field at a place in steps from its first sample: the unit normal of the surface nearest to it, and how far away that
// is, below 0 inside. Its layers lie side by side: radtex_field_size.w of them in a row.
fn radtex_field(at: vec3f) -> vec4f {
    let size = radtex_exit.field_size;
    let range = radtex_exit.field_range;
    let low = clamp(floor(at.z), 0.0, size.z - 2.0);
    let scale = range.xy / (size.xy * vec2f(size.w, ceil((size.z - 0.5) / size.w)));
    let row = floor((low + 0.5) / size.w);
    let next = floor((low + 1.5) / size.w);
    let first = vec2f(low - row * size.w, row) * size.xy + at.xy + 0.5;
    let second = vec2f(low + 1.0 - next * size.w, next) * size.xy + at.xy + 0.5;
    let below = textureSampleLevel(radtex_field_map, radtex_filtering, first * scale, 0.0);
    return mix(below, textureSampleLevel(radtex_field_map, radtex_filtering, second * scale, 0.0), at.z - low)
        * range.z + range.w;
}

// A ray through the object: where it is, in steps of the field; `side`: 1 inside, -1 outside; how often it was reflected.
// `tints`: how many surfaces tinted it, beyond the two by which light comes in and goes out. Of rough glass it is a `beam`:
// variances of its directions, and of its places across it, in z; in y, how both go together.
struct RadtexWay {
    place: vec3f,
    ray: vec3f,
    beam: vec3f,
    weight: f32,
    side: f32,
    reflections: f32,
    tints: f32,
}

// The cosine behind a surface, of an index of refraction over that before it; 0 if all is reflected.
fn radtex_beyond(cosine: f32, index: f32) -> f32 {
    return sqrt(max(1.0 - (1.0 - cosine * cosine) / (index * index), 0.0));
}

// The share that a smooth surface reflects.
fn radtex_fresnel(cosine: f32, beyond: f32, index: f32) -> f32 {
    let across = (cosine - index * beyond) / (cosine + index * beyond);
    let along = (index * cosine - beyond) / (index * cosine + beyond);
    return select(1.0, 0.5 * (across * across + along * along), beyond > 0.0);
}

// A beam so many steps further on.
fn radtex_advanced(beam: vec3f, steps: f32) -> vec3f {
    return beam + steps * vec3f(0.0, beam.x, 2.0 * beam.y + steps * beam.x);
}

// Half of a beam behind a surface, by one of two planes: what its directions and places are multiplied by, what turns of
// the surface's normal count for, and by how much it turns from ray to ray.
fn radtex_fanned(beam: vec3f, direction: f32, place: f32, turn: f32, bend: f32) -> vec3f {
    let bent = turn * bend;
    let wider = direction * (direction * beam.x + 2.0 * bent * beam.y) + bent * bent * beam.z;
    return 0.5 * vec3f(wider + turn * turn * radtex_exit.field_glass.y, place * (direction * beam.y + bent * beam.z),
        place * place * beam.z);
}

// A beam that is reflected, or else refracted, by a surface whose normal bends so much a step.
fn radtex_fan_out(beam: vec3f, cosine: f32, beyond: f32, index: f32, bend: f32, back: bool) -> vec3f {
    let before = max(cosine, 0.2);
    let after = max(beyond, 0.2);
    let steeper = before / (index * after);
    var fanned: vec3f;
    if back {
        fanned = radtex_fanned(beam, 1.0, 1.0, -2.0, bend / before)
            + radtex_fanned(beam, 1.0, 1.0, -2.0 * before, bend);
    } else {
        fanned = radtex_fanned(beam, steeper, after / before, 1.0 - steeper, bend / before)
            + radtex_fanned(beam, 1.0 / index, 1.0, after - before / index, bend);
    }
    return fanned * (4.0 / max(fanned.x, 4.0));
}

// By how much the unit normal `ahead` of where a ray is turns, a step further along the surface.
fn radtex_bend(way: RadtexWay, ahead: vec3f, cosine: f32) -> f32 {
    var along = way.ray - cosine * ahead + 0.001 * cross(ahead, ahead.yzx);
    along *= inverseSqrt(max(dot(along, along), 1e-12));
    var beside = radtex_field(clamp(way.place + along, vec3f(0.0, 0.0, 0.0), radtex_exit.field_size.xyz - 1.0)).xyz;
    beside *= way.side * inverseSqrt(max(dot(beside, beside), 1e-12));
    return clamp(dot(beside - ahead, along), -0.25, 0.25);
}

// What of a ray is reflected, or else refracted, by a surface with the unit normal `ahead` on its far side.
fn radtex_turned(way: RadtexWay, ahead: vec3f, cosine: f32, index: f32, bend: f32, back: bool) -> RadtexWay {
    let glass = radtex_exit.field_glass;
    let beyond = radtex_beyond(cosine, index);
    let reflected = radtex_fresnel(cosine, beyond, index);
    let bent = way.ray / index + (beyond - cosine / index) * ahead;
    var turned = way;
    turned.ray = normalize(select(bent, way.ray - 2.0 * cosine * ahead, back));
    turned.weight = way.weight * select(1.0 - reflected, reflected, back);
    turned.side = select(-way.side, way.side, back);
    turned.reflections = way.reflections + select(0.0, 1.0, back);
    turned.tints = way.tints + select(1.0, radtex_exit.field_tint.w, back);
    turned.place = way.place + 1.5 * turned.ray;
    if glass.y > 0.0 {
        turned.beam = radtex_advanced(radtex_fan_out(way.beam, cosine, beyond, index, bend, back), 1.5);
    }
    if turned.reflections > glass.z { turned.weight = 0.0; }
    return turned;
}

// What is seen of the surroundings, as if the surfaces by which light comes in and goes out were white. At each surface a ray
// goes on as most of its light does; of what parts from it, the brightest is followed, too; and of what goes neither way, a
// share comes from all around.
fn radtex_followed(whence: vec3f, N: vec3f, V: vec3f) -> vec3f {
    let glass = radtex_exit.field_glass;
    let low = radtex_exit.field_low;
    let last = radtex_exit.field_size.xyz - 1.0;
    var light = vec3f(0.0, 0.0, 0.0);
    let cosine = max(dot(V, N), 0.001);
    let beyond = radtex_beyond(cosine, glass.x);
    var way: RadtexWay;
    way.ray = normalize((cosine / glass.x - beyond) * N - V / glass.x);
    way.place = (whence - low.xyz) * low.w + 1.5 * way.ray;
    way.beam = vec3f(0.0, 0.0, 0.0);
    if glass.y > 0.0 { way.beam = radtex_advanced(radtex_fan_out(way.beam, cosine, beyond, glass.x, 0.0, false), 1.5); }
    way.weight = 1.0 - radtex_fresnel(cosine, beyond, glass.x);
    way.side = 1.0;
    way.reflections = 0.0;
    way.tints = -1.0;
    var lost = way.weight;
    for (var k = 0; k < 3; k++) {
        var parted = way;
        parted.weight = 0.0;
        var outside = k == 2;
        var going = !outside && way.weight > 0.004;
        for (var taken = 0; taken < 64 && going; taken++) {
            let found = radtex_field(way.place);
            let free = -found.w * way.side;
            var normal = found.xyz;  // of an edge that of the nearest sample
            if free < 0.1 && dot(normal, normal) < 0.9 { normal = radtex_field(floor(way.place + 0.5)).xyz; }
            let ahead = normal * (way.side * inverseSqrt(max(dot(normal, normal), 1e-12)));
            let towards = dot(way.ray, ahead);
            let met = free < 0.1 && towards > 0.05;
            let steps = select(max(free, 0.5), free / max(towards, 0.2), met);
            way.place += steps * way.ray;
            way.beam = radtex_advanced(way.beam, steps);
            if met {
                let index = select(glass.x, 1.0 / glass.x, way.side > 0.0);
                let back = radtex_fresnel(towards, radtex_beyond(towards, index), index) >= 0.5;
                var bend = 0.0;
                if glass.y > 0.0 { bend = radtex_bend(way, ahead, towards); }
                let other = radtex_turned(way, ahead, towards, index, bend, !back);
                if other.weight > parted.weight { parted = other; }
                way = radtex_turned(way, ahead, towards, index, bend, back);
            }
            let room = min(way.place, last - way.place);
            outside = min(room.x, min(room.y, room.z)) < 0.0;
            going = !outside && way.weight > 0.004;
        }
        if way.weight > select(0.004, 0.0, k == 2) && (outside || way.side < 0.0) {
            let narrowest = clamp(way.beam.y / max(way.beam.x, 1e-12), 0.0, 64.0);  // so many steps back
            let exit = low.xyz + (way.place - narrowest * way.ray) / low.w;
            let spread = log2(max(1.4 * way.beam.x, 1e-12));
            let shown = radtex_shown(exit, way.ray, radtex_met(exit, way.ray), spread, vec4f(0.0, 0.0, 0.0, 1e6));
            light += way.weight * exp2(way.tints * radtex_exit.field_tint.xyz) * shown;
            lost -= way.weight;
        }
        way = parted;
        if k == 1 {
            way.ray = -V;
            way.place = (whence - low.xyz) * low.w;
            way.tints = 0.0;
            way.beam = vec3f(0.5 / 1.4, 0.0, 0.0);
            way.weight = lost * glass.w - 0.004;
        }
    }
    return light;
}

// A way, at a place in texels' units of tiles: luminance * direction, luminance.
fn radtex_way(at: vec2f) -> vec4f {
    let range = radtex_exit.direction_range;
    return textureSampleLevel(radtex_exit_direction_map, radtex_filtering, at * range.xy, 0.0) * range.z + range.w;
}

// And its line: luminance * place, luminance * width².
fn radtex_path(at: vec2f) -> vec4f {
    let range = radtex_exit.place_range;
    return textureSampleLevel(radtex_exit_place_map, radtex_filtering, at * range.xy, 0.0) * range.z + range.w;
}

// The k-th of the four corners of a square.
fn radtex_corner(k: i32) -> vec2f {
    return vec2f(f32(k & 1), f32((k >> 1) & 1));
}

// Where to look for a way's k-th tap: within the tile of a cell beside `low`, as the filter blends texels around
// `inside`, or at one of these.
fn radtex_tap(k: i32, low: vec2f, inside: vec2f) -> vec2f {
    let cell = low + radtex_corner(k);
    if RADTEX_EXIT_TAPS == 16 {
        let half_texel = radtex_exit.tile.zw;
        let corner = floor(inside / half_texel * 0.5 - 0.5) * 2.0 + 1.0;
        let texel = (corner + 2.0 * radtex_corner(k >> 2)) * half_texel;
        return cell + clamp(texel, half_texel, radtex_exit.tile.xy - half_texel);
    } else {
        return cell + inside;
    }
}

// The weight of a tap; f and g are the places between four cells and between four texels.
fn radtex_tap_weight(k: i32, f: vec2f, g: vec2f) -> f32 {
    var cell = mix(1.0 - f, f, radtex_corner(k));
    if RADTEX_EXIT_TAPS == 16 {
        cell *= mix(1.0 - g, g, radtex_corner(k >> 2));
    }
    return cell.x * cell.y;
}

// What is seen of the surroundings through white glass. Of the ways around, those are followed that agree with the strongest
// one.
fn radtex_by_cells(uv: vec2f, whence: vec3f, N: vec3f, V: vec3f, T: vec3f, B: vec3f) -> vec3f {
    let n = f32(RADTEX_EXIT_CELLS);
    var I = vec3f(dot(V, T), dot(V, B), max(dot(V, N), 0.0));
    I *= inverseSqrt(max(dot(I, I), 1e-18));
    let disc = I.xy * inverseSqrt(1.0 + I.z);  // equal area; and from there to the square
    let square = disc * (length(disc) / max(max(abs(disc.x), abs(disc.y)), 1e-9));
    var place = (clamp(square, vec2f(-1.0, -1.0), vec2f(1.0, 1.0)) * 0.5 + 0.5) * n - 0.5;
    place = clamp(place, vec2f(0.0, 0.0), vec2f(n - 1.0, n - 1.0));
    let low = min(floor(place), vec2f(n - 2.0, n - 2.0));
    let f = place - low;
    let inside = radtex_inside(radtex_exit.tile, uv);
    let g = fract(inside / radtex_exit.tile.zw * 0.5 - 0.5);
    var way = vec4f(0.0, 0.0, 0.0, 0.0);
    var path = way;
    var ways: array<vec4f, 16>;
    var chief = vec3f(0.0, 0.0, 0.0);
    var total = 0.0;
    for (var k = 0; k < RADTEX_EXIT_TAPS; k++) {
        ways[k] = radtex_tap_weight(k, f, g) * radtex_way(radtex_tap(k, low, inside));
        chief = select(chief, ways[k].xyz, dot(ways[k].xyz, ways[k].xyz) > dot(chief, chief));
        total += ways[k].w;
    }
    chief *= inverseSqrt(max(dot(chief, chief), 1e-24));
    for (var k = 0; k < RADTEX_EXIT_TAPS; k++) {
        let cosine = dot(ways[k].xyz, chief) * inverseSqrt(max(dot(ways[k].xyz, ways[k].xyz), 1e-24));
        let kept = clamp((cosine - 0.8) / 0.15, 0.0, 1.0);
        way += kept * ways[k];
        if kept > 0.0 { path += kept * radtex_tap_weight(k, f, g) * radtex_path(radtex_tap(k, low, inside)); }
    }
    let brighter = total / max(way.w, 1e-9);  // as bright as all of them
    way *= brighter;
    path *= brighter;
    let luminance = max(way.w, 1e-6);
    let even = length(way.xyz);
    let width = max(path.w / luminance + max(1.0 - even / luminance - 0.03, 0.0), 1e-12);  // more if they disagree
    let away = way.xyz / max(even, 1e-9);
    let moved = path.xyz / luminance;
    let ray = away.x * T + away.y * B + away.z * N;
    let exit = whence + moved.x * T + moved.y * B + moved.z * N;
    return way.w * radtex_shown(exit, ray, radtex_met(exit, ray), log2(width), vec4f(0.0, 0.0, 0.0, 1e6));
}

// What is seen of the surroundings.
fn radtex_through(uv: vec2f, whence: vec3f, N: vec3f, V: vec3f, T: vec3f, B: vec3f) -> vec3f {
    var light: vec3f;
    if RADTEX_FIELD {
        light = radtex_followed(whence, N, V);
    } else {
        light = radtex_by_cells(uv, whence, N, V, T, B);
    }
    return light * radtex_colours(radtex_through_colour_map, radtex_exit.colour_range, uv);
}

// Radiance towards the viewer, in the unit direction V, from a fragment at `position`.
fn radtex_layered_through(uv: vec2f, position: vec3f, N: vec3f, V: vec3f, T: vec3f, B: vec3f) -> vec3f {
    let through = radtex_through(uv, position - radtex.middle.xyz, N, V, T, B)
        + radtex_rest(radtex_through_rest_map, radtex_exit.rest_range, radtex_exit.rest_tile,
            f32(RADTEX_THROUGH_CELLS), uv, radtex_square(-V));
    return max(radtex_layered(uv, position, N, V) + radtex_alpha(uv) * through, vec3f(0.0, 0.0, 0.0));
}
