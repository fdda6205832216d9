import { gzipSync } from "node:zlib";
import { BlobReader, BlobWriter, ZipWriter, type ZipWriterConstructorOptions } from "@zip.js/zip.js";
import { describe, expect, it } from "vitest";
import { archiveFormat, Budget, filesIn } from "./archives";
import { makeBundle } from "./bundle";
import { DamagedPiece, wholeOf } from "./piece";
import { scanFiles } from "./scan";
import { makeSeries } from "./testing";
import { partBlobs } from "./upload_plan";

const scan = (files: readonly Blob[]) =>
  scanFiles(
    files,
    () => undefined,
    () => false,
  );

async function zipOf(files: readonly (readonly [string, Blob])[], options: ZipWriterConstructorOptions = {}) {
  const writer = new ZipWriter(new BlobWriter(), { useWebWorkers: false, ...options });
  for (const [name, file] of files) await writer.add(name, new BlobReader(file));
  return writer.close();
}

const gzipOf = async (blob: Blob) => new Blob([gzipSync(new Uint8Array(await blob.arrayBuffer()))]);
const named = (files: readonly Blob[]) => files.map((file, i) => [`DICOM/IM${i}`, file] as const);
const bytesOf = async (blob: Blob) => new Uint8Array(await blob.arrayBuffer());

/** What would be uploaded of the only series, and how it is recognised. */
async function sentOf(files: readonly Blob[]) {
  const { series, unpacked, faults } = await scan(files);
  expect(faults).toEqual([]);
  expect(series).toHaveLength(1);
  const [{ upload, fingerprint, thumbnail } = { upload: null, fingerprint: "", thumbnail: null }] = series;
  if (!upload) throw new Error("no series");
  const parts = await partBlobs(upload, files, unpacked);
  return { fingerprint, thumbnail, parts: await Promise.all(parts.map(bytesOf)) };
}

const faultsOf = async (archive: Blob) => (await scan([archive])).faults.map(({ fault }) => fault);
const slices = makeSeries(20, 1.5);

describe("an archive", () => {
  it("gives what its files give, whatever packs them", async () => {
    const plain = await sentOf(slices);
    const zip = await zipOf(named(slices));
    expect(zip.size).toBeLessThan(makeBundle(slices).size / 2);
    const stored = await zipOf(named(slices), { level: 0 });
    const large = await zipOf(named(slices), { zip64: true });
    const tar = makeBundle(slices);
    const packed = await gzipOf(tar);
    const nested = await gzipOf(makeBundle([await zipOf([["disc.zip", zip]], { level: 0 })]));
    for (const archive of [zip, stored, large, tar, packed, nested]) expect(await sentOf([archive])).toEqual(plain);
  });

  it("may lie beside files and other archives of the same series", async () => {
    const mixed = [await zipOf(named(slices.slice(0, 7))), ...slices.slice(7, 12), makeBundle(slices.slice(12))];
    expect(await sentOf(mixed)).toEqual(await sentOf(slices));
  });

  it("counts the files in it that are not DICOM, and not itself", async () => {
    const { notDicom, files } = await scan([
      await zipOf([...named(slices), ["README.TXT", new Blob(["Hello, doctor!"])]]),
    ]);
    expect({ notDicom, files }).toEqual({ notDicom: 1, files: slices.length + 1 });
  });

  it("cannot lead anywhere by the names of its files", async () => {
    const names = ["../../etc/passwd", "/etc/passwd", "C:\\Windows\\x", "a\0b", "", "x".repeat(60_000)];
    const archive = await zipOf(slices.map((file, i) => [`${names[i % names.length]}${i}`, file] as const));
    expect(await sentOf([archive])).toEqual(await sentOf(slices));
  });
});

