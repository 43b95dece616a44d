"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

// How numbers are told.
const digits = (v, n = 3) => (v === null || v === undefined ? "" : Number(v.toPrecision(n)).toString());
const percent = (v) => (v === null || v === undefined ? "" : `${digits(100 * v)}%`);
const time = (s) => {
  if (s === null || s === undefined) return "";
  if (s >= 120) return `${digits(s / 60)} min`;
  if (s >= 1) return `${digits(s)} s`;
  if (s >= 1e-3) return `${digits(1e3 * s)} ms`;
  return `${digits(1e6 * s)} µs`;
};
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
const front = data.pareto_front;
const onFront = new Set(front.map(([setting]) => setting));

// Automatic is black, settings that are best somewhere have a colour, the rest is grey until asked for.
const palette = ["#0b6bcb", "#d1495b", "#2a9d5c", "#8a5cd1", "#e08a00", "#00929b", "#b0417e", "#6b7d1e"];
const colours = settings.map(() => "#a9b1bf");
colours[0] = "#111722";
[...onFront].filter((i) => i !== 0).forEach((i, k) => { colours[i] = palette[k % palette.length]; });
const important = (i) => i === 0 || onFront.has(i);

function tellHeader() {
  const c = data.circumstances;
  document.title = `${c.scene}: error against time`;
  byId("title").textContent = `Error against time: ${data.query} in ${c.scene}`;
  byId("subtitle").textContent =
    `${data.quantity}, asked of a running server by a client; ${swept.length} settings, ` +
    `${time(c.spent_s)} of measuring.`;
}

function tellLevels() {
  const table = byId("levels");
  row(table, ["error", "setting", "time", "automatic takes", "", "command"], "th", [2, 3]);
  for (const level of data.levels) {
    if (level.setting === undefined) {
      row(table, [percent(level.error), "no setting came near within the budget", "", "", "", ""]);
      continue;
    }
    const how = level.how === "extrapolated"
      ? element("span", "extrapolated", { class: "tag beyond" })
      : element("span", level.how, { class: "tag" });
    const tags = [how];
    if (level.below_reference) {
      tags.push(" ", element("span", "below the reference's own error", { class: "tag beyond" }));
    }
    const ratio = level.automatic_over_best;
    row(table, [
      element("b", percent(level.error)), level.name,
      (level.how.startsWith("with") ? "≤ " : "") + time(level.seconds),
      ratio === null ? "" : `${digits(ratio)} ×${level.automatic_extrapolated ? " (extrapolated)" : ""}`,
      tags, element("code", level.command),
    ], "td", [2, 3]);
  }
  for (const warning of data.warnings) byId("warnings").append(element("p", warning, { class: "warning" }));
}

const measures = {
  relative_error: { title: "relative error (root mean square)", tell: percent },
  rmse: { title: `RMSE, ${data.quantity}`, tell: (v) => digits(v) },
};
if (settings.some((s) => s.cells.some((c) => c.flip))) {
  measures.flip = { title: "mean FLIP", tell: (v) => digits(v) };
}
let measure = "relative_error";
const shown = new Set(swept.filter(important));
let pointed = null;

// Powers of ten, and where these are few 2 and 5 between.
function ticks(axis) {
  const decades = Math.log10(axis.max / axis.min);
  const values = [];
  for (let e = Math.floor(Math.log10(axis.min)); e <= Math.ceil(Math.log10(axis.max)); e++) {
    for (const f of decades < 2.5 ? [1, 2, 5] : [1]) {
      const v = f * 10 ** e;
      if (v >= axis.min * 0.999 && v <= axis.max * 1.001) values.push({ value: v });
    }
  }
  axis.ticks = values;
}
const logarithmic = (title, tell) => ({
  type: "logarithmic",
  title: { display: true, text: title, color: "#5b6475", font: { size: 13 } },
  afterBuildTicks: ticks,
  ticks: { callback: (v) => tell(v), color: "#5b6475", autoSkip: false, maxRotation: 0 },
  grid: { color: "#edf0f4" },
});

