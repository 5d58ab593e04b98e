# %% [markdown]
# # The hidden effect, from Python
#
# [The walkthrough](../hidden_effect.md) in ten lines: a model that was accurate, a damper that has changed, and the
# change.

# %%
import damper_estimator as de
from damper_estimator.share import share_path

bags = share_path("bags")  # the recordings that come with the project
base, now = (de.read(bags / f"hidden_{name}.mcap", start=0, stop=20) for name in ("base", "fit"))
road = de.read(bags / "hidden_unseen.mcap")

# %% [markdown]
# A force-velocity curve, identified on the original damper. On the road, months later, it is wrong:

# %%
model = de.fit(base, "viscous_curve").model
before = de.compare(road, model)
print(f"{before.rmse_n:.1f} N rms error, of which {before.noise_floor_n:.1f} N are noise")
before.regions[0].where

# %% [markdown]
# What is missing? Identified on the bench recording of the changed damper, judged on the road, which no parameter is
# fitted to.

# %%
found = de.diagnose(now, model, validate=road)
print(found.sentence)
for finding in found.findings:
    print(f"{finding.phenomenon}, tied with {finding.tied_with}: {finding.evidence}")

# %% [markdown]
# `found.improved` has the findings of the diagnosis; `de.improve` continues as long as unseen data justify it.

# %%
after = de.compare(road, found.improved)
print(f"{before.rmse_n:.1f} N -> {after.rmse_n:.1f} N")
after.figure()
