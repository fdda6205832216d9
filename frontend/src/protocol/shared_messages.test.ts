import { fromBinary } from "@bufbuild/protobuf";
import { expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { noSlab } from "../slices/oblique";
import { ClientMessageSchema } from "./gen/api/proto/stream_pb";
import { encodeSliceView, presentedOf } from "./shared_messages";

it("tells followers the tilt and the slab of the presenter's slices", () => {
  const axes = { right: vec3(0.6, 0.8, 0), down: vec3(-0.8, 0.6, 0) };
  const tilt = { axial: axes, sagittal: axes, coronal: axes };
  const slab = { mm: 12.5, projection: "minimum" } as const;
  const window = { centre: 103, width: 205 };
  const shown = {
    crosshair: vec3(1, 2, 3),
    window,
    smooth: true,
    overlay: 0.5,
    labels: 0.25,
    tilt,
    slab,
    placings: {},
  };
  for (const presented of [
    { ...shown, view: "four" as const },
    { ...shown, view: "axial" as const, tilt: null },
  ]) {
    const { body } = fromBinary(ClientMessageSchema, encodeSliceView(presented));
    if (body.case !== "sliceView") expect.unreachable();
    expect(presentedOf(body.value)).toEqual(presented);
  }
});

it("tells followers the presenter's window while the presenter shows no slices", () => {
  const window = { centre: 103, width: 205 };
  const shown = {
    view: null,
    crosshair: vec3(1, 2, 3),
    window,
    smooth: true,
    overlay: 0.5,
    labels: 0,
    tilt: null,
    slab: noSlab,
    placings: {},
  };
  const { body } = fromBinary(ClientMessageSchema, encodeSliceView(shown));
  if (body.case !== "sliceView") expect.unreachable();
  expect(presentedOf(body.value)).toMatchObject({ view: null, window, overlay: 0, crosshair: vec3(0, 0, 0) });
});
