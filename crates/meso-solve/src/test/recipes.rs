//! Commented TEST.toml files to start from, one for each named test.

use crate::test::TestKind;

/// Keys that every test has, as a comment.
const COMMON: &str = "\
# strain = 0.005            # at the end
# friction = 0.1            # between plates and specimen
# law = \"cdp\"               # elastic, cdp, cdpm2 or meso
# control = \"servo\"         # or steady, crack-mouth, lateral-strain
# history = \"turns.csv\"     # turns of the path: a column strain, stress_mpa or opening_mm

# Gauges are further columns of curve.csv.
# [[gauges]]
# kind = \"lvdt\"             # strain between two planes across an axis, mm from the lower side
# name = \"lvdt\"
# axis = \"z\"
# from_mm = 10.0
# to_mm = 40.0
# [[gauges]]
# kind = \"lateral-strain\"   # or sides, crack-mouth
# name = \"lateral_strain\"
";

impl TestKind {
    /// A TEST.toml of this test, with comments.
    pub fn recipe(self) -> String {
        let (head, own) = match self {
            Self::Compression => (
                "Plates press along z.",
                "kind = \"compression\"\nfriction = 0.1              # brushes and teflon: 0.005\n",
            ),
            Self::Tension => ("Plates are glued on and pull along z.", "kind = \"tension\"\n"),
            Self::Splitting => (
                "Strips press a cylinder on its mantle, or a cube, along x. The stress is 2 F / (pi l d).",
                "kind = \"splitting\"\n# strip_mm = 10.0           # absent: a tenth of the diameter\n",
            ),
            Self::Bending => (
                "A notched beam along x on two rollers; a third presses its middle. The stress is 3 F l / (2 b h^2).",
                "kind = \"bending\"\n# span_mm = 500.0           # absent: 10/3 of the depth, at most 0.9 of the length\n",
            ),
            Self::Triaxial => {
                ("All sides are pressed first, then plates press along z.", "kind = \"triaxial\"\npressure_mpa = 5.0\n")
            }
            Self::Biaxial => (
                "Plates press along z; the stress of plates across x follows in a ratio.",
                "kind = \"biaxial\"\nstress_ratio = 0.5          # lateral over axial stress\nfriction = 0.005\n",
            ),
            Self::Cyclic => (
                "Plates press along z and make the turns that are listed.",
                "kind = \"cyclic\"\nturns = [\n    { at = 0.002 },             # a strain\n    { at = 1.0, of = \"stress\" },  # MPa\n    { at = 0.005 },\n]\n",
            ),
            Self::Expansion => (
                "Phases swell or shrink in a specimen without supports.",
                "kind = \"expansion\"\n[expansion]\naggregate = 1e-4            # linear strains; shrinkage is negative\nmortar = 0.0\n",
            ),
            Self::Shear => (
                "Plates glued to the upper left and the lower right half of a double-notched prism move past each other along z.",
                "kind = \"shear\"\n",
            ),
        };
        let (options, tables) = own.split_once("[expansion]").map_or((own, None), |(a, b)| (a, Some(b)));
        let tables = tables.map_or_else(String::new, |text| format!("\n[expansion]{text}"));
        format!("# A test for `mesocrete solve --test TEST.toml`. {head}\n{options}{COMMON}{tables}")
    }
}
