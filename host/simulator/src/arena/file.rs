//! Arena files (TOML).
//!
//! ```toml
//! width_cm = 489            # inner size; or instead of both:  map = "map.yaml"  (ROS map_server)
//! height_cm = 185
//! start = { x_cm = 30, y_cm = 90, heading_deg = 0 }   # left out: a random free place per trial
//! goal = { x_cm = 450, y_cm = 90, radius_cm = 12 }    # left out: the same; none for the rover
//!
//! [[rect]]                  # any number; x_cm, y_cm is the lower left corner
//! x_cm = 200
//! y_cm = 60
//! w_cm = 20
//! h_cm = 30
//!
//! [[circle]]
//! x_cm = 320
//! y_cm = 120
//! r_cm = 12
//!
//! [[polygon]]
//! points_cm = [[100, 20], [130, 20], [115, 45]]
//!
//! [robot]                   # optional, and so is each of its keys
//! model = "paper"           # or "harder" or "rover"
//! beam_deg = 10             # rover only: width of a sensor's field
//! step_cm = 4
//! contact_radius_cm = 2
//! front_range_cm = 40
//! side_range_cm = 20
//! ```
//!
//! Centimetres from the lower left corner, degrees counter-clockwise with 90 = up. Unknown keys are
//! errors, so that a misspelt one does not go unnoticed.

use std::path::Path;

use super::check::Text;
use super::entry::{ArenaEntry, ModelEntry};
use super::error::ArenaError;
use super::files::Files;
use super::fixed::{Fixed, Task};
use super::layout::GOAL_RADIUS_CM;

/// Reads an arena file, and the map that it may name.
pub(super) fn load(path: &Path, files: &mut Files) -> Result<Fixed, ArenaError> {
    let text = &files.text(path)?;
    let file = Text { path, text };
    let entry: ArenaEntry = toml::from_str(text).map_err(|error| {
        let problem = error.message().trim_end().replace('\n', "; ");
        match error.span() {
            Some(span) => file.at(&span, problem),
            None => ArenaError::file(path, problem),
        }
    })?;
    let robot = file.robot(&entry.robot)?;
    let world = file.world(&entry, files)?;
    let start = entry.start.as_ref();
    let start = start.map(|start| file.start(start, &world, &robot));
    let goal = entry.goal.as_ref();
    let goal = goal.map(|goal| file.goal(goal, &world, &robot));
    let (start, goal) = (start.transpose()?, goal.transpose()?);
    let task = match goal {
        Some(goal) => Task::Reach(goal),
        // The rover has a compass, but nothing to see a target with (IV-A).
        None if entry.robot.model == ModelEntry::Rover => Task::Follow,
        None => Task::ReachAnywhere {
            radius_cm: GOAL_RADIUS_CM,
        },
    };
    Fixed::new(world, robot, start, task).map_err(|problem| ArenaError::file(path, problem))
}

#[cfg(test)]
mod tests {
    use rand_pcg::Pcg32;

    use super::super::{Circle, Goal, Obstacle, Pose, Rect, RobotModel, Scenario, Side, degrees};
    use super::*;

    const SIZE: &str = "width_cm = 200\nheight_cm = 100\n";

    fn parsed(text: &str) -> Result<Fixed, ArenaError> {
        let path = Path::new("room.toml");
        load(
            path,
            &mut Files(&mut |name| {
                let text = (name == path).then(|| text.into());
                text.ok_or(std::io::ErrorKind::NotFound.into())
            }),
        )
    }

    fn scenario(text: &str) -> Scenario {
        parsed(text)
            .expect("a valid file")
            .scenario(&mut Pcg32::new(1, 1))
    }

