import {
  fromRas,
  placeOrNull,
  stepOrNull,
  times,
  triple,
  type ImageHeader,
  type ImageRead,
  type Triple,
  type VoxelType,
} from "./header";

// Offsets of nifti1.h and nifti2.h (R. Cox et al. 2004, 2011).

export const typeCodes: Readonly<Record<VoxelType, number>> = {
  uint8: 2,
  int16: 4,
  int32: 8,
  float32: 16,
  float64: 64,
  int8: 256,
  uint16: 512,
  uint32: 768,
};
const types = new Map(Object.entries(typeCodes).map(([type, code]) => [code, type as VoxelType]));

const length1 = 348;
const length2 = 540;
/** Units of length in mm, by their code. Most files that say nothing mean mm. */
const unitMm: Readonly<Record<number, number>> = { 1: 1000, 2: 1, 3: 0.001 };
const unitMs: Readonly<Record<number, number>> = { 8: 1000, 16: 1, 24: 0.001 };

/** Reads NIfTI-1 and NIfTI-2, as one file or as the header of a pair. */
export function readNifti(bytes: Uint8Array): ImageRead {
  if (bytes.length < 4) return null;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const little = [length1, length2].includes(view.getInt32(0, true));
  const length = view.getInt32(0, little);
  if (length !== length1 && length !== length2) return null;
  if (bytes.length < length) return "more";
  const fields = length === length1 ? fields1(view, little) : fields2(view, little);
  if (!/^n[i+][12]$/.test(fields.magic)) return null;
  const { dim, pixdim, code } = fields;
  const dimensions = Math.max(0, Math.min(7, dim[0] ?? 0));
  const extent = (i: number) => (i <= dimensions ? Math.max(1, dim[i] ?? 1) : 1);
  const mm = unitMm[fields.units & 7] ?? 1;
  const isScaled = Number.isFinite(fields.slope) && fields.slope !== 0 && Number.isFinite(fields.intercept);
  return {
    size: [extent(1), extent(2), extent(3)],
    volumes: extent(4),
    run: extent(1) * extent(2) * extent(3),
    stepMs: stepOrNull((unitMs[fields.units & 0x38] ?? 0) * (pixdim[4] ?? 0)),
    values: extent(5) * extent(6) * extent(7),
    type: types.get(code) ?? null,
    littleEndian: little,
    axes: axesOf(fields, mm),
    origin: originOf(fields, mm),
    spacing: times(triple(pixdim.map(Math.abs), 1), mm),
    slope: isScaled ? fields.slope : 1,
    intercept: isScaled ? fields.intercept : 0,
    modality: "",
    coding: "raw",
    begin: fields.magic[1] === "+" ? fields.begin : null,
    storedBytes: null,
  };
}

interface Fields {
  readonly magic: string;
  readonly dim: readonly number[];
  readonly pixdim: readonly number[];
  readonly code: number;
  readonly begin: number;
  readonly slope: number;
  readonly intercept: number;
  readonly units: number;
  readonly qform: number;
  readonly sform: number;
  /** b, c and d of the quaternion. */
  readonly quaternion: readonly number[];
  readonly offset: readonly number[];
  /** The rows of the matrix, with four numbers each. */
  readonly srow: readonly number[];
}

const magicAt = (view: DataView, at: number) =>
  String.fromCharCode(view.getUint8(at), view.getUint8(at + 1), view.getUint8(at + 2));
const list = (count: number, read: (i: number) => number) => Array.from({ length: count }, (_, i) => read(i));

function fields1(view: DataView, little: boolean): Fields {
  const float = (at: number) => view.getFloat32(at, little);
  const short = (at: number) => view.getInt16(at, little);
  return {
    magic: magicAt(view, 344),
    dim: list(8, (i) => short(40 + 2 * i)),
    pixdim: list(8, (i) => float(76 + 4 * i)),
    code: short(70),
    begin: float(108),
    slope: float(112),
    intercept: float(116),
    units: view.getUint8(123),
    qform: short(252),
    sform: short(254),
    quaternion: list(3, (i) => float(256 + 4 * i)),
    offset: list(3, (i) => float(268 + 4 * i)),
    srow: list(12, (i) => float(280 + 4 * i)),
  };
}

function fields2(view: DataView, little: boolean): Fields {
  const double = (at: number) => view.getFloat64(at, little);
  const long = (at: number) => Number(view.getBigInt64(at, little));
  return {
    magic: magicAt(view, 4),
    dim: list(8, (i) => long(16 + 8 * i)),
    pixdim: list(8, (i) => double(104 + 8 * i)),
    code: view.getInt16(12, little),
    begin: long(168),
    slope: double(176),
    intercept: double(184),
    units: view.getInt32(500, little),
    qform: view.getInt32(344, little),
    sform: view.getInt32(348, little),
    quaternion: list(3, (i) => double(352 + 8 * i)),
    offset: list(3, (i) => double(376 + 8 * i)),
    srow: list(12, (i) => double(400 + 8 * i)),
  };
}

/**
 * Returns the axes from the matrix, or else from the quaternion, as ingest and most programs do.
 */
function axesOf({ sform, srow, qform, quaternion, pixdim }: Fields, mm: number): ImageHeader["axes"] {
  const column = (i: number): Triple => [srow[i] ?? Number.NaN, srow[4 + i] ?? Number.NaN, srow[8 + i] ?? Number.NaN];
  const axes = sform > 0 ? ([column(0), column(1), column(2)] as const) : qform > 0 ? turned(quaternion, pixdim) : null;
  return axes && [fromRas(times(axes[0], mm)), fromRas(times(axes[1], mm)), fromRas(times(axes[2], mm))];
}

function originOf({ sform, srow, qform, offset }: Fields, mm: number): Triple | null {
  const place = sform > 0 ? [srow[3], srow[7], srow[11]] : qform > 0 ? offset : [];
  return placeOrNull(fromRas(times(triple(place.map((one) => one ?? Number.NaN)), mm)));
}

function turned(
  [b = 0, c = 0, d = 0]: readonly number[],
  pixdim: readonly number[],
): readonly [Triple, Triple, Triple] {
  const a = Math.sqrt(Math.max(0, 1 - (b * b + c * c + d * d)));
  const x: Triple = [a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)];
  const y: Triple = [2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)];
  const z: Triple = [2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c];
  const [across, down, deep] = triple(pixdim, 1);
  return [times(x, across), times(y, down), times(z, (pixdim[0] ?? 1) < 0 ? -deep : deep)];
}
