import { describe, expect, it } from "vitest";
import { Shading_Mode, type Scene } from "../protocol/gen/api/proto/scene_pb";
import { camera_of } from "../protocol/messages";
import { rgb } from "./colour";
import * as cuts from "./cuts";
import * as lens from "./lens";
import * as lights from "./lights";
import { refused, some_bounds, some_scene } from "./testing";
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
const pose = camera_of(some_scene());

/** Every edit that a window can make, with any number. */
function edits(any: () => number, index: number, flag: boolean): ((scene: Scene) => Scene)[] {
  const axis = cuts.axes[index % 3] ?? "x";
  const slice = cuts.slice_names[index % 3] ?? "axial";
  const side = flag ? "low" : "high";
  return [
    (s) => transfer.move_point(s, index % 3, index, { value: any(), opacity: any() }),
    (s) => transfer.add_point(s, index % 3, any(), any())?.scene ?? s,
    (s) => transfer.remove_point(s, index % 3, index),
    (s) => transfer.add_channel(s, "new", { low: -1000, high: any() || 0 }),
    (s) => transfer.remove_channel(s, index),
    (s) => transfer.set_material(s, index % 3, { gloss: any(), name: "x".repeat(200), disabled: flag }),
    (s) => transfer.set_density(s, any()),
    (s) => ({ ...s, transferFunction: transfer.shifted(transfer.transfer_of(s), any()) }),
    (s) => lights.place_light(s, index, { right: any(), up: any(), distance: any() }),
    (s) => lights.size_light(s, index, any()),
    (s) => lights.colour_light(s, index, rgb(0, flag ? 0 : 1, 0)),
    (s) => lights.dim_light(s, index, any()),
    (s) => (pose ? lights.lock_light(s, index, flag, pose) : s),
    (s) => lights.add_light(s, flag ? "disk" : "rectangle", "new", any()),
    (s) => (s.lights.length > 3 ? lights.remove_light(s, index) : s),
    (s) => lens.set_fov(s, any()),
    (s) => lens.set_orthographic(s, flag),
    (s) => lens.set_aperture(s, any()),
    (s) => lens.set_focus(s, flag ? null : any()),
    (s) => lens.set_exposure(s, any()),
    (s) => lens.set_bounces(s, any()),
    (s) => lens.set_mode(s, flag ? Shading_Mode.HYBRID : Shading_Mode.SURFACE),
    (s) => lens.set_gradient(s, any()),
    (s) => lens.set_forward(s, any()),
    (s) => cuts.move_face(s, some_bounds, axis, side, any()),
    (s) => cuts.add_plane(s),
    (s) => cuts.move_plane(s, some_bounds, index, { right: any(), up: any(), offset: any() }),
    (s) => cuts.remove_plane(s, index),
    (s) => cuts.set_slice(s, some_bounds, grey, slice, { shown: flag, position: any() }),
    (s) => cuts.set_alone(s, grey, flag),
    (s) => cuts.set_colouring(s, grey, flag),
    (s) => cuts.set_window(s, grey, { centre: any(), width: any() }),
  ];
}

describe("edits", () => {
  it("the scene to begin with is one that the server takes", () => {
    expect(refused(some_scene())).toEqual([]);
  });

  it("no sequence of them makes a scene that the server refuses, whatever numbers come in", () => {
    const next = chance(20261122);
    const any = () => (next() < 0.4 ? (strange[Math.floor(next() * strange.length)] ?? 0) : (next() - 0.5) * 10 ** Math.floor(next() * 8 - 2));
    for (let run = 0; run < 40; run++) {
      let scene = some_scene();
      for (let i = 0; i < 150; i++) {
        const all = edits(any, Math.floor(next() * 6), next() < 0.5);
        const which = Math.floor(next() * all.length);
        scene = all[which]?.(scene) ?? scene;
        expect(refused(scene), `run ${run}, step ${i}, edit ${which}`).toEqual([]);
      }
    }
  });

  it("never touch the scene that they are given", () => {
    const next = chance(7);
    const scene = some_scene();
    const before = JSON.stringify(scene);
    for (let i = 0; i < 200; i++) for (const edit of edits(() => (next() - 0.5) * 500, Math.floor(next() * 5), next() < 0.5)) edit(scene);
    expect(JSON.stringify(scene)).toBe(before);
  });
});
