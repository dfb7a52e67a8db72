// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_trace.c.
//
// Find where a ray first meets a baked mesh: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later. Include it, then
//
//     RadtexMet met = radtex_trace(tree, nodes, from, ray, 0.0, culled);
//     if (met.far >= 0.0) light = radtex_hit(atlas, ivec2(W, H), n, met.uv, ray, met.normal, met.tangent.xyz,
//                                            met.tangent.w, RADTEX_QUADRILINEAR);
//
// or radtex_layered_of(met.material, met.uv, met.position, normalize(met.normal), -ray). `tree` is the texture `mirror` of
// an export, of 32-bit floats, read by texelFetch alone; `nodes` its number of nodes. From and ray are in Blender's world
// space of the bake, z up; ray has length 1. Hits nearer than `least` do not count, nor, if `culled`, do the backs of faces.
//
// The texture, row by row: two texels a node, (low, skip) and (high, leaf), with leaf = 8 * first + count of its triangles,
// 0 of an inner node; then nine texels a triangle: its corners' (position, u), (normal, v), and (tangent, one of: the
// bitangent's sign, the material's number, 0).

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
#endif

// Where a ray meets the mesh. `far` is the distance, below 0 where there is nothing; normal and tangent are interpolated,
// the tangent's fourth number is the bitangent's sign.
struct RadtexMet {
    float far;
    vec3 position;
    vec3 normal;
    vec4 tangent;
    vec2 uv;
    int material;
};

vec4 radtex_tree_texel(sampler2D tree, int number) {
    int width = textureSize(tree, 0).x;
    return texelFetch(tree, ivec2(number % width, number / width), 0);
}

// Distance and two barycentric coordinates where a ray meets a triangle; a distance below 0 if it does not.
// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
vec3 radtex_triangle(vec3 from, vec3 ray, vec3 a, vec3 b, vec3 c, bool culled) {
    vec3 nowhere = vec3(-1.0, 0.0, 0.0);
    vec3 along = b - a, up = c - a, P = cross(ray, up);
    float size = dot(along, P);
    if (culled ? size <= 0.0 : size == 0.0) return nowhere;
    vec3 towards = from - a, Q = cross(towards, along);
    float u = dot(towards, P) / size, v = dot(ray, Q) / size;
    if (u < 0.0 || v < 0.0 || u + v > 1.0) return nowhere;
    return vec3(dot(up, Q) / size, u, v);
}

// What lies in a triangle, whose first texel is `first`, at barycentric coordinates.
RadtexMet radtex_met_in(sampler2D tree, int first, vec3 from, vec3 ray, vec3 found) {
    vec3 weight = vec3(1.0 - found.y - found.z, found.yz);
    vec4 a = radtex_tree_texel(tree, first), b = radtex_tree_texel(tree, first + 1);
    vec4 c = radtex_tree_texel(tree, first + 2), d = radtex_tree_texel(tree, first + 3);
    vec4 e = radtex_tree_texel(tree, first + 4), f = radtex_tree_texel(tree, first + 5);
    vec4 g = radtex_tree_texel(tree, first + 6), h = radtex_tree_texel(tree, first + 7);
    vec4 i = radtex_tree_texel(tree, first + 8);
    RadtexMet met;
    met.far = found.x;
    met.position = from + found.x * ray;
    met.normal = weight.x * d.xyz + weight.y * e.xyz + weight.z * f.xyz;
    met.tangent = vec4(weight.x * g.xyz + weight.y * h.xyz + weight.z * i.xyz, g.w);
    met.uv = vec2(dot(weight, vec3(a.w, b.w, c.w)), dot(weight, vec3(d.w, e.w, f.w)));
    met.material = int(h.w + 0.5);
    return met;
}

RadtexMet radtex_trace(sampler2D tree, int nodes, vec3 from, vec3 ray, float least, bool culled) {
    vec3 safe = vec3(abs(ray.x) < 1e-9 ? 1e-9 : ray.x, abs(ray.y) < 1e-9 ? 1e-9 : ray.y,
        abs(ray.z) < 1e-9 ? 1e-9 : ray.z);
    vec3 slope = 1.0 / safe, best = vec3(exp2(100.0), 0.0, 0.0);
    int chosen = -1, node = 0;
    for (int visited = 0; visited < nodes && node < nodes; visited++) {
        vec4 low = radtex_tree_texel(tree, 2 * node), high = radtex_tree_texel(tree, 2 * node + 1);
        vec3 one = (low.xyz - from) * slope, other = (high.xyz - from) * slope;
        vec3 nearer = min(one, other), farther = max(one, other);
        float enters = max(max(nearer.x, nearer.y), max(nearer.z, least));
        float leaves = min(min(farther.x, farther.y), min(farther.z, best.x));
        if (enters > leaves * 1.000001) {
            node = int(low.w + 0.5);
            continue;
        }
        int leaf = int(high.w + 0.5), count = leaf % 8, first = 2 * nodes + 9 * (leaf / 8);
        for (int each = 0; each < count; each++) {
            int texel = first + 9 * each;
            vec3 a = radtex_tree_texel(tree, texel).xyz, b = radtex_tree_texel(tree, texel + 1).xyz;
            vec3 c = radtex_tree_texel(tree, texel + 2).xyz, found = radtex_triangle(from, ray, a, b, c, culled);
            if (found.x > least && found.x < best.x) {
                best = found;
                chosen = texel;
            }
        }
        node++;
    }
    if (chosen < 0) {
        RadtexMet nothing;
        nothing.far = -1.0;
        nothing.position = from;
        nothing.normal = -ray;
        nothing.tangent = vec4(1.0, 0.0, 0.0, 1.0);
        nothing.uv = vec2(0.0);
        nothing.material = 0;
        return nothing;
    }
    return radtex_met_in(tree, chosen, from, ray, best);
}
