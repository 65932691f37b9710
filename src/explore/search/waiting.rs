//! Which invocations wait, where they run as they are: one that repeats an attempt after nothing has changed would find
//! what it found before.

/// The waiting invocations of a stage.
pub(super) struct Waiting {
    /// Changes of words, and those by each invocation.
    changes: u64,
    own: Vec<u64>,
    /// Changes by others when the present attempt began.
    begun: Vec<u64>,
    waits: Vec<bool>,
}

impl Waiting {
    pub(super) fn new(invocations: usize) -> Self {
        let zeros = vec![0; invocations];
        Self { changes: 0, own: zeros.clone(), begun: zeros, waits: vec![false; invocations] }
    }

    /// An invocation has changed a word.
    pub(super) fn change(&mut self, invocation: usize) {
        self.changes += 1;
        self.own[invocation] += 1;
        // Its own change is no news to itself.
        let waited = self.waits[invocation];
        self.waits.fill(false);
        self.waits[invocation] = waited;
    }

    /// An invocation tries again: it waits, unless others have changed a word during its attempt.
    pub(super) fn spin(&mut self, invocation: usize) {
        let others = self.changes - self.own[invocation];
        self.waits[invocation] = self.begun[invocation] == others;
        self.begun[invocation] = others;
    }

    /// Whether it waits for a change.
    pub(super) fn waits(&self, invocation: usize) -> bool {
        self.waits[invocation]
    }
}
