//! The learning rule of the rover: one line to change.

use crate::knowledge::Knowledge;
use crate::learning::LearningRule;
use crate::learning::paper_rule::PaperRule;

/// The rule the rover learns by.
pub type Rule = PaperRule;

/// What a rover with this [`Rule`] has learned.
pub type RoverKnowledge = Knowledge<<Rule as LearningRule>::Memory>;
