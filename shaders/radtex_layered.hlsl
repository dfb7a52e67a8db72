// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_layered.c.
//
// Look up a radiance texture in the layered layout: HLSL, shader model 5 and later. Define what the bake has, include
// this file, then
//
//     float3 V = normalize(camera - position), N = normalize(normal);  // in Blender's world space of the bake, z up
//     float3 light = radtex_layered(uv, position, N, V);               // premultiplied by radtex_alpha(uv)
//
// or, of an object that light comes through, what radtex_layered_through.hlsl adds; RADTEX_THROUGH is defined then.
//
// What the bake has. RADTEX_MIRRORS: any of its materials has lobes. RADTEX_TINT, RADTEX_NORMAL, RADTEX_WIDTH,
// RADTEX_ALPHA, RADTEX_PLANE, RADTEX_THINGS (with distances): these layers. RADTEX_LAMPS: how many, 0 to 8.
// RADTEX_SHELL: how many planes of a room the plane layer shows, 2 to 8; 0 if it is a single one. RADTEX_BOXES: how many
// boxes things lie in there, 1 to 8; else 0.
// RADTEX_GLOSSES: how much a material mirrors follows from its tint and its width. RADTEX_SHAPES: some lamps are
// rectangles, discs or balls where lobes are sharp, not blurs alone. RADTEX_TANGENT: some materials are brushed, and
// draw lamps out along the tangents of this layer. RADTEX_BEHIND: a plane or things hide some lamps, such as lights of
// the world.
// RADTEX_IMAGES: the material is shown by its own images, in place of colour, tint and normal: call radtex_layered_images.
// These are radtex_base_map, the base colour, its format sRGB; radtex_metal_map, green roughness and blue metal; and
// radtex_bump_map, the normal map, y up. RADTEX_IMAGE_SAMPLER(name): the sampler of each, such as name##_sampler;
// without, it is RADTEX_SAMPLER. RADTEX_PACKED_BUMP: the normal map holds x and y alone, as engines compress it: x is
// red times alpha, y is green.
// RADTEX_OWN_CELLS, RADTEX_REST_CELLS: cells along the sides of buckets.
//
// What a lookup costs. RADTEX_STEPS (0, 1, 2; default 1): fetches of distances. RADTEX_OWN_TAPS, RADTEX_REST_TAPS (3,
// 4; default 3): cells of a bucket that are blended; RADTEX_OWN_TAPS is 0 where an object mirrors nothing of itself,
// and the own layer is not read. RADTEX_SECOND_LOBE (0, 1; default 1): whether the second lobe is looked up, or
// materials have one lobe in place of two.
//
// RADTEX_TEMPORAL: cheaper where an engine has temporal antialiasing. Of the cells of a bucket one is read, drawn by
// chance as often as its weight says, and of two levels of a picture one: noise that the antialiasing averages away.
// RADTEX_FRAME: a whole number of the frame; default 0, as the jitter of such frames draws anew by itself.
//
// RADTEX_STEADY: lobes are wider where normals differ from one pixel to the next, so that what is far away or sharply
// curved does not shimmer. Its value is by how much: 0.16 is what a pixel covers, 4 times a twelfth for each of two
// axes, as a mirror doubles angles; more is steadier, and softer. In the pixel's stage alone, and never where pixels go
// different ways.
//
// Textures, one for each layer, are clamped to their edges and filtered linearly; irradiance and pictures have mip
// levels, filtered linearly, too. v = 0 is the first row, or with RADTEX_TOP_DOWN the last one. A range is the share of
// a texture's width and height that is no padding, and scale and offset: a value is texel * scale + offset, but for the
// alpha of own, plane and things.
// Uniforms are the same for all materials, but for radtex_material, radtex_lobes, radtex_gloss and radtex_brush: draw
// one material at a time.
//
// Where things are bound. RADTEX_SAMPLER: a linear, clamped SamplerState that is declared before; without, there is
// radtex_filtering. RADTEX_TEXTURE(k), RADTEX_BUFFER(k): what follows the declaration of the k-th texture or buffer,
// such as `: register(t##k)`; without, the compiler chooses. RADTEX_DECLARED: you declare textures and buffers before.
// RADTEX_NO_DERIVATIVES: for stages other than the pixel's, and for rays that end in the atlas.

#ifndef RADTEX_LAYERED_HLSL
#define RADTEX_LAYERED_HLSL

#ifndef RADTEX_LAMPS
#define RADTEX_LAMPS 0
#endif
#ifndef RADTEX_SHELL
#define RADTEX_SHELL 0
#endif
#ifndef RADTEX_BOXES
#define RADTEX_BOXES 0
#endif
#ifndef RADTEX_STEPS
#define RADTEX_STEPS 1
#endif
#ifndef RADTEX_OWN_TAPS
#define RADTEX_OWN_TAPS 3
#endif
#ifndef RADTEX_REST_TAPS
#define RADTEX_REST_TAPS 3
#endif
#ifndef RADTEX_SECOND_LOBE
#define RADTEX_SECOND_LOBE 1
#endif
#ifndef RADTEX_FRAME
#define RADTEX_FRAME 0
#endif
#ifndef RADTEX_TEXTURE
#define RADTEX_TEXTURE(k)
#endif
#ifndef RADTEX_BUFFER
#define RADTEX_BUFFER(k)
#endif
#ifndef RADTEX_SAMPLER
SamplerState radtex_filtering;
#define RADTEX_SAMPLER radtex_filtering
#endif
#ifndef RADTEX_IMAGE_SAMPLER
#define RADTEX_IMAGE_SAMPLER(name) RADTEX_SAMPLER
#endif

