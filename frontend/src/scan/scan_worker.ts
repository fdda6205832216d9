import { scan_files } from "./scan";
import type { ScanResult } from "./types";

export type FromWorker =
  | { readonly kind: "progress"; readonly done: number; readonly total: number }
  | { readonly kind: "result"; readonly result: ScanResult };

const shown_every_ms = 60;

self.onmessage = (event: MessageEvent<readonly File[]>) => {
  let last = 0;
  const say = (message: FromWorker) => self.postMessage(message);
  const progress = (done: number, total: number) => {
    const now = performance.now();
    if (done < total && now - last < shown_every_ms) return;
    last = now;
    say({ kind: "progress", done, total });
  };
  void scan_files(event.data, progress, () => false).then((result) => say({ kind: "result", result }));
};
