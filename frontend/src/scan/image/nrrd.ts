import {
  lengths,
  numbersIn,
  placeOrNull,
  textBefore,
  triple,
  type ImageHeader,
  type ImageRead,
  type Triple,
  type VoxelType,
} from "./header";

/** Names of types, without "signed" and "_t" (teem.sourceforge.net/nrrd/format.html). */
const types: Readonly<Record<string, VoxelType>> = {
  char: "int8",
  int8: "int8",
  uchar: "uint8",
  "unsigned char": "uint8",
  uint8: "uint8",
  short: "int16",
  "short int": "int16",
  int16: "int16",
  ushort: "uint16",
  "unsigned short": "uint16",
  "unsigned short int": "uint16",
  uint16: "uint16",
  int: "int32",
  int32: "int32",
  uint: "uint32",
  "unsigned int": "uint32",
  uint32: "uint32",
  float: "float32",
  double: "float64",
};

/** The directions of the axes of a space in LPS. */
const spaces: Readonly<Record<string, Triple>> = {
  "left-posterior-superior": [1, 1, 1],
  lps: [1, 1, 1],
  "right-anterior-superior": [-1, -1, 1],
  ras: [-1, -1, 1],
  "left-anterior-superior": [1, -1, 1],
  las: [1, -1, 1],
};

/** Reads an NRRD with its voxels, or the header of one whose voxels are in another file. */
export function readNrrd(bytes: Uint8Array): ImageRead {
  if (!/^NRRD\d{4}/.test(String.fromCharCode(...bytes.subarray(0, 8)))) return null;
  const found = textBefore(bytes, /\r?\n\r?\n/);
  // The header of a file without voxels need not end with an empty line.
  const { text, after } = found ?? { text: new TextDecoder("latin1").decode(bytes), after: bytes.length };
  const fields = new Map<string, string>();
  for (const line of text.split(/\r?\n/)) {
    const [, key, value] = /^([^:#]+): (.*)$/.exec(line) ?? [];
    if (key !== undefined && value !== undefined) fields.set(key.trim().toLowerCase(), value.trim());
  }
  const get = (...keys: readonly string[]) => keys.map((key) => fields.get(key)).find((value) => value !== undefined);
  const isBeside = get("data file", "datafile") !== undefined;
  if (!found && !isBeside) return "more";
  return headerOf(get, isBeside ? null : after);
}

function headerOf(get: (...keys: readonly string[]) => string | undefined, begin: number | null): ImageHeader {
  const sizes = numbersIn(get("sizes") ?? "");
  const directions = vectorsOf(get("space directions"));
  // In a file of four dimensions, the axis without a direction counts volumes or values. If no axis
  // has a direction, it is the last one.
  const spatial = directions?.flatMap((one, i) => (one ? [i] : [])) ?? sizes.map((_, i) => i).slice(0, 3);
  const others = sizes.filter((_, i) => !spatial.includes(i)).reduce((product, size) => product * size, 1);
  const isInner = !spatial.includes(0); // the values of a voxel lie beside each other
  const space = spaces[(get("space") ?? "").toLowerCase()];
  const spacings = numbersIn(get("spacings") ?? "");
  const axes = spatial.map((i) => directions?.[i]);
  const coding = get("encoding")?.toLowerCase();
  const skips = [get("byte skip", "byteskip"), get("line skip", "lineskip")].some((skip) => (skip ?? "0") !== "0");
  return {
    size: triple(spatial.map((i) => sizes[i] ?? Number.NaN)),
    volumes: isInner ? 1 : others,
    stepMs: null,
    values: isInner ? others : 1,
    type:
      types[
        (get("type") ?? "")
          .toLowerCase()
          .replace(/^signed /, "")
          .replace(/_t$/, "")
      ] ?? null,
    littleEndian: get("endian")?.toLowerCase() !== "big",
    axes: axesOf(axes, space),
    origin: space ? placeOrNull(along(triple(numbersIn(get("space origin") ?? "")), space)) : null,
    spacing:
      axes[0] && axes[1] && axes[2]
        ? lengths([axes[0], axes[1], axes[2]])
        : triple(spatial.map((i) => spacings[i] ?? 1)),
    slope: 1,
    intercept: 0,
    modality: "",
    coding: skips ? "other" : coding === "raw" ? "raw" : coding === "gzip" || coding === "gz" ? "gzip" : "other",
    begin,
    storedBytes: null,
  };
}

const along = (a: Triple, space: Triple): Triple => [a[0] * space[0], a[1] * space[1], a[2] * space[2]];

function axesOf(axes: readonly (Triple | null | undefined)[], space: Triple | undefined): ImageHeader["axes"] {
  const [x, y, z] = axes;
  if (!x || !y || !z || !space) return null;
  const inLps = (axis: Triple): Triple => along(axis, space);
  return [inLps(x), inLps(y), inLps(z)];
}

/** Parses vectors such as "(1,0,0) none (0,0,2)", where "none" marks an axis outside of space. */
function vectorsOf(text: string | undefined): (Triple | null)[] | null {
  const found = text?.match(/none|\([^)]*\)/g);
  return found ? found.map((one) => (one === "none" ? null : triple(numbersIn(one)))) : null;
}
