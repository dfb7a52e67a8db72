// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
@for glsl hlsl wgsl godot
@name wgsl radtex_through_colour_range radtex_exit.colour_range
@name wgsl radtex_through_rest_range radtex_exit.rest_range
@name wgsl radtex_through_rest_tile radtex_exit.rest_tile
@name wgsl radtex_field_range radtex_exit.field_range
@name wgsl radtex_field_low radtex_exit.field_low
@name wgsl radtex_field_size radtex_exit.field_size
@name wgsl radtex_field_glass radtex_exit.field_glass
@name wgsl radtex_field_tint radtex_exit.field_tint
//
@in glsl
// Look up a radiance texture in the layered layout, of an object that light comes through: GLSL 330 and later, GLSL ES
// 300 (WebGL 2) and later. Include it behind radtex_layered.glsl, before which RADTEX_THROUGH is defined, then
@in hlsl
// Look up a radiance texture in the layered layout, of an object that light comes through: HLSL, shader model 5 and
// later. radtex_layered.hlsl, which says what is defined before, must lie beside it. Define RADTEX_THROUGH, include
// this file, then
@in wgsl
// Look up a radiance texture in the layered layout, of an object that light comes through: WGSL. Put it behind
// radtex_layered.wgsl, then
@in godot
// Look up a radiance texture in the layered layout, of an object that light comes through: Godot 4.6's shading
// language, every renderer. Include it behind radtex_layered.gdshaderinc, before which RADTEX_THROUGH is defined, then
@end
//
//     vec3 light = radtex_layered_through(uv, position, N, V, T, B);
//
@in wgsl
// where N, T and B are the unit normal, tangent and bitangent of the baked UV map in the world space of the bake.

override RADTEX_EXIT_CELLS: i32 = 16;    // cells along the sides of buckets
override RADTEX_THROUGH_CELLS: i32 = 8;
// 16: the ways around are taken one by one, 32 fetches; 4: as the textures' filter blends those of texels, 8 fetches,
// which is far off where they part.
override RADTEX_EXIT_TAPS: i32 = 16;
override RADTEX_FIELD: bool = false;  // closed glass: rays are followed through its distance field, two fetches a step
@else
// where N, T and B are the unit normal, tangent and bitangent of the baked UV map in the world space of the bake. Also
// defined before are RADTEX_EXIT_CELLS and RADTEX_THROUGH_CELLS, cells along the sides of buckets; and RADTEX_EXIT_TAPS
// (16, 4; default 16): the ways around are taken one by one, 32 fetches; or as the textures' filter blends those of
// texels, 8 fetches, which is far off where they part. Or RADTEX_FIELD: closed glass, whose distance field rays are followed
// through, two fetches a step.
@end
@in hlsl

#ifndef RADTEX_LAYERED_THROUGH_HLSL
#define RADTEX_LAYERED_THROUGH_HLSL

#include "radtex_layered.hlsl"
@end
@in glsl hlsl godot

#ifndef RADTEX_EXIT_TAPS
#define RADTEX_EXIT_TAPS 16
#endif
@end
@in glsl

#ifndef RADTEX_DECLARED
@in godot

@end
@in glsl godot
#ifdef RADTEX_FIELD
uniform sampler2D radtex_field_map;  // 16-bit floats
uniform vec4 radtex_field_range, radtex_field_low, radtex_field_size, radtex_field_glass, radtex_field_tint;
#else
uniform sampler2D radtex_exit_direction_map, radtex_exit_place_map;
uniform vec4 radtex_exit_direction_range, radtex_exit_place_range, radtex_exit_tile;
#endif
uniform sampler2D radtex_through_rest_map;
uniform mipmapped sampler2D radtex_through_colour_map;
uniform vec4 radtex_through_colour_range, radtex_through_rest_range, radtex_through_rest_tile;
@end
@in glsl
#endif
@in hlsl

