# %% [markdown]
# # A magneto-rheological damper with changing current
#
# A simulated damper whose yield force follows the coil's current with a lag; random motion while the
# current steps from 0 to 2 A.

# %%
import numpy as np

import damper_estimator as de
from damper_estimator.share import share_path

bags = share_path("bags")
bench = de.read(bags / "semi_active_random.mcap", start=0, stop=20)
road = de.read(bags / "semi_active_road.mcap", start=0, stop=20)

# %% [markdown]
# A model without current, and one with it:

# %%
blind = de.fit(bench, "linear_viscous").model
fitted = de.fit(bench, "semi_active_yield")
for model in (blind, fitted.model):
    print(f"{model.name}: {de.compare(road, model).rmse_n:.0f} N on the road")

# %% [markdown]
# Values with their standard errors; the coil has a lag of about 20 ms.

# %%
for p in fitted.parameters:
    print(f"{p.name} = {p.value:.4g} +- {p.standard_error:.2g} {p.unit}")

# %% [markdown]
# The inverse: which current gives 800 N in 30 ms, while the damper extends at 0.2 m/s? One column of kinematics is one
# sample.

# %%
from damper_estimator.control import InverseModel
from damper_estimator.signals.layout import COMMAND, DT, ROWS, V

inverse = InverseModel(fitted.model, (0.0, 2.0))
sample = np.zeros(ROWS)
sample[V], sample[DT], sample[COMMAND] = 0.2, 0.002, 0.5
answer = inverse.solve(sample, wanted=800.0)
print(f"{answer.current:.2f} A; from {answer.force_min:.0f} to {answer.force_max:.0f} N can be reached")
