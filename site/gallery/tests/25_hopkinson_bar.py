"""A split Hopkinson bar

A striker sends a pulse along a steel bar. The specimen lets a part of it through to a second bar and returns the rest.
[Fast loads](../fast-loads.md) has the other tests in real time and their closed forms.
"""
import matplotlib.pyplot as plt
import mesocrete as mc

cube = {"specimen": mc.Specimen.cube(24), "grading": mc.Grading.fuller(4, 8), "placement": {"min_gap_mm": 1.0}}
mesh = mc.pack(cube, fraction=0.25, seed=1).mesh(for_test=True, element_size=2)

# The law's strengths may grow with the rate of strain; what is left is the inertia of the specimen.
runs = {rated: mesh.solve(test=mc.Test.hopkinson(8.0, rate_effect=rated)) for rated in (True, False)}
slow = mesh.solve(friction=0.1)
for rated, response in runs.items():
    print(f"rate effect {rated}: {response.result['peak_mpa']:.1f} MPa, {response.result['peak_mpa'] / slow.result['peak_mpa']:.2f} times slow")

# Pulses that run towards the specimen and away from it, and the stress at both of its ends.
curve = runs[True].curve
pulses, ends = plt.subplots(1, 2, figsize=(10, 4))[1]
for column, name in [("input_in_mpa", "incident"), ("input_out_mpa", "reflected"), ("output_out_mpa", "transmitted")]:
    pulses.plot(1e6 * curve["time_s"], curve[column], label=name)
for column, name in [("stress_bottom_mpa", "two waves, input"), ("stress_top_mpa", "one wave, output"), ("stress_mpa", "mean")]:
    ends.plot(1e6 * curve["time_s"], curve[column], label=name)
for axes in (pulses, ends):
    axes.set(xlabel="time, µs", ylabel="stress, MPa")
    axes.legend()
plt.savefig("picture.png")