#ifndef RADTEX_DECLARED
#ifdef RADTEX_FIELD
Texture2D radtex_field_map RADTEX_TEXTURE(12);
#else
Texture2D radtex_exit_direction_map RADTEX_TEXTURE(12);
Texture2D radtex_exit_place_map RADTEX_TEXTURE(13);
#endif
Texture2D radtex_through_colour_map RADTEX_TEXTURE(14);
Texture2D radtex_through_rest_map RADTEX_TEXTURE(15);

cbuffer RadtexThrough RADTEX_BUFFER(2) {
    float4 radtex_exit_direction_range;
    float4 radtex_exit_place_range;
    float4 radtex_exit_tile;
    float4 radtex_through_colour_range;
    float4 radtex_through_rest_range;
    float4 radtex_through_rest_tile;
    float4 radtex_field_range;
    float4 radtex_field_low;
    float4 radtex_field_size;
    float4 radtex_field_glass;
    float4 radtex_field_tint;
};
#endif
@in wgsl

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
@end

@in glsl hlsl godot
#ifdef RADTEX_FIELD
@end
// The field at a place in steps from its first sample: the unit normal of the surface nearest to it, and how far away that
// is, below 0 inside. Its layers lie side by side: radtex_field_size.w of them in a row.
vec4 radtex_field(vec3 at) {
    vec4 size = radtex_field_size, range = radtex_field_range;
    float low = clamp(floor(at.z), 0.0, size.z - 2.0);
    vec2 scale = range.xy / (size.xy * vec2(size.w, ceil((size.z - 0.5) / size.w)));
    float row = floor((low + 0.5) / size.w), next = floor((low + 1.5) / size.w);
    vec2 first = vec2(low - row * size.w, row) * size.xy + at.xy + 0.5;
    vec2 second = vec2(low + 1.0 - next * size.w, next) * size.xy + at.xy + 0.5;
    vec4 below = textureLod(radtex_field_map, first * scale, 0.0);
    return mix(below, textureLod(radtex_field_map, second * scale, 0.0), at.z - low) * range.z + range.w;
}

// A ray through the object: where it is, in steps of the field; `side`: 1 inside, -1 outside; how often it was reflected.
// `tints`: how many surfaces tinted it, beyond the two by which light comes in and goes out. Of rough glass it is a `beam`:
// variances of its directions, and of its places across it, in z; in y, how both go together.
struct RadtexWay {
    vec3 place;
    vec3 ray;
    vec3 beam;
    float weight;
    float side;
    float reflections;
    float tints;
};

// The cosine behind a surface, of an index of refraction over that before it; 0 if all is reflected.
float radtex_beyond(float cosine, float index) {
    return sqrt(max(1.0 - (1.0 - cosine * cosine) / (index * index), 0.0));
}

// The share that a smooth surface reflects.
float radtex_fresnel(float cosine, float beyond, float index) {
    float across = (cosine - index * beyond) / (cosine + index * beyond);
    float along = (index * cosine - beyond) / (index * cosine + beyond);
    return beyond > 0.0 ? 0.5 * (across * across + along * along) : 1.0;
}

// A beam so many steps further on.
vec3 radtex_advanced(vec3 beam, float steps) {
    return beam + steps * vec3(0.0, beam.x, 2.0 * beam.y + steps * beam.x);
}

// Half of a beam behind a surface, by one of two planes: what its directions and places are multiplied by, what turns of
// the surface's normal count for, and by how much it turns from ray to ray.
vec3 radtex_fanned(vec3 beam, float direction, float place, float turn, float bend) {
    float bent = turn * bend;
    float wider = direction * (direction * beam.x + 2.0 * bent * beam.y) + bent * bent * beam.z;
    return 0.5 * vec3(wider + turn * turn * radtex_field_glass.y, place * (direction * beam.y + bent * beam.z),
        place * place * beam.z);
}

// A beam that is reflected, or else refracted, by a surface whose normal bends so much a step.
vec3 radtex_fan_out(vec3 beam, float cosine, float beyond, float index, float bend, bool back) {
    float before = max(cosine, 0.2), after = max(beyond, 0.2), steeper = before / (index * after);
    vec3 fanned;
    if (back) {
        fanned = radtex_fanned(beam, 1.0, 1.0, -2.0, bend / before) + radtex_fanned(beam, 1.0, 1.0, -2.0 * before, bend);
    } else {
        fanned = radtex_fanned(beam, steeper, after / before, 1.0 - steeper, bend / before)
            + radtex_fanned(beam, 1.0 / index, 1.0, after - before / index, bend);
    }
    return fanned * (4.0 / max(fanned.x, 4.0));
}

