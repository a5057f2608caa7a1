"""Curves of the law `meso` at one point by other arithmetic than the engine's, as an oracle for `law::meso`.

    python3 tests/oracles/meso.py                  # writes tests/oracles/meso/*.csv
    python3 tests/oracles/meso.py loops 200 OUT    # closed loops of the default mortar, energy given back, into OUT

Principal directions come from Jacobi's rotations, and every equation is solved by regula falsi: the flow of a return,
the share of stress that a crack leaves, the fall of principal stresses by cracks, and the strain of a free side. The
engine has Newton's steps, polynomials and closed forms for them. Strain xx, yy, zz, xy, yz, zx with engineering shears;
stress in MPa, tension positive.
"""

import math
import random
import sys
from pathlib import Path

E, NU, FC, PEAK_STRAIN, FT, GF, GC = 20000.0, 0.2, 40.0, 0.003, 3.5, 0.08, 1.5
FB, KC, MERIDIAN_BEND, PSI, DUCTILITY, LENGTH, WIDTH = 1.16, 2 / 3, 0.8, 30.0, 10.0, 5.0, 4.0
BULK, SHEAR = E / (3 * (1 - 2 * NU)), E / (2 * (1 + NU))
ALPHA = (FB - 1) / (2 * FB - 1)
GAMMA = 3 * (1 - KC) / (2 * KC - 1)
PEAK = PEAK_STRAIN - FC / E
# Steps from one row of a file to the next, and of paths whose sides bend as a crack begins.
EVERY, CLOSE = 50, 5


def main() -> None:
    """Write every path, or the figures of closed loops."""
    if sys.argv[1:2] == ["loops"]:
        loops(int(sys.argv[2]), Path(sys.argv[3]))
        return
    folder = Path(__file__).with_suffix("")
    for name, rows in {**free_paths(), **strained_paths()}.items():
        lines = [",".join(f"{x:.9g}" for x in row) for row in rows]
        head = "strain xx,yy,zz,xy,yz,zx,stress xx,yy,zz,xy,yz,zx"
        (folder / f"{name}.csv").write_text("\n".join([f"# {name}", head, *lines]) + "\n")
        print(name, len(rows), "rows; stress along x from", min(r[6] for r in rows), "to", max(r[6] for r in rows))


def root(function, low: float, high: float) -> float:
    """Root of a function that rises from below 0 to above: regula falsi, whose kept end loses half its weight."""
    at_low, at_high = function(low), function(high)
    if at_low >= 0 or at_high <= 0:
        return low if at_low >= 0 else high
    side = 0
    for _ in range(200):
        middle = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < middle < high:
            middle = (low + high) / 2
        at = function(middle)
        if at == 0 or middle in (low, high) or high - low < 1e-15 * abs(middle):
            return middle
        if at < 0:
            low, at_low = middle, at
            at_high /= 2 if side < 0 else 1
            side = -1
        else:
            high, at_high = middle, at
            at_low /= 2 if side > 0 else 1
            side = 1
    return (low + high) / 2


def bend() -> float:
    """Shape of the rising branch: least squares against fib Model Code 2010, eq. 5.1-26, over plastic strain."""
    k = E * PEAK_STRAIN / FC
    above = below = 0.0
    for step in range(1, 100):
        x = step / 100
        # Stress at which the code's curve has this plastic strain, in f_c.
        strain = x * (1 - 1 / k)
        stress = root(lambda s: s - code(k, strain + s / k), 0.0, 1.0)
        weight = 0.6 * (1 - x) ** 2
        above += weight * x * (1 - weight - max(stress, 0.4))
        below += (weight * x) ** 2
    return min(max(above / below, -1.0), 2.0)


def code(k: float, e: float) -> float:
    """Stress over f_c at the strain e over the peak strain."""
    return (k * e - e * e) / (1 + (k - 2) * e)


BEND = bend()


def rise(kc: float) -> float:
    """Strength before cohesion is lost, MPa."""
    x = min(kc / PEAK, 1.0)
    return FC * (1 - 0.6 * (1 - x) ** 2 * (1 + BEND * x))


