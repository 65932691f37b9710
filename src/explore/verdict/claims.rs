//! The papers' claims, stated so that a machine can decide them. Verdicts are computed, never recorded.

use serde::Serialize;

use super::check::inherit;
use super::laws::{Law, Tried};
use super::plan::Plan;
use super::survey::{Survey, properties};
use super::{Finding, Scope, Verdict};
use crate::catalogue::Catalogue;
use crate::error::{Error, Result};
use crate::explore::program::instances::Family;
use crate::explore::program::machine::Conditions;
use crate::explore::program::subject::Subject;
use crate::explore::search::explored::Limits;
use crate::explore::search::property::Property;

/// A published claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Claim {
    /// C1 to C17.
    pub id: &'static str,
    /// Which paper says so.
    pub paper: &'static str,
    /// Where.
    pub section: &'static str,
    /// What it says, as it is checked here.
    pub statement: &'static str,
    /// The methods it is checked on; none if it needs one that does not exist yet.
    pub methods: &'static [&'static str],
    /// Which k.
    #[serde(skip)]
    ks: Ks,
    /// The properties that make up the claim: it is violated if one of them is.
    #[serde(skip)]
    properties: &'static [Property],
    /// Or a law that is tried on a grid of instances, whatever the memory model.
    #[serde(skip)]
    law: Option<Law>,
}

/// Which k a claim is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ks {
    /// Those of the plan.
    Planned,
    /// 1, and the number of fragments or more.
    Ends,
}

const KPLUS: &str = "Vasilakis, Fudos 2014 (k+-buffer)";
const IMPORTANCE: &str = "variable k-buffer using importance maps, 2017";
const HA: &str = "HA-buffer, 2013";
const CULLING: &str = "occupancy fragment culling, 2014";
const SUMS: &str = "McGuire 2013, Münstermann 2018, Maule 2013, Enderton 2010; Salvi 2011 and 2014";
const THICKNESS: &str = "fragment merging with z-thickness";

const RESULT: &[Property] = &[Property::Keeps, Property::Intact];

const fn claim(
    id: &'static str,
    paper: &'static str,
    section: &'static str,
    statement: &'static str,
    methods: &'static [&'static str],
) -> Claim {
    Claim { id, paper, section, statement, methods, ks: Ks::Planned, properties: RESULT, law: None }
}

