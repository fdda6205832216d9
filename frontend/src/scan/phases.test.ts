import { describe, expect, it } from "vitest";
import { judge } from "./judge";
import { thinned } from "./phases";
import { pieceOf } from "./piece";
import { HeaderReader } from "./read_file";
import { scanFiles } from "./scan";
import { makeSlice, type MadeSlice } from "./testing";
import type { SliceHeader } from "./types";
import { partBlobs } from "./upload_plan";

const slices = 20;

/** Slices of several phases in no order. `change` returns null for a missing slice. */
function phasesOf(count: number, change: (phase: number, z: number) => MadeSlice | null): Blob[] {
  const made = Array.from({ length: count * slices }, (_, i) => {
    const k = (i * 7919) % (count * slices);
    const [phase, z] = [Math.floor(k / slices), k % slices];
    const own = change(phase, z);
    return own && new Blob([makeSlice({ z: 2 * z, instance: (k * 31) % 997, ...own })]);
  });
  return made.flatMap((blob) => blob ?? []);
}

async function headers(blobs: readonly Blob[]): Promise<SliceHeader[]> {
  const reads = await Promise.all(blobs.map((blob, i) => new HeaderReader().read(pieceOf(blob), i)));
  return reads.flatMap((read) => (read.kind === "headers" ? read.headers : []));
}

const judged = async (blobs: readonly Blob[]) => judge(await headers(blobs));

/** The phases that the chosen slices belong to, in order, each checked to be complete and in the order of positions. */
async function orderOf(blobs: readonly Blob[], phaseOf: (slice: SliceHeader) => number): Promise<number[]> {
  const verdict = await judged(blobs);
  if (!verdict.suitable || !verdict.phases) throw new Error(JSON.stringify({ ...verdict, slices: undefined }));
  const each = verdict.slices.length / verdict.phases.count;
  return Array.from({ length: verdict.phases.count }, (_, p) => {
    const own = verdict.slices.slice(p * each, (p + 1) * each);
    expect(own.map(({ position }) => position?.[2])).toEqual([...own.keys()].map((z) => 2 * z));
    expect(new Set(own.map(phaseOf)).size).toBe(1);
    return own.map(phaseOf)[0] ?? -1;
  });
}

describe("a series with several phases", () => {
  it("is ordered by trigger times that vary from slice to slice", async () => {
    const blobs = phasesOf(10, (phase, z) => ({ triggerTime: 80 * phase + (z % 5) }));
    expect(await orderOf(blobs, ({ moment }) => Math.floor((moment[3] ?? 0) / 80))).toEqual([...Array(10).keys()]);
    expect(await judged(blobs)).toMatchObject({ phases: { kind: "time", count: 10, range: [0, 720] }, repairs: [] });
  });

  it("is ordered by echo times and b-values before anything else", async () => {
    const echoes = phasesOf(3, (phase) => ({ echoTime: 30 - 10 * phase, acquisitionTime: `10000${phase}` }));
    expect(await judged(echoes)).toMatchObject({ phases: { kind: "echo", count: 3, range: [10, 30] } });
    const diffusion = phasesOf(3, (phase) => ({ bValue: 500 * phase, echoTime: 80 }));
    expect(await judged(diffusion)).toMatchObject({ phases: { kind: "b_value", count: 3, range: [0, 1000] } });
  });

  it.each([
    ["Siemens", (b: number) => [0x0019, "SIEMENS MR HEADER", 0x100c, "IS", String(b)]],
    ["GE", (b: number) => [0x0043, "GEMS_PARM_01", 0x1039, "IS", `${1e9 + b}\\8\\0\\0`]],
    [
      "Philips",
      (b: number) => [0x2001, "Philips Imaging DD 001", 0x1003, "FL", new Uint8Array(Float32Array.of(b).buffer)],
    ],
  ] as const)("is split by the private b-values of %s, which are sent as the standard element", async (_, own) => {
    for (const syntax of ["1.2.840.10008.1.2.1", "1.2.840.10008.1.2"]) {
      const made = phasesOf(3, (phase) => ({ syntax, privately: own(500 * phase) as MadeSlice["privately"] & object }));
      expect(await judged(made)).toMatchObject({ phases: { kind: "b_value", count: 3, range: [0, 1000] } });
      const { series } = await scanFiles(
        made.map((blob, i) => new File([blob], String(i))),
        () => undefined,
        () => false,
      );
      const sent = await partBlobs(series[0]?.upload ?? expect.unreachable(), made);
      expect(await judged(sent), "without the private elements").toMatchObject({
        phases: { kind: "b_value", count: 3, range: [0, 1000] },
      });
      const last = new Uint8Array((await sent.at(-1)?.arrayBuffer()) ?? new ArrayBuffer());
      expect(new TextDecoder("latin1").decode(last)).not.toMatch(/SIEMENS|GEMS|Philips/);
    }
  });

  it("is not split by private elements of other creators", async () => {
    const made = phasesOf(2, (phase) => ({ privately: [0x0019, "SOMEBODY", 0x100c, "IS", String(500 * phase)] }));
    expect(await judged(made)).toMatchObject({ phases: { kind: "index" } });
  });

  it("leaves out a phase that is incomplete", async () => {
    const blobs = phasesOf(6, (phase, z) => (phase === 5 && z > 8 ? null : { acquisitionTime: `1000${10 + phase}` }));
    expect(await judged(blobs)).toMatchObject({
      size: [8, 8, slices],
      phases: { kind: "index", count: 5 },
      repairs: [{ kind: "incomplete_phases", phases: 1 }],
    });
  });

  it("keeps the positions that all phases have", async () => {
    const blobs = phasesOf(6, (phase, z) => (phase === 1 && z === 0 ? null : { acquisitionTime: `1000${10 + phase}` }));
    expect(await judged(blobs)).toMatchObject({
      size: [8, 8, slices - 1],
      phases: { count: 6 },
      repairs: [{ kind: "uncommon", slices: 5 }],
    });
  });

  it("is refused if most phases are incomplete", async () => {
    const blobs = phasesOf(6, (phase, z) =>
      phase > 1 && z === 3 + phase ? null : { acquisitionTime: `1000${10 + phase}` },
    );
    expect(await judged(blobs)).toMatchObject({ suitable: false, reason: "incomplete_phases" });
  });

  it("is sent in order, without the time of day that gives it", async () => {
    const files = phasesOf(3, (phase) => ({ acquisitionTime: `10${phase}000.5` }));
    const result = await scanFiles(
      files,
      () => undefined,
      () => false,
    );
    const series = result.series[0];
    expect(series).toMatchObject({ slices, verdict: { phases: { kind: "index", count: 3 } } });
    if (!series) return;
    const sent = await headers(await partBlobs(series.upload, files));
    expect(sent).toHaveLength(3 * slices);
    // TemporalPositionIdentifier numbers the phases.
    expect(sent.map(({ moment }) => moment[5])).toEqual([...sent.keys()].map((i) => 1 + Math.floor(i / slices)));
    expect(sent.every(({ moment }) => moment[7] === null)).toBe(true);
  });

  it("keeps every n-th phase if all of them are too many", () => {
    expect(thinned([0, 1, 2, 3, 4, 5, 6], 4)).toEqual([0, 2, 4, 6]);
    expect(thinned([0, 1, 2], 3)).toEqual([0, 1, 2]);
    expect(thinned([0, 1, 2], 1)).toEqual([0]);
  });
});
