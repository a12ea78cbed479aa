"""What functions that run a scene take beside it: what is of a wrong type is refused before any work.

Test: tests/unit/test_wrong_inputs.py.
"""

from numbers import Integral
from typing import Any

from astroinertia.errors import SceneError


def refuse_wrong(listener: Any, workers: Any, cluster: Any, effects: Any, observables: Any) -> None:
    """SceneError names the first of these arguments that is of a wrong type."""
    if not (listener is None or callable(listener)):
        raise SceneError(f"listener must be a function of the progress, not {listener!r:.60}.")
    if not isinstance(workers, Integral) or isinstance(workers, bool) or workers < 1:
        raise SceneError(f"workers must be a whole number of at least 1, not {workers!r:.60}.")
    if not (cluster is None or isinstance(cluster, str)):
        raise SceneError(f"cluster must be the address of a cluster, such as tcp://host:8786, not {cluster!r:.60}.")
    for name, own in (("effects", effects), ("observables", observables)):
        if not isinstance(own, list | tuple):
            raise SceneError(f"{name} must be a list, not {own!r:.60}.")


def refuse_wrong_names(of: Any, by: Any) -> None:
    """SceneError unless `of` is the name of a series and `by` a list of keys."""
    if not isinstance(of, str):
        raise SceneError(f"of must name a series, such as inertia_tensor.zz@end, not {of!r:.60}.")
    if not isinstance(by, list | tuple) or not by or not all(isinstance(key, str) for key in by):
        raise SceneError(f"by must be a list of keys of the scene, such as ['body.rotation.period'], not {by!r:.60}.")
