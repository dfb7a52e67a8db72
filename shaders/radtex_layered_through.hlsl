// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_layered_through.c.
//
// Look up a radiance texture in the layered layout, of an object that light comes through: HLSL, shader model 5 and
// later. radtex_layered.hlsl, which says what is defined before, must lie beside it. Define RADTEX_THROUGH, include
// this file, then
//
//     float3 light = radtex_layered_through(uv, position, N, V, T, B);
//
// where N, T and B are the unit normal, tangent and bitangent of the baked UV map in the world space of the bake. Also
// defined before are RADTEX_EXIT_CELLS and RADTEX_THROUGH_CELLS, cells along the sides of buckets; and RADTEX_EXIT_TAPS
// (16, 4; default 16): the ways around are taken one by one, 32 fetches; or as the textures' filter blends those of
// texels, 8 fetches, which is far off where they part. Or RADTEX_FIELD: closed glass, whose distance field rays are followed
// through, two fetches a step.

#ifndef RADTEX_LAYERED_THROUGH_HLSL
#define RADTEX_LAYERED_THROUGH_HLSL

#include "radtex_layered.hlsl"

#ifndef RADTEX_EXIT_TAPS
#define RADTEX_EXIT_TAPS 16
#endif

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

#ifdef RADTEX_FIELD
// The field at a place in steps from its first sample: the unit normal of the surface nearest to it, and how far away that
// is, below 0 inside. Its layers lie side by side: radtex_field_size.w of them in a row.
float4 radtex_field(float3 at) {
    float4 size = radtex_field_size, range = radtex_field_range;
    float low = clamp(floor(at.z), 0.0, size.z - 2.0);
    float2 scale = range.xy / (size.xy * float2(size.w, ceil((size.z - 0.5) / size.w)));
    float row = floor((low + 0.5) / size.w), next = floor((low + 1.5) / size.w);
    float2 first = float2(low - row * size.w, row) * size.xy + at.xy + 0.5;
    float2 second = float2(low + 1.0 - next * size.w, next) * size.xy + at.xy + 0.5;
    float4 below = radtex_looked_up(radtex_field_map, first * scale, 0.0);
    return lerp(below, radtex_looked_up(radtex_field_map, second * scale, 0.0), at.z - low) * range.z + range.w;
}

