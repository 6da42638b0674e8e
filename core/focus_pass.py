"""The pilot that finds where photons crowd (``photons.focus``)."""

from __future__ import annotations

from typing import NamedTuple

from .photon_pass import Batch, trace_batch
from .photons.focus import Focus, find_focus
from .photons.trace import Walk
from .pilot import CROWD, PILOT_PASS
from .plan import Plan, Stage
from .prepared import Prepared
from .settings import Settings
from .steps import Steps


class Crowds(NamedTuple):
    """The places where photons crowd, and ``walks`` of the pilot that are as they were.

    None are where there is such a place, as photons are shared out there.
    """

    focus: Focus
    walks: dict[Batch, Walk]


def focus_of(prepared: Prepared, settings: Settings, caustics: bool) -> Steps[Crowds]:
    """The places where photons crowd, by ``CROWD`` paths of each kind.

    ``caustics``: whether there will be caustic photons. The camera plays no part, so that
    photons serve whatever it sees.
    """
    kinds = (True, False) if caustics else (False,)
    batches = [Batch(caustic, 0, CROWD, CROWD) for caustic in kinds]
    walks: list[Walk] = yield [
        (trace_batch, prepared, settings, PILOT_PASS, batch) for batch in batches
    ]
    focus = find_focus(walks[-1], walks[0] if caustics else None, settings.photon_depth)
    return Crowds(focus, {} if focus.found else dict(zip(batches, walks, strict=True)))


def wants_focus(settings: Settings, plan: Plan) -> bool:
    """Whether to look for crowded places: where gather rays and photons meet at all."""
    return settings.focus and not settings.draft and plan.is_on("indirect")


def with_focus_stage(plan: Plan, focus: Focus) -> Plan:
    """``plan`` with the line that tells what was found."""
    count = focus.found
    reason = "no place so bright that gather rays seldom meet it"
    if count:
        reason = f"photons bring the light of {count} small bright places"
    return plan._replace(stages=(*plan.stages, Stage("focus", count > 0, reason)))
