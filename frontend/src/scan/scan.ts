import { Budget, filesIn, type ArchiveFault, type ArchiveFormat } from "./archives";
import { allThere, Arriving } from "./arriving";
import { uploadParts } from "./clean_file";
import { fingerprint } from "./fingerprint";
import { imageSeries, type FoundImage } from "./image/image_series";
import { isSlice, judge } from "./judge";
import { pieceOf, wholeOf, type Piece } from "./piece";
import { HeaderReader } from "./read_file";
import { drawThumbnail } from "./thumbnail";
import type { Chosen, FaultyArchive, ScanResult, Series, SliceHeader, Suitable, Thumbnail } from "./types";
import { planOf } from "./upload_plan";

/** Number of files read at the same time: enough to keep a disk busy, and few enough for a phone. */
const atOnce = 12;

export type Progress = (done: number, total: number) => void;

/** Maximum nesting of archives: three levels, one of which may be a compressed tar. */
const mostNested = 4;

/**
 * Reads every file, whatever its name and including those in archives, and sorts the slices into
 * series.
 */
export async function scanFiles(
  given: readonly Blob[] | Arriving,
  progress: Progress,
  stopped: () => boolean,
): Promise<ScanResult> {
  const arriving = given instanceof Arriving ? given : allThere(given);
  const search = new Search(progress, stopped);
  await search.read(arriving.total, async (i) => {
    const file = await arriving.file(i);
    return file && pieceOf(file);
  });
  await search.openArchives();
  const { pieces, headers } = search;
  search.images.sort((a, b) => a.file - b.file);
  headers.sort((a, b) => a.file - b.file || a.frame - b.frame); // independent of the order in which the disk delivered them
  const series: Series[] = [];
  const slicesOnly = headers.filter(isSlice);
  for (const [key, slices] of bySeries(slicesOnly)) series.push(await seriesOf(key, slices, pieces));
  for (const image of search.images) {
    const { series: one, second } = await imageSeries(image, pieces);
    series.push(one);
    if (second !== null) search.notDicom -= 1;
  }
  series.sort(byUse);
  const sent = new Set(series.flatMap(({ upload }) => [...upload.files]));
  return {
    series,
    unpacked: pieces.slice(arriving.total).map((piece, i) => (sent.has(arriving.total + i) ? piece : null)),
    faults: search.faults,
    notDicom: search.notDicom,
    unreadable: search.unreadable,
    notSlices: headers.length - slicesOnly.length,
    files: search.files,
  };
}

interface Archive {
  /** Index of the chosen file that is or contains this archive. */
  readonly file: number;
  readonly index: number;
  readonly format: ArchiveFormat;
  readonly depth: number;
}

/** The search of the chosen files, and then of the archives among them. */
class Search {
  readonly pieces: Piece[] = [];
  readonly headers: SliceHeader[] = [];
  readonly images: FoundImage[] = [];
  readonly faults: FaultyArchive[] = [];
  notDicom = 0;
  unreadable = 0;
  private readonly archives: Archive[] = [];
  private readonly budget = new Budget();
  private readonly reader = new HeaderReader();
  private done = 0;

  constructor(
    private readonly progress: Progress,
    private readonly stopped: () => boolean,
  ) {}

  /** Returns the number of files that are not archives. */
  get files(): number {
    return this.pieces.length - this.archives.length;
  }

  /** Reads `count` further files, several at a time. `within`: the archive that they are in. */
  async read(count: number, pieceAt: (i: number) => Promise<Piece | undefined>, within?: Archive): Promise<void> {
    const first = this.pieces.length;
    const total = first + count;
    const found: Archive[] = [];
    let next = 0;
    const worker = async () => {
      while (next < count && !this.stopped()) {
        const i = next++;
        const piece = await pieceAt(i);
        if (!piece) continue;
        const index = first + i;
        this.pieces[index] = piece;
        const read = await this.reader.read(piece, index);
        if (read.kind === "headers") this.headers.push(...read.headers);
        else if (read.kind === "image") this.images.push({ file: index, header: read.header });
        else if (read.kind === "not_dicom") this.notDicom += 1;
        else if (read.kind === "unreadable") this.unreadable += 1;
        else if (read.kind === "archive") {
          const depth = (within?.depth ?? 0) + 1;
          found.push({ file: within?.file ?? index, index, format: read.format, depth });
        }
        this.progress(++this.done, total);
      }
    };
    await Promise.all(Array.from({ length: atOnce }, worker));
    this.archives.push(...found.sort((a, b) => a.index - b.index));
  }

