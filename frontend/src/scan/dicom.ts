import dicomParser, { type DataSet } from "dicom-parser";
import { kept_element, wanted_tags } from "./clean_file";
import { bytes_of, frames_of } from "./frames";
import type { SliceHeader } from "./types";

/** The only place that knows dicom-parser. */

export type HeaderRead =
  | { readonly kind: "headers"; readonly headers: readonly SliceHeader[] } // of an enhanced file one a frame
  | { readonly kind: "more" } // the header goes on behind these bytes
  | { readonly kind: "not_dicom" }
  | { readonly kind: "unreadable" };

const explicit_little = "1.2.840.10008.1.2.1";
const implicit_little = "1.2.840.10008.1.2";
const big_endian = "1.2.840.10008.1.2.2";
const deflated_little = "1.2.840.10008.1.2.1.99";
const pixel_data = "x7fe00010";
const lossy_syntaxes = new Set(["50", "51", "81", "91"].map((leaf) => `1.2.840.10008.1.2.4.${leaf}`));

/** Reads a header from the first bytes of a file, up to the voxels; of a deflated file, from all that it unpacks to. */
export function read_header(bytes: Uint8Array, file: number, file_bytes: number): HeaderRead {
  const form = guess_form(bytes);
  if (!form) return { kind: "not_dicom" };
  const complete = bytes.length >= file_bytes;
  rename_long_offsets(form.bytes);
  let data: DataSet;
  let cut_off = false;
  try {
    data = dicomParser.parseDicom(form.bytes, {
      untilTag: pixel_data,
      ...(form.syntax ? { TransferSyntaxUID: form.syntax } : {}),
    });
  } catch (thrown) {
    if (!complete) return { kind: "more" };
    const partial = (thrown as { dataSet?: DataSet } | null)?.dataSet;
    if (!partial?.elements.x0020000e) return form.sure ? { kind: "unreadable" } : { kind: "not_dicom" };
    cut_off = true;
    data = partial; // cut off behind what is needed: a damaged slice of a known series
  }
  if (!complete && !data.elements[pixel_data]) return { kind: "more" };
  const header = header_of(data, form, file, file_bytes, cut_off);
  if (!header) return form.sure ? { kind: "unreadable" } : { kind: "not_dicom" };
  return { kind: "headers", headers: frames_of(data, header) };
}

/** Where the deflated part of a file begins; nothing when it is not deflated. */
export function deflated_from(bytes: Uint8Array): number | null {
  const form = guess_form(bytes);
  if (!form || form.syntax || form.shift !== 0) return null;
  try {
    const meta = dicomParser.readPart10Header(bytes) as DataSet & { position?: number };
    return meta.string("x00020010") === deflated_little ? (meta.position ?? null) : null;
  } catch {
    return null;
  }
}

interface Form {
  readonly bytes: Uint8Array;
  readonly syntax?: string;
  /** How much longer `bytes` is than the file. */
  readonly shift: number;
  /** It says that it is DICOM; otherwise it only looks so. */
  readonly sure: boolean;
}

/** With preamble; without; without anything but the data elements (case 20 of ingest). */
function guess_form(bytes: Uint8Array): Form | null {
  if (text_at(bytes, 128, 4) === "DICM") return { bytes, shift: 0, sure: true };
  if (bytes.length < 16) return null;
  const group = (bytes[0] ?? 0) | ((bytes[1] ?? 0) << 8);
  const explicit = /^[A-Z]{2}$/.test(text_at(bytes, 4, 2));
  if (group === 0x0002 && explicit) {
    const preamble = new Uint8Array(132);
    preamble.set([0x44, 0x49, 0x43, 0x4d], 128);
    return { bytes: joined(preamble, bytes), shift: 132, sure: false };
  }
  if (group === 0x0800 && explicit) return { bytes, syntax: big_endian, shift: 0, sure: false };
  if (group !== 0x0008) return null;
  return { bytes, syntax: explicit ? explicit_little : implicit_little, shift: 0, sure: false };
}

/** The parser does not know the representation OV of the Extended Offset Table and its lengths, and would lose its place: OB is laid out alike. */
function rename_long_offsets(bytes: Uint8Array): void {
  for (let at = bytes.indexOf(0xe0); at >= 0; at = bytes.indexOf(0xe0, at + 1)) {
    const [, high, low, zero, o, v] = bytes.subarray(at, at + 6);
    if (high === 0x7f && (low === 1 || low === 2) && zero === 0 && o === 0x4f && v === 0x56) bytes[at + 5] = 0x42;
  }
}