    #[test]
    fn everything_a_file_says_is_taken() {
        let text = "width_cm = 200.5\nheight_cm = 100\n\
            start = { x_cm = 20, y_cm = 50, heading_deg = -90 }\n\
            goal = { x_cm = 180, y_cm = 50, radius_cm = 10 }\n\
            [[rect]]\nx_cm = 90\ny_cm = 40\nw_cm = 20\nh_cm = 30\n\
            [[circle]]\nx_cm = 40\ny_cm = 80\nr_cm = 5\n\
            [[polygon]]\npoints_cm = [[120, 10], [140, 10], [130, 30]]\n\
            [robot]\nstep_cm = 3\ncontact_radius_cm = 1.5\nfront_range_cm = 50\n\
            side_range_cm = 25\n";
        let scenario = scenario(text);
        assert_eq!(
            (scenario.world.width_cm(), scenario.world.height_cm()),
            (200.5, 100.0)
        );
        assert_eq!(
            scenario.start,
            Pose {
                x_cm: 20.0,
                y_cm: 50.0,
                heading: degrees(-90.0)
            }
        );
        assert_eq!(
            scenario.goal,
            Some(Goal {
                x_cm: 180.0,
                y_cm: 50.0,
                radius_cm: 10.0
            })
        );
        let [
            Obstacle::Rect(rect),
            Obstacle::Circle(circle),
            Obstacle::Polygon(polygon),
        ] = scenario.world.obstacles()
        else {
            panic!("{:?}", scenario.world.obstacles())
        };
        assert_eq!(
            *rect,
            Rect {
                x_cm: 90.0,
                y_cm: 40.0,
                w_cm: 20.0,
                h_cm: 30.0
            }
        );
        assert_eq!(
            *circle,
            Circle {
                x_cm: 40.0,
                y_cm: 80.0,
                r_cm: 5.0
            }
        );
        assert_eq!(polygon.points().len(), 3);
        let robot = scenario.robot;
        assert_eq!((robot.step_cm, robot.contact_radius_cm), (3.0, 1.5));
        assert_eq!(robot.range_cm(Side::Front), [0.0, 50.0]);
        assert_eq!(robot.range_cm(Side::Left), [0.0, 25.0]);
    }

    #[test]
    fn what_a_file_leaves_out_is_the_papers() {
        let scenario = scenario(SIZE);
        assert_eq!(scenario.robot, RobotModel::paper());
        assert_eq!(scenario.goal.map(|goal| goal.radius_cm), Some(12.0));
        let rover = self::scenario(&format!(
            "{SIZE}[robot]\nmodel = \"rover\"\nbeam_deg = 30\n"
        ));
        assert_eq!((rover.robot, rover.goal), (RobotModel::rover(30.0), None));
    }

