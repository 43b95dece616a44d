"""When a computation stops, and which methods it uses."""
from __future__ import annotations

import dataclasses
from typing import Any

from lucerna._errors import invalid
from lucerna.v1 import accuracy_pb2

_METHODS = ("area_sampling", "light_selection", "sampler", "combination", "closed_forms", "visibility", "thin_glass")


def enum_value(field: str, enum: Any, word: str) -> int:
    """The number of an enum's value by its name without the prefix, such as "bvh" for LIGHT_SELECTION_BVH.

    Raises InvalidArgument with the allowed words for another word.
    """
    names: list[str] = list(enum.DESCRIPTOR.values_by_name)
    prefix = names[0].removesuffix("UNSPECIFIED")
    words = {name.removeprefix(prefix).lower(): name for name in names[1:]}
    try:
        return int(enum.Value(words[str(word).lower().replace("-", "_")]))
    except KeyError:
        raise invalid(field, f"is {word!r}, allowed: {', '.join(sorted(words))}") from None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Accuracy:
    """When a computation stops, and which methods it uses (docs/accuracy.md).

    Set at most one of `samples`, `error` and `budget_s`.  If none is set, the default of the call applies.  None
    leaves a setting to the server.  The words of methods are those of the contract without their prefix, such as
    "bvh".  Errors: InvalidArgument for a word that is not allowed; the server checks the numbers.
    """

    samples: int | None = None  #: number for each item or pixel, at least 1
    error: float | None = None  #: target error relative to the estimate, above 0; 0.01 is one percent
    budget_s: float | None = None  #: wall time for all items together [s], above 0
    floor: float = 0.0  #: with `error`: the error need not be smaller than this, in the unit of the answer
    confidence: float | None = None  #: with `error`: of the target and of intervals, in (0, 1); default 0.95
    max_samples: int | None = None  #: with `error`: the most samples for each item, at least 64; default 65536
    area_sampling: str | None = None  #: how points on area lights are chosen
    light_selection: str | None = None  #: how a light is chosen: all, uniform, power or bvh
    samples_per_light: int | None = None  #: points that every sample takes on its light, 1 to 1024
    far_light_radii: float | None = None  #: beyond this many radii an area light counts as a point, above 0
    sampler: str | None = None  #: sobol or independent
    combination: str | None = None  #: power_heuristic, balance_heuristic, lights or surfaces
    closed_forms: str | None = None  #: off or empty_shafts
    visibility: str | None = None  #: rays or shadow_maps
    thin_glass: str | None = None  #: passes or blocks

    def message(self) -> accuracy_pb2.Accuracy:
        """The message of the contract."""
        given = [n for n in ("samples", "error", "budget_s") if getattr(self, n) is not None]
        if len(given) > 1:
            raise invalid(given[1], f"is set beside {given[0]}, allowed: one of samples, error and budget_s")
        if self.error is None and (self.floor or self.confidence is not None or self.max_samples is not None):
            raise invalid("error", "is not set, required with floor, confidence and max_samples")
        message = accuracy_pb2.Accuracy()
        try:
            if self.samples is not None:
                message.samples = self.samples
            if self.budget_s is not None:
                message.time_budget_s = self.budget_s
            if self.error is not None:
                message.target_error.relative = self.error
                message.target_error.absolute_floor = self.floor
                if self.confidence is not None:
                    message.target_error.confidence = self.confidence
                if self.max_samples is not None:
                    message.target_error.max_samples = self.max_samples
            if self.samples_per_light is not None:
                message.samples_per_light = self.samples_per_light
            if self.far_light_radii is not None:
                message.far_light_radii = self.far_light_radii
        except (TypeError, ValueError) as error:  # a number of another type, or one that does not fit its field
            raise invalid("accuracy", str(error)) from None
        for method in _METHODS:
            word = getattr(self, method)
            if word is not None:
                enum = getattr(accuracy_pb2, method.title().replace("_", ""))
                setattr(message, method, enum_value(method, enum, word))
        return message


def accuracy_of(accuracy: Accuracy | None, samples: int | None, error: float | None,
                budget_s: float | None) -> accuracy_pb2.Accuracy:
    """The message of an Accuracy, or of the three short arguments that most methods have."""
    given = {k: v for k, v in (("samples", samples), ("error", error), ("budget_s", budget_s)) if v is not None}
    if accuracy is None:
        return Accuracy(**given).message()  # type: ignore[arg-type]
    return dataclasses.replace(accuracy, **given).message()
