import { expect, it } from "vitest";
import { readAtMost } from "./streams";

const packed = async (bytes: Uint8Array<ArrayBuffer>) =>
  new Uint8Array(
    await new Response(new Blob([bytes]).stream().pipeThrough(new CompressionStream("deflate-raw"))).arrayBuffer(),
  );
const unpacked = (bytes: Uint8Array<ArrayBuffer>, most: number) =>
  readAtMost(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")), most);

it("reads everything, or up to the limit, or what arrived before the stream broke", async () => {
  const bytes = Uint8Array.from({ length: 300_000 }, (_, i) => (i * 2_654_435_761) >>> 24);
  const small = await packed(bytes);
  expect(await unpacked(small, bytes.length)).toEqual({ bytes, end: "whole" });
  expect(await unpacked(small, 1000)).toEqual({ bytes: bytes.slice(0, 1000), end: "more" });
  const cut = await unpacked(small.slice(0, small.length >> 1), bytes.length);
  expect(cut.end).toBe("broken");
  expect(cut.bytes).toEqual(bytes.slice(0, cut.bytes.length));
  expect((await unpacked(Uint8Array.of(7, 7, 7), 10)).end).toBe("broken");
});
