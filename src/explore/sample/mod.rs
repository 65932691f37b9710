//! Whole scenes: runs of a scene on the simulated device, one pixel of it as a litmus pixel, and minimised schedules.

mod executions;
pub mod minimise;
mod pixel;
mod replay;
pub mod stability;
mod walk;

pub use self::executions::Executions;
pub use self::pixel::{cut, litmus_of, sampled};
pub use self::replay::{SceneReplay, replay_scene};
