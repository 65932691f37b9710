//! What the command line says of the camera, and the cameras that files have.

use glam::{DMat4, DVec3};

use super::camera::{FOV_Y, Framing, VIEW_FROM};
use super::{Bounds, Camera, Projection};
use crate::error::{Error, Result};

/// What replaces parts of a scene's camera; nothing by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Viewpoint {
    /// Position, in world units.
    pub eye: Option<[f64; 3]>,
    /// The point in the middle of the image.
    pub target: Option<[f64; 3]>,
    /// Roughly up; not zero.
    pub up: Option<[f64; 3]>,
    /// All of the scene, seen from one side.
    pub side: Option<Side>,
    /// A perspective of this vertical field of view, in degrees.
    pub fov_y: Option<f64>,
    /// Parallel rays.
    pub parallel: Option<Parallel>,
    /// Distance of the near plane.
    pub near: Option<f64>,
    /// Distance of the far plane.
    pub far: Option<f64>,
    /// A camera of the scene's files, by its name or its number from 0.
    pub camera: Option<String>,
}

/// How high the visible box of parallel rays is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parallel {
    /// As high as what a perspective shows at the target, or as all of the scene needs.
    Fitting,
    /// In world units.
    Height(f64),
}

/// The side that a scene is seen from. With y up, its front is at positive z; with another axis up, the scene is turned
/// from y to that axis the shortest way: with z up, its front is at negative y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From positive z.
    Front,
    /// From negative z.
    Back,
    /// From negative x.
    Left,
    /// From positive x.
    Right,
    /// From above, with the front below.
    Top,
    /// From below, with the front above.
    Bottom,
    /// From the direction (1, 1, 1).
    Iso,
}

/// A camera that a file has. Its planes may be left out.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedCamera {
    /// Its own name, and that of what carries it; empty where there is none.
    pub names: [String; 2],
    /// From its space, where it looks along -z with y up, to the world.
    pub transform: DMat4,
    /// Its projection.
    pub projection: Projection,
    /// Distances of the near and the far plane.
    pub planes: [Option<f64>; 2],
}

/// The options by the camera's fields, as in the messages of [`Camera::check`].
const OPTIONS: [(&str, &str); 6] = [
    ("camera.eye", "--eye"),
    ("camera.target", "--target"),
    ("camera.up", "--up"),
    ("camera.fov_y", "--fov"),
    ("camera.ortho_height", "--ortho"),
    ("camera.near", "--near"),
];

impl Viewpoint {
    /// The camera of a scene whose file has the camera `own`, or none.
    ///
    /// # Errors
    /// The option, and what would be right.
    pub(super) fn camera(
        &self,
        own: Option<Camera>,
        cameras: &[NamedCamera],
        bounds: Bounds,
        size: [u32; 2],
    ) -> Result<Camera> {
        if *self == Self::default() {
            return Ok(own.unwrap_or_else(|| Camera::frame(bounds, size)));
        }
        if self.up.is_some_and(|up| DVec3::from(up).try_normalize().is_none()) {
            return Err(Error::new("--up", "must be a direction, not zero, finite"));
        }
        let named = self.camera.as_deref().map(|name| find(cameras, name)).transpose()?;
        let named = named.map(|camera| camera.place(bounds));
        let mut camera = match named.or(own).filter(|_| self.side.is_none()) {
            Some(camera) => camera,
            None => self.framed(bounds, size),
        };
        let moved = self.eye.is_some() || self.target.is_some();
        if let Some(eye) = self.eye {
            camera.eye = eye.into();
        }
        if let Some(target) = self.target {
            camera.target = target.into();
        }
        if let Some(up) = self.up.filter(|_| self.side.is_none()) {
            camera.up = up.into();
        }
        if let Some(fov_y) = self.fov_y {
            camera.projection = Projection::Perspective { fov_y };
        }
        match (self.parallel, camera.projection) {
            (Some(Parallel::Height(height)), _) => {
                camera.projection = Projection::Orthographic { height };
            }
            (Some(Parallel::Fitting), Projection::Perspective { .. }) => {
                let height =
                    2.0 * camera.half_extent([1, 1])[1] * (camera.eye - camera.target).length();
                camera.projection = Projection::Orthographic { height };
            }
            _ => {}
        }
        if moved || self.side.is_some() || self.parallel.is_some() {
            (camera.near, camera.far) = camera.planes_around(bounds);
        }
        camera.near = self.near.unwrap_or(camera.near);
        camera.far = self.far.unwrap_or(camera.far);
        camera.check("camera").map_err(|error| named_option(&error))?;
        Ok(camera)
    }

    /// All of the scene, from a side or from the default direction.
    fn framed(&self, bounds: Bounds, size: [u32; 2]) -> Camera {
        let up = self.up.map_or(DVec3::Y, |up| DVec3::from(up).normalize_or_zero());
        let [from, up] = self.side.map_or([VIEW_FROM, DVec3::Y], Side::axes).map(|v| turned(v, up));
        let framing = match self.parallel {
            Some(_) => Framing::Parallel,
            None => Framing::Perspective(self.fov_y.unwrap_or(FOV_Y)),
        };
        Camera::framed(bounds, size, from, up, framing)
    }
}

