//! The papers' tables and figures: theirs next to ours.
//!
//! An [`Experiment`] gives a table, which is written as CSV; a plot as SVG, where the paper draws curves; pictures; and a
//! verdict: as in the paper, or how it differs. What is
//! counted (probes, atomic operations, ages, bytes) is the same everywhere; seconds are this machine's, and only their
//! trend is comparable.

mod approximate;
mod bundled;
mod ha_figures;
mod ha_memory;
mod importance;
mod merge;
mod occupancy;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::report::grid;

pub use crate::image::plot;
use plot::Plot;

/// A published table or figure.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Its name on the command line.
    pub name: &'static str,
    /// Where it was published.
    pub paper: &'static str,
    /// What it shows.
    pub about: &'static str,
    run: fn(&Scale) -> Result<Outcome>,
}

/// The scale of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// Pixels of the picture on each side, where the experiment draws one.
    pub edge: u32,
    /// How often each point is timed; the median counts.
    pub repeats: u32,
}

/// The result of an experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// The experiment's name.
    pub experiment: &'static str,
    /// What the numbers say, in a sentence or two.
    pub summary: String,
    /// Names of the columns, with units.
    pub columns: Vec<&'static str>,
    /// Rows of cells.
    pub rows: Vec<Vec<String>>,
    /// The curves, if there are any.
    #[serde(skip)]
    pub plot: Option<Plot>,
    /// Pictures, by what they show.
    #[serde(skip)]
    pub pictures: Vec<(String, Image)>,
    /// Whether what must hold does, if the paper's point can be decided here.
    pub verdict: Option<Verdict>,
    /// Values that should equal the paper's and do not.
    pub differences: Vec<String>,
}

/// How ours compares with the paper's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// All that must hold does.
    pub as_in_the_paper: bool,
    /// Otherwise, what does not, and why.
    pub how: String,
}

impl Verdict {
    /// From what does not hold.
    #[must_use]
    pub fn of(differences: &[String]) -> Self {
        Self { as_in_the_paper: differences.is_empty(), how: differences.join("; ") }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.as_in_the_paper {
            f.write_str("as in the paper")
        } else {
            write!(f, "differs: {}", self.how)
        }
    }
}

/// All experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "ha-table1",
        paper: "HA-buffer 2013, Table 1",
        about: "memory of A-buffers by number of fragments",
        run: ha_memory::table,
    },
    Experiment {
        name: "ha-fig5",
        paper: "HA-buffer 2013, Figure 5",
        about: "insertion by load factor",
        run: ha_figures::loads,
    },
    Experiment {
        name: "ha-fig8",
        paper: "HA-buffer 2013, Figure 8",
        about: "squares that are brought together until they lie on each other",
        run: ha_figures::stack,
    },
    Experiment {
        name: "varik-table1",
        paper: "importance maps 2017, Table 1",
        about: "how three k-buffers choose k and take memory",
        run: importance::overview::overview,
    },
    Experiment {
        name: "varik-table2",
        paper: "importance maps 2017, Table 2",
        about: "k and loss of fixed, dynamic and variable k in one budget",
        run: importance::losses::losses,
    },
    Experiment {
        name: "varik-fig1",
        paper: "importance maps 2017, Figure 1",
        about: "beard and smoke by budget",
        run: importance::losses::teaser,
    },
    Experiment {
        name: "varik-fig2",
        paper: "importance maps 2017, Figure 2",
        about: "what fixed, dynamic and variable k give each pixel",
        run: importance::maps::allocation,
    },
    Experiment {
        name: "varik-fig3",
        paper: "importance maps 2017, Figure 3",
        about: "the pipeline",
        run: importance::overview::pipeline,
    },
    Experiment {
        name: "varik-fig4",
        paper: "importance maps 2017, Figure 4",
        about: "the factors of importance as maps",
        run: importance::maps::factors,
    },
    Experiment {
        name: "varik-fig5",
        paper: "importance maps 2017, Figure 5",
        about: "bottles and greenhouse by budget",
        run: importance::losses::evaluation,
    },
    Experiment {
        name: "occupancy-fig1",
        paper: "occupancy culling 2014, Figure 1",
        about: "the k+-buffer with and without culling, by k",
        run: occupancy::culling,
    },
    Experiment {
        name: "merge-fig1",
        paper: "z-thickness 2021, Figure 1",
        about: "a ball and cubes with faces in common planes",
        run: merge::zfighting::teaser,
    },
    Experiment {
        name: "merge-fig3",
        paper: "z-thickness 2021, Figure 3",
        about: "flicker of two cubes with common planes, on an orbit",
        run: merge::zfighting::orbit,
    },
    Experiment {
        name: "merge-fig5",
        paper: "z-thickness 2021, Figures 2, 4 and 5",
        about: "the slabs of a pixel, before and after they are merged",
        run: merge::model::slabs,
    },
    Experiment {
        name: "merge-fig6",
        paper: "z-thickness 2021, Figure 6",
        about: "smooth merging and merging by overlap, across an intersection",
        run: merge::intersections::profiles,
    },
    Experiment {
        name: "merge-fig7",
        paper: "z-thickness 2021, Figure 7",
        about: "intersections by beta",
        run: merge::intersections::betas,
    },
    Experiment {
        name: "merge-fig8",
        paper: "z-thickness 2021, Figure 8",
        about: "opacity inside of a slab, by beta",
        run: merge::model::opacities,
    },
    Experiment {
        name: "merge-fig9",
        paper: "z-thickness 2021, Figure 9",
        about: "what is inside of a nearly opaque ball, by beta",
        run: merge::ghosts::betas,
    },
    Experiment {
        name: "merge-fig10",
        paper: "z-thickness 2021, Figure 10",
        about: "errors of k+-buffer and merging on three scenes",
        run: merge::quality::errors,
    },
    Experiment {
        name: "merge-fig11",
        paper: "z-thickness 2021, Figure 11",
        about: "plates with marks in a ball of discs",
        run: merge::quality::marks,
    },
    Experiment {
        name: "merge-fig12",
        paper: "z-thickness 2021, Figure 12",
        about: "what merging costs beside sorting",
        run: merge::cost::passes_of_methods,
    },
    Experiment {
        name: "merge-fig13",
        paper: "z-thickness 2021, Figure 13",
        about: "absorbance along a ray through ten groups of layers",
        run: merge::absorbance::staircases,
    },
    Experiment {
        name: "merge-fig14",
        paper: "z-thickness 2021, Figure 14",
        about: "two meshes compared by colour, and surfels without speckle",
        run: merge::comparison::comparative,
    },
    Experiment {
        name: "merge-fig15",
        paper: "z-thickness 2021, Figure 15",
        about: "a ghosted illustration",
        run: merge::ghosts::illustration,
    },
    Experiment {
        name: "merge-fig16",
        paper: "z-thickness 2021, Figure 16",
        about: "volumes that surfaces intersect",
        run: merge::hybrid::bands,
    },
    Experiment {
        name: "merge-fig17",
        paper: "z-thickness 2021, Figure 17",
        about: "ambient occlusion and depth of field over merged layers",
        run: merge::screen::effects,
    },
    Experiment {
        name: "approximate",
        paper: "McGuire 2013, Münstermann 2018, Salvi 2011 and 2014, Maule 2013, Enderton 2010",
        about: "all approximations on four scenes: errors, time and memory, and the papers' rankings",
        run: approximate::gallery,
    },
];