// Lines across the whole plot, with a word at their right end.
const lines = {
  id: "lines",
  beforeDatasetsDraw(chart, _, options) {
    const { ctx, chartArea: area, scales: { y } } = chart;
    for (const { at, text, colour } of options.list || []) {
      const py = y.getPixelForValue(at);
      if (py < area.top || py > area.bottom) continue;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.setLineDash([3, 4]);
      ctx.beginPath();
      ctx.moveTo(area.left, py);
      ctx.lineTo(area.right, py);
      ctx.stroke();
      ctx.font = "12px sans-serif";
      ctx.textAlign = "right";
      ctx.fillText(text, area.right - 4, py - 4);
      ctx.restore();
    }
  },
};

function errorDatasets() {
  const sets = [];
  for (const i of swept) {
    if (!shown.has(i) && pointed !== i) continue;
    const strong = pointed === i || (pointed === null && important(i));
    const cells = settings[i].cells.filter((c) => c[measure] && c[measure].mean > 0);
    const curve = (key) => cells.filter((c) => c[measure][key] > 0 && c[measure].upper !== null)
      .map((c) => ({ x: c.seconds.median, y: c[measure][key] }));
    sets.push({
      setting: i, cells, label: settings[i].name, borderColor: colours[i], backgroundColor: colours[i],
      data: cells.map((c) => ({ x: c.seconds.median, y: c[measure].mean })),
      borderWidth: pointed === i ? 3.5 : i === 0 ? 3 : important(i) ? 2 : 1.2,
      pointRadius: strong ? 3.5 : 2, order: i === 0 ? 1 : important(i) ? 2 : 3,
    });
    if (!strong && !important(i)) continue;
    const band = { band: true, borderWidth: 0, pointRadius: 0, pointHitRadius: 0, order: 4,
      backgroundColor: `${colours[i]}26` };
    sets.push({ ...band, data: curve("lower"), fill: false });
    sets.push({ ...band, data: curve("upper"), fill: "-1" });
  }
  if (measure === "relative_error") {
    sets.push({
      label: "Pareto front", borderColor: "#11172299", borderDash: [6, 5], borderWidth: 1.5, pointRadius: 0,
      pointHitRadius: 0, order: 0, band: true, stepped: "after", fill: false,
      data: front.map(([s, c]) => ({ x: settings[s].cells[c].seconds.median, y: settings[s].cells[c].relative_error.mean }))
        .filter((p) => p.y > 0),
    });
  }
  return sets;
}

let errorPlot = null;
function drawErrors() {
  if (errorPlot) errorPlot.destroy();
  const list = measure === "relative_error"
    ? [...data.levels.map((l) => ({ at: l.error, text: percent(l.error), colour: "#9aa3b2" })),
      { at: data.reference.relative_error, text: "the reference's own error", colour: "#c23b3b" }]
    : measure === "rmse" ? [{ at: data.reference.rmse, text: "the reference's own error", colour: "#c23b3b" }] : [];
  errorPlot = new Chart(byId("error-plot"), {
    type: "line",
    data: { datasets: errorDatasets() },
    plugins: [lines],
    options: {
      animation: false, parsing: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", intersect: true },
      scales: {
        x: logarithmic("wall time of a question, as the client sees it (median)", time),
        y: logarithmic(measures[measure].title, measures[measure].tell),
      },
      plugins: {
        legend: { display: false },
        lines: { list },
        tooltip: {
          filter: (item) => !item.dataset.band,
          callbacks: {
            title: (items) => items.map((item) => item.dataset.label),
            label: (item) => {
              const c = item.dataset.cells[item.dataIndex];
              const e = c[measure];
              return [
                `${amount(c.amount)}: ${measures[measure].tell(e.mean)} ` +
                  `(${measures[measure].tell(e.lower)} to ${measures[measure].tell(e.upper)})`,
                `${time(c.seconds.median)} (${time(c.seconds.lower)} to ${time(c.seconds.upper)}), ${c.runs} runs`,
              ];
            },
          },
        },
      },
    },
  });
}

