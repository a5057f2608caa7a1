def main(arguments):
    """Read the results that are named and write the curve; the exit code."""
    if len(arguments) not in (1, 2):
        print(__doc__, file=sys.stderr)
        return 2
    rows = read(arguments[0])
    with open(arguments[1] if len(arguments) == 2 else "curve.csv", "w") as file:
        file.write(",".join(["strain", "stress_mpa"] + [name for name, _ in ENERGIES]) + "\n")
        for row in rows:
            file.write(",".join("%.9g" % value for value in row) + "\n")
    print(summary(rows))
    return 0


def interpolated(data, time):
    """The value at a time, linear between the pairs and constant beyond them."""
    before = data[0]
    for after in data:
        if after[0] >= time:
            width = after[0] - before[0]
            share = (time - before[0]) / width if width > 0.0 else 1.0
            return before[1] + share * (after[1] - before[1])
        before = after
    return before[1]


def summary(rows):
    """The peak, what is left of it, and how dynamic the run was there, in a line."""
    strain, stress, kinetic, internal = max(rows, key=lambda row: row[1])[:4]
    if stress <= 0.0:
        return "no stress in the history"
    dynamic = 100.0 * kinetic / internal if internal > 0.0 else 0.0
    left = 100.0 * rows[-1][1] / stress
    return "peak %.4g MPa at a strain of %.4g, %.3g %% of it left at %.4g; kinetic over internal energy at the peak %.2g %%" % (
        stress, strain, left, rows[-1][0], dynamic
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
