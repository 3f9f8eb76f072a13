//! All figures of one source, each with its title and what is said below it.

use super::inputs::{Inputs, Place};
use super::lattice::Growth;
use super::palette::Palette;
use super::shape::Heading;
use super::situations::{Scene, capitalised};
use super::{
    Figure, Figures, lattice, learning, neuron, overview, page, patterns, position, sequence,
    staircases, trajectories,
};
use rover_simulator::experiment::Trial;

impl Inputs {
    /// Draws all figures and the page.
    pub fn draw(&self, place: &Place) -> Figures {
        let palette = Palette::new(&self.drives, &self.lessons);
        let scenes = self.setting.scenes(&self.drives);
        let growths = lattice::chosen(&self.drives, &palette, &self.coefficients.lattice);
        let mut figures = vec![
            self.overview(&scenes, &growths, &palette),
            self.lattice(&growths, &palette),
            self.neuron(),
            self.staircases(),
            self.trajectories(&scenes, &palette),
            self.position(place, &palette),
        ];
        figures.extend(scenes.last().map(|scene| self.sequence(scene, &palette)));
        figures.push(self.patterns(&palette));
        figures.push(self.learning());
        let report = page::page(&self.about.sources, &self.facts, &figures);
        Figures { figures, report }
    }

    /// The first trial as a scene, if there is one worth comparing.
    fn untrained(&self) -> Option<Scene> {
        let drive = self.first.as_ref()?;
        Some(Scene {
            title: if self.from_nothing {
                format!("First {}, nothing learned yet", self.unit)
            } else {
                format!("First {}", self.unit)
            },
            place: format!("{} 1", self.unit),
            drive: self.setting.shown(drive),
        })
    }

    fn overview(&self, scenes: &[Scene], growths: &[Growth], palette: &Palette) -> Figure {
        let untrained = self.untrained();
        let shown: Vec<&Scene> = untrained.iter().chain(scenes.last()).collect();
        let heading = Heading {
            title: "What the robot does, and what it perceives by".into(),
            subtitle: self.about.source.clone(),
            description: format!(
                "{} {}",
                trajectories::described(&shown),
                lattice::described(overview::chosen(growths))
            ),
        };
        Figure {
            name: "overview.svg",
            paper: "",
            caption:
                "Above, a drive at the start of learning and one after it; every move has the \
                colour of the pattern that chose it. Below, how two of these patterns grow from \
                what was sensed."
                    .into(),
            svg: overview::draw(&shown, &overview::chosen(growths), palette, &heading),
        }
    }

    fn lattice(&self, growths: &[Growth], palette: &Palette) -> Figure {
        let heading = Heading {
            title: "How patterns grow in the network".into(),
            subtitle: format!("{}; percepts of {}", self.about.source, self.about.drives),
            description: lattice::described(growths),
        };
        Figure {
            name: "lattice.svg",
            paper: "Fig. 2b, equations 1 and 3",
            caption: "Layer 1 of the reaction-diffusion network from the four corners that were \
                sensed until every cell has left the range from \u{2212}1 to 1: the pattern. Drawn \
                by the fixed-point network that drives the robot; layer 2 starts at 0 here, where \
                the robot adds noise of \u{b1}0.005. On the right, all 16 cells over time."
                .into(),
            svg: lattice::draw(growths, palette, &heading),
        }
    }

    fn neuron(&self) -> Figure {
        let lesson = neuron::Lesson::new(&self.history);
        let heading = Heading {
            title: "How a sensing neuron learns".into(),
            subtitle: self.about.source.clone(),
            description: lesson.described(),
        };
        Figure {
            name: "neuron.svg",
            paper: "Fig. 3, equations 5 and 6",
            caption: "The function of one sensing neuron, which turns a scaled reading into the \
                initial state of a corner cell. After an action that made things worse, a random \
                amount is added to the step in use and to all above it (5), or taken from it and \
                from all below it (6): the staircase never falls."
                .into(),
            svg: lesson.draw(&heading),
        }
    }

    fn staircases(&self) -> Figure {
        let heading = Heading {
            title: "What the sensing neurons learned".into(),
            subtitle: self.about.source.clone(),
            description: staircases::described(self.lessons.neurons()),
        };
        let ranges = &self.coefficients.ranges;
        Figure {
            name: "staircases.svg",
            paper: "Fig. 4",
            caption: "The four learned functions. Their values are the initial states of the \
                network's corner cells; all were 0 before learning."
                .into(),
            svg: staircases::draw(self.lessons.neurons(), ranges, &heading),
        }
    }

