# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of options: everything that can be chosen for a bake, told once.

A new option is a field of `BakeOptions` and a row of a section, whose place is that in --help and in the
panel. From the row come the command line, the panel's properties, presets, the names in messages, refusals,
what counts on resume and in fingerprints, marks in sidecars, and the reference in the documentation.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, cast

from ..bake.layers import Layer
from ..bake.plan import MAX_IMAGE_SIDE, SHEET
from ..core.messages import Setting
from ..core.sampler import Filter
from ..formats.containers.compression import Compression
from .bake_names import OBJECT, TOKENS
from .choices import Backs, CaptureMethod, Unwrap, View
from .kinds import DEFAULT_KIND, Kind, Layout, Light
from .menu_items import (
    ATLAS_SIZES,
    BACKS,
    COMPRESSIONS,
    CONTENTS,
    KINDS,
    LAYERS,
    LAYOUTS_OR_AUTOMATIC,
    SPLITS,
    TARGETS,
    TOGETHER,
    UNWRAPS,
    VARIANTS,
    VIEWS,
)
from .option import Fold, Mark, Option, Section
from .parts import Split
from .targets import Target
from .texel_density import MOST_SHARED, MOST_TEXELS

DEFAULT_FOLDER = "//radtex/{blend_name}/"  # the panel's
LEAST_MEMORY, MOST_MEMORY = 16, 2**24  # limits of --memory, in MiB
_LENGTH = {"min": 0.0, "max": 1e18, "step": 1, "precision": 3, "subtype": "DISTANCE"}  # a property's
_FRAMES = (0, 1048574)  # Blender's
_TOKENS = "; ".join(f"{{{token}}}: {told}" for token, told in TOKENS.items())


@dataclass(frozen=True)
class BakeOptions:
    """The fields of `BakeSpec`, in an order that fingerprints and files have: new ones go last."""

    kind: Kind = DEFAULT_KIND
    texels: int = 128
    density: float | None = None
    bucket: int = cast(int, None)  # None only until __post_init__ sets the default
    samples: int = 16
    uv_layer: str | None = None
    capture: CaptureMethod = CaptureMethod.PORTAL
    seed: int = 0
    device: str = "auto"
    half: bool = True
    compression: Compression = Compression.ZIP
    unwrap: Unwrap = Unwrap.AUTO
    padding: int = 2
    memory_mb: int | None = None
    layout: Layout = Layout.BUCKETS
    layers: tuple[Layer, ...] = ()
    content: str | None = None
    accumulate: bool = False
    refresh: bool = False
    source: str | None = None
    extrusion: float | None = None
    view: View = View.NORMAL
    frame: int | None = None
    unwrap_at: int | None = None
    cage: str | None = None
    lights: tuple[str, ...] = ()
    objects: tuple[str, ...] = ()
    split: Split | None = None
    part: str | None = None
    ao_distance: float | None = None
    where: str | None = None
    sheet: int = SHEET
    denoise: bool = False
    alone: bool = False
    texel_weights: str | None = None
    backs: Backs = Backs.AUTO
    bake_name: str = OBJECT


_DEFAULTS = {each.name: each.default for each in fields(BakeOptions)}


def _row(name: str, **told: Any) -> Option:
    return Option(name, **{"default": _DEFAULTS.get(name), **told})


