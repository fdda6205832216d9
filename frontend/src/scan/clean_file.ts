import { sha256 } from "@noble/hashes/sha2.js";
import { disguisedUid } from "./disguised_uid";
import type { GroupedElement, KeptElement, SliceHeader, UploadPart } from "./types";

/**
 * The upload of a slice: its voxels and a new header with only what a volume needs, so that names,
 * dates, ID numbers, comments and private elements never leave the browser. This is an allow-list:
 * an element that it does not name is not sent.
 */

/**
 * The elements that may be sent, by the form of their values: numbers, UIDs and coded words, but no
 * free text.
 */
const keptTags: Readonly<
  Record<
    string,
    | "number"
    | "us"
    | "image_type"
    | "modality"
    | "class"
    | "photometric"
    | "rescale_type"
    | "lossy"
    | "offsets"
    | "count"
    | "float"
    | "frame"
  >
> = {
  x00080008: "image_type",
  x00080016: "class",
  x00080060: "modality",
  x00180050: "number",
  x00180081: "number",
  x00180086: "number",
  x00181060: "number",
  x00189082: "number",
  x00189087: "number",
  x00200012: "number",
  x00200013: "number",
  x00200032: "number",
  x00200037: "number",
  x00200052: "frame",
  x00200100: "number",
  x00209128: "count",
  x00209153: "number",
  x00209241: "float",
  x0020930d: "number",
  x00280002: "us",
  x00280004: "photometric",
  x00280006: "us",
  x00280008: "number",
  x00280010: "us",
  x00280011: "us",
  x00280030: "number",
  x00280034: "number",
  x00280100: "us",
  x00280101: "us",
  x00280102: "us",
  x00280103: "us",
  x00280106: "us",
  x00280107: "us",
  x00280120: "us",
  x00280121: "us",
  x00282110: "lossy",
  x00281050: "number",
  x00281051: "number",
  x00281052: "number",
  x00281053: "number",
  x00281054: "rescale_type",
  x7fe00001: "offsets",
};

export const wantedTags: readonly string[] = Object.keys(keptTags);

const imageWords = new Set([
  "ORIGINAL",
  "DERIVED",
  "MIXED",
  "PRIMARY",
  "SECONDARY",
  "AXIAL",
  "LOCALIZER",
  "REFORMATTED",
  "MPR",
  "AVERAGE",
  "RESAMPLED",
  "VOLUME",
  "HELIX",
  "NORM",
  "M",
  "P",
  "R",
  "I",
  "ND",
  "NONE",
  "DIFFUSION",
  "ADC",
  "TRACEW",
  "FFE",
  "SE",
  "M_FFE",
  "M_SE",
  "STATIC",
]);

/** Returns the element as it may be sent, or null if its value does not have the expected form. */
export function keptElement(tag: string, vr: string, bytes: Uint8Array): KeptElement | null {
  const kind = keptTags[tag];
  if (kind === undefined) return null;
  const plain = () => new Uint8Array(bytes);
  if (kind === "us") return bytes.length === 2 ? { tag, vr: vr === "SS" ? "SS" : "US", bytes: plain() } : null;
  const text = String.fromCharCode(...bytes).replace(/[\0 ]+$/, "");
  switch (kind) {
    case "number":
      if (doubleTags.has(tag)) return bytes.length === 8 ? { tag, vr: "FD", bytes: plain() } : null;
      if (vr === "FD" || vr === "FL") return { tag, vr, bytes: plain() };
      return /^[-+0-9.eE \\]*$/.test(text) ? { tag, vr: numberVr(tag), bytes: plain() } : null;
    case "image_type": {
      const words = text.split("\\").map((word) => word.trim().toUpperCase());
      return coded(tag, "CS", words.map((word) => (imageWords.has(word) ? word : "OTHER")).join("\\"));
    }
    case "modality":
      return /^(CT|MR|PT)$/.test(text) ? coded(tag, "CS", text) : null;
    case "photometric":
      return /^MONOCHROME[12]$/.test(text) ? coded(tag, "CS", text) : null;
    case "rescale_type":
      return /^(HU|US|BQML|SUV)$/.test(text) ? coded(tag, "LO", text) : null;
    case "float":
      return bytes.length === 4 ? { tag, vr: "FL", bytes: plain() } : null;
    case "count":
      return bytes.length === 4 ? { tag, vr: "UL", bytes: plain() } : null;
    case "offsets":
      return bytes.length % 8 === 0 ? { tag, vr: "OV", bytes: plain() } : null;
    case "lossy":
      return /^0[01]$/.test(text) ? coded(tag, "CS", text) : null;
    case "frame":
      return /^[0-9.]{1,64}$/.test(text) ? coded(tag, "UI", disguisedUid(text)) : null;
    case "class":
      return /^[0-9.]{1,64}$/.test(text) ? coded(tag, "UI", text) : null;
  }
}