  /** Opens archives one after the other, also those that it finds in archives, so that the order is always the same. */
  async openArchives(): Promise<void> {
    for (const archive of this.archives) {
      if (this.stopped()) return;
      const inside = await this.list(archive);
      await this.read(inside.length, (i) => Promise.resolve(inside[i]), archive);
    }
  }

  private async list(archive: Archive): Promise<Piece[]> {
    const blob = await this.contentOf(archive);
    const inside: Piece[] = [];
    if (!blob) return inside;
    for await (const one of filesIn(blob, archive.format, this.budget)) {
      if (typeof one === "string") this.report(archive, one);
      else inside.push(archive.format === "gzip" ? this.namedLike(archive, one) : one);
    }
    return inside;
  }

  /** Gives a file that was compressed alone, such as a scan in NIfTI, the name of its archive. */
  private namedLike({ index }: Archive, piece: Piece): Piece {
    const packed = this.pieces[index]?.blob;
    return packed instanceof File ? pieceOf(new File([piece.blob], packed.name)) : piece;
  }

  private async contentOf(archive: Archive): Promise<Blob | null> {
    const piece = this.pieces[archive.index];
    if (!piece) return null;
    if (archive.depth > mostNested) {
      this.report(archive, "nested");
      return null;
    }
    const unpacked = piece.zipped?.isDeflated ? piece.size : 0;
    if (unpacked > this.budget.bytesLeft) {
      this.report(archive, "large");
      return null;
    }
    this.budget.takeBytes(unpacked);
    try {
      return await wholeOf(piece);
    } catch {
      this.report(archive, "damaged");
      return null;
    }
  }

  private report({ file }: Archive, fault: ArchiveFault): void {
    if (!this.faults.some((known) => known.file === file && known.fault === fault)) this.faults.push({ file, fault });
  }
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

async function seriesOf(key: string, slices: readonly SliceHeader[], pieces: readonly Piece[]): Promise<Series> {
  const first = slices[0];
  const judged = judge(slices);
  const ordered = judged.suitable ? judged.slices : slices;
  return {
    key,
    description: first?.description ?? "",
    fileName: "",
    bodyPart: first?.bodyPart ?? "",
    date: first?.date ?? "",
    modality: first?.modality ?? "",
    seriesNumber: first?.seriesNumber ?? null,
    patient: first?.patient ?? { name: "", id: "", birthDate: "" },
    slices: judged.suitable ? judged.slices.length / (judged.phases?.count ?? 1) : ordered.length,
    verdict: judged.suitable ? withoutSlices(judged) : judged,
    thumbnail: judged.suitable ? await middleSlice(firstPhase(judged), pieces) : null,
    upload: planOf(judged.suitable ? uploadParts(ordered) : []),
    fingerprint: fingerprint(ordered),
  };
}

/**
 * Returns the verdict without the headers, which the page does not need. Copying thousands of them
 * is slow.
 */
const withoutSlices = ({ phases, size, sizeMm, leftOut, repairs }: Chosen): Suitable => ({
  suitable: true,
  phases,
  size,
  sizeMm,
  leftOut,
  repairs,
});

const firstPhase = ({ slices, phases }: Chosen): readonly SliceHeader[] =>
  slices.slice(0, slices.length / (phases?.count ?? 1));

async function middleSlice(ordered: readonly SliceHeader[], pieces: readonly Piece[]): Promise<Thumbnail | null> {
  const slice = ordered[Math.floor(ordered.length / 2)];
  const piece = slice && pieces[slice.file];
  if (!slice?.pixels || !piece) return null;
  try {
    const { offset, length } = slice.pixels;
    const file = slice.inflated ?? (await wholeOf(piece));
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