# A row has its short facts first, then its texts.
# fmt: off
LIGHT = Section(Fold.LIGHT, (
    _row("kind", flag="--kind", takes=Kind, title="Bake Type", items=KINDS, hooks={"update": "suit_bucket"},
         preset=True,
         help="radiance: the object as a viewer sees it; incident: the light that arrives; reflection: the "
         "same, along the mirror direction; proxy: what a hull has inside, or shows in its place; shadow: "
         "which directions are blocked; ao: how much of the sky is; transfer: how the object answers to "
         "light from each direction",
         tooltip="What is recorded: how the object looks, the light that reaches it, or what blocks light"),
    _row("view", flag="--view", takes=View, title="View", items=VIEWS, called="view",
         help="from where a transfer is seen: normal: each texel along its normal, which suits matt "
         "things; camera: from the scene's camera, gloss and all; around: from nine directions, for nine "
         "times the paths",
         tooltip="From where the object will be looked at: fixes how its gloss comes out when lamps move",
         applies=lambda kind, _: kind.views, refusal="{kind} is not baked for a view, such as {value}"),
    _row("content", flag="--content", metavar="NAME", title="Content", items=CONTENTS, panel_default="inside",
         called="content",
         help="what a proxy shows: the collection of that name, or * for all that is behind it, as through "
         "a window", default_words="what lies inside it",
         tooltip="What the hull shows in its place; the hull itself is never seen",
         applies=lambda kind, _: kind.content, refusal="{kind} shows the object itself",
         instead="bake a proxy"),
    _row("content_collection", title="Collection",
         tooltip="The collection whose objects the hull shows", applies=lambda kind, _: kind.content),
    _row("ao_distance", flag="--ao-distance", metavar="D", title="Distance", panel_default=0.0,
         blender=_LENGTH | {"soft_max": 10.0}, called=Setting.AO_DISTANCE,
         help="of ao, what is farther than D, in scene units, counts as open", default_words="nothing does",
         tooltip="What is farther away than this counts as open. With 0 there is no limit",
         applies=lambda kind, _: kind.ao_distance),
    _row("alone", flag="--alone", title="Alone", called="choice to bake it alone",
         help="bake each object as if it stood alone: no other object is seen, or casts shadows; lamps and "
         "the world stay",
         tooltip="Bake each object as if it stood alone: no other object is mirrored in it or shades it. "
         "For objects that will stand elsewhere; lamps and the world stay",
         applies=lambda kind, _: not kind.content, refusal="{kind} shows other objects",
         no_farm="a farm bakes the scene as it is", added=True,
         mark=Mark(on="was baked alone", off="was baked among other objects",
                   unlike="was baked without the other objects: compare a bake that was made among them")),
))

LAYOUT = Section(Fold.LIGHT, (
    _row("layout", flag="--layout", takes=Layout, cli_default=None, panel_name="atlas_layout",
         title="Storage", items=LAYOUTS_OR_AUTOMATIC, panel_default="auto", hooks={"update": "suit_bucket"},
         preset=True, called=Setting.LAYOUT,
         help="layered: what surrounds the object, in layers that are met from each place, what it shows "
         "of itself, and what is left: the best picture in the fewest bytes; radiance by the portal only; "
         "buckets: every texel keeps a picture of its own",
         default_words="layered; buckets for other kinds, for an object with hair or a volume, and for what "
         "layered refuses: a line says why; what is resumed, accumulated or refreshed keeps its layout",
         tooltip="Decides how sharp reflections are, and how large the files",
         applies=lambda kind, _: kind.form is None),
))

QUALITY = Section(Fold.MAIN, (
    _row("atlas_size", title="Size By", fold=Fold.SURFACE, items=ATLAS_SIZES, panel_default="texels",
         preset=True, tooltip="What the size of the texture follows from"),
    _row("texels", flag="--texels", takes=int, metavar="N", cli_default=None, limits=(1, MAX_IMAGE_SIDE),
         title="Resolution", blender={"soft_min": 16, "soft_max": 1024}, preset=True, called=Setting.TEXELS,
         help="texels along the atlas's longer side; left out, an atlas that objects share has more, such as "
         "256 for four of them", default_words=str(BakeOptions.texels),
         tooltip="Texels along the texture's longer side: more show finer detail on the surface. Twice as "
         "many take four times as long"),
    _row("density", flag="--density", metavar="D", title="Density", panel_default=64.0,
         blender={"min": 1e-3, "max": 1e12, "soft_min": 1.0, "soft_max": 4096.0}, preset=True,
         called=Setting.DENSITY,
         help="texels per metre of surface, such as 64/m, 64/cm or 1.5/mm, in place of --texels: the atlas "
         f"is as large as that needs, up to {MOST_TEXELS} texels a side. A scene unit has as many metres as "
         "the scene's unit scale says",
         tooltip="Texels per metre of surface: objects of every size come out alike, and their textures "
         "are as large as that needs, up to 4096 texels a side. The scene's Unit Scale says what a metre is"),
    # The panel's 14 cells are those of the automatic layout (`job.layout_choice`).
    _row("bucket", flag="--bucket", takes=int, metavar="N", limits=(2, 256), word="cells",
         title="Angular Detail", fold=Fold.SAMPLING, panel_default=14, blender={"soft_max": 32},
         hooks={"update": "keep_bucket"}, preset=True, called=Setting.BUCKET,
         help="cells along a bucket's side: each texel tells N x N directions apart",
         default_words=f"{Layout.BUCKETS.cells} in layout buckets; layered chooses them itself",
         tooltip="Directions that each texel tells apart, along each side of its bucket: more give sharper "
         "reflections and highlights, and twice as many take four times as long. Layered chooses it "
         "itself; a number other than 14 makes Automatic choose Buckets",
         applies=lambda kind, form: kind.cells and form.any_cells),
    _row("samples", flag="--samples", metavar="N", limits=(1, 2**24), title="Samples",
         blender={"soft_max": 1024}, preset=True,
         help="light paths for each cell: more paths, less noise; in the layered layout about 64 N for "
         "each texel, however many cells it has",
         tooltip="Paths that Cycles traces for each direction of a texel: more leave less noise, and take "
         "longer. Layered traces about 64 times as many for each texel"),
))

