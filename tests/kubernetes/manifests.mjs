// Checks Kubernetes manifests without a cluster.  Each document must match the JSON schemas of the
// npm package kubernetes-models, which come from Kubernetes' OpenAPI description.  It must also
// match that package's types: the schemas allow unknown fields, TypeScript does not.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../..", import.meta.url));
const tools = `${root}build/tools/`; // .ci/install-tools.sh
const require = createRequire(tools);
const ts = require("typescript");
const yaml = require("yaml");

/** The documents of a manifest.  Throws on invalid YAML and on duplicate keys. */
export function read(path) {
  return yaml.parseAllDocuments(readFileSync(path, "utf8")).map((document) => {
    if (document.errors.length > 0) throw document.errors[0];
    return document.toJS();
  });
}

/** The errors of each of `documents`, by its index; an empty list if there are none. */
export function check(documents) {
  const errors = documents.map(() => []);
  const sources = new Map();
  documents.forEach((document, i) => {
    const { apiVersion, kind } = document ?? {};
    const name = `kubernetes-models/${apiVersion}/${kind}`;
    let Model;
    try {
      Model = require(name)[kind];
    } catch {
      errors[i].push(`apiVersion ${apiVersion}, kind ${kind}: Kubernetes has no such kind`);
      return;
    }
    try {
      new Model(document).validate();
    } catch (error) {
      errors[i].push(error.message);
    }
    sources.set(
      `${tools}manifest${i}.ts`,
      `import type { I${kind} } from "${name}";\n` +
        `export const document: I${kind} = ${JSON.stringify(document)};\n`,
    );
  });
  for (const { file, messageText } of diagnostics(sources)) {
    const i = Number(/manifest(\d+)\.ts$/.exec(file.fileName)[1]);
    errors[i].push(ts.flattenDiagnosticMessageText(messageText, "\n"));
  }
  return errors;
}

/** TypeScript's errors in the sources, which are in memory only. */
function diagnostics(sources) {
  const options = {
    strict: true,
    noEmit: true,
    skipLibCheck: true,
    types: [],
    target: ts.ScriptTarget.ES2022,
    module: ts.ModuleKind.CommonJS,
    moduleResolution: ts.ModuleResolutionKind.Node10,
  };
  const host = ts.createCompilerHost(options);
  const { getSourceFile, fileExists, readFile } = host;
  host.getSourceFile = (path, language, ...rest) =>
    sources.has(path)
      ? ts.createSourceFile(path, sources.get(path), language)
      : getSourceFile.call(host, path, language, ...rest);
  host.fileExists = (path) => sources.has(path) || fileExists.call(host, path);
  host.readFile = (path) => sources.get(path) ?? readFile.call(host, path);
  const program = ts.createProgram([...sources.keys()], options, host);
  const general = [...program.getOptionsDiagnostics(), ...program.getGlobalDiagnostics()];
  if (general.length > 0) throw new Error(ts.formatDiagnostics(general, host));
  return [...sources.keys()].flatMap((path) => {
    const source = program.getSourceFile(path);
    return [...program.getSyntacticDiagnostics(source), ...program.getSemanticDiagnostics(source)];
  });
}
