import { describe, expect, it } from "vitest";
import { Shading_Mode as ShadingMode, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { cameraOf } from "../protocol/messages";
import { rgb } from "./colour";
import * as cuts from "./cuts";
import * as lens from "./lens";
import * as lights from "./lights";
import { refused, someBounds, someScene } from "./testing";
import * as transfer from "./transfer";

// A fixed sequence, so that what fails once fails again.
function chance(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

const strange = [NaN, Infinity, -Infinity, 0, -0, 1e-30, 1e30, -1e30, -1, 1, 0.5, 90, -90, 180, 1024.5, 3072];
const grey = { centre: 40, width: 0 };
const pose = cameraOf(someScene());

/** Every edit that a window can make, with any number. */
function edits(any: () => number, index: number, flag: boolean): ((scene: Scene) => Scene)[] {
  const axis = cuts.axes[index % 3] ?? "x";
  const slice = cuts.sliceNames[index % 3] ?? "axial";
  const side = flag ? "low" : "high";
  return [
    (s) => transfer.movePoint(s, index % 3, index, { value: any(), opacity: any() }),
    (s) => transfer.addPoint(s, index % 3, any(), any())?.scene ?? s,
    (s) => transfer.removePoint(s, index % 3, index),
    (s) => transfer.addChannel(s, "new", { low: -1000, high: any() || 0 }),
    (s) => transfer.removeChannel(s, index),
    (s) => transfer.setMaterial(s, index % 3, { gloss: any(), name: "x".repeat(200), disabled: flag }),
    (s) => transfer.setDensity(s, any()),
    (s) => ({ ...s, transferFunction: transfer.shifted(transfer.transferOf(s), any()) }),
    (s) => lights.placeLight(s, index, { right: any(), up: any(), distance: any() }),
    (s) => lights.sizeLight(s, index, any()),
    (s) => lights.colourLight(s, index, rgb(0, flag ? 0 : 1, 0)),
    (s) => lights.dimLight(s, index, any()),
    (s) => (pose ? lights.lockLight(s, index, flag, pose) : s),
    (s) => lights.addLight(s, flag ? "disk" : "rectangle", "new", any()),
    (s) => (s.lights.length > 3 ? lights.removeLight(s, index) : s),
    (s) => lens.setFov(s, any()),
    (s) => lens.setOrthographic(s, flag),
    (s) => lens.setAperture(s, any()),
    (s) => lens.setFocus(s, flag ? null : any()),
    (s) => lens.setExposure(s, any()),
    (s) => lens.setExposureAutomatic(s, flag),
    (s) => lens.setFilmic(s, flag),
    (s) => lens.setBounces(s, any()),
    (s) => lens.setMode(s, flag ? ShadingMode.HYBRID : ShadingMode.SURFACE),
    (s) => lens.setGradient(s, any()),
    (s) => lens.setForward(s, any()),
    (s) => cuts.moveFace(s, someBounds, axis, side, any()),
    (s) => cuts.addPlane(s),
    (s) => cuts.movePlane(s, someBounds, index, { right: any(), up: any(), offset: any() }),
    (s) => cuts.removePlane(s, index),
    (s) => cuts.setSlice(s, someBounds, grey, slice, { shown: flag, position: any() }),
    (s) => cuts.setAlone(s, grey, flag),
    (s) => cuts.setColouring(s, grey, flag),
    (s) => cuts.setWindow(s, grey, { centre: any(), width: any() }),
  ];
}

describe("edits", () => {
  it("start from a scene that the server accepts", () => {
    expect(refused(someScene())).toEqual([]);
  });

  it("in any order and with any numbers give a scene that the server accepts", () => {
    const next = chance(20261122);
    const any = () =>
      next() < 0.4
        ? (strange[Math.floor(next() * strange.length)] ?? 0)
        : (next() - 0.5) * 10 ** Math.floor(next() * 8 - 2);
    for (let run = 0; run < 40; run++) {
      let scene = someScene();
      for (let i = 0; i < 150; i++) {
        const all = edits(any, Math.floor(next() * 6), next() < 0.5);
        const which = Math.floor(next() * all.length);
        scene = all[which]?.(scene) ?? scene;
        expect(refused(scene), `run ${run}, step ${i}, edit ${which}`).toEqual([]);
      }
    }
  });

  it("never modify the given scene", () => {
    const next = chance(7);
    const scene = someScene();
    const before = JSON.stringify(scene);
    for (let i = 0; i < 200; i++)
      for (const edit of edits(() => (next() - 0.5) * 500, Math.floor(next() * 5), next() < 0.5)) edit(scene);
    expect(JSON.stringify(scene)).toBe(before);
  });
});