SURFACE = Section(Fold.SURFACE, (
    _row("uv_layer", flag="--uv", metavar="NAME", title="UV Map", called=Setting.UV,
         help="bake on this UV layer of the object", default_words="as --unwrap says",
         tooltip="The UV map to bake on: inside the unit square and without overlaps, or places on the "
         "surface would show each other's light. Left empty, Unwrap decides"),
    _row("unwrap", flag="--unwrap", takes=Unwrap, title="Unwrap", items=UNWRAPS, called=Setting.UNWRAP,
         help="auto: bake on the object's active UV layer if it is fit (it covers half of the square, "
         "overlaps nowhere, and its islands are --padding apart), else pack its islands anew where they are "
         "clean, unwrap what is left as uvunwrap does, and give few texels to what no camera can see; "
         "uvunwrap: unwrap a copy into few, large islands; xatlas, blender: by these",
         tooltip="How UVs are made where no map is chosen. Your mesh stays as it is"),
    _row("texel_weights", flag="--texel-weights", metavar="GROUP", title="Texel Weights",
         called=Setting.TEXEL_WEIGHTS,
         help="a vertex group that says where the unwrap gives more or fewer texels: weight 1 gives twice as "
         "many along a side, 0.5 as many as without it, 0 a quarter; vertices that are not in it have 0.5",
         default_words="as --unwrap says",
         tooltip="A vertex group that says where texels go: weight 1 gives twice as many along a side, 0.5 "
         "as many as without it, 0 a quarter. Vertices that are not in it have 0.5: assign all with that "
         "weight before you paint",
         added=True),
    _row("backs", flag="--backs", takes=Backs, word="choice of backs", title="Backs", items=BACKS,
         called=Setting.BACKS,
         help="which faces that are seen from behind, such as a leaf's, get texels of their own for their "
         "backs in the layered layout: auto: those whose backs a camera can see, not the backs of a room's "
         "walls or of what lies on something; all: those too; none: only front sides have texels",
         tooltip="Which faces that are seen from behind, such as a leaf's, get texels of their own for their "
         "backs, where the storage is Layered",
         applies=lambda kind, _: kind.form is None, added=True),
    _row("padding", flag="--padding", metavar="N", limits=(0, 256), title="Padding", blender={"soft_max": 16},
         preset=True,
         help="texels that the unwrap leaves free between islands",
         tooltip="Texels left free between UV islands: too few, and light bleeds across seams"),
))