function header_of(data: DataSet, form: Form, file: number, file_bytes: number, cut_off: boolean): SliceHeader | null {
  const string = (tag: string) => data.string(tag) ?? "";
  const series_uid = string("x0020000e");
  const sop_class = string("x00080016");
  if (!series_uid || !sop_class) return null;
  const text = text_reader(data);
  const syntax = form.syntax ?? string("x00020010");
  const rows = data.uint16("x00280010") ?? 0;
  const columns = data.uint16("x00280011") ?? 0;
  const samples = data.uint16("x00280002") ?? 1;
  const bits_allocated = data.uint16("x00280100") ?? 16;
  const frames = Math.max(1, data.intString("x00280008") ?? 1);
  const center = data.floatString("x00281050");
  const width = data.floatString("x00281051");
  const element = data.elements[pixel_data];
  const native = [explicit_little, implicit_little, big_endian].includes(syntax) && element !== undefined;
  const wanted = (rows * columns * frames * samples * bits_allocated) / 8;
  const offset = element ? element.dataOffset - form.shift : 0;
  return {
    file,
    frame: 0,
    stack: "",
    file_bytes,
    sop_class,
    sop_uid: string("x00080018"),
    study_uid: string("x0020000d"),
    series_uid,
    transfer_syntax: syntax,
    modality: string("x00080060"),
    image_type: string("x00080008").split("\\").map((part) => part.trim().toUpperCase()),
    is_lossy: string("x00282110").trim() === "01" || lossy_syntaxes.has(syntax),
    patient: {
      name: text("x00100010").split("=")[0]?.replaceAll("^", " ").replace(/\s+/g, " ").trim() ?? "",
      id: text("x00100020"),
      birth_date: string("x00100030"),
    },
    series_number: finite(data.intString("x00200011")),
    description: text("x0008103e"),
    body_part: string("x00180015"),
    rows,
    columns,
    frames,
    samples,
    photometric: string("x00280004").toUpperCase(),
    bits_allocated,
    bits_stored: data.uint16("x00280101") ?? bits_allocated,
    is_signed: data.uint16("x00280103") === 1,
    has_lookup_table: data.elements.x00283000 !== undefined,
    has_scale: data.elements.x00281053 !== undefined && data.elements.x00281052 !== undefined,
    slope: finite(data.floatString("x00281053")) ?? 1,
    intercept: finite(data.floatString("x00281052")) ?? 0,
    window: finite(center) !== null && width !== undefined && width > 0 ? { center: center ?? 0, width } : null,
    pixel_spacing: numbers(data, "x00280030", 2) as [number, number] | null,
    position: numbers(data, "x00200032", 3) as [number, number, number] | null,
    orientation: numbers(data, "x00200037", 6) as SliceHeader["orientation"],
    pixels: native && syntax !== big_endian ? { offset, length: wanted } : null,
    // The end of compressed voxels is found by going through their fragments (read_file.ts).
    voxels: element
      ? { from: offset, to: native ? offset + wanted + (wanted % 2) : file_bytes, vr: element.vr === "OB" ? "OB" : "OW", encapsulated: !native }
      : null,
    kept: wanted_tags.flatMap((tag) => {
      const found = data.elements[tag];
      const bytes = found && bytes_of(data).subarray(found.dataOffset, found.dataOffset + found.length);
      return (bytes && kept_element(tag, found.vr ?? "", bytes)) ?? [];
    }),
    grouped: [],
    inflated: null,
    truncated: cut_off || (element !== undefined && native && (element.length < wanted || offset + wanted > file_bytes)),
  };
}

function numbers(data: DataSet, tag: string, count: number): number[] | null {
  const values = (data.string(tag) ?? "").split("\\").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
  return values.length === count && values.every(Number.isFinite) ? values : null;
}

const finite = (value: number | undefined): number | null =>
  value !== undefined && Number.isFinite(value) ? value : null;

/** DICOM PS3.3 C.12.1.1.2, those that browsers can read; the last of several holds the most. */
const character_sets: Readonly<Record<string, string>> = {
  "ISO_IR 100": "windows-1252", "ISO_IR 101": "iso-8859-2", "ISO_IR 109": "iso-8859-3", "ISO_IR 110": "iso-8859-4",
  "ISO_IR 144": "iso-8859-5", "ISO_IR 127": "iso-8859-6", "ISO_IR 126": "iso-8859-7", "ISO_IR 138": "iso-8859-8",
  "ISO_IR 148": "windows-1254", "ISO_IR 203": "iso-8859-15", "ISO_IR 166": "windows-874", "ISO_IR 13": "shift_jis",
  "ISO 2022 IR 100": "windows-1252", "ISO 2022 IR 87": "iso-2022-jp", "ISO 2022 IR 149": "euc-kr",
  "ISO_IR 192": "utf-8", GB18030: "gb18030", GBK: "gbk",
};

const decoders = new Map<string, TextDecoder>();

function text_reader(data: DataSet): (tag: string) => string {
  const names = (data.string("x00080005") ?? "").split("\\").map((name) => name.trim());
  const label = names.map((name) => character_sets[name]).findLast((found) => found !== undefined) ?? "windows-1252";
  const decoder = decoders.get(label) ?? new TextDecoder(label);
  decoders.set(label, decoder);
  return (tag) => {
    const element = data.elements[tag];
    if (!element) return "";
    const bytes = bytes_of(data).subarray(element.dataOffset, element.dataOffset + element.length);
    return decoder.decode(bytes).replaceAll("\0", "").trim();
  };
}

const text_at = (bytes: Uint8Array, offset: number, count: number): string =>
  String.fromCharCode(...bytes.subarray(offset, offset + count));

function joined(a: Uint8Array, b: Uint8Array): Uint8Array {
  const all = new Uint8Array(a.length + b.length);
  all.set(a);
  all.set(b, a.length);
  return all;
}
