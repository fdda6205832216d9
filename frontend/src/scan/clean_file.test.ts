import { describe, expect, it } from "vitest";
import { groupedElement } from "./clean_file";
import { pieceOf } from "./piece";
import { HeaderReader } from "./read_file";
import { scanFiles } from "./scan";
import { concat, makeSeries, makeSlice, type MadeSlice } from "./testing";
import { partBlobs } from "./upload_plan";

const pixels = Uint8Array.from({ length: 128 }, (_, i) => 255 - i);

async function cleaned(change: MadeSlice, tail = new Uint8Array()): Promise<Blob[]> {
  const files = makeSeries(20, 1.5, () => ({
    pixels,
    patientName: "Secret^Name",
    patientId: "Secret-1",
    ...change,
  })).map((blob) => new Blob([blob, tail]));
  const result = await scanFiles(
    files,
    () => undefined,
    () => false,
  );
  const series = result.series[0];
  if (!series?.verdict.suitable) throw new Error(JSON.stringify(series?.verdict));
  return partBlobs(series.upload, files);
}

describe("the uploaded part of a slice", () => {
  it.each<[string, MadeSlice]>([
    ["explicit", {}],
    ["implicit", { syntax: "1.2.840.10008.1.2" }],
    ["without preamble", { preamble: "none" }],
    ["without a meta header", { preamble: "nothing" }],
    ["with private elements", { paddingBytes: 5000 }],
  ])("is the same slice without its names: %s", async (_, change) => {
    const blobs = await cleaned(change, new TextEncoder().encode("Secret tail"));
    expect(blobs).toHaveLength(20);
    for (const [i, blob] of blobs.entries()) {
      const text = await blob.text();
      for (const word of ["Secret", "Head 1.5", "1.2.5", "1.2.3.", "HEAD", "PAD"]) expect(text).not.toContain(word);
      const read = await new HeaderReader().read(pieceOf(blob), i);
      const found = read.kind === "headers" ? read.headers[0] : undefined;
      if (!found) throw new Error(read.kind);
      expect(found).toMatchObject({
        sopClass: "1.2.840.10008.5.1.4.1.1.2",
        modality: "CT",
        rows: 8,
        columns: 8,
        position: [0, 0, i * 1.5],
        orientation: [1, 0, 0, 0, 1, 0],
        pixelSpacing: [0.5, 0.5],
        intercept: -1024,
        slope: 1,
        isSigned: true,
        bitsStored: 16,
        window: { center: 40, width: 400 },
        patient: { name: "", id: "", birthDate: "" },
        description: "",
        truncated: false,
      });
      const { offset, length } = found.pixels ?? { offset: 0, length: 0 };
      expect(new Uint8Array(await blob.slice(offset, offset + length).arrayBuffer())).toEqual(pixels);
    }
  });

  it("is judged like the original slices", async () => {
    const result = await scanFiles(
      await cleaned({}),
      () => undefined,
      () => false,
    );
    expect(result.series[0]?.verdict).toMatchObject({ suitable: true, size: [8, 8, 20] });
  });

  it("contains no unknown word of a coded field", async () => {
    const text = await (await cleaned({ imageType: "ORIGINAL\\PRIMARY\\AXIAL\\SECRETNAME" }))[0]?.text();
    expect(text).toContain("ORIGINAL\\PRIMARY\\AXIAL\\OTHER");
    expect(text).not.toContain("SECRETNAME");
  });

  it("ends with the last fragment of compressed voxels", async () => {
    const fragments = Uint8Array.from([
      0xfe, 0xff, 0x00, 0xe0, 0, 0, 0, 0, 0xfe, 0xff, 0x00, 0xe0, 4, 0, 0, 0, 1, 2, 3, 4, 0xfe, 0xff, 0xdd, 0xe0, 0, 0,
      0, 0,
    ]);
    const plain = makeSlice({ syntax: "1.2.840.10008.1.2.4.70", pixels: fragments, patientName: "Secret^Name" });
    plain.set([255, 255, 255, 255], plain.length - fragments.length - 4); // of undefined length
    const files = [new Blob([concat([plain, new TextEncoder().encode("Secret tail")])])];
    const read = await new HeaderReader().read(pieceOf(files[0] ?? new Blob()), 0);
    const found = read.kind === "headers" ? read.headers[0] : undefined;
    if (!found) throw new Error(read.kind);
    const { from, to } = found.voxels ?? { from: 0, to: 0 };
    expect(new Uint8Array(await (files[0] ?? new Blob()).slice(from, to).arrayBuffer())).toEqual(fragments);
    expect(found.truncated).toBe(false);
    const cut = new Blob([plain.slice(0, plain.length - 10)]);
    expect(await new HeaderReader().read(pieceOf(cut), 0)).toMatchObject({
      headers: [{ truncated: true, voxels: null }],
    });
  });

  it("replaces the names of stacks, and keeps different ones apart", () => {
    const sent = (name: string) => {
      const kept = groupedElement("x00209111", "x00209056", new TextEncoder().encode(name));
      return String.fromCharCode(...(kept?.bytes ?? []));
    };
    const names = Array.from({ length: 300 }, (_, i) => `Stack ${i}`);
    expect(new Set(names.map(sent)).size).toBe(names.length);
    for (const name of names) expect(sent(name)).toMatch(/^[0-9a-f]{8}$/);
    expect(sent("Secret ")).toBe(sent("Secret"));
  });
});