/// C1 to C17.
pub const CLAIMS: &[Claim] = &[
    claim(
        "C1",
        KPLUS,
        "3.1, 3.2, Algorithms 1 and 3",
        "after any interleaving a pixel holds exactly its k nearest fragments; the cull test outside of the lock never \
         loses one",
        &[
            "kplus-array",
            "kplus-array@published",
            "kplus-array@root-first",
            "kplus-heap",
            "kplus-heap@published",
            "kplus-heap@root-first",
            "kplus-sb",
        ],
    ),
    Claim {
        properties: &[Property::Keeps, Property::Intact, Property::MutualExclusion],
        ..claim(
            "C2",
            KPLUS,
            "3.1, Algorithm 1",
            "a plain store is enough to release the lock: the next holder sees all that was written under it",
            &[
                "kplus-array",
                "kplus-array@M1",
                "kplus-array@published",
                "kplus-heap",
                "kplus-heap@M1",
            ],
        )
    },
    Claim {
        ks: Ks::Ends,
        ..claim(
            "C3",
            KPLUS,
            "3.4",
            "with k = 1 a pixel holds the nearest fragment (a Z-buffer), with k at least the number of fragments all of \
             them (an A-buffer), also on the near and far planes and at equal depths",
            &[
                "kplus-array",
                "kplus-array@published",
                "kplus-heap",
                "kplus-sb",
                "kplus-sb@heap",
                "kb",
                "kb-mdt64",
                "kb-ps",
                "kb-ab-ll",
                "z-buffer",
                "ab-array",
                "ab-ll",
                "s-buffer",
            ],
        )
    },
    Claim {
        properties: &[Property::Keeps, Property::Intact, Property::OneOutcome],
        ..claim(
            "C4",
            KPLUS,
            "2, 3",
            "read-modify-write hazards do not lose, double or tear a fragment: said to fail for kb, and to hold for the \
             k+-buffer",
            &["kb", "kplus-array", "kplus-array@published"],
        )
    },
    claim(
        "C5",
        KPLUS,
        "2, 4",
        "conversion of depths loses nothing: said to fail for kb-mdt32, where fragments that become equal are confused, \
         and to hold for the k+-buffer",
        &["kb-mdt32", "kplus-array", "kplus-heap"],
    ),
    Claim {
        properties: &[Property::Keeps, Property::Intact, Property::Invariant],
        ..claim(
            "C6",
            KPLUS,
            "3.3, Algorithm 3",
            "a count pass bounded by k gives kplus-sb exactly the memory it needs: it never counts beyond k",
            &["kplus-sb", "kplus-sb@heap", "kplus-sb@published"],
        )
    },
    Claim {
        properties: &[Property::Keeps, Property::Intact, Property::Invariant, Property::Bounds],
        ..claim(
            "C7",
            IMPORTANCE,
            "3.1, equations 1 and 2",
            "the sum of k(p) never exceeds the budget, and every pixel has the k(p) that its importance gives it (that \
             less is lost than with a fixed k is measured: reproduce varik-table2)",
            &["k-variable", "k-variable@rounded", "k-variable@float-quotient", "k-variable@M17"],
        )
    },
    Claim {
        properties: &[Property::Invariant],
        ..claim(
            "C8",
            HA,
            "4.1.2",
            "cells of the table only grow; Proposition A holds in every state; lists come out sorted front to back",
            &["ha64", "ha32", "ha64-multiset", "ha64-cull", "ha64@no-depth", "ha64@load-store"],
        )
    },
    claim(
        "C9",
        HA,
        "4.1.1",
        "the age of a record alone identifies its pixel: where the table is at least as large as the screen on each axis; \
         more cells than pixels, as the paper asks for, are not enough in two dimensions (ha64@area)",
        &["ha64", "ha32", "ha64@area", "ha64@offset"],
    ),
    Claim {
        properties: &[
            Property::Keeps,
            Property::Intact,
            Property::Accounting,
            Property::OneOutcome,
        ],
        ..claim(
            "C10",
            HA,
            "4.1.3",
            "no fragment is lost short of the two stated failures, and the lists do not depend on the interleaving, also \
             where there are failures; two fragments that are wholly alike count as one, but in ha64-multiset",
            &[
                "ha64",
                "ha32",
                "ha64-multiset",
                "hash-coherent",
                "hash-coherent@published",
                "ha64@no-reinsert",
            ],
        )
    },
    claim(
        "C11",
        HA,
        "5",
        "early culling is conservative: a culled fragment is behind fragments that let no more light through than the \
         threshold",
        &["ha64-cull", "ha64-cull@published"],
    ),
    claim(
        "C12",
        HA,
        "4.1.4",
        "traversal sees all fragments of its pixel",
        &["ha64", "ha64@published", "ha64@max-age"],
    ),
    Claim {
        properties: &[Property::Keeps, Property::OneOutcome],
        ..claim(
            "C13",
            CULLING,
            "2, 3",
            "occupancy culling never removes one of the k nearest: the bound is behind all of them, whatever the order",
            &["occupancy", "occupancy@near-end", "occupancy@one-too-near", "occupancy@ends-early"],
        )
    },
    Claim {
        properties: &[Property::ArrivalFree, Property::OneOutcome, Property::Keeps],
        ..claim(
            "C14",
            THICKNESS,
            "3.2.2, 4.1.2",
            "merging by overlap does not depend on the order of arrival",
            &[
                "dfb+ofm",
                "skb+ofm",
                "skb+ofm@published",
                "skb+ofm@released",
                "skb+ofm@first-overlap",
                "skb+ofm@M10",
                "skb+ofm@M15",
            ],
        )
    },
    Claim {
        law: Some(Law::Restores),
        ..claim(
            "C15",
            THICKNESS,
            "3.3.1, equations 3 to 5",
            "the parts of a slab over each other look like the slab: merged with something invisible, it is what it was",
            &["dfb+sfm", "dfb+sfm@released", "dfb+sfm@front-beta", "dfb+sfm@M15"],
        )
    },
    Claim {
        law: Some(Law::Blends),
        ..claim(
            "C16",
            THICKNESS,
            "3.1",
            "surfaces of equal depth blend smoothly: which of them is one depth code nearer makes no difference to speak of",
            &["dfb+sfm", "dfb+ofm", "skb+ofm", "skb+ofm@released", "dfb", "kplus-array"],
        )
    },
    Claim {
        properties: &[Property::ArrivalFree, Property::OneOutcome, Property::Keeps],
        ..claim(
            "C17",
            SUMS,
            "the definition of each",
            "approximate transparency by sums does not depend on the order of arrival: said of weighted blending, of \
             moments, of a tail's average and of samples; of nodes that are merged or removed, nobody says so",
            &[
                "wboit",
                "mbt",
                "hybrid",
                "hybrid@product",
                "stochastic",
                "stochastic@plain",
                "stochastic@depth",
                "wboit@published-f32",
                "mbt@published-f32",
                "mlab",
                "adaptive",
                "kplus-array+tail",
            ],
        )
    },
];