function drawLegend() {
  const legend = byId("legend");
  const entry = (i) => {
    const box = element("input", "", { type: "checkbox" });
    box.checked = shown.has(i);
    box.addEventListener("change", () => { box.checked ? shown.add(i) : shown.delete(i); drawErrors(); });
    const label = element("label", [box, element("span", "", { class: "swatch", style: `background:${colours[i]}` }),
      element("span", settings[i].name)]);
    label.addEventListener("mouseenter", () => { pointed = i; drawErrors(); });
    label.addEventListener("mouseleave", () => { pointed = null; drawErrors(); });
    legend.append(label);
  };
  legend.append(element("h3", "automatic, and the best at some time (Pareto front)"));
  swept.filter(important).forEach(entry);
  const rest = swept.filter((i) => !important(i));
  if (rest.length === 0) return;
  legend.append(element("h3", "others: tick to show, point to look"));
  rest.forEach(entry);
}

function drawMeasures() {
  const box = byId("measures");
  for (const [key, { title }] of Object.entries(measures)) {
    const button = element("input", "", { type: "radio", name: "measure" });
    button.checked = key === measure;
    button.addEventListener("change", () => { measure = key; drawErrors(); });
    box.append(element("label", [button, " ", title]));
  }
  byId("error-note").textContent =
    "Bands: 95% intervals from repeats with different seeds. Dashed: the Pareto front, the least error that any setting " +
    "has by that time. Each point is one amount of work; median time of its runs, in rounds shuffled over all settings.";
  const exact = swept.filter((i) => settings[i].cells.some((c) => c.relative_error.mean === 0));
  if (exact.length > 0) {
    byId("error-note").textContent += " Without error, and so not in this plot: " +
      `${exact.map((i) => `${settings[i].name} (${time(settings[i].cells[0].seconds.median)})`).join("; ")}.`;
  }
}

const whiskers = {
  id: "whiskers",
  afterDatasetsDraw(chart) {
    const { ctx, scales: { x } } = chart;
    const set = chart.data.datasets[0];
    chart.getDatasetMeta(0).data.forEach((bar, k) => {
      const { lower, upper } = set.intervals[k];
      if (!(lower > 0) || upper === null) return;
      const a = x.getPixelForValue(lower), b = x.getPixelForValue(upper);
      ctx.save();
      ctx.strokeStyle = "#111722";
      ctx.lineWidth = 1.2;
      ctx.beginPath();
      ctx.moveTo(a, bar.y);
      ctx.lineTo(b, bar.y);
      for (const p of [a, b]) { ctx.moveTo(p, bar.y - 4); ctx.lineTo(p, bar.y + 4); }
      ctx.stroke();
      ctx.restore();
    });
  },
};

