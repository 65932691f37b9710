// Making elements, and reading what is attached to the page.

/** An element with attributes and children; names that begin with "on" are listeners. */
function el(name, attributes = {}, ...children) {
  return fill(document.createElement(name), attributes, children);
}

/** The same for drawings. */
function svg(name, attributes = {}, ...children) {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** 1234567 as 1,234,567. */
function thousands(number) {
  return String(number).replace(/\B(?=(\d{3})+$)/g, ",");
}

/** The text that is attached under a name, base64, or null if the page is not read so far. */
function attachedSoFar(name) {
  const element = document.getElementById(name);
  if (document.readyState !== "loading" && !element) throw new Error(`the page has no ${name}: is the file whole?`);
  return element && (element.nextSibling || document.readyState !== "loading") ? element.textContent : null;
}

/** The same of what stands before the script. */
function attached(name) {
  return document.getElementById(name).textContent;
}

/** Attached bytes, which are packed in zlib's format. */
async function unpacked(name) {
  let packed = attachedSoFar(name);
  for (; packed === null; packed = attachedSoFar(name)) await new Promise((done) => setTimeout(done, 20));
  const text = atob(packed);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Text to be copied or saved, which is shown on demand. */
function exported(label, file, type, text) {
  const area = el("textarea", { readonly: true, rows: "8", "aria-label": label, spellcheck: "false" });
  const link = el("a", { class: "control", download: file }, `Save ${file}`);
  const box = el("div", { class: "exported", hidden: true }, area, link);
  let url = null;
  const show = () => {
    area.value = text();
    if (url) URL.revokeObjectURL(url);
    url = URL.createObjectURL(new Blob([area.value], { type }));
    link.href = url;
  };
  const button = el("button", {
    type: "button", class: "control", "aria-expanded": "false",
    onclick() {
      box.hidden = !box.hidden;
      button.setAttribute("aria-expanded", String(!box.hidden));
      if (!box.hidden) {
        show();
        area.focus();
        area.select();
      }
    },
  }, label);
  return { button, box, refresh: () => { if (!box.hidden) show(); } };
}
