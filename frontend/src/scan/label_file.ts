import dicomParser, { type DataSet, type Element } from "dicom-parser";
import { readAtMost } from "../streams";
import { disguisedUid } from "./disguised_uid";
import { canonicalHeader } from "./image/canonical";
import { voxelBytes, type VoxelType, type ImageHeader } from "./image/header";
import { readNifti } from "./image/nifti";
import { inChunks } from "./piece";

/** Files of labels: NIfTI label volumes, DICOM segmentations (SEG) and structure sets (RTSTRUCT). */

export type LabelFault = "unknown" | "damaged" | "too_large";

/** Thrown if a file is not sent. */
export class LabelFileError extends Error {
  constructor(readonly fault: LabelFault) {
    super(fault);
  }
}

/** Maximum size that the server accepts (docs/bounds.toml). */
const mostBytes = 2 ** 30;

/**
 * Returns what is uploaded of a file of labels, compressed: the voxels or outlines, and the names,
 * numbers and colours of the structures. Everything else stays in the browser, because it may name
 * the patient. Throws LabelFileError.
 */
export async function cleanLabelFile(file: Blob): Promise<Blob> {
  const bytes = await unpacked(file);
  const parts = niftiParts(bytes) ?? dicomParts(bytes);
  // Chunks of the same sizes give the same bytes each time, so that an upload can be resumed.
  const whole = new Uint8Array(await new Blob(parts).arrayBuffer());
  return new Response(inChunks(whole).pipeThrough(new CompressionStream("gzip"))).blob();
}

async function unpacked(file: Blob): Promise<Uint8Array<ArrayBuffer>> {
  if (file.size > mostBytes) throw new LabelFileError("too_large");
  const [first, second] = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (first !== 0x1f || second !== 0x8b) return new Uint8Array(await file.arrayBuffer());
  const { bytes, end } = await readAtMost(file.stream().pipeThrough(new DecompressionStream("gzip")), mostBytes);
  if (end !== "whole") throw new LabelFileError(end === "more" ? "too_large" : "damaged");
  return bytes;
}

const isTyped = (header: ImageHeader): header is ImageHeader & { readonly type: VoxelType } => header.type !== null;

function niftiParts(bytes: Uint8Array<ArrayBuffer>): BlobPart[] | null {
  const header = readNifti(bytes);
  if (header === null) return null;
  if (header === "more") throw new LabelFileError("damaged");
  // A header without its voxels, colours, or several volumes cannot be the labels of one scan.
  if (header.begin === null || header.values > 1 || header.volumes > 1 || !isTyped(header))
    throw new LabelFileError("unknown");
  const voxels = bytes.subarray(header.begin, header.begin + voxelBytes(header));
  if (!(voxels.length > 0) || voxels.length < voxelBytes(header)) throw new LabelFileError("damaged");
  return [canonicalHeader(header), voxels];
}

/** The SOP classes of segmentations and structure sets. */
const labelClasses: readonly string[] = ["1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.481.3"];
const implicitLittle = "1.2.840.10008.1.2";
const explicitLittle = "1.2.840.10008.1.2.1";

/**
 * Elements that are sent, at any depth. The only free text among them is the names of structures.
 */
const keptTags = new Set([
  "x00080016", // SOPClassUID
  "x00180050", // SliceThickness
  "x00180088", // SpacingBetweenSlices
  "x00200032",
  "x00200037",
  "x00209113", // plane positions and orientations of frames
  "x00209116",
  "x00280002",
  "x00280008",
  "x00280010",
  "x00280011",
  "x00280030",
  "x00280100",
  "x00280101",
  "x00280102",
  "x00280103",
  "x00289110", // pixel measures
  "x00620001", // SegmentationType
  "x00620002", // segments, with number, label and colour
  "x00620004",
  "x00620005",
  "x0062000a", // which segment a frame belongs to
  "x0062000b",
  "x0062000d",
  "x0062000e", // MaximumFractionalValue
  "x30060010", // frames of reference of a structure set
  "x30060020", // structures, with number and name
  "x30060022",
  "x30060026",
  "x30060039", // contours, with colour
  "x3006002a",
  "x30060040",
  "x30060042",
  "x30060046",
  "x30060050",
  "x30060084",
  "x52009229",
  "x52009230",
  "x7fe00010",
]);
/** Frames of reference, which are disguised. */
const frameTags = new Set(["x00200052", "x30060024"]);
/** The character set of the names of structures. */
const characterSet = "x00080005";

