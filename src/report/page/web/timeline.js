// The timeline of an interleaving: a lane per invocation, step by step, and memory beside it.
//
// timeline(element, data) fills the element. `data` is what `fragloom::explore::replay::timeline` writes: see
// docs/schemas/timeline.json. Keys, while the focus is within: left and right (or up and down) go by one step, Home
// and End to the ends, F to the fault. `element.dataset.step` is the number of steps that have run.
"use strict";

function timeline(element, data) {
  const make = (tag, name, text) => {
    const made = document.createElement(tag);
    if (name) made.className = name;
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const add = (parent, ...children) => {
    children.forEach((child) => parent.appendChild(child));
    return parent;
  };
  const steps = data.steps;
  const fault = data.fault;
  const color = (lane) => `var(--timeline-series${lane % 7})`;
  const shown = (value) => (value === null ? "-" : value);

  element.classList.add("timeline");
  element.tabIndex = 0;
  element.setAttribute("role", "group");
  element.setAttribute("aria-label", `Interleaving of ${data.method}`);
  element.replaceChildren();

  // What is replayed, and what is wrong with it.
  const memory = data.memory + (data.profile === null ? "" : `/${data.profile}`);
  const warp = data.warp === null ? "" : ", lanes of one warp";
  add(
    element,
    make("h2", "", `${data.method}, ${data.instance}`),
    make("p", "timeline-quiet", `memory ${memory}${warp}: ${steps.length} steps`),
  );
  if (fault !== null) {
    add(element, make("p", "timeline-wrong", `${fault.property}: ${fault.message}`));
  }

  // The bar.
  const bar = make("div", "timeline-bar");
  const button = (text, label, to) => {
    const made = make("button", "", text);
    made.type = "button";
    made.title = label;
    made.setAttribute("aria-label", label);
    made.addEventListener("click", () => show(to()));
    add(bar, made);
    return made;
  };
  let now = 0;
  const back = [
    button("|<", "Before the first step (Home)", () => 0),
    button("<", "One step back (left)", () => now - 1),
  ];
  const forth = [
    button(">", "One step on (right)", () => now + 1),
    button(">|", "After the last step (End)", () => steps.length),
  ];
  if (fault !== null && fault.step !== null) {
    button("fault", "The step at which it goes wrong (F)", () => fault.step);
  }
  const slider = make("input");
  slider.type = "range";
  slider.min = 0;
  slider.max = steps.length;
  slider.setAttribute("aria-label", "Steps that have run");
  slider.addEventListener("input", () => show(Number(slider.value)));
  const told = make("output", "timeline-told");
  told.setAttribute("aria-live", "polite");
  add(bar, slider, told);
  add(element, bar);

  // The steps.
  const both = make("div", "timeline-both");
  const table = make("table", "timeline-steps");
  const head = make("tr");
  add(head, make("th", "", "step"));
  const lanes = data.stages.length > 0 ? data.stages[0].lanes : [];
  lanes.forEach((lane, i) => {
    const cell = make("th", "", lane.name);
    cell.scope = "col";
    cell.style.color = color(i);
    add(head, cell);
  });
  add(table, add(make("thead"), head));
  const body = make("tbody");
  const say = (text, name) => {
    const cell = make("td", "", text);
    cell.colSpan = lanes.length + 1;
    return add(make("tr", name), cell);
  };
  const first = fault !== null && fault.causes.length > 0 ? fault.causes[0].steps : [];
  const holds = lanes.map(() => false);
  // Rows by the step that they come after; the step's own row is the one with a number.
  const rows = [];
  steps.forEach((step, i) => {
    const own = [];
    const stage = data.stages[step.stage];
    if (i > 0 && stage.first === step.number) {
      const names = stage.lanes.map((lane) => lane.name).join(", ");
      own.push(say(`barrier, then ${stage.name}: ${names}`, "timeline-barrier"));
    }
    if (data.cycle > 0 && i + data.cycle === steps.length) {
      own.push(say("forever:", "timeline-said"));
    }
    const row = make("tr", "timeline-step");
    row.dataset.step = step.number;
    const number = make("th", "", String(step.number));
    number.scope = "row";
    add(row, number);
    lanes.forEach((_, lane) => {
      const cell = make("td");
      cell.style.setProperty("--timeline-lane", color(lane));
      if (lane === step.lane) {
        const stale = step.read_from !== null && step.read_from.newer.length > 0 ? " (stale)" : "";
        cell.textContent = `${step.short}${stale}${step.spins ? ", again" : ""}`;
        cell.className = "timeline-does";
        if (step.site !== null) cell.title = `${step.text}\n${step.site}`;
        if (step.lock === "locks") holds[lane] = true;
        if (step.lock === "unlocks") holds[lane] = false;
      } else if (holds[lane]) {
        cell.className = "timeline-holds";
        cell.title = "holds a lock";
      }
      add(row, cell);
    });
    if (fault !== null && fault.step === step.number) row.classList.add("timeline-fault");
    if (first.includes(step.number)) row.classList.add("timeline-caused");
    row.addEventListener("click", () => show(step.number));
    own.push(row);
    step.wrong.forEach((wrong) => {
      own.push(say(`${wrong.property}: ${wrong.message}`, "timeline-said"));
    });
    if (fault !== null && fault.shown === "doomed-after" && fault.step === step.number) {
      own.push(say("from here on, every continuation is wrong", "timeline-said"));
    }
    add(body, ...own);
    rows.push({ row, all: own });
  });
  add(table, body);
  const scroll = make("div", "timeline-scroll");
  add(both, add(scroll, table));

  // Memory.
  const words = make("table", "timeline-memory");
  const relaxed = data.memory === "relaxed";
  const titles = relaxed ? ["word", "value", "who may read what"] : ["word", "value"];
  add(words, add(make("thead"), add(make("tr"), ...titles.map((title) => make("th", "", title)))));
  const cells = data.words.map((word) => {
    const row = make("tr");
    const name = make("th", "", word.name);
    name.scope = "row";
    name.title = word.address;
    const value = make("td");
    const versions = make("td");
    add(row, name, value);
    if (relaxed) add(row, versions);
    return { row, value, versions };
  });
  add(words, add(make("tbody"), ...cells.map((cell) => cell.row)));
  add(both, words);
  add(element, both);

  // What led to the fault, and what every pixel holds in the end.
  if (fault !== null) {
    fault.causes.forEach((cause) => {
      const made = make("button", "timeline-cause", cause.message);
      made.type = "button";
      let next = 0;
      // Its steps, one after another.
      made.addEventListener("click", () => {
        show(cause.steps[next % cause.steps.length]);
        next += 1;
      });
      add(element, made);
    });
  }
  data.result.forEach((pixel) => {
    const found = pixel.found === null ? "nothing yet: the run has not ended" : pixel.found;
    let must = "";
    if (pixel.expected !== null) must = `, must hold ${pixel.expected}`;
    else if (pixel.possible.length > 0) must = `, may hold ${pixel.possible.join(" or ")}`;
    const wrong = pixel.expected !== null && pixel.expected !== pixel.found;
    const text = `pixel ${pixel.pixel} holds ${found}${must}`;
    add(element, make("p", wrong ? "timeline-wrong" : "", text));
  });
  add(
    element,
    make(
      "p",
      "timeline-quiet timeline-help",
      "Keys: left and right by one step, Home and End to the ends, F to the fault. Values are hexadecimal.",
    ),
  );

  // What the words hold after so many steps.
  const held = (count) => {
    const now = data.words.map((word) => ({
      value: word.initial,
      versions: [{ value: word.initial, by: null }],
      oldest: [],
      changed: false,
    }));
    steps.slice(0, count).forEach((step, i) => {
      step.changes.forEach((change) => {
        const old = now[change.word];
        const differs = change.value !== old.value || change.versions.length > old.versions.length;
        now[change.word] = { ...change, changed: i === count - 1 && differs };
      });
    });
    return now;
  };

  // For each value that can still be read, which lanes may read it.
  const readers = (word, stage) => {
    if (word.oldest.length === 0) return "";
    return word.versions
      .map((version, i) => {
        const able = stage.lanes.filter((_, lane) => word.oldest[lane] !== null && word.oldest[lane] <= i);
        const names = able.map((lane) => lane.name.split(" ")[0]).join(" ");
        const by = version.by === null ? "" : ` of step ${version.by}`;
        return able.length > 0 ? `${shown(version.value)}${by}: ${names}` : null;
      })
      .filter((text) => text !== null)
      .join("\n");
  };

  function show(wanted) {
    now = Math.max(0, Math.min(steps.length, wanted));
    element.dataset.step = now;
    slider.value = now;
    back.forEach((made) => (made.disabled = now === 0));
    forth.forEach((made) => (made.disabled = now === steps.length));
    rows.forEach(({ row, all }, i) => {
      all.forEach((each) => each.classList.toggle("timeline-later", i + 1 > now));
      row.classList.toggle("timeline-now", i + 1 === now);
      if (i + 1 === now) row.setAttribute("aria-current", "step");
      else row.removeAttribute("aria-current");
    });
    const step = now > 0 ? steps[now - 1] : null;
    const stage = data.stages[step === null ? 0 : step.stage];
    held(now).forEach((word, i) => {
      cells[i].value.textContent = shown(word.value);
      cells[i].versions.textContent = stage === undefined ? "" : readers(word, stage);
      cells[i].row.classList.toggle("timeline-changed", word.changed);
    });
    told.textContent =
      step === null
        ? `before the first of ${steps.length} steps`
        : `step ${now} of ${steps.length}: ${stage.lanes[step.lane].name}: ${step.short}`;
    if (now > 0) {
      const row = rows[now - 1].row;
      const top = row.offsetTop - scroll.offsetTop;
      if (top < scroll.scrollTop + 40 || top + 40 > scroll.scrollTop + scroll.clientHeight) {
        scroll.scrollTop = top - scroll.clientHeight / 2;
      }
    }
  }

  element.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const to = {
      ArrowLeft: now - 1,
      ArrowUp: now - 1,
      ArrowRight: now + 1,
      ArrowDown: now + 1,
      Home: 0,
      End: steps.length,
    };
    if (fault !== null && fault.step !== null) to.f = to.F = fault.step;
    if (!(event.key in to)) return;
    event.preventDefault();
    show(to[event.key]);
  });
  show(0);
}
