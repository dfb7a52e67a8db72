// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_layered.c.
//
// Look up a radiance texture in the layered layout: WGSL. Put it before your shader's text, then
//
//     let V = normalize(camera - position); let N = normalize(normal);  // in Blender's world space of the bake, z up
//     let light = radtex_layered(uv, position, N, V);               // premultiplied by radtex_alpha(uv)
//
// or, of an object that light comes through, what radtex_layered_through.wgsl adds.
//
// What the bake has and what a lookup costs is overridden when a pipeline is made, which leaves out what is not needed.
// Textures, one for each layer, have mip levels if they are the world's, the plane's or the things'; others' are not
// read. In place of one that the bake lacks, any of 1 x 1 is bound. The sampler clamps to the edge and filters linearly, between levels, too.
// v = 0 is the first row. A range is the share of a texture's width and height that is no padding, and scale and
// offset: a value is texel * scale + offset, but for the alpha of own, plane and things. `radtex` is the same for all
// materials, radtex_of is of one: draw one material at a time. For another group of bindings, replace "@group(1)".

override RADTEX_MIRRORS: bool = false;  // any of the materials has lobes
override RADTEX_TINT: bool = false;     // the bake has this layer; and so on
override RADTEX_NORMAL: bool = false;
override RADTEX_WIDTH: bool = false;
override RADTEX_GLOSSES: bool = false;  // how much a material mirrors follows from its tint and its width
override RADTEX_ALPHA: bool = false;
override RADTEX_TANGENT: bool = false;  // some materials are brushed, and draw lamps out along the tangents
override RADTEX_BEHIND: bool = false;   // a plane or things hide some lamps, such as lights of the world
override RADTEX_PLANE: bool = false;
override RADTEX_THINGS: bool = false;   // and their distances
override RADTEX_SHELL: i32 = 0;         // how many planes of a room the plane layer shows, or 0
override RADTEX_BOXES: i32 = 0;         // how many boxes things lie in there, or 0
override RADTEX_LAMPS: i32 = 0;         // how many, 0 to 8
override RADTEX_SHAPES: bool = false;   // some are rectangles, discs or balls where lobes are sharp, not blurs alone
override RADTEX_OWN_CELLS: i32 = 14;    // cells along the sides of buckets
override RADTEX_REST_CELLS: i32 = 8;
override RADTEX_STEPS: i32 = 1;         // fetches of distances, 0 to 2
override RADTEX_OWN_TAPS: i32 = 3;      // cells of a bucket that are blended, 3 or 4; 0: it mirrors nothing of itself
override RADTEX_REST_TAPS: i32 = 3;
override RADTEX_SECOND_LOBE: i32 = 1;   // 1: it is looked up, 0: materials have one lobe in place of two
override RADTEX_TEMPORAL: bool = false; // one cell of a bucket is read, drawn by chance as often as its weight says, and
                                        // one level of a picture: noise that temporal antialiasing averages away
var<private> radtex_frame_number: u32 = 0u;  // by which chance draws anew in each frame

struct RadtexBake {
    middle: vec4f,        // xyz: from where the surroundings are seen
    colour_range: vec4f,  // part of width and height, scale, offset
    irradiance_range: vec4f,
    tint_range: vec4f,
    normal_range: vec4f,
    width_range: vec4f,
    alpha_range: vec4f,
    tangent_range: vec4f,
    own_range: vec4f,     // the size of a tile in place of the part
    rest_range: vec4f,
    own_tile: vec4f,      // size of a tile without its padding, and half a texel, in units of a tile
    rest_tile: vec4f,
    world_range: vec4f,
    plane_range: vec4f,
    things_range: vec4f,
    distances_range: vec4f,
    world_levels: vec4f,  // texels along a side, last level, log2 of level 0's width²
    plane_levels: vec4f,
    things_levels: vec4f,
    distances_size: vec4f,  // texels along a side, and the mean distance
    plane_place: vec4f,   // its normal and height, from the middle
    plane_eye: vec4f,     // where its picture was taken from, and how high above the plane that is
    things_eye: vec4f,    // xyz: where the picture of things was taken from, from the middle
    shell: array<vec4f, 8>,  // the normals and heights of a room's planes
    box_low: array<vec4f, 8>,  // xyz: the lowest corners of boxes that things lie in, from the middle
    box_high: array<vec4f, 8>,  // xyz: the highest corners
    lamp_place: array<vec4f, 8>,  // from the middle, and width²
    lamp_light: array<vec4f, 8>,  // rgb: irradiance at the middle; a: 1 if layers hide it
    lamp_across: array<vec4f, 8>,  // half a side, or a ball's radius; a: 1 / steradians from the middle, or 0
    lamp_up: array<vec4f, 8>,      // half of the other side, or a ball's 0; a: 1 if it is a disc
}

struct RadtexMaterial {
    curves: array<vec4f, 16>,  // by N.V: the falloff, and the sine by which lobes bend towards the normal
    lobes: array<vec4f, 32>,   // by N.V: weight, and log2 of the width²; the first lobe's, then the second one's
    gloss: array<vec4f, 1>,    // its mean glossy colour and log2 of its mean width²: see radtex_reflected; 0 if tints say all
    brush: array<vec4f, 1>,    // xy: of brushed metal the width² along the tangent and across it; or 0
}

