//! Commented TEST.toml files to start from, one for each named test.

use crate::trial::{Test, TestKind, TurnOf, named};

impl TestKind {
    /// Supports and loads of the test in a sentence.
    pub fn description(self) -> &'static str {
        match self {
            Self::Compression => "Plates press along z.",
            Self::Tension => "Plates are glued on and pull along z.",
            Self::Splitting => {
                "Strips press a cylinder on its mantle, or a cube, along x. The stress is 2 F / (pi l d)."
            }
            Self::Bending => {
                "A beam along x on two rollers; a third presses its middle. The stress is 3 F l / (2 b h^2)."
            }
            Self::FourPoint => {
                "A beam along x on two rollers; two more press its third points. The stress is F l / (b h^2)."
            }
            Self::Triaxial => "All sides are pressed first, then plates press along z.",
            Self::Biaxial => "Plates press along z; the stress of plates across x follows in a ratio.",
            Self::Cyclic => "Plates press along z and make the turns that are listed.",
            Self::Expansion => "Phases swell or shrink in a specimen without supports.",
            Self::Hopkinson => "A pulse in a steel bar presses the specimen along z against another one.",
            Self::HopkinsonSplitting => {
                "A pulse in a steel bar presses a strip of a cylinder's mantle, or of a cube, along x against another bar. The stress \
                 is 2 F / (pi l d)."
            }
            Self::Spall => {
                "A pulse comes along a steel bar below; its reflection from the free upper end tears the specimen."
            }
            Self::Drop => {
                "A mass falls on the middle of a beam on two rollers, of a plate on four, or on a specimen on a base."
            }
            Self::Impact => "A plate of constant speed presses along z.",
            Self::Shear => {
                "Plates glued to the upper left and the lower right half of a double-notched prism move past each other along z."
            }
        }
    }

    /// A TEST.toml of this test, with comments. It is the named test; each line that begins with `# KEY =` is an option.
    pub fn recipe(self) -> String {
        let test = Test { kind: self, ..Test::default() };
        let (strain, friction) = (test.strain(), test.friction());
        let own = match self {
            Self::Splitting => "# strip_mm = 10.0           # absent: a tenth of the diameter\n".to_owned(),
            Self::Bending => {
                "# span_mm = 500.0           # absent: 10/3 of the depth, at most 0.9 of the length\n".to_owned()
            }
            Self::FourPoint => {
                "# span_mm = 450.0           # absent: three depths, at most 0.9 of the length\n".to_owned()
            }
            Self::Triaxial => "pressure_mpa = 5.0\n".to_owned(),
            Self::Biaxial => "stress_ratio = 1.0          # lateral over axial stress\n".to_owned(),
            Self::Cyclic => turns(strain),
            Self::Hopkinson | Self::HopkinsonSplitting | Self::Spall => {
                let [speed, pulse, rise] = [test.speed_m_per_s(), test.pulse_s(), test.rise_s()];
                let pressed = match self {
                    Self::Hopkinson => "# pressure_mpa = 5.0        # on the mantle\n",
                    Self::HopkinsonSplitting => {
                        "# strip_mm = 10.0           # absent: a tenth of the diameter\n\
                         # pressure_mpa = 5.0        # on both ends\n"
                    }
                    _ => "",
                };
                format!(
                    "# speed_m_per_s = {speed:?}         # of the striker\n# pulse_s = {pulse:?}\n# rise_s = {rise:?}\n{pressed}{RATED}"
                )
            }
            Self::Drop => format!(
                "# mass_kg = 1.0\n# speed_m_per_s = {:?}       # of the mass when it strikes\n# span_mm = 450.0           # of a beam or plate; strip_mm: width of its rollers or load\n{RATED}",
                test.speed_m_per_s()
            ),
            Self::Impact => {
                format!(
                    "# speed_m_per_s = {:?}       # of the plate\n# rise_s = {:?}\n{RATED}",
                    test.speed_m_per_s(),
                    test.rise_s()
                )
            }
            _ => String::new(),
        };
        let kind = serde_json::to_value(self).unwrap_or_default();
        let mut path = String::new();
        if test.has_path() {
            path += &format!("# strain = {strain:<16} # at the end\n");
        }
        if test.rubs() {
            path += &format!("# friction = {friction:<14} # between plates and specimen; brushes and teflon: 0.005\n");
        }
        let control = if self.is_fast() { "" } else { CONTROL };
        let strains = test.expansion().map_or("", |_| STRAINS);
        let head = self.description();
        format!(
            "# A test for `mesocrete solve --test TEST.toml`. {head}\nkind = {kind}\n{own}{path}{LAW}{control}{COMMON}{strains}"
        )
    }
}

