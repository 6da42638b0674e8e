"""Looks up images by the coordinates of a hit, texel for texel as Cycles does.

Texel (i, j) covers [i, i + 1] x [j, j + 1] of the image scaled to its size in texels, its
value stands at the middle. Linear interpolation works on the numbers as they are stored;
sRGB is decoded, and alpha divided out, afterwards.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector
from ..jit import Row, Table, kernel
from ..scene.tables import Channel, Extension, ImageKind

Color4 = tuple[float, float, float, float]

_EXTEND = int(Extension.EXTEND)
_CLIP = int(Extension.CLIP)
_MIRROR = int(Extension.MIRROR)
_SRGB_BYTES = int(ImageKind.SRGB_BYTES)
_FLOATS = int(ImageKind.FLOATS)
_SRGB_FLOATS = int(ImageKind.SRGB_FLOATS)
_COLOR = int(Channel.COLOR)
_ALPHA = int(Channel.ALPHA)
_RED = int(Channel.RED)
_GREEN = int(Channel.GREEN)
_BLUE = int(Channel.BLUE)

#: Beyond this many images' widths a coordinate has no fraction left that could matter;
#: it is the origin then, and so is NaN.
_FARTHEST = 1e9


@kernel
def uv_at(uvs: Table, layer: int, face: int, u: float, v: float) -> tuple[float, float]:
    """Coordinates of set ``layer`` at barycentrics (u, v); (0, 0) when there is no such set."""
    if layer < 0 or layer >= uvs.shape[0]:
        return 0.0, 0.0
    w = 1.0 - u - v
    corners = uvs[layer, face]
    s = w * corners[0, 0] + u * corners[1, 0] + v * corners[2, 0]
    t = w * corners[0, 1] + u * corners[1, 1] + v * corners[2, 1]
    return s, t


@kernel
def wrap(i: int, size: int, extension: int) -> int:
    """The texel shown at place ``i`` of a row of ``size``; -1: none, transparent black."""
    if extension == _EXTEND:
        return min(max(i, 0), size - 1)
    if extension == _CLIP:
        return i if 0 <= i < size else -1
    if extension == _MIRROR:
        i = i % (2 * size)
        return i if i < size else 2 * size - 1 - i
    return i % size


@kernel
def texel(image: Row, texels8: Table, texels32: Table, i: int, j: int) -> Color4:
    """What is stored for texel (i, j), bytes as 0..1; transparent black for -1."""
    if i < 0 or j < 0:
        return (0.0, 0.0, 0.0, 0.0)
    at = image.start + j * image.width + i
    if image.kind == _FLOATS or image.kind == _SRGB_FLOATS:
        return (
            float(texels32[at, 0]),
            float(texels32[at, 1]),
            float(texels32[at, 2]),
            float(texels32[at, 3]),
        )
    return (
        texels8[at, 0] / 255.0,
        texels8[at, 1] / 255.0,
        texels8[at, 2] / 255.0,
        texels8[at, 3] / 255.0,
    )


@kernel
def srgb_to_linear(c: float) -> float:
    """Decoded sRGB component (IEC 61966-2-1); 0 below 0."""
    if c < 0.04045:
        return max(c, 0.0) / 12.92
    return float(((c + 0.055) / 1.055) ** 2.4)


@kernel
def _mixed(a: Color4, b: Color4, t: float) -> Color4:
    s = 1.0 - t
    return (
        s * a[0] + t * b[0],
        s * a[1] + t * b[1],
        s * a[2] + t * b[2],
        s * a[3] + t * b[3],
    )


@kernel
def _stored_at(
    texture: Row, image: Row, texels8: Table, texels32: Table, s: float, t: float
) -> Color4:
    """The interpolated texels at (s, t) of the image's unit square."""
    x, y = s * image.width, t * image.height
    width, height, extension = image.width, image.height, texture.extension
    if texture.interpolation == 1:
        i = wrap(int(math.floor(x)), width, extension)
        j = wrap(int(math.floor(y)), height, extension)
        return texel(image, texels8, texels32, i, j)
    x -= 0.5
    y -= 0.5
    left, low = math.floor(x), math.floor(y)
    i0, i1 = wrap(int(left), width, extension), wrap(int(left) + 1, width, extension)
    j0, j1 = wrap(int(low), height, extension), wrap(int(low) + 1, height, extension)
    lower = _mixed(
        texel(image, texels8, texels32, i0, j0),
        texel(image, texels8, texels32, i1, j0),
        x - left,
    )
    upper = _mixed(
        texel(image, texels8, texels32, i0, j1),
        texel(image, texels8, texels32, i1, j1),
        x - left,
    )
    return _mixed(lower, upper, y - low)


@kernel
def sample_uv(shading: Row, texture_id: int, s: float, t: float) -> Color4:
    """Scene-linear colour and alpha of a texture at the coordinates (s, t) of its set."""
    texture = shading.textures[texture_id]
    image = shading.images[texture.image]
    m = texture.to_image
    x = m[0, 0] * s + m[0, 1] * t + m[0, 2]
    y = m[1, 0] * s + m[1, 1] * t + m[1, 2]
    if not (abs(x) < _FARTHEST and abs(y) < _FARTHEST):
        x, y = 0.0, 0.0
    r, g, b, a = _stored_at(texture, image, shading.texels8, shading.texels32, x, y)
    if texture.unassociate and a != 0.0 and a != 1.0:
        r, g, b = r / a, g / a, b / a
    if image.kind == _SRGB_BYTES or image.kind == _SRGB_FLOATS:
        r, g, b = srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b)
    return r, g, b, a


@kernel
def sample_texture(shading: Row, texture_id: int, face: int, u: float, v: float) -> Color4:
    """Scene-linear colour and alpha (r, g, b, a) of a texture at a hit.

    ``u``, ``v``: barycentrics of the hit, as Embree gives them.
    """
    s, t = uv_at(shading.uvs, shading.textures[texture_id].uv, face, u, v)
    return sample_uv(shading, texture_id, s, t)


@kernel
def luminance(r: float, g: float, b: float) -> float:
    """The number that Blender makes of a colour: its luminance in linear Rec. 709."""
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@kernel
def _channel(color: Color4, channel: int) -> float:
    """One number of a colour; its luminance for the channels that are none by themselves."""
    if channel == _ALPHA:
        return color[3]
    if channel == _RED:
        return color[0]
    if channel == _GREEN:
        return color[1]
    if channel == _BLUE:
        return color[2]
    return luminance(color[0], color[1], color[2])


@kernel
def param_color(shading: Row, param: Row, face: int, u: float, v: float) -> Vector:
    """The colour of a ``tables.PARAM`` at a hit: its value times its texture."""
    value = (param.value[0], param.value[1], param.value[2])
    if param.texture < 0:
        return value
    color = sample_texture(shading, param.texture, face, u, v)
    if param.channel == _COLOR:
        return (value[0] * color[0], value[1] * color[1], value[2] * color[2])
    number = _channel(color, param.channel)
    return (value[0] * number, value[1] * number, value[2] * number)


@kernel
def param_number(shading: Row, param: Row, face: int, u: float, v: float) -> float:
    """The number of a ``tables.PARAM`` at a hit: ``value[0]`` times its texture's number."""
    if param.texture < 0:
        return float(param.value[0])
    color = sample_texture(shading, param.texture, face, u, v)
    return float(param.value[0]) * _channel(color, param.channel)
