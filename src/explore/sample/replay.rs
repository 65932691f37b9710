//! Replaying a scene's token.

use crate::catalogue::Catalogue;
use crate::error::{Error, Result};
use crate::exec::sim::policy::Policy;
use crate::explore::replay::token::SceneToken;
use crate::render::{Exec, Options, Rendering, Sim, render};
use crate::scene::{self, Overrides, Scene};

/// The result of replaying a scene's token.
#[derive(Clone, Debug)]
pub struct SceneReplay {
    /// The scene that it names.
    pub scene: Scene,
    /// How it was drawn.
    pub options: Options,
    /// The picture and its accounting from the replay.
    pub rendering: Rendering,
}

impl SceneToken {
    /// The scene that the token names, at its size.
    ///
    /// # Errors
    /// The scene does not exist, or it is invalid.
    pub fn scene(&self) -> Result<Scene> {
        scene::load(&self.scene, &Overrides { size: Some(self.size), ..Overrides::default() })
    }

    /// How the token draws it.
    ///
    /// # Errors
    /// The catalogue has no such method, or the token's values do not fit it.
    pub fn options(&self, catalogue: &Catalogue) -> Result<Options> {
        let policy = Policy::parse(&self.schedule)?;
        let resident = usize::try_from(self.resident).unwrap_or(usize::MAX);
        let sim = Sim { policy, seed: self.seed, resident, ..Sim::default() };
        let options = Options {
            method: catalogue.find("TOKEN", &self.method)?,
            k: self.k,
            exec: Exec::Sim(sim),
            ..Options::default()
        };
        options.check()?;
        Ok(options)
    }
}

/// Draw what a scene's token names, in its interleaving.
///
/// # Errors
/// The scene or the method does not exist, or has changed since: the result is another.
pub fn replay_scene(catalogue: &Catalogue, token: &SceneToken) -> Result<SceneReplay> {
    let scene = token.scene()?;
    let options = token.options(catalogue)?;
    let rendering = render(&scene, &options)?;
    if rendering.report.result_hash() != token.fragments_hash {
        let problem = "the token's scene or method has changed since: it gives another result";
        return Err(Error::new("TOKEN", problem));
    }
    Ok(SceneReplay { scene, options, rendering })
}

impl SceneReplay {
    /// Whether the replay shows that a fragment was lost, stored twice or torn, or that another promise was broken.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        let report = &self.rendering.report;
        let lost = report.dropped.get("lost").is_some_and(|&n| n > 0);
        lost || report.duplicated + report.torn > 0 || !report.violations.is_empty()
    }
}