/** Tags with one binary number (FD), whose representation implicit files do not state. */
const doubleTags = new Set(["x00189082", "x00189087", "x00209153", "x0020930d"]);
/** Tags with integer strings (IS). All other numbers here are decimal strings (DS). */
const integerTags = new Set(["x00180086", "x00200012", "x00200013", "x00200100", "x00280008", "x00280034"]);
const numberVr = (tag: string) => (integerTags.has(tag) ? "IS" : "DS");

function coded(tag: string, vr: string, text: string): KeptElement {
  const bytes = new Uint8Array(text.length + (text.length % 2)).fill(vr === "UI" ? 0 : 32);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return { tag, vr, bytes };
}

/** The elements of each functional group of an enhanced file that may be sent. */
export const groupedTags: Readonly<Record<string, readonly string[]>> = {
  x00189114: ["x00189082"],
  x00189117: ["x00189087"],
  x00189118: ["x00209153", "x00209241"],
  x00209111: ["x00209056", "x00209128"],
  x00209113: ["x00200032"],
  x00209116: ["x00200037"],
  x00209310: ["x0020930d"],
  x00289110: ["x00280030"],
  x00289132: ["x00281050", "x00281051"],
  x00289145: ["x00281052", "x00281053"],
  x00189226: ["x00089007"],
  x00189329: ["x00089007"],
  x00189751: ["x00089007"],
};

/**
 * Replaces the name of a stack, which can be any text, by a short hash. Equal names stay equal, and
 * different names stay different, because the frames of two stacks must not be merged.
 */
const disguised = (name: string): string =>
  Array.from(sha256(new TextEncoder().encode(name)).subarray(0, 4), (byte) => byte.toString(16).padStart(2, "0")).join(
    "",
  );

export function groupedElement(group: string, tag: string, bytes: Uint8Array): GroupedElement | null {
  if (tag === "x00209056") return { ...coded(tag, "SH", disguised(String.fromCharCode(...bytes).trim())), group };
  const kept = tag === "x00089007" ? keptElement("x00080008", "CS", bytes) : keptElement(tag, "DS", bytes);
  return kept && { ...kept, tag, group };
}

export const bigEndian = "1.2.840.10008.1.2.2";
export const implicitLittle = "1.2.840.10008.1.2";

/** Returns the slice with TemporalPositionIdentifier, or TemporalPositionIndex in an enhanced file. */
export function withTemporalPosition(slice: SliceHeader, position: number): SliceHeader {
  if (slice.stack === "") {
    const tag = "x00200100";
    return { ...slice, kept: [...slice.kept.filter((one) => one.tag !== tag), coded(tag, "IS", String(position))] };
  }
  const tag = "x00209128";
  const bytes = new Uint8Array(4);
  new DataView(bytes.buffer).setUint32(0, position, slice.transferSyntax !== bigEndian);
  const own = { tag, vr: "UL", bytes, group: "x00209111" };
  return { ...slice, grouped: [...slice.grouped.filter((one) => one.tag !== tag), own] };
}

/** Returns the parts to upload for the chosen slices, one per file, in the order of each file's first slice. */
export function uploadParts(slices: readonly SliceHeader[]): UploadPart[] {
  const files = new Map<number, SliceHeader[]>();
  for (const slice of slices) {
    const others = files.get(slice.file);
    if (others) others.push(slice);
    else files.set(slice.file, [slice]);
  }
  return [...files.values()].flatMap((ofFile, i) => uploadPart(ofFile, i + 1) ?? []);
}

/**
 * Returns the upload of one file. `number` is its position in the bundle, from 1, which replaces
 * the identifiers.
 */