#ifndef RADTEX_DECLARED
Texture2D radtex_colour_map RADTEX_TEXTURE(0);
Texture2D radtex_irradiance_map RADTEX_TEXTURE(1);
Texture2D radtex_tint_map RADTEX_TEXTURE(2);
Texture2D radtex_normal_map RADTEX_TEXTURE(3);
Texture2D radtex_width_map RADTEX_TEXTURE(4);
Texture2D radtex_alpha_map RADTEX_TEXTURE(5);
Texture2D radtex_own_map RADTEX_TEXTURE(6);
Texture2D radtex_rest_map RADTEX_TEXTURE(7);
Texture2D radtex_world_map RADTEX_TEXTURE(8);
Texture2D radtex_plane_map RADTEX_TEXTURE(9);
Texture2D radtex_things_map RADTEX_TEXTURE(10);
Texture2D radtex_distances_map RADTEX_TEXTURE(11);
Texture2D radtex_tangent_map RADTEX_TEXTURE(19);
#ifdef RADTEX_IMAGES
Texture2D radtex_base_map RADTEX_TEXTURE(16);
Texture2D radtex_metal_map RADTEX_TEXTURE(17);
Texture2D radtex_bump_map RADTEX_TEXTURE(18);
#endif

cbuffer RadtexBake RADTEX_BUFFER(0) {
    float4 radtex_middle;        // xyz: from where the surroundings are seen
    float4 radtex_colour_range;  // part of width and height, scale, offset
    float4 radtex_irradiance_range;
    float4 radtex_tint_range;
    float4 radtex_normal_range;
    float4 radtex_width_range;
    float4 radtex_alpha_range;
    float4 radtex_tangent_range;
    float4 radtex_own_range;     // the size of a tile in place of the part
    float4 radtex_rest_range;
    float4 radtex_own_tile;      // size of a tile without its padding, and half a texel, in units of a tile
    float4 radtex_rest_tile;
    float4 radtex_world_range;
    float4 radtex_plane_range;
    float4 radtex_things_range;
    float4 radtex_distances_range;
    float4 radtex_world_levels;  // texels along a side, last level, log2 of level 0's width²
    float4 radtex_plane_levels;
    float4 radtex_things_levels;
    float4 radtex_distances_size;  // texels along a side, and the mean distance
    float4 radtex_plane_place;   // its normal and height, from the middle
    float4 radtex_plane_eye;     // where its picture was taken from, and how high above the plane that is
    float4 radtex_things_eye;    // xyz: where the picture of things was taken from, from the middle
    float4 radtex_shell[8];      // the normals and heights of a room's planes
    float4 radtex_box_low[8];    // xyz: the lowest corners of boxes that things lie in, from the middle
    float4 radtex_box_high[8];   // xyz: the highest corners
    float4 radtex_lamp_place[8];  // from the middle, and width²
    float4 radtex_lamp_light[8];  // rgb: irradiance at the middle; a: 1 if layers hide it
    float4 radtex_lamp_across[8];  // half a side, or a ball's radius; a: 1 / steradians from the middle, or 0
    float4 radtex_lamp_up[8];      // half of the other side, or a ball's 0; a: 1 if it is a disc
};

cbuffer RadtexMaterial RADTEX_BUFFER(1) {
    float4 radtex_material[16];  // by N.V: the falloff, and the sine by which lobes bend towards the normal
    float4 radtex_lobes[32];     // by N.V: weight, and log2 of the width²; the first lobe's, then the second one's
    float4 radtex_gloss[1];      // its mean glossy colour and log2 of its mean width²: see radtex_reflected; 0 if tints say all
    float4 radtex_brush[1];      // xy: of brushed metal the width² along the tangent and across it; or 0
};
#ifdef RADTEX_IMAGES
cbuffer RadtexImages RADTEX_BUFFER(3) {
    float4 radtex_images[3];  // as radtex_look_of takes them
};
#endif
#endif

float2 radtex_turned(float2 place) {
#ifdef RADTEX_TOP_DOWN
    place.y = 1.0 - place.y;
#endif
    return place;
}

float4 radtex_looked_up(Texture2D image, float2 place, float level) {
    return image.SampleLevel(RADTEX_SAMPLER, radtex_turned(place), level);
}

// A plain map's value.
float4 radtex_map(Texture2D image, float4 range, float2 uv) {
#ifdef RADTEX_NO_DERIVATIVES
    return radtex_looked_up(image, uv * range.xy, 0.0) * range.z + range.w;
#else
    return image.Sample(RADTEX_SAMPLER, radtex_turned(uv * range.xy)) * range.z + range.w;
#endif
}

// The same of a map of colours.
float3 radtex_colours(Texture2D image, float4 range, float2 uv) {
    return radtex_map(image, range, uv).rgb;
}

// How much a fragment hides of what lies behind it.
float radtex_alpha(float2 uv) {
#ifdef RADTEX_ALPHA
    return radtex_map(radtex_alpha_map, radtex_alpha_range, uv).r;
#else
    return 1.0;
#endif
}

// Where a direction, of any length, lies on the octahedron's square: 0 to 1.
float2 radtex_square(float3 direction) {
    float3 d = direction * (1.0 / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30));
    float2 folded = (1.0 - abs(d.yx)) * float2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return (d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5;
}

// Cells around a place in a bucket, and their weights.
struct RadtexCells {
    float2 a, b, c, d;
    float4 weight;
};

// A cell beyond an edge is the one that lies there on the sphere: the same edge's, mirrored at its middle.
float2 radtex_folded(float2 cell, float last) {
    float2 inside = clamp(cell, float2(0.0, 0.0), float2(last, last));
    return float2(cell.y != inside.y ? last - inside.x : inside.x, cell.x != inside.x ? last - inside.y : inside.y);
}

// The four of n x n cells around a place on the octahedron's square.
RadtexCells radtex_four_cells(float2 place, float n) {
    float2 position = place * n - 0.5, low = floor(position), f = position - low;
    RadtexCells cells;
    cells.a = radtex_folded(low, n - 1.0);
    cells.b = radtex_folded(low + float2(1.0, 0.0), n - 1.0);
    cells.c = radtex_folded(low + float2(0.0, 1.0), n - 1.0);
    cells.d = radtex_folded(low + 1.0, n - 1.0);
    cells.weight = float4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    return cells;
}

