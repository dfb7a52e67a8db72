// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What every bake in the layout `shared` has, dense or condensed.

uniform sampler2D u_colour, u_irradiance, u_surroundings;
uniform ivec2 u_fine, u_texels, u_around;
uniform int u_bucket, u_columns;
uniform vec3 u_falloff[RADTEX_FALLOFF];
