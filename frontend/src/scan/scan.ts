import { allThere, Arriving } from "./arriving";
import { uploadParts } from "./clean_file";
import { fingerprint } from "./fingerprint";
import { isSlice, judge } from "./judge";
import { HeaderReader } from "./read_file";
import { drawThumbnail } from "./thumbnail";
import type { Chosen, ScanResult, Series, SliceHeader, Suitable, Thumbnail } from "./types";
import { planOf } from "./upload_plan";

/** Number of files read at the same time: enough to keep a disk busy, and few enough for a phone. */
const atOnce = 12;

export type Progress = (done: number, total: number) => void;

/** Reads every file, whatever its name, and sorts the slices into series. */
export async function scanFiles(
  given: readonly Blob[] | Arriving,
  progress: Progress,
  stopped: () => boolean,
): Promise<ScanResult> {
  const arriving = given instanceof Arriving ? given : allThere(given);
  const { files, total } = arriving;
  const headers: SliceHeader[] = [];
  let notDicom = 0;
  let unreadable = 0;
  let next = 0;
  let done = 0;
  const reader = new HeaderReader();
  const worker = async () => {
    while (next < total && !stopped()) {
      const index = next++;
      const file = await arriving.file(index);
      if (!file) continue;
      const read = await reader.read(file, index);
      if (read.kind === "headers") headers.push(...read.headers);
      else if (read.kind === "not_dicom") notDicom += 1;
      else if (read.kind === "unreadable") unreadable += 1;
      progress(++done, total);
    }
  };
  await Promise.all(Array.from({ length: atOnce }, worker));
  headers.sort((a, b) => a.file - b.file || a.frame - b.frame); // independent of the order in which the disk delivered them
  const series: Series[] = [];
  const slicesOnly = headers.filter(isSlice);
  for (const [key, slices] of bySeries(slicesOnly)) series.push(await seriesOf(key, slices, files));
  series.sort(byUse);
  const notSlices = headers.length - slicesOnly.length;
  return { series, notDicom, unreadable, notSlices, files: total };
}

/**
 * Separates the stacks of an enhanced file, and two patients on one disc, even if a faulty device gave them the same
 * series.
 */
function bySeries(headers: readonly SliceHeader[]): Map<string, SliceHeader[]> {
  const groups = new Map<string, SliceHeader[]>();
  for (const header of headers) {
    const key = `${header.patient.id}\n${header.patient.name}\n${header.studyUid}\n${header.seriesUid}\n${header.stack}`;
    const group = groups.get(key);
    if (group) group.push(header);
    else groups.set(key, [header]);
  }
  return groups;
}

async function seriesOf(key: string, slices: readonly SliceHeader[], files: readonly Blob[]): Promise<Series> {
  const first = slices[0];
  const judged = judge(slices);
  const ordered = judged.suitable ? judged.slices : slices;
  return {
    key,
    description: first?.description ?? "",
    bodyPart: first?.bodyPart ?? "",
    date: first?.date ?? "",
    modality: first?.modality ?? "",
    seriesNumber: first?.seriesNumber ?? null,
    patient: first?.patient ?? { name: "", id: "", birthDate: "" },
    slices: ordered.length,
    verdict: judged.suitable ? withoutSlices(judged) : judged,
    thumbnail: judged.suitable ? await middleSlice(ordered, files) : null,
    upload: planOf(judged.suitable ? uploadParts(ordered) : []),
    fingerprint: fingerprint(ordered),
  };
}

/** The headers stay in the worker, because the page does not need them and copying thousands of them takes long. */
const withoutSlices = ({ size, sizeMm, leftOut, repairs }: Chosen): Suitable => ({
  suitable: true,
  size,
  sizeMm,
  leftOut,
  repairs,
});

async function middleSlice(ordered: readonly SliceHeader[], files: readonly Blob[]): Promise<Thumbnail | null> {
  const slice = ordered[Math.floor(ordered.length / 2)];
  const file = slice ? (slice.inflated ?? files[slice.file]) : undefined;
  if (!slice?.pixels || !file) return null;
  try {
    const { offset, length } = slice.pixels;
    return drawThumbnail(slice, await file.slice(offset, offset + length).arrayBuffer());
  } catch {
    return null; // a series without a thumbnail is still shown
  }
}

/** Sorts suitable series to the front, the largest first. */
function byUse(a: Series, b: Series): number {
  if (a.verdict.suitable !== b.verdict.suitable) return a.verdict.suitable ? -1 : 1;
  return b.slices - a.slices;
}