// By how much the unit normal `ahead` of where a ray is turns, a step further along the surface.
float radtex_bend(RadtexWay way, vec3 ahead, float cosine) {
    vec3 along = way.ray - cosine * ahead + 0.001 * cross(ahead, ahead.yzx);
    along *= inversesqrt(max(dot(along, along), 1e-12));
    vec3 beside = radtex_field(clamp(way.place + along, vec3(0.0, 0.0, 0.0), radtex_field_size.xyz - 1.0)).xyz;
    beside *= way.side * inversesqrt(max(dot(beside, beside), 1e-12));
    return clamp(dot(beside - ahead, along), -0.25, 0.25);
}

// What of a ray is reflected, or else refracted, by a surface with the unit normal `ahead` on its far side.
RadtexWay radtex_turned(RadtexWay way, vec3 ahead, float cosine, float index, float bend, bool back) {
    vec4 glass = radtex_field_glass;
    float beyond = radtex_beyond(cosine, index), reflected = radtex_fresnel(cosine, beyond, index);
    vec3 bent = way.ray / index + (beyond - cosine / index) * ahead;
    RadtexWay turned = way;
    turned.ray = normalize(back ? way.ray - 2.0 * cosine * ahead : bent);
    turned.weight = way.weight * (back ? reflected : 1.0 - reflected);
    turned.side = back ? way.side : -way.side;
    turned.reflections = way.reflections + (back ? 1.0 : 0.0);
    turned.tints = way.tints + (back ? radtex_field_tint.w : 1.0);
    turned.place = way.place + 1.5 * turned.ray;
    if (glass.y > 0.0) {
        turned.beam = radtex_advanced(radtex_fan_out(way.beam, cosine, beyond, index, bend, back), 1.5);
    }
    if (turned.reflections > glass.z) turned.weight = 0.0;
    return turned;
}

// What is seen of the surroundings, as if the surfaces by which light comes in and goes out were white. At each surface a ray
// goes on as most of its light does; of what parts from it, the brightest is followed, too; and of what goes neither way, a
// share comes from all around.
vec3 radtex_followed(vec3 from, vec3 N, vec3 V) {
    vec4 glass = radtex_field_glass, low = radtex_field_low;
    vec3 last = radtex_field_size.xyz - 1.0, light = vec3(0.0, 0.0, 0.0);
    float cosine = max(dot(V, N), 0.001), beyond = radtex_beyond(cosine, glass.x);
    RadtexWay way;
    way.ray = normalize((cosine / glass.x - beyond) * N - V / glass.x);
    way.place = (from - low.xyz) * low.w + 1.5 * way.ray;
    way.beam = vec3(0.0, 0.0, 0.0);
    if (glass.y > 0.0) way.beam = radtex_advanced(radtex_fan_out(way.beam, cosine, beyond, glass.x, 0.0, false), 1.5);
    way.weight = 1.0 - radtex_fresnel(cosine, beyond, glass.x);
    way.side = 1.0;
    way.reflections = 0.0;
    way.tints = -1.0;
    float lost = way.weight;
    [loop] for (int k = 0; k < 3; k++) {
        RadtexWay parted = way;
        parted.weight = 0.0;
        bool outside = k == 2, going = !outside && way.weight > 0.004;
        [loop] for (int taken = 0; taken < 64 && going; taken++) {
            vec4 found = radtex_field(way.place);
            float free = -found.w * way.side;
            vec3 normal = found.xyz;  // of an edge that of the nearest sample
            if (free < 0.1 && dot(normal, normal) < 0.9) normal = radtex_field(floor(way.place + 0.5)).xyz;
            vec3 ahead = normal * (way.side * inversesqrt(max(dot(normal, normal), 1e-12)));
            float towards = dot(way.ray, ahead);
            bool met = free < 0.1 && towards > 0.05;
            float steps = met ? free / max(towards, 0.2) : max(free, 0.5);
            way.place += steps * way.ray;
            way.beam = radtex_advanced(way.beam, steps);
            if (met) {
                float index = way.side > 0.0 ? 1.0 / glass.x : glass.x;
                bool back = radtex_fresnel(towards, radtex_beyond(towards, index), index) >= 0.5;
                float bend = 0.0;
                if (glass.y > 0.0) bend = radtex_bend(way, ahead, towards);
                RadtexWay other = radtex_turned(way, ahead, towards, index, bend, !back);
                if (other.weight > parted.weight) parted = other;
                way = radtex_turned(way, ahead, towards, index, bend, back);
            }
            vec3 room = min(way.place, last - way.place);
            outside = min(room.x, min(room.y, room.z)) < 0.0;
            going = !outside && way.weight > 0.004;
        }
        if (way.weight > (k == 2 ? 0.0 : 0.004) && (outside || way.side < 0.0)) {
            float narrowest = clamp(way.beam.y / max(way.beam.x, 1e-12), 0.0, 64.0);  // so many steps back
            vec3 exit = low.xyz + (way.place - narrowest * way.ray) / low.w;
            float spread = log2(max(1.4 * way.beam.x, 1e-12));
            vec3 shown = radtex_shown(exit, way.ray, radtex_met(exit, way.ray), spread, vec4(0.0, 0.0, 0.0, 1e6));
            light += way.weight * exp2(way.tints * radtex_field_tint.xyz) * shown;
            lost -= way.weight;
        }
        way = parted;
        if (k == 1) {
            way.ray = -V;
            way.place = (from - low.xyz) * low.w;
            way.tints = 0.0;
            way.beam = vec3(0.5 / 1.4, 0.0, 0.0);
            way.weight = lost * glass.w - 0.004;
        }
    }
    return light;
}

