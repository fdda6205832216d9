// Prints, for each line {file, text} of its input, how many errors TypeScript finds in the file
// with that text. One process does this for all mutants of a run (./diaphane mutants), because the
// types of the other files are the same.
import { createRequire } from "node:module";
import { join } from "node:path";
import { createInterface } from "node:readline";

const frontend = process.argv[2];
const ts = createRequire(join(frontend, "package.json"))("typescript");
const config = ts.getParsedCommandLineOfConfigFile(join(frontend, "tsconfig.app.json"), {}, { ...ts.sys, onUnRecoverableConfigFileDiagnostic: () => {} });
let changed = { file: "", text: "", version: 0 };
const service = ts.createLanguageService({
  getScriptFileNames: () => config.fileNames,
  getScriptVersion: (file) => (file === changed.file ? `${changed.version}` : "0"),
  getScriptSnapshot: (file) => {
    const text = file === changed.file ? changed.text : ts.sys.readFile(file);
    return text === undefined ? undefined : ts.ScriptSnapshot.fromString(text);
  },
  getCurrentDirectory: () => frontend,
  getCompilationSettings: () => config.options,
  getDefaultLibFileName: ts.getDefaultLibFilePath,
  fileExists: ts.sys.fileExists,
  readFile: ts.sys.readFile,
  readDirectory: ts.sys.readDirectory,
  directoryExists: ts.sys.directoryExists,
  realpath: ts.sys.realpath,
});

for await (const line of createInterface({ input: process.stdin })) {
  const { file, text } = JSON.parse(line);
  changed = { file, text, version: changed.version + 1 };
  console.log(service.getSyntacticDiagnostics(file).length + service.getSemanticDiagnostics(file).length);
}