def left(kc: float) -> float:
    """Share of the cohesion that is left."""
    return max(math.exp(-max(kc - PEAK, 0.0) * max(WIDTH, LENGTH) * FC / GC), 1e-3)


def loose(kc: float) -> float:
    """Share of the stiffness that crushing leaves."""
    return max(left(kc), 0.1)


def standing(kt: float) -> float:
    """Share of the stiffness that a crack leaves: all until the bilinear law ends, nearly nothing 0.2 G_f / f_t beyond."""
    beyond = WIDTH * kt * FT / GF - 5
    return min(max(1 - 5 * beyond, 1e-3), 1.0)


def excess(principal: list[float], kc: float, gamma: float) -> float:
    """The yield function of effective stress times 1 - alpha."""
    first, _, last = principal
    pressed = first - last + 3 * ALPHA * mean(principal) + gamma * first
    return pressed - (1 - ALPHA) * rise(kc) * left(kc) / loose(kc)


def mean(s: list[float]) -> float:
    """Mean stress."""
    return sum(s) / 3


def mises(s: list[float]) -> float:
    """Mises stress of principal stresses."""
    return math.sqrt(((s[0] - s[1]) ** 2 + (s[1] - s[2]) ** 2 + (s[2] - s[0]) ** 2) / 2)


class Point:
    """A point with its history."""

    def __init__(self) -> None:
        self.plastic = [0.0] * 6
        self.kt = self.kc = 0.0

    def copy(self) -> "Point":
        """Another point of this history."""
        other = Point()
        other.plastic, other.kt, other.kc = list(self.plastic), self.kt, self.kc
        return other

    def stiffness(self) -> float:
        """Share of the stiffness that is left."""
        return loose(self.kc) * standing(self.kt)

    def stress(self, strain: list[float]) -> list[float]:
        """Stress at the end of a step to this strain."""
        elastic = [e - p for e, p in zip(strain, self.plastic)]
        values, axes = eigen(matrix(elastic, 0.5))
        trace = sum(values)
        trial = [(BULK - 2 / 3 * SHEAR) * trace + 2 * SHEAR * e for e in values]
        kept = left(self.kc)
        strength = FT * kept / self.stiffness() * crack_share(self.kt)
        cracked, _ = opened(trial, strength)

        confined = self.stiffness() * max(-cracked[0], 0.0)
        bent = 1 + MERIDIAN_BEND * confined / FC
        gamma = GAMMA / bent
        costly = 1 + DUCTILITY * confined / FC
        tan = kept / bent / costly * math.tan(math.radians(PSI))
        p, q = mean(cracked), mises(cracked)
        flow, sheared = 0.0, trial
        direction = [0.0] * 3
        if excess(cracked, self.kc, gamma) > 0:
            direction = [1.5 * (s - p) / q + tan / 3 for s in cracked]
            harden = max(-direction[2], 0.0) / costly
            push = (BULK - 2 / 3 * SHEAR) * sum(direction)
            less = lambda of, x: [s - x * (push + 2 * SHEAR * n) for s, n in zip(of, direction)]  # noqa: E731
            over = lambda x: -excess(less(cracked, x), self.kc + x * harden, gamma)  # noqa: E731
            flow = root(over, 0.0, q / (3 * SHEAR))
            sheared = less(trial, flow)
            self.kc += flow * harden
        # The cone's flow has lowered the largest stress, so that cracks open less.
        effective, cracks = opened(sheared, strength)
        moved = [crack + flow * n for crack, n in zip(cracks, direction)]
        self.plastic = [a + b for a, b in zip(self.plastic, tensor(moved, axes, 2.0))]
        self.kt += cracks[0]
        return tensor([self.stiffness() * s for s in effective], axes, 1.0)


