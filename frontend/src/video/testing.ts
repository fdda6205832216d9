import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import { ClientMessageSchema, ConfigSchema, ServerMessageSchema, type ClientMessage, type ServerMessage } from "../protocol/gen/api/proto/stream_pb";
import type { Door, SocketEvents } from "../protocol/stream_client";
import { some_scene } from "../scene/testing";
import type { UnseenParts } from "./unseen";

export const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

/** A worker by hand, for a session that nobody sees. */
export abstract class WorkerByHand<State> {
  abstract readonly shot: { start(): void };
  states: State[] = [];
  sent: ClientMessage[] = [];
  socket: SocketEvents | null = null;
  open = true;
  door: Door = () => Promise.resolve({ ok: true, url: "/stream" });

  readonly parts: UnseenParts<State> = {
    door: (signal) => this.door(signal),
    open_socket: (_, events) => {
      this.socket = events;
      return { send: (data) => this.sent.push(fromBinary(ClientMessageSchema, data)), close: () => (this.open = false) };
    },
    after: (ms, task) => {
      if (ms === 0) queueMicrotask(task);
      return () => undefined;
    },
    state: (state) => this.states.push(state),
  };

  say(body: ServerMessage["body"]): void {
    this.socket?.message(toBinary(ServerMessageSchema, create(ServerMessageSchema, { body })));
  }
  config(): void {
    this.say({ case: "config", value: create(ConfigSchema, { scene: some_scene() }) });
  }
  async live(): Promise<void> {
    this.shot.start();
    await settled();
    this.socket?.opened();
    this.config();
    await settled();
  }
  get cases(): (string | undefined)[] {
    return this.sent.map(({ body }) => body.case);
  }
  get state(): State | undefined {
    return this.states.at(-1);
  }
}
