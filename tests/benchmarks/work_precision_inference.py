"""Error against time of posteriors of interiors, and of the polytropic index of a moment ratio.

The posterior of Mars's core in three layers is compared with exact inversion of two million draws from the errors: its
error is that of the 16th, 50th and 84th percentile of the core radius together, in standard deviations.
"""

import numpy as np
from precision_table import publish, table

from astroinertia.bodies.planets import body
from astroinertia.studies.core_inversion import DRAWS, core_inversion
from astroinertia.studies.interior_inference import infer_body

SHARES = (0.16, 0.84)
EXACT_DRAWS = 2_000_000


def main() -> None:
    """Print the tables."""
    one = body("Mars")
    exact = core_inversion(one, draws=EXACT_DRAWS)
    ends = np.array([exact.core_radius_low, exact.core_radius_high])
    width = (ends[1] - ends[0]) / 2

    def error_of_posterior(posterior) -> float:
        found = np.quantile(posterior["core_radius"].values, SHARES)
        return float(np.sqrt(np.mean(((found - ends) / width) ** 2)))

    def error_of_draws(found) -> float:
        return float(
            np.sqrt(np.mean(((np.array([found.core_radius_low, found.core_radius_high]) - ends) / width) ** 2))
        )

    publish(
        "inference",
        [
            table(
                "Posterior of Mars's core in three layers by sampling (4 chains of 32 walkers)",
                "draws",
                (250, 500, 1000, 2000),
                lambda draws: infer_body("Mars", draws=draws),
                error_of_posterior,
                2000,
            ),
            table(
                "The same by exact inversion of draws from the errors",
                "draws",
                (200, 2000, DRAWS, 200_000),
                lambda draws: core_inversion(one, draws=draws),
                error_of_draws,
                DRAWS,
            ),
        ],
    )


if __name__ == "__main__":
    main()
