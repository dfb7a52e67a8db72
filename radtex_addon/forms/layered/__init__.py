# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout: surroundings in layers, the lobes of each material, own light, and what is left.

    radiance = colour(uv) irradiance(uv) falloff(N.V)
             + tint(uv) sum over a material's two lobes of  weight(N.V) [ m D + (1 - m) own(uv, A) ]
             + rest(uv, A)
             + colour through(uv) chief(uv, V) D + rest through(uv, -V)

A is the mirror direction, bent a little by the lobe. D is what surrounds the object, met from the fragment's
own place: the world, a plane under the object, the things beside it (by a distance impostor), each blurred by
the lobe as it is seen from there, and lamps. m is how much of D the object itself leaves free, own what it
shows of itself, rest what all this does not explain. See docs/layered-layout.md for what each part is
worth.
"""
