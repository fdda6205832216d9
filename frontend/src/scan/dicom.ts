import dicomParser, { type DataSet } from "dicom-parser";
import type { ArchiveFormat } from "./archives";
import type { ImageHeader } from "./image/header";
import { bigEndian, implicitLittle, keptElement, wantedTags } from "./clean_file";
import { bytesOf, framesOf } from "./frames";
import type { SliceHeader } from "./types";
import { bValueElement, bValueTag, privateBValue } from "./private_b_value";

/** Reads the headers of DICOM files with dicom-parser. */

export type HeaderRead =
  | { readonly kind: "headers"; readonly headers: readonly SliceHeader[] } // one header per frame of an enhanced file
  | { readonly kind: "more" } // the header continues after these bytes
  | { readonly kind: "not_dicom" }
  | { readonly kind: "directory" } // the list of contents of a disc
  | { readonly kind: "archive"; readonly format: ArchiveFormat }
  | { readonly kind: "image"; readonly header: ImageHeader }
  | { readonly kind: "unreadable" };

const explicitLittle = "1.2.840.10008.1.2.1";
const deflatedLittle = "1.2.840.10008.1.2.1.99";
const pixelData = "x7fe00010";
const mediaDirectory = "1.2.840.10008.1.3.10";
const lossySyntaxes = new Set(["50", "51", "81", "91"].map((leaf) => `1.2.840.10008.1.2.4.${leaf}`));

/**
 * Reads a header from the first bytes of a file, up to the voxels. A deflated file must be inflated completely first.
 */
export function readHeader(bytes: Uint8Array, file: number, fileBytes: number): HeaderRead {
  const form = guessForm(bytes);
  if (!form) return { kind: "not_dicom" };
  const complete = bytes.length >= fileBytes;
  renameLongOffsets(form.bytes);
  let data: DataSet;
  let cutOff = false;
  try {
    data = dicomParser.parseDicom(form.bytes, {
      untilTag: pixelData,
      ...(form.syntax ? { TransferSyntaxUID: form.syntax } : {}),
    });
  } catch (thrown) {
    const partial = (thrown as { dataSet?: DataSet } | null)?.dataSet;
    if (partial?.string("x00020002") === mediaDirectory) return { kind: "directory" };
    if (!complete) return { kind: "more" };
    if (!partial?.elements.x0020000e) return form.isDicom ? { kind: "unreadable" } : { kind: "not_dicom" };
    cutOff = true;
    data = partial; // the file ends after the required elements: a damaged slice of a known series
  }
  if (data.string("x00020002") === mediaDirectory) return { kind: "directory" };
  if (!complete && !data.elements[pixelData]) return { kind: "more" };
  const header = headerOf(data, form, file, fileBytes, cutOff);
  if (!header) return form.isDicom ? { kind: "unreadable" } : { kind: "not_dicom" };
  return { kind: "headers", headers: framesOf(data, header) };
}

/** Returns the offset of the deflated part of a file, or null if it is not deflated. */
export function deflatedFrom(bytes: Uint8Array): number | null {
  const form = guessForm(bytes);
  if (!form || form.syntax || form.shift !== 0) return null;
  try {
    const meta = dicomParser.readPart10Header(bytes) as DataSet & { position?: number };
    return meta.string("x00020010") === deflatedLittle ? (meta.position ?? null) : null;
  } catch {
    return null;
  }
}

interface Form {
  readonly bytes: Uint8Array;
  readonly syntax?: string;
  /** The length of `bytes` minus that of the file. */
  readonly shift: number;
  /** Whether the file identifies itself as DICOM. If not, it only looks like it. */
  readonly isDicom: boolean;
}

/** Recognises files with a preamble, without one, and with nothing but data elements (case 20 of ingest). */
function guessForm(bytes: Uint8Array): Form | null {
  if (textAt(bytes, 128, 4) === "DICM") return { bytes, shift: 0, isDicom: true };
  if (bytes.length < 16) return null;
  const group = (bytes[0] ?? 0) | ((bytes[1] ?? 0) << 8);
  const explicit = /^[A-Z]{2}$/.test(textAt(bytes, 4, 2));
  if (group === 0x0002 && explicit) {
    const preamble = new Uint8Array(132);
    preamble.set([0x44, 0x49, 0x43, 0x4d], 128);
    return { bytes: joined(preamble, bytes), shift: 132, isDicom: false };
  }
  if (group === 0x0800 && explicit) return { bytes, syntax: bigEndian, shift: 0, isDicom: false };
  if (group !== 0x0008) return null;
  return { bytes, syntax: explicit ? explicitLittle : implicitLittle, shift: 0, isDicom: false };
}

