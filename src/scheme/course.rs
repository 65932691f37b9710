//! The course of a frame: which passes run together, where barriers stand, and how rounds follow each other. Everything
//! that runs a program (tiles, threads, the simulated device, the explorer, devices) follows it.

use super::program::{Barrier, Program};

/// One part of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Clear the frame's words, and every pixel.
    Clear,
    /// A pass of the program, by its number.
    Pass(usize),
    /// Resolve every pixel; where the program repeats, it says whether a pixel needs another round.
    Resolve,
}

/// All stages of a frame. A stage is what runs between two barriers: the parts without one between them overlap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Course {
    stages: Vec<Vec<Part>>,
    repeats: bool,
}

/// Where a running frame is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct At {
    /// The stage.
    pub stage: usize,
    /// Rounds before this one.
    pub round: u32,
}

impl Course {
    /// The course of a program.
    #[must_use]
    pub fn of(program: &Program) -> Self {
        let mut stages = vec![vec![Part::Clear]];
        let passes =
            program.passes.iter().enumerate().map(|(n, pass)| (pass.before, Part::Pass(n)));
        for (before, part) in passes.chain([(program.before_resolve, Part::Resolve)]) {
            match stages.last_mut() {
                Some(stage) if before == Barrier::Missing => stage.push(part),
                _ => stages.push(vec![part]),
            }
        }
        Self { stages, repeats: program.repeats }
    }

    /// The stages of a first round, in order. Later rounds are without those that clear.
    #[must_use]
    pub fn stages(&self) -> &[Vec<Part>] {
        &self.stages
    }

    /// What runs in a stage.
    #[must_use]
    pub fn parts(&self, at: At) -> &[Part] {
        &self.stages[at.stage]
    }

    /// The stage after one that has ended, if there is one. `again`: its resolve asks for another round.
    #[must_use]
    pub fn after(&self, at: At, again: bool) -> Option<At> {
        if at.stage + 1 < self.stages.len() {
            return Some(At { stage: at.stage + 1, ..at });
        }
        // What overlaps with clear is not repeated with it: faults of that kind have one round.
        let first = self.stages.iter().position(|parts| !parts.contains(&Part::Clear))?;
        (self.repeats && again).then_some(At { stage: first, round: at.round + 1 })
    }

    /// Run a frame: `run` runs the parts of a stage to their end, and says whether a pixel asks for another round.
    /// Gives the number of rounds.
    ///
    /// # Errors
    /// What `run` fails with.
    pub fn walk<E>(
        &self,
        mut run: impl FnMut(&[Part]) -> std::result::Result<bool, E>,
    ) -> std::result::Result<u32, E> {
        let mut at = At::default();
        loop {
            let again = run(self.parts(at))?;
            match self.after(at, again) {
                Some(next) => at = next,
                None => return Ok(at.round + 1),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::super::program::{Pass, PassKind};
    use super::*;

    const COUNT: Pass = Pass::new("count", PassKind::Prepare, Barrier::Pixel);

    /// The parts in the order in which they run, with `rounds` rounds asked for; a barrier is a bar.
    fn run(program: &Program, rounds: usize) -> String {
        let (mut text, mut left) = (String::new(), rounds);
        let walked = Course::of(program).walk(|parts| {
            for part in parts {
                text += &match part {
                    Part::Clear => "c".to_owned(),
                    Part::Pass(number) => number.to_string(),
                    Part::Resolve => "r".to_owned(),
                };
            }
            text += "|";
            left -= usize::from(parts.contains(&Part::Resolve));
            Ok::<bool, Infallible>(left > 0)
        });
        let Ok(walked) = walked;
        format!("{text} {walked}")
    }

    #[test]
    fn barriers_divide_stages() {
        const APART: &[Pass] = &[COUNT, Pass::store(Barrier::Frame)];
        const TOGETHER: &[Pass] = &[COUNT, Pass::store(Barrier::Missing)];
        const WITH_CLEAR: &[Pass] = &[Pass::store(Barrier::Missing)];
        assert_eq!(run(&Program::STORE, 1), "c|0|r| 1");
        assert_eq!(run(&Program::of(APART), 1), "c|0|1|r| 1");
        assert_eq!(run(&Program::of(TOGETHER), 1), "c|01|r| 1");
        assert_eq!(run(&Program::of(WITH_CLEAR), 1), "c0|r| 1");
        let overlapping = Program { before_resolve: Barrier::Missing, ..Program::STORE };
        assert_eq!(run(&overlapping, 1), "c|0r| 1");
    }

    #[test]
    fn only_a_program_that_repeats_goes_on_and_clears_once() {
        const APART: &[Pass] = &[Pass::store(Barrier::Pixel)];
        const TOGETHER: &[Pass] = &[Pass::store(Barrier::Missing)];
        assert_eq!(run(&Program::repeated(APART), 3), "c|0|r|0|r|0|r| 3");
        assert_eq!(run(&Program::STORE, 3), "c|0|r| 1");
        let all = Program { before_resolve: Barrier::Missing, ..Program::repeated(TOGETHER) };
        assert_eq!(run(&all, 3), "c0r| 1");
    }
}
