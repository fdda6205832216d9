// What the page's scanner makes of folders of files, for the table of cases of ingest (tools/devtool/ingest_cases):
// node dev/judge_folders.mjs OUT FOLDER... prints a list of {outcomes, words}, in the words of that table, and writes what the
// page would send of the first suitable series of each folder to OUT/0.tar, OUT/1.tar, ...
import { openAsBlob } from "node:fs";
import { readdir, writeFile } from "node:fs/promises";
import { join } from "node:path";
import { runnerImport } from "vite";

const load = async (name) =>
  (await runnerImport(join(import.meta.dirname, "../src", name), { logLevel: "error" })).module;
const [{ scanFiles }, { partBlobs }, { makeBundle }, { reasons }] = await Promise.all(
  ["scan/scan.ts", "scan/upload_plan.ts", "scan/bundle.ts", "texts/en/reasons.ts"].map(load),
);

async function filesBelow(folder) {
  const entries = await readdir(folder, { recursive: true, withFileTypes: true });
  const paths = entries.filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath, entry.name));
  return Promise.all(paths.sort().map((path) => openAsBlob(path)));
}

const scan = async (files) =>
  scanFiles(
    files,
    () => undefined,
    () => false,
  );

function wordsOf({ series, notSlices, notDicom, unreadable }) {
  if (series.length === 0)
    return {
      outcomes: [notSlices > 0 ? "not listed" : "refused: nothing"],
      words: `${notDicom} not DICOM, ${unreadable} unreadable`,
    };
  const outcomes = series.map(({ verdict }) => (verdict.suitable ? "built" : `refused: ${verdict.reason}`));
  const words = series.map(({ verdict }) =>
    verdict.suitable ? JSON.stringify([verdict.repairs, verdict.leftOut]) : reasons[verdict.reason](verdict.count),
  );
  return { outcomes, words: words.join("; ") };
}

const [out, ...folders] = process.argv.slice(2);
const judged = [];
for (const [number, folder] of folders.entries()) {
  const files = await filesBelow(folder);
  const result = await scan(files);
  judged.push(wordsOf(result));
  const chosen = result.series.find(({ verdict }) => verdict.suitable);
  if (!chosen) continue;
  const bundle = makeBundle(await partBlobs(chosen.upload, files));
  await writeFile(join(out, `${number}.tar`), Buffer.from(await bundle.arrayBuffer()));
}
process.stdout.write(JSON.stringify(judged));
