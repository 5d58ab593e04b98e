# %% [markdown]
# # A bench file
#
# A dynamometer's text file becomes a recording, a recording a model. The file is written here, so that the notebook
# runs anywhere: a damper of 1500 N s/m with 60 N of friction, driven by a sum of five sines.

# %%
import tempfile
from pathlib import Path

import numpy as np

folder = Path(tempfile.mkdtemp())
time = np.arange(0.0, 20.0, 0.005)
frequencies = np.array([0.7, 1.3, 2.1, 3.7, 5.9])
travel = sum(10.0 / f * np.sin(2.0 * np.pi * f * time + f) for f in frequencies)  # mm
velocity = np.gradient(travel * 1e-3, time)
load = 1500.0 * velocity + 60.0 * np.tanh(velocity / 0.01) + np.random.default_rng(1).normal(0.0, 3.0, time.size)
table = np.column_stack([time, travel, load])
np.savetxt(folder / "run.csv", table, delimiter=",", header="Time,Travel,Load", comments="", fmt="%.6f")

# %% [markdown]
# A column map states quantity and unit of each column.

# %%
(folder / "columns.yaml").write_text("""
time: {column: Time, unit: s}
dampers:
  front_left:
    displacement: {column: Travel, unit: mm}
    force: {column: Load, unit: N}
""")

# %%
import damper_estimator as de

recording = de.read(folder / "run.csv", columns=folder / "columns.yaml")
recording

# %% [markdown]
# First a straight line, and its missing effects. 40 % of the recording are reserved for judging.

# %%
line = de.fit(recording, "linear_viscous")
found = de.diagnose(recording, line.model)
print(found.sentence)

# %%
better = de.improve(recording, line.model)
for step in better.steps:
    print(f"{step.action} {step.effect or ''}: {step.rmse_unseen_n:.1f} N unseen")
better.save(folder / "mine.yaml")

# %% [markdown]
# The friction was 60 N:

# %%
{slot.address: round(slot.value, 1) for slot in better.model.slots}