    fn trajectories(&self, scenes: &[Scene], palette: &Palette) -> Figure {
        let untrained = self.untrained();
        let compared = untrained.is_some();
        let scenes: Vec<&Scene> = untrained.iter().chain(scenes).collect();
        let heading = Heading {
            title: if compared {
                "Trajectories before and after learning".into()
            } else {
                "Trajectories".into()
            },
            subtitle: self.about.source.clone(),
            description: trajectories::described(&scenes),
        };
        let known = self.drives.iter().all(|drive| drive.arena_known);
        let mut caption = String::from(
            "Every move has the colour of the pattern that chose it. Triangles show where the \
             robot is headed. Scenes are the first ones in which a situation occurs, whatever the \
             robot made of it.",
        );
        if !known {
            caption += " The log does not say where walls and obstacles are: positions are by dead \
                reckoning from compass and moves, and grey dots are what the distance sensors saw.";
        }
        if self.emulated {
            caption += " Places, walls and obstacles are the emulation's: the rover knows none of \
                them.";
        }
        Figure {
            name: "trajectories.svg",
            paper: if self.setting.follow_direction {
                "Fig. 12 to 14"
            } else {
                "Fig. 5, 6, 8 and 9"
            },
            caption,
            svg: trajectories::draw(&scenes, palette, &heading),
        }
    }

    fn position(&self, place: &Place, palette: &Palette) -> Figure {
        let Place { drive, at } = place;
        let neurons = self.neurons_at(drive, *at);
        let numbered = format!(
            "{} {}, after {} actions",
            self.setting.unit, drive.number, at
        );
        let heading = Heading {
            title: "What the robot makes of one place".into(),
            subtitle: format!("{}; {numbered}", self.about.source),
            description: position::described(drive, *at),
        };
        let closeup = position::Closeup {
            drive,
            at: *at,
            neurons: &neurons,
            ranges: &self.coefficients.ranges,
        };
        Figure {
            name: "position.svg",
            paper: "Fig. 7",
            caption: "At A, each reading lies in one step of its sensing neuron (bold). The four \
                values of these steps are put into the corners of the network, which grows the \
                pattern, which stands for the turn. Grey sectors: what the distance sensors see. \
                Choose another place with rover figures LOG --trial N --at N."
                .into(),
            svg: position::draw(&closeup, palette, &heading),
        }
    }

    fn sequence(&self, scene: &Scene, palette: &Palette) -> Figure {
        let heading = Heading {
            title: "The sequence of patterns along a drive".into(),
            subtitle: format!("{}. {} ({})", self.about.source, scene.title, scene.place),
            description: sequence::described(&scene.drive, palette),
        };
        Figure {
            name: "sequence.svg",
            paper: if self.setting.follow_direction {
                "Fig. 14 and 15"
            } else {
                "Fig. 10"
            },
            caption: "Each dot is an action, in the row of the pattern that chose it; above, what \
                the sensors had in range. On the left the pattern, its code, how often it occurred \
                on this drive, and the turn it stands for."
                .into(),
            svg: sequence::draw(scene, palette, &heading),
        }
    }

    fn patterns(&self, palette: &Palette) -> Figure {
        let heading = Heading {
            title: if self.frozen && self.first.is_none() {
                "Patterns in use".into()
            } else {
                "Patterns in use after learning".into()
            },
            subtitle: format!("{}; {}", self.about.source, self.about.drives),
            description: patterns::described(palette),
        };
        let limit = self.coefficients.parameters().learning.phase_limit_deg;
        Figure {
            name: "patterns.svg",
            paper: "Fig. 10 and 15",
            caption:
                "How often each pattern chose an action, the pattern itself (filled cells are \
                at +1), its code (3), and the turn that was learned for it."
                    .into(),
            svg: patterns::draw(palette, limit, &heading),
        }
    }

    fn learning(&self) -> Figure {
        let sessions: Vec<&[Trial]> = self.sessions.iter().map(Vec::as_slice).collect();
        let follow_direction = self.setting.follow_direction;
        let heading = Heading {
            title: if self.frozen && self.first.is_none() {
                capitalised(&format!("{0} by {0}", self.unit))
            } else {
                format!("Learning, {0} by {0}", self.unit)
            },
            subtitle: self.about.sources.clone(),
            description: learning::described(&sessions, follow_direction),
        };
        let how = format!("How {}s went from the first to the last", self.unit);
        let caption = if sessions.len() > 1 {
            format!("{how}, over all sessions. The band holds the middle 80 % of them.")
        } else {
            format!(
                "{how}. More sessions (rover learn --sessions 20, or several logs) show how far they \
                 scatter."
            )
        };
        Figure {
            name: "learning.svg",
            paper: "",
            caption,
            svg: learning::draw(&sessions, follow_direction, self.unit, &heading),
        }
    }
}
