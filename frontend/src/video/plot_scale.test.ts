import { describe, expect, it } from "vitest";
import { plotOf, withPoint } from "./plot_scale";

describe("the plot of error against time", () => {
  it("is a straight line if the error falls with the square root of time", () => {
    const points = [1, 4, 16, 64].map((seconds) => ({ seconds, error: 0.5 / Math.sqrt(seconds) }));
    const way =
      plotOf(points, 190, 74)
        ?.line.split(" ")
        .map((pair) => pair.split(",").map(Number)) ?? [];
    const slopes = way.slice(1).map(([x = 0, y = 0], i) => (y - (way[i]?.[1] ?? 0)) / (x - (way[i]?.[0] ?? 0)));
    for (const slope of slopes) expect(slope).toBeCloseTo(slopes[0] ?? 0, 1);
    expect(slopes[0]).toBeGreaterThan(0); // downwards on the screen
  });
  it("stays inside its frame and labels whole decades", () => {
    const plot = plotOf(
      [
        { seconds: 0.01, error: 0.9 },
        { seconds: 30, error: 0.004 },
      ],
      190,
      74,
    );
    expect(plot?.horizontal.map(({ percent }) => percent)).toEqual([0.1, 1, 10, 100]);
    for (const { at } of plot?.horizontal ?? []) expect(at >= -1e-9 && at <= 74 + 1e-9).toBe(true);
    expect(plot?.vertical).toHaveLength(4);
  });
  it("does not go back in time for a picture that was tone-mapped faster than the previous one", () => {
    const told = [
      { seconds: 2, error: 0.3 },
      { seconds: 1.5, error: 0.2 },
      { seconds: 0, error: 0.1 },
      { seconds: 4, error: Number.NaN },
      { seconds: 3, error: 0.1 },
    ];
    expect(told.reduce(withPoint, [])).toEqual([
      { seconds: 2, error: 0.3 },
      { seconds: 2, error: 0.2 },
      { seconds: 3, error: 0.1 },
    ]);
  });
  it("is empty for a single point or unknown errors", () => {
    expect(plotOf([{ seconds: 1, error: 0.1 }], 190, 74)).toBeNull();
    expect(
      plotOf(
        [
          { seconds: 1, error: Infinity },
          { seconds: 2, error: Number.NaN },
          { seconds: 0, error: 1 },
        ],
        190,
        74,
      ),
    ).toBeNull();
  });
});
