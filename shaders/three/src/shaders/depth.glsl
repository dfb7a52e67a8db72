// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Where a fading object is, before it is drawn: then its nearest side alone is blended, not what it hides of itself.

#include <common>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>

void main() {
    #include <clipping_planes_fragment>
    #include <logdepthbuf_fragment>
    gl_FragColor = vec4(0.0);
}
