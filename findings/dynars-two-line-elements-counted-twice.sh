#!/usr/bin/env bash
# dynars 1.1.0: table("ELEMENT_SOLID") takes the two lines of an element of the ten-node form for two elements.
# LS-DYNA has the number and the part on the first line and ten nodes on the second.
# Seen: 2 elements become 4 rows, the second of each pair with a node's number as element and part; no message.
# Mends it: dynakw 1.7.0, which pairs the lines, or every second row with the columns moved by two.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile dynars==1.1.0 dynakw==1.7.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import dynakw
import dynars

field = lambda numbers: "".join(f"{n:8d}" for n in numbers) + "\n"
points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
nodes = "".join(f"{i:8d}" + "".join(f"{x:16.8f}" for x in p) + f"{0:8d}{0:8d}\n" for i, p in enumerate(points, 1))
elements = [(21, 5, [1, 2, 3, 4, 4, 4, 4, 4, 0, 0]), (22, 6, [2, 5, 3, 4, 4, 4, 4, 4, 0, 0])]
with open("two.k", "w") as file:
    file.write("*KEYWORD\n*NODE\n" + nodes + "*ELEMENT_SOLID\n")
    file.write("".join(field([number, part]) + field(own) for number, part, own in elements) + "*END\n")
table = dynars.parse_deck("two.k").table("ELEMENT_SOLID")
rows = [[int(table[name][i]) for name in ("EID", "PID", "N1", "N2")] for i in range(len(table["EID"]))]
with dynakw.DynaKeywordReader("two.k") as reader:
    cards = next(k for k in reader.keywords() if "ELEMENT_SOLID" in k.full_keyword).cards
paired = [[int(cards["Card 1"][n][i]) for n in ("EID", "PID")] + [int(cards["nodes"]["N1"][i])] for i in range(2)]
print("rows of dynars (EID, PID, N1, N2):", rows, "of dynakw (EID, PID, N1):", paired)
assert rows == [[21, 5, 0, 0], [1, 2, 3, 4], [22, 6, 0, 0], [2, 5, 3, 4]]
assert paired == [[21, 5, 1], [22, 6, 2]]
PYTHON
