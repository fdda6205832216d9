import {
  lengths,
  numbersIn,
  placeOrNull,
  stepOrNull,
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

type Get = (...keys: readonly string[]) => string | undefined;

function headerOf(get: Get, begin: number | null): ImageHeader {
  const sizes = numbersIn(get("sizes") ?? "");
  const directions = vectorsOf(get("space directions"));
  const { spatial, others } = rolesOf(sizes, get, directions);
  const sizeOf = (i: number | undefined) => sizes[i ?? sizes.length] ?? Number.NaN;
  const [outer] = others;
  const isCounted = others.length === 1 && outer !== undefined && countsVolumes(outer, sizeOf(outer), get);
  const space = spaces[(get("space") ?? "").toLowerCase().replace(/(-time|t)$/, "")];
  const spacings = numbersIn(get("spacings") ?? "");
  const axes = spatial.map((i) => directions?.[i]?.place);
  const coding = get("encoding")?.toLowerCase();
  const skips = [get("byte skip", "byteskip"), get("line skip", "lineskip")].some((skip) => (skip ?? "0") !== "0");
  const product = (all: readonly number[]) => all.reduce((sum, size) => sum * size, 1);
  return {
    size: triple([0, 1, 2].map((i) => sizeOf(spatial[i]))),
    volumes: isCounted ? sizeOf(outer) : 1,
    run: product(sizes.slice(0, isCounted ? outer : sizes.length)),
    stepMs: isCounted ? stepOf(outer, get, directions) : null,
    values: isCounted ? 1 : product(others.map(sizeOf)),
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

const kindsIn = (get: Get) => (get("kinds") ?? "").toLowerCase().split(/\s+/);
/** Kinds of axes that may run through space. "???" and "none" mean that the kind is unknown. */
const spatialKinds: readonly (string | undefined)[] = [undefined, "", "???", "none", "domain", "space"];

/** Returns the axes that run through space, and the others with more than one sample (like ingest/build/nrrd.cpp). */
function rolesOf(sizes: readonly number[], get: Get, directions: readonly (Direction | null)[] | null) {
  const kinds = kindsIn(get);
  const isSpatial = (i: number) => {
    if (!directions) return spatialKinds.includes(kinds[i]);
    return directions[i]?.place.some((part) => part !== 0) ?? false;
  };
  const all = sizes.map((_, i) => i);
  const found = all.filter(isSpatial);
  // If nothing tells time from space, time is the last axis.
  const spatial = found.length === 4 && sizes.length === 4 ? found.slice(0, 3) : found;
  return { spatial, others: all.filter((i) => !spatial.includes(i) && sizes[i] !== 1) };
}

/** Programs that write no kinds put the parts of a vector or a colour in front. */
const mostParts = 4;

/** Whether an axis outside of space counts volumes. Otherwise its samples are parts of a vector or a colour. */
function countsVolumes(axis: number, size: number, get: Get): boolean {
  const kind = kindsIn(get)[axis];
  if (kind === "time" || kind === "list" || kind === "domain" || kind === "space") return true;
  return spatialKinds.includes(kind) && (axis > 0 || size > mostParts);
}

/** Returns the time from volume to volume in ms, if the file states its unit. */
function stepOf(axis: number, get: Get, directions: readonly (Direction | null)[] | null): number | null {
  const unitOf = (list: string | undefined, i: number) => (list?.match(/"[^"]*"/g) ?? [])[i]?.slice(1, -1) ?? "";
  const direction = directions?.[axis];
  if (direction) return stepOrNull(direction.time * (unitMs[unitOf(get("space units"), 3)] ?? 0));
  return stepOrNull((numbersIn(get("spacings") ?? "")[axis] ?? 0) * (unitMs[unitOf(get("units"), axis)] ?? 0));
}

const unitNames: Readonly<Record<number, readonly string[]>> = {
  1000: ["s", "sec", "second", "seconds"],
  1: ["ms", "msec", "millisecond", "milliseconds"],
  0.001: ["us", "usec", "microsecond", "microseconds"],
};
/** Units of time in ms, by their name. */
const unitMs: Readonly<Record<string, number>> = Object.fromEntries(
  Object.entries(unitNames).flatMap(([ms, names]) => names.map((name) => [name, Number(ms)] as const)),
);

const along = (a: Triple, space: Triple): Triple => [a[0] * space[0], a[1] * space[1], a[2] * space[2]];

function axesOf(axes: readonly (Triple | null | undefined)[], space: Triple | undefined): ImageHeader["axes"] {
  const [x, y, z] = axes;
  if (!x || !y || !z || !space) return null;
  const inLps = (axis: Triple): Triple => along(axis, space);
  return [inLps(x), inLps(y), inLps(z)];
}

/** The step along an axis: in space, and in time if the space of the file has time. */
interface Direction {
  readonly place: Triple;
  readonly time: number;
}

/** Parses vectors such as "(1,0,0) none (0,0,2)", where "none" marks an axis outside of space. */
function vectorsOf(text: string | undefined): (Direction | null)[] | null {
  const found = text?.match(/none|\([^)]*\)/g);
  if (!found) return null;
  return found.map((one) => {
    const numbers = numbersIn(one);
    return one === "none" ? null : { place: triple(numbers), time: numbers[3] ?? 0 };
  });
}
