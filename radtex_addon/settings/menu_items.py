# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Items of the enum properties: identifier, name and tooltip, in Blender's format."""

from __future__ import annotations

from .kinds import Kind
from .targets import Target

KINDS = tuple((kind.value, kind.traits.title, kind.traits.tooltip) for kind in Kind)
TARGETS = tuple((target.value, target.traits.title, target.traits.tooltip) for target in Target)

VIEWS = (
    (
        "normal",
        "Normal",
        "Each place as it is seen straight from above: right for matt things, from anywhere",
    ),
    ("camera", "Camera", "As the scene's camera sees it, gloss and all: for one picture that is lit anew"),
    (
        "around",
        "Around",
        "From nine directions, between which it blends: nine times the paths and the texture",
    ),
)

CONTENTS = (
    ("inside", "Inside", "All that lies within the hull"),
    ("collection", "Collection", "What one collection holds, wherever it is"),
    ("all", "Everything", "All that is behind it, the world too, as through a window"),
)

VARIANTS = (
    ("none", "None", "One bake of each object"),
    ("frames", "Frames", "One for each of some frames of the animation, on one unwrap"),
    (
        "lamps",
        "Each Lamp",
        "One for each lamp alone, and one for all other light. Light adds up: games mix them as they like",
    ),
)

LAYERS = (
    ("diffuse", "Diffuse", "Light scattered by the surface, and below it"),
    ("glossy", "Glossy", "Reflections, sharp or blurred"),
    ("transmission", "Transmission", "What is seen through glass"),
    ("volume", "Volume", "Light scattered by smoke and fog"),
    ("emission", "Emission", "What glows"),
    ("environment", "Environment", "The world, where nothing else is seen"),
    ("normal", "Normal", "Which way what is seen there faces, in world space"),
    ("base", "Base", "Diffuse light, one value for each texel: a small texture that needs no view"),
    ("rest", "Rest", "What the base lacks of the whole, in each direction"),
)

LAYOUTS = (
    (
        "buckets",
        "Buckets",
        "Every texel keeps its own small picture of the light in all directions: exact, and large files",
    ),
    (
        "layered",
        "Layered",
        "One sharp picture of the surroundings and the object's own light: the best picture, small files",
    ),
)
AUTOMATIC = (
    "auto",
    "Automatic",
    "Layered where that is possible, else Buckets; the line below says which, and why",
)
# The numbers are explicit because .blend files store them; 1 was a layout that is no longer there.
LAYOUTS_OR_AUTOMATIC = (
    (*AUTOMATIC, "NONE", 2),
    *((*layout, "NONE", number) for layout, number in zip(LAYOUTS, (0, 3), strict=True)),
)

SPLITS = (
    ("none", "None", "The whole surface has one texture"),
    ("material", "Material", "Each material has a texture, for engines that draw material by material"),
    ("udim", "UDIM", "Each tile of the UV map has a texture; tiles are numbered from 1001 on"),
)

# The numbers are explicit because .blend files store them: 0 and 1 were off and on.
TOGETHER = (
    (
        "auto",
        "Automatic",
        "Objects that touch are one asset, with one texture; all others, floors and walls have their own",
        "NONE",
        2,
    ),
    (
        "one",
        "One Atlas",
        "All chosen objects share one texture, so that a game draws them at once",
        "NONE",
        1,
    ),
    ("off", "Each by Itself", "Each object has a texture of its own", "NONE", 0),
)

# The numbers are explicit because .blend files store them: the first two are the older ones.
UNWRAPS = (
    (
        "auto",
        "Automatic",
        (
            "Your active UV map if it is fit: it covers half of the square, overlaps nowhere, and its "
            "islands are apart by the padding. Else a new unwrap; your mesh stays as it is"
        ),
        "NONE",
        2,
    ),
    (
        "uvunwrap",
        "New",
        "Unwrap a copy anew: few, large islands, so that seams waste little",
        "NONE",
        3,
    ),
    ("xatlas", "xatlas", "Even islands, more of them. Takes long on large meshes", "NONE", 0),
    (
        "blender",
        "Blender",
        "Blender's Smart UV Project: quick on large meshes, in more and smaller islands",
        "NONE",
        1,
    ),
)

BACKS = (
    (
        "auto",
        "Automatic",
        (
            "Those that a camera can see: not the backs of a room's walls, floor and ceiling, nor of what "
            "lies on something"
        ),
    ),
    ("all", "All", "Those that can be seen from outside of their mesh, wherever it stands"),
    ("none", "Only Front Sides", "No backs: from behind, faces look as from the front"),
)

ATLAS_SIZES = (
    ("texels", "Texels", "Each texture has so many texels along its longer side"),
    (
        "density",
        "Density",
        "Each metre of surface has so many texels, and the texture is as large as that needs",
    ),
)

COMPRESSIONS = (
    ("zip", "ZIP", "Exact, and small"),
    ("piz", "PIZ", "Exact, and often smaller where there is noise, but slower to read"),
    ("dwaa", "DWAA", "Much smaller; faint detail in smooth areas is lost"),
)

DEVICES = (
    ("auto", "Automatic", "The GPU that is switched on in Blender's preferences, or else the CPU"),
    ("cpu", "CPU", "The processor: slow, and never short of memory"),
    ("gpu", "Any GPU", "The first GPU that Cycles can use, whatever Blender's preferences say"),
    ("optix", "OptiX", "NVIDIA's GPUs from RTX on"),
    ("cuda", "CUDA", "NVIDIA's GPUs"),
    ("hip", "HIP", "AMD's GPUs"),
    ("metal", "Metal", "Apple's GPUs"),
    ("oneapi", "oneAPI", "Intel's GPUs"),
)
