"""Balanced mechanisms: balancing conditions, designs, torques, reactions and shaking forces.

    import balance_mechanisms as bm

    spec = bm.load("3rrr.yaml", set={"l": 0.2})
    run = spec.simulate("cycloid")
    print(run.metrics["shaking_force"].peak)

SI units, world axes. docs/python.md describes the module, docs/spec.md the language of specs.
"""

from balance_mechanisms import _native
from balance_mechanisms._reports import (Answer, Batch, Channel, ChannelSeries, Check, Comparison, Condition, Conditions, Design,
                                         Equations, Formula, Front, Identification, Modes, Tolerance)
from balance_mechanisms._errors import MechanismError, MotionError, SpecError
from balance_mechanisms._files import Exported, batch, compare, export, import_, kinds, new, parts, read
from balance_mechanisms._imported import Imported
from balance_mechanisms._mechanism import InverseDynamics, Mechanism
from balance_mechanisms._model_file import ModelFile
from balance_mechanisms._run import AdaptationMove, Metric, PayloadChange, Quantity, Run
from balance_mechanisms._spec import Spec, load

__version__: str = _native.version
GOALS = tuple(_native.goal_names)

__all__ = ["GOALS", "AdaptationMove", "Answer", "Batch", "Channel", "ChannelSeries", "Check", "Comparison", "Condition", "Conditions", "Design",
           "Equations", "Exported", "Formula", "Front", "Identification", "Imported", "InverseDynamics", "Mechanism", "MechanismError",
           "Metric", "ModelFile", "Modes", "MotionError", "PayloadChange", "Quantity", "Run", "Spec", "SpecError", "Tolerance", "batch", "compare",
           "export", "import_", "kinds", "load", "new", "parts", "read"]