// Three of them: the square between four centres is two triangles, whose diagonals run as the octahedron's edges do.
RadtexCells radtex_three_cells(float2 place, float n) {
    float2 position = place * n - 0.5, low = floor(position), f = position - low;
    bool flipped = (place.x - 0.5) * (place.y - 0.5) < 0.0;
    f.x = flipped ? 1.0 - f.x : f.x;
    bool upper = f.x + f.y > 1.0;
    float2 corner = upper ? float2(1.0, 1.0) : float2(0.0, 0.0), g = upper ? 1.0 - f.yx : f;
    RadtexCells cells;
    cells.a = radtex_folded(low + float2(flipped ? 1.0 - corner.x : corner.x, corner.y), n - 1.0);
    cells.b = radtex_folded(low + float2(flipped ? 0.0 : 1.0, 0.0), n - 1.0);
    cells.c = radtex_folded(low + float2(flipped ? 1.0 : 0.0, 1.0), n - 1.0);
    cells.d = cells.a;
    cells.weight = float4(1.0 - g.x - g.y, g, 0.0);
    return cells;
}

// A place in a tile: `tile` as radtex_rest_tile.
float2 radtex_inside(float4 tile, float2 uv) {
    return clamp(uv * tile.xy, tile.zw, tile.xy - tile.zw);
}

// A number from 0 to 1 by chance, for two others (O'Neill, "PCG", 2014, by its output's permutation).
float radtex_chance(float2 at) {
    uint mixed = asuint(at.x) * 747796405u + asuint(at.y) * 2891336453u + uint(RADTEX_FRAME) * 1664525u;
    mixed = mixed * 747796405u + 2891336453u;
    mixed = ((mixed >> ((mixed >> 28u) + 4u)) ^ mixed) * 277803737u;
    return float(((mixed >> 22u) ^ mixed) >> 8u) / 16777216.0;
}

// One of three cells, drawn by chance as often as its weight says.
float2 radtex_drawn(RadtexCells cells, float2 inside) {
    float chance = radtex_chance(cells.a + inside);
    float2 cell = chance < cells.weight.x + cells.weight.y ? cells.b : cells.c;
    return chance < cells.weight.x ? cells.a : cell;
}

float4 radtex_three_taps(Texture2D image, RadtexCells cells, float2 inside, float2 size) {
    return radtex_looked_up(image, (cells.a + inside) * size, 0.0) * cells.weight.x
        + radtex_looked_up(image, (cells.b + inside) * size, 0.0) * cells.weight.y
        + radtex_looked_up(image, (cells.c + inside) * size, 0.0) * cells.weight.z;
}

float4 radtex_four_taps(Texture2D image, RadtexCells cells, float2 inside, float2 size) {
    return radtex_three_taps(image, cells, inside, size)
        + radtex_looked_up(image, (cells.d + inside) * size, 0.0) * cells.weight.w;
}

// What lobes and other paths, in coarse cells, do not tell, in the direction that lies at a place on the square.
float3 radtex_rest(Texture2D image, float4 range, float4 tile, float n, float2 uv, float2 place) {
    float4 found;
    float2 inside = radtex_inside(tile, uv);
#ifdef RADTEX_TEMPORAL
    found = radtex_looked_up(image, (radtex_drawn(radtex_three_cells(place, n), inside) + inside) * range.xy, 0.0);
#else
#if RADTEX_REST_TAPS == 4
    found = radtex_four_taps(image, radtex_four_cells(place, n), inside, range.xy);
#else
    found = radtex_three_taps(image, radtex_three_cells(place, n), inside, range.xy);
#endif
#endif
    return found.rgb * range.z + range.w;
}

#if defined(RADTEX_MIRRORS) || defined(RADTEX_THROUGH)
// The same as radtex_square on a picture of so many texels a side, whose outermost texels' centres lie on its edge.
float2 radtex_on_edges(float2 place, float size) {
    return place + (0.5 - place) / size;
}

// The texel of a picture around the direction d, blurred by a width² whose log2 is `spread`. Between levels it is mixed
// by the width, not by its logarithm: so a lobe's tails are nearly right.
float4 radtex_blurred(Texture2D image, float4 levels, float3 d, float spread) {
    float level = clamp(0.5 * (spread - levels.z), 0.0, levels.y), between = exp2(frac(level)) - 1.0;
    float2 place = radtex_on_edges(radtex_square(d), levels.x * exp2(-level));
#ifdef RADTEX_TEMPORAL
    between = radtex_chance(d.xy) < between ? 1.0 : 0.0;
#endif
    return radtex_looked_up(image, place, floor(level) + between);
}

// A picture of what is near, premultiplied by its alpha.
float4 radtex_picture(Texture2D image, float4 range, float4 levels, float3 d, float spread) {
    float4 found = radtex_blurred(image, levels, d, spread);
    return float4(found.rgb * range.z + range.w, found.a);
}

#ifdef RADTEX_PLANE
// What a lobe shows of the plane, and by how much that hides what lies behind: the mean direction of the share of the
// lobe that is below the horizon meets the plane, where its picture's eye sees the lobe wider or narrower.
float4 radtex_below(float3 from, float3 ray, float spread) {
    float3 N = radtex_plane_place.xyz;
    float sine = dot(ray, N), squared = sine * sine + 2.0 * exp2(spread), root = rsqrt(squared);
    float deep = clamp(squared * root, 1e-4, 0.999), share = 0.5 - 0.5 * sine * root;
    if (share < 0.002) return float4(0.0, 0.0, 0.0, 0.0);
    float3 level = ray - sine * N;
    level *= rsqrt(max(dot(level, level), 1e-12));
    float far = max(dot(from, N) - radtex_plane_place.w, 0.0) / deep;
    float3 met = from + far * (sqrt(1.0 - deep * deep) * level - deep * N) - radtex_plane_eye.xyz;
    float nearness = rsqrt(max(dot(met, met), 1e-12)), along = far * nearness;
    float wider = clamp(along * along * radtex_plane_eye.w * nearness / deep, 0.00390625, 16.0);
    float4 found = radtex_picture(radtex_plane_map, radtex_plane_range, radtex_plane_levels, met, spread + log2(wider));
    return found * share;
}

