import {
  numbersIn,
  placeOrNull,
  textBefore,
  times,
  triple,
  type ImageHeader,
  type ImageRead,
  type Triple,
  type VoxelType,
} from "./header";

const types: Readonly<Record<string, VoxelType>> = {
  MET_CHAR: "int8",
  MET_UCHAR: "uint8",
  MET_SHORT: "int16",
  MET_USHORT: "uint16",
  MET_INT: "int32",
  MET_UINT: "uint32",
  MET_FLOAT: "float32",
  MET_DOUBLE: "float64",
};

const modalities: Readonly<Record<string, string>> = { MET_MOD_CT: "CT", MET_MOD_MR: "MR" };

/** Reads a MetaImage with its voxels (MHA), or the header of one whose voxels are in another file (MHD). */
export function readMetaImage(bytes: Uint8Array): ImageRead {
  const begin = String.fromCharCode(...bytes.subarray(0, 64));
  if (!/^\s*(ObjectType|Comment|NDims|ObjectSubType)\s*=/.test(begin)) return null;
  const found = textBefore(bytes, /(?:^|\n)\s*ElementDataFile\s*=\s*([^\r\n]*)(?:\r?\n|$)/);
  if (!found) return "more";
  const fields = new Map<string, string>();
  for (const line of found.text.split(/\r?\n/)) {
    const [, key, value] = /^\s*(\w+)\s*=\s*(.*?)\s*$/.exec(line) ?? [];
    if (key !== undefined && value !== undefined) fields.set(key, value);
  }
  const last = new TextDecoder("latin1").decode(bytes.subarray(found.text.length, found.after));
  const isLocal = /=\s*LOCAL\s*$/i.test(last);
  return headerOf((...keys) => keys.map((key) => fields.get(key)).find(Boolean), isLocal ? found.after : null);
}

function headerOf(get: (...keys: readonly string[]) => string | undefined, begin: number | null): ImageHeader {
  const sizes = numbersIn(get("DimSize") ?? "");
  const spacing = triple(numbersIn(get("ElementSpacing", "ElementSize") ?? "1 1 1"));
  const matrix = numbersIn(get("TransformMatrix", "Rotation", "Orientation") ?? "");
  const dimensions = sizes.length;
  const isTrue = (text: string | undefined) => /^(true|1)$/i.test(text ?? "");
  const stored = Number(get("CompressedDataSize") ?? Number.NaN);
  const isPacked = isTrue(get("CompressedData"));
  return {
    size: triple(sizes),
    volumes: sizes[3] ?? 1,
    run: sizes.slice(0, 3).reduce((product, size) => product * size, 1),
    stepMs: null, // the format has no unit of time
    values: sizes.slice(4).reduce((product, size) => product * size, Number(get("ElementNumberOfChannels") ?? 1)),
    type: types[get("ElementType") ?? ""] ?? null,
    littleEndian: !isTrue(get("BinaryDataByteOrderMSB", "ElementByteOrderMSB")),
    axes: axesOf(matrix, dimensions, spacing),
    origin: placeOrNull(triple(numbersIn(get("Offset", "Position", "Origin") ?? ""))),
    spacing,
    slope: 1,
    intercept: 0,
    modality: modalities[get("Modality") ?? ""] ?? "",
    coding: isPacked ? "zlib" : Number(get("HeaderSize") ?? 0) !== 0 || get("BinaryData") === "False" ? "other" : "raw",
    begin,
    storedBytes: isPacked && Number.isFinite(stored) ? stored : null,
  };
}

/** The matrix has a row for each axis, in LPS, with as many numbers as the image has dimensions. */
function axesOf(matrix: readonly number[], dimensions: number, spacing: Triple): ImageHeader["axes"] {
  if (matrix.length !== dimensions ** 2) return null;
  const axis = (i: 0 | 1 | 2) => times(triple(matrix, dimensions * i), Math.abs(spacing[i]));
  return [axis(0), axis(1), axis(2)];
}
