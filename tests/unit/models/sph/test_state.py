"""What a problem knows of its effects."""

from dataclasses import replace

import numpy as np

from astroinertia.effects.catalogue import build
from tests.ball import ball, state_of


def test_pair_terms_are_gathered_once_and_are_those_of_the_effects_that_there_are() -> None:
    """Every end of an interval asks for them several times."""
    problem = state_of(build("pressure", {}), position=ball(20), velocity=np.zeros((len(ball(20)), 3)))[0]
    terms = problem.terms("neighbour_terms")
    assert terms and terms == build("pressure", {}).neighbour_terms
    assert problem.terms("neighbour_terms") is terms
    assert replace(problem, effects=()).terms("neighbour_terms") == ()