function drawEfficiency() {
  const ranked = swept.filter((i) => settings[i].efficiency_per_s)
    .sort((a, b) => settings[b].efficiency_per_s.mean - settings[a].efficiency_per_s.mean);
  if (ranked.length === 0) { byId("efficiency").style.display = "none"; return; }
  const unit = (settings[0].efficiency_per_s || settings[ranked[0]].efficiency_per_s).mean;
  byId("efficiency-box").style.height = `${70 + 24 * ranked.length}px`;
  const of = (i, key) => {
    const v = settings[i].efficiency_per_s[key];
    return v === null ? null : v / unit;
  };
  const values = ranked.flatMap((i) => ["mean", "lower", "upper"].map((k) => of(i, k))).filter((v) => v > 0);
  new Chart(byId("efficiency-plot"), {
    type: "bar",
    data: {
      labels: ranked.map((i) => settings[i].name),
      datasets: [{
        data: ranked.map((i) => of(i, "mean")), base: 1,
        intervals: ranked.map((i) => ({ lower: of(i, "lower"), upper: of(i, "upper") })),
        backgroundColor: ranked.map((i) => (i === 0 ? "#111722" : `${colours[i]}cc`)), barThickness: 13, minBarLength: 2,
      }],
    },
    plugins: [whiskers],
    options: {
      indexAxis: "y", animation: false, responsive: true, maintainAspectRatio: false,
      scales: {
        x: { ...logarithmic("efficiency, automatic = 1", (v) => `${digits(v)} ×`),
          min: Math.min(0.5, ...values) * 0.8, max: Math.max(2, ...values) * 1.25 },
        y: { ticks: { color: "#1c2230", autoSkip: false }, grid: { display: false } },
      },
      plugins: {
        legend: { display: false },
        tooltip: {
          callbacks: {
            label: (item) => {
              const s = settings[ranked[item.dataIndex]];
              const c = s.cells[s.efficiency_at];
              return [`${digits(of(ranked[item.dataIndex], "mean"))} × automatic`,
                `${digits(s.efficiency_per_s.mean)} /s at ${amount(c.amount)}: ${percent(c.relative_error.mean)} in ${time(c.seconds.median)}`];
            },
          },
        },
      },
    },
  });
}

// Dark to light with equal steps to the eye.
const ramp = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function ramped(t) {
  const at = Math.min(Math.max(t, 0), 1) * (ramp.length - 1);
  const k = Math.min(Math.floor(at), ramp.length - 2);
  return `rgb(${ramp[k].map((v, c) => Math.round(v + (ramp[k + 1][c] - v) * (at - k))).join(",")})`;
}

function drawPoints() {
  const items = data.items;
  const points = data.points;
  const extent = [0, 1, 2].map((k) => Math.max(...points.map((p) => p[k])) - Math.min(...points.map((p) => p[k])));
  const [u, v] = [0, 1, 2].sort((a, b) => extent[b] - extent[a]).slice(0, 2).sort();
  const axes = ["x [m]", "y [m]", "z [m]"];
  byId("differences-note").textContent =
    `Every point's error (root mean square over runs, relative) when each setting has about the same time, ` +
    `${time(data.comparison_s)} for all points.`;
  const select = element("select");
  items.forEach((item, k) => select.append(element("option", `${settings[item.setting].name} (${item.amount}, ${time(item.seconds)})`, { value: k })));
  const all = items.flatMap((item) => item.errors).filter((e) => e > 0).sort((a, b) => a - b);
  const low = all[Math.floor(0.02 * all.length)] || 1e-6;
  const high = Math.max(all[Math.floor(0.995 * all.length)] || 1, 1.01 * low);
  const scale = element("span", "", { class: "scale" });
  scale.style.background = `linear-gradient(to right, ${ramp.map((c) => `rgb(${c.join(",")})`).join(",")})`;
  byId("differences-controls").append(element("label", ["setting ", select]), percent(low), scale, percent(high));
  const box = element("div", element("canvas"), { class: "plot" });
  const width = Math.min(900, 1100), ratio = Math.max(extent[v], 1e-9) / Math.max(extent[u], 1e-9);
  box.style.height = `${Math.min(Math.max(ratio * width, 240), 560)}px`;
  byId("differences-body").append(box);
  let chart = null;
  const draw = () => {
    const item = items[Number(select.value)];
    if (chart) chart.destroy();
    chart = new Chart(box.firstChild, {
      type: "scatter",
      data: {
        datasets: [{
          data: points.map((p) => ({ x: p[u], y: p[v] })), pointRadius: 5.5, borderWidth: 0,
          pointBackgroundColor: item.errors.map((e) => ramped(Math.log(Math.max(e, low) / low) / Math.log(high / low))),
        }],
      },
      options: {
        animation: false, responsive: true, maintainAspectRatio: false,
        scales: { x: { title: { display: true, text: axes[u] } }, y: { title: { display: true, text: axes[v] } } },
        plugins: {
          legend: { display: false },
          tooltip: {
            callbacks: {
              label: (t) => [`(${points[t.dataIndex].join(", ")}): error ${percent(item.errors[t.dataIndex])}`,
                `reference ${digits(data.reference.values[t.dataIndex], 4)} ± ${digits(data.reference.standard_error[t.dataIndex], 2)}`],
            },
          },
        },
      },
    });
  };
  select.addEventListener("change", draw);
  draw();
  itemTable((i) => `(${points[i].map((x) => digits(x, 4)).join(", ")})`);
}