def opened(trial: list[float], strength: float) -> tuple[list[float], list[float]]:
    """Principal stresses after cracks have opened, and the openings: all fall by m, those above the strength to it."""
    factor = NU / (1 - 2 * NU)
    fallen = lambda m: m - factor * sum(max(s - strength - m, 0.0) for s in trial)  # noqa: E731
    m = root(fallen, 0.0, max(trial[0] - strength, 0.0) + 1.0)
    cracks = [max(s - strength - m, 0.0) / (2 * SHEAR) for s in trial]
    return [s - m - 2 * SHEAR * crack for s, crack in zip(trial, cracks)], cracks


def crack_share(kt: float) -> float:
    """Share of f_t that a crack leaves: the bilinear law of fib Model Code 2010 over the opening."""

    def law(share: float) -> float:
        opening = WIDTH * (kt + (1 - share) * FT / E) * FT / GF
        return max(1 - 0.8 * opening, 0.25 - 0.05 * opening)

    return min(max(root(lambda y: y - law(y), -1.0, 2.0), 1e-4), 1.0)


def matrix(t: list[float], shear: float) -> list[list[float]]:
    """Symmetric matrix of six components."""
    xx, yy, zz, xy, yz, zx = t
    return [[xx, shear * xy, shear * zx], [shear * xy, yy, shear * yz], [shear * zx, shear * yz, zz]]


def tensor(values: list[float], axes: list[list[float]], shear: float) -> list[float]:
    """Six components of a tensor with these principal values along these axes."""
    at = lambda i, j: sum(v * a[i] * a[j] for v, a in zip(values, axes))  # noqa: E731
    return [at(0, 0), at(1, 1), at(2, 2), shear * at(0, 1), shear * at(1, 2), shear * at(2, 0)]


def eigen(a: list[list[float]]) -> tuple[list[float], list[list[float]]]:
    """Eigenvalues in falling order and their axes, by Jacobi's rotations."""
    a = [list(row) for row in a]
    v = [[float(i == j) for j in range(3)] for i in range(3)]
    for _ in range(30):
        p, q = max(((0, 1), (1, 2), (0, 2)), key=lambda ij: abs(a[ij[0]][ij[1]]))
        if abs(a[p][q]) < 1e-300:
            break
        angle = 0.5 * math.atan2(2 * a[p][q], a[q][q] - a[p][p])
        c, s = math.cos(angle), math.sin(angle)
        for k in range(3):
            a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
        for k in range(3):
            a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
        for k in range(3):
            v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]
    order = sorted(range(3), key=lambda i: -a[i][i])
    return [a[i][i] for i in order], [[v[k][i] for k in range(3)] for i in order]


def free_paths() -> dict[str, list[list[float]]]:
    """Paths along x with a held stress at the sides."""
    return {
        "tension": held(0.0, [0.003], step=2e-6, every=CLOSE),
        "compression": held(0.0, [-0.012]),
        "confined_5": held(-5.0, [-0.03]),
        "confined_10": held(-10.0, [-0.04]),
        "crushed_unloaded_crushed": held(0.0, [-0.004, -0.0025, -0.008]),
        "cracked_crushed_cracked": held(0.0, [0.001, -0.004, 0.002], every=CLOSE),
        "biaxial": held(0.0, [-0.01], third=True),
    }


def held(
    side: float, corners: list[float], *, third: bool = False, step: float = 1e-5, every: int = EVERY
) -> list[list[float]]:
    """Follow `corners` along x while the sides, or z alone, keep their stress."""
    point, rows, free, start, count = Point(), [], 0.0, 0.0, 0
    whole = abs(corners[0])
    for corner in corners:
        steps = every * max(round(abs(corner - start) / step / every), 1)
        for k in range(1, steps + 1):
            x = start + (corner - start) * k / steps
            # The held stress is raised in the first twentieth of the path.
            goal = side * min(1.0, abs(x) / (0.05 * whole)) if side else 0.0
            at = lambda e: [x, x if third else e, e, 0.0, 0.0, 0.0]  # noqa: E731, B023
            free = root(lambda e: point.copy().stress(at(e))[2] - goal, free - 2e-4, free + 2e-4)  # noqa: B023
            stress = point.stress(at(free))
            count += 1
            if count % every == 0:
                rows.append(at(free) + stress)
        start = corner
    return rows


