// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Look up a radiance texture in the layered layout, in one pass without a loop: GLSL 330, GLSL ES 300 (WebGL 2).
// All textures are clamped to their edges and filtered: pictures between their mip levels too, the others have none.
//
// What a bake has is defined before: RADTEX_COLOUR (colour and irradiance) or RADTEX_LIT (their product in one
// texture), RADTEX_TINT, RADTEX_NORMAL, RADTEX_WIDTH, RADTEX_PLANE, RADTEX_THINGS, RADTEX_LAMPS (how many, 0 to 4),
// RADTEX_MIRRORS, RADTEX_REST and RADTEX_OWN_CELLS, RADTEX_REST_CELLS (along buckets' sides), RADTEX_ALPHA (what is looked up is premultiplied by radtex_alpha). What it costs is
// chosen: RADTEX_STEPS (0, 1 or 2 fetches of distances), RADTEX_OWN_TAPS and
// RADTEX_REST_TAPS (3 or 4 cells around a direction), and for the second lobe RADTEX_WHOLE (one picture of everything,
// as seen from the middle) or RADTEX_ALL (all that the first one looks at) or neither (no second lobe).

uniform vec3 middle;  // of the object, where all pictures are seen from
uniform vec4 material[16];  // falloff's three channels and the bend's sine, by N.V
#ifdef RADTEX_COLOUR
uniform sampler2D colour, irradiance;
uniform vec2 colour_part, irradiance_part;  // the share of a texture that is not padding
uniform float colour_scale;
#endif
#ifdef RADTEX_LIT
uniform sampler2D lit;
uniform vec2 lit_part;
#endif
#ifdef RADTEX_TINT
uniform sampler2D tint;
uniform float tint_scale;
uniform vec2 tint_part;
#endif
#ifdef RADTEX_ALPHA
uniform sampler2D alpha;
uniform vec2 alpha_part;

// How much a fragment hides of what lies behind it.
float radtex_alpha(vec2 uv) {
    return texture(alpha, uv * alpha_part).r;
}
#endif
#ifdef RADTEX_NORMAL
uniform sampler2D shading_normal;
uniform vec2 normal_part;
#endif
#ifdef RADTEX_WIDTH
uniform sampler2D width;  // how wide lobes are
uniform vec2 width_part, width_range;  // and scale and offset
#endif
#ifdef RADTEX_MIRRORS
uniform vec4 lobes[32];  // weight, and the width²'s logarithm to base 2, by N.V; then the second lobe's
uniform sampler2D world, own;
uniform vec3 world_levels;  // texels along a side, the last level, and the width² of level 0 as a logarithm
uniform vec4 own_tile;  // size of a tile's texels without padding, and half a texel, in units of a padded tile
uniform float own_scale;
#endif
#ifdef RADTEX_PLANE
uniform sampler2D plane;
uniform vec3 plane_levels;
uniform float plane_scale;
uniform vec4 plane_place;  // normal and height
uniform vec3 plane_eye;  // where its picture was taken from
#endif
#ifdef RADTEX_THINGS
uniform sampler2D things, distances;
uniform vec3 things_levels, nearness;  // scale, offset and mean of the distances' texels
uniform float things_scale, distances_size;
#endif
#ifdef RADTEX_WHOLE
uniform sampler2D whole;
uniform vec3 whole_levels;
#endif
#ifdef RADTEX_REST
uniform sampler2D rest;
uniform vec4 rest_tile;
uniform vec2 rest_range;  // scale and offset
#endif
#if RADTEX_LAMPS > 0
uniform vec4 lamp_place[RADTEX_LAMPS];  // and width²
uniform vec3 lamp_light[RADTEX_LAMPS];
#endif

#ifdef RADTEX_MIRRORS
const float OWN_CELLS = float(RADTEX_OWN_CELLS);
#endif
#ifdef RADTEX_REST
const float REST_CELLS = float(RADTEX_REST_CELLS);
#endif

