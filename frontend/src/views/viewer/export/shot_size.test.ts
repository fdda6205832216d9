import { expect, test } from "vitest";
import { isHeldByPage, large, largest, poster, typedSize } from "./shot_size";

test("sizes have the aspect ratio of the screen and stay within the renderer's limits", () => {
  expect(large({ width: 1024, height: 768 })).toEqual({ width: 2048, height: 1536 });
  expect(largest({ width: 390, height: 844 })).toEqual({ width: 1893, height: 4096 });
  expect(largest({ width: 0, height: 0 })).toEqual({ width: 16, height: 16 });
  expect(largest({ width: 100000, height: 1 })).toEqual({ width: 4096, height: 16 });
});

test("the size fields accept only two whole numbers within the limits", () => {
  expect(typedSize("1920", " 1080 ")).toEqual({ width: 1920, height: 1080 });
  expect(typedSize("16", "4096")).toEqual({ width: 16, height: 4096 });
  expect(typedSize("16384", "4320")).toEqual({ width: 16384, height: 4320 });
  for (const [width, height] of [
    ["16385", "4320"],
    ["15", "100"],
    ["", "100"],
    ["1e3", "100"],
    ["12.5", "100"],
    ["-100", "100"],
    ["0x100", "100"],
    ["9".repeat(400), "100"],
  ] as const)
    expect(typedSize(width, height), width).toBeNull();
});

test("the page renders sizes up to the canvas limit, and a worker larger ones", () => {
  expect(isHeldByPage(largest({ width: 1024, height: 768 }))).toBe(true);
  expect(poster({ width: 1024, height: 768 })).toEqual({ width: 8192, height: 6144 });
  expect(isHeldByPage(poster({ width: 1024, height: 768 }))).toBe(false);
  expect(isHeldByPage({ width: 16, height: 4097 })).toBe(false);
});