@in glsl hlsl godot
#else
@end
// A way, at a place in texels' units of tiles: luminance * direction, luminance.
vec4 radtex_way(vec2 at) {
    vec4 range = radtex_exit_direction_range;
    return textureLod(radtex_exit_direction_map, at * range.xy, 0.0) * range.z + range.w;
}

// And its line: luminance * place, luminance * width².
vec4 radtex_path(vec2 at) {
    vec4 range = radtex_exit_place_range;
    return textureLod(radtex_exit_place_map, at * range.xy, 0.0) * range.z + range.w;
}

// The k-th of the four corners of a square.
vec2 radtex_corner(int k) {
    return vec2(float(k & 1), float((k >> 1) & 1));
}

// Where to look for a way's k-th tap: within the tile of a cell beside `low`, as the filter blends texels around
// `inside`, or at one of these.
vec2 radtex_tap(int k, vec2 low, vec2 inside) {
    vec2 cell = low + radtex_corner(k);
#if RADTEX_EXIT_TAPS == 16
    vec2 half_texel = radtex_exit_tile.zw, corner = floor(inside / half_texel * 0.5 - 0.5) * 2.0 + 1.0;
    vec2 texel = (corner + 2.0 * radtex_corner(k >> 2)) * half_texel;
    return cell + clamp(texel, half_texel, radtex_exit_tile.xy - half_texel);
#else
    return cell + inside;
#endif
}

// The weight of a tap; f and g are the places between four cells and between four texels.
float radtex_tap_weight(int k, vec2 f, vec2 g) {
    vec2 cell = mix(1.0 - f, f, radtex_corner(k));
#if RADTEX_EXIT_TAPS == 16
    cell *= mix(1.0 - g, g, radtex_corner(k >> 2));
#endif
    return cell.x * cell.y;
}

