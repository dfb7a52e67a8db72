# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a game engine does: one reflection probe in the object's middle, the material's inputs, a lightmap.

The probe is parallax-corrected and blurred by roughness; metals, dielectrics, thin films and clear coats
mirror it by the split sum, dimmed where the object occludes itself. Diffuse light is a lightmap's. Glass
shows the probe behind it as Filament's solid refraction does: through a ball as thick as the object.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import bilinear
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.settings.spec import BakeSpec

from ..captured import Captured, OfCapture
from ..engine_material import Inputs
from ..lightmaps import DiffuseMap, diffuse_map, sample_weights, texture_bytes
from ..method import Baked
from ..reflection_probe import Probe
from ..self_occlusion import RAYS, ambient_visibility, specular_visibility
from ..split_sum import reflectance
from ..thin_film import filmed

_STEPS = 16  # of the cosine, in a mean over viewers


@dataclass(frozen=True, eq=False)
class _Surface:
    """The inputs at fragments (K, ...); `bare` is the base's frontal reflectance without a thin film."""

    colour: Floats
    bare: Floats
    roughness: Floats
    metallic: Floats
    transmission: Floats
    coat: Floats
    coat_roughness: Floats
    coat_frontal: float
    film: float
    film_ior: float

    @classmethod
    def at(cls, inputs: Inputs, uv: Floats) -> _Surface:
        colour = np.clip(bilinear(inputs.colour, uv), 0, 1)
        metallic, roughness, transmission = bilinear(inputs.surface, uv).T
        coat, coat_roughness, level = bilinear(inputs.coat, uv).T
        dielectric = (2 * level * _frontal(inputs.ior))[:, None]
        return cls(
            colour=colour,
            bare=dielectric + metallic[:, None] * (colour - dielectric),
            roughness=np.clip(roughness, 0, 1),
            metallic=metallic,
            transmission=transmission,
            coat=coat,
            coat_roughness=np.clip(coat_roughness, 0, 1),
            coat_frontal=_frontal(inputs.coat_ior),
            film=inputs.film,
            film_ior=inputs.film_ior,
        )

    def frontal(self, cosine: Floats) -> Floats:
        """The base's frontal reflectance (K, 3); under a thin film it depends on the cosine (K,)."""
        return filmed(self.bare, cosine, self.film, self.film_ior) if self.film > 0 else self.bare

    def mirrored(self, cosine: Floats) -> tuple[Floats, Floats]:
        """The shares (K, 3) that coat and base mirror of even light, the base as seen through the coat."""
        frontal = np.full_like(self.bare, self.coat_frontal)
        coat = self.coat[:, None] * reflectance(frontal, cosine, self.coat_roughness)
        return coat, (1 - coat) * reflectance(self.frontal(cosine), cosine, self.roughness)