#if RADTEX_SHELL > 0
// Which of a room's planes a ray meets from inside, the nearest that it points at: its normal, and how far that is.
float4 radtex_wall(float3 from, float3 ray) {
    float4 found = float4(ray, 1e6);
    [unroll] for (int k = 0; k < RADTEX_SHELL; k++) {
        float4 plane = radtex_shell[k];
        float sine = -dot(ray, plane.xyz);
        float reach = max(dot(from, plane.xyz) - plane.w, 0.0) / max(sine, 1e-4);
        if (sine > 1e-4 && reach < found.w) found = float4(plane.xyz, reach);
    }
    return found;
}

// What a lobe shows of a room's planes.
float4 radtex_walls(float3 from, float3 ray, float spread) {
    float4 wall = radtex_wall(from, ray);
    float3 met = from + wall.w * ray - radtex_plane_eye.xyz;
    float nearness = rsqrt(max(dot(met, met), 1e-12)), along = wall.w * nearness;
    float wider = along * along * nearness * abs(dot(wall.xyz, met)) / max(abs(dot(wall.xyz, ray)), 1e-4);
    wider = clamp(wider, 0.00390625, 16.0);
    return radtex_picture(radtex_plane_map, radtex_plane_range, radtex_plane_levels, met, spread + log2(wider));
}
#endif
#endif

#ifdef RADTEX_THINGS
// How far along the unit ray is a sphere of that radius about the middle; `along` is from . ray, `squared` from . from.
float radtex_reach(float along, float squared, float radius) {
    return sqrt(max(along * along - squared + radius * radius, 0.0)) - along;
}

// The distance from the middle of what lies in a direction.
float radtex_distance(float3 d) {
    float2 place = radtex_on_edges(radtex_square(d), radtex_distances_size.x);
    float4 range = radtex_distances_range;
    return 1.0 / max(radtex_looked_up(radtex_distances_map, place, 0.0).r * range.z + range.w, 1e-9);
}
#endif

#if RADTEX_BOXES > 0
// The nearest box that a ray comes to: how far away the ray begins to look for things, and enters and leaves the box;
// and how far away a wall is, where it does all that if it comes to none. From within, it begins where it leaves.
float4 radtex_span(float3 from, float3 ray) {
    float wall = radtex_wall(from, ray).w;
    float4 span = float4(wall, wall, wall, wall);
    float3 slow = float3(abs(ray.x) < 1e-7 ? 1e-7 : ray.x, abs(ray.y) < 1e-7 ? 1e-7 : ray.y,
        abs(ray.z) < 1e-7 ? 1e-7 : ray.z);
    [unroll] for (int k = 0; k < RADTEX_BOXES; k++) {
        float3 one = (radtex_box_low[k].xyz - from) / slow, other = (radtex_box_high[k].xyz - from) / slow;
        float3 near = min(one, other), far = max(one, other);
        float first = max(near.x, max(near.y, near.z)), last = min(far.x, min(far.y, far.z));
        float start = first > 0.0 ? first : last;
        if (first <= last && last > 0.0 && start < span.x) span = float4(start, max(first, 0.0), last, wall);
    }
    return span;
}

// How far along the unit ray things are that are seen at a distance: in the box, or else at the wall.
float radtex_reached(float along, float squared, float distance, float4 span) {
    float reach = radtex_reach(along, squared, distance);
    return reach > span.z + 0.12 * distance ? span.w : clamp(reach, span.y, span.z);
}

// The same for a ray that passes behind the side of a thing that its eye sees: one that meets nothing between where it
// enters and leaves its box meets it in the middle of its way through it if that lies behind such a side, by no more than
// that way.
float radtex_behind(float3 offset, float3 ray, float reach, float4 span) {
    if (span.y >= span.z || (reach > span.y && reach < span.z)) return reach;
    float middle = 0.5 * (span.y + span.z);
    float3 reached = offset + middle * ray;
    float length_ = length(reached), distance = radtex_distance(reached);
    return length_ >= 0.98 * distance && length_ - distance <= span.z - span.y ? middle : reach;
}
#endif

// Where a ray meets things, from their eye, and log2 of how much a lobe's width² is larger as seen from there. In a room
// the length is 1, or of a ray that passes between things, 1 and how far aside of it lies what is seen there, as the squared
// sine of the angle.
float4 radtex_met(float3 from, float3 ray) {
#ifdef RADTEX_THINGS
    float3 offset = from - radtex_things_eye.xyz, met = ray;
    float along = dot(offset, ray), squared = dot(offset, offset), reach;
#if RADTEX_BOXES > 0
    float4 span = radtex_span(from, ray);
    reach = span.x;
    met = offset + reach * ray;
#if RADTEX_STEPS > 0
    float distance = radtex_distance(met);
    reach = radtex_reached(along, squared, distance, span);
#if RADTEX_STEPS > 1
    met = offset + reach * ray;
    distance = radtex_distance(met);
    reach = radtex_reached(along, squared, distance, span);
#endif
    reach = radtex_behind(offset, ray, reach, span);
    met = offset + reach * ray;
    float scale = rsqrt(max(dot(met, met), 1e-12));
    met *= scale;
    if (reach >= span.w) {
        float3 away = distance * met - offset;
        float ahead = max(dot(away, ray), 0.0);
        met *= 2.0 - ahead * ahead / max(dot(away, away), 1e-12);
    }
    return float4(met, 2.0 * log2(clamp(reach * scale, 0.0625, 4.0)));
#endif
#else
#if RADTEX_STEPS < 2  // begin on a sphere
    reach = radtex_reach(along, squared, radtex_distances_size.y);
    met = offset + reach * ray;
#endif
#if RADTEX_STEPS > 0
    reach = radtex_reach(along, squared, radtex_distance(met));
    met = offset + reach * ray;
#endif
#if RADTEX_STEPS > 1
    reach = radtex_reach(along, squared, radtex_distance(met));
    met = offset + reach * ray;
#endif
#endif
    return float4(met, 2.0 * log2(clamp(reach * rsqrt(max(dot(met, met), 1e-12)), 0.0625, 4.0)));
#else
    return float4(ray, 0.0);
#endif
}

