import type { Progress } from "./scan";
import type { FromWorker, ToWorker } from "./scan_worker";
import type { ScanResult } from "./types";

/** Scans in a worker, so that the page stays alive. Aborting ends the worker; the promise then never settles. */
export function scan_in_worker(files: readonly File[], progress: Progress, signal: AbortSignal): Promise<ScanResult> {
  return new Promise((resolve, reject) => {
    const worker = new Worker(new URL("./scan_worker.ts", import.meta.url), { type: "module" });
    signal.addEventListener("abort", () => worker.terminate(), { once: true });
    worker.onerror = (event) => {
      worker.terminate();
      reject(new Error(event.message || "the scan stopped"));
    };
    worker.onmessage = (event: MessageEvent<FromWorker>) => {
      const message = event.data;
      if (message.kind === "progress") {
        progress(message.done, message.total);
        return;
      }
      worker.terminate();
      resolve(message.result);
    };
    void hand_over(worker, files, signal);
  });
}

const handed_at_once = 8;
const longest_ms = 12;

/** Bit by bit: the browser needs about a millisecond for each file, and 3,000 at once would hold the page up for seconds. */
async function hand_over(worker: Worker, files: readonly File[], signal: AbortSignal): Promise<void> {
  const say = (message: ToWorker) => worker.postMessage(message);
  say({ kind: "begin", total: files.length });
  let began = performance.now();
  for (let at = 0; at < files.length && !signal.aborted; at += handed_at_once) {
    say({ kind: "files", files: files.slice(at, at + handed_at_once) });
    if (performance.now() - began < longest_ms) continue;
    await new Promise((go_on) => setTimeout(go_on));
    began = performance.now();
  }
}