function dicomParts(bytes: Uint8Array<ArrayBuffer>): BlobPart[] {
  let data: DataSet;
  try {
    data = dicomParser.parseDicom(bytes);
  } catch {
    throw new LabelFileError("unknown");
  }
  const syntax = data.string("x00020010");
  const sopClass = data.string("x00080016") ?? "";
  if (!labelClasses.includes(sopClass) || (syntax !== implicitLittle && syntax !== explicitLittle))
    throw new LabelFileError("unknown");
  return [...fileHead(sopClass), ...elementsOf(data)];
}

/** Returns the preamble and the file meta information (group 2), always in explicit VR. */
function fileHead(sopClass: string): Uint8Array<ArrayBuffer>[] {
  const preamble = new Uint8Array(132);
  preamble.set([0x44, 0x49, 0x43, 0x4d], 128);
  const meta = [
    explicitUid(0x0002, sopClass),
    explicitUid(0x0003, "2.25.1001"),
    explicitUid(0x0010, implicitLittle),
    explicitUid(0x0012, "2.25.3"),
  ];
  const length = new Uint8Array(12);
  const view = new DataView(length.buffer);
  view.setUint16(0, 2, true);
  length.set([0x55, 0x4c], 4); // UL
  view.setUint16(6, 4, true);
  view.setUint32(8, lengthOf(meta), true);
  return [preamble, length, ...meta];
}

function explicitUid(element: number, uid: string): Uint8Array<ArrayBuffer> {
  const value = uidBytes(uid);
  const bytes = new Uint8Array(8 + value.length);
  const view = new DataView(bytes.buffer);
  view.setUint16(0, 2, true);
  view.setUint16(2, element, true);
  bytes.set([0x55, 0x49], 4); // UI
  view.setUint16(6, value.length, true);
  bytes.set(value, 8);
  return bytes;
}

function uidBytes(uid: string): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(uid.length + (uid.length % 2));
  for (let i = 0; i < uid.length; i++) bytes[i] = uid.charCodeAt(i);
  return bytes;
}

const lengthOf = (parts: readonly Uint8Array[]): number => parts.reduce((sum, part) => sum + part.length, 0);

/** Returns the kept elements of a data set in implicit little endian, which needs no types. */
function elementsOf(data: DataSet): Uint8Array<ArrayBuffer>[] {
  return Object.keys(data.elements)
    .sort()
    .flatMap((tag) => {
      const element = data.elements[tag];
      return element ? elementOf(data, tag, element) : [];
    });
}

function elementOf(data: DataSet, tag: string, element: Element): Uint8Array<ArrayBuffer>[] {
  if (frameTags.has(tag)) return implicit(tag, [uidBytes(disguisedUid(data.string(tag) ?? ""))]);
  if (!keptTags.has(tag) && tag !== characterSet) return [];
  if (element.items)
    return implicit(
      tag,
      element.items.flatMap((item) => implicit("xfffee000", item.dataSet ? elementsOf(item.dataSet) : [])),
    );
  const bytes = data.byteArray as Uint8Array<ArrayBuffer>;
  return implicit(tag, [bytes.subarray(element.dataOffset, element.dataOffset + element.length)]);
}

function implicit(tag: string, value: readonly Uint8Array<ArrayBuffer>[]): Uint8Array<ArrayBuffer>[] {
  const head = new Uint8Array(8);
  const view = new DataView(head.buffer);
  view.setUint16(0, Number.parseInt(tag.slice(1, 5), 16), true);
  view.setUint16(2, Number.parseInt(tag.slice(5), 16), true);
  view.setUint32(4, lengthOf(value), true);
  return [head, ...value];
}
