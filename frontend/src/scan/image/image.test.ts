import { describe, expect, it } from "vitest";
import { scanFiles } from "../scan";
import type { ScanResult, Series } from "../types";
import { partBlobs } from "../upload_plan";
import { canonicalHeader } from "./canonical";
import { voxelBytes, type ImageHeader, type Triple } from "./header";
import { readNifti } from "./nifti";
import { readImage } from "./read_image";

const size: Triple = [20, 18, 16];
const count = size[0] * size[1] * size[2];
const values = Int16Array.from({ length: count }, (_, i) => (i % 3001) - 1000);
const voxels = new Uint8Array(values.buffer);
const swapped = Uint8Array.from(voxels, (_, i) => voxels[i ^ 1] ?? 0);
const text = (lines: readonly string[]) => new TextEncoder().encode(lines.join("\n") + "\n");
const file = (...parts: readonly Uint8Array<ArrayBuffer>[]) => new File([...parts], "Jane Canary.nii");
/** Stands where headers have free texts, and must never be sent. */
const canary = "Jane Canary";

async function packed(bytes: Uint8Array<ArrayBuffer>, format: CompressionFormat): Promise<Uint8Array<ArrayBuffer>> {
  return new Uint8Array(
    await new Response(new Blob([bytes]).stream().pipeThrough(new CompressionStream(format))).arrayBuffer(),
  );
}

type Axes = readonly [Triple, Triple, Triple];
const steps: Triple = [0.5, 0.75, 1.5];
/** Every way to lay the axes of a file along those of the patient (LPS), forwards or backwards. */
const orientations: Axes[] = [];
for (const order of [
  [0, 1, 2],
  [0, 2, 1],
  [1, 0, 2],
  [1, 2, 0],
  [2, 0, 1],
  [2, 1, 0],
])
  for (let signs = 0; signs < 8; signs++) {
    const axis = (a: number): Triple => {
      const step = (steps[a] ?? 0) * (signs & (1 << a) ? -1 : 1);
      const at = (i: number) => (order[a] === i ? step : 0);
      return [at(0), at(1), at(2)];
    };
    orientations.push([axis(0), axis(1), axis(2)]);
  }
const [upright] = orientations;
if (!upright) throw new Error("no orientation");

interface Nifti {
  readonly axes?: Axes | null;
  readonly little?: boolean;
  readonly magic?: string;
  readonly volumes?: number;
  readonly code?: number;
}

/** A NIfTI-1 header as other programs write it. */
function nifti({ axes = upright ?? null, little = true, magic = "n+1", volumes = 1, code = 4 }: Nifti = {}) {
  const bytes = new Uint8Array(352);
  const view = new DataView(bytes.buffer);
  view.setInt32(0, 348, little);
  [volumes > 1 ? 4 : 3, ...size, volumes].forEach((one, i) => view.setInt16(40 + 2 * i, one, little));
  view.setInt16(70, code, little);
  [1, 2, 3, 4].forEach((one, i) => view.setFloat32(76 + 4 * i, one, little));
  view.setFloat32(108, 352, little);
  view.setFloat32(112, 2, little);
  view.setFloat32(116, -10, little);
  bytes.set(text([canary]), 148);
  if (axes) {
    view.setInt16(254, 1, little);
    for (let row = 0; row < 3; row++)
      axes.forEach((axis, i) => view.setFloat32(280 + 16 * row + 4 * i, (row < 2 ? -1 : 1) * (axis[row] ?? 0), little));
  }
  bytes.set(text([canary]), 328);
  bytes.set(new TextEncoder().encode(magic), 344);
  return bytes;
}

const nrrd = (space: string, directions: string, ...more: readonly string[]) =>
  text([
    "NRRD0004",
    `# ${canary}`,
    "type: short",
    "dimension: 3",
    `space: ${space}`,
    ...(more.some((one) => one.startsWith("sizes")) ? [] : [`sizes: ${size.join(" ")}`]),
    `space directions: ${directions}`,
    ...(more.some((one) => one.startsWith("encoding")) ? [] : ["encoding: raw"]),
    "endian: little",
    `PatientName:=${canary}`,
    ...more,
    "",
  ]);