/**
 * Renames the value representation OV of the Extended Offset Table, which the parser does not know
 * and would misread, to OB, which has the same layout.
 */
function renameLongOffsets(bytes: Uint8Array): void {
  for (let at = bytes.indexOf(0xe0); at >= 0; at = bytes.indexOf(0xe0, at + 1)) {
    const [, high, low, zero, o, v] = bytes.subarray(at, at + 6);
    if (high === 0x7f && (low === 1 || low === 2) && zero === 0 && o === 0x4f && v === 0x56) bytes[at + 5] = 0x42;
  }
}

function headerOf(data: DataSet, form: Form, file: number, fileBytes: number, cutOff: boolean): SliceHeader | null {
  const string = (tag: string) => data.string(tag) ?? "";
  const seriesUid = string("x0020000e");
  const sopClass = string("x00080016");
  if (!seriesUid || !sopClass) return null;
  const text = textReader(data);
  const transferSyntax = form.syntax ?? string("x00020010");
  const format = pixelFormatOf(data);
  const voxels = voxelsOf(data, form, transferSyntax, format, fileBytes);
  return {
    file,
    frame: 0,
    stack: "",
    fileBytes,
    sopClass,
    sopUid: string("x00080018"),
    studyUid: string("x0020000d"),
    seriesUid,
    transferSyntax,
    modality: string("x00080060"),
    imageType: string("x00080008")
      .split("\\")
      .map((part) => part.trim().toUpperCase()),
    isLossy: string("x00282110").trim() === "01" || lossySyntaxes.has(transferSyntax),
    patient: {
      name: text("x00100010").split("=")[0]?.replaceAll("^", " ").replace(/\s+/g, " ").trim() ?? "",
      id: text("x00100020"),
      birthDate: string("x00100030"),
    },
    seriesNumber: finite(data.intString("x00200011")),
    description: text("x0008103e"),
    bodyPart: string("x00180015"),
    date: string("x00080021") || string("x00080020"),
    ...format,
    ...valuesOf(data),
    pixelSpacing: numbers(data, "x00280030", 2) as [number, number] | null,
    position: numbers(data, "x00200032", 3) as [number, number, number] | null,
    orientation: numbers(data, "x00200037", 6) as SliceHeader["orientation"],
    pixels: voxels.pixels,
    voxels: voxels.voxels,
    ...distinguishing(data, transferSyntax),
    grouped: [],
    inflated: null,
    truncated: cutOff || voxels.truncated,
  };
}

/** Reads the elements to send, and what may distinguish slices. A private b-value is sent as the standard element. */
function distinguishing(data: DataSet, transferSyntax: string): Pick<SliceHeader, "moment" | "kept"> {
  const [standard = null, ...others] = momentOf(data);
  const own = standard === null ? privateBValue(data) : null;
  const kept = keptElements(data).filter(({ tag }) => own === null || tag !== bValueTag);
  return {
    moment: [standard ?? own, ...others],
    kept: own === null ? kept : [...kept, bValueElement(own, transferSyntax)],
  };
}

/** Reads what may distinguish slices at the same position (phases.ts), of which times of day are never sent. */
function momentOf(data: DataSet): SliceHeader["moment"] {
  const number = (tag: string) => finite(data.floatString(tag));
  // The length is checked first, because reading beyond the value throws.
  const double = (tag: string) => (data.elements[tag]?.length === 8 ? finite(data.double(tag)) : null);
  const count = data.elements.x00209128?.length === 4 ? finite(data.uint32("x00209128")) : null;
  const offset = double("x0020930d");
  return [
    double("x00189087"),
    number("x00180081") ?? double("x00189082"),
    data.elements.x00209241?.length === 4 ? finite(data.float("x00209241")) : null,
    number("x00181060") ?? double("x00209153"),
    offset === null ? null : 1000 * offset,
    number("x00200100") ?? count,
    null,
    number("x00080032"),
    number("x00080033"),
    number("x00200013"),
  ];
}

type PixelFormat = Pick<
  SliceHeader,
  | "rows"
  | "columns"
  | "frames"
  | "samples"
  | "photometric"
  | "bitsAllocated"
  | "bitsStored"
  | "isSigned"
  | "hasLookupTable"
>;

function pixelFormatOf(data: DataSet): PixelFormat {
  const bitsAllocated = data.uint16("x00280100") ?? 16;
  return {
    rows: data.uint16("x00280010") ?? 0,
    columns: data.uint16("x00280011") ?? 0,
    frames: Math.max(1, data.intString("x00280008") ?? 1),
    samples: data.uint16("x00280002") ?? 1,
    photometric: (data.string("x00280004") ?? "").toUpperCase(),
    bitsAllocated,
    bitsStored: data.uint16("x00280101") ?? bitsAllocated,
    isSigned: data.uint16("x00280103") === 1,
    hasLookupTable: data.elements.x00283000 !== undefined,
  };
}

