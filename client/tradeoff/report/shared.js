// The data of the page, and functions to format numbers.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

// Formats of numbers.
const digits = (v, n = 3) => (v === null || v === undefined ? "" : Number(v.toPrecision(n)).toString());
const percent = (v) => (v === null || v === undefined ? "" : `${digits(100 * v)}%`);
const time = (s) => {
  if (s === null || s === undefined) return "";
  if (s >= 120) return `${digits(s / 60)} min`;
  if (s >= 1) return `${digits(s)} s`;
  if (s >= 1e-3) return `${digits(1e3 * s)} ms`;
  return `${digits(1e6 * s)} µs`;
};
const nameTime = (i, c) => `${settings[i].name}, ${time(c.seconds.median)}`;
const amount = (a) => (a.kind === "error" ? `error ${percent(a.value)}` : `${a.value} ${a.value === 1 ? "sample" : "samples"}`);

function element(tag, content = "", attributes = {}) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) e.setAttribute(name, value);
  for (const part of [].concat(content)) e.append(part);
  return e;
}
function row(table, cells, tag = "td", numbers = []) {
  const tr = element("tr");
  cells.forEach((cell, i) => tr.append(element(tag, cell, numbers.includes(i) ? { class: "number" } : {})));
  table.append(tr);
}

const settings = data.settings;
const swept = settings.map((s, i) => i).filter((i) => settings[i].cells.length > 0);
// Exact settings have error 0, which has no logarithm.  A text lists them, and the plot shows the others.
const exact = swept.filter((i) => settings[i].exact_at !== undefined);
const drawn = swept.filter((i) => settings[i].exact_at === undefined);
const exactText = () => exact.map((i) => nameTime(i, settings[i].cells[settings[i].exact_at])).join("; ");
// Exact settings would end the Pareto front, so the page draws the front of the others.
const front = exact.length === 0 ? data.pareto_front : frontOf(drawn);
function frontOf(some) {
  const places = some.flatMap((i) => settings[i].cells.map((c, k) => ({ i, k, t: c.seconds.median, e: c.relative_error.mean })));
  let best = Infinity;
  return places.sort((a, b) => a.t - b.t || a.e - b.e).filter((p) => p.e < best && ((best = p.e), true)).map((p) => [p.i, p.k]);
}
const onFront = new Set(front.map(([setting]) => setting));

// Automatic is black, settings on the Pareto front have a colour, the others are grey.
const palette = ["#0b6bcb", "#d1495b", "#2a9d5c", "#8a5cd1", "#e08a00", "#00929b", "#b0417e", "#6b7d1e",
  "#7a4a2b", "#5aa9e6", "#c8a415", "#ef7fb1", "#3f7d73", "#9a8cff"];
const colours = settings.map(() => "#a9b1bf");
colours[0] = "#111722";
[...onFront].filter((i) => i !== 0).forEach((i, k) => { colours[i] = palette[k % palette.length]; });
const important = (i) => i === 0 || onFront.has(i);
