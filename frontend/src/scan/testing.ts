/** DICOM files by hand, for tests: explicit or implicit little endian, with or without a preamble. */

export interface MadeSlice {
  z?: number;
  position?: readonly [number, number, number] | null;
  orientation?: readonly number[] | null;
  sopUid?: string;
  seriesUid?: string;
  sopClass?: string;
  modality?: string;
  imageType?: string;
  syntax?: string;
  patientName?: string;
  patientId?: string;
  photometric?: string;
  samples?: number;
  frames?: number;
  rows?: number;
  columns?: number;
  spacing?: readonly [number, number];
  bitsStored?: number;
  isSigned?: boolean;
  pixels?: Uint8Array;
  /** What may distinguish the slice from others at its position. */
  triggerTime?: number;
  echoTime?: number;
  bValue?: number;
  /** Elements of a private group: its number, its creator, and an element of block 10 with its representation and value. */
  privately?: readonly [group: number, creator: string, element: number, vr: string, value: string | Uint8Array];
  acquisitionTime?: string;
  instance?: number;
  paddingBytes?: number; // a private element of that length before the voxels
  preamble?: "whole" | "none" | "nothing"; // nothing: not even the meta header
}

const longVrs = new Set(["OB", "OW", "SQ", "UN", "UT"]);

function element(group: number, number: number, vr: string, value: string | Uint8Array, implicit = false): Uint8Array {
  const text = typeof value === "string" ? new TextEncoder().encode(value) : value;
  const padded = new Uint8Array(text.length + (text.length % 2));
  padded.fill(vr === "UI" || text !== value ? (vr === "UI" ? 0 : 32) : 0);
  padded.set(text);
  const long = implicit || longVrs.has(vr);
  const bytes = new Uint8Array((implicit || !long ? 8 : 12) + padded.length);
  const view = new DataView(bytes.buffer);
  view.setUint16(0, group, true);
  view.setUint16(2, number, true);
  if (!implicit) {
    bytes[4] = vr.charCodeAt(0);
    bytes[5] = vr.charCodeAt(1);
  }
  if (implicit) view.setUint32(4, padded.length, true);
  else if (long) view.setUint32(8, padded.length, true);
  else view.setUint16(6, padded.length, true);
  bytes.set(padded, bytes.length - padded.length);
  return bytes;
}

const us = (value: number): Uint8Array => Uint8Array.of(value & 255, value >> 8);