OBJECTS = Section(Fold.SURFACE, (
    _row("object", flag="--object", metavar="NAME", many=True,
         help="the mesh object to bake; may be given several times"),
    _row("collection", flag="--collection", metavar="NAME", many=True,
         help="bake all meshes of the collection and of those in it, by name; what cannot be baked, such "
         "as what is hidden from render, is left out with a line that says why; may be given several "
         "times, and beside --object"),
    _row("all", flag="--all", default=False,
         help="bake the scene in one go: all meshes that render, or what --object and --collection name, "
         "into few atlases. Floors, walls and what lies flat on them share NAME_shell, NAME being the "
         "scene's; things that stand near each other share others, of up to "
         f"{MOST_SHARED} texels a side. With --density all have that. Else --texels is an object's share: "
         "of up to a dozen objects all atlases together have as many texels as they would have had, of more "
         "as many as a dozen; small and glossy things get more per area"),
    _row("one_atlas", panel_name="together", title="Together", items=TOGETHER, panel_default="auto",
         tooltip="Which of the chosen objects share a texture"),
    _row("together", flag="--together", metavar="NAME|auto", panel_name="atlas_name", title="Name",
         panel_default="Atlas", called=Setting.TOGETHER, label="Together",
         help="bake all objects into one atlas, which is called NAME: DIR/NAME.KIND.exr; auto: one for each "
         "group of objects that touch and that the layered layout takes, called like the parent or the "
         "collection of them alone, else like the largest and _asset; no part of it is what is far larger "
         "and flat, or encloses the others, such as a floor or a room. Without --texels an atlas that they "
         "share has about as many as theirs would have, more if their UV layers have hundreds of islands, up "
         f"to {MOST_SHARED} a side",
         default_words="each has its own; a line says which touch",
         tooltip="Name of the shared texture, and of its files"),
    _row("split", flag="--split", takes=Split, word="way to split", title="Split By", items=SPLITS,
         panel_default="none", called=Setting.SPLIT,
         help="material: an atlas for each material, DIR/NAME.MATERIAL.KIND.exr; udim: one for each tile "
         "of the UV layer --uv, DIR/NAME.1001.KIND.exr and so on", default_words="one for the whole surface",
         tooltip="One texture for the whole object, or one for each material or UDIM tile"),
    _row("part", flag="--part", metavar="PART", title="Only", called=Setting.PART,
         help="of --split, bake this material or tile alone", default_words="all of them",
         tooltip="The one material, or the tile's number, to bake. Left empty, all are baked"),
    _row("in_scene", flag="--in-scene", metavar="NAME",
         help="the scene of the file", default_words="the one that it opens with"),
))

SOURCE = Section(Fold.SURFACE, (
    _row("source", flag="--from", metavar="NAME", title="Detailed Object", called=Setting.FROM,
         help="bake what the detailed object of that name shows: it is found along the normals of "
         "--object, which is simple, stands around the same place and is not seen itself",
         tooltip="A high-poly object in the same place, whose light the low-poly one shall show. The "
         "low-poly one is not seen while it is baked. Left empty, objects show their own light",
         applies=lambda kind, _: kind.source),
    _row("extrusion", flag="--extrusion", metavar="D", title="Extrusion", panel_default=0.0,
         blender=_LENGTH | {"soft_max": 1.0}, called=Setting.EXTRUSION,
         help="how far from --object, outwards and inwards, --from is looked for, in scene units",
         default_words="3 %% of the size",
         tooltip="How far from the simple surface, outwards and inwards, the detailed one is looked for. 0 "
         "is 3 % of the object's size",
         applies=lambda kind, _: kind.source),
    _row("cage", flag="--cage", metavar="NAME", title="Cage", called=Setting.CAGE,
         help="look for --from from this object on, through --object and as far beyond, instead of along "
         "normals: a copy of --object whose vertices were moved out; it is never seen",
         tooltip="A copy of the simple object whose vertices were moved out: the detailed one is looked "
         "for from there on, instead of along the normals. It may be hidden",
         applies=lambda kind, _: kind.source),
))

VARIANTS_OF_LIGHT = Section(Fold.LIGHT, (
    _row("variants", title="Variations", items=VARIANTS, panel_default="none", called=Setting.LIGHTS,
         tooltip="Several bakes of each object at once"),
    _row("frame", limits=_FRAMES, resumes=True),  # another fact tells the frame in use
    _row("frames", flag="--frames", metavar="LIST", cli_default=(), title="Frames", panel_default="1",
         called=Setting.FRAMES,
         help="bake the scene at each of these frames, such as 1,5,10-20, into DIR/NAME-FRAME.KIND.exr, "
         "the frame in four digits", default_words="the frame that the file opens with",
         tooltip="The frames to bake, such as 1,5,10-20"),
    _row("unwrap_at", flag="--unwrap-at", metavar="FRAME", limits=_FRAMES,
         help="unwrap the object as it is at that frame, so that atlases of all frames fit one mesh",
         default_words="the first of --frames"),
    _row("lit", flag="--lights", metavar="LIST", many=True,
         help="bake with these lamps, or collections of lamps, alone lit, such as Key,Fill, into "
         "DIR/NAME-Key+Fill.KIND.exr; the name world is the light of no lamp. each: an atlas for every "
         "lamp and one for world, which add up to the whole; all: the whole; may be given several times"),
    _row("layers", flag="--layer", takes=Layer, word="layer", metavar="LAYER", many=True, cli_default=None,
         title="Layers", items=LAYERS, panel_default=set(), called=Setting.LAYER,
         help="also write this part of the radiance as an atlas, DIR/NAME.KIND.LAYER.exr: "
         f"{', '.join(Layer)}; base and rest add up to the whole; may be given several times",
         tooltip="Also save parts of the light, such as reflections, as textures of their own, to mix or "
         "to regrade later",
         applies=lambda kind, form: form.layers and kind.layers),
))

