import { all_there, Arriving } from "./arriving";
import { upload_parts } from "./clean_file";
import { fingerprint } from "./fingerprint";
import { is_slice, judge } from "./judge";
import { HeaderReader } from "./read_file";
import { draw_thumbnail } from "./thumbnail";
import type { Chosen, ScanResult, Series, SliceHeader, Suitable, Thumbnail } from "./types";
import { plan_of } from "./upload_plan";

/** So many files at once: enough to keep a disk busy, few enough for a phone. */
const at_once = 12;

export type Progress = (done: number, total: number) => void;

/** Looks at every file whatever its name, and sorts what it finds into series. */
export async function scan_files(given: readonly Blob[] | Arriving, progress: Progress, stopped: () => boolean): Promise<ScanResult> {
  const arriving = given instanceof Arriving ? given : all_there(given);
  const { files, total } = arriving;
  const headers: SliceHeader[] = [];
  let not_dicom = 0;
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
      else if (read.kind === "not_dicom") not_dicom += 1;
      else unreadable += 1;
      progress(++done, total);
    }
  };
  await Promise.all(Array.from({ length: at_once }, worker));
  headers.sort((a, b) => a.file - b.file || a.frame - b.frame); // whatever order the disk gave them in
  const series: Series[] = [];
  const slices_only = headers.filter(is_slice);
  for (const [key, slices] of by_series(slices_only)) series.push(await series_of(key, slices, files));
  series.sort(by_use);
  const not_slices = headers.length - slices_only.length;
  return { series, not_dicom, unreadable, not_slices, files: total };
}

/** Several stacks of an enhanced file are apart as well. Two patients on one disc are listed apart, even where a faulty device gave them one series. */
function by_series(headers: readonly SliceHeader[]): Map<string, SliceHeader[]> {
  const groups = new Map<string, SliceHeader[]>();
  for (const header of headers) {
    const key = `${header.patient.id}\n${header.patient.name}\n${header.study_uid}\n${header.series_uid}\n${header.stack}`;
    const group = groups.get(key);
    if (group) group.push(header);
    else groups.set(key, [header]);
  }
  return groups;
}

async function series_of(key: string, slices: readonly SliceHeader[], files: readonly Blob[]): Promise<Series> {
  const first = slices[0];
  const judged = judge(slices);
  const ordered = judged.suitable ? judged.slices : slices;
  return {
    key,
    description: first?.description ?? "",
    body_part: first?.body_part ?? "",
    modality: first?.modality ?? "",
    series_number: first?.series_number ?? null,
    patient: first?.patient ?? { name: "", id: "", birth_date: "" },
    slices: ordered.length,
    verdict: judged.suitable ? without_slices(judged) : judged,
    thumbnail: judged.suitable ? await middle_slice(ordered, files) : null,
    upload: plan_of(judged.suitable ? upload_parts(ordered) : []),
    fingerprint: fingerprint(ordered),
  };
}

/** The headers stay with the scan: the page needs none of them, and thousands are long on their way to it. */
const without_slices = ({ size, size_mm, left_out, repairs }: Chosen): Suitable => ({ suitable: true, size, size_mm, left_out, repairs });

async function middle_slice(ordered: readonly SliceHeader[], files: readonly Blob[]): Promise<Thumbnail | null> {
  const slice = ordered[Math.floor(ordered.length / 2)];
  const file = slice ? (slice.inflated ?? files[slice.file]) : undefined;
  if (!slice?.pixels || !file) return null;
  try {
    const { offset, length } = slice.pixels;
    return draw_thumbnail(slice, await file.slice(offset, offset + length).arrayBuffer());
  } catch {
    return null; // no picture is no reason to hide a series
  }
}

/** Suitable ones first, the largest of them on top. */
function by_use(a: Series, b: Series): number {
  if (a.verdict.suitable !== b.verdict.suitable) return a.verdict.suitable ? -1 : 1;
  return b.slices - a.slices;
}