/// The turns of a cyclic test that ends at `strain`.
fn turns(strain: f64) -> String {
    let lines = named::cycles(strain).into_iter().map(|turn| match turn.of {
        TurnOf::Stress => format!("    {{ at = {:?}, of = \"stress\" }},  # MPa\n", turn.at),
        _ => format!("    {{ at = {:?} }},\n", turn.at),
    });
    format!("turns = [                   # strains, and stresses between them\n{}]\n", lines.collect::<String>())
}

/// Options of tests in real time.
const RATED: &str = "# rate_effect = true         # strengths of mortar and ITZ grow with the rate of strain\n";

/// Strains of an expansion test.
const STRAINS: &str = "
[expansion]
aggregate = 1e-4            # linear strains; shrinkage is negative
mortar = 0.0                # or rows of a time and a strain: [[28, -2e-4], [90, -4e-4]]; or a table: \"drying.csv\"
# layer_mm = 2.0            # only so deep; layer_on = [\"z-max\"]: on these sides; below = { mortar = 1e-4 }: the rest
";

/// Options that every test has.
const LAW: &str = "# law = \"meso\"              # meso, cdp, cdpm2 or elastic\n";
/// Option of quasi-static tests.
const CONTROL: &str = "# control = \"servo\"         # or steady, crack-mouth, lateral-strain\n";
/// Gauges and turns.
const COMMON: &str = "
# Gauges instead of the test's own are further columns of curve.csv; an lvdt measures between two planes, mm from the lower
# side. Turns of the path may also come from a CSV file. Both: docs/tests.md
# gauges = [{ kind = \"lateral-strain\", name = \"lateral_strain\" }]
# gauges = [{ kind = \"lvdt\", name = \"lvdt\", axis = \"z\", from_mm = 5.0, to_mm = 15.0 }]
";

#[cfg(test)]
mod tests {
    use crate::sample::Geometry;
    use crate::trial::{Test, TestKind};

    const ALL: [TestKind; 15] = [
        TestKind::Compression,
        TestKind::Tension,
        TestKind::Splitting,
        TestKind::Bending,
        TestKind::FourPoint,
        TestKind::Triaxial,
        TestKind::Biaxial,
        TestKind::Cyclic,
        TestKind::Expansion,
        TestKind::Shear,
        TestKind::Hopkinson,
        TestKind::HopkinsonSplitting,
        TestKind::Spall,
        TestKind::Drop,
        TestKind::Impact,
    ];
    const BEAM: Geometry = Geometry {
        size_mm: [120.0, 30.0, 32.0],
        section_mm2: 3600.0,
        notch_mm: 8.0,
        upper_notch_mm: 8.0,
        notch_at_mm: 0.0,
    };

    fn read(text: &str) -> Test {
        let test: Test = meso_spec::options_from_toml(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        test.validate().unwrap_or_else(|error| panic!("{error}\n{text}"));
        test
    }

    /// The case: `init --test biaxial` had a ratio of 0.5, and `--test biaxial` one of 1.
    #[test]
    fn a_recipe_is_the_named_test() {
        for kind in ALL {
            let (named, recipe) = (Test { kind, ..Test::default() }, read(&kind.recipe()));
            assert_eq!(recipe.rig(&BEAM).unwrap(), named.rig(&BEAM).unwrap(), "{kind:?}");
            assert_eq!((recipe.turns(), recipe.gauges()), (named.turns(), named.gauges()), "{kind:?}");
            assert_eq!((recipe.strain(), recipe.expansion()), (named.strain(), named.expansion()), "{kind:?}");
            assert_eq!((recipe.law, recipe.control), (named.law, named.control), "{kind:?}");
        }
    }

    /// The case: `# friction = 0.1` stood beside `friction = 0.1`, and `# strain = 0.005` in a tension test.
    #[test]
    fn every_option_of_a_recipe_can_be_uncommented_alone_and_has_the_default_of_its_test() {
        for kind in ALL {
            let (text, named) = (kind.recipe(), read(&kind.recipe()));
            let options: Vec<&str> = text.lines().filter(|line| is_option(line)).collect();
            assert!(options.len() >= 4, "{text}");
            for line in options {
                let test = read(&text.replacen(line, line.trim_start_matches("# "), 1));
                assert_eq!((test.strain(), test.friction()), (named.strain(), named.friction()), "{line}");
            }
        }
    }

    fn is_option(line: &str) -> bool {
        let key = line.strip_prefix("# ").and_then(|line| line.split_once(" = ")).map(|(key, _)| key);
        key.is_some_and(|key| key.chars().all(|c| c.is_ascii_lowercase() || c == '_'))
    }
}
