import { describe, expect, it } from "vitest";
import { rgb } from "./colour";
import * as looks from "./labels";
import { someScene } from "./testing";

const labels = [
  { number: 3, colour: 0xff0000 },
  { number: 8, colour: 0x0000ff },
].map((label) => ({ ...label, name: "", volume: 1 })) as unknown as Parameters<typeof looks.setColoured>[1];

describe("the look of a label", () => {
  it("is left out of the scene while it changes nothing", () => {
    const scene = someScene();
    const hidden = looks.setShown(scene, 3, false);
    expect(hidden.labels).toMatchObject([{ number: 3, opacity: 0 }]);
    expect(looks.isShown(hidden, 3)).toBe(false);
    expect(looks.isShown(hidden, 8)).toBe(true);
    expect(looks.setShown(hidden, 3, true).labels).toEqual([]);
    expect(looks.setSolo(looks.setSolo(scene, 8, true), 8, false).labels).toEqual([]);
  });

  it("is limited to what the server accepts", () => {
    const scene = looks.setOpacity(someScene(), 3, 7);
    expect(looks.opacityOf(scene, 3)).toBe(1);
    expect(looks.opacityOf(looks.setOpacity(scene, 3, -1), 3)).toBe(0);
    expect(looks.opacityOf(looks.setOpacity(looks.setOpacity(scene, 3, 0.4), 3, Number.NaN), 3)).toBe(0.4);
  });

  it("shows at most one label alone", () => {
    const scene = looks.setSolo(looks.setSolo(someScene(), 3, true), 8, true);
    expect(looks.isSolo(scene, 3)).toBe(false);
    expect(looks.isSolo(scene, 8)).toBe(true);
  });

  it("gets the colour of its file, but keeps one that was chosen", () => {
    const chosen = looks.setColour(someScene(), 3, rgb(0, 1, 0));
    expect(looks.areColoured(someScene(), labels)).toBe(false);
    const coloured = looks.setColoured(chosen, labels, true);
    expect(coloured.labels.map(({ number, colour }) => [number, colour?.r, colour?.g, colour?.b])).toEqual([
      [3, 0, 1, 0],
      [8, 0, 0, 1],
    ]);
    const faint = looks.setOpacity(coloured, 8, 0.5);
    expect(looks.setColoured(faint, labels, false).labels).toMatchObject([{ number: 8, opacity: 0.5 }]);
    expect(looks.areColoured(looks.setColoured(faint, labels, false), labels)).toBe(false);
  });
});