// What is seen of the surroundings through white glass. Of the ways around, those are followed that agree with the strongest
// one.
vec3 radtex_by_cells(vec2 uv, vec3 from, vec3 N, vec3 V, vec3 T, vec3 B) {
    float n = float(RADTEX_EXIT_CELLS);
    vec3 I = vec3(dot(V, T), dot(V, B), max(dot(V, N), 0.0));
    I *= inversesqrt(max(dot(I, I), 1e-18));
    vec2 disc = I.xy * inversesqrt(1.0 + I.z);  // equal area; and from there to the square
    vec2 square = disc * (length(disc) / max(max(abs(disc.x), abs(disc.y)), 1e-9));
    vec2 place = (clamp(square, vec2(-1.0, -1.0), vec2(1.0, 1.0)) * 0.5 + 0.5) * n - 0.5;
    place = clamp(place, vec2(0.0, 0.0), vec2(n - 1.0, n - 1.0));
    vec2 low = min(floor(place), vec2(n - 2.0, n - 2.0)), f = place - low;
    vec2 inside = radtex_inside(radtex_exit_tile, uv), g = fract(inside / radtex_exit_tile.zw * 0.5 - 0.5);
    vec4 way = vec4(0.0, 0.0, 0.0, 0.0), path = way;
@in wgsl
    var ways: array<vec4f, 16>;
@else
    vec4 ways[RADTEX_EXIT_TAPS];
@end
    vec3 chief = vec3(0.0, 0.0, 0.0);
    float total = 0.0;
    [unroll] for (int k = 0; k < RADTEX_EXIT_TAPS; k++) {
        ways[k] = radtex_tap_weight(k, f, g) * radtex_way(radtex_tap(k, low, inside));
        chief = dot(ways[k].xyz, ways[k].xyz) > dot(chief, chief) ? ways[k].xyz : chief;
        total += ways[k].w;
    }
    chief *= inversesqrt(max(dot(chief, chief), 1e-24));
    [unroll] for (int k = 0; k < RADTEX_EXIT_TAPS; k++) {
        float cosine = dot(ways[k].xyz, chief) * inversesqrt(max(dot(ways[k].xyz, ways[k].xyz), 1e-24));
        float kept = clamp((cosine - 0.8) / 0.15, 0.0, 1.0);
        way += kept * ways[k];
        if (kept > 0.0) path += kept * radtex_tap_weight(k, f, g) * radtex_path(radtex_tap(k, low, inside));
    }
    float brighter = total / max(way.w, 1e-9);  // as bright as all of them
    way *= brighter;
    path *= brighter;
    float luminance = max(way.w, 1e-6), even = length(way.xyz);
    float width = max(path.w / luminance + max(1.0 - even / luminance - 0.03, 0.0), 1e-12);  // more if they disagree
    vec3 away = way.xyz / max(even, 1e-9), moved = path.xyz / luminance;
    vec3 ray = away.x * T + away.y * B + away.z * N, exit = from + moved.x * T + moved.y * B + moved.z * N;
    return way.w * radtex_shown(exit, ray, radtex_met(exit, ray), log2(width), vec4(0.0, 0.0, 0.0, 1e6));
}
@in glsl hlsl godot
#endif
@end

// What is seen of the surroundings.
vec3 radtex_through(vec2 uv, vec3 from, vec3 N, vec3 V, vec3 T, vec3 B) {
    vec3 light;
#ifdef RADTEX_FIELD
    light = radtex_followed(from, N, V);
#else
    light = radtex_by_cells(uv, from, N, V, T, B);
#endif
    return light * radtex_colours(radtex_through_colour_map, radtex_through_colour_range, uv);
}
@in glsl hlsl godot

#ifndef RADTEX_IMAGES
@end
@in wgsl

@end
// Radiance towards the viewer, in the unit direction V, from a fragment at `position`.
vec3 radtex_layered_through(vec2 uv, vec3 position, vec3 N, vec3 V, vec3 T, vec3 B) {
    vec3 through = radtex_through(uv, position - radtex_middle.xyz, N, V, T, B)
        + radtex_rest(radtex_through_rest_map, radtex_through_rest_range, radtex_through_rest_tile,
            float(RADTEX_THROUGH_CELLS), uv, radtex_square(-V));
    return max(radtex_layered(uv, position, N, V) + radtex_alpha(uv) * through, vec3(0.0, 0.0, 0.0));
}
@in glsl hlsl godot
#endif
@end
@in hlsl

#endif
@end
