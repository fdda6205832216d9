import { Arriving } from "./arriving";
import { scan_files } from "./scan";
import type { ScanResult } from "./types";

export type ToWorker = { readonly kind: "begin"; readonly total: number } | { readonly kind: "files"; readonly files: readonly File[] };

export type FromWorker =
  | { readonly kind: "progress"; readonly done: number; readonly total: number }
  | { readonly kind: "result"; readonly result: ScanResult };

const shown_every_ms = 60;
let arriving: Arriving | null = null;

self.onmessage = (event: MessageEvent<ToWorker>) => {
  if (event.data.kind === "files") {
    arriving?.add(event.data.files);
    return;
  }
  let last = 0;
  const say = (message: FromWorker) => self.postMessage(message);
  const progress = (done: number, total: number) => {
    const now = performance.now();
    if (done < total && now - last < shown_every_ms) return;
    last = now;
    say({ kind: "progress", done, total });
  };
  arriving = new Arriving(event.data.total);
  void scan_files(arriving, progress, () => false).then((result) => say({ kind: "result", result }));
};
