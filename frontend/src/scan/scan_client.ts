import { pauses } from "./pause";
import type { Progress } from "./scan";
import type { FromWorker, ToWorker } from "./scan_worker";
import type { ScanResult } from "./types";

/** Scans in a worker, so that the page stays alive. Aborting ends the worker; the promise then never settles. */
export function scanInWorker(files: readonly File[], progress: Progress, signal: AbortSignal): Promise<ScanResult> {
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
    void handOver(worker, files, signal);
  });
}

/**
 * Bit by bit: the browser asks the disk for the size of each file when it is first wanted, and the page stands still for
 * that millisecond; for all 3,000 of a disc, for seconds.
 */
async function handOver(worker: Worker, files: readonly File[], signal: AbortSignal): Promise<void> {
  const say = (message: ToWorker) => worker.postMessage(message);
  say({ kind: "begin", total: files.length });
  // The browser still takes in what was chosen, and the first question would wait for all of it.
  await new Promise((goOn) => setTimeout(goOn, settlingMs));
  const pause = pauses();
  let handed = 0;
  for (let at = 0; at < files.length && !signal.aborted; at++) {
    askSize(files[at]);
    const waited = pause();
    if (!waited && at + 1 < files.length) continue;
    say({ kind: "files", files: files.slice(handed, at + 1) });
    handed = at + 1;
    await waited;
  }
}

const settlingMs = 50;
const askSize = (file: File | undefined): number => file?.size ?? 0;