impl Side {
    /// Towards the eye, and up in the picture, with y up.
    fn axes(self) -> [DVec3; 2] {
        match self {
            Self::Front => [DVec3::Z, DVec3::Y],
            Self::Back => [-DVec3::Z, DVec3::Y],
            Self::Left => [-DVec3::X, DVec3::Y],
            Self::Right => [DVec3::X, DVec3::Y],
            Self::Top => [DVec3::Y, -DVec3::Z],
            Self::Bottom => [-DVec3::Y, DVec3::Z],
            Self::Iso => [DVec3::ONE, DVec3::Y],
        }
    }
}

/// A direction turned as the y axis is turned to `up`, the shortest way (Rodrigues); about the x axis to -y.
fn turned(v: DVec3, up: DVec3) -> DVec3 {
    let (axis, cosine) = (DVec3::Y.cross(up), up.y);
    if cosine <= -1.0 + 1e-12 {
        return DVec3::new(v.x, -v.y, -v.z);
    }
    v * cosine + axis.cross(v) + axis * (axis.dot(v) / (1.0 + cosine))
}

fn find<'a>(cameras: &'a [NamedCamera], name: &str) -> Result<&'a NamedCamera> {
    let by_name = cameras.iter().find(|camera| camera.names.iter().any(|own| own == name));
    let by_number = || name.parse::<usize>().ok().and_then(|number| cameras.get(number));
    by_name.filter(|_| !name.is_empty()).or_else(by_number).ok_or_else(|| {
        let label = |(i, camera): (usize, &NamedCamera)| {
            let own = camera.names.iter().find(|own| !own.is_empty());
            own.map_or_else(|| i.to_string(), |own| format!("{own:?}"))
        };
        let names: Vec<String> = cameras.iter().enumerate().map(label).take(20).collect();
        let there = match names[..] {
            [] => "the scene's files have no camera".to_owned(),
            _ => format!("there are {}", names.join(", ")),
        };
        Error::new("--camera", format!("{name:?} is none of the cameras; {there}"))
    })
}

impl NamedCamera {
    /// Its planes are around `bounds` where they are left out.
    fn place(&self, bounds: Bounds) -> Camera {
        let axis = |axis: DVec3| self.transform.transform_vector3(axis).normalize_or_zero();
        let eye = self.transform.transform_point3(DVec3::ZERO);
        // The target decides how far parallel rays would be; the middle of what is seen is as good as any.
        let distance = (bounds.center() - eye).length();
        let distance = if distance > 0.0 { distance } else { 1.0 };
        let mut camera = Camera {
            eye,
            target: eye - axis(DVec3::Z) * distance,
            up: axis(DVec3::Y),
            projection: self.projection,
            near: 0.0,
            far: 1.0,
        };
        let (near, far) = camera.planes_around(bounds);
        camera.near = self.planes[0].unwrap_or(near);
        // What lies in front of its near plane needs no far one.
        let behind = if far > camera.near { far } else { camera.near.abs() * 2.0 + 1.0 };
        camera.far = self.planes[1].unwrap_or(behind);
        camera
    }
}