// A ray through the object: where it is, in steps of the field; `side`: 1 inside, -1 outside; how often it was reflected.
// `tints`: how many surfaces tinted it, beyond the two by which light comes in and goes out. Of rough glass it is a `beam`:
// variances of its directions, and of its places across it, in z; in y, how both go together.
struct RadtexWay {
    float3 place;
    float3 ray;
    float3 beam;
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
float3 radtex_advanced(float3 beam, float steps) {
    return beam + steps * float3(0.0, beam.x, 2.0 * beam.y + steps * beam.x);
}

// Half of a beam behind a surface, by one of two planes: what its directions and places are multiplied by, what turns of
// the surface's normal count for, and by how much it turns from ray to ray.
float3 radtex_fanned(float3 beam, float direction, float place, float turn, float bend) {
    float bent = turn * bend;
    float wider = direction * (direction * beam.x + 2.0 * bent * beam.y) + bent * bent * beam.z;
    return 0.5 * float3(wider + turn * turn * radtex_field_glass.y, place * (direction * beam.y + bent * beam.z),
        place * place * beam.z);
}

// A beam that is reflected, or else refracted, by a surface whose normal bends so much a step.
float3 radtex_fan_out(float3 beam, float cosine, float beyond, float index, float bend, bool back) {
    float before = max(cosine, 0.2), after = max(beyond, 0.2), steeper = before / (index * after);
    float3 fanned;
    if (back) {
        fanned = radtex_fanned(beam, 1.0, 1.0, -2.0, bend / before)
            + radtex_fanned(beam, 1.0, 1.0, -2.0 * before, bend);
    } else {
        fanned = radtex_fanned(beam, steeper, after / before, 1.0 - steeper, bend / before)
            + radtex_fanned(beam, 1.0 / index, 1.0, after - before / index, bend);
    }
    return fanned * (4.0 / max(fanned.x, 4.0));
}

// By how much the unit normal `ahead` of where a ray is turns, a step further along the surface.
float radtex_bend(RadtexWay way, float3 ahead, float cosine) {
    float3 along = way.ray - cosine * ahead + 0.001 * cross(ahead, ahead.yzx);
    along *= rsqrt(max(dot(along, along), 1e-12));
    float3 beside = radtex_field(clamp(way.place + along, float3(0.0, 0.0, 0.0), radtex_field_size.xyz - 1.0)).xyz;
    beside *= way.side * rsqrt(max(dot(beside, beside), 1e-12));
    return clamp(dot(beside - ahead, along), -0.25, 0.25);
}

// What of a ray is reflected, or else refracted, by a surface with the unit normal `ahead` on its far side.
RadtexWay radtex_turned(RadtexWay way, float3 ahead, float cosine, float index, float bend, bool back) {
    float4 glass = radtex_field_glass;
    float beyond = radtex_beyond(cosine, index), reflected = radtex_fresnel(cosine, beyond, index);
    float3 bent = way.ray / index + (beyond - cosine / index) * ahead;
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
float3 radtex_followed(float3 from, float3 N, float3 V) {
    float4 glass = radtex_field_glass, low = radtex_field_low;
    float3 last = radtex_field_size.xyz - 1.0, light = float3(0.0, 0.0, 0.0);
    float cosine = max(dot(V, N), 0.001), beyond = radtex_beyond(cosine, glass.x);
    RadtexWay way;
    way.ray = normalize((cosine / glass.x - beyond) * N - V / glass.x);
    way.place = (from - low.xyz) * low.w + 1.5 * way.ray;
    way.beam = float3(0.0, 0.0, 0.0);
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
            float4 found = radtex_field(way.place);
            float free = -found.w * way.side;
            float3 normal = found.xyz;  // of an edge that of the nearest sample
            if (free < 0.1 && dot(normal, normal) < 0.9) normal = radtex_field(floor(way.place + 0.5)).xyz;
            float3 ahead = normal * (way.side * rsqrt(max(dot(normal, normal), 1e-12)));
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
            float3 room = min(way.place, last - way.place);
            outside = min(room.x, min(room.y, room.z)) < 0.0;
            going = !outside && way.weight > 0.004;
        }
        if (way.weight > (k == 2 ? 0.0 : 0.004) && (outside || way.side < 0.0)) {
            float narrowest = clamp(way.beam.y / max(way.beam.x, 1e-12), 0.0, 64.0);  // so many steps back
            float3 exit = low.xyz + (way.place - narrowest * way.ray) / low.w;
            float spread = log2(max(1.4 * way.beam.x, 1e-12));
            float3 shown = radtex_shown(exit, way.ray, radtex_met(exit, way.ray), spread, float4(0.0, 0.0, 0.0, 1e6));
            light += way.weight * exp2(way.tints * radtex_field_tint.xyz) * shown;
            lost -= way.weight;
        }
        way = parted;
        if (k == 1) {
            way.ray = -V;
            way.place = (from - low.xyz) * low.w;
            way.tints = 0.0;
            way.beam = float3(0.5 / 1.4, 0.0, 0.0);
            way.weight = lost * glass.w - 0.004;
        }
    }
    return light;
}

#else
// A way, at a place in texels' units of tiles: luminance * direction, luminance.
float4 radtex_way(float2 at) {
    float4 range = radtex_exit_direction_range;
    return radtex_looked_up(radtex_exit_direction_map, at * range.xy, 0.0) * range.z + range.w;
}

// And its line: luminance * place, luminance * width².
float4 radtex_path(float2 at) {
    float4 range = radtex_exit_place_range;
    return radtex_looked_up(radtex_exit_place_map, at * range.xy, 0.0) * range.z + range.w;
}

// The k-th of the four corners of a square.
float2 radtex_corner(int k) {
    return float2(float(k & 1), float((k >> 1) & 1));
}

// Where to look for a way's k-th tap: within the tile of a cell beside `low`, as the filter blends texels around
// `inside`, or at one of these.
float2 radtex_tap(int k, float2 low, float2 inside) {
    float2 cell = low + radtex_corner(k);
#if RADTEX_EXIT_TAPS == 16
    float2 half_texel = radtex_exit_tile.zw, corner = floor(inside / half_texel * 0.5 - 0.5) * 2.0 + 1.0;
    float2 texel = (corner + 2.0 * radtex_corner(k >> 2)) * half_texel;
    return cell + clamp(texel, half_texel, radtex_exit_tile.xy - half_texel);
#else
    return cell + inside;
#endif
}

