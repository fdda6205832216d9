import { pauses } from "./pause";
import type { Progress } from "./scan";
import type { FromWorker, ToWorker } from "./scan_worker";
import type { ScanResult } from "./types";

/**
 * Scans in a worker, so that the page stays responsive. Aborting terminates the worker, and the promise then never
 * settles.
 */
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
 * Hands over the files in small groups. The browser reads each file's size from the disk when it is first used, which
 * blocks the page for a millisecond per file: several seconds for the 3,000 files of a disc.
 */
async function handOver(worker: Worker, files: readonly File[], signal: AbortSignal): Promise<void> {
  const say = (message: ToWorker) => worker.postMessage(message);
  say({ kind: "begin", total: files.length });
  // The browser is still processing the selection, and the first access would wait for all of it.
  await new Promise((resolve) => setTimeout(resolve, settlingMs));
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
