"use strict";
// Texts and tables.  The end of the file fills in the page.

function showHeader() {
  const c = data.circumstances;
  document.title = `${c.scene}: error against time`;
  byId("title").textContent = `Error against time: ${data.query} in ${c.scene}`;
  byId("subtitle").textContent =
    `${data.quantity}, measured through a running server; ${swept.length} settings, ${time(c.spent_s)}.`;
}

function showLevels() {
  const table = byId("levels");
  row(table, ["error", "setting", "time", "automatic takes", "", "command"], "th", [2, 3]);
  // One row is enough if the same exact setting is recommended for every error.
  const anyError = data.levels.every((l) => l.exact && l.setting === data.levels[0].setting);
  for (const level of anyError ? data.levels.slice(0, 1) : data.levels) {
    if (level.setting === undefined) {
      row(table, [percent(level.error), level.below_reference ? "below the error of the reference"
        : "no setting reached this error", "", "", "", ""]);
      continue;
    }
    const how = level.exact ? element("span", "exact", { class: "tag" })
      : level.how === "extrapolated"
      ? element("span", "extrapolated", { class: "tag beyond" })
      : element("span", level.how, { class: "tag" });
    // The ratio is that of the fastest setting, which may not be the recommended one.
    const ratio = level.name === level.best && level.setting !== 0 ? level.automatic_over_best : null;
    const name = [level.name];
    if (level.name !== level.best) {
      name.push(element("small", `not significantly slower than the fastest, ${level.best}, ${time(level.best_seconds)}` +
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

function showCells() {
  const table = byId("cells");
  const withFlip = Boolean(measures.flip);
  const heads = ["setting", "amount", "time (quartiles)", "relative error (95%)", "RMSE (95%)"];
  if (withFlip) heads.push("FLIP (95%)");
  heads.push("samples", "rays", "runs");
  const numbers = heads.map((_, k) => k).filter((k) => k >= 2);
  row(table, heads, "th", numbers);
  for (const i of swept) {
    for (const c of settings[i].cells) {
      // The interval is below the mean, because tables of pictures have many columns.
      const two = (middle, lower, upper) => [middle, element("small", `${lower} – ${upper}`)];
      const interval = (e, format) => two(format(e.mean), format(e.lower), e.upper === null ? "?" : format(e.upper));
      const cells = [settings[i].name, c.samples > 0 ? amount(c.amount) : "",
        two(time(c.seconds.median), time(c.seconds.lower), time(c.seconds.upper)),
        c.exact ? "exact" : interval(c.relative_error, percent), interval(c.rmse, digits)];
      if (withFlip) cells.push(interval(c.flip, digits));
      cells.push(c.samples.toLocaleString("en"), c.rays.toLocaleString("en"), String(c.runs));
      row(table, cells, "td", numbers);
    }
  }
  const explained = swept.filter((i) => settings[i].about);
  if (explained.length > 0) {
    const list = element("ul");
    for (const i of explained) list.append(element("li", [element("b", settings[i].name), `: ${settings[i].about}`]));
    byId("others").append(element("h2", "Settings"), list);
  }
  const others = settings.filter((s) => s.fate !== "swept");
  if (others.length === 0) return;
  const list = element("ul");
  for (const s of others) list.append(element("li", [element("b", s.name), `: ${s.why}`]));
  byId("others").append(element("h2", "Settings that were not measured to the end"), list);
}

function showMethod() {
  const c = data.circumstances, r = data.reference;
  const list = element("ul");
  const add = (...parts) => list.append(element("li", parts));
  add(element("b", "Reference: "), r.exact && r.relative_error === 0 ? `${r.way}. It has no error except rounding.`
    : r.exact ? `${r.way}. Its error is at most ${percent(r.relative_error)}, by its own bound. The page shows this bound as the error of the same method.`
    : `${r.way}. Mean of ${r.replicates} answers of ${r.samples_each} samples with different seeds, ${time(r.seconds)}. ` +
      `Its own relative error, from their scatter: ${percent(r.relative_error)}. No measured setting is this estimator.`);
  add(element("b", "Relative error: "), `${data.relative_error.definition}, dark = ${digits(data.relative_error.dark)} (a hundredth of the reference's mean). ` +
      `The error of several runs is the root of the mean of their squares. Intervals: Student's t of that mean, in logarithms.` +
      (r.exact ? "" : " The square of the reference's own error is subtracted. Errors below half of the reference's own are uncertain."));
  if (r.relative_error <= data.relative_error.rounding) {
    add(element("b", "Exact: "), `relative error below ${digits(data.relative_error.rounding)}, because answers are in single precision.`);
  }
  add(element("b", "Recommended: "), "the setting that reaches the error first. Extrapolated times count twice. Automatic, the simplest command, is recommended if it " +
      "is not significantly slower. Its time is then at most the time of the fastest setting at the upper ends of that setting's 95% intervals and the upper quartiles of its times.");
  if (measures.flip) {
    add(element("b", "FLIP: "), `mean over the pixels of the tiles, of values as shown on a screen at ${data.exposure_ev} EV, 67 pixels per degree ` +
        `(Andersson et al. 2020).`);
  }
  add(element("b", "Times: "), `wall time of the call in the client, network included; median and quartiles over runs. ` +
      `Each round measures every amount of every setting once, in random order. The settings of a round share its seeds; each round has new seeds. ` +
      (c.rounds ? `The study has ${c.rounds} rounds. ` : `After the first rounds, settings that are far behind are dropped, and the others get the rest of the time. `) +
      `Runs that only measure the cost are in tradeoff.csv as round 0 and do not count.`);
  add(element("b", "Time to an error: "), "interpolated linearly in logarithms between measurements. After the last measurement, errors of independent samples fall with the root of the time. Such times are marked as extrapolated. " +
      "Nothing is extrapolated if the last three errors fall more slowly, or for approximations (far lights as points, shadow maps, panes that block), whose errors level off. Errors below half of the reference's own error are left out.");
  const table = element("table");
  for (const [name, value] of [["scene", c.scene], ["scene id", c.scene_id], ["server", `lucernad ${c.server_version}, ${c.server_threads} compute threads`],
    ["client", c.client_version], ["numeric fingerprint", c.fingerprint], ["build", c.build], ["Embree", c.embree],
    ["date", c.date], c.rounds ? ["rounds", `${c.rounds}, up to ${amount({ kind: "samples", value: c.max_samples })}`] : ["budget", time(c.budget_s)],
    ["seed", c.seed]]) row(table, [name, String(value)]);
  byId("method-body").append(list, table);
}

showHeader();
showLevels();
drawMeasures();
drawLegend();
drawErrors();
drawEfficiency();
drawDifferences();
showCells();
showMethod();

// "#only=errors" shows only this section, for a picture of it.
const only = location.hash.match(/^#only=(\w+)$/);
if (only && byId(only[1])) {
  document.body.classList.add("only");
  byId(only[1]).classList.add("kept");
}
