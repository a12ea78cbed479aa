"""Bodies of uniform density in a scene."""

from typing import Any, ClassVar, Literal

from astroinertia.scene.body_kinds.stretched import Sized, profiles


class UniformBody(Sized):
    """A sphere or ellipsoid of uniform density."""

    kind: Literal["uniform"]
    rank: ClassVar[int] = 3
    has_core: ClassVar[bool] = True

    @property
    def homogeneous(self) -> bool:
        """It is."""
        return True

    def profile(self) -> Any:
        """Of one density."""
        return profiles().uniform()
