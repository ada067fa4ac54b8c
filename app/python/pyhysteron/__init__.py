"""Digital twin and controller for tendon-driven continuum robots, and dynamics of servo-driven arms.

Classes hold a robot, its twin, a recording or an arm; every verb of the program is a function with the same options, which
returns its outcome. All numbers are SI: m, N, s, rad; arguments that are not carry their unit in the name.

    import numpy as np
    import pyhysteron as ph

    twin = ph.Twin(ph.Scene.embedded())
    report = twin.step([1e-3, 0.0, -1e-3, 0.0])
    print(report.tip)
"""

from __future__ import annotations

from . import arm, outcomes, rig, shards, study
from ._errors import BadInput, Cancelled, Error, Failed
from ._pyhysteron import (
    COMMIT,
    Arm,
    ReachReport,
    Recording,
    Scene,
    StepReport,
    Twin,
    TwinState,
    __version__,
)
from ._verbs import (
    adapt,
    check,
    command,
    demo,
    evaluate,
    fit_material,
    fit_residual,
    fit_sensor,
    generate,
    identify,
    identify_servo,
    import_,
    mesh,
    reach,
    record,
    reduce,
    sense,
    simulate,
    target,
    track,
    train,
)

__all__ = [
    "COMMIT",
    "Arm",
    "BadInput",
    "Cancelled",
    "Error",
    "Failed",
    "ReachReport",
    "Recording",
    "Scene",
    "StepReport",
    "Twin",
    "TwinState",
    "__version__",
    "adapt",
    "arm",
    "check",
    "command",
    "demo",
    "evaluate",
    "fit_material",
    "fit_residual",
    "fit_sensor",
    "generate",
    "identify",
    "identify_servo",
    "import_",
    "mesh",
    "outcomes",
    "reach",
    "record",
    "reduce",
    "rig",
    "sense",
    "shards",
    "simulate",
    "study",
    "target",
    "track",
    "train",
]