#ifdef RADTEX_THINGS
// What a lobe as wide as `spread` says shows of the things that its ray meets; of what lies far aside of it nothing.
float4 radtex_things(float4 met, float spread) {
    float4 found = radtex_picture(radtex_things_map, radtex_things_range, radtex_things_levels, met.xyz, spread
        + met.w);
#if RADTEX_BOXES > 0
#if RADTEX_STEPS > 0
    found *= clamp(2.0 - 0.25 * (length(met.xyz) - 1.0) / max(exp2(spread), 1e-6), 0.0, 1.0);
#endif
#endif
    return found;
}
#endif

// Places of brushed metal: unit vectors to the viewer, of the normal, and of the tangent across that; and the lobe's
// width² along the tangent and across it, which are alike where the tangent is not known, and is 0. Of what is not
// brushed `along` is 0.
struct RadtexBrush {
    float3 viewer;
    float3 normal;
    float3 tangent;
    float along;
    float across;
};

float radtex_luminance(float3 colour) {
    return dot(colour, float3(0.2126, 0.7152, 0.0722));
}

#if RADTEX_LAMPS > 0
// How much of what lies behind all layers is seen between them, about the unit ray and as wide as `spread` says.
float radtex_free_way(float3 from, float3 ray, float spread) {
    float free = 1.0;
#ifdef RADTEX_PLANE
#if RADTEX_SHELL > 0
    free = 1.0 - radtex_walls(from, ray, spread).a;
#else
    free = 1.0 - radtex_below(from, ray, spread).a;
#endif
#endif
#ifdef RADTEX_THINGS
    free *= 1.0 - radtex_things(radtex_met(from, ray), spread).a;
#endif
    return free;
}
#endif

// The normal of a surface, and the luminance of its irradiance, which is pi times `even`: more than any sun's where the
// diffuse colour is too dark to tell it.
float4 radtex_lit_by(float3 face, float3 even, float3 colour) {
    float unknown = max(1.0 - 50.0 * max(colour.r, max(colour.g, colour.b)), 0.0);
    return float4(face, 3.14159265 * radtex_luminance(even) + 1e6 * unknown);
}

#if RADTEX_LAMPS > 0
#ifdef RADTEX_SHAPES
// Of a polygon's edge between unit vectors, the angle times how much the edge's normal lies along the axis.
float radtex_edge(float3 one, float3 other, float3 axis) {
    float cosine = dot(one, other), x = abs(cosine);
    float high = 0.030891881 + x * (-0.0170881256 + x * (0.0066700901 + x * -0.0012624911));
    float angle = 1.570796305 + x * (-0.2145988016 + x * (0.0889789874 + x * (-0.0501743046 + x * high)));
    angle *= rsqrt(1.0 + x);  // over its sine (Abramowitz and Stegun, 4.4.46)
    float wide = 3.14159265 * rsqrt(max(1.0 - x * x, 1e-12)) - angle;
    return dot(cross(one, other), axis) * (cosine < 0.0 ? wide : angle);
}

// A unit vector there, once what lies across the axis is stretched as much as a lobe is narrow.
float3 radtex_stretched(float3 way, float3 axis, float blunt) {
    float3 found = way + blunt * dot(way, axis) * axis;
    return found * rsqrt(max(dot(found, found), 1e-24));
}

// How much of a lobe of that width² lies on a lamp, which is `towards` from where it begins; a lamp's shape is as
// radtex_lamp_across and radtex_lamp_up tell. A lobe is a cosine's foreshortening on a plane: so that is Lambert's formula
// for polygons, and for a ball the view factor of a disc.
float radtex_covered(float3 towards, float3 ray, float width, float4 across, float4 up) {
    if (dot(up.xyz, up.xyz) == 0.0) {
        float along = dot(towards, ray), radius = dot(across.xyz, across.xyz);
        float3 aside = towards / max(along, 1e-12) - ray;
        float sharp = 0.5 / max(width, 1e-6);
        float size = min(radius / max(dot(towards, towards) - radius, 1e-12), 1000.0) * sharp;
        float away = min(dot(aside, aside), 1e6) * sharp, apart = away - size;
        if (along <= 0.0) return 0.0;
        return 0.5 - 0.5 * (1.0 + apart) * rsqrt(1.0 + 2.0 * (away + size) + apart * apart);
    }
    bool isDisc = up.w > 0.5;
    int count = isDisc ? 12 : 4;
    float far = isDisc ? 1.0233267 : 1.41421356;  // as large as the disc, and as far as a rectangle's corners
    float turn = isDisc ? 0.52359878 : 1.57079633, c = cos(turn), s = sin(turn), blunt = sqrt(2.0 * width) - 1.0;
    float2 at = float2(far * cos(0.5 * turn), far * sin(0.5 * turn));
    float3 last = radtex_stretched(towards + at.x * across.xyz + at.y * up.xyz, ray, blunt);
    float found = 0.0;
    for (int k = 0; k < count; k++) {
        at = float2(at.x * c - at.y * s, at.x * s + at.y * c);
        float3 next = radtex_stretched(towards + at.x * across.xyz + at.y * up.xyz, ray, blunt);
        found += radtex_edge(last, next, ray);
        last = next;
    }
    return clamp(found / 6.2831853, 0.0, 1.0);
}
#endif

// How much of a lamp that layers are before is seen between them; `ray` is the unit vector to it, `nearer` by how much
// more it lights than the middle. A surface whose unit normal is lit.xyz sees no more than the luminance of its
// irradiance, lit.w, allows.
float radtex_lamp_free(float4 place, float4 light, float3 from, float3 ray, float nearer, float4 lit) {
    float free = lit.w / max(nearer * radtex_luminance(light.rgb) * max(dot(lit.xyz, ray), 0.1), 1e-9);
    free = clamp((free - 0.1) / 0.9, 0.0, 1.0);
    if (free > 0.0) free *= radtex_free_way(from, ray, log2(place.w * nearer));
    return free;
}

