"use strict";
const { measures, cells } = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const shown = (name) => name.replaceAll("_", " ");

const element = (tag, text) => {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
};

const heading = (scope, text) => {
  const made = element("th", text);
  made.scope = scope;
  return made;
};

// Hover: the first numbers of a cell.
const TOLD = 12;
const tip = byId("tip");
const tell = (cell) => {
  const lines = measures.slice(0, TOLD).map((name, i) => {
    const line = document.createElement("span");
    line.append(element("span", shown(name)), element("span", cell.summaries[i]));
    return line;
  });
  tip.replaceChildren(element("b", cell.title), ...lines);
  tip.hidden = false;
};
const follow = (event) => {
  const { offsetWidth: width, offsetHeight: height } = tip;
  const left = event.clientX + 16 + width > innerWidth ? event.clientX - 16 - width : event.clientX + 16;
  const top = Math.min(event.clientY + 16, innerHeight - height - 8);
  tip.style.left = `${Math.max(8, left)}px`;
  tip.style.top = `${Math.max(8, top)}px`;
};

// The folder that this page lies in, as one word of a shell.
const folder = () => {
  if (location.protocol !== "file:") return "DIR";
  const path = decodeURIComponent(location.pathname).replace(/\/[^/]*$/, "");
  return /^[\w\-./,=+%:@]+$/.test(path) ? path : `'${path.replaceAll("'", "'\\''")}'`;
};

const numbers = (cell) => {
  const head = document.createElement("tr");
  const several = cell.seeds.length > 1;
  head.append(heading("col", "measure"), ...(several ? [heading("col", "all")] : []));
  head.append(...cell.seeds.map((seed) => heading("col", `seed ${seed}`)));
  const rows = measures.map((name, i) => {
    const row = document.createElement("tr");
    row.append(heading("row", shown(name)), ...(several ? [element("td", cell.summaries[i])] : []));
    row.append(...cell.values[i].map((x) => element("td", x)));
    return row;
  });
  const ended = document.createElement("tr");
  ended.append(heading("row", "stopped by"), ...(several ? [element("td", "")] : []));
  ended.append(...cell.stopped.map((word) => element("td", word)));
  return [head, ...rows, ended];
};

// Click: the large picture, the commands, every number.
const open = (button) => {
  const cell = cells[button.dataset.cell];
  const picture = button.querySelector("img");
  byId("cell-title").textContent = cell.title;
  byId("cell-picture").hidden = !picture;
  byId("cell-picture").replaceChildren(...(picture ? [picture.cloneNode()] : []));
  byId("cell-error").textContent = cell.errors.join("; ");
  byId("cell-command").textContent = cell.command;
  byId("cell-only").textContent = `thallus sweep ${folder()}/grid.toml -o ${folder()} --only ${cell.name}`;
  byId("cell-numbers").replaceChildren(...numbers(cell));
  tip.hidden = true;
  byId("cell").showModal();
  history.replaceState(null, "", `#${encodeURIComponent(cell.name)}`);
};

const copy = async (button) => {
  const code = byId(button.dataset.copy);
  try {
    await navigator.clipboard.writeText(code.textContent);
  } catch {
    getSelection().selectAllChildren(code);
    document.execCommand("copy");
  }
  button.textContent = "Copied";
  setTimeout(() => (button.textContent = "Copy"), 1500);
};

for (const button of document.querySelectorAll("button.cell")) {
  button.addEventListener("click", () => open(button));
  button.addEventListener("pointerenter", () => tell(cells[button.dataset.cell]));
  button.addEventListener("pointermove", follow);
  button.addEventListener("pointerleave", () => (tip.hidden = true));
}
byId("cell").addEventListener("close", () => history.replaceState(null, "", "#"));
for (const button of document.querySelectorAll("[data-copy]")) {
  button.addEventListener("click", () => copy(button));
}
byId("cell").addEventListener("click", (event) => {
  if (event.target === byId("cell")) byId("cell").close();
});

// A link to a cell opens it.
const linked = cells.findIndex((cell) => `#${encodeURIComponent(cell.name)}` === location.hash || `#${cell.name}` === location.hash);
if (linked >= 0) open(document.querySelector(`button.cell[data-cell="${linked}"]`));