@group(1) @binding(0) var<uniform> radtex: RadtexBake;
@group(1) @binding(1) var<uniform> radtex_of: RadtexMaterial;
@group(1) @binding(2) var radtex_filtering: sampler;
@group(1) @binding(3) var radtex_colour_map: texture_2d<f32>;
@group(1) @binding(4) var radtex_irradiance_map: texture_2d<f32>;
@group(1) @binding(5) var radtex_tint_map: texture_2d<f32>;
@group(1) @binding(6) var radtex_normal_map: texture_2d<f32>;
@group(1) @binding(7) var radtex_width_map: texture_2d<f32>;
@group(1) @binding(8) var radtex_alpha_map: texture_2d<f32>;
@group(1) @binding(9) var radtex_own_map: texture_2d<f32>;
@group(1) @binding(10) var radtex_rest_map: texture_2d<f32>;
@group(1) @binding(11) var radtex_world_map: texture_2d<f32>;
@group(1) @binding(12) var radtex_plane_map: texture_2d<f32>;
@group(1) @binding(13) var radtex_things_map: texture_2d<f32>;
@group(1) @binding(14) var radtex_distances_map: texture_2d<f32>;
@group(1) @binding(21) var radtex_tangent_map: texture_2d<f32>;

// A plain map's value.
fn radtex_map(image: texture_2d<f32>, range: vec4f, uv: vec2f) -> vec4f {
    return textureSampleLevel(image, radtex_filtering, uv * range.xy, 0.0) * range.z + range.w;
}

// The same of a map of colours.
fn radtex_colours(image: texture_2d<f32>, range: vec4f, uv: vec2f) -> vec3f {
    return radtex_map(image, range, uv).rgb;
}

// How much a fragment hides of what lies behind it.
fn radtex_alpha(uv: vec2f) -> f32 {
    if RADTEX_ALPHA {
        return radtex_map(radtex_alpha_map, radtex.alpha_range, uv).r;
    } else {
        return 1.0;
    }
}

// Where a direction, of any length, lies on the octahedron's square: 0 to 1.
fn radtex_square(direction: vec3f) -> vec2f {
    let d = direction * (1.0 / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30));
    let folded = (1.0 - abs(d.yx)) * vec2f(select(1.0, -1.0, d.x < 0.0), select(1.0, -1.0, d.y < 0.0));
    return select(d.xy, folded, d.z < 0.0) * 0.5 + 0.5;
}

// Cells around a place in a bucket, and their weights.
struct RadtexCells {
    a: vec2f,
    b: vec2f,
    c: vec2f,
    d: vec2f,
    weight: vec4f,
}

// A cell beyond an edge is the one that lies there on the sphere: the same edge's, mirrored at its middle.
fn radtex_folded(cell: vec2f, last: f32) -> vec2f {
    let inside = clamp(cell, vec2f(0.0, 0.0), vec2f(last, last));
    return vec2f(select(inside.x, last - inside.x, cell.y != inside.y),
        select(inside.y, last - inside.y, cell.x != inside.x));
}