const meta = (matrix: string, ...more: readonly string[]) =>
  text([
    "ObjectType = Image",
    "NDims = 3",
    `Comment = ${canary}`,
    "BinaryData = True",
    `TransformMatrix = ${matrix}`,
    `ElementSpacing = ${steps.join(" ")}`,
    `DimSize = ${size.join(" ")}`,
    "ElementType = MET_SHORT",
    ...more,
  ]);
const identity = "1 0 0 0 1 0 0 0 1";
const local = "ElementDataFile = LOCAL";

function defined<T>(value: T | undefined): T {
  if (value === undefined) throw new Error("nothing");
  return value;
}

const scanned = (...files: readonly File[]) =>
  scanFiles(
    files,
    () => undefined,
    () => false,
  );
const only = ({ series }: ScanResult): Series => {
  expect(series).toHaveLength(1);
  return defined(series[0]);
};

/** What a scan of these files would send, read like the server does. */
async function sent(...files: readonly File[]): Promise<{ header: ImageHeader; voxels: Uint8Array; series: Series }> {
  const result = await scanned(...files);
  const series = only(result);
  expect(series.verdict).toMatchObject({ suitable: true });
  const [blob] = await partBlobs(series.upload, files, result.unpacked);
  const bytes = new Uint8Array(await defined(blob).arrayBuffer());
  expect(new TextDecoder("latin1").decode(bytes)).not.toContain(canary);
  const header = readNifti(bytes) as ImageHeader;
  return { header, voxels: bytes.subarray(352), series };
}

const isNear = (axes: ImageHeader["axes"], wanted: Axes) =>
  axes?.every((axis, i) => axis.every((part, j) => Math.abs(part - (wanted[i]?.[j] ?? Number.NaN)) < 1e-6)) ?? false;