@dataclass(frozen=True, eq=False)
class _Shader:
    """All that the engine keeps of the object; `visibility` (H, W, 1), `size` its thickness.

    The diffuse map is premultiplied by `alpha` (H', W', 1), None where that is 1 everywhere.
    """

    probe: Probe
    inputs: Inputs
    diffuse: DiffuseMap
    visibility: Floats
    size: float
    alpha: Floats | None

    def shade(self, buffer: GBuffer) -> Array:
        """The light along a G-buffer's rays, (N, 3)."""
        uv, position, normal, viewer = (
            field[buffer.hit].astype(np.float32)
            for field in (buffer.uv, buffer.position, buffer.normal, buffer.incoming)
        )
        surface = _Surface.at(self.inputs, uv)
        facing = np.sum(normal * viewer, axis=1)
        cosine = np.clip(facing, 1e-3, 1)
        reflected = 2 * facing[:, None] * normal - viewer
        visible = bilinear(self.visibility, uv)[:, 0]

        def lobe(roughness: Floats, frontal: Floats) -> Floats:
            """The probe in the mirror direction; a rough lobe leans to the normal, as in Filament."""
            leaning = reflected + (roughness**4)[:, None] * (normal - reflected)
            light = self.probe.look(position, leaning, roughness)
            return light * specular_visibility(visible, cosine, roughness, frontal)

        coat, base = surface.mirrored(cosine)
        light = base * lobe(surface.roughness, surface.frontal(cosine))
        if surface.coat.any():
            light += coat * lobe(surface.coat_roughness, np.full_like(surface.bare, surface.coat_frontal))
        diffuse = self._diffuse(uv, surface, 1 - coat - base)
        if surface.transmission.any():
            through = (surface.transmission * (1 - surface.metallic))[:, None] * (1 - coat - base)
            light += through * surface.colour * self._behind(surface, position, normal, viewer)
        alpha = 1 if self.alpha is None else bilinear(self.alpha, uv)
        return buffer.spread(diffuse + alpha * light)

    def _diffuse(self, uv: Floats, surface: _Surface, let_in: Floats) -> Floats:
        """The lightmap, a mean over viewers, made what the layers above it let out to this one."""
        if not self.diffuse.irradiance.any():
            return np.zeros_like(let_in)
        mean = np.zeros_like(let_in)
        for cosine in (np.arange(_STEPS) + 0.5) / _STEPS:
            coat, base = surface.mirrored(np.full(len(uv), cosine, dtype=np.float32))
            mean += (1 - coat - base) / _STEPS
        light: Floats = self.diffuse.look(uv) * let_in / np.maximum(mean, 1e-2)
        return light

    def _behind(self, surface: _Surface, position: Floats, normal: Floats, viewer: Floats) -> Floats:
        """The probe as it is seen through a ball of glass."""
        ratio = self.inputs.ior
        inner = _refracted(-viewer, normal, 1 / ratio)
        along = np.sum(normal * inner, axis=1, keepdims=True)
        left = position - self.size * along * inner
        back = along * inner - 0.5 * normal
        back /= np.maximum(np.linalg.norm(back, axis=1, keepdims=True), 1e-6)
        roughness = surface.roughness * np.float32(np.clip(2 * ratio - 2, 0, 1))
        return self.probe.look(left, _refracted(inner, back, ratio), roughness)

    @property
    def bytes(self) -> int:
        """All textures, compressed a byte a texel; occlusion and alpha take half a byte (BC4)."""
        maps = sum(texture_bytes(image) for image in self.inputs.textures)
        halves = [self.visibility] + ([] if self.alpha is None else [self.alpha])
        return self.probe.bytes + self.diffuse.bytes + maps + sum(map(texture_bytes, halves)) // 2


def _frontal(ior: float) -> float:
    return ((ior - 1) / (ior + 1)) ** 2


def _refracted(away: Floats, normal: Floats, ratio: float) -> Floats:
    """Directions (K, 3) refracted at a surface whose normal is against them, as GLSL's refract.

    What is reflected wholly goes along the surface.
    """
    along = np.sum(normal * away, axis=1, keepdims=True)
    root = np.sqrt(np.maximum(1 - ratio**2 * (1 - along**2), 0))
    direction: Floats = ratio * away - (ratio * along + root) * normal
    length = np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-6)
    return direction / length


def of_capture(captured: Captured) -> Baked:
    """The probe and lightmap of a stage that was captured with its inputs; its seconds left at 0.

    Its paths count the rays of ambient occlusion and of the inputs' textures, too.
    """
    capture, prepared = captured.capture, captured.prepared
    plan = capture.plan
    visibility = plan.placed(ambient_visibility(plan, prepared.surface.corner_position), gutter=True)
    assert captured.inputs is not None
    shader = _Shader(
        probe=Probe.of(capture.surroundings, plan.points),
        inputs=captured.inputs,
        diffuse=diffuse_map(capture, sample_weights(capture.light), captured.alpha is not None),
        visibility=visibility,
        size=2 * float(np.linalg.norm(plan.points - capture.surroundings.middle, axis=1).mean()),
        alpha=captured.alpha,
    )
    sides = " and ".join(", ".join(f"{value:.3f}" for value in row) for row in shader.probe.box.nearness)
    print(f"the box's sides are {sides} near", flush=True)
    paths = captured.paths + RAYS * len(plan.texel)
    return replace(captured.baked(shader.shade, 0), paths=paths, bytes=shader.bytes)


def make(texels: int, samples: int) -> OfCapture:
    """The probe and lightmap of a stage's single paths."""
    return OfCapture("probe", BakeSpec(texels=texels, samples=samples), of_capture, inputs=True)
