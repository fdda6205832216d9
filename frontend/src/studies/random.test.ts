import { createHash } from "node:crypto";
import { describe, expect, it } from "vitest";
import type { Step } from "./definition";
import { moved, orderedSteps } from "./order";
import { randomNumbers, shuffled } from "./random";

const step = (id: string, group = ""): Step => ({ id, kind: "text", group, text: { en: id } });
const ids = (steps: readonly Step[]) => steps.map(({ id }) => id);

describe("the random numbers of a participant", () => {
  it("are the first 52 bits of the documented hashes", () => {
    const random = randomNumbers(123, "order/a/1");
    for (const count of [0, 1, 2]) {
      const hash = createHash("sha256").update(`123/order/a/1/${count}`).digest("hex");
      expect(random()).toBe(Number(BigInt(`0x${hash}`) >> 204n) / 2 ** 52);
    }
  });

  it("depend on the seed and on the purpose", () => {
    const first = randomNumbers(1, "a")();
    expect(randomNumbers(1, "a")()).toBe(first);
    expect(randomNumbers(2, "a")()).not.toBe(first);
    expect(randomNumbers(1, "b")()).not.toBe(first);
  });

  it("make every order of three items equally likely", () => {
    const rounds = 6000;
    const counts = new Map<string, number>();
    for (let seed = 0; seed < rounds; ++seed) {
      const order = shuffled(["a", "b", "c"], randomNumbers(seed, "x")).join("");
      counts.set(order, (counts.get(order) ?? 0) + 1);
    }
    const expected = rounds / 6;
    const chi = [...counts.values()].reduce((sum, n) => sum + (n - expected) ** 2 / expected, 0);
    expect(counts.size).toBe(6);
    expect(chi).toBeLessThan(20.52); // chi-squared with 5 degrees of freedom, significance 0.001
  });
});

describe("the order of the steps", () => {
  const groups = ["", "g", "g", "g", "", "", "g"];
  const steps = groups.map((group, i) => step(`step-${i}`, group));

  it("changes within a group only, and only among neighbours", () => {
    const orders = new Set<string>();
    for (let seed = 0; seed < 60; ++seed) {
      const order = ids(orderedSteps(steps, seed));
      expect([order[0], ...order.slice(1, 4).sort(), ...order.slice(4)]).toEqual(ids(steps));
      orders.add(order.join());
    }
    expect(orders.size).toBe(6); // a wrong result for all 60 seeds has a probability below 6 (5/6)^60 = 1e-4
  });

  it("is the same for the same participant", () => {
    expect(orderedSteps(steps, 42)).toEqual(orderedSteps(steps, 42));
  });
});

describe("moving an item", () => {
  it("keeps the others in order and the item in the list", () => {
    expect(moved(["a", "b", "c"], 0, 2)).toEqual(["b", "c", "a"]);
    expect(moved(["a", "b", "c"], 2, 0)).toEqual(["c", "a", "b"]);
    expect(moved(["a", "b", "c"], 1, -5)).toEqual(["b", "a", "c"]);
    expect(moved(["a", "b", "c"], 1, 9)).toEqual(["a", "c", "b"]);
    expect(moved(["a"], 4, 0)).toEqual(["a"]);
  });
});
