import { expect, it } from "vitest";
import type { SocketEvents } from "./stream_client";
import { forVisit } from "./visit_socket";

it("ends a visit together with its session, and with nothing else", () => {
  const codes: number[] = [];
  let inner: SocketEvents | undefined;
  const open = forVisit((_, events) => {
    inner = events;
    return { send: () => undefined, close: () => undefined };
  });
  open("/stream", { opened: () => undefined, message: () => undefined, closed: (code) => codes.push(code) });
  for (const code of [4404, 4503, 1006, 4410, 4411]) inner?.closed(code);
  expect(codes).toEqual([4410, 4503, 1006, 4410, 4411]);
});