/// Figures that another's experiment shows as well.
const SHOWN_WITH: [(&str, &str); 2] = [("merge-fig2", "merge-fig5"), ("merge-fig4", "merge-fig5")];

/// The experiment of that name, or of the figure of that name.
///
/// # Errors
/// No experiment has that name; the message lists those that exist.
pub fn experiment(name: &str) -> Result<&'static Experiment> {
    let shown = SHOWN_WITH.iter().find(|(figure, _)| *figure == name);
    let own = shown.map_or(name, |(_, experiment)| experiment);
    EXPERIMENTS.iter().find(|experiment| experiment.name == own).ok_or_else(|| {
        let names: Vec<&str> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
        let problem = format!("no experiment is called {name:?}; there are {}", names.join(", "));
        Error::new("EXPERIMENT", problem)
    })
}

impl Experiment {
    /// Run it.
    ///
    /// # Errors
    /// A scene that cannot be drawn at this scale.
    pub fn run(&self, scale: &Scale) -> Result<Outcome> {
        (self.run)(scale)
    }
}

/// A word of a contract as it is written in JSON.
fn word(word: &impl Serialize) -> String {
    serde_json::to_value(word).map_or_else(
        |error| error.to_string(),
        |value| value.as_str().map_or_else(|| value.to_string(), str::to_owned),
    )
}

impl Outcome {
    /// An empty one.
    #[must_use]
    pub fn new(experiment: &'static str, summary: String) -> Self {
        Self {
            experiment,
            summary,
            columns: Vec::new(),
            rows: Vec::new(),
            plot: None,
            pictures: Vec::new(),
            verdict: None,
            differences: Vec::new(),
        }
    }

    /// The table as CSV, with a line of names first.
    #[must_use]
    pub fn csv(&self) -> String {
        grid::csv(self.columns.iter().copied(), &self.rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_experiments() {
        assert_eq!(experiment("ha-fig5").unwrap().name, "ha-fig5");
        for (figure, name) in SHOWN_WITH {
            assert_eq!(experiment(figure).unwrap().name, name);
            assert!(EXPERIMENTS.iter().all(|experiment| experiment.name != figure));
        }
        assert!(experiment("fig").unwrap_err().problem().contains("ha-table1, ha-fig5, ha-fig8"));
    }

    #[test]
    fn cells_with_commas_are_quoted() {
        let outcome = Outcome {
            columns: vec!["a", "b, c"],
            rows: vec![vec!["1".into(), "say \"2\"".into()]],
            ..Outcome::new("x", String::new())
        };
        assert_eq!(outcome.csv(), "a,\"b, c\"\n1,\"say \"\"2\"\"\"\n");
    }
}