describe("an archive that cannot be read", () => {
  it("says that it needs a password, and what is open is still found", async () => {
    const locked = await zipOf(named(slices), { password: "secret" });
    expect(await faultsOf(locked)).toEqual(["encrypted"]);
    const { series, faults } = await scan([...slices, locked]);
    expect(series).toHaveLength(1);
    expect(faults).toEqual([{ file: slices.length, fault: "encrypted" }]);
  });

  it("says that it is damaged, wherever it ends", async () => {
    const zip = await zipOf(named(slices));
    const tar = makeBundle(slices);
    const packed = await gzipOf(tar);
    for (const archive of [zip, packed]) {
      for (const part of [0.1, 0.5, 0.99]) {
        expect(await faultsOf(archive.slice(0, Math.floor(part * archive.size))), `${part}`).toEqual(["damaged"]);
      }
    }
    expect(await faultsOf(tar.slice(0, 5000))).toEqual(["damaged"]);
    const broken = await bytesOf(tar);
    broken[5 * 512 + 130] = 0x39;
    expect((await scan([new Blob([broken])])).faults.length).toBeLessThanOrEqual(1);
  });

  it("is not uploaded if a byte of it was changed", async () => {
    const zip = await zipOf(named(slices));
    const bytes = await bytesOf(zip);
    const [first] = await collect(filesIn(zip, "zip", new Budget()));
    if (!first || typeof first === "string" || !first.zipped) throw new Error("no file");
    expect((await wholeOf(first)).size).toBe(slices[0]?.size);
    const within = first.blob.size - 1;
    let refused = 0;
    for (let at = 60; at < Math.min(within, first.zipped.packedSize); at += 37) {
      const changed = bytes.slice();
      changed[at] = (changed[at] ?? 0) ^ 0x10;
      const [piece] = await collect(filesIn(new Blob([changed]), "zip", new Budget()));
      if (!piece || typeof piece === "string") continue;
      await expect(wholeOf(piece)).rejects.toThrow(DamagedPiece);
      refused += 1;
    }
    expect(refused).toBeGreaterThan(3);
  });

  it("says that too many archives lie in each other", async () => {
    let archive = await zipOf(named(slices));
    for (let i = 0; i < 4; i++) archive = await zipOf([["inner.zip", archive]]);
    expect(await faultsOf(archive)).toEqual(["nested"]);
  });

  it("says that it contains too much", async () => {
    const zip = await zipOf(named(slices));
    const found = await collect(filesIn(zip, "zip", new Budget(3)));
    expect(found.slice(3)).toEqual(["large"]);
    const zeros = await gzipOf(new Blob([new Uint8Array(1_000_000)]));
    expect(zeros.size).toBeLessThan(2000);
    expect(await collect(filesIn(zeros, "gzip", new Budget(10, 999_999)))).toEqual(["large"]);
    expect(await collect(filesIn(zeros, "gzip", new Budget(10, 1_000_000)))).toMatchObject([{ size: 1_000_000 }]);
  });

  it("says that a format or a compression is unknown", async () => {
    const rar = new Blob([Uint8Array.of(0x52, 0x61, 0x72, 0x21, 0x1a, 7, 1, 0), new Uint8Array(100)]);
    expect(await faultsOf(rar)).toEqual(["format"]);
    const bytes = await bytesOf(await zipOf(named(slices.slice(0, 1))));
    const directory = bytes.findIndex((_, i) => bytes[i] === 0x50 && bytes[i + 1] === 0x4b && bytes[i + 2] === 1);
    bytes[directory + 10] = 12; // bzip2
    expect(await faultsOf(new Blob([bytes]))).toEqual(["format"]);
  });
});

it("does not open programs and documents that happen to be ZIP archives", async () => {
  for (const name of ["META-INF/MANIFEST.MF", "[Content_Types].xml", "mimetype"]) {
    const archive = await zipOf([[name, new Blob(["x"])], ...named(slices)]);
    expect(archiveFormat(await bytesOf(archive))).toBeNull();
    expect(await scan([archive])).toMatchObject({ series: [], notDicom: 1, files: 1 });
  }
});

async function collect<T>(from: AsyncGenerator<T>): Promise<T[]> {
  const all: T[] = [];
  for await (const one of from) all.push(one);
  return all;
}