// What brushed metal shows of a small lamp in the unit direction `way`, blurred by a width² `size`: GGX with two
// roughnesses, D G1 / (4 N.V) (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018).
float radtex_brushed(RadtexBrush brush, float3 way, float size) {
    float3 between = brush.viewer + way;
    between *= rsqrt(max(dot(between, between), 1e-12));
    float upright = max(dot(between, brush.normal), 1e-3), aside = dot(between, brush.tangent) / upright;
    float flatness = max(1.0 / (upright * upright) - 1.0 - aside * aside, 0.0);
    float along = 0.5 * (brush.along + size), across = 0.5 * (brush.across + size);
    float tail = (1.0 + aside * aside / along + flatness / across) * upright * upright;
    float cosine = max(dot(brush.viewer, brush.normal), 1e-3), slant = dot(brush.viewer, brush.tangent);
    float rough = brush.across * max(1.0 - cosine * cosine - slant * slant, 0.0) + brush.along * slant * slant;
    float seen = 2.0 / (cosine + sqrt(cosine * cosine + 0.5 * rough));  // G1 / N.V
    float shown = seen * rsqrt(along * across) / (12.56637061 * tail * tail);
    return dot(way, brush.normal) > 0.0 ? shown : 0.0;
}

// What a lobe of that width², or of brushed metal, shows of the lamp with that number.
float3 radtex_lamp(int number, float3 from, float3 ray, float width, float4 lit, RadtexBrush brush) {
    float4 place = radtex_lamp_place[number], light = radtex_lamp_light[number];
    float3 towards = place.xyz - from;
    float squared = dot(towards, towards), nearer = dot(place.xyz, place.xyz) / squared;
    float size = place.w * nearer, wide = width + size;
    float off = wide + 1.0 - dot(ray, towards) * rsqrt(squared);
    float free = 1.0, shown = nearer * (1.0 + 0.5 * wide) * wide / (6.2831853 * off * off);
#ifdef RADTEX_TANGENT
    if (brush.along > 0.0) shown = nearer * radtex_brushed(brush, towards * rsqrt(squared), size);
#endif
#ifdef RADTEX_SHAPES
    float4 across = radtex_lamp_across[number], up = radtex_lamp_up[number];
    if (across.w > 0.0) {
        float3 back = cross(across.xyz, up.xyz);
        float square = dot(back, towards) * sqrt(nearer), there = dot(back, place.xyz);  // how squarely it is seen
        if (dot(up.xyz, up.xyz) > 0.0) shown *= clamp(square / max(there, 1e-12), 0.0, 4.0);
        float share = clamp(2.0 - width / min(8.0 * size, 0.04), 0.0, 1.0);
#ifdef RADTEX_TANGENT
        if (brush.along > 0.0) share = 0.0;
#endif
        if (share > 0.0) shown += share * (radtex_covered(towards, ray, width, across, up) * across.w - shown);
    }
#endif
#if RADTEX_SHELL > 0
    if (light.w > 0.5) free = radtex_lamp_free(place, light, from, towards * rsqrt(squared), nearer, lit);
#endif
#ifdef RADTEX_BEHIND
    if (light.w > 0.5) free = radtex_lamp_free(place, light, from, towards * rsqrt(squared), nearer, lit);
#endif
    return light.rgb * (free * shown);
}
#endif

float3 radtex_lamps(float3 from, float3 ray, float width, float4 lit, RadtexBrush brush) {
    float3 light = float3(0.0, 0.0, 0.0);
#if RADTEX_LAMPS > 0
    for (int k = 0; k < RADTEX_LAMPS; k++) {
        light += radtex_lamp(k, from, ray, width, lit, brush);
    }
#endif
    return light;
}

// What a lobe about the unit ray, of a width² whose log2 is `spread`, shows of the surroundings from a place that is
// given from the middle; `met` is radtex_met of both, `lit` as for radtex_lamp_free, (0, 0, 0, 1e6) where no surface is.
float3 radtex_shown_by(float3 from, float3 ray, float4 met, float spread, float4 lit, RadtexBrush brush) {
    float3 light = float3(0.0, 0.0, 0.0);
    float left = 1.0;  // of what lies behind
    float4 next;
#ifdef RADTEX_THINGS
    next = radtex_things(met, spread);
    light = next.rgb;
    left = 1.0 - next.a;
#endif
#ifdef RADTEX_PLANE
    if (left > 0.001) {
#if RADTEX_SHELL > 0
        next = radtex_walls(from, ray, spread);
#else
        next = radtex_below(from, ray, spread);
#endif
        light += left * next.rgb;
        left *= 1.0 - next.a;
    }
#endif
    if (left > 0.001) {
        next = radtex_blurred(radtex_world_map, radtex_world_levels, ray, spread);
        light += left * (next.rgb * radtex_world_range.z + radtex_world_range.w);
    }
    return light + radtex_lamps(from, ray, exp2(spread), lit, brush);
}

// The same of what is not brushed.
float3 radtex_shown(float3 from, float3 ray, float4 met, float spread, float4 lit) {
    RadtexBrush brush;
    brush.viewer = ray;
    brush.normal = ray;
    brush.tangent = ray;
    brush.along = 0.0;
    brush.across = 0.0;
    return radtex_shown_by(from, ray, met, spread, lit, brush);
}
#endif