function uploadPart(slices: readonly SliceHeader[], number: number): UploadPart | null {
  const slice = slices[0];
  const voxels = slice?.voxels;
  if (!slice || !voxels) return null;
  const own = `2.25.${1000 + number}`;
  const meta = [
    element(coded("x00020002", "UI", slice.sopClass)),
    element(coded("x00020003", "UI", own)),
    element(coded("x00020010", "UI", slice.transferSyntax)),
    element(coded("x00020012", "UI", "2.25.3")),
  ];
  const metaLength = new Uint8Array(4);
  new DataView(metaLength.buffer).setUint32(
    0,
    meta.reduce((sum, part) => sum + part.length, 0),
    true,
  );
  const implicit = slice.transferSyntax === implicitLittle;
  const little = slice.transferSyntax !== bigEndian;
  const body = [
    ...slice.kept,
    coded("x00080018", "UI", own),
    coded("x0020000d", "UI", "2.25.1"),
    coded("x0020000e", "UI", "2.25.2"),
  ].sort((a, b) => (a.tag < b.tag ? -1 : 1));
  const preamble = new Uint8Array(132);
  preamble.set([0x44, 0x49, 0x43, 0x4d], 128);
  const length = voxels.encapsulated ? 0xffffffff : voxels.to - voxels.from;
  const head = joined([
    preamble,
    element({ tag: "x00020000", vr: "UL", bytes: metaLength }),
    ...meta,
    ...body.filter(({ tag }) => tag < frameGroupsTag).map((one) => element(one, implicit, little)),
    ...(slice.stack === "" ? [] : [frameGroups(slices, implicit, little)]),
    ...body.filter(({ tag }) => tag > frameGroupsTag).map((one) => element(one, implicit, little)),
    element({ tag: "x7fe00010", vr: voxels.vr, bytes: new Uint8Array() }, implicit, little, length),
  ]);
  return { file: slice.file, head, from: voxels.from, to: voxels.to, inflated: slice.inflated };
}

const frameGroupsTag = "x52009230";

/**
 * Returns PerFrameFunctionalGroupsSequence. The items of frames that were not chosen are empty, and
 * the server skips these frames.
 */
function frameGroups(slices: readonly SliceHeader[], implicit: boolean, little: boolean): Uint8Array {
  const chosen = new Map(slices.map((slice) => [slice.frame, slice]));
  const frames = Number(textOf(slices[0]?.kept.find(({ tag }) => tag === "x00280008")) || 1);
  const sequence = (tag: string, items: readonly Uint8Array[]) =>
    element(
      {
        tag,
        vr: "SQ",
        bytes: joined(items.map((item) => element({ tag: "xfffee000", vr: "", bytes: item }, true, little))),
      },
      implicit,
      little,
    );
  return sequence(
    frameGroupsTag,
    Array.from({ length: frames }, (_, frame) => {
      const said = chosen.get(frame)?.grouped ?? [];
      const groups = [...new Set(said.map(({ group }) => group))].sort();
      return joined(
        groups.map((group) => {
          const last = new Map(said.filter((one) => one.group === group).map((one) => [one.tag, one])); // the frame's own item comes last and wins
          const inner = [...last.values()].sort((a, b) => (a.tag < b.tag ? -1 : 1));
          return sequence(group, [joined(inner.map((one) => element(one, implicit, little)))]);
        }),
      );
    }),
  );
}

const textOf = (kept: KeptElement | undefined): string => (kept ? String.fromCharCode(...kept.bytes).trim() : "");

const longForm = new Set(["OB", "OV", "OW", "UN", "SQ"]);

function element({ tag, vr, bytes }: KeptElement, implicit = false, little = true, length = bytes.length): Uint8Array {
  const long = implicit || longForm.has(vr);
  const start = implicit || !long ? 8 : 12;
  const all = new Uint8Array(start + bytes.length);
  const view = new DataView(all.buffer);
  view.setUint16(0, Number.parseInt(tag.slice(1, 5), 16), little);
  view.setUint16(2, Number.parseInt(tag.slice(5), 16), little);
  if (!implicit) {
    all[4] = vr.charCodeAt(0);
    all[5] = vr.charCodeAt(1);
  }
  if (implicit) view.setUint32(4, length, little);
  else if (long) view.setUint32(8, length, little);
  else view.setUint16(6, length, little);
  all.set(bytes, start);
  return all;
}

function joined(parts: readonly Uint8Array[]): Uint8Array<ArrayBuffer> {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}
