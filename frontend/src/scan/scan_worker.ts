import { Arriving } from "./arriving";
import { scanFiles } from "./scan";
import type { ScanResult, Series } from "./types";
import { buffersOf } from "./upload_plan";

export type ToWorker =
  { readonly kind: "begin"; readonly total: number } | { readonly kind: "files"; readonly files: readonly File[] };

export type FromWorker =
  | { readonly kind: "progress"; readonly done: number; readonly total: number }
  | { readonly kind: "result"; readonly result: ScanResult };

const shownEveryMs = 100;
const buffersOfSeries = ({ upload, thumbnail }: Series) => [
  ...buffersOf(upload),
  ...(thumbnail ? [thumbnail.gray.buffer] : []),
];
let arriving: Arriving | null = null;

self.onmessage = (event: MessageEvent<ToWorker>) => {
  if (event.data.kind === "files") {
    arriving?.add(event.data.files);
    return;
  }
  let last = 0;
  const say = (message: FromWorker, given: ArrayBuffer[] = []) => self.postMessage(message, { transfer: given });
  const progress = (done: number, total: number) => {
    const now = performance.now();
    if (done < total && now - last < shownEveryMs) return;
    last = now;
    say({ kind: "progress", done, total });
  };
  arriving = new Arriving(event.data.total);
  void scanFiles(arriving, progress, () => false).then((result) =>
    say({ kind: "result", result }, result.series.flatMap(buffersOfSeries)),
  );
};
