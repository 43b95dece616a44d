"use strict";
// The plots.

const measures = {
  relative_error: { title: "relative error (root mean square)", format: percent },
  rmse: { title: `RMSE, ${data.quantity}`, format: (v) => digits(v) },
};
if (settings.some((s) => s.cells.some((c) => c.flip))) {
  measures.flip = { title: "mean FLIP", format: (v) => digits(v) };
}
let measure = "relative_error";
const shown = new Set(drawn.filter(important));
let pointed = null;

// Powers of ten, with 2 and 5 between them if there are few.
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
const logarithmic = (title, format) => ({
  type: "logarithmic",
  title: { display: true, text: title, color: "#5b6475", font: { size: 13 } },
  afterBuildTicks: ticks,
  ticks: { callback: (v) => format(v), color: "#5b6475", autoSkip: false, maxRotation: 0 },
  grid: { color: "#edf0f4" },
});

// Lines across the whole plot.  Their labels are on the right, where they hide no points.
const lines = {
  id: "lines",
  beforeDatasetsDraw(chart, _, options) {
    const { ctx, chartArea: area, scales: { y } } = chart;
    const taken = [];
    for (const { at, text, colour } of options.list || []) {
      const py = y.getPixelForValue(at);
      if (!(py >= area.top && py <= area.bottom)) continue;
      // Labels that would overlap move down.
      let line = py;
      while (taken.some((t) => Math.abs(t - line) < 14)) line += 14;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.setLineDash([3, 4]);
      ctx.beginPath();
      ctx.moveTo(area.left, py);
      ctx.lineTo(area.right, py);
      ctx.stroke();
      ctx.font = "12px sans-serif";
      ctx.textBaseline = "middle";
      text.split("\n").forEach((part, k) => {
        ctx.fillText(part, area.right + 6, line + 14 * k);
        taken.push(line + 14 * k);
      });
      ctx.restore();
    }
  },
};

function errorDatasets() {
  const sets = [];
  for (const i of drawn) {
    if (!shown.has(i) && pointed !== i) continue;
    const strong = pointed === i || (pointed === null && important(i));
    const cells = settings[i].cells.filter((c) => !c.exact && c[measure] && c[measure].mean > 0);
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
      pointHitRadius: 0, order: 0, band: true, stepped: "before", fill: false,
      data: front.map(([s, c]) => settings[s].cells[c]).filter((c) => !c.exact)
        .map((c) => ({ x: c.seconds.median, y: c.relative_error.mean })),
    });
  }
  return sets;
}

const referenceText = "the reference's\nown error";
let errorPlot = null;
function drawErrors() {
  if (drawn.length === 0) return;
  if (errorPlot) errorPlot.destroy();
  const list = measure === "relative_error"
    ? [...data.levels.map((l) => ({ at: l.error, text: percent(l.error), colour: "#9aa3b2" })),
      { at: data.reference.relative_error, text: referenceText, colour: "#c23b3b" }]
    : measure === "rmse" ? [{ at: data.reference.rmse, text: referenceText, colour: "#c23b3b" }] : [];
  errorPlot = new Chart(byId("error-plot"), {
    type: "line",
    data: { datasets: errorDatasets() },
    plugins: [lines],
    options: {
      animation: false, parsing: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", intersect: true },
      layout: { padding: { right: 95 } },
      scales: {
        x: logarithmic("wall time of a call in the client (median)", time),
        y: logarithmic(measures[measure].title, measures[measure].format),
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
                `${amount(c.amount)}: ${measures[measure].format(e.mean)} ` +
                  `(${measures[measure].format(e.lower)} to ${measures[measure].format(e.upper)})`,
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
  if (drawn.length === 0) return;
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
  if (exact.length > 0) {
    legend.append(element("h3", "exact, not in the plot"));
    for (const i of exact) legend.append(element("div", nameTime(i, settings[i].cells[settings[i].exact_at])));
  }
  const best = drawn.filter(important);
  if (best.length > 0) legend.append(element("h3", `${best.includes(0) ? "automatic, and " : ""}the best at some time (Pareto front)`));
  best.forEach(entry);
  const rest = drawn.filter((i) => !important(i));
  if (rest.length === 0) return;
  legend.append(element("h3", "others: tick to show, point to highlight"));
  rest.forEach(entry);
}

function drawMeasures() {
  if (drawn.length === 0) {
    byId("error-box").style.display = "none";
    byId("error-note").textContent = `Every setting is exact: ${exactText()}.`;
    return;
  }
  const box = byId("measures");
  for (const [key, { title }] of Object.entries(measures)) {
    const button = element("input", "", { type: "radio", name: "measure" });
    button.checked = key === measure;
    button.addEventListener("change", () => { measure = key; drawErrors(); });
    box.append(element("label", [button, " ", title]));
  }
  byId("error-note").textContent =
    "Bands: 95% intervals over runs with different seeds. Dashed: the Pareto front, the least error of all settings at that " +
    "time. Each point is one amount of work, at the median time of its runs.";
  if (exact.length > 0) byId("error-note").textContent += ` Exact settings are not in this plot: ${exactText()}.`;
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
  // A single setting has nothing to compare with.
  if (ranked.length < 2) { byId("efficiency").style.display = "none"; return; }
  const first = ranked.includes(0) ? 0 : ranked[0];
  const unit = settings[first].efficiency_per_s.mean;
  byId("efficiency-unit").textContent = settings[first].name;
  if (exact.length > 0) byId("efficiency-note").append(` Exact settings are not shown: ${exactText()}.`);
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
        x: { ...logarithmic(`efficiency, ${settings[first].name} = 1`, (v) => `${digits(v)} ×`),
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
              return [`${digits(of(ranked[item.dataIndex], "mean"))} × ${settings[first].name}`,
                `${digits(s.efficiency_per_s.mean)} /s at ${amount(c.amount)}: ${percent(c.relative_error.mean)} in ${time(c.seconds.median)}`];
            },
          },
        },
      },
    },
  });
}

// From dark to light in perceptually equal steps.
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
    `The relative error of every point (root mean square over runs) when each setting takes about ${time(data.comparison_s)} for all points. ` +
    `Settings whose amounts take over twice or under half that time are left out, and exact settings.`;
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
  showItems((i) => `(${points[i].map((x) => digits(x, 4)).join(", ")})`);
}

// The items with the largest ratios between the worst and the best setting.
function showItems(nameOf) {
  const items = data.items;
  if (items.length < 2) return;
  const rows = data.reference.values.map((reference, i) => {
    const order = items.map((item) => item).sort((a, b) => a.errors[i] - b.errors[i]);
    const best = order[0], worst = order[order.length - 1];
    // An error below the reference's own error is not resolved.
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
    `The tiles in which settings differ most when each takes about ${time(data.comparison_s)} for all tiles: ` +
    `the reference, then answers with their FLIP below, which is dark where both look the same. Shown at ${data.exposure_ev} EV.`;
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
  const some = data.pictures || data.items;
  if (!some || some.length === 0) { byId("differences").style.display = "none"; return; }
  if (data.pictures) return drawPictures();
  if (data.points) return drawPoints();
  byId("differences-note").textContent = `Errors of single items when each setting takes about ${time(data.comparison_s)}. Settings whose amounts take more than twice or less than half of ` +
    "that time are left out. Exact settings are left out, too.";
  showItems((i) => data.labels[i]);
}