def strained_paths() -> dict[str, list[list[float]]]:
    """Paths of all six strains: straight pieces between random corners."""
    found = {}
    for name, seed, size in (("wander", 3, 0.0008), ("crush", 5, 0.002), ("ended", 11, 0.02)):
        dice = random.Random(seed)
        point, rows, start = Point(), [], [0.0] * 6
        for _ in range(8):
            corner = [size * dice.uniform(-1.5, 1.0) for _ in range(3)] + [size * dice.uniform(-1, 1) for _ in range(3)]
            for k in range(1, 10 * EVERY + 1):
                strain = [a + (b - a) * k / (10 * EVERY) for a, b in zip(start, corner)]
                stress = point.stress(strain)
                if k % EVERY == 0:
                    rows.append(strain + stress)
            start = corner
        found[name] = rows
    return found


def take(**values: float) -> None:
    """Take other values of the mortar, and what follows from them."""
    names = globals()
    names.update(values)
    names["ALPHA"] = (FB - 1) / (2 * FB - 1)
    names["GAMMA"] = 3 * (1 - KC) / (2 * KC - 1)
    names["PEAK"] = PEAK_STRAIN - FC / E
    names["BEND"] = bend()


DEFAULTS = {"FC": 33.0, "FT": 3.4, "GF": 0.1, "GC": 11.0, "KC": 0.72, "MERIDIAN_BEND": 0.15, "PSI": 5.0, "DUCTILITY": 3.0, "LENGTH": 15.0}


def loops(count: int, path: Path) -> None:
    """Count what closed loops give back, for biaxial ratios and steps from corner to corner."""
    rows = ["biaxial_ratio,steps,loops,spent_n_per_mm2,returned_n_per_mm2,largest_share_of_a_loop"]
    for ratio in (1.0, 1.16, 2.0, 0.94):
        take(**DEFAULTS, FB=ratio)
        for steps in (1, 4, 20):
            dice, spent, returned, worst = random.Random(5), 0.0, 0.0, 0.0
            for turn in range(count):
                won, lost = loop(dice, steps, (0.001, 0.01, 0.05)[turn % 3], turn % 2 == 0)
                spent, returned, worst = spent + won, returned + lost, max(worst, lost / max(won, 1e-12))
            rows.append(f"{ratio},{steps},{count},{spent:.6g},{returned:.3g},{worst:.3g}")
            path.write_text("\n".join(rows) + "\n")


def loop(dice: random.Random, steps: int, size: float, is_round: bool) -> tuple[float, float]:
    """Energy per volume that steps of a polygon or an ellipse spend, and that they give back."""
    tensors = [[size * (dice.uniform(-1, 1) - (0.3 if i < 3 else 0)) for i in range(6)] for _ in range(4)]
    middle, a, b, _ = tensors
    at = lambda t: [m + math.cos(t) * x + math.sin(t) * y for m, x, y in zip(middle, a, b)]  # noqa: E731
    corners = [at(0.7 * k) for k in range(24)] if is_round else tensors
    point, start, before, won, lost = Point(), [0.0] * 6, 1.0, 0.0, 0.0
    for corner in [*corners, [0.0] * 6]:
        for k in range(1, steps + 1):
            strain = [x + (y - x) * k / steps for x, y in zip(start, corner)]
            old = list(point.plastic)
            stress, kept = point.stress(strain), point.stiffness()
            flowed = sum(s * (new - was) for s, new, was in zip(stress, point.plastic, old))
            stored = sum(0.5 * s * (e - p) for s, e, p in zip(stress, strain, point.plastic))
            step = flowed + stored * (before - kept) / kept
            before = kept
            won, lost = won + max(step, 0.0), lost + max(-step, 0.0)
        start = corner
    return won, lost


if __name__ == "__main__":
    main()
