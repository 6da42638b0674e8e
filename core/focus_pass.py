"""The pilot that finds where photons crowd (``photons.focus``)."""

from __future__ import annotations

from .photon_pass import Batch, trace_batch
from .photons.focus import Focus, find_focus
from .photons.trace import Walk
from .pilot import CROWD, PILOT_PASS
from .plan import Plan, Stage
from .prepared import Prepared
from .settings import Settings
from .steps import Steps


def focus_of(prepared: Prepared, settings: Settings, caustics: bool) -> Steps[Focus]:
    """The places where photons crowd, by ``CROWD`` paths of each kind.

    ``caustics``: whether there will be caustic photons. The camera plays no part, so that
    photons serve whatever it sees.
    """
    kinds = (True, False) if caustics else (False,)
    walks: list[Walk] = yield [
        (trace_batch, prepared, settings, PILOT_PASS, Batch(caustic, 0, CROWD, CROWD))
        for caustic in kinds
    ]
    return find_focus(walks[-1], walks[0] if caustics else None, settings.photon_depth)


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
