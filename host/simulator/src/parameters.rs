//! The parameters that suit a robot, and files that change some of them (TOML).

use rover_shared::parameters::{Coefficients, Parameters};
use rover_shared::range_check::ParameterError;

use crate::arena::{RobotModel, Side};

/// The paper's parameters, with the step, turns and sensor ranges of a robot.
pub fn preset(robot: &RobotModel) -> Parameters {
    let mut parameters = Parameters::PAPER;
    parameters.learning.module_cm = robot.step_cm;
    parameters.learning.phase_limit_deg = robot.max_turn_deg;
    let sensing = &mut parameters.sensing;
    [sensing.front_near_cm, sensing.front_far_cm] = robot.range_cm(Side::Front);
    [sensing.side_near_cm, sensing.side_far_cm] = robot.range_cm(Side::Left);
    parameters
}

/// Why a parameter file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OverlayError {
    /// It is not TOML, or names something that is no parameter.
    #[error("line {line}: {problem}")]
    Toml {
        /// The line, from 1.
        line: usize,
        /// What is wrong and what was expected.
        problem: String,
    },
    /// A value cannot be used.
    #[error("line {line}: {error}")]
    Value {
        /// The line of the value or, where several are to blame together, of their section.
        line: usize,
        /// What is wrong and what was expected.
        error: ParameterError,
    },
}

/// `preset` with the values that `text` gives, checked as a whole.
///
/// # Errors
/// If the text is not TOML of parameters, or a value violates (2) or lies outside its range.
pub fn overlay(preset: Parameters, text: &str) -> Result<Parameters, OverlayError> {
    let refuse = |error: toml::de::Error| {
        let at = error.span().map_or(0, |span| span.start);
        let line = text[..at].matches('\n').count() + 1;
        OverlayError::Toml {
            line,
            problem: error.message().to_owned(),
        }
    };
    // Read once as parameters, so that unknown names are reported with their line.
    toml::from_str::<Parameters>(text).map_err(refuse)?;
    let mut values = toml::Table::try_from(preset).unwrap_or_default();
    for (name, section) in toml::from_str::<toml::Table>(text).map_err(refuse)? {
        if let (Some(toml::Value::Table(into)), toml::Value::Table(section)) =
            (values.get_mut(&name), section)
        {
            into.extend(section);
        }
    }
    let parameters = values.try_into::<Parameters>().map_err(refuse)?;
    match Coefficients::new(&parameters) {
        Ok(_) => Ok(parameters),
        Err(error) => Err(OverlayError::Value {
            line: line_of(&error, text),
            error,
        }),
    }
}

/// The line that a parameter stands in, or its section begins in; 1 if the file names neither.
fn line_of(error: &ParameterError, text: &str) -> usize {
    let name = match error {
        ParameterError::OutOfRange { name, .. } | ParameterError::EmptyRange { name } => name,
        ParameterError::RewardTooLarge { .. } => "reward.",
        _ => "lattice.",
    };
    let (section, key) = name.split_once('.').unwrap_or((name, ""));
    let lines = || (1..).zip(text.lines().map(str::trim));
    let begins = lines().find(|(_, line)| *line == format!("[{section}]"));
    let begin = begins.map_or(1, |(number, _)| number);
    let is_key = |line: &str| {
        line.split('=')
            .next()
            .is_some_and(|name| name.trim() == key)
    };
    lines()
        .skip(begin)
        .find(|(_, line)| is_key(line))
        .map_or(begin, |(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_replace_those_of_the_preset_only_where_given() {
        let text = "[learning]\nrate = 0.25\n[lattice]\nmu = -0.71\n";
        let parameters = overlay(Parameters::ROVER, text).unwrap();
        assert_eq!(
            (parameters.learning.rate, parameters.lattice.mu),
            (0.25, -0.71)
        );
        assert_eq!(parameters.sensing, Parameters::ROVER.sensing);
        assert_eq!(parameters.learning.module_cm, 7.0);
    }

    #[test]
    fn unknown_names_and_violations_are_refused() {
        let unknown = overlay(Parameters::PAPER, "[lattice]\nmue = 1.0\n")
            .unwrap_err()
            .to_string();
        assert!(
            unknown.contains("line 2") && unknown.contains("mue"),
            "{unknown}"
        );
        let stable = overlay(Parameters::PAPER, "[lattice]\nd2 = 0.05\n")
            .unwrap_err()
            .to_string();
        assert!(
            stable.contains("line 1: no Turing patterns (eq. 2)"),
            "{stable}"
        );
        let range = overlay(Parameters::PAPER, "[learning]\nrate = 7\n")
            .unwrap_err()
            .to_string();
        assert!(
            range.contains("line 2: parameter learning.rate is 7"),
            "{range}"
        );
    }
}
