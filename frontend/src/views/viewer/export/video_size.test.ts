import { expect, test } from "vitest";
import { someScene } from "../../../scene/testing";
import {
  renderingSeconds,
  shortestAroundS,
  videoOrder,
  videoSize,
  typedCycles,
  typedSeconds,
  usualCycles,
} from "./video_size";

test("a video has the aspect ratio of the screen and even sides within the limits", () => {
  expect(videoSize({ width: 1024, height: 768 }, 1280)).toEqual({ width: 1280, height: 960 });
  for (const screen of [
    { width: 391, height: 843 },
    { width: 1, height: 1 },
    { width: 100000, height: 3 },
    { width: 1279, height: 721 },
  ]) {
    const { width, height } = videoSize(screen, 1920);
    expect([width % 2, height % 2]).toEqual([0, 0]);
    expect(Math.min(width, height)).toBeGreaterThanOrEqual(16);
    expect(Math.max(width, height)).toBeLessThanOrEqual(1920);
  }
});

test("the time of a video follows from the speed of the picture on the screen", () => {
  const shown = { samples: 100, seconds: 20, error: 0.1, width: 1000, height: 500 };
  const half = { width: 500, height: 250 };
  const gpu = (...[picture, frames, size, error]: readonly [typeof shown, number, typeof half, number]) =>
    renderingSeconds(picture, frames, size, error, "NVIDIA H200");
  expect(gpu(shown, 1, shown, 0.1)).toEqual({ least: 20.05, most: 40.05 });
  expect(gpu(shown, 10, shown, 0.05)?.least).toBeCloseTo(10 * (4 * 20 + 0.05));
  expect(gpu(shown, 10, half, 0.05)?.least).toBeCloseTo(10 * (20 + 0.05));
  expect(gpu(shown, 100, shown, 10)?.least).toBeCloseTo(100 * (0.2 + 0.05)); // at least one sample
  expect(gpu({ ...shown, error: Infinity }, 1, shown, 0.1)).toBeNull();
  expect(gpu({ ...shown, samples: 3 }, 1, shown, 0.1)).toBeNull();
});

test("a video takes longer on a CPU, which also encodes it", () => {
  const shown = { samples: 100, seconds: 20, error: 0.1, width: 1000, height: 500 };
  expect(renderingSeconds(shown, 1, shown, 0.1, "2 CPU threads")).toEqual({ least: 20.5, most: 60.5 });
});

test("the length accepts only whole seconds within the limits", () => {
  expect(typedSeconds(" 8 ")).toBe(8);
  expect(typedSeconds("60")).toBe(60);
  for (const text of ["0", "61", "-1", "1.5", "", "1e1", "0x8", "999999"]) expect(typedSeconds(text), text).toBeNull();
  expect([typedSeconds("11", shortestAroundS), typedSeconds("12", shortestAroundS)]).toEqual([null, 12]);
});

test("the number of frames is the length times the frame rate", () => {
  const order = videoOrder({
    kind: "turntable",
    keys: [someScene()],
    size: { width: 640, height: 480 },
    seconds: 8,
    rate: 25,
    cycles: 3,
    error: 0.05,
    marks: { unit: 1, items: [] },
  });
  expect(order).toMatchObject({ kind: "turntable", frames: 200, framesPerSecond: 25, phaseCycles: 3 });
});

test("a video of the phases plays a heartbeat per second, for about four seconds", () => {
  expect(usualCycles(20, 20)).toEqual({ cycles: 4, seconds: 4 });
  expect(usualCycles(40, 10)).toEqual({ cycles: 1, seconds: 4 });
  expect(usualCycles(1000, 1)).toEqual({ cycles: 1, seconds: 60 });
});

test("the number of cycles is a whole number from the least to the number of frames", () => {
  expect(["0", "1", "50", "51", "1.5", "-1", ""].map((text) => typedCycles(text, 1, 50))).toEqual([
    null,
    1,
    50,
    null,
    null,
    null,
    null,
  ]);
  expect(typedCycles("0", 0, 50)).toBe(0);
});