#ifdef RADTEX_MIRRORS
// What the object shows of itself in the direction that lies at a place on the square, and how much it leaves free.
float4 radtex_own(float2 uv, float2 place) {
#if RADTEX_OWN_TAPS == 0
    return float4(0.0, 0.0, 0.0, 1.0);
#else
    float n = float(RADTEX_OWN_CELLS);
    float2 inside = radtex_inside(radtex_own_tile, uv), size = radtex_own_range.xy;
    RadtexCells cells;
    float4 own;
#ifdef RADTEX_TEMPORAL
    cells = radtex_three_cells(place, n);
    own = radtex_looked_up(radtex_own_map, (radtex_drawn(cells, inside) + inside) * size, 0.0);
#else
#if RADTEX_OWN_TAPS == 4
    cells = radtex_four_cells(place, n);
    own = radtex_four_taps(radtex_own_map, cells, inside, size);
#else
    cells = radtex_three_cells(place, n);
    own = radtex_three_taps(radtex_own_map, cells, inside, size);
#endif
#endif
    return float4(own.rgb * radtex_own_range.z + radtex_own_range.w, own.a);
#endif
}

// How much the object leaves free of its surroundings, as a lobe of that width² sees it; `kept` is as cells see it.
float radtex_free(float kept, float width) {
    float side = clamp(2.0 * kept - 1.0, -1.0, 1.0);
    float sharper = side * max(5.0 / float(RADTEX_OWN_CELLS) * rsqrt(width + 0.0016), 1.0);
    return 0.5 + 0.5 * sharper * rsqrt(1.0 - side * side + sharper * sharper);
}

#ifdef RADTEX_GLOSSES
// What of the light is reflected where facets' reflectance is F: F x + y, by roughness and N.V (Karis, "Physically Based
// Shading on Mobile", 2014).
float2 radtex_environment(float rough, float cosine) {
    float smoothness = 1.0 - rough;
    float grazing = min(smoothness * smoothness, exp2(-9.28 * cosine)) * smoothness + (0.0425 - 0.0275 * rough);
    return float2(1.04 - 0.572 * rough - 1.04 * grazing, 0.022 * rough - 0.04 + 1.04 * grazing);
}

// What a surface reflects at N.V that reflects `colour` along its normal, with lobes of that width²; both colours are
// premultiplied by `opacity`.
float3 radtex_reflected(float3 colour, float width, float cosine, float opacity) {
    float rough = sqrt(sqrt(clamp(width / max(2.0 - 5.0 * width, 1e-6), 0.0, 1.0)));
    float2 here = radtex_environment(rough, clamp(cosine, 0.0, 1.0)), facing = radtex_environment(rough, 1.0);
    float3 facets = max(colour - opacity * facing.y, float3(0.0, 0.0, 0.0)) / facing.x;
    float glossy = min(50.0 * max(colour.r, max(colour.g, colour.b)), opacity);  // what reflects less is no surface
    return facets * here.x + glossy * here.y;
}
#endif

// What a lobe (weight, and log2 of its width²) shows; `own` is what the object shows of itself.
float3 radtex_mirrored(float3 from, float3 ray, float4 met, float4 own, float4 lobe, float4 lit, RadtexBrush brush) {
#if RADTEX_OWN_TAPS == 0
    return lobe.rgb * radtex_shown_by(from, ray, met, lobe.a, lit, brush);
#else
    float free = radtex_free(own.a, exp2(lobe.a));
    float3 light = own.rgb;
    if (free > 0.001) light += free * (radtex_shown_by(from, ray, met, lobe.a, lit, brush) - light);
    return lobe.rgb * light;
#endif
}
#endif

// A material at a place: the colour of its diffuse light, what its lobes are multiplied by, its normal, and its alpha,
// by which both are multiplied.
struct RadtexLook {
    float3 colour;
    float3 tint;
    float3 normal;
    float opacity;
};

// That of a Principled BSDF whose maps are images, by what these hold at the place: base colour (linear), roughness and
// metal, and the normal map. Each of three vectors of the material's has a colour: of diffuse light, of what is no metal,
// of metal; and a number: what metal is multiplied by, the normal map's strength, and by how much roughness to the fourth
// dims what is no metal. T and B are the tangents of the images'
// texture coordinates, with the normal `face` interpolated but not normalised; `opacity` is radtex_alpha.
RadtexLook radtex_look_of(float4 diffuse, float4 dull, float4 shiny, float3 base, float2 rough, float3 bump, float3 T,
                          float3 B, float3 face, float opacity) {
    float part = diffuse.a * rough.y, squared = rough.x * rough.x, fades = 1.0 - shiny.a * squared * squared;
    float3 turn = 2.0 * bump - 1.0, N = face * rsqrt(max(dot(face, face), 1e-12));
    float3 mapped = turn.x * T + turn.y * B + turn.z * face;
    mapped *= rsqrt(max(dot(mapped, mapped), 1e-12));
    RadtexLook look;
    look.colour = diffuse.rgb * base * (opacity * (1.0 - part));
    look.tint = opacity * (dull.rgb * (fades * (1.0 - part)) + shiny.rgb * base * part);
    look.normal = N + dull.a * (mapped - N);
    look.opacity = opacity;
    return look;
}

#ifdef RADTEX_IMAGES
float4 radtex_image(Texture2D image, SamplerState filtering, float2 place) {
#ifdef RADTEX_NO_DERIVATIVES
    return image.SampleLevel(filtering, place, 0.0);
#else
    return image.Sample(filtering, place);
#endif
}

// The same of the images that are bound, at their texture coordinates `place`.
RadtexLook radtex_look_of_images(float2 place, float2 uv, float3 T, float3 B, float3 face) {
    float3 base = radtex_image(radtex_base_map, RADTEX_IMAGE_SAMPLER(radtex_base_map), place).rgb;
    float2 rough = radtex_image(radtex_metal_map, RADTEX_IMAGE_SAMPLER(radtex_metal_map), place).gb;
    float4 bump = radtex_image(radtex_bump_map, RADTEX_IMAGE_SAMPLER(radtex_bump_map), place);
#ifdef RADTEX_PACKED_BUMP
    bump.x *= bump.w;
    float2 turn = 2.0 * bump.xy - 1.0;
    bump.z = 0.5 + 0.5 * sqrt(max(1.0 - dot(turn, turn), 0.0));
#endif
    return radtex_look_of(radtex_images[0], radtex_images[1], radtex_images[2], base, rough, bump.xyz, T, B, face,
        radtex_alpha(uv));
}
#else
// The same by the bake's maps; `face` is the mesh's unit normal.
RadtexLook radtex_look(float2 uv, float3 face) {
    RadtexLook look;
    look.opacity = radtex_alpha(uv);
    look.colour = radtex_colours(radtex_colour_map, radtex_colour_range, uv);
    look.tint = float3(look.opacity, look.opacity, look.opacity);
    look.normal = face;
#ifdef RADTEX_TINT
    look.tint = radtex_colours(radtex_tint_map, radtex_tint_range, uv);
#endif
#ifdef RADTEX_NORMAL
    look.normal = radtex_map(radtex_normal_map, radtex_normal_range, uv).xyz;
#endif
    return look;
}
#endif