/** Reads how stored values convert to values of the modality, and the window in which to show them. */
function valuesOf(data: DataSet): Pick<SliceHeader, "hasScale" | "slope" | "intercept" | "window"> {
  const center = data.floatString("x00281050");
  const width = data.floatString("x00281051");
  return {
    hasScale: data.elements.x00281053 !== undefined && data.elements.x00281052 !== undefined,
    slope: finite(data.floatString("x00281053")) ?? 1,
    intercept: finite(data.floatString("x00281052")) ?? 0,
    window: finite(center) !== null && width !== undefined && width > 0 ? { center: center ?? 0, width } : null,
  };
}

type Voxels = Pick<SliceHeader, "pixels" | "voxels" | "truncated">;

/** Finds the voxels in the file, and whether the file ends before they do. */
function voxelsOf(data: DataSet, form: Form, syntax: string, format: PixelFormat, fileBytes: number): Voxels {
  const element = data.elements[pixelData];
  if (!element) return { pixels: null, voxels: null, truncated: false };
  const { rows, columns, frames, samples, bitsAllocated } = format;
  const native = [explicitLittle, implicitLittle, bigEndian].includes(syntax);
  const pixelBytes = (rows * columns * frames * samples * bitsAllocated) / 8;
  const offset = element.dataOffset - form.shift;
  return {
    pixels: native && syntax !== bigEndian ? { offset, length: pixelBytes } : null,
    // read_file.ts finds the end of compressed voxels from their fragments.
    voxels: {
      from: offset,
      to: native ? offset + pixelBytes + (pixelBytes % 2) : fileBytes,
      vr: element.vr === "OB" ? "OB" : "OW",
      encapsulated: !native,
    },
    truncated: native && (element.length < pixelBytes || offset + pixelBytes > fileBytes),
  };
}

const keptElements = (data: DataSet): SliceHeader["kept"] =>
  wantedTags.flatMap((tag) => {
    const found = data.elements[tag];
    const bytes = found && bytesOf(data).subarray(found.dataOffset, found.dataOffset + found.length);
    return (bytes && keptElement(tag, found.vr ?? "", bytes)) ?? [];
  });

function numbers(data: DataSet, tag: string, count: number): number[] | null {
  const values = (data.string(tag) ?? "").split("\\").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  return values.length === count && values.every(Number.isFinite) ? values : null;
}

const finite = (value: number | undefined): number | null =>
  value !== undefined && Number.isFinite(value) ? value : null;

/**
 * The character sets of DICOM PS3.3 C.12.1.1.2 that browsers can decode. If there are several, the last one is the most
 * comprehensive.
 */
const characterSets: Readonly<Record<string, string>> = {
  "ISO_IR 100": "windows-1252",
  "ISO_IR 101": "iso-8859-2",
  "ISO_IR 109": "iso-8859-3",
  "ISO_IR 110": "iso-8859-4",
  "ISO_IR 144": "iso-8859-5",
  "ISO_IR 127": "iso-8859-6",
  "ISO_IR 126": "iso-8859-7",
  "ISO_IR 138": "iso-8859-8",
  "ISO_IR 148": "windows-1254",
  "ISO_IR 203": "iso-8859-15",
  "ISO_IR 166": "windows-874",
  "ISO_IR 13": "shift_jis",
  "ISO 2022 IR 100": "windows-1252",
  "ISO 2022 IR 87": "iso-2022-jp",
  "ISO 2022 IR 149": "euc-kr",
  "ISO_IR 192": "utf-8",
  GB18030: "gb18030",
  GBK: "gbk",
};

const decoders = new Map<string, TextDecoder>();

function textReader(data: DataSet): (tag: string) => string {
  const names = (data.string("x00080005") ?? "").split("\\").map((name) => name.trim());
  const label = names.map((name) => characterSets[name]).findLast((found) => found !== undefined) ?? "windows-1252";
  const decoder = decoders.get(label) ?? new TextDecoder(label);
  decoders.set(label, decoder);
  return (tag) => {
    const element = data.elements[tag];
    if (!element) return "";
    const bytes = bytesOf(data).subarray(element.dataOffset, element.dataOffset + element.length);
    return decoder.decode(bytes).replaceAll("\0", "").trim();
  };
}

const textAt = (bytes: Uint8Array, offset: number, count: number): string =>
  String.fromCharCode(...bytes.subarray(offset, offset + count));

function joined(a: Uint8Array, b: Uint8Array): Uint8Array {
  const all = new Uint8Array(a.length + b.length);
  all.set(a);
  all.set(b, a.length);
  return all;
}
