"use strict";
// Words and tables, and at the end what is done.

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
  say(element("b", "Time to an error: "), "between measurements linearly in logarithms; beyond them with the root of the time, as errors of independent samples fall, which is marked as extrapolated; not where the last three fall more slowly.");
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