// Radiance towards the viewer, in the unit direction V, from a place at `position` whose unit normal is `face`, of a
// material that looks so, with lobes whose width² is larger by `more`.
float3 radtex_lit(float2 uv, float3 position, float3 face, float3 V, RadtexLook look, float more) {
    const int material = 0;
    float3 shading = look.normal * rsqrt(max(dot(look.normal, look.normal), 1e-12));
    float3 N = dot(shading, face) > 0.3 ? shading : face;
    float cosine = dot(N, V), curve = clamp(cosine * 16.0 - 0.5, 0.0, 15.0);
    float below = min(floor(curve), 14.0), above = curve - below;
    int low = 16 * material + int(below);
    float4 facts = lerp(radtex_material[low], radtex_material[low + 1], above);
    float3 even = radtex_map(radtex_irradiance_map, radtex_irradiance_range, uv).rgb;
    float3 light = look.colour * even * facts.rgb;
    float3 axis = 2.0 * cosine * N - V;
    axis += max(0.01 - dot(axis, face), 0.0) * face;  // no lower than the surface
    axis *= rsqrt(dot(axis, axis));
    float2 place = radtex_square(axis);
#ifdef RADTEX_MIRRORS
    low += 16 * material;
    float4 lobe = lerp(radtex_lobes[low], radtex_lobes[low + 1], above), second = float4(0.0, 0.0, 0.0, 0.0);
#if RADTEX_SECOND_LOBE > 0
    second = lerp(radtex_lobes[low + 16], radtex_lobes[low + 17], above);
#endif
    float wider = 0.0;
#ifdef RADTEX_WIDTH
    wider = radtex_map(radtex_width_map, radtex_width_range, uv).r;
#endif
    float spread = more;
#ifdef RADTEX_STEADY
    float3 across = ddx(N), up = ddy(N);
    spread += float(RADTEX_STEADY) * (dot(across, across) + dot(up, up));
#endif
    if (radtex_luminance(lobe.rgb + second.rgb) > 0.0) {
        float3 from = position - radtex_middle.xyz, towards = N - dot(N, axis) * axis;
        towards *= rsqrt(max(dot(towards, towards), 1e-12));
        float3 ray = axis * sqrt(1.0 - facts.a * facts.a) + towards * facts.a;
        float4 own = radtex_own(uv, place), met = radtex_met(from, ray), lit = radtex_lit_by(face, even, look.colour);
        lobe.a = log2(exp2(lobe.a + wider) + spread);
        RadtexBrush brush;
        brush.viewer = 2.0 * dot(N, axis) * N - axis;
        brush.normal = N;
        brush.tangent = N;
        brush.along = 0.0;
        brush.across = 0.0;
#ifdef RADTEX_TANGENT
        float4 brushed = radtex_brush[material];
        if (brushed.x > 0.0) {
            float3 tangent = radtex_map(radtex_tangent_map, radtex_tangent_range, uv).xyz;
            tangent -= dot(N, tangent) * N;
            brush.along = brushed.x * exp2(wider) + spread;
            brush.across = brushed.y * exp2(wider) + spread;
            float known = dot(tangent, tangent);
            brush.tangent = tangent * rsqrt(max(known, 1e-12));
            if (known < 0.01) {
                brush.tangent = float3(0.0, 0.0, 0.0);
                brush.along = sqrt(brush.along * brush.across);
                brush.across = brush.along;
            }
        }
#endif
        float3 mirrored = radtex_mirrored(from, ray, met, own, lobe, lit, brush);
#if RADTEX_SECOND_LOBE > 0
        second.a = log2(exp2(second.a + wider) + spread);
        if (radtex_luminance(second.rgb) > 0.0) {
            mirrored += radtex_mirrored(from, ray, met, own, second, lit, brush);
        }
#endif
        float3 tint = look.tint;
#ifdef RADTEX_GLOSSES
        float4 gloss = radtex_gloss[material];
        if (gloss.g > 0.0) {
            tint = radtex_reflected(gloss.rgb * tint, exp2(gloss.a + wider), cosine, look.opacity);
        }
#endif
        light += mirrored * tint;
    }
#endif
    float3 rest = radtex_rest(radtex_rest_map, radtex_rest_range, radtex_rest_tile, float(RADTEX_REST_CELLS), uv,
        place);
    light += max(look.opacity * rest, -0.5 * light);
    return max(light, float3(0.0, 0.0, 0.0));
}

#ifdef RADTEX_IMAGES
// Radiance towards the viewer of the material that the uniforms tell of, by its own images: at their texture
// coordinates `place`, with the tangents of these. T, B and `face` are as radtex_look_of takes them.
float3 radtex_layered_images(float2 uv, float2 place, float3 position, float3 T, float3 B, float3 face, float3 V) {
    return radtex_lit(uv, position, normalize(face), V, radtex_look_of_images(place, uv, T, B, face), 0.0);
}
#else
// Radiance towards the viewer, in the unit direction V, from a place at `position` whose unit normal is N.
float3 radtex_layered(float2 uv, float3 position, float3 N, float3 V) {
    return radtex_lit(uv, position, N, V, radtex_look(uv, N), 0.0);
}
#endif

#endif
