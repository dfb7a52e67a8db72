// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the shared layout: WGSL. Put it before your shader's text, then
//
//     let V = normalize(camera - position); let N = normalize(normal);  // in the world space of the bake
//     var light = radtex_diffuse(colour, irradiance, filtering, falloff, uv, dot(N, V))
//         + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, filtering, n, surroundings, around, uv, reflect(-V, N))
//         + radtex_lobe(through_ends, through_gain, through_rest, filtering, n, surroundings, around, uv, -V);
//     light = max(light, vec3f(0.0));
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_shared. The textures are
// <name>.radiance.<layer>.exr as half floats, scene-linear Rec.709, without mipmaps, uploaded bottom row first (v = 0
// is row 0); the sampler is linear. From the sidecar: n is "bucket", `around` is "surroundings" and "levels",
// `falloff` is "falloff".

override RADTEX_HARDWARE_LINEAR: bool = false;  // true: the sampler blends, one lookup in place of four. 8-bit weights

const RADTEX_FALLOFF: i32 = 16;  // the falloff's points: as many as the sidecar has
alias RadtexFalloff = array<vec3f, RADTEX_FALLOFF>;

// Bilinear between the pixels of a box at `origin`, never beyond it; `place` in pixels, their centres at a half.
fn radtex_bilinear(image: texture_2d<f32>, filtering: sampler, origin: vec2i, box: vec2i, place: vec2f) -> vec4f {
    let position = clamp(place, vec2f(0.5), vec2f(box) - 0.5);
    if RADTEX_HARDWARE_LINEAR {
        return textureSampleLevel(image, filtering, (vec2f(origin) + position) / vec2f(textureDimensions(image)), 0.0);
    }
    let low = vec2i(position - 0.5);
    let high = min(low + 1, box - 1);
    let f = position - 0.5 - vec2f(low);
    let below = mix(textureLoad(image, origin + low, 0), textureLoad(image, origin + vec2i(high.x, low.y), 0), f.x);
    let above = mix(textureLoad(image, origin + vec2i(low.x, high.y), 0), textureLoad(image, origin + high, 0), f.x);
    return mix(below, above, f.y);
}

// Where a direction, of any length, lies on an octahedral picture of n x n cells: in pixels from its border's corner.
fn radtex_octahedron(direction: vec3f, n: i32) -> vec2f {
    let d = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    let folded = (1.0 - abs(d.yx)) * select(vec2f(1.0), vec2f(-1.0), d.xy < vec2f(0.0));
    return (select(d.xy, folded, d.z < 0.0) * 0.5 + 0.5) * f32(n) + 1.0;
}

// The four buckets of n x n cells around `uv`, each at `place`, blended.
fn radtex_buckets(image: texture_2d<f32>, filtering: sampler, n: i32, uv: vec2f, place: vec2f) -> vec4f {
    let box = vec2i(n + 2);
    let last = vec2i(textureDimensions(image)) / box - 1;
    let position = clamp(uv * vec2f(last + 1) - 0.5, vec2f(0.0), vec2f(last));
    let low = vec2i(position);
    let high = min(low + 1, last);
    let f = position - vec2f(low);
    let below = mix(radtex_bilinear(image, filtering, low * box, box, place),
                    radtex_bilinear(image, filtering, vec2i(high.x, low.y) * box, box, place), f.x);
    let above = mix(radtex_bilinear(image, filtering, vec2i(low.x, high.y) * box, box, place),
                    radtex_bilinear(image, filtering, high * box, box, place), f.x);
    return mix(below, above, f.y);
}

// One level of the surroundings, whose sharpest has `size` x `size` cells; the others lie in a column beside it.
fn radtex_surroundings_level(surroundings: texture_2d<f32>, filtering: sampler, size: i32, level: i32,
                             d: vec3f) -> vec3f {
    let side = max(size >> u32(level), 8);
    var origin = vec2i(select(0, size + 2, level > 0), 0);
    for (var k = 1; k < level; k++) { origin.y += max(size >> u32(k), 8) + 2; }
    return radtex_bilinear(surroundings, filtering, origin, vec2i(side + 2), radtex_octahedron(d, side)).rgb;
}

// Surroundings around the direction d, blurred by a variance in units of the sharpest level's. Each level has four
// times the variance of the one before.
fn radtex_surroundings(surroundings: texture_2d<f32>, filtering: sampler, around: vec2i, d: vec3f,
                       spread: f32) -> vec3f {
    let level = clamp(0.5 * log2(max(spread, 1.0)), 0.0, f32(around.y - 1));
    let low = i32(level);
    let high = min(low + 1, around.y - 1);
    let sharper = radtex_surroundings_level(surroundings, filtering, around.x, low, d);
    return mix(sharper, radtex_surroundings_level(surroundings, filtering, around.x, high, d), level - f32(low));
}

