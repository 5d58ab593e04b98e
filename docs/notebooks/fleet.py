# %% [markdown]
# # A fleet
#
# The same question for many recordings, and the answer as one table. On many cores or a cluster `damper-estimator
# fleet` does this ([fleets](../fleet.md)); in a notebook a loop is enough for a few dozen. Three cars here; the last
# one has additional friction.

# %%
import numpy as np

import damper_estimator as de


def drive(seed, friction):
    """Ten seconds of a damper of 1500 N s/m with some friction, in N."""
    draw = np.random.default_rng(seed)
    time = np.arange(0.0, 10.0, 0.005)
    frequencies = draw.uniform(0.5, 6.0, 6)
    phases = draw.uniform(0.0, 6.0, 6)
    waves = zip(frequencies, phases, strict=True)
    displacement = sum(0.008 / f * np.sin(2.0 * np.pi * f * time + phase) for f, phase in waves)
    velocity = np.gradient(displacement, time)
    force = 1500.0 * velocity + friction * np.tanh(velocity / 0.01) + draw.normal(0.0, 3.0, time.size)
    return de.Recording.from_arrays(time, displacement, force=force)


fleet = {"car_1": drive(1, 20.0), "car_2": drive(2, 20.0), "car_3": drive(3, 80.0)}

# %% [markdown]
# One model, identified on the first car when it was new:

# %%
model = de.fit(drive(0, 20.0), "dahl").model

# %%
errors = {car: de.compare(recording, model).rmse_n for car, recording in fleet.items()}
for car, error in errors.items():
    print(f"{car}: {error:5.1f} N {'#' * round(error)}")

# %% [markdown]
# The outlier and its new parameters: the friction has increased several times.

# %%
outlier = max(errors, key=errors.get)
again = de.fit(fleet[outlier], model)
for before, after in zip(model.slots, again.model.slots, strict=True):
    print(f"{outlier} {before.address}: {before.value:.0f} -> {after.value:.0f} {before.parameter.unit}")
