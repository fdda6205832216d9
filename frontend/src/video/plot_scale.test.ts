import { describe, expect, it } from "vitest";
import { plotOf, withPoint } from "./plot_scale";

describe("the plot of error against time", () => {
  it("is a straight line if the error falls with the square root of time", () => {
    const points = [1, 4, 16, 64].map((seconds) => ({
      samples: 8 * seconds,
      seconds,
      error: 0.5 / Math.sqrt(seconds),
    }));
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
        { samples: 2, seconds: 0.01, error: 0.9 },
        { samples: 6000, seconds: 30, error: 0.004 },
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
      { samples: 1, seconds: 2, error: 0.3 },
      { samples: 2, seconds: 1.5, error: 0.2 },
      { samples: 3, seconds: 0, error: 0.1 },
      { samples: 4, seconds: 4, error: Number.NaN },
      { samples: 5, seconds: 3, error: 0.1 },
    ];
    expect(told.reduce(withPoint, [])).toEqual([
      { samples: 1, seconds: 2, error: 0.3 },
      { samples: 2, seconds: 2, error: 0.2 },
      { samples: 5, seconds: 3, error: 0.1 },
    ]);
  });
  it("is empty for a single point or unknown errors", () => {
    expect(plotOf([{ samples: 1, seconds: 1, error: 0.1 }], 190, 74)).toBeNull();
    expect(
      plotOf(
        [
          { samples: 1, seconds: 1, error: Infinity },
          { samples: 2, seconds: 2, error: Number.NaN },
          { samples: 3, seconds: 0, error: 1 },
        ],
        190,
        74,
      ),
    ).toBeNull();
  });
  it("has a guide of slope -1/2 that ends where the curve does and stays inside the box", () => {
    const points = [
      { samples: 4, seconds: 0.1, error: 0.9 },
      { samples: 400, seconds: 10, error: 0.08 },
    ];
    const plot = plotOf(points, 200, 100);
    const [from, to] = plot?.guide.split(" ").map((pair) => pair.split(",").map(Number)) ?? [];
    expect(to).toEqual([200, 54.8]);
    expect(plot?.line.endsWith("200.0,54.8")).toBe(true);
    // A decade of time is 100 wide, a decade of error is 50 high: half a decade of error per decade of time.
    expect(((to?.[1] ?? 0) - (from?.[1] ?? 0)) / ((to?.[0] ?? 0) - (from?.[0] ?? 0))).toBeCloseTo(25 / 100, 2);
    expect(from?.[1]).toBeGreaterThanOrEqual(0);
    expect(plot?.vertical.map(({ seconds }) => seconds)).toEqual([0.1, 1, 10]);
    expect(plot?.samples).toEqual([
      { at: expect.closeTo(200 * 0.199, 0) as number, samples: 10 },
      { at: expect.closeTo(200 * 0.699, 0) as number, samples: 100 },
    ]);
  });
  it("keeps the first and the last point, and steps of five percent between them", () => {
    const all = Array.from({ length: 20_000 }, (_, i) => ({ samples: i + 1, seconds: i + 1, error: 1 / (i + 1) }));
    const curve = all.reduce(withPoint, []);
    expect(curve[0]?.samples).toBe(1);
    expect(curve.at(-1)?.samples).toBe(20_000);
    expect(curve.length).toBeLessThan(220);
    expect([...curve, ...curve].reduce(withPoint, [])).toEqual(curve);
  });
});
