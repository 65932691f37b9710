//! A contract as `fragloom methods --json` lists it: flat, with a flag for each question that a reader may have.

use serde::{Serialize, Serializer};

use super::contract::{Contract, Demand, Dependence, Form, Keeps};
use super::program::Program;
use crate::fragment::Data;
use crate::num::depth::Format;

/// The fields, in their order; others rely on their names.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    title: &'static str,
    paper: &'static str,
    section: &'static str,
    form: Form,
    program: Program,
    words: &'static str,
    frame_words: &'static str,
    published_words: Option<&'static str>,
    keeps: Keeps,
    identical: bool,
    crosses: bool,
    settled_overflow: bool,
    exact_when: &'static str,
    arrival_dependent: bool,
    racy: bool,
    right_depths: bool,
    judged: bool,
    ties: &'static str,
    overflow: &'static str,
    needs: &'static str,
    wgsl: Option<&'static str>,
    depth_format: Option<Format>,
    depth_bits: u32,
    data: Option<Data>,
    default_k: Option<u32>,
    max_k: u32,
    max_pixels: u32,
    demand: Demand,
    page: u32,
    interlock: bool,
}

impl Listed {
    fn new(contract: &Contract) -> Self {
        let c = contract;
        Self {
            name: c.name,
            title: c.title,
            paper: c.paper,
            section: c.section,
            form: c.form,
            program: c.program,
            words: c.words,
            frame_words: c.frame_words,
            published_words: c.published_words,
            keeps: c.keeps,
            identical: c.keeps_alike(),
            crosses: c.crosses(),
            settled_overflow: c.settles_overflow(),
            exact_when: c.exact_when,
            arrival_dependent: c.is_arrival_dependent(),
            racy: c.is_racy(),
            right_depths: c.dependence == Dependence::Ties,
            judged: c.is_judged(),
            ties: c.ties,
            overflow: c.overflow.text(),
            needs: c.needs,
            wgsl: c.wgsl,
            depth_format: c.depth_format,
            depth_bits: c.depth_bits,
            data: c.data,
            default_k: c.default_k,
            max_k: c.max_k,
            max_pixels: c.max_pixels,
            demand: c.demand,
            page: c.page,
            interlock: c.is_interlocked(),
        }
    }
}

impl Serialize for Contract {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Listed::new(self).serialize(serializer)
    }
}
