"""What effects that exchange heat with the surroundings share."""


def changing_time(xp, h, energy, gain, decay):
    """u/|du/dt| of matter that cools; of matter that is heated, the time in which that moves it by h, besides."""
    rate = gain - decay * energy
    size = xp.maximum(xp.abs(rate), 1e-100)
    spread = xp.where(rate > 0.0, xp.power(h * h / size, 1.0 / 3.0), 0.0)
    return (energy / size + spread,)
