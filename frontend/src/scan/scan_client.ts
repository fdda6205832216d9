import type { Progress } from "./scan";
import type { FromWorker } from "./scan_worker";
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
    worker.postMessage(files);
  });
}