// Items by how far apart the best and the worst setting are.
function itemTable(nameOf) {
  const items = data.items;
  if (items.length < 2) return;
  const rows = data.reference.values.map((reference, i) => {
    const order = items.map((item) => item).sort((a, b) => a.errors[i] - b.errors[i]);
    const best = order[0], worst = order[order.length - 1];
    // An error that is below the reference's own is not told apart from it.
    const floor = reference ? data.reference.standard_error[i] / Math.abs(reference) : 0;
    return { i, reference, best, worst, ratio: worst.errors[i] / Math.max(best.errors[i], floor, 1e-9) };
  }).filter((r) => r.reference).sort((a, b) => b.ratio - a.ratio).slice(0, 8);
  const table = element("table");
  row(table, ["item", `reference, ${data.quantity}`, "best setting", "error", "worst setting", "error"], "th", [1, 3, 5]);
  for (const r of rows) {
    row(table, [nameOf(r.i), `${digits(r.reference, 4)} ± ${digits(data.reference.standard_error[r.i], 2)}`,
      settings[r.best.setting].name, percent(r.best.errors[r.i]), settings[r.worst.setting].name,
      percent(r.worst.errors[r.i])], "td", [1, 3, 5]);
  }
  byId("differences-body").append(element("div", table, { class: "wide" }));
}

function bytes(text) {
  return Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
}
function pictureOf(width, height, colour) {
  const canvas = element("canvas", "", { width, height });
  canvas.style.width = `${Math.round(200 * Math.min(1, width / height))}px`;
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  for (let k = 0; k < width * height; k++) image.data.set([...colour(k), 255], 4 * k);
  context.putImageData(image, 0, 0);
  return canvas;
}
function drawPictures() {
  byId("differences-note").textContent =
    `The tiles in which settings differ most when each has about the same time (${time(data.comparison_s)} for all tiles): ` +
    `the reference; then answers, and below each its FLIP, dark where it looks alike. Shown at ${data.exposure_ev} EV.`;
  for (const tile of data.pictures) {
    const line = element("div", "", { class: "pictures" });
    const figure = (canvases, caption) => line.append(element("figure", [...canvases, element("figcaption", caption)]));
    const rgb = (text) => { const b = bytes(text); return pictureOf(tile.width, tile.height, (k) => b.slice(3 * k, 3 * k + 3)); };
    figure([rgb(tile.reference)], `reference, pixels from (${tile.x}, ${tile.y})`);
    for (const answer of tile.answers) {
      const b = bytes(answer.difference);
      const map = pictureOf(tile.width, tile.height, (k) => ramped(b[k] / 255).match(/\d+/g).map(Number));
      const cell = settings[answer.setting].cells;
      figure([rgb(answer.picture), map], `${settings[answer.setting].name}: FLIP ${digits(answer.flip)}`);
    }
    byId("differences-body").append(line);
  }
}

function drawDifferences() {
  if (data.pictures) return drawPictures();
  if (!data.items || data.items.length === 0) { byId("differences").style.display = "none"; return; }
  if (data.points) return drawPoints();
  byId("differences-note").textContent = "Errors of single items when each setting has about the same time.";
  itemTable((i) => data.labels[i]);
}

