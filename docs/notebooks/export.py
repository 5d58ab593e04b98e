# %% [markdown]
# # Export and co-simulation
#
# The model as C99 for a control unit, as an FMU for a simulation, and a simulation that steps it.
# [Export](../export.md) has the rules.

# %%
import tempfile
from pathlib import Path

import numpy as np

import damper_estimator as de

folder = Path(tempfile.mkdtemp())
model = de.load_model("carrera_akutain")

# %%
written = model.to_c(folder, name="front_left")
print(written.header.name, written.source.name, f"{written.ram} bytes of state")

# %% [markdown]
# The same as an FMU. Without a C compiler `binary=False` writes the sources, which the importing program compiles.

# %%
from damper_estimator.codegen.build import find_compiler

binary = find_compiler() is not None
model.to_fmu(folder / "front_left.fmu", name="front_left", binary=binary)

# %% [markdown]
# A master steps the FMU at 1 kHz through a sine of 20 mm at 2 Hz; the Python line processes the same samples:

# %%
time = np.arange(0.0, 1.0, 1e-3)
displacement = 0.02 * np.sin(2.0 * np.pi * 2.0 * time)
expected = de.replay(de.Recording.from_arrays(time, displacement), model).force

# %%
if binary:
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(folder / "front_left.fmu")
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=extract(folder / "front_left.fmu"),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    forces = []
    for instant, value in zip(time, displacement, strict=True):
        fmu.setReal([number["displacement"]], [value])
        fmu.doStep(currentCommunicationPoint=instant, communicationStepSize=1e-3)
        forces.append(fmu.getReal([number["force"]])[0])
    difference = np.abs(np.array(forces) - expected).max()
    print(f"largest difference between FMU and Python: {difference:.2g} N of {np.abs(expected).max():.0f} N")
