// The manifests of deploy/kubernetes are valid for Kubernetes and for the programs.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import test from "node:test";

import { check, read, root } from "./manifests.mjs";

const folder = `${root}deploy/kubernetes/`;
const manifests = readdirSync(folder).filter((name) => name.endsWith(".yaml"));
const documents = manifests.flatMap((name) => read(folder + name));
const find = (kind) => structuredClone(documents.find((document) => document.kind === kind));
const pod = (document) => document.spec.template.spec;

test("Kubernetes accepts every manifest", () => {
  assert.deepEqual(manifests, ["render.yaml", "servers.yaml"]);
  assert.deepEqual(documents.map((d) => d.kind).sort(), ["Deployment", "Job", "NetworkPolicy", "PodDisruptionBudget", "Service"]);
  assert.deepEqual(check(documents), documents.map(() => []));
});

test("broken manifests are refused", () => {
  const broken = [
    ["Service", (d) => (d.spec.clusterIp = "None"), /clusterIp.* does not exist/],
    ["Service", (d) => (d.spec.ports[0].port = "50051"), /ports\/0\/port must be integer/],
    ["Service", (d) => delete d.spec.ports[0].port, /must have required property port/],
    ["Service", (d) => (d.kind = "Servise"), /Kubernetes has no such kind/],
    ["Deployment", (d) => (d.apiVersion = "apps/v2"), /Kubernetes has no such kind/],
    ["Deployment", (d) => delete d.spec.selector, /must have required property selector/],
    ["Deployment", (d) => (d.spec.replica = 3), /replica.* does not exist/],
    ["Deployment", (d) => (pod(d).containers[0].livenessProbe.grcp = { port: 50051 }), /grcp.* does not exist/],
    ["Deployment", (d) => (pod(d).containers[0].livenessProbe.grpc.port = "grpc"), /grpc\/port must be integer/],
    ["Deployment", (d) => (pod(d).containers[0].securityContext.capabilities.dropp = ["ALL"]), /dropp.* does not exist/],
    ["Deployment", (d) => (pod(d).volumes[0].emptyDir.size = "1Gi"), /size.* does not exist/],
    ["Job", (d) => (pod(d).restartPolicy = "Sometimes"), /restartPolicy must be equal to one of/],
    ["Job", (d) => (d.spec.podFailurePolicy.rules[0].action = "Forget"), /action must be equal to one of/],
    ["Job", (d) => (pod(d).containers[0].volumeMounts[0].mountpath = "/"), /mountpath.* does not exist/],
    ["PodDisruptionBudget", (d) => (d.spec.minAvailabel = 1), /minAvailabel.* does not exist/],
    ["NetworkPolicy", (d) => (d.spec.ingress[0].form = []), /form.* does not exist/],
  ];
  const errors = check(
    broken.map(([kind, breaks]) => {
      const document = find(kind);
      breaks(document);
      return document;
    }),
  );
  broken.forEach(([, , expected], i) => assert.match(errors[i].join("\n"), expected));
});

test("a duplicate key is refused", () => {
  const directory = mkdtempSync(`${tmpdir()}/lucerna-manifests.`);
  try {
    writeFileSync(`${directory}/twice.yaml`, "kind: Service\nkind: Job\n");
    assert.throws(() => read(`${directory}/twice.yaml`), /Map keys must be unique/);
  } finally {
    rmSync(directory, { recursive: true });
  }
});

test("selectors match, and the job uses the name and the port of the service", () => {
  const labels = find("Deployment").spec.template.metadata.labels;
  assert.deepEqual(find("Deployment").spec.selector.matchLabels, labels);
  assert.deepEqual(find("Service").spec.selector, labels);
  const budget = find("PodDisruptionBudget").spec;
  assert.deepEqual(budget.selector.matchLabels, labels);
  assert.ok(budget.minAvailable < find("Deployment").spec.replicas);
  const policy = find("NetworkPolicy").spec;
  assert.deepEqual(policy.podSelector.matchLabels, labels);
  const from = policy.ingress[0].from[0].podSelector.matchLabels;
  assert.deepEqual(from, find("Job").spec.template.metadata.labels);
  const service = find("Service");
  const port = service.spec.ports[0].port;
  const target = `--servers=dns:///${service.metadata.name}:${port}`;
  assert.ok(pod(find("Job")).containers[0].args.includes(target), target);
  const server = pod(find("Deployment")).containers[0];
  assert.equal(server.ports[0].containerPort, port);
  assert.ok(server.args.includes(`--listen=0.0.0.0:${port}`));
  for (const probe of ["startupProbe", "readinessProbe", "livenessProbe"]) {
    assert.equal(server[probe].grpc.port, port, probe);
  }
});

test("every mount of a container is a volume of its pod", () => {
  for (const kind of ["Deployment", "Job"]) {
    const { containers, volumes } = pod(find(kind));
    const names = volumes.map((volume) => volume.name);
    for (const mount of containers[0].volumeMounts) assert.ok(names.includes(mount.name), mount.name);
  }
});

test("the programs accept the given options", () => {
  const help = (...command) =>
    execFileSync(`${root}build/release/${command[0]}`, [...command.slice(1), "--help"], { encoding: "utf8" });
  const texts = { Deployment: help("bin/lucernad"), Job: help("bin/lucerna", "render") };
  for (const [kind, text] of Object.entries(texts)) {
    const options = pod(find(kind)).containers[0].args.filter((argument) => argument.startsWith("--"));
    assert.ok(options.length > 3);
    for (const option of options) {
      const name = option.split("=")[0];
      assert.match(text, new RegExp(`${name}[ ,]`), `${kind}: ${name}`);
    }
  }
});
