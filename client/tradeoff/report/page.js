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
  // What is exact does for every error where nothing that is not is faster.
  const anyError = data.levels.every((l) => l.exact && l.setting === data.levels[0].setting);
  for (const level of anyError ? data.levels.slice(0, 1) : data.levels) {
    if (level.setting === undefined) {
      row(table, [percent(level.error), level.below_reference ? "the reference does not tell errors so small"
        : "no setting came near within the budget", "", "", "", ""]);
      continue;
    }
    const how = level.exact ? element("span", "exact", { class: "tag" })
      : level.how === "extrapolated"
      ? element("span", "extrapolated", { class: "tag beyond" })
      : element("span", level.how, { class: "tag" });
    // Of the fastest; where another is recommended, that is told with its name.
    const ratio = level.name === level.best && level.setting !== 0 ? level.automatic_over_best : null;
    const name = [level.name];
    if (level.name !== level.best) {
      name.push(element("small", `not told apart from the fastest, ${level.best}, ${time(level.best_seconds)}` +
        `${level.best_how === "extrapolated" ? " (extrapolated)" : ""}`));
    }
    row(table, [
      element("b", anyError ? "any" : percent(level.error)), name,
      (!level.exact && level.how.startsWith("with") ? "≤ " : "") + time(level.seconds),
      ratio === null ? "" : `${digits(ratio)} ×${level.automatic_extrapolated ? " (extrapolated)" : ""}`,
      how, element("code", level.command),
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
      // The interval below its middle: beside it, tables of pictures would be wider than a page.
      const two = (middle, lower, upper) => [middle, element("small", `${lower} – ${upper}`)];
      const interval = (e, tell) => two(tell(e.mean), tell(e.lower), e.upper === null ? "?" : tell(e.upper));
      const cells = [settings[i].name, c.samples > 0 ? amount(c.amount) : "",
        two(time(c.seconds.median), time(c.seconds.lower), time(c.seconds.upper)),
        c.exact ? "exact" : interval(c.relative_error, percent), interval(c.rmse, digits)];
      if (withFlip) cells.push(interval(c.flip, digits));
      cells.push(c.samples.toLocaleString("en"), c.rays.toLocaleString("en"), String(c.runs));
      row(table, cells, "td", numbers);
    }
  }
  const told = swept.filter((i) => settings[i].about);
  if (told.length > 0) {
    const list = element("ul");
    for (const i of told) list.append(element("li", [element("b", settings[i].name), `: ${settings[i].about}`]));
    byId("others").append(element("h2", "What the settings are"), list);
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
  say(element("b", "Reference: "), r.exact && r.relative_error === 0 ? `${r.way}. It has no error of its own but rounding.`
    : r.exact ? `${r.way}; its error is at most ${percent(r.relative_error)} (its own bound, which is what is shown as the error of asking for it).`
    : `${r.way}. Mean of ${r.replicates} answers of ${r.samples_each} samples with different seeds, ${time(r.seconds)}. ` +
      `Its own relative error, from their scatter: ${percent(r.relative_error)}. It is another estimator than any that was swept.`);
  say(element("b", "Relative error: "), `${data.relative_error.definition}, dark = ${digits(data.relative_error.dark)} (a hundredth of the reference's mean). ` +
      `Of several runs: the root of the mean of their squares. Intervals: Student's t of that mean, in logarithms.` +
      (r.exact ? "" : " Less the reference's own, whose square is part of each: what is below half of that is uncertain."));
  if (r.relative_error <= data.relative_error.rounding) {
    say(element("b", "Exact: "), `relative error below ${digits(data.relative_error.rounding)}, as answers come in single precision.`);
  }
  say(element("b", "Recommended: "), "what comes down to the error first, where a time beyond what was measured counts twice; automatic, the " +
      "simplest command, where its time is not beyond the fastest's at the upper ends of that one's 95% intervals and the upper quartiles of its times.");
  if (measures.flip) {
    say(element("b", "FLIP: "), `mean over the tiles' pixels, of values clamped to what a screen shows at ${data.exposure_ev} EV, 67 pixels per degree ` +
        `(Andersson et al. 2020).`);
  }
  say(element("b", "Times: "), `wall time around the call in the client, over loopback or the network there was; median and quartiles over runs. ` +
      `Each round asks every amount of every setting once, shuffled; the settings share its seeds, and no two rounds do. After the first rounds, settings far behind ` +
      `are dropped, and what is left of the budget goes to the others. Runs by which the sweep learnt what amounts cost are in tradeoff.csv as round 0 and count for nothing.`);
  say(element("b", "Time to an error: "), "between measurements linearly in logarithms; beyond them with the root of the time, as errors of independent samples fall, which is marked as extrapolated; not where the last three fall more slowly, and not of approximations (far lights as points, shadow maps), whose errors level off. Errors below half the reference's own are left out, as it does not tell them.");
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
