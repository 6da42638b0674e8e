"""Denoising by the Open Image Denoise that Blender brings along, with caustics kept sharp.

Blender's Python cannot reach it, but its library is loaded in Blender's process, and its C
interface is a public and stable one. It works with and without a window. Blenders that were
built without it (those of Debian) render as if denoising were off, and say so.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..core import Film

#: Layers that guide the denoiser, to be rendered beside the light.
GUIDES = ("end_albedo", "end_normal")

_CPU, _FLOAT3 = 1, 3
#: Names that the library goes by, where it is loaded already.
_NAMES = {
    "linux": ("libOpenImageDenoise.so.2",),
    "darwin": ("libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"),
    "win32": ("OpenImageDenoise.dll",),
}


class DenoiseError(RuntimeError):
    """There is no denoiser, or it failed; the message says which."""


def denoise(film: Film, threads: int) -> NDArray[np.float32]:
    """The layer "combined" (h, w, 4) without its noise but for that of the caustics.

    Caustics are told from noise by nothing but their photons, so they are taken out before
    and put back. Raises ``DenoiseError``.
    """
    combined = film.resolve("combined")
    caustics = film.resolve("caustics")
    guides = {"albedo": film.resolve(GUIDES[0]), "normal": film.resolve(GUIDES[1])}
    images = {"color": np.maximum(combined[..., :3] - caustics, 0.0), **guides}
    combined[..., :3] = _filtered(_library(), images, threads) + caustics
    return combined


def is_available() -> bool:
    """Whether this Blender has the denoiser."""
    try:
        _library()
    except DenoiseError:
        return False
    return True


def _library() -> Any:
    """The library with its functions' types; raises ``DenoiseError``."""
    for name in _NAMES.get(sys.platform, ()):
        folder = Path(bpy.app.binary_path).parent
        beside = (folder, folder / "lib", folder.parent / "Resources" / "lib")
        for path in (name, *(str(folder / name) for folder in beside)):
            try:
                library = ctypes.CDLL(path)
            except OSError:
                continue
            if hasattr(library, "oidnSetSharedFilterImage"):
                return _typed(library)
    raise DenoiseError("this Blender was built without Open Image Denoise")


def _typed(library: Any) -> Any:
    pointer, text, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
    functions: dict[str, tuple[Any, list[Any]]] = {
        "oidnNewDevice": (pointer, [ctypes.c_int]),
        "oidnSetDeviceInt": (None, [pointer, text, ctypes.c_int]),
        "oidnCommitDevice": (None, [pointer]),
        "oidnReleaseDevice": (None, [pointer]),
        "oidnGetDeviceError": (ctypes.c_int, [pointer, ctypes.POINTER(text)]),
        "oidnNewFilter": (pointer, [pointer, text]),
        "oidnSetFilterBool": (None, [pointer, text, ctypes.c_bool]),
        "oidnSetSharedFilterImage": (
            None, [pointer, text, pointer, ctypes.c_int, size, size, size, size, size],
        ),
        "oidnCommitFilter": (None, [pointer]),
        "oidnExecuteFilter": (None, [pointer]),
        "oidnReleaseFilter": (None, [pointer]),
    }  # fmt: skip
    for name, (result, arguments) in functions.items():
        function = getattr(library, name, None)
        if function is None:
            raise DenoiseError(
                f"this Blender's Open Image Denoise is too old: it has no {name}"
            )
        function.restype, function.argtypes = result, arguments
    return library


def _filtered(
    library: Any, images: dict[str, NDArray[np.float32]], threads: int
) -> NDArray[np.float32]:
    """``images["color"]`` (h, w, 3) without noise, guided by the others.

    Those are rid of their own noise first: behind glass they have some, which would stay.
    """
    device = library.oidnNewDevice(_CPU)
    if not device:
        raise DenoiseError("Open Image Denoise does not start on this processor")
    try:
        library.oidnSetDeviceInt(device, b"numThreads", threads)
        library.oidnCommitDevice(device)
        clean = {
            name: _run(library, device, {name: image}, {})
            for name, image in images.items()
            if name != "color"
        }
        flags = {"hdr": True, "cleanAux": True}
        return _run(library, device, {"color": images["color"], **clean}, flags)
    finally:
        library.oidnReleaseDevice(device)


def _run(
    library: Any, device: Any, images: dict[str, NDArray[np.float32]], flags: dict[str, bool]
) -> NDArray[np.float32]:
    """One filter over ``images``; the first of them is the one that comes out."""
    output = np.zeros_like(next(iter(images.values())), dtype=np.float32)
    # Kept until the end: the library reads and writes them in place.
    arrays = {k: np.ascontiguousarray(v, dtype=np.float32) for k, v in images.items()}
    arrays["output"] = output
    height, width = output.shape[:2]
    ray_tracing = library.oidnNewFilter(device, b"RT")
    try:
        for name, array in arrays.items():
            library.oidnSetSharedFilterImage(
                ray_tracing, name.encode(), array.ctypes.data, _FLOAT3, width, height, 0, 0, 0
            )
        for name, flag in flags.items():
            library.oidnSetFilterBool(ray_tracing, name.encode(), flag)
        library.oidnCommitFilter(ray_tracing)
        library.oidnExecuteFilter(ray_tracing)
        words = ctypes.c_char_p()
        if library.oidnGetDeviceError(device, ctypes.byref(words)) != 0:
            raise DenoiseError((words.value or b"it failed").decode(errors="replace"))
        return output
    finally:
        library.oidnReleaseFilter(ray_tracing)