    /// Each with the line it is on and words its message must hold.
    const BAD: [(&str, Option<usize>, &[&str]); 30] = [
        ("height_cm = 100", None, &["`width_cm`", "missing"]),
        ("width_cm = 100", None, &["`height_cm`", "missing"]),
        (
            "width_cm = 0\nheight_cm = 9",
            Some(1),
            &["`width_cm`", "greater than 0"],
        ),
        (
            "width_cm = 9\nheight_cm = -1",
            Some(2),
            &["`height_cm`", "greater than 0"],
        ),
        (
            "width_cm = inf\nheight_cm = 9",
            Some(1),
            &["`width_cm`", "between"],
        ),
        ("width_cm = nan\nheight_cm = 9", Some(1), &["`width_cm`"]),
        (
            "width_cm = 9e9\nheight_cm = 9",
            Some(1),
            &["`width_cm`", "100000"],
        ),
        (
            "width_cm = \"wide\"\nheight_cm = 9",
            Some(1),
            &["string", "f64"],
        ),
        (
            "width_cm = 9\nheight_cm = 9\nwidht = 3",
            Some(3),
            &["unknown field `widht`", "expected"],
        ),
        ("width_cm = 9\nheight_cm = ", Some(2), &["value"]),
        ("width_cm = 9\nwidth_cm = 9", Some(2), &["duplicate key"]),
        (
            "S[[rect]]\nx_cm = 1\ny_cm = 1\nw_cm = 5",
            Some(3),
            &["missing field `h_cm`"],
        ),
        (
            "S[[rect]]\nx_cm = 1\ny_cm = 1\nw_cm = 5\nh_cm = 0",
            Some(7),
            &["`h_cm`", "greater than 0"],
        ),
        (
            "S[[rect]]\nx_cm = 1\ny_cm = 1\nw_cm = 5\nh = 0",
            Some(7),
            &["unknown field `h`", "`h_cm`"],
        ),
        (
            "S[[rect]]\nx_cm = 180\ny_cm = 1\nw_cm = 25\nh_cm = 5",
            Some(3),
            &["rectangle", "inside"],
        ),
        (
            "S[[rect]]\nx_cm = -5\ny_cm = 1\nw_cm = 25\nh_cm = 5",
            Some(4),
            &["`x_cm`", "between 0"],
        ),
        (
            "S[[circle]]\nx_cm = 3\ny_cm = 50\nr_cm = 5",
            Some(3),
            &["circle", "inside the walls"],
        ),
        (
            "S[[circle]]\nx_cm = 50\ny_cm = 50\nr_cm = nan",
            Some(6),
            &["`r_cm`"],
        ),
        (
            "S[[polygon]]\npoints_cm = [[1, 1], [2, 2]]",
            Some(4),
            &["three points"],
        ),
        (
            "S[[polygon]]\npoints_cm = [[1, 1], [2, 2, 3], [1, 2]]",
            Some(4),
            &["point 2", "3 numbers"],
        ),
        (
            "S[[polygon]]\npoints_cm = [[0, 0], [9, 9], [9, 0], [0, 9]]",
            Some(4),
            &["cross itself", "point 1", "point 3"],
        ),
        (
            "S[[polygon]]\npoints_cm = [[0, 0], [9, 900], [9, 0]]",
            Some(3),
            &["polygon", "inside"],
        ),
        (
            "Sstart = { x_cm = 5, y_cm = 5 }",
            Some(3),
            &["missing field `heading_deg`"],
        ),
        (
            "Sstart = { x_cm = 1, y_cm = 50, heading_deg = 0 }",
            Some(3),
            &["start", "cannot stand free", "2 cm"],
        ),
        (
            "Sgoal = { x_cm = 50, y_cm = 50, radius_cm = 5 }\n\
             [[circle]]\nx_cm = 55\ny_cm = 50\nr_cm = 9",
            Some(3),
            &["goal", "in an obstacle"],
        ),
        (
            "Sgoal = { x_cm = 199, y_cm = 50, radius_cm = 5 }",
            Some(3),
            &["goal", "cannot stand free"],
        ),
        (
            "Sgoal = { x_cm = 250, y_cm = 50, radius_cm = 5 }",
            Some(3),
            &["`x_cm`", "200"],
        ),
        ("S[robot]\nbeam_deg = 10", Some(4), &["`beam_deg`", "rover"]),
        (
            "S[robot]\nmodel = \"tank\"",
            Some(4),
            &["unknown variant `tank`", "`rover`"],
        ),
        (
            "S[robot]\nmodel = \"rover\"\nfront_range_cm = 14",
            Some(5),
            &["`front_range_cm`", "between 15"],
        ),
    ];

    #[test]
    fn what_is_wrong_is_said_with_file_and_line() {
        for (text, line, words) in BAD {
            let text = text.replacen('S', SIZE, 1);
            let Err(error) = parsed(&text) else {
                panic!("accepted: {text}")
            };
            let message = error.to_string();
            let place = line.map_or("room.toml: ".into(), |line| {
                format!("room.toml, line {line}: ")
            });
            assert!(message.starts_with(&place), "{text:?}: {message}");
            assert!(
                words.iter().all(|word| message.contains(word)),
                "{text:?}: {message}"
            );
            assert!(!message.contains('\n'), "{text:?}: {message}");
        }
    }

    #[test]
    fn a_robot_that_fits_nowhere_is_refused() {
        let text = format!("{SIZE}[robot]\ncontact_radius_cm = 60\n");
        let message = parsed(&text).expect_err("too wide").to_string();
        assert!(
            message.contains("no room") && message.contains("60 cm"),
            "{message}"
        );
    }

    #[test]
    fn a_map_gives_the_size() {
        let text = "width_cm = 5\nheight_cm = 5\nmap = \"map.yaml\"\n";
        let message = parsed(text).expect_err("both").to_string();
        assert!(
            message.contains("line 3") && message.contains("`map`"),
            "{message}"
        );
        let message = parsed("map = \"nowhere.yaml\"\n")
            .expect_err("no such map")
            .to_string();
        assert!(
            message.contains("nowhere.yaml") && message.contains("read"),
            "{message}"
        );
    }
}