// The four of n x n cells around a place on the octahedron's square.
fn radtex_four_cells(place: vec2f, n: f32) -> RadtexCells {
    let position = place * n - 0.5;
    let low = floor(position);
    let f = position - low;
    var cells: RadtexCells;
    cells.a = radtex_folded(low, n - 1.0);
    cells.b = radtex_folded(low + vec2f(1.0, 0.0), n - 1.0);
    cells.c = radtex_folded(low + vec2f(0.0, 1.0), n - 1.0);
    cells.d = radtex_folded(low + 1.0, n - 1.0);
    cells.weight = vec4f((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    return cells;
}

// Three of them: the square between four centres is two triangles, whose diagonals run as the octahedron's edges do.
fn radtex_three_cells(place: vec2f, n: f32) -> RadtexCells {
    let position = place * n - 0.5;
    let low = floor(position);
    var f = position - low;
    let flipped = (place.x - 0.5) * (place.y - 0.5) < 0.0;
    f.x = select(f.x, 1.0 - f.x, flipped);
    let upper = f.x + f.y > 1.0;
    let corner = select(vec2f(0.0, 0.0), vec2f(1.0, 1.0), upper);
    let g = select(f, 1.0 - f.yx, upper);
    var cells: RadtexCells;
    cells.a = radtex_folded(low + vec2f(select(corner.x, 1.0 - corner.x, flipped), corner.y), n - 1.0);
    cells.b = radtex_folded(low + vec2f(select(1.0, 0.0, flipped), 0.0), n - 1.0);
    cells.c = radtex_folded(low + vec2f(select(0.0, 1.0, flipped), 1.0), n - 1.0);
    cells.d = cells.a;
    cells.weight = vec4f(1.0 - g.x - g.y, g, 0.0);
    return cells;
}

// A place in a tile: `tile` as radtex_rest_tile.
fn radtex_inside(tile: vec4f, uv: vec2f) -> vec2f {
    return clamp(uv * tile.xy, tile.zw, tile.xy - tile.zw);
}

// A number from 0 to 1 by chance, for two others (O'Neill, "PCG", 2014, by its output's permutation).
fn radtex_chance(at: vec2f) -> f32 {
    var mixed = bitcast<u32>(at.x) * 747796405u + bitcast<u32>(at.y) * 2891336453u + radtex_frame_number * 1664525u;
    mixed = mixed * 747796405u + 2891336453u;
    mixed = ((mixed >> ((mixed >> 28u) + 4u)) ^ mixed) * 277803737u;
    return f32(((mixed >> 22u) ^ mixed) >> 8u) / 16777216.0;
}

// One of three cells, drawn by chance as often as its weight says.
fn radtex_drawn(cells: RadtexCells, inside: vec2f) -> vec2f {
    let chance = radtex_chance(cells.a + inside);
    let cell = select(cells.c, cells.b, chance < cells.weight.x + cells.weight.y);
    return select(cell, cells.a, chance < cells.weight.x);
}

fn radtex_three_taps(image: texture_2d<f32>, cells: RadtexCells, inside: vec2f, size: vec2f) -> vec4f {
    return textureSampleLevel(image, radtex_filtering, (cells.a + inside) * size, 0.0) * cells.weight.x
        + textureSampleLevel(image, radtex_filtering, (cells.b + inside) * size, 0.0) * cells.weight.y
        + textureSampleLevel(image, radtex_filtering, (cells.c + inside) * size, 0.0) * cells.weight.z;
}

fn radtex_four_taps(image: texture_2d<f32>, cells: RadtexCells, inside: vec2f, size: vec2f) -> vec4f {
    return radtex_three_taps(image, cells, inside, size)
        + textureSampleLevel(image, radtex_filtering, (cells.d + inside) * size, 0.0) * cells.weight.w;
}

// What lobes and other paths, in coarse cells, do not tell, in the direction that lies at a place on the square.
fn radtex_rest(image: texture_2d<f32>, range: vec4f, tile: vec4f, n: f32, uv: vec2f, place: vec2f) -> vec3f {
    var found: vec4f;
    let inside = radtex_inside(tile, uv);
    if RADTEX_TEMPORAL {
        found = textureSampleLevel(image, radtex_filtering,
            (radtex_drawn(radtex_three_cells(place, n), inside) + inside) * range.xy, 0.0);
    } else {
        if RADTEX_REST_TAPS == 4 {
            found = radtex_four_taps(image, radtex_four_cells(place, n), inside, range.xy);
        } else {
            found = radtex_three_taps(image, radtex_three_cells(place, n), inside, range.xy);
        }
    }
    return found.rgb * range.z + range.w;
}

// The same as radtex_square on a picture of so many texels a side, whose outermost texels' centres lie on its edge.
fn radtex_on_edges(place: vec2f, size: f32) -> vec2f {
    return place + (0.5 - place) / size;
}

// The texel of a picture around the direction d, blurred by a width² whose log2 is `spread`. Between levels it is mixed
// by the width, not by its logarithm: so a lobe's tails are nearly right.
fn radtex_blurred(image: texture_2d<f32>, levels: vec4f, d: vec3f, spread: f32) -> vec4f {
    let level = clamp(0.5 * (spread - levels.z), 0.0, levels.y);
    var between = exp2(fract(level)) - 1.0;
    let place = radtex_on_edges(radtex_square(d), levels.x * exp2(-level));
    if RADTEX_TEMPORAL {
        between = select(0.0, 1.0, radtex_chance(d.xy) < between);
    }
    return textureSampleLevel(image, radtex_filtering, place, floor(level) + between);
}

// A picture of what is near, premultiplied by its alpha.
fn radtex_picture(image: texture_2d<f32>, range: vec4f, levels: vec4f, d: vec3f, spread: f32) -> vec4f {
    let found = radtex_blurred(image, levels, d, spread);
    return vec4f(found.rgb * range.z + range.w, found.a);
}

// What a lobe shows of the plane, and by how much that hides what lies behind: the mean direction of the share of the
// lobe that is below the horizon meets the plane, where its picture's eye sees the lobe wider or narrower.
fn radtex_below(whence: vec3f, ray: vec3f, spread: f32) -> vec4f {
    let N = radtex.plane_place.xyz;
    let sine = dot(ray, N);
    let squared = sine * sine + 2.0 * exp2(spread);
    let root = inverseSqrt(squared);
    let deep = clamp(squared * root, 1e-4, 0.999);
    let share = 0.5 - 0.5 * sine * root;
    if share < 0.002 { return vec4f(0.0, 0.0, 0.0, 0.0); }
    var level = ray - sine * N;
    level *= inverseSqrt(max(dot(level, level), 1e-12));
    let far = max(dot(whence, N) - radtex.plane_place.w, 0.0) / deep;
    let met = whence + far * (sqrt(1.0 - deep * deep) * level - deep * N) - radtex.plane_eye.xyz;
    let nearness = inverseSqrt(max(dot(met, met), 1e-12));
    let along = far * nearness;
    let wider = clamp(along * along * radtex.plane_eye.w * nearness / deep, 0.00390625, 16.0);
    let found = radtex_picture(radtex_plane_map, radtex.plane_range, radtex.plane_levels, met, spread + log2(wider));
    return found * share;
}

// Which of a room's planes a ray meets from inside, the nearest that it points at: its normal, and how far that is.
fn radtex_wall(whence: vec3f, ray: vec3f) -> vec4f {
    var found = vec4f(ray, 1e6);
    for (var k = 0; k < RADTEX_SHELL; k++) {
        let plane = radtex.shell[k];
        let sine = -dot(ray, plane.xyz);
        let reach = max(dot(whence, plane.xyz) - plane.w, 0.0) / max(sine, 1e-4);
        if sine > 1e-4 && reach < found.w { found = vec4f(plane.xyz, reach); }
    }
    return found;
}

// What a lobe shows of a room's planes.
fn radtex_walls(whence: vec3f, ray: vec3f, spread: f32) -> vec4f {
    let wall = radtex_wall(whence, ray);
    let met = whence + wall.w * ray - radtex.plane_eye.xyz;
    let nearness = inverseSqrt(max(dot(met, met), 1e-12));
    let along = wall.w * nearness;
    var wider = along * along * nearness * abs(dot(wall.xyz, met)) / max(abs(dot(wall.xyz, ray)), 1e-4);
    wider = clamp(wider, 0.00390625, 16.0);
    return radtex_picture(radtex_plane_map, radtex.plane_range, radtex.plane_levels, met, spread + log2(wider));
}

// How far along the unit ray is a sphere of that radius about the middle; `along` is from . ray, `squared` from . from.
fn radtex_reach(along: f32, squared: f32, radius: f32) -> f32 {
    return sqrt(max(along * along - squared + radius * radius, 0.0)) - along;
}

// The distance from the middle of what lies in a direction.
fn radtex_distance(d: vec3f) -> f32 {
    let place = radtex_on_edges(radtex_square(d), radtex.distances_size.x);
    let range = radtex.distances_range;
    return 1.0
        / max(textureSampleLevel(radtex_distances_map, radtex_filtering, place, 0.0).r * range.z + range.w, 1e-9);
}

// The nearest box that a ray comes to: how far away the ray begins to look for things, and enters and leaves the box;
// and how far away a wall is, where it does all that if it comes to none. From within, it begins where it leaves.
fn radtex_span(whence: vec3f, ray: vec3f) -> vec4f {
    let wall = radtex_wall(whence, ray).w;
    var span = vec4f(wall, wall, wall, wall);
    let slow = vec3f(select(ray.x, 1e-7, abs(ray.x) < 1e-7), select(ray.y, 1e-7, abs(ray.y) < 1e-7),
        select(ray.z, 1e-7, abs(ray.z) < 1e-7));
    for (var k = 0; k < RADTEX_BOXES; k++) {
        let one = (radtex.box_low[k].xyz - whence) / slow;
        let other = (radtex.box_high[k].xyz - whence) / slow;
        let near = min(one, other);
        let far = max(one, other);
        let first = max(near.x, max(near.y, near.z));
        let last = min(far.x, min(far.y, far.z));
        let start = select(last, first, first > 0.0);
        if first <= last && last > 0.0 && start < span.x { span = vec4f(start, max(first, 0.0), last, wall); }
    }
    return span;
}

// How far along the unit ray things are that are seen at a distance: in the box, or else at the wall.
fn radtex_reached(along: f32, squared: f32, distance: f32, span: vec4f) -> f32 {
    let reach = radtex_reach(along, squared, distance);
    return select(clamp(reach, span.y, span.z), span.w, reach > span.z + 0.12 * distance);
}

// The same for a ray that passes behind the side of a thing that its eye sees: one that meets nothing between where it
// enters and leaves its box meets it in the middle of its way through it if that lies behind such a side, by no more than
// that way.
fn radtex_behind(offset: vec3f, ray: vec3f, reach: f32, span: vec4f) -> f32 {
    if span.y >= span.z || (reach > span.y && reach < span.z) { return reach; }
    let middle = 0.5 * (span.y + span.z);
    let reached = offset + middle * ray;
    let length_ = length(reached);
    let distance = radtex_distance(reached);
    return select(reach, middle, length_ >= 0.98 * distance && length_ - distance <= span.z - span.y);
}

// Where a ray meets things, from their eye, and log2 of how much a lobe's width² is larger as seen from there. In a room
// the length is 1, or of a ray that passes between things, 1 and how far aside of it lies what is seen there, as the squared
// sine of the angle.
fn radtex_met(whence: vec3f, ray: vec3f) -> vec4f {
    if RADTEX_THINGS {
        let offset = whence - radtex.things_eye.xyz;
        var met = ray;
        let along = dot(offset, ray);
        let squared = dot(offset, offset);
        var reach: f32;
        if RADTEX_BOXES > 0 {
            let span = radtex_span(whence, ray);
            reach = span.x;
            met = offset + reach * ray;
            if RADTEX_STEPS > 0 {
                var distance = radtex_distance(met);
                reach = radtex_reached(along, squared, distance, span);
                if RADTEX_STEPS > 1 {
                    met = offset + reach * ray;
                    distance = radtex_distance(met);
                    reach = radtex_reached(along, squared, distance, span);
                }
                reach = radtex_behind(offset, ray, reach, span);
                met = offset + reach * ray;
                let scale = inverseSqrt(max(dot(met, met), 1e-12));
                met *= scale;
                if reach >= span.w {
                    let away = distance * met - offset;
                    let ahead = max(dot(away, ray), 0.0);
                    met *= 2.0 - ahead * ahead / max(dot(away, away), 1e-12);
                }
                return vec4f(met, 2.0 * log2(clamp(reach * scale, 0.0625, 4.0)));
            }
        } else {
            if RADTEX_STEPS < 2 {  // begin on a sphere
                reach = radtex_reach(along, squared, radtex.distances_size.y);
                met = offset + reach * ray;
            }
            if RADTEX_STEPS > 0 {
                reach = radtex_reach(along, squared, radtex_distance(met));
                met = offset + reach * ray;
            }
            if RADTEX_STEPS > 1 {
                reach = radtex_reach(along, squared, radtex_distance(met));
                met = offset + reach * ray;
            }
        }
        return vec4f(met, 2.0 * log2(clamp(reach * inverseSqrt(max(dot(met, met), 1e-12)), 0.0625, 4.0)));
    } else {
        return vec4f(ray, 0.0);
    }
}

// What a lobe as wide as `spread` says shows of the things that its ray meets; of what lies far aside of it nothing.
fn radtex_things(met: vec4f, spread: f32) -> vec4f {
    var found = radtex_picture(radtex_things_map, radtex.things_range, radtex.things_levels, met.xyz, spread + met.w);
    if RADTEX_BOXES > 0 {
        if RADTEX_STEPS > 0 {
            found *= clamp(2.0 - 0.25 * (length(met.xyz) - 1.0) / max(exp2(spread), 1e-6), 0.0, 1.0);
        }
    }
    return found;
}

// Places of brushed metal: unit vectors to the viewer, of the normal, and of the tangent across that; and the lobe's
// width² along the tangent and across it, which are alike where the tangent is not known, and is 0. Of what is not
// brushed `along` is 0.
struct RadtexBrush {
    viewer: vec3f,
    normal: vec3f,
    tangent: vec3f,
    along: f32,
    across: f32,
}

fn radtex_luminance(colour: vec3f) -> f32 {
    return dot(colour, vec3f(0.2126, 0.7152, 0.0722));
}

// How much of what lies behind all layers is seen between them, about the unit ray and as wide as `spread` says.
fn radtex_free_way(whence: vec3f, ray: vec3f, spread: f32) -> f32 {
    var free = 1.0;
    if RADTEX_PLANE {
        if RADTEX_SHELL > 0 {
            free = 1.0 - radtex_walls(whence, ray, spread).a;
        } else {
            free = 1.0 - radtex_below(whence, ray, spread).a;
        }
    }
    if RADTEX_THINGS {
        free *= 1.0 - radtex_things(radtex_met(whence, ray), spread).a;
    }
    return free;
}

// The normal of a surface, and the luminance of its irradiance, which is pi times `even`: more than any sun's where the
// diffuse colour is too dark to tell it.
fn radtex_lit_by(face: vec3f, even: vec3f, colour: vec3f) -> vec4f {
    let unknown = max(1.0 - 50.0 * max(colour.r, max(colour.g, colour.b)), 0.0);
    return vec4f(face, 3.14159265 * radtex_luminance(even) + 1e6 * unknown);
}

// Of a polygon's edge between unit vectors, the angle times how much the edge's normal lies along the axis.
fn radtex_edge(one: vec3f, other: vec3f, axis: vec3f) -> f32 {
    let cosine = dot(one, other);
    let x = abs(cosine);
    let high = 0.030891881 + x * (-0.0170881256 + x * (0.0066700901 + x * -0.0012624911));
    var angle = 1.570796305 + x * (-0.2145988016 + x * (0.0889789874 + x * (-0.0501743046 + x * high)));
    angle *= inverseSqrt(1.0 + x);  // over its sine (Abramowitz and Stegun, 4.4.46)
    let wide = 3.14159265 * inverseSqrt(max(1.0 - x * x, 1e-12)) - angle;
    return dot(cross(one, other), axis) * select(angle, wide, cosine < 0.0);
}

// A unit vector there, once what lies across the axis is stretched as much as a lobe is narrow.
fn radtex_stretched(way: vec3f, axis: vec3f, blunt: f32) -> vec3f {
    let found = way + blunt * dot(way, axis) * axis;
    return found * inverseSqrt(max(dot(found, found), 1e-24));
}

// How much of a lobe of that width² lies on a lamp, which is `towards` from where it begins; a lamp's shape is as
// radtex_lamp_across and radtex_lamp_up tell. A lobe is a cosine's foreshortening on a plane: so that is Lambert's formula
// for polygons, and for a ball the view factor of a disc.
fn radtex_covered(towards: vec3f, ray: vec3f, width: f32, across: vec4f, up: vec4f) -> f32 {
    if dot(up.xyz, up.xyz) == 0.0 {
        let along = dot(towards, ray);
        let radius = dot(across.xyz, across.xyz);
        let aside = towards / max(along, 1e-12) - ray;
        let sharp = 0.5 / max(width, 1e-6);
        let size = min(radius / max(dot(towards, towards) - radius, 1e-12), 1000.0) * sharp;
        let away = min(dot(aside, aside), 1e6) * sharp;
        let apart = away - size;
        if along <= 0.0 { return 0.0; }
        return 0.5 - 0.5 * (1.0 + apart) * inverseSqrt(1.0 + 2.0 * (away + size) + apart * apart);
    }
    let isDisc = up.w > 0.5;
    let count = select(4, 12, isDisc);
    let far = select(1.41421356, 1.0233267, isDisc);  // as large as the disc, and as far as a rectangle's corners
    let turn = select(1.57079633, 0.52359878, isDisc);
    let c = cos(turn);
    let s = sin(turn);
    let blunt = sqrt(2.0 * width) - 1.0;
    var at = vec2f(far * cos(0.5 * turn), far * sin(0.5 * turn));
    var last = radtex_stretched(towards + at.x * across.xyz + at.y * up.xyz, ray, blunt);
    var found = 0.0;
    for (var k = 0; k < count; k++) {
        at = vec2f(at.x * c - at.y * s, at.x * s + at.y * c);
        let next = radtex_stretched(towards + at.x * across.xyz + at.y * up.xyz, ray, blunt);
        found += radtex_edge(last, next, ray);
        last = next;
    }
    return clamp(found / 6.2831853, 0.0, 1.0);
}

// How much of a lamp that layers are before is seen between them; `ray` is the unit vector to it, `nearer` by how much
// more it lights than the middle. A surface whose unit normal is lit.xyz sees no more than the luminance of its
// irradiance, lit.w, allows.
fn radtex_lamp_free(place: vec4f, light: vec4f, whence: vec3f, ray: vec3f, nearer: f32, lit: vec4f) -> f32 {
    var free = lit.w / max(nearer * radtex_luminance(light.rgb) * max(dot(lit.xyz, ray), 0.1), 1e-9);
    free = clamp((free - 0.1) / 0.9, 0.0, 1.0);
    if free > 0.0 { free *= radtex_free_way(whence, ray, log2(place.w * nearer)); }
    return free;
}

// What brushed metal shows of a small lamp in the unit direction `way`, blurred by a width² `size`: GGX with two
// roughnesses, D G1 / (4 N.V) (Heitz, "Sampling the GGX Distribution of Visible Normals", 2018).
fn radtex_brushed(brush: RadtexBrush, way: vec3f, size: f32) -> f32 {
    var between = brush.viewer + way;
    between *= inverseSqrt(max(dot(between, between), 1e-12));
    let upright = max(dot(between, brush.normal), 1e-3);
    let aside = dot(between, brush.tangent) / upright;
    let flatness = max(1.0 / (upright * upright) - 1.0 - aside * aside, 0.0);
    let along = 0.5 * (brush.along + size);
    let across = 0.5 * (brush.across + size);
    let tail = (1.0 + aside * aside / along + flatness / across) * upright * upright;
    let cosine = max(dot(brush.viewer, brush.normal), 1e-3);
    let slant = dot(brush.viewer, brush.tangent);
    let rough = brush.across * max(1.0 - cosine * cosine - slant * slant, 0.0) + brush.along * slant * slant;
    let seen = 2.0 / (cosine + sqrt(cosine * cosine + 0.5 * rough));  // G1 / N.V
    let shown = seen * inverseSqrt(along * across) / (12.56637061 * tail * tail);
    return select(0.0, shown, dot(way, brush.normal) > 0.0);
}

// What a lobe of that width², or of brushed metal, shows of the lamp with that number.
fn radtex_lamp(number: i32, whence: vec3f, ray: vec3f, width: f32, lit: vec4f, brush: RadtexBrush) -> vec3f {
    let place = radtex.lamp_place[number];
    let light = radtex.lamp_light[number];
    let towards = place.xyz - whence;
    let squared = dot(towards, towards);
    let nearer = dot(place.xyz, place.xyz) / squared;
    let size = place.w * nearer;
    let wide = width + size;
    let off = wide + 1.0 - dot(ray, towards) * inverseSqrt(squared);
    var free = 1.0;
    var shown = nearer * (1.0 + 0.5 * wide) * wide / (6.2831853 * off * off);
    if RADTEX_TANGENT {
        if brush.along > 0.0 { shown = nearer * radtex_brushed(brush, towards * inverseSqrt(squared), size); }
    }
    if RADTEX_SHAPES {
        let across = radtex.lamp_across[number];
        let up = radtex.lamp_up[number];
        if across.w > 0.0 {
            let back = cross(across.xyz, up.xyz);
            let square = dot(back, towards) * sqrt(nearer);
            let there = dot(back, place.xyz);  // how squarely it is seen
            if dot(up.xyz, up.xyz) > 0.0 { shown *= clamp(square / max(there, 1e-12), 0.0, 4.0); }
            var share = clamp(2.0 - width / min(8.0 * size, 0.04), 0.0, 1.0);
            if RADTEX_TANGENT {
                if brush.along > 0.0 { share = 0.0; }
            }
            if share > 0.0 { shown += share * (radtex_covered(towards, ray, width, across, up) * across.w - shown); }
        }
    }
    if RADTEX_SHELL > 0 {
        if light.w > 0.5 { free = radtex_lamp_free(place, light, whence, towards * inverseSqrt(squared), nearer, lit); }
    }
    if RADTEX_BEHIND {
        if light.w > 0.5 { free = radtex_lamp_free(place, light, whence, towards * inverseSqrt(squared), nearer, lit); }
    }
    return light.rgb * (free * shown);
}

fn radtex_lamps(whence: vec3f, ray: vec3f, width: f32, lit: vec4f, brush: RadtexBrush) -> vec3f {
    var light = vec3f(0.0, 0.0, 0.0);
    if RADTEX_LAMPS > 0 {
        for (var k = 0; k < RADTEX_LAMPS; k++) {
            light += radtex_lamp(k, whence, ray, width, lit, brush);
        }
    }
    return light;
}

// What a lobe about the unit ray, of a width² whose log2 is `spread`, shows of the surroundings from a place that is
// given from the middle; `met` is radtex_met of both, `lit` as for radtex_lamp_free, (0, 0, 0, 1e6) where no surface is.
fn radtex_shown_by(whence: vec3f, ray: vec3f, met: vec4f, spread: f32, lit: vec4f, brush: RadtexBrush) -> vec3f {
    var light = vec3f(0.0, 0.0, 0.0);
    var left = 1.0;  // of what lies behind
    var next: vec4f;
    if RADTEX_THINGS {
        next = radtex_things(met, spread);
        light = next.rgb;
        left = 1.0 - next.a;
    }
    if RADTEX_PLANE {
        if left > 0.001 {
            if RADTEX_SHELL > 0 {
                next = radtex_walls(whence, ray, spread);
            } else {
                next = radtex_below(whence, ray, spread);
            }
            light += left * next.rgb;
            left *= 1.0 - next.a;
        }
    }
    if left > 0.001 {
        next = radtex_blurred(radtex_world_map, radtex.world_levels, ray, spread);
        light += left * (next.rgb * radtex.world_range.z + radtex.world_range.w);
    }
    return light + radtex_lamps(whence, ray, exp2(spread), lit, brush);
}

// The same of what is not brushed.
fn radtex_shown(whence: vec3f, ray: vec3f, met: vec4f, spread: f32, lit: vec4f) -> vec3f {
    var brush: RadtexBrush;
    brush.viewer = ray;
    brush.normal = ray;
    brush.tangent = ray;
    brush.along = 0.0;
    brush.across = 0.0;
    return radtex_shown_by(whence, ray, met, spread, lit, brush);
}

// What the object shows of itself in the direction that lies at a place on the square, and how much it leaves free.
fn radtex_own(uv: vec2f, place: vec2f) -> vec4f {
    if RADTEX_OWN_TAPS == 0 {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    } else {
        let n = f32(RADTEX_OWN_CELLS);
        let inside = radtex_inside(radtex.own_tile, uv);
        let size = radtex.own_range.xy;
        var cells: RadtexCells;
        var own: vec4f;
        if RADTEX_TEMPORAL {
            cells = radtex_three_cells(place, n);
            own = textureSampleLevel(radtex_own_map, radtex_filtering, (radtex_drawn(cells, inside) + inside) * size,
                0.0);
        } else {
            if RADTEX_OWN_TAPS == 4 {
                cells = radtex_four_cells(place, n);
                own = radtex_four_taps(radtex_own_map, cells, inside, size);
            } else {
                cells = radtex_three_cells(place, n);
                own = radtex_three_taps(radtex_own_map, cells, inside, size);
            }
        }
        return vec4f(own.rgb * radtex.own_range.z + radtex.own_range.w, own.a);
    }
}

// How much the object leaves free of its surroundings, as a lobe of that width² sees it; `kept` is as cells see it.
fn radtex_free(kept: f32, width: f32) -> f32 {
    let side = clamp(2.0 * kept - 1.0, -1.0, 1.0);
    let sharper = side * max(5.0 / f32(RADTEX_OWN_CELLS) * inverseSqrt(width + 0.0016), 1.0);
    return 0.5 + 0.5 * sharper * inverseSqrt(1.0 - side * side + sharper * sharper);
}

// What of the light is reflected where facets' reflectance is F: F x + y, by roughness and N.V (Karis, "Physically Based
// Shading on Mobile", 2014).
fn radtex_environment(rough: f32, cosine: f32) -> vec2f {
    let smoothness = 1.0 - rough;
    let grazing = min(smoothness * smoothness, exp2(-9.28 * cosine)) * smoothness + (0.0425 - 0.0275 * rough);
    return vec2f(1.04 - 0.572 * rough - 1.04 * grazing, 0.022 * rough - 0.04 + 1.04 * grazing);
}

// What a surface reflects at N.V that reflects `colour` along its normal, with lobes of that width²; both colours are
// premultiplied by `opacity`.
fn radtex_reflected(colour: vec3f, width: f32, cosine: f32, opacity: f32) -> vec3f {
    let rough = sqrt(sqrt(clamp(width / max(2.0 - 5.0 * width, 1e-6), 0.0, 1.0)));
    let here = radtex_environment(rough, clamp(cosine, 0.0, 1.0));
    let facing = radtex_environment(rough, 1.0);
    let facets = max(colour - opacity * facing.y, vec3f(0.0, 0.0, 0.0)) / facing.x;
    let glossy = min(50.0 * max(colour.r, max(colour.g, colour.b)), opacity);  // what reflects less is no surface
    return facets * here.x + glossy * here.y;
}

// What a lobe (weight, and log2 of its width²) shows; `own` is what the object shows of itself.
fn radtex_mirrored(whence: vec3f, ray: vec3f, met: vec4f, own: vec4f, lobe: vec4f, lit: vec4f,
                   brush: RadtexBrush) -> vec3f {
    if RADTEX_OWN_TAPS == 0 {
        return lobe.rgb * radtex_shown_by(whence, ray, met, lobe.a, lit, brush);
    } else {
        let free = radtex_free(own.a, exp2(lobe.a));
        var light = own.rgb;
        if free > 0.001 { light += free * (radtex_shown_by(whence, ray, met, lobe.a, lit, brush) - light); }
        return lobe.rgb * light;
    }
}

// A material at a place: the colour of its diffuse light, what its lobes are multiplied by, its normal, and its alpha,
// by which both are multiplied.
struct RadtexLook {
    colour: vec3f,
    tint: vec3f,
    normal: vec3f,
    opacity: f32,
}

// That of a Principled BSDF whose maps are images, by what these hold at the place: base colour (linear), roughness and
// metal, and the normal map. Each of three vectors of the material's has a colour: of diffuse light, of what is no metal,
// of metal; and a number: what metal is multiplied by, the normal map's strength, and by how much roughness to the fourth
// dims what is no metal. T and B are the tangents of the images'
// texture coordinates, with the normal `face` interpolated but not normalised; `opacity` is radtex_alpha.
fn radtex_look_of(diffuse: vec4f, dull: vec4f, shiny: vec4f, base: vec3f, rough: vec2f, bump: vec3f, T: vec3f,
                  B: vec3f, face: vec3f, opacity: f32) -> RadtexLook {
    let part = diffuse.a * rough.y;
    let squared = rough.x * rough.x;
    let fades = 1.0 - shiny.a * squared * squared;
    let turn = 2.0 * bump - 1.0;
    let N = face * inverseSqrt(max(dot(face, face), 1e-12));
    var mapped = turn.x * T + turn.y * B + turn.z * face;
    mapped *= inverseSqrt(max(dot(mapped, mapped), 1e-12));
    var look: RadtexLook;
    look.colour = diffuse.rgb * base * (opacity * (1.0 - part));
    look.tint = opacity * (dull.rgb * (fades * (1.0 - part)) + shiny.rgb * base * part);
    look.normal = N + dull.a * (mapped - N);
    look.opacity = opacity;
    return look;
}

// The same by the bake's maps; `face` is the mesh's unit normal.
fn radtex_look(uv: vec2f, face: vec3f) -> RadtexLook {
    var look: RadtexLook;
    look.opacity = radtex_alpha(uv);
    look.colour = radtex_colours(radtex_colour_map, radtex.colour_range, uv);
    look.tint = vec3f(look.opacity, look.opacity, look.opacity);
    look.normal = face;
    if RADTEX_TINT {
        look.tint = radtex_colours(radtex_tint_map, radtex.tint_range, uv);
    }
    if RADTEX_NORMAL {
        look.normal = radtex_map(radtex_normal_map, radtex.normal_range, uv).xyz;
    }
    return look;
}

// Radiance towards the viewer, in the unit direction V, from a place at `position` whose unit normal is `face`, of a
// material that looks so, with lobes whose width² is larger by `more`.
fn radtex_lit(uv: vec2f, position: vec3f, face: vec3f, V: vec3f, look: RadtexLook, more: f32) -> vec3f {
    const material: i32 = 0;
    let shading = look.normal * inverseSqrt(max(dot(look.normal, look.normal), 1e-12));
    let N = select(face, shading, dot(shading, face) > 0.3);
    let cosine = dot(N, V);
    let curve = clamp(cosine * 16.0 - 0.5, 0.0, 15.0);
    let below = min(floor(curve), 14.0);
    let above = curve - below;
    var low = 16 * material + i32(below);
    let facts = mix(radtex_of.curves[low], radtex_of.curves[low + 1], above);
    let even = radtex_map(radtex_irradiance_map, radtex.irradiance_range, uv).rgb;
    var light = look.colour * even * facts.rgb;
    var axis = 2.0 * cosine * N - V;
    axis += max(0.01 - dot(axis, face), 0.0) * face;  // no lower than the surface
    axis *= inverseSqrt(dot(axis, axis));
    let place = radtex_square(axis);
    if RADTEX_MIRRORS {
        low += 16 * material;
        var lobe = mix(radtex_of.lobes[low], radtex_of.lobes[low + 1], above);
        var second = vec4f(0.0, 0.0, 0.0, 0.0);
        if RADTEX_SECOND_LOBE > 0 {
            second = mix(radtex_of.lobes[low + 16], radtex_of.lobes[low + 17], above);
        }
        var wider = 0.0;
        if RADTEX_WIDTH {
            wider = radtex_map(radtex_width_map, radtex.width_range, uv).r;
        }
        let spread = more;
        if radtex_luminance(lobe.rgb + second.rgb) > 0.0 {
            let whence = position - radtex.middle.xyz;
            var towards = N - dot(N, axis) * axis;
            towards *= inverseSqrt(max(dot(towards, towards), 1e-12));
            let ray = axis * sqrt(1.0 - facts.a * facts.a) + towards * facts.a;
            let own = radtex_own(uv, place);
            let met = radtex_met(whence, ray);
            let lit = radtex_lit_by(face, even, look.colour);
            lobe.a = log2(exp2(lobe.a + wider) + spread);
            var brush: RadtexBrush;
            brush.viewer = 2.0 * dot(N, axis) * N - axis;
            brush.normal = N;
            brush.tangent = N;
            brush.along = 0.0;
            brush.across = 0.0;
            if RADTEX_TANGENT {
                let brushed = radtex_of.brush[material];
                if brushed.x > 0.0 {
                    var tangent = radtex_map(radtex_tangent_map, radtex.tangent_range, uv).xyz;
                    tangent -= dot(N, tangent) * N;
                    brush.along = brushed.x * exp2(wider) + spread;
                    brush.across = brushed.y * exp2(wider) + spread;
                    let known = dot(tangent, tangent);
                    brush.tangent = tangent * inverseSqrt(max(known, 1e-12));
                    if known < 0.01 {
                        brush.tangent = vec3f(0.0, 0.0, 0.0);
                        brush.along = sqrt(brush.along * brush.across);
                        brush.across = brush.along;
                    }
                }
            }
            var mirrored = radtex_mirrored(whence, ray, met, own, lobe, lit, brush);
            if RADTEX_SECOND_LOBE > 0 {
                second.a = log2(exp2(second.a + wider) + spread);
                if radtex_luminance(second.rgb) > 0.0 {
                    mirrored += radtex_mirrored(whence, ray, met, own, second, lit, brush);
                }
            }
            var tint = look.tint;
            if RADTEX_GLOSSES {
                let gloss = radtex_of.gloss[material];
                if gloss.g > 0.0 {
                    tint = radtex_reflected(gloss.rgb * tint, exp2(gloss.a + wider), cosine, look.opacity);
                }
            }
            light += mirrored * tint;
        }
    }
    let rest = radtex_rest(radtex_rest_map, radtex.rest_range, radtex.rest_tile, f32(RADTEX_REST_CELLS), uv, place);
    light += max(look.opacity * rest, -0.5 * light);
    return max(light, vec3f(0.0, 0.0, 0.0));
}

// Radiance towards the viewer, in the unit direction V, from a place at `position` whose unit normal is N.
fn radtex_layered(uv: vec2f, position: vec3f, N: vec3f, V: vec3f) -> vec3f {
    return radtex_lit(uv, position, N, V, radtex_look(uv, N), 0.0);
}

// The same with lobes that are wider where normals differ from one pixel to the next, so that what is far away or
// sharply curved does not shimmer, by so much: 0.16 is what a pixel covers, 4 times a twelfth for each of two axes, as
// a mirror doubles angles. In the fragment stage alone, and not where fragments go different ways.
fn radtex_layered_steady(uv: vec2f, position: vec3f, N: vec3f, V: vec3f, steady: f32) -> vec3f {
    let look = radtex_look(uv, N);
    let shading = look.normal * inverseSqrt(max(dot(look.normal, look.normal), 1e-12));
    let normal = select(N, shading, dot(shading, N) > 0.3);
    let across = dpdx(normal);
    let up = dpdy(normal);
    return radtex_lit(uv, position, N, V, look, steady * (dot(across, across) + dot(up, up)));
}