/// An error about a camera's field as one about the option.
fn named_option(error: &Error) -> Error {
    let problem = error.problem();
    let option = OPTIONS.iter().find(|(field, _)| problem.starts_with(field));
    let mut text = problem.to_owned();
    for (field, option) in OPTIONS.into_iter().chain([("camera.far", "--far")]) {
        text = text.replace(field, option);
    }
    match option {
        Some((_, option)) => {
            let rest = text.strip_prefix(option).unwrap_or(&text);
            Error::new(*option, rest.trim_start_matches([':', ' ']))
        }
        None => Error::new("--eye", text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 6.0) };
    const SIZE: [u32; 2] = [200, 100];

    fn camera(viewpoint: &Viewpoint) -> Camera {
        viewpoint.camera(None, &[], BOX, SIZE).unwrap()
    }

    fn unit(camera: &Camera) -> DVec3 {
        (camera.eye - camera.target).normalize()
    }

    #[test]
    fn nothing_said_changes_nothing() {
        let own = Camera { eye: DVec3::ONE * 9.0, ..Camera::frame(BOX, SIZE) };
        let found = Viewpoint::default().camera(Some(own), &[], BOX, SIZE).unwrap();
        assert_eq!((found, camera(&Viewpoint::default())), (own, Camera::frame(BOX, SIZE)));
    }

    /// Every side, and every axis up: the whole box is inside of the picture and touches its margin.
    #[test]
    fn sides_show_all_of_the_scene() {
        use Side::{Back, Bottom, Front, Iso, Left, Right, Top};
        for side in [Front, Back, Left, Right, Top, Bottom, Iso] {
            for up in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
                for parallel in [None, Some(Parallel::Fitting)] {
                    let viewpoint = Viewpoint {
                        side: Some(side),
                        up: Some(up.to_array()),
                        parallel,
                        ..Viewpoint::default()
                    };
                    let camera = camera(&viewpoint);
                    let to_clip = camera.view_projection(SIZE);
                    let places = BOX.corners().map(|corner| to_clip.project_point3(corner));
                    let farthest = places.map(|p| p.x.abs().max(p.y.abs()));
                    let farthest = farthest.into_iter().fold(0.0, f64::max);
                    assert!((0.8..=1.0).contains(&farthest), "{side:?} {up} {farthest}");
                    assert!(places.iter().all(|p| (0.0..=1.0).contains(&p.z)), "{side:?} {up}");
                }
            }
        }
    }

    #[test]
    fn the_front_is_at_positive_z_or_with_z_up_at_negative_y() {
        let side = |side, up: [f64; 3]| {
            let viewpoint = Viewpoint { side: Some(side), up: Some(up), ..Viewpoint::default() };
            let camera = camera(&viewpoint);
            (unit(&camera), camera.axes()[1])
        };
        let near = |a: (DVec3, DVec3), b: (DVec3, DVec3)| {
            assert!((a.0 - b.0).length() + (a.1 - b.1).length() < 1e-12, "{a:?} {b:?}");
        };
        near(side(Side::Front, [0.0, 1.0, 0.0]), (DVec3::Z, DVec3::Y));
        near(side(Side::Front, [0.0, 0.0, 1.0]), (-DVec3::Y, DVec3::Z));
        near(side(Side::Top, [0.0, 0.0, 1.0]), (DVec3::Z, DVec3::Y));
        near(side(Side::Right, [0.0, 0.0, 1.0]), (DVec3::X, DVec3::Z));
        near(side(Side::Front, [0.0, 0.0, -1.0]), (DVec3::Y, -DVec3::Z));
        near(side(Side::Front, [0.0, -1.0, 0.0]), (-DVec3::Z, -DVec3::Y));
        near(side(Side::Left, [0.0, -1.0, 0.0]), (-DVec3::X, -DVec3::Y));
    }

    #[test]
    fn parts_of_a_camera_are_replaced() {
        let own = Camera::frame(BOX, SIZE);
        let apply = |viewpoint: Viewpoint| viewpoint.camera(Some(own), &[], BOX, SIZE).unwrap();
        let found = apply(Viewpoint { eye: Some([0.0, 0.0, 50.0]), ..Viewpoint::default() });
        assert_eq!((found.eye, found.target), (DVec3::Z * 50.0, own.target));
        assert!(found.near < 44.0 && found.far > 50.0, "planes follow the eye");
        let found = apply(Viewpoint { near: Some(0.5), far: Some(99.0), ..Viewpoint::default() });
        assert_eq!((found.eye, found.near, found.far), (own.eye, 0.5, 99.0));
        let parallel = Some(Parallel::Height(3.0));
        let found = apply(Viewpoint { parallel, ..Viewpoint::default() });
        assert_eq!(found.projection, Projection::Orthographic { height: 3.0 });
    }

    #[test]
    fn cameras_of_files_are_found_by_name_or_number() {
        let camera = |name: &str, z| NamedCamera {
            names: [String::new(), name.to_owned()],
            transform: DMat4::from_translation(DVec3::new(0.0, 0.0, z)),
            projection: Projection::Perspective { fov_y: 30.0 },
            planes: [Some(0.25), None],
        };
        let cameras = [camera("a", 10.0), camera("b", 20.0)];
        let find = |name: &str| {
            let viewpoint = Viewpoint { camera: Some(name.to_owned()), ..Viewpoint::default() };
            viewpoint.camera(None, &cameras, BOX, SIZE)
        };
        for (name, z) in [("b", 20.0), ("0", 10.0)] {
            let found = find(name).unwrap();
            assert_eq!((found.eye.z, found.near, found.up), (z, 0.25, DVec3::Y), "{name}");
            assert_eq!(unit(&found), DVec3::Z);
        }
        assert!(find("c").unwrap_err().to_string().contains("there are \"a\", \"b\""));
    }

    #[test]
    fn wrong_options_are_named() {
        let vector = Some([1.0, 2.0, 3.0]);
        let cases = [
            (Viewpoint { eye: vector, target: vector, ..Viewpoint::default() }, "--target"),
            (Viewpoint { up: Some([0.0; 3]), ..Viewpoint::default() }, "--up"),
            (Viewpoint { fov_y: Some(180.0), ..Viewpoint::default() }, "--fov"),
            (Viewpoint { near: Some(-1.0), ..Viewpoint::default() }, "--near"),
            (Viewpoint { near: Some(9.0), far: Some(1.0), ..Viewpoint::default() }, "--near"),
            (
                Viewpoint { parallel: Some(Parallel::Height(0.0)), ..Viewpoint::default() },
                "--ortho",
            ),
        ];
        for (viewpoint, option) in cases {
            let error = viewpoint.camera(None, &[], BOX, SIZE).unwrap_err();
            assert_eq!(error.place(), option, "{error}");
            assert!(!error.problem().contains("camera."), "{error}");
        }
    }
}
