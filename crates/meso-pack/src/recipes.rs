//! Specs to start from, commented: the specimens of the paper and of the standards.

/// A commented SPEC.toml and its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// Name of the recipe in `mesocrete init NAME`.
    pub name: &'static str,
    /// The spec; its first line is a comment that describes it.
    pub text: &'static str,
}

impl Recipe {
    /// Name of the paper's specimen.
    pub const DEFAULT: &str = "paper";

    /// All recipes, the paper's first.
    pub const ALL: &[Self] = &[
        Self { name: Self::DEFAULT, text: include_str!("recipes/paper.toml") },
        Self { name: "paper-rule", text: include_str!("recipes/paper-rule.toml") },
        Self { name: "paper-compression", text: include_str!("recipes/paper-compression.toml") },
        Self { name: "en-cube-100", text: include_str!("recipes/en-cube-100.toml") },
        Self { name: "en-cube-150", text: include_str!("recipes/en-cube-150.toml") },
        Self { name: "en-prism-100", text: include_str!("recipes/en-prism-100.toml") },
        Self { name: "en-prism-150", text: include_str!("recipes/en-prism-150.toml") },
        Self { name: "en-cylinder-100", text: include_str!("recipes/en-cylinder-100.toml") },
        Self { name: "en-cylinder-150", text: include_str!("recipes/en-cylinder-150.toml") },
        Self { name: "astm-cube-150", text: include_str!("recipes/astm-cube-150.toml") },
        Self { name: "gb-cube-150", text: include_str!("recipes/gb-cube-150.toml") },
        Self { name: "astm-cylinder-100", text: include_str!("recipes/astm-cylinder-100.toml") },
        Self { name: "astm-cylinder-150", text: include_str!("recipes/astm-cylinder-150.toml") },
        Self { name: "astm-beam-150", text: include_str!("recipes/astm-beam-150.toml") },
        Self { name: "rilem-notched-150", text: include_str!("recipes/rilem-notched-150.toml") },
        Self { name: "double-notched-100", text: include_str!("recipes/double-notched-100.toml") },
        Self { name: "dogbone-200", text: include_str!("recipes/dogbone-200.toml") },
        Self { name: "rve-60", text: include_str!("recipes/rve-60.toml") },
        Self { name: "fibres-voids-100", text: include_str!("recipes/fibres-voids-100.toml") },
        Self { name: "mix-design", text: include_str!("recipes/mix-design.toml") },
        Self { name: "gb-dam-three", text: include_str!("recipes/gb-dam-three.toml") },
        Self { name: "gb-dam-four", text: include_str!("recipes/gb-dam-four.toml") },
        Self { name: "asphalt-101", text: include_str!("recipes/asphalt-101.toml") },
        Self { name: "rock-soil-300", text: include_str!("recipes/rock-soil-300.toml") },
        Self { name: "en-mortar-40", text: include_str!("recipes/en-mortar-40.toml") },
        Self { name: "recycled-36", text: include_str!("recipes/recycled-36.toml") },
        Self { name: "lightweight-36", text: include_str!("recipes/lightweight-36.toml") },
    ];

    /// The recipe of this name, if there is one.
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|recipe| recipe.name == name)
    }

    /// The recipe of this name.
    ///
    /// # Errors
    /// A sentence with all names.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let known = || Self::ALL.iter().map(|recipe| recipe.name).collect::<Vec<_>>().join(", ");
        Self::find(name).ok_or_else(|| format!("there is no recipe {name:?}; the recipes are {}", known()))
    }

    /// The recipe's specimen in one line.
    pub fn title(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches("# ")
    }
}