// Where a direction, of any length, lies on the octahedron's square: 0 to 1.
vec2 radtex_square(vec3 d) {
    d *= 1.0 / max(abs(d.x) + abs(d.y) + abs(d.z), 1e-30);
    vec2 folded = (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return (d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5;
}

// The same on a texture of so many texels a side, of which the outermost ones' centres lie on the square's edge.
vec2 radtex_on_edges(vec2 place, float size) {
    return place + (0.5 - place) / size;
}

// Texture coordinates and level for the direction d and a width²'s logarithm to base 2. Between levels, pictures are
// mixed by the width, not by its logarithm: so a lobe's tails are nearly right.
vec3 radtex_picture(vec3 levels, vec3 d, float spread) {
    float level = clamp(0.5 * (spread - levels.z), 0.0, levels.y);
    return vec3(radtex_on_edges(radtex_square(d), levels.x * exp2(-level)), floor(level) + exp2(fract(level)) - 1.0);
}

// Cells around a place, of n x n, and their weights.
struct Cells {
    vec2 a, b, c, d;
    vec4 weight;
};

// A cell beyond an edge is the one that lies there on the sphere: the same edge's, mirrored at its middle.
vec2 radtex_folded(vec2 cell, float last) {
    vec2 inside = clamp(cell, 0.0, last);
    return vec2(cell.y != inside.y ? last - inside.x : inside.x, cell.x != inside.x ? last - inside.y : inside.y);
}

Cells radtex_four_cells(vec2 place, float n) {
    vec2 position = place * n - 0.5, low = floor(position), f = position - low;
    Cells cells;
    cells.a = radtex_folded(low, n - 1.0);
    cells.b = radtex_folded(low + vec2(1.0, 0.0), n - 1.0);
    cells.c = radtex_folded(low + vec2(0.0, 1.0), n - 1.0);
    cells.d = radtex_folded(low + 1.0, n - 1.0);
    cells.weight = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    return cells;
}

// The square between four cells' centres in two triangles: with the other diagonal it costs up to 0.7 dB.
Cells radtex_three_cells(vec2 place, float n) {
    vec2 position = place * n - 0.5, low = floor(position), f = position - low;
    bool flipped = (place.x - 0.5) * (place.y - 0.5) < 0.0;  // so that diagonals run as the octahedron's edges do
    f.x = flipped ? 1.0 - f.x : f.x;
    bool upper = f.x + f.y > 1.0;
    vec2 corner = vec2(upper), g = upper ? 1.0 - f.yx : f;
    vec2 first = corner, right = vec2(1.0, 0.0), above = vec2(0.0, 1.0);
    if (flipped) {
        first.x = 1.0 - first.x;
        right.x = 0.0;
        above.x = 1.0;
    }
    Cells cells;
    cells.a = radtex_folded(low + first, n - 1.0);
    cells.b = radtex_folded(low + right, n - 1.0);
    cells.c = radtex_folded(low + above, n - 1.0);
    cells.d = cells.a;
    cells.weight = vec4(1.0 - g.x - g.y, g, 0.0);
    return cells;
}

#ifdef RADTEX_MIRRORS
// How much the object leaves free, as a lobe of that width² sees it.
float radtex_free(float kept, float width) {
    float side = 2.0 * kept - 1.0, sharper = side * max(2.56 / OWN_CELLS * inversesqrt(width + 0.0016), 1.0);
    return 0.5 + 0.5 * sharper * inversesqrt(1.0 - side * side + sharper * sharper);
}
#endif

#if RADTEX_LAMPS > 0
vec3 radtex_lamp(vec4 place, vec3 light, vec3 from, vec3 axis, float width) {
    vec3 towards = place.xyz - from;
    float squared = dot(towards, towards), nearer = dot(place.xyz, place.xyz) / squared;
    float wide = width + place.w * nearer;
    float off = wide + 1.0 - dot(axis, towards) * inversesqrt(squared);
    return light * (nearer * (1.0 + 0.5 * wide) * wide / (6.2831853 * off * off));
}
#endif

vec3 radtex_lamps(vec3 from, vec3 axis, float width) {
    vec3 light = vec3(0.0);
#if RADTEX_LAMPS > 0
    light += radtex_lamp(lamp_place[0], lamp_light[0], from, axis, width);
#endif
#if RADTEX_LAMPS > 1
    light += radtex_lamp(lamp_place[1], lamp_light[1], from, axis, width);
#endif
#if RADTEX_LAMPS > 2
    light += radtex_lamp(lamp_place[2], lamp_light[2], from, axis, width);
#endif
#if RADTEX_LAMPS > 3
    light += radtex_lamp(lamp_place[3], lamp_light[3], from, axis, width);
#endif
    return light;
}

// Where a ray from an offset along the unit axis cuts a sphere about the middle: how far along.
float radtex_sphere(float along, float squared, float radius) {
    return sqrt(max(along * along - squared + radius * radius, 0.0)) - along;
}

#ifdef RADTEX_PLANE
// Where a lobe meets the plane: the place, from the middle, and how far off; its direction from the plane's eye; by how
// much the lobe is wider there (of its width² the logarithm to base 2); the share of it that is below the horizon.
struct Below {
    vec3 there, met;
    float far, wider, cover;
};

Below radtex_below(vec3 from, vec3 ray, float spread) {
    vec3 N = plane_place.xyz;
    float sine = dot(ray, N), squared = sine * sine + 2.0 * exp2(spread), root = inversesqrt(squared);
    float deep = clamp(squared * root, 1e-4, 0.999);  // of the mean direction of that share
    vec3 level = ray - sine * N;
    level *= inversesqrt(max(dot(level, level), 1e-12));
    Below below;
    below.far = max(dot(from, N) - plane_place.w, 0.0) / deep;
    below.there = from + below.far * (sqrt(1.0 - deep * deep) * level - deep * N);
    below.met = below.there - plane_eye;
    float whence = inversesqrt(max(dot(below.met, below.met), 1e-12));
    below.met *= whence;
    float along = below.far * whence, slant = (dot(plane_eye, N) - plane_place.w) * whence / deep;
    below.wider = log2(clamp(along * along * slant, 0.00390625, 16.0));
    below.cover = 0.5 - 0.5 * sine * root;
    return below;
}
#endif

// Radiance towards the viewer, in the unit direction V, from a fragment at `position` whose unit normal is N.
vec3 radtex_layered(vec2 uv, vec3 position, vec3 N, vec3 V) {
#ifdef RADTEX_NORMAL
    vec3 shading = normalize(texture(shading_normal, uv * normal_part).xyz * 2.0 - 1.0);
    N = dot(shading, N) > 0.3 ? shading : N;
#endif
#ifdef RADTEX_ALPHA
    float opacity = radtex_alpha(uv);
#endif
    float cosine = dot(N, V);
    vec3 axis = 2.0 * cosine * N - V;
    float step = clamp(cosine * 16.0 - 0.5, 0.0, 15.0);
    int low = min(int(step), 14);
    float above = step - float(low);
    vec4 facts = mix(material[low], material[low + 1], above);
    vec3 light = vec3(0.0);
#ifdef RADTEX_COLOUR
    light = texture(colour, uv * colour_part).rgb * texture(irradiance, uv * irradiance_part).rgb;
    light *= facts.rgb * colour_scale;
#endif
#ifdef RADTEX_LIT
    light = texture(lit, uv * lit_part).rgb * facts.rgb;
#endif
    vec2 place = radtex_square(axis);
#ifdef RADTEX_MIRRORS
    vec3 from = position - middle;
    vec3 towards = N - dot(N, axis) * axis;
    towards *= inversesqrt(max(dot(towards, towards), 1e-12));
    vec3 ray = axis * sqrt(1.0 - facts.a * facts.a) + towards * facts.a;
    vec4 lobe = mix(lobes[low], lobes[low + 1], above);
    float wider = 0.0;
#ifdef RADTEX_WIDTH
    wider = texture(width, uv * width_part).r * width_range.x + width_range.y;
#endif
    lobe.a += wider;
    vec3 at = radtex_picture(world_levels, ray, lobe.a);
    vec3 direct = textureLod(world, at.xy, at.z).rgb;
#ifdef RADTEX_ALL
    vec4 wide = mix(lobes[low + 16], lobes[low + 17], above);
    wide.a += wider;
    at = radtex_picture(world_levels, ray, wide.a);
    vec3 broad = textureLod(world, at.xy, at.z).rgb;
#endif
    vec3 seen = ray;  // where the second lobe looks: at what the first one saw
    float reached = 0.0;
#ifdef RADTEX_PLANE
    Below below = radtex_below(from, ray, lobe.a);
    at = radtex_picture(plane_levels, below.met, lobe.a + below.wider);
    vec4 before = textureLod(plane, at.xy, at.z) * below.cover;
    float close = inversesqrt(max(dot(below.there, below.there), 1e-12));
    seen = mix(seen, below.there * close, before.a);
    reached = 2.0 * log2(clamp(below.far * close, 0.0625, 4.0)) * before.a;
    direct = direct * (1.0 - before.a) + before.rgb * plane_scale;
#ifdef RADTEX_ALL
    below = radtex_below(from, ray, wide.a);
    at = radtex_picture(plane_levels, below.met, wide.a + below.wider);
    before = textureLod(plane, at.xy, at.z) * below.cover;
    broad = broad * (1.0 - before.a) + before.rgb * plane_scale;
#endif
#endif
#ifdef RADTEX_THINGS
    float along = dot(from, ray), squared = dot(from, from), reach;
    vec3 hit = ray;
#if RADTEX_STEPS < 2  // begin on a sphere
    reach = radtex_sphere(along, squared, 1.0 / nearness.z);
    hit = from + reach * ray;
#endif
#if RADTEX_STEPS > 0
    vec2 spot = radtex_on_edges(radtex_square(hit), distances_size);
    reach = radtex_sphere(along, squared, 1.0 / (textureLod(distances, spot, 0.0).r * nearness.x + nearness.y));
    hit = from + reach * ray;
#endif
#if RADTEX_STEPS > 1
    spot = radtex_on_edges(radtex_square(hit), distances_size);
    reach = radtex_sphere(along, squared, 1.0 / (textureLod(distances, spot, 0.0).r * nearness.x + nearness.y));
    hit = from + reach * ray;
#endif
    float nearer = 2.0 * log2(clamp(reach * inversesqrt(max(dot(hit, hit), 1e-12)), 0.0625, 4.0));
    at = radtex_picture(things_levels, hit, lobe.a + nearer);
    vec4 front = textureLod(things, at.xy, at.z);
    seen = mix(seen, normalize(hit), front.a);
    reached = mix(reached, nearer, front.a);
    direct = direct * (1.0 - front.a) + front.rgb * things_scale;
#ifdef RADTEX_ALL
    at = radtex_picture(things_levels, hit, wide.a + nearer);
    front = textureLod(things, at.xy, at.z);
    broad = broad * (1.0 - front.a) + front.rgb * things_scale;
#endif
#endif
#ifdef RADTEX_WHOLE
    vec4 wide = mix(lobes[low + 16], lobes[low + 17], above);
    wide.a += wider;
    at = radtex_picture(whole_levels, seen, wide.a + reached);
    vec3 broad = textureLod(whole, at.xy, at.z).rgb;
#endif
#if RADTEX_OWN_TAPS == 4
    Cells cells = radtex_four_cells(place, OWN_CELLS);
#else
    Cells cells = radtex_three_cells(place, OWN_CELLS);
#endif
    vec2 inside = clamp(uv * own_tile.xy, own_tile.zw, own_tile.xy - own_tile.zw);
    vec4 self = textureLod(own, (cells.a + inside) / OWN_CELLS, 0.0) * cells.weight.x
        + textureLod(own, (cells.b + inside) / OWN_CELLS, 0.0) * cells.weight.y
        + textureLod(own, (cells.c + inside) / OWN_CELLS, 0.0) * cells.weight.z;
#if RADTEX_OWN_TAPS == 4
    self += textureLod(own, (cells.d + inside) / OWN_CELLS, 0.0) * cells.weight.w;
#endif
    self.rgb *= own_scale;
    float spread = exp2(lobe.a);
    vec3 mirrored = lobe.rgb * mix(self.rgb, direct + radtex_lamps(from, ray, spread), radtex_free(self.a, spread));
#if defined(RADTEX_ALL) || defined(RADTEX_WHOLE)
    spread = exp2(wide.a);
    mirrored += wide.rgb * mix(self.rgb, broad + radtex_lamps(from, ray, spread), radtex_free(self.a, spread));
#endif
#ifdef RADTEX_TINT
    mirrored *= texture(tint, uv * tint_part).rgb * tint_scale;
#else
#ifdef RADTEX_ALPHA
    mirrored *= opacity;
#endif
#endif
    light += mirrored;
#endif
#ifdef RADTEX_REST
#if RADTEX_REST_TAPS == 4
    Cells fewer = radtex_four_cells(place, REST_CELLS);
#else
    Cells fewer = radtex_three_cells(place, REST_CELLS);
#endif
    vec2 within = clamp(uv * rest_tile.xy, rest_tile.zw, rest_tile.xy - rest_tile.zw);
    vec3 more = textureLod(rest, (fewer.a + within) / REST_CELLS, 0.0).rgb * fewer.weight.x
        + textureLod(rest, (fewer.b + within) / REST_CELLS, 0.0).rgb * fewer.weight.y
        + textureLod(rest, (fewer.c + within) / REST_CELLS, 0.0).rgb * fewer.weight.z;
#if RADTEX_REST_TAPS == 4
    more += textureLod(rest, (fewer.d + within) / REST_CELLS, 0.0).rgb * fewer.weight.w;
#endif
    more = more * rest_range.x + rest_range.y;
#ifdef RADTEX_ALPHA
    more *= opacity;
#endif
    light += max(more, -0.5 * light);
#endif
    return max(light, 0.0);
}