HOW = Section(Fold.SAMPLING, (
    _row("capture", flag="--capture", takes=CaptureMethod,
         help="portal: many texels in one render; panoramic: a fisheye camera at each texel, slow, not for "
         "radiance"),
    _row("seed", flag="--seed", metavar="N", limits=(0, 2**31 - 1), title="Seed",
         help="seed of the light paths; the same seed gives the same atlas",
         tooltip="Another seed gives other noise; the same one gives the same picture again"),
    _row("sheet", flag="--sheet", metavar="N", limits=(16, MAX_IMAGE_SIDE),
         help="side, in pixels, of the pictures that Cycles renders of an atlas: a frame of a farm is one, "
         "and pictures of another size have other noise"),
    _row("denoise", flag="--no-denoise", cli_default=True, title="Denoise", panel_default=True,
         help="keep cells as they were traced, noise and all",
         default_words="buckets of light, and transfers, are denoised by OpenImageDenoise",
         tooltip="Remove the grain by OpenImageDenoise. Turn it off for bakes to which samples are added "
         "later",
         applies=lambda kind, form: kind.light is not Light.OCCLUSION and not form.by_paths),
    # In the panel these are preferences. Another fact tells the device in use; memory changes tiles' heights.
    _row("device", flag="--device", resumes=True, of_atlas=False),
    _row("memory_mb", flag="--memory", limits=(LEAST_MEMORY, MOST_MEMORY), word="memory in MiB",
         help="memory that the bake may take beside the scene: one that needs more is refused",
         resumes=True, of_atlas=False),
))

FOLDER = Section(Fold.OUTPUT, (
    _row("out", flag="--out", metavar="DIR", panel_name="directory", title="Output Folder",
         panel_default=DEFAULT_FOLDER,
         blender={"subtype": "DIR_PATH", "options": {"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"}},
         called=Setting.OUT, label="Folder",
         help="folder for the files, made if need be",
         default_words="radtex/NAME beside NAME.blend; without a file, radtex",
         tooltip="Where the atlas and all that belongs to it are written; // is the .blend file's folder, "
         "{blend_name} its name, so that no two files share a folder"),
    _row("bake_name", flag="--name", metavar="PATTERN", title="Bake Name", called=Setting.BAKE_NAME,
         help="what the files are called, NAME in DIR/NAME.KIND.exr and so on, such as {object}.{quality}, "
         f"so that a draft and a final bake lie side by side. {_TOKENS}",
         default_words=OBJECT,
         tooltip="What the bake's files are called, such as {object}.{quality}, so that a draft and a final "
         f"bake of one object lie side by side. {_TOKENS}",
         resumes=True, of_atlas=False),  # the unfinished bake lies by that name
    _row("overwrite", flag="--overwrite", default=False, title="Overwrite", fold=Fold.SCRIPTS,
         called=Setting.OVERWRITE,
         help="replace an earlier bake of the same thing, unless it is better: with more texels, cells or "
         "samples, other layers, or layered where the new one is not",
         tooltip="Replace the files of an earlier bake of the same object"),
    _row("overwrite_any", flag="--overwrite-any", default=False,
         help="as --overwrite, and replace better bakes, and those of other .blend files, too; a bake of "
         "another object, part or frame never is"),
))