describe("a research file", () => {
  it("is uploaded as one NIfTI file with the same voxels, in either byte order, packed or not", async () => {
    const files = [
      file(nifti(), voxels),
      file(nifti({ little: false }), swapped),
      new File([await packed(new Uint8Array(await file(nifti(), voxels).arrayBuffer()), "gzip")], "scan.nii.gz"),
      file(nrrd("left-posterior-superior", "(0.5,0,0) (0,0.75,0) (0,0,1.5)"), voxels),
      file(nrrd("LPS", "(0.5,0,0) (0,0.75,0) (0,0,1.5)", "encoding: gzip"), await packed(voxels, "gzip")),
      file(meta(identity, local), voxels),
      file(meta(identity, "CompressedData = True", "Modality = MET_MOD_CT", local), await packed(voxels, "deflate")),
      file(meta(identity, "BinaryDataByteOrderMSB = True", local), swapped),
    ];
    for (const one of files) {
      const { header, voxels: got } = await sent(one);
      expect(header.size).toEqual(size);
      expect(isNear(header.axes, upright)).toBe(true);
      expect(got).toEqual(header.littleEndian ? voxels : swapped);
    }
  });

  it("keeps its scale and its modality", async () => {
    expect((await sent(file(nifti(), voxels))).header).toMatchObject({ slope: 2, intercept: -10 });
    const ct = await sent(file(meta(identity, "Modality = MET_MOD_CT", local), voxels));
    expect(ct.series.modality).toBe("CT");
    const [blob] = await partBlobs(ct.series.upload, [file(meta(identity, "Modality = MET_MOD_CT", local), voxels)]);
    expect(await defined(blob).slice(328, 331).text()).toBe("CT\0");
  });

  it("lies in the patient as the file says, in all 48 orientations", () => {
    expect(orientations).toHaveLength(48);
    for (const axes of orientations) {
      const written = (signs: Triple) =>
        axes.map((axis) => `(${axis.map((part, i) => part * (signs[i] ?? 0)).join(",")})`).join(" ");
      const files = {
        "NIfTI-1": nifti({ axes }),
        LPS: nrrd("left-posterior-superior", written([1, 1, 1])),
        RAS: nrrd("right-anterior-superior", written([-1, -1, 1])),
        LAS: nrrd("LAS", written([1, -1, 1])),
        MetaImage: meta(axes.flatMap((axis, i) => axis.map((part) => part / (steps[i] ?? 1))).join(" "), local),
      };
      for (const [format, bytes] of Object.entries(files)) {
        const read = readImage(bytes) as ImageHeader & { type: "int16" };
        expect(isNear(read.axes, axes), `${format} ${JSON.stringify(axes)}`).toBe(true);
        const again = readNifti(canonicalHeader(read)) as ImageHeader;
        expect(isNear(again.axes, axes), `${format}, sent`).toBe(true);
      }
    }
  });

  it("may give its directions by a quaternion", () => {
    const bytes = nifti({ axes: null });
    const view = new DataView(bytes.buffer);
    view.setInt16(252, 1, true);
    view.setFloat32(76, -1, true); // the third axis is reversed
    view.setFloat32(264, 1, true); // d: half a turn about the axis to the head
    const { axes } = readImage(bytes) as ImageHeader;
    expect(
      isNear(axes, [
        [2, 0, 0],
        [0, 3, 0],
        [0, 0, -4],
      ]),
    ).toBe(true);
  });

  it("may have its voxels in a second file, wherever that is in the choice", async () => {
    const raw = new File([voxels], "voxels.raw");
    const others = [
      file(meta(identity, "ElementDataFile = voxels.raw")),
      file(nrrd("LPS", "(0.5,0,0) (0,0.75,0) (0,0,1.5)", "data file: voxels.raw")),
      file(nifti({ magic: "ni1" })),
    ];
    for (const header of others) {
      expect((await sent(raw, header)).voxels).toEqual(voxels);
      expect((await scanned(header, raw)).notDicom).toBe(0);
      expect(only(await scanned(header)).verdict).toMatchObject({ suitable: false, reason: "no_voxels" });
    }
  });

  it("is shown with its file's name in the list, which the upload does not contain", async () => {
    const { series } = await sent(file(nifti(), voxels));
    const bytes = new Uint8Array(await file(nifti(), voxels).arrayBuffer());
    const alone = new File([await packed(bytes, "gzip")], "scan.nii.gz");
    expect((await sent(alone)).series.fileName).toBe("scan.nii.gz");
    expect(series).toMatchObject({ fileName: "Jane Canary.nii", description: "", slices: 16 });
    expect(series.verdict).toMatchObject({ size: [20, 18, 16], sizeMm: [10, 13.5, 24] });
  });

  it("has the same fingerprint in each choice, and another one if a voxel differs", async () => {
    const changed = Uint8Array.from(voxels);
    changed[1234] = 77;
    const marks = await Promise.all(
      [voxels, voxels, changed].map(async (data) => (await sent(file(nifti(), data))).series.fingerprint),
    );
    expect(marks[0]).toBe(marks[1]);
    expect(marks[0]).not.toBe(marks[2]);
  });

  it("has a preview that is as radiologists see it", async () => {
    const [x, y, z] = size;
    const bright = new Int16Array(count);
    // At the patient's left front, in the middle slice of a file that runs to the right and to the back.
    for (let row = 0; row < 4; row++)
      for (let column = 0; column < 4; column++) bright[column + x * (row + y * (z / 2))] = 900;
    const axes: Axes = [
      [-1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ];
    const { series } = await sent(file(nifti({ axes }), new Uint8Array(bright.buffer)));
    const { thumbnail } = series;
    if (!thumbnail) throw new Error("no preview");
    const at = (across: number, down: number) =>
      thumbnail.gray[Math.floor(across * thumbnail.width) + thumbnail.width * Math.floor(down * thumbnail.height)];
    expect(at(0.95, 0.05)).toBe(255);
    expect(at(0.05, 0.05)).toBe(0);
    expect(at(0.95, 0.95)).toBe(0);
  });

  it("says so if it does not say how it lies in the patient", async () => {
    const { header, series } = await sent(file(nifti({ axes: null }), voxels));
    expect(header.axes).toBeNull();
    expect(header.spacing).toEqual([2, 3, 4]);
    expect(series.verdict).toMatchObject({ repairs: [{ kind: "unknown_directions" }] });
  });

  it("is sent with all of its phases and the time between them", async () => {
    const header = nifti({ volumes: 3 });
    header[123] = 2 | 8; // mm and seconds
    new DataView(header.buffer).setFloat32(92, 4, true);
    const all = new Uint8Array(3 * voxels.length).map((_, i) => i % 251);
    const found = await sent(file(header, all));
    expect(found.series.verdict).toMatchObject({
      size,
      phases: { kind: "time", count: 3, range: [0, 8000] },
    });
    expect(found.header).toMatchObject({ size, volumes: 3, stepMs: 4000 });
    expect(found.voxels).toEqual(all);
    const unknown = await sent(file(nifti({ volumes: 3 }), all));
    expect(unknown.series.verdict).toMatchObject({ phases: { kind: "index", count: 3, range: [0, 2] } });
    expect(unknown.header.stepMs).toBeNull();
  });

  /** Voxels of three volumes, and the same with the axis of the volumes as the one number `axis` of the file. */
  const moments = Int16Array.from({ length: 3 * count }, (_, i) => (i * 7919) % 30011);
  const bytesOfMoments = new Uint8Array(moments.buffer);
  function withMomentsAt(axis: number): Uint8Array<ArrayBuffer> {
    const run = size.slice(0, axis).reduce((product, side) => product * side, 1);
    const mixed = Int16Array.from(moments, (_, i) => {
      const turn = Math.floor(i / (3 * run));
      const volume = Math.floor(i / run) % 3;
      return moments[volume * count + turn * run + (i % run)] ?? 0;
    });
    return new Uint8Array(mixed.buffer);
  }
  const inserted = (words: readonly string[], axis: number, word: string) =>
    [...words.slice(0, axis), word, ...words.slice(axis)].join(" ");
  const nrrdOf = (axis: number, kind: string, volumes = 3, ...more: readonly string[]) =>
    nrrd(
      "LPS",
      inserted(["(0.5,0,0)", "(0,0.75,0)", "(0,0,1.5)"], axis, "none"),
      `sizes: ${inserted(size.map(String), axis, `${volumes}`)}`,
      `kinds: ${inserted(["domain", "domain", "domain"], axis, kind)}`,
      ...more,
    );

  it("has phases in NRRD wherever their axis is, and whether it is packed", async () => {
    for (const axis of [0, 1, 2, 3])
      for (const kind of ["list", "time", "domain"]) {
        const found = await sent(file(nrrdOf(axis, kind), withMomentsAt(axis)));
        expect(found.series.verdict).toMatchObject({ size, phases: { kind: "index", count: 3 } });
        expect(isNear(found.header.axes, upright)).toBe(true);
        expect(found.voxels, `${kind}, ${axis}`).toEqual(bytesOfMoments);
      }
    const gzip = await packed(withMomentsAt(0), "gzip");
    expect((await sent(file(nrrdOf(0, "list", 3, "encoding: gzip"), gzip))).voxels).toEqual(bytesOfMoments);
    expect((await sent(file(nrrdOf(3, "???"), bytesOfMoments))).voxels).toEqual(bytesOfMoments);
  });

  it("keeps the time between the phases of an NRRD", async () => {
    const stepOf = async (head: Uint8Array<ArrayBuffer>) => (await sent(file(head, bytesOfMoments))).header.stepMs;
    const seconds = ["spacings: nan nan nan 0.04", 'units: "" "" "" "s"'];
    expect(await stepOf(nrrdOf(3, "time", 3, ...seconds))).toBeCloseTo(40, 4);
    expect(await stepOf(nrrdOf(3, "time", 3, "spacings: nan nan nan 0.04"))).toBeNull();
    const directions = "(0.5,0,0,0) (0,0.75,0,0) (0,0,1.5,0) (0,0,0,75)";
    const sizes = `sizes: ${size.join(" ")} 3`;
    expect(await stepOf(nrrd("LPST", directions, sizes, 'space units: "mm" "mm" "mm" "ms"'))).toBe(75);
  });

  it("has phases in MetaImage, whose matrix then has four rows", async () => {
    const matrix = "0 1 0 0 1 0 0 0 0 0 1 0 0 0 0 1";
    const head = new TextDecoder()
      .decode(meta(matrix, local))
      .trimEnd()
      .replace("NDims = 3", "NDims = 4")
      .replace(size.join(" "), `${size.join(" ")} 3`)
      .replace(steps.join(" "), `${steps.join(" ")} 40`);
    const found = await sent(file(text(head.split("\n")), bytesOfMoments));
    expect(found.series.verdict).toMatchObject({ size, phases: { kind: "index", count: 3 }, repairs: [] });
    expect(found.header.axes).toEqual([
      [0, 0.5, 0],
      [0.75, 0, 0],
      [0, 0, 1.5],
    ]);
    expect(found.voxels).toEqual(bytesOfMoments);
  });

  it("with colours or vectors is refused", async () => {
    for (const [kind, parts] of [
      ["vector", 3],
      ["RGB-color", 3],
      ["3D-symmetric-matrix", 6],
      ["???", 3],
    ] as const) {
      const many = new Uint8Array(parts * voxels.length);
      const { verdict } = only(await scanned(file(nrrdOf(0, kind, parts), many)));
      expect(verdict, kind).toMatchObject({ suitable: false, reason: "pixel_format" });
    }
  });

  it("is refused in words if it cannot be shown", async () => {
    const reasonOf = async (...parts: readonly Uint8Array<ArrayBuffer>[]) => {
      const { verdict } = only(await scanned(file(...parts)));
      return verdict.suitable ? null : verdict.reason;
    };
    const sheared: Axes = [upright[0], [0.5, 0.75, 0], upright[2]];
    expect(await reasonOf(nifti({ volumes: 10 }), voxels)).toBe("damaged");
    expect(await reasonOf(nifti({ volumes: 1001 }), voxels)).toBe("too_large");
    expect(await reasonOf(nifti({ code: 128 }), voxels)).toBe("pixel_format");
    expect(await reasonOf(nifti({ axes: sheared }), voxels)).toBe("bad_orientation");
    expect(await reasonOf(nifti(), voxels.subarray(1))).toBe("damaged");
    expect(await reasonOf(meta(identity, "ElementNumberOfChannels = 3", local), voxels)).toBe("pixel_format");
    expect(await reasonOf(meta(identity, "CompressedData = True", local), voxels)).toBe("damaged");
    expect(await reasonOf(nrrd("LPS", "none (0.5,0,0) (0,0.75,0) (0,0,1.5)", "sizes: 3 20 18 16"), voxels)).toBe(
      "pixel_format",
    );
    expect(await reasonOf(nrrd("LPS", "(0.5,0,0) (0,0.75,0) (0,0,1.5)", "encoding: bzip2"), voxels)).toBe(
      "pixel_format",
    );
    expect(await reasonOf(text(["NRRD0004", "type: short", "encoding: raw", ""]), voxels)).toBe("damaged");
  });

  it("is not what only begins like one", async () => {
    const others = [text(["ObjectType = Door"]), text(["NRRD0004", "type: short"]), nifti({ magic: "xyz" })];
    for (const other of others) expect(readImage(other)).not.toMatchObject({ type: "int16" });
    expect(await scanned(...others.map((one) => file(one)))).toMatchObject({ series: [] });
  });

  it("reads NIfTI-2", () => {
    const bytes = new Uint8Array(544);
    const view = new DataView(bytes.buffer);
    view.setInt32(0, 540, true);
    bytes.set(new TextEncoder().encode("n+2\0\r\n\x1a\n"), 4);
    view.setInt16(12, 4, true);
    [3, ...size].forEach((one, i) => view.setBigInt64(16 + 8 * i, BigInt(one), true));
    [1, 2, 3, 4].forEach((one, i) => view.setFloat64(104 + 8 * i, one, true));
    view.setBigInt64(168, 544n, true);
    const read = readImage(bytes) as ImageHeader;
    expect(read).toMatchObject({ size, type: "int16", begin: 544, axes: null, spacing: [2, 3, 4] });
    expect(voxelBytes(read)).toBe(2 * count);
  });
});