/// The claim of that name.
///
/// # Errors
/// No claim has that name; the message lists those that exist.
pub fn claim_by_id(id: &str) -> Result<&'static Claim> {
    let found = CLAIMS.iter().find(|claim| claim.id.eq_ignore_ascii_case(id));
    found.ok_or_else(|| {
        let ids: Vec<&str> = CLAIMS.iter().map(|claim| claim.id).collect();
        Error::new("--claim", format!("no claim is called {id:?}; there are {}", ids.join(", ")))
    })
}

impl Claim {
    /// Compute its verdicts: one row per method of the catalogue and memory model. `only`, if it is not empty, selects
    /// methods, which need not be among the claim's.
    ///
    /// # Errors
    /// An unknown method.
    pub fn check(
        &self,
        catalogue: &Catalogue,
        only: &[String],
        plan: &Plan,
        limits: &Limits<'_>,
    ) -> Result<Vec<Finding>> {
        let methods: Vec<&str> = if only.is_empty() {
            self.methods.to_vec()
        } else {
            only.iter().map(String::as_str).collect()
        };
        if self.methods.is_empty() {
            return Ok(vec![self.undecided()]);
        }
        let mut rows = Vec::new();
        for method in methods {
            let begin = rows.len();
            let subject = Subject::new(catalogue.find("METHOD", method)?)?;
            if let Some(law) = self.law {
                rows.push(self.tried(&subject, &law.on(&subject)));
                continue;
            }
            for &memory in &plan.memory {
                let n = plan.fragments_under(subject.contract, memory);
                let ks = match self.ks {
                    Ks::Planned => plan.ks.clone(),
                    Ks::Ends => vec![1, n],
                };
                let family = Family { fragments: n, ks, helpers: plan.helpers };
                let conditions = Conditions { memory, warp: None };
                let survey = Survey::new(&subject, &family, conditions, limits);
                rows.push(self.row(&survey, &properties(&subject, memory)));
            }
            inherit(&mut rows[begin..]);
        }
        Ok(rows)
    }

    /// The worst of the properties' rows; of several violations, the one on the smallest instance.
    fn row(&self, survey: &Survey, asked: &[Property]) -> Finding {
        let own = |p: &&Property| asked.contains(p) || **p == Property::ArrivalFree;
        let of_claim = self.properties.iter().filter(own);
        let rows: Vec<Finding> = of_claim.map(|&p| survey.row(p)).collect();
        let size = |row: &Finding| row.steps.unwrap_or(u64::MAX);
        let worst = rows
            .iter()
            .max_by(|a, b| a.verdict.cmp(&b.verdict).then(size(b).cmp(&size(a))))
            .cloned();
        let Some(mut row) = worst else { return self.undecided() };
        let race = survey.violation(Property::RaceFree);
        if let Some((litmus, _, _)) = race {
            let note = format!("besides, a data race ({})", litmus.describe());
            row.message =
                if row.message.is_empty() { note } else { format!("{}; {note}", row.message) };
        }
        row.claim = Some(self.id.to_owned());
        row
    }

    /// What a law's grid showed of a method.
    fn tried(&self, subject: &Subject, tried: &Tried) -> Finding {
        let Tried { instances, grid, most, bound, instance, .. } = tried;
        let verdict = if tried.holds() { Verdict::Verified } else { Verdict::Violated };
        let message = format!("at most {most:.3e} off, allowed are {bound:.3e}");
        Finding {
            method: subject.method.name().to_owned(),
            verdict,
            bound: format!("{instances} instances: {grid}"),
            memory: "any".to_owned(),
            instance: if tried.holds() { String::new() } else { instance.clone() },
            executions: Some(*instances),
            message,
            ..self.undecided()
        }
    }

    fn undecided(&self) -> Finding {
        Finding {
            method: String::new(),
            property: None,
            found: None,
            claim: Some(self.id.to_owned()),
            verdict: Verdict::Unknown,
            exhaustive: false,
            bound: String::new(),
            scope: Scope::default(),
            memory: String::new(),
            profile: None,
            progress: None,
            instance: String::new(),
            initial: String::new(),
            executions: None,
            states: 0,
            token: None,
            steps: None,
            message: "needs a method that is not here yet".to_owned(),
            outcomes: Vec::new(),
        }
    }
}
