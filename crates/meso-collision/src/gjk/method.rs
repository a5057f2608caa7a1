//! The searches by name.

use crate::gjk::error::GjkError;
use crate::gjk::pair::{Found, Pair};
use crate::gjk::search::classical::{Classical, Until};
use crate::gjk::search::enhanced::Enhanced;
use crate::gjk::search::nearest::SubAlgorithm;
use crate::gjk::search::simplex::Corners;
use crate::math::Vec3;
use crate::simd::dispatch;
use std::str::FromStr;

/// The search that proposes an answer. The answer does not depend on it: all are certified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Algorithm {
    /// The paper's boolean GJK, mended (Sec. 2.3.2).
    #[default]
    Enhanced,
    /// The distance GJK with Johnson's sub-algorithm (Sec. 2.3.1), stopped as soon as the answer is known.
    Classical,
    /// The distance GJK with signed volumes.
    SignedVolumes,
    /// Exact arithmetic from the first step.
    Exact,
}

impl Algorithm {
    /// All methods, the default first.
    pub const ALL: [Self; 4] = [Self::Enhanced, Self::Classical, Self::SignedVolumes, Self::Exact];

    /// The name [`FromStr`] takes.
    ///
    /// ```
    /// use meso_collision::gjk::Algorithm;
    /// assert_eq!(Algorithm::SignedVolumes.name().parse(), Ok(Algorithm::SignedVolumes));
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            Self::Enhanced => "enhanced",
            Self::Classical => "classical",
            Self::SignedVolumes => "signed-volumes",
            Self::Exact => "exact",
        }
    }
}

impl Algorithm {
    /// The search in floating point from direction `v`.
    pub(crate) fn search(self, pair: Pair<'_>, v: Vec3) -> Found {
        let until = Until::Apart(0.0);
        let classical = |sub_algorithm| dispatch(Classical { pair, v, sub_algorithm, until });
        match self {
            Self::Enhanced => dispatch(Enhanced { pair, v }),
            Self::Classical => classical(SubAlgorithm::Johnson),
            Self::SignedVolumes => classical(SubAlgorithm::SignedVolumes),
            Self::Exact => Found::Undecided(Corners::NONE),
        }
    }
}

impl FromStr for Algorithm {
    type Err = GjkError;

    fn from_str(name: &str) -> Result<Self, GjkError> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| GjkError::UnknownMethod { name: name.to_owned() })
    }
}