function tellCells() {
  const table = byId("cells");
  const withFlip = Boolean(measures.flip);
  const heads = ["setting", "amount", "time (quartiles)", "relative error (95%)", "RMSE (95%)"];
  if (withFlip) heads.push("FLIP (95%)");
  heads.push("samples", "rays", "runs");
  const numbers = heads.map((_, k) => k).filter((k) => k >= 2);
  row(table, heads, "th", numbers);
  for (const i of swept) {
    for (const c of settings[i].cells) {
      const interval = (e, tell) => `${tell(e.mean)} (${tell(e.lower)} – ${e.upper === null ? "?" : tell(e.upper)})`;
      const cells = [settings[i].name, amount(c.amount),
        `${time(c.seconds.median)} (${time(c.seconds.lower)} – ${time(c.seconds.upper)})`,
        interval(c.relative_error, percent), interval(c.rmse, digits)];
      if (withFlip) cells.push(interval(c.flip, digits));
      cells.push(c.samples.toLocaleString("en"), c.rays.toLocaleString("en"), String(c.runs));
      row(table, cells, "td", numbers);
    }
  }
  const others = settings.filter((s) => s.fate !== "swept");
  if (others.length === 0) return;
  const list = element("ul");
  for (const s of others) list.append(element("li", [element("b", s.name), `: ${s.why}`]));
  byId("others").append(element("h2", "Settings that were not swept to the end"), list);
}

function tellMethod() {
  const c = data.circumstances, r = data.reference;
  const list = element("ul");
  const say = (...parts) => list.append(element("li", parts));
  say(element("b", "Reference: "), r.exact ? `${r.way}; its error is at most ${percent(r.relative_error)} (its own bound, which is what is shown as the error of asking for it).`
    : `${r.way}. Mean of ${r.replicates} answers of ${r.samples_each} samples with different seeds, ${time(r.seconds)}. ` +
      `Its own relative error, from their scatter: ${percent(r.relative_error)}. It is another estimator than any that was swept.`);
  say(element("b", "Relative error: "), `${data.relative_error.definition}, dark = ${digits(data.relative_error.dark)} (a hundredth of the reference's mean). ` +
      `Of several runs: the root of the mean of their squares. Intervals: Student's t of that mean, in logarithms.`);
  if (measures.flip) {
    say(element("b", "FLIP: "), `mean over the tiles' pixels, of values clamped to what a screen shows at ${data.exposure_ev} EV, 67 pixels per degree ` +
        `(Andersson et al. 2020).`);
  }
  say(element("b", "Times: "), `wall time around the call in the client, over loopback or the network there was; median and quartiles over runs. ` +
      `Every run has a seed of its own. Each round asks every amount of every setting once, shuffled. After the first rounds, settings far behind ` +
      `are dropped, and what is left of the budget goes to the others. Runs by which the sweep learnt what amounts cost are in tradeoff.csv as round 0 and count for nothing.`);
  say(element("b", "Time to an error: "), "between measurements linearly in logarithms; beyond them by the fitted rate of the last three, which is marked as extrapolated.");
  const table = element("table");
  for (const [name, value] of [["scene", c.scene], ["scene id", c.scene_id], ["server", `lucernad ${c.server_version}, ${c.server_threads} compute threads`],
    ["client", c.client_version], ["numeric fingerprint", c.fingerprint], ["build", c.build], ["Embree", c.embree],
    ["date", c.date], ["budget", `${time(c.budget_s)}, seed ${c.seed}`]]) row(table, [name, String(value)]);
  byId("method-body").append(list, table);
}

tellHeader();
tellLevels();
drawMeasures();
drawLegend();
drawErrors();
drawEfficiency();
drawDifferences();
tellCells();
tellMethod();

// "#only=errors" leaves one section, for a picture of it.
const only = location.hash.match(/^#only=(\w+)$/);
if (only && byId(only[1])) {
  document.body.classList.add("only");
  byId(only[1]).classList.add("kept");
}
