import type { DataSet } from "dicom-parser";
import { bigEndian } from "./clean_file";
import type { KeptElement } from "./types";

export const bValueTag = "x00189087";
const most = 1e5; // s/mm², far above those of scanners

/**
 * Returns the b-value that scanners of Siemens, GE and Philips write into private elements of files without the
 * standard one, by the same rules as ingest/dicom/read_slice.cpp.
 */
export function privateBValue(data: DataSet): number | null {
  const creator = (tag: string) => data.string(tag)?.trim();
  const first = (tag: string) => data.floatString(tag, 0);
  let value: number | undefined;
  if (creator("x00190010") === "SIEMENS MR HEADER") {
    value = first("x0019100c");
  } else if (creator("x00430010") === "GEMS_PARM_01") {
    value = first("x00431039");
    if (value !== undefined && value >= 1e9) value %= most; // some versions add 10⁹ as a mark
  } else if (creator("x20010010") === "Philips Imaging DD 001") {
    value = data.elements.x20011003?.length === 4 ? data.float("x20011003") : undefined;
  }
  return value !== undefined && value >= 0 && value < most ? value : null;
}

/** Returns the standard element with a b-value. Private elements are never sent. */
export function bValueElement(value: number, transferSyntax: string): KeptElement {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value, transferSyntax !== bigEndian);
  return { tag: bValueTag, vr: "FD", bytes };
}
