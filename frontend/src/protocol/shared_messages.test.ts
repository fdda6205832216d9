import { fromBinary } from "@bufbuild/protobuf";
import { expect, it } from "vitest";
import { vec3 } from "../input/vec3";
import { ClientMessageSchema } from "./gen/api/proto/stream_pb";
import { encodeSliceView, presentedOf } from "./shared_messages";

it("tells followers the presenter's window while the presenter shows no slices", () => {
  const window = { centre: 103, width: 205 };
  const shown = { view: null, crosshair: vec3(1, 2, 3), window, smooth: true, overlay: 0.5, placings: {} };
  const { body } = fromBinary(ClientMessageSchema, encodeSliceView(shown));
  if (body.case !== "sliceView") expect.unreachable();
  expect(presentedOf(body.value)).toMatchObject({ view: null, window, overlay: 0, crosshair: vec3(0, 0, 0) });
});