// Light that leaves every way alike, but for its falloff with the cosine N.V. `fine` and `texels` are the images'
// sizes: an image may be padded on the right and at the top.
fn radtex_diffuse_padded(colour: texture_2d<f32>, fine: vec2i, irradiance: texture_2d<f32>, texels: vec2i,
                         filtering: sampler, falloff: RadtexFalloff, uv: vec2f, cosine: f32) -> vec3f {
    let place = clamp(cosine * f32(RADTEX_FALLOFF) - 0.5, 0.0, f32(RADTEX_FALLOFF - 1));
    let low = i32(place);
    return radtex_bilinear(colour, filtering, vec2i(0), fine, uv * vec2f(fine)).rgb
        * radtex_bilinear(irradiance, filtering, vec2i(0), texels, uv * vec2f(texels)).rgb
        * mix(falloff[low], falloff[min(low + 1, RADTEX_FALLOFF - 1)], place - f32(low));
}

// The same of images that are not padded.
fn radtex_diffuse(colour: texture_2d<f32>, irradiance: texture_2d<f32>, filtering: sampler, falloff: RadtexFalloff,
                  uv: vec2f, cosine: f32) -> vec3f {
    let fine = vec2i(textureDimensions(colour));
    let texels = vec2i(textureDimensions(irradiance));
    return radtex_diffuse_padded(colour, fine, irradiance, texels, filtering, falloff, uv, cosine);
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
fn radtex_lobe(ends: texture_2d<f32>, gain: texture_2d<f32>, rest: texture_2d<f32>, filtering: sampler, n: i32,
               surroundings: texture_2d<f32>, around: vec2i, uv: vec2f, axis: vec3f) -> vec3f {
    let place = radtex_octahedron(axis, n);
    let end = radtex_buckets(ends, filtering, n, uv, place);
    let met = radtex_surroundings(surroundings, filtering, around, axis + end.xyz, end.w);
    return radtex_buckets(gain, filtering, n, uv, place).rgb * met + radtex_buckets(rest, filtering, n, uv, place).rgb;
}

// The direction V to the viewer whose place a ray takes that hits the surface: `ray` leads to it, unit as N is. One from
// behind N counts as grazing: at a slant a smooth normal turns away from rays that do hit the front. A ray that meets a
// facet's back is no hit.
fn radtex_hit_viewer(ray: vec3f, N: vec3f) -> vec3f {
    let V = max(dot(ray, N), 0.0) * N - ray;
    return V / max(length(V), 1e-30);
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
fn radtex_shared(colour: texture_2d<f32>, irradiance: texture_2d<f32>, filtering: sampler, falloff: RadtexFalloff,
                 mirror_ends: texture_2d<f32>, mirror_gain: texture_2d<f32>, mirror_rest: texture_2d<f32>,
                 through_ends: texture_2d<f32>, through_gain: texture_2d<f32>, through_rest: texture_2d<f32>, n: i32,
                 surroundings: texture_2d<f32>, around: vec2i, uv: vec2f, N: vec3f, V: vec3f) -> vec3f {
    let light = radtex_diffuse(colour, irradiance, filtering, falloff, uv, dot(N, V))
        + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, filtering, n, surroundings, around, uv, reflect(-V, N))
        + radtex_lobe(through_ends, through_gain, through_rest, filtering, n, surroundings, around, uv, -V);
    return max(light, vec3f(0.0));
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
fn radtex_shared_hit(colour: texture_2d<f32>, irradiance: texture_2d<f32>, filtering: sampler, falloff: RadtexFalloff,
                     mirror_ends: texture_2d<f32>, mirror_gain: texture_2d<f32>, mirror_rest: texture_2d<f32>,
                     through_ends: texture_2d<f32>, through_gain: texture_2d<f32>, through_rest: texture_2d<f32>,
                     n: i32, surroundings: texture_2d<f32>, around: vec2i, uv: vec2f, N: vec3f, ray: vec3f) -> vec3f {
    return radtex_shared(colour, irradiance, filtering, falloff, mirror_ends, mirror_gain, mirror_rest,
                         through_ends, through_gain, through_rest, n, surroundings, around, uv, N,
                         radtex_hit_viewer(ray, N));
}