COURSE = Section(Fold.OUTPUT, (
    _row("accumulate", flag="--accumulate", title="Accumulate", called=Setting.ACCUMULATE,
         help="fold the samples into the atlas that is there: 8 and 8 more are 16, if nothing has changed",
         tooltip="Add samples to the bake that is there: the same picture with less grain",
         of_atlas=False),
    _row("passes", flag="--passes", takes=int, metavar="N",
         help="bake, then fold in as many samples again, with exports and preview after each pass, until "
         "there are N passes", default_words="1"),
    _row("serve", flag="--serve", takes=int, metavar="PORT",
         help="with --export web: serve the page on this machine, which takes in each pass, until Ctrl-C; "
         "0 is a free port"),
    _row("refresh", flag="--refresh", title="Refresh", called=Setting.REFRESH,
         help="bake again only those texels of the atlas that is there whose light has changed, with as "
         "many samples as it has",
         tooltip="Bake again only the places whose light has changed since the atlas was baked, as after a "
         "lamp was moved. For Buckets alone: in Layered, Bake Again, or Bake Changed of several objects",
         of_atlas=False),
    _row("where", flag="--where", metavar="NAME", title="Only Where", hooks={"search": "places"},
         help="accumulate or refresh only faces of the object's vertex group, boolean face attribute or "
         "material of that name", default_words="everywhere",
         tooltip="Accumulate or refresh only the faces of this vertex group, boolean face attribute or "
         "material. Left empty, everywhere",
         of_atlas=False),
    _row("only_changed", flag="--changed", default=False, called=Setting.CHANGED,
         help="bake only what has no finished bake in DIR, or has changed since: mesh, place, materials, "
         "settings or surroundings; replaces what is there, and says in a line what became of each"),
    _row("surroundings", flag="--ignore-surroundings", default=True,
         help="of --changed, what has changed of neighbours, lamps and the world does not count"),
    _row("resume", flag="--resume", default=False, title="Resume", fold=Fold.SCRIPTS, called=Setting.RESUME,
         help="go on with a bake that was interrupted, killed or failed, from what is kept of it in "
         "DIR/NAME.KIND.radtex-unfinished; the atlas is what it would have been, bit by bit",
         tooltip="Go on with a bake that was cancelled or that failed, from what is kept of it: the "
         "picture is the same as if it had never stopped"),
))

FILES = Section(Fold.OUTPUT, (
    _row("save_preview", flag="--save-preview", default=False, panel_name="preview", title="Preview",
         panel_default=True, called=Setting.SAVE_PREVIEW,
         help="also write DIR/NAME.preview.blend: the scene with the baked object in it",
         tooltip="Also write a .blend in which the baked copy stands in the object's place. Showing the "
         "bake here and exporting it need that"),
    _row("filter", flag="--filter", takes=Filter, default=Filter.QUADRILINEAR,
         help="how the preview blends cells and texels of layout buckets"),
    _row("half", flag="--float", panel_name="full_floats", title="32-bit Floats", panel_default=False,
         preset=True, called=Setting.FLOAT,
         help="store 32-bit floats", default_words="half floats",
         tooltip="Keep light beyond 65504 and steps that 16 bits are too few for. Hardly ever seen, and "
         "twice as large",
         applies=lambda kind, _: kind.full_floats),
    _row("compression", flag="--compression", takes=Compression, title="Compression", items=COMPRESSIONS,
         preset=True, called=Setting.COMPRESSION,
         help="how the atlas is packed; dwaa is small and loses a little",
         tooltip="How the images are packed on disk"),
))

EXPORTS = Section(Fold.OUTPUT, (
    _row("exports", flag="--export", takes=Target, many=True, panel_name="export_targets", title="Export",
         items=TARGETS, panel_default=set(),
         help="also make DIR/NAME.TARGET of the bake, as bake.py export --to TARGET does; may be given "
         "several times, and needs --save-preview",
         tooltip="Folders to make of the bake once it is done: for browsers, engines and viewers"),
    _row("export_again", flag="--export-again", default=False,
         help="also make the exports again that the .blend keeps of these bakes, in the same folders by the "
         "same settings: those with After Each Bake in the panel's dialog; needs --save-preview"),
    _row("thumbnail", flag="--thumbnail", metavar="FILE",
         help="a small PNG of what is baked so far, written anew every second"),
))

# fmt: on
# In the panel's order.
SECTIONS = (
    *(LIGHT, LAYOUT, QUALITY, SURFACE, OBJECTS, SOURCE, VARIANTS_OF_LIGHT),
    *(HOW, FOLDER, COURSE, FILES, EXPORTS),
)
OPTIONS = {option.name: option for section in SECTIONS for option in section.options}
MARKED = {name: option.mark for name, option in OPTIONS.items() if option.mark is not None}
SHOWN = {option.setting: option for option in OPTIONS.values() if option.title}
CALLED = {option.called: option for option in OPTIONS.values() if option.called}


def shown_in(fold: Fold) -> list[Option]:
    """The options that are in a fold of the panel."""
    return [
        option
        for section in SECTIONS
        for option in section.options
        if option.title and (option.fold or section.fold) == fold
    ]