export function concat(parts: readonly Uint8Array[]): Uint8Array<ArrayBuffer> {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

let counter = 0;

export function makeSlice(made: MadeSlice = {}): Uint8Array<ArrayBuffer> {
  const syntax = made.syntax ?? "1.2.840.10008.1.2.1";
  const rows = made.rows ?? 8;
  const columns = made.columns ?? 8;
  const e = (group: number, number: number, vr: string, value: string | Uint8Array) =>
    element(group, number, vr, value, syntax === "1.2.840.10008.1.2");
  const position = made.position === undefined ? [0, 0, made.z ?? 0] : made.position;
  const orientation = made.orientation === undefined ? [1, 0, 0, 0, 1, 0] : made.orientation;
  const sopClass = made.sopClass ?? "1.2.840.10008.5.1.4.1.1.2";
  const privateElements = (group: number) => {
    if (made.privately?.[0] !== group) return [];
    const [, creator, number, vr, value] = made.privately;
    return [e(group, 0x0010, "LO", creator), e(group, number, vr, value)];
  };
  const body = [
    e(0x0008, 0x0005, "CS", "ISO_IR 192"),
    e(0x0008, 0x0008, "CS", made.imageType ?? "ORIGINAL\\PRIMARY\\AXIAL"),
    e(0x0008, 0x0016, "UI", sopClass),
    e(0x0008, 0x0018, "UI", made.sopUid ?? `1.2.3.${++counter}`),
    ...(made.acquisitionTime === undefined ? [] : [e(0x0008, 0x0032, "TM", made.acquisitionTime)]),
    e(0x0008, 0x0060, "CS", made.modality ?? "CT"),
    e(0x0008, 0x103e, "LO", "Head 1.5"),
    ...(made.paddingBytes
      ? [e(0x0009, 0x0010, "LO", "PAD"), e(0x0009, 0x1001, "OB", new Uint8Array(made.paddingBytes))]
      : []),
    e(0x0010, 0x0010, "PN", made.patientName ?? "Müller^Änne"),
    e(0x0010, 0x0020, "LO", made.patientId ?? "4711"),
    e(0x0018, 0x0015, "CS", "HEAD"),
    e(0x0018, 0x0050, "DS", "99"), // a slice thickness that lies
    ...(made.echoTime === undefined ? [] : [e(0x0018, 0x0081, "DS", String(made.echoTime))]),
    ...(made.triggerTime === undefined ? [] : [e(0x0018, 0x1060, "DS", String(made.triggerTime))]),
    ...(made.bValue === undefined
      ? []
      : [e(0x0018, 0x9087, "FD", new Uint8Array(Float64Array.of(made.bValue).buffer))]),
    ...privateElements(0x0019),
    e(0x0020, 0x000d, "UI", "1.2.4"),
    e(0x0020, 0x000e, "UI", made.seriesUid ?? "1.2.5"),
    e(0x0020, 0x0011, "IS", "3"),
    ...(made.instance === undefined ? [] : [e(0x0020, 0x0013, "IS", String(made.instance))]),
    ...(position ? [e(0x0020, 0x0032, "DS", position.join("\\"))] : []),
    ...(orientation ? [e(0x0020, 0x0037, "DS", orientation.join("\\"))] : []),
    e(0x0028, 0x0002, "US", us(made.samples ?? 1)),
    e(0x0028, 0x0004, "CS", made.photometric ?? "MONOCHROME2"),
    ...(made.frames ? [e(0x0028, 0x0008, "IS", String(made.frames))] : []),
    e(0x0028, 0x0010, "US", us(rows)),
    e(0x0028, 0x0011, "US", us(columns)),
    e(0x0028, 0x0030, "DS", (made.spacing ?? [0.5, 0.5]).join("\\")),
    e(0x0028, 0x0100, "US", us(16)),
    e(0x0028, 0x0101, "US", us(made.bitsStored ?? 16)),
    e(0x0028, 0x0103, "US", us(made.isSigned === false ? 0 : 1)),
    e(0x0028, 0x1050, "DS", "40"),
    e(0x0028, 0x1051, "DS", "400"),
    e(0x0028, 0x1052, "DS", "-1024"),
    e(0x0028, 0x1053, "DS", "1"),
    ...privateElements(0x0043),
    ...privateElements(0x2001),
    e(0x7fe0, 0x0010, "OW", made.pixels ?? new Uint8Array(rows * columns * 2 * (made.frames ?? 1))),
  ];
  return made.preamble === "nothing" ? concat(body) : asFile(body, sopClass, syntax, made.preamble === "none");
}

/** Returns a file of these elements with its group 2, and with or without its preamble. */
function asFile(body: Uint8Array[], sopClass: string, syntax: string, bare: boolean): Uint8Array<ArrayBuffer> {
  const meta = [element(0x0002, 0x0002, "UI", sopClass), element(0x0002, 0x0010, "UI", syntax)];
  const length = meta.reduce((sum, part) => sum + part.length, 0);
  const lengthBytes = new Uint8Array(4);
  new DataView(lengthBytes.buffer).setUint32(0, length, true);
  const start = bare ? [] : [concat([new Uint8Array(128), new TextEncoder().encode("DICM")])];
  return concat([...start, element(0x0002, 0x0000, "UL", lengthBytes), ...meta, ...body]);
}

/** `count` slices along z, `gap` mm apart, each changed by `change`. */
export function makeSeries(count: number, gap: number, change: (i: number) => MadeSlice = () => ({})): Blob[] {
  return Array.from({ length: count }, (_, i) => new Blob([makeSlice({ z: i * gap, ...change(i) })]));
}
