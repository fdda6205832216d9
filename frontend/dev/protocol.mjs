// Generates src/protocol/gen from the messages of api/proto if they are newer. The result is never committed.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readdirSync, rmSync, statSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const frontend = join(dirname(fileURLToPath(import.meta.url)), "..");
const root = join(frontend, "..");
const out = join(frontend, "src/protocol/gen");
const names = ["scene.proto", "stream.proto", "volume.proto"];
const sources = names.map((name) => join(root, "api/proto", name));
const results = names.map((name) => join(out, "api/proto", name.replace(".proto", "_pb.ts")));

const newest = Math.max(...[...sources, fileURLToPath(import.meta.url)].map((file) => statSync(file).mtimeMs));
if (results.every((file) => existsSync(file) && statSync(file).mtimeMs > newest)) process.exit(0);

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
const plugin = join(frontend, "node_modules/.bin/protoc-gen-es");
const run = spawnSync(
  "protoc",
  [`-I${root}`, `--plugin=protoc-gen-es=${plugin}`, `--es_out=${out}`, "--es_opt=target=ts", ...sources],
  { stdio: "inherit" },
);
if (run.error) {
  console.error("protoc is missing: install Debian's protobuf-compiler");
  process.exit(1);
}
if (run.status !== 0) process.exit(run.status ?? 1);
console.log(`protocol: ${readdirSync(join(out, "api/proto")).join(", ")}`);
