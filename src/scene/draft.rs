//! A scene before it is checked: what its source gives, what the command line overrides, and what is missing.

use glam::DVec3;
use serde::Deserialize;

use super::camera::FOV_Y;
use super::model::{GREY, Model};
use super::{
    Bounds, Camera, FileFormat, Light, Material, PointSize, Projection, Scene, Shading, Viewpoint,
    check,
};
use crate::error::{Error, Result};

/// Width and height of images where none are given, in pixels.
pub const DEFAULT_SIZE: [u32; 2] = [1024, 1024];

/// The background where a scene gives none: white.
pub const DEFAULT_BACKGROUND: [f32; 3] = [1.0; 3];

/// What the command line sets about a scene; it overrides the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Width and height of the image in pixels.
    pub size: Option<[u32; 2]>,
    /// The opacity of all materials and screen triangles, 0..1.
    pub alpha: Option<f32>,
    /// How light acts on all materials.
    pub shading: Option<Shading>,
    /// The radii of all point sets' points.
    pub points: PointSize,
    /// What it says of the camera.
    pub viewpoint: Viewpoint,
    /// The format of the scene's file; `None` for what its name's ending says.
    pub format: Option<FileFormat>,
}

/// The image's size: the option's, or else the file's, or else the default; checked.
pub(super) fn image_size(
    place: &str,
    own: Option<[u32; 2]>,
    overrides: &Overrides,
) -> Result<[u32; 2]> {
    if let Some(size) = overrides.size {
        check::size("--size", size)?;
    }
    let size = overrides.size.or(own).unwrap_or(DEFAULT_SIZE);
    check::size(place, size)?;
    Ok(size)
}

/// A scene before its camera, light and overrides.
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) size: Option<[u32; 2]>,
    pub(super) background: [f32; 3],
    pub(super) view: Option<View>,
    pub(super) light: Option<Light>,
    pub(super) model: Model,
}

impl Draft {
    pub(super) fn new(name: String, model: Model) -> Self {
        let (size, background) = (None, DEFAULT_BACKGROUND);
        Self { name, size, background, view: None, light: None, model }
    }

    /// Fills what is missing, applies the overrides and checks the whole.
    pub(super) fn finish(self, overrides: &Overrides) -> Result<Scene> {
        let size = image_size(&self.name, self.size, overrides)?;
        let bounds = self.model.bounds();
        let own = self.view.as_ref().map(|view| view.placed(bounds));
        let camera = overrides.viewpoint.camera(own, &self.model.cameras, bounds, size)?;
        let mut scene = Scene {
            name: self.name,
            size,
            background: self.background,
            light: self.light.unwrap_or_else(|| camera.default_light()),
            camera,
            cameras: self.model.cameras.into_iter().map(|camera| camera.names).collect(),
            materials: self.model.materials,
            objects: self.model.objects,
            screen: self.model.screen,
            volumes: self.model.volumes,
            warnings: self.model.warnings,
            files: Vec::new(),
        };
        if scene.materials.is_empty() {
            scene.materials.push(Material::new("default", GREY, 1.0));
        }
        overrides.apply(&mut scene)?;
        check::scene(&scene)?;
        Ok(scene)
    }
}

impl Overrides {
    /// What the option for radii wants, checked.
    pub(super) fn point_size(&self) -> Result<PointSize> {
        let names = ["--point-radius", "--point-scale"];
        self.points.check(names).map_err(|(name, problem)| Error::new(name, problem))?;
        Ok(self.points)
    }

    fn apply(&self, scene: &mut Scene) -> Result<()> {
        let no_points = || scene.objects.iter().all(|object| object.mesh.discs.is_empty());
        if self.points != PointSize::default() && no_points() {
            let idle = "--point-radius and --point-scale have no effect: there is no point set";
            scene.warnings.push(idle.to_owned());
        }
        if let Some(alpha) = self.alpha {
            check::fraction("--alpha", "alpha", alpha)?;
            scene.materials.iter_mut().for_each(|material| material.alpha = alpha);
            scene.screen.iter_mut().for_each(|triangle| triangle.color[3] = alpha);
        }
        if let Some(shading) = self.shading {
            scene.materials.iter_mut().for_each(|material| material.shading = shading);
        }
        Ok(())
    }
}

/// A camera as written: planes may be left out.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct View {
    eye: [f64; 3],
    target: [f64; 3],
    up: Option<[f64; 3]>,
    fov_y: Option<f64>,
    ortho_height: Option<f64>,
    near: Option<f64>,
    far: Option<f64>,
}

impl View {
    pub(super) fn problem(&self) -> Option<&'static str> {
        let both = self.fov_y.is_some() && self.ortho_height.is_some();
        both.then_some("camera.fov_y: must not be given together with camera.ortho_height")
    }

    /// The camera that is written, with planes around `bounds` where they are left out, or one that frames
    /// `bounds`.
    pub(super) fn camera(view: Option<&Self>, bounds: Bounds, size: [u32; 2]) -> Camera {
        view.map_or_else(|| Camera::frame(bounds, size), |view| view.placed(bounds))
    }

    fn placed(&self, bounds: Bounds) -> Camera {
        let projection = match self.ortho_height {
            Some(height) => Projection::Orthographic { height },
            None => Projection::Perspective { fov_y: self.fov_y.unwrap_or(FOV_Y) },
        };
        let mut camera = Camera {
            eye: self.eye.into(),
            target: self.target.into(),
            up: self.up.map_or(DVec3::Y, DVec3::from),
            projection,
            near: 0.0,
            far: 0.0,
        };
        let (near, far) = camera.planes_around(bounds);
        camera.near = self.near.unwrap_or(near);
        camera.far = self.far.unwrap_or(far);
        camera
    }
}
