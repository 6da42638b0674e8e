"""What only the X server can do to the windows of a display: through Xlib."""

from __future__ import annotations

import ctypes
import time


class KeyEvent(ctypes.Structure):
    """`XKeyEvent` of Xlib, padded to the size of `XEvent`."""

    _fields_ = (
        ("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("root", ctypes.c_ulong),
        ("subwindow", ctypes.c_ulong), ("time", ctypes.c_ulong), ("x", ctypes.c_int),
        ("y", ctypes.c_int), ("x_root", ctypes.c_int), ("y_root", ctypes.c_int),
        ("state", ctypes.c_uint), ("keycode", ctypes.c_uint), ("same_screen", ctypes.c_int),
        ("padding", ctypes.c_long * 24),
    )  # fmt: skip


def press_escape() -> None:
    """Press Escape by the X server: Blender's simulated events do not break a render.

    With the time [ms]: Blender takes a press at the time of the last release for one of a key
    that is held down, and those do not break it.
    """
    now = int(1000 * time.monotonic())
    x, display, root, windows = _open()
    escape = x.XKeysymToKeycode(display, ctypes.c_ulong(0xFF1B))
    for window in windows:
        for kind, mask in ((2, 1), (3, 2)):
            event = KeyEvent(
                type=kind, display=display, window=window, root=root, keycode=escape,
                time=now + kind, same_screen=1,
            )  # fmt: skip
            x.XSendEvent(
                display, ctypes.c_ulong(window), 1, ctypes.c_long(mask), ctypes.byref(event)
            )
    _close(x, display)


def resize_windows(width: int, height: int) -> None:
    """Give every window another size, as its border would when it is pulled."""
    x, display, _, windows = _open()
    for window in windows:
        x.XResizeWindow(display, ctypes.c_ulong(window), width, height)
    _close(x, display)


def _open() -> tuple[ctypes.CDLL, ctypes.c_void_p, int, list[int]]:
    """Xlib, the display, its root and the windows on it."""
    x = ctypes.CDLL("libX11.so.6")
    x.XOpenDisplay.restype, x.XDefaultRootWindow.restype = ctypes.c_void_p, ctypes.c_ulong
    display = ctypes.c_void_p(x.XOpenDisplay(None))
    root = x.XDefaultRootWindow(display)
    found, children = (ctypes.c_ulong * 2)(), ctypes.POINTER(ctypes.c_ulong)()
    count = ctypes.c_uint()
    second = ctypes.byref(found, ctypes.sizeof(ctypes.c_ulong))
    x.XQueryTree(
        display, ctypes.c_ulong(root), found, second, ctypes.byref(children),
        ctypes.byref(count),
    )  # fmt: skip
    return x, display, root, list(children[: count.value])


def _close(x: ctypes.CDLL, display: ctypes.c_void_p) -> None:
    x.XFlush(display)
    x.XCloseDisplay(display)