// The weight of a tap; f and g are the places between four cells and between four texels.
float radtex_tap_weight(int k, float2 f, float2 g) {
    float2 cell = lerp(1.0 - f, f, radtex_corner(k));
#if RADTEX_EXIT_TAPS == 16
    cell *= lerp(1.0 - g, g, radtex_corner(k >> 2));
#endif
    return cell.x * cell.y;
}

// What is seen of the surroundings through white glass. Of the ways around, those are followed that agree with the strongest
// one.
float3 radtex_by_cells(float2 uv, float3 from, float3 N, float3 V, float3 T, float3 B) {
    float n = float(RADTEX_EXIT_CELLS);
    float3 I = float3(dot(V, T), dot(V, B), max(dot(V, N), 0.0));
    I *= rsqrt(max(dot(I, I), 1e-18));
    float2 disc = I.xy * rsqrt(1.0 + I.z);  // equal area; and from there to the square
    float2 square = disc * (length(disc) / max(max(abs(disc.x), abs(disc.y)), 1e-9));
    float2 place = (clamp(square, float2(-1.0, -1.0), float2(1.0, 1.0)) * 0.5 + 0.5) * n - 0.5;
    place = clamp(place, float2(0.0, 0.0), float2(n - 1.0, n - 1.0));
    float2 low = min(floor(place), float2(n - 2.0, n - 2.0)), f = place - low;
    float2 inside = radtex_inside(radtex_exit_tile, uv), g = frac(inside / radtex_exit_tile.zw * 0.5 - 0.5);
    float4 way = float4(0.0, 0.0, 0.0, 0.0), path = way;
    float4 ways[RADTEX_EXIT_TAPS];
    float3 chief = float3(0.0, 0.0, 0.0);
    float total = 0.0;
    [unroll] for (int k = 0; k < RADTEX_EXIT_TAPS; k++) {
        ways[k] = radtex_tap_weight(k, f, g) * radtex_way(radtex_tap(k, low, inside));
        chief = dot(ways[k].xyz, ways[k].xyz) > dot(chief, chief) ? ways[k].xyz : chief;
        total += ways[k].w;
    }
    chief *= rsqrt(max(dot(chief, chief), 1e-24));
    [unroll] for (int k = 0; k < RADTEX_EXIT_TAPS; k++) {
        float cosine = dot(ways[k].xyz, chief) * rsqrt(max(dot(ways[k].xyz, ways[k].xyz), 1e-24));
        float kept = clamp((cosine - 0.8) / 0.15, 0.0, 1.0);
        way += kept * ways[k];
        if (kept > 0.0) path += kept * radtex_tap_weight(k, f, g) * radtex_path(radtex_tap(k, low, inside));
    }
    float brighter = total / max(way.w, 1e-9);  // as bright as all of them
    way *= brighter;
    path *= brighter;
    float luminance = max(way.w, 1e-6), even = length(way.xyz);
    float width = max(path.w / luminance + max(1.0 - even / luminance - 0.03, 0.0), 1e-12);  // more if they disagree
    float3 away = way.xyz / max(even, 1e-9), moved = path.xyz / luminance;
    float3 ray = away.x * T + away.y * B + away.z * N, exit = from + moved.x * T + moved.y * B + moved.z * N;
    return way.w * radtex_shown(exit, ray, radtex_met(exit, ray), log2(width), float4(0.0, 0.0, 0.0, 1e6));
}
#endif

// What is seen of the surroundings.
float3 radtex_through(float2 uv, float3 from, float3 N, float3 V, float3 T, float3 B) {
    float3 light;
#ifdef RADTEX_FIELD
    light = radtex_followed(from, N, V);
#else
    light = radtex_by_cells(uv, from, N, V, T, B);
#endif
    return light * radtex_colours(radtex_through_colour_map, radtex_through_colour_range, uv);
}

#ifndef RADTEX_IMAGES
// Radiance towards the viewer, in the unit direction V, from a fragment at `position`.
float3 radtex_layered_through(float2 uv, float3 position, float3 N, float3 V, float3 T, float3 B) {
    float3 through = radtex_through(uv, position - radtex_middle.xyz, N, V, T, B)
        + radtex_rest(radtex_through_rest_map, radtex_through_rest_range, radtex_through_rest_tile,
            float(RADTEX_THROUGH_CELLS), uv, radtex_square(-V));
    return max(radtex_layered(uv, position, N, V) + radtex_alpha(uv) * through, float3(0.0, 0.0, 0.0));
}
#endif

#endif
